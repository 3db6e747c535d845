//! Other programs' trees as scripts of ours: text to text, with a note for every parameter.

pub mod weber_penn;

/// How well a parameter came across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Means the same here.
    Used,
    /// Something near it stands here.
    Approximated,
    /// Has no counterpart, or no effect on this tree.
    Ignored,
    /// Needs the reader's attention: not known, or not in the file.
    Warning,
}

impl Mark {
    /// The sign that stands before a note.
    #[must_use]
    pub fn sign(self) -> char {
        match self {
            Self::Used => '=',
            Self::Approximated => '~',
            Self::Ignored => '-',
            Self::Warning => '!',
        }
    }
}

/// What became of one or more parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// How well they came across.
    pub mark: Mark,
    /// The parameters with their values, such as `Scale 13, ScaleV 3`.
    pub parameters: String,
    /// What became of them.
    pub text: String,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}: {}", self.mark.sign(), self.parameters, self.text)
    }
}

/// A script that was made of another program's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The script, which has the notes as comments.
    pub script: String,
    /// What became of each parameter.
    pub notes: Vec<Note>,
}

/// A fault of the other program's file, with its place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {message}")]
pub struct ImportFault {
    /// From 1.
    pub line: u32,
    /// From 1.
    pub column: u32,
    /// What is wrong and what was expected.
    pub message: String,
}
