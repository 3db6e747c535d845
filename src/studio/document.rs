//! The document: a script's text, and what it says. The text is the truth; every panel reads from it and writes
//! to it, so that none can disagree with another.

use super::history::History;
use super::recovery::Note;
use crate::disk;
use crate::species::edit::{self, EditError};
use crate::species::schema::Species;
use crate::species::syntax::{self, Node};
use crate::species::{self, Beside, Faults};
use std::io;
use std::path::{Path, PathBuf};

/// A script that is being worked on.
#[derive(Debug)]
pub struct Document {
    history: History,
    /// Its file; none while it was never saved.
    path: Option<PathBuf>,
    /// What the file held when it was read or written last.
    saved: Option<String>,
    reading: Reading,
}

/// What a text says.
#[derive(Debug)]
pub struct Reading {
    /// Its values; none where brackets do not match.
    pub root: Option<Node>,
    /// The species, or what is at fault.
    pub species: Result<Box<Species>, Faults>,
}

/// One thing that is done to a script. Paths are those of [`edit::set`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Edit {
    /// Sets a field.
    Set {
        /// The field.
        path: String,
        /// Its new value, RON text.
        value: String,
    },
    /// Takes a field or an item out.
    Remove(String),
    /// Puts an item into a list.
    Insert {
        /// The list.
        list: String,
        /// Its number.
        index: usize,
        /// RON text.
        item: String,
    },
    /// Moves an item of a list.
    Reorder {
        /// The item.
        path: String,
        /// Its number afterwards.
        to: usize,
    },
    /// Copies an item of a list behind itself, its `name` changed.
    Duplicate {
        /// The item.
        path: String,
        /// The name of the copy.
        name: String,
    },
    /// Replaces the whole text.
    Text(String),
}

/// What came of a look at the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Nobody else has changed it.
    Same,
    /// It was taken over; nothing was unsaved.
    Taken,
    /// Both were changed, in different places: the text holds both.
    Merged,
    /// Both were changed at the same place: the user must choose. This is the file's text.
    Conflict(String),
}

impl Document {
    /// A new document with a text to begin with.
    #[must_use]
    pub fn new(text: String) -> Self {
        Self::of(text, None, None)
    }

    /// Reads a script.
    ///
    /// # Errors
    /// If it cannot be read or is not text. Faults inside it are no error: they are to be mended here.
    pub fn open(path: &Path) -> io::Result<Self> {
        let text = std::fs::read_to_string(path)?;
        let path = std::path::absolute(path)?;
        Ok(Self::of(text.clone(), Some(path), Some(text)))
    }

    /// A document that a killed window has left, with all that was unsaved in it as one step.
    #[must_use]
    pub fn recovered(note: Note) -> Self {
        let Note { path, saved, text } = note;
        let mut document = Self::of(saved.clone().unwrap_or_default(), path, saved);
        document.take("Recover", None, text);
        document
    }

    fn of(text: String, path: Option<PathBuf>, saved: Option<String>) -> Self {
        let reading = Reading::of(&text, path.as_deref());
        Self {
            history: History::new(text),
            path,
            saved,
            reading,
        }
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        self.history.text()
    }

