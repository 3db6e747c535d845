//! Faults of a script: what is wrong, where, what was expected, and what may have been meant.

use std::fmt::{self, Write as _};
use std::ops::Range;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

/// Faults drawn in full by [`Faults::render`]; a file with more is told how many are left.
const RENDERED: usize = 50;

/// Faults kept of one file: more are of no use to anyone, and a hostile file could have millions.
pub(super) const MOST: usize = 1000;

/// Most characters of a message or a path: both may quote the script.
const LONGEST: usize = 1200;

/// One thing that is wrong with a script, or with a file that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Index of the text it is in: 0 is the script, others are the files it names.
    pub source: usize,
    /// Bytes of that text which are at fault.
    pub span: Range<usize>,
    /// The field, such as `levels[1].down.vary`; empty where there is none.
    pub path: String,
    /// What was found and what was expected.
    pub message: String,
    /// What to do about it, where that can be guessed.
    pub help: Option<String>,
    /// A second place in the same text that belongs to it, and why.
    pub also: Option<(Range<usize>, String)>,
}

impl Fault {
    /// A fault at some bytes of the script itself.
    #[must_use]
    pub fn new(span: Range<usize>, path: &str, message: impl Into<String>) -> Self {
        Self {
            source: 0,
            span,
            path: visible(path),
            message: visible(&message.into()),
            help: None,
            also: None,
        }
    }

    /// The same with a word of advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(visible(&help.into()));
        self
    }

    /// The same with a second place.
    #[must_use]
    pub fn also(mut self, span: Range<usize>, label: impl Into<String>) -> Self {
        self.also = Some((span, visible(&label.into())));
        self
    }
}

/// Messages quote the script: keep its control characters away from the terminal, and its longest
/// words within bounds.
fn visible(text: &str) -> String {
    let mut out = String::new();
    for (index, c) in text.chars().enumerate() {
        if index >= LONGEST {
            out.push_str("...");
            break;
        }
        if c.is_control() {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

/// A text that faults point into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// File name as the user knows it.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// Byte offset of each line's start.
    lines: Vec<usize>,
}

impl Source {
    /// A named text.
    #[must_use]
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let lines = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(at, _)| at + 1))
            .collect();
        Self {
            name: name.into(),
            text,
            lines,
        }
    }

    /// Line and column of a byte, both from 1. A column is a character, a tab being one.
    #[must_use]
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let line = self.lines.partition_point(|&start| start <= offset).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        let before = self.text.get(start..offset).unwrap_or("");
        (line, before.chars().count() + 1)
    }
}

/// All faults of a script, in the order of their places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faults {
    sources: Vec<Source>,
    faults: Vec<Fault>,
}

impl Faults {
    /// Sorts faults by text and place.
    #[must_use]
    pub fn new(sources: Vec<Source>, mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|fault| (fault.source, fault.span.start, fault.span.end));
        Self { sources, faults }
    }

    /// The faults in order.
    #[must_use]
    pub fn list(&self) -> &[Fault] {
        &self.faults
    }

    /// The texts that [`Fault::source`] counts.
    #[must_use]
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// File name, line and column (from 1) at which a fault begins.
    #[must_use]
    pub fn place(&self, fault: &Fault) -> (&str, usize, usize) {
        self.sources.get(fault.source).map_or(("", 1, 1), |source| {
            let (line, column) = source.line_column(fault.span.start);
            (source.name.as_str(), line, column)
        })
    }

    /// A report for people, with the lines at fault; with terminal colours if `color`.
    #[must_use]
    pub fn render(&self, color: bool) -> String {
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let renderer = renderer.decor_style(DecorStyle::Ascii);
        let mut out = String::new();
        for fault in self.faults.iter().take(RENDERED) {
            out.push_str(&self.render_one(fault, &renderer));
            out.push_str("\n\n");
        }
        let name = self.sources.first().map_or("", |s| s.name.as_str());
        // Writing to a string cannot fail.
        let _ = match self.faults.len() {
            1 => writeln!(out, "{name}: 1 fault"),
            n if n > RENDERED => writeln!(out, "{name}: {n} faults, the first {RENDERED} shown"),
            n => writeln!(out, "{name}: {n} faults"),
        };
        out
    }

    fn render_one(&self, fault: &Fault, renderer: &Renderer) -> String {
        let title = if fault.path.is_empty() {
            fault.message.clone()
        } else {
            format!("{}: {}", fault.path, fault.message)
        };
        let mut group = Level::ERROR
            .primary_title(title)
            .elements(Vec::<Snippet<'_, annotate_snippets::Annotation<'_>>>::new());
        if let Some(source) = self.sources.get(fault.source) {
            let mut snippet = Snippet::source(source.text.as_str())
                .path(source.name.as_str())
                .annotation(AnnotationKind::Primary.span(fault.span.clone()));
            if let Some((span, label)) = &fault.also {
                snippet = snippet.annotation(
                    AnnotationKind::Context
                        .span(span.clone())
                        .label(label.as_str()),
                );
            }
            group = group.element(snippet);
        }
        if let Some(help) = &fault.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        renderer.render(&[group])
    }
}

impl fmt::Display for Faults {
    /// One block a fault: `file:line:column: path: message`, then indented advice.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.faults.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            let (name, line, column) = self.place(fault);
            write!(f, "{name}:{line}:{column}: ")?;
            if !fault.path.is_empty() {
                write!(f, "{}: ", fault.path)?;
            }
            write!(f, "{}", fault.message)?;
            if let (Some((span, label)), Some(source)) =
                (&fault.also, self.sources.get(fault.source))
            {
                let (line, column) = source.line_column(span.start);
                write!(f, "\n    {line}:{column}: {label}")?;
            }
            if let Some(help) = &fault.help {
                write!(f, "\n    help: {help}")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_tabs_once() {
        let source = Source::new("x", "a\n\tÖl: 1\n");
        assert_eq!(source.line_column(0), (1, 1));
        assert_eq!(source.line_column(2), (2, 1));
        assert_eq!(source.line_column("a\n\tÖl".len()), (2, 4));
        assert_eq!(source.line_column(source.text.len()), (3, 1));
    }

    #[test]
    fn control_characters_of_a_script_never_reach_the_terminal() {
        let fault = Fault::new(0..1, "", "unknown field `\u{1b}[31m`");
        assert_eq!(fault.message, "unknown field `\\u{1b}[31m`");
    }

    #[test]
    fn every_span_of_a_text_can_be_rendered() {
        let text = "Ä(\r\n\t\"\u{1F333}\",\n\n)";
        let edges: Vec<usize> = (0..=text.len())
            .filter(|&i| text.is_char_boundary(i))
            .collect();
        for &start in &edges {
            for &end in edges.iter().filter(|&&end| end >= start) {
                let fault = Fault::new(start..end, "a.b", "wrong").help("right");
                let faults = Faults::new(vec![Source::new("x.ron", text)], vec![fault]);
                assert!(faults.render(true).contains("wrong"));
            }
        }
    }
}