    /// What it says.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Its file.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The folder that its files are looked for in.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        folder(self.path.as_deref())
    }

    /// True if there is something to lose.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        self.saved.as_deref() != Some(self.text())
    }

    /// What a journal is to keep.
    #[must_use]
    pub fn note(&self) -> Option<Note> {
        self.is_unsaved().then(|| Note {
            path: self.path.clone(),
            saved: self.saved.clone(),
            text: self.text().to_owned(),
        })
    }

    /// Does something, as one step with a name; steps that follow one another in one `gesture` are one.
    ///
    /// # Errors
    /// If it cannot be done; the text stays as it is.
    pub fn apply(
        &mut self,
        name: &str,
        gesture: Option<&str>,
        edit: Edit,
    ) -> Result<(), EditError> {
        let text = match edit {
            Edit::Set { path, value } => edit::set(self.text(), &path, &value)?,
            Edit::Remove(path) => edit::remove(self.text(), &path)?,
            Edit::Insert { list, index, item } => edit::insert(self.text(), &list, index, &item)?,
            Edit::Reorder { path, to } => edit::reorder(self.text(), &path, to)?,
            Edit::Duplicate { path, name } => {
                let copied = edit::duplicate(self.text(), &path, |item| {
                    let quoted = format!("{name:?}");
                    edit::set(item, "name", &quoted).unwrap_or_else(|_| item.to_owned())
                });
                copied?
            }
            Edit::Text(text) => text,
        };
        self.take(name, gesture, text);
        Ok(())
    }

    fn take(&mut self, name: &str, gesture: Option<&str>, text: String) {
        self.history.take(name, gesture, text);
        self.read();
    }

    fn read(&mut self) {
        self.reading = Reading::of(self.history.text(), self.path.as_deref());
    }

    /// Reads what the text says once more: a file that it names may be another one.
    pub fn reread(&mut self) {
        self.read();
    }

    /// Undo, redo and their names.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Ends a gesture, as [`History::rest`].
    pub fn rest(&mut self) {
        self.history.rest();
    }

    /// Goes back by one step.
    pub fn undo(&mut self) -> bool {
        let done = self.history.undo();
        self.read();
        done
    }

    /// Goes forth by one step.
    pub fn redo(&mut self) -> bool {
        let done = self.history.redo();
        self.read();
        done
    }

    /// Writes the text to its file, or to another one, which is its file from then on. The file is whole at any
    /// time: the text is written beside it and renamed.
    ///
    /// # Errors
    /// If it cannot be written, or if there is no file yet; nothing is lost.
    pub fn save(&mut self, to: Option<&Path>) -> io::Result<()> {
        let Some(path) = to.or(self.path.as_deref()) else {
            let kind = io::ErrorKind::InvalidInput;
            return Err(io::Error::new(kind, "the script has no file yet"));
        };
        let path = std::path::absolute(path)?;
        disk::write_whole(&path, self.text().as_bytes())?;
        self.saved = Some(self.text().to_owned());
        self.path = Some(path);
        self.rest();
        self.read();
        Ok(())
    }

    /// Looks at the file again, and takes in what somebody else has written to it.
    ///
    /// # Errors
    /// If it cannot be read any more; the text stays.
    pub fn look(&mut self) -> io::Result<Outside> {
        let Some(path) = &self.path else {
            return Ok(Outside::Same);
        };
        let theirs = std::fs::read_to_string(path)?;
        let base = self.saved.clone().unwrap_or_default();
        if theirs == base {
            return Ok(Outside::Same);
        }
        if theirs == self.text() {
            self.saved = Some(theirs);
            return Ok(Outside::Same);
        }
        let outcome = if self.is_unsaved() {
            match diffy::merge(&base, self.text(), &theirs) {
                Ok(merged) => {
                    self.take("Merge the file's changes", None, merged);
                    Outside::Merged
                }
                Err(_) => return Ok(Outside::Conflict(theirs)),
            }
        } else {
            self.take("Read the file again", None, theirs.clone());
            Outside::Taken
        };
        self.saved = Some(theirs);
        Ok(outcome)
    }

    /// Settles a conflict: the file's text is taken over as a step that can be undone, or ours is kept and will
    /// replace it at the next save.
    pub fn settle(&mut self, theirs: String, take: bool) {
        if take {
            self.take("Take the file's text", None, theirs.clone());
        }
        self.saved = Some(theirs);
    }
}

impl Reading {
    fn of(text: &str, path: Option<&Path>) -> Self {
        let name = path.map_or_else(|| "script".to_owned(), |p| p.display().to_string());
        let files = Beside(folder(path));
        Self {
            root: syntax::parse(text).0,
            species: species::parse(&name, text, &files).map(Box::new),
        }
    }
}

fn folder(path: Option<&Path>) -> PathBuf {
    path.and_then(Path::parent)
        .unwrap_or(Path::new(""))
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::outline;
    use crate::studio::templates::BLANK;
    use proptest::prelude::*;
    use std::fs;

    fn set(path: &str, value: &str) -> Edit {
        Edit::Set {
            path: path.to_owned(),
            value: value.to_owned(),
        }
    }

    #[test]
    fn a_saved_document_has_nothing_to_lose_and_what_fails_changes_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut document = Document::new(BLANK.to_owned());
        assert!(document.save(None).is_err(), "it has no file");
        document
            .apply("Set links", None, set("levels.limbs.links", "4"))
            .unwrap();
        let text = document.text().to_owned();
        assert!(
            document
                .apply("?", None, set("levels.limbs.links", "("))
                .is_err()
        );
        assert!(
            document
                .apply("?", None, set("levels.roots.links", "4"))
                .is_err()
        );
        assert!(
            document
                .save(Some(&dir.path().join("no/such.ron")))
                .is_err()
        );
        assert_eq!(
            (document.text(), document.path(), document.is_unsaved()),
            (&*text, None, true)
        );
        let path = dir.path().join("a.ron");
        document.save(Some(&path)).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        assert_eq!((document.is_unsaved(), document.note()), (false, None));
        document.undo();
        assert!(document.is_unsaved());
        let again = Document::recovered(document.note().unwrap());
        assert_eq!((again.text(), again.path()), (BLANK, Some(&*path)));
    }

    #[test]
    fn a_fault_is_read_and_can_be_edited_away() {
        let mut document = Document::new(BLANK.replace("links: 18", "links: -1"));
        assert!(document.reading().species.is_err());
        document
            .apply("Set links", None, set("levels.limbs.links", "18"))
            .unwrap();
        assert!(document.reading().species.is_ok());
        document
            .apply("Type", None, Edit::Text("(".to_owned()))
            .unwrap();
        assert!(document.reading().root.is_none() && document.reading().species.is_err());
        assert!(document.undo());
        assert_eq!(document.text(), BLANK);
    }

    #[test]
    fn copies_have_names_of_their_own() {
        let mut document = Document::new(BLANK.to_owned());
        let path = "levels.1".to_owned();
        let name = "more \"limbs\"".to_owned();
        document
            .apply("Copy", None, Edit::Duplicate { path, name })
            .unwrap();
        let reading = document.reading();
        let root = reading.root.as_ref().unwrap();
        let names: Vec<_> = outline::items(outline::field(root, "levels").unwrap())
            .iter()
            .map(|item| outline::name(item).unwrap())
            .collect();
        assert_eq!(names, ["trunk", "limbs", "more \"limbs\"", "leaves"]);
        assert!(reading.species.is_ok());
    }

    /// Something to do, made of a few numbers.
    fn edit(document: &Document, what: u8, which: usize, value: u16) -> Option<Edit> {
        let root = document.reading().root.as_ref()?;
        let pages = outline::pages(root);
        let page = &pages[which % pages.len()];
        let value = value.to_string();
        Some(match what {
            0 => set("seed", &value),
            1 => set(&format!("{}.links", page.path), &value),
            2 => Edit::Remove(page.path.clone()),
            3 => Edit::Reorder {
                path: page.path.clone(),
                to: value.len(),
            },
            4 => Edit::Duplicate {
                path: page.path.clone(),
                name: format!("copy {value}"),
            },
            5 => Edit::Text(document.text().replacen("links", "// é \n links", 1)),
            _ => Edit::Text(format!("{}{value}", document.text())),
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

        #[test]
        fn a_long_sequence_of_edits_ends_with_text_and_reading_in_agreement(
            steps in prop::collection::vec((0_u8..10, any::<u8>(), 0_u16..40), 1..60),
        ) {
            let mut document = Document::new(BLANK.to_owned());
            for (what, which, value) in steps {
                match what {
                    7 => { document.undo(); }
                    8 => { document.redo(); }
                    9 => document.rest(),
                    _ => if let Some(edit) = edit(&document, what, usize::from(which), value) {
                        let gesture = (value % 2 == 0).then_some("drag");
                        let _ = document.apply("Step", gesture, edit);
                    },
                }
                // What it says is what its text says, read anew.
                let reading = Reading::of(document.text(), None);
                prop_assert_eq!(&reading.root, &document.reading().root);
                prop_assert_eq!(reading.species.is_ok(), document.reading().species.is_ok());
            }
            while document.undo() {}
            prop_assert_eq!(document.text(), BLANK);
        }
    }
}
