//! Splines whose points are in files of their own: why they have no handles, and the way into the script.
//!
//! A file may be that of other scripts, too, and undo is of the script's text. So points are not changed in the file:
//! they are brought into the script first, which draws the same tree.

use super::document::Edit;
use super::form::Change;
use super::outline;
use crate::species::edit::{self, EditError};
use crate::species::schema::{Knots, Species, Spline};
use crate::species::syntax::Node;
use eframe::egui::Ui;

/// A spline with its points in a file.
pub(super) struct Outside<'a> {
    /// Path of its struct in the script.
    path: &'a str,
    file: &'a str,
    spline: &'a Spline,
}

impl<'a> Outside<'a> {
    /// That of a spline's struct, if it is one.
    pub(super) fn of(path: &'a str, node: &'a Node, species: &'a Species) -> Option<Self> {
        Some(Self {
            path,
            file: outline::text(outline::field(node, "file")?)?,
            spline: species.splines.get(outline::number(path)?)?,
        })
    }

    /// Says where the points are, and offers to bring them; gives the change if that is wanted.
    pub(super) fn ui(&self, ui: &mut Ui, text: &str) -> Option<Change> {
        ui.label(format!(
            "The points of {} are in the file {}, and so they have no handles.",
            self.spline.name, self.file
        ));
        let button = ui.button("Bring them into the script");
        let button = button.on_hover_text("The tree stays the same; the file is left as it is.");
        button.clicked().then(|| self.change(text)).flatten()
    }

    fn change(&self, text: &str) -> Option<Change> {
        let text = self.brought(text).ok()?;
        let name = format!("Bring {} into the script", self.file);
        Some(Change::Edit(name, None, Edit::Text(text)))
    }

    /// The script with the points in it.
    fn brought(&self, text: &str) -> Result<String, EditError> {
        let point = |[x, y, z]: &[f32; 3]| format!("({x}, {y}, {z})");
        let points: Vec<String> = self.spline.points.iter().map(point).collect();
        let field = |name: &str| format!("{}.{name}", self.path);
        let points = format!("[{}]", points.join(", "));
        let mut text = edit::set(text, &field("points"), &points)?;
        if self.spline.knots != Knots::default() {
            let knots = format!("{:?}", self.spline.knots);
            text = edit::set(&text, &field("knots"), &knots)?;
        }
        edit::remove(&text, &field("file"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, Beside, NoFiles, syntax};
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits, grow};

    #[test]
    fn a_spline_that_is_brought_into_the_script_makes_the_same_tree() {
        let dir = tempfile::tempdir().unwrap();
        let file = "# A limb.\nknots chordal\n0 0 0\n0.125 1.3 0.1\n-0.0625 2 0.4\n";
        std::fs::write(dir.path().join("limb.spline"), file).unwrap();
        let points = "points: [(0, 0, 0), (0.1, 1, 0.1), (0, 2, 0.4)]";
        let script = BLANK.replace(points, "file: \"limb.spline\" /* ours */");
        assert_ne!(script, BLANK);
        let files = Beside(dir.path().to_owned());
        let before = species::parse("a", &script, &files).unwrap();
        let root = syntax::parse(&script).0.unwrap();
        let node = outline::at(&root, "splines.1").unwrap();
        let outside = Outside::of("splines.1", node, &before).unwrap();
        let text = outside.brought(&script).unwrap();
        assert!(
            text.contains("(0.125, 1.3, 0.1)") && !text.contains("limb.spline"),
            "{text}"
        );
        let after = species::parse("a", &text, &NoFiles).unwrap();
        assert_eq!(after.splines, before.splines);
        let tree = |species| grow(species, 1, &Limits::default()).unwrap();
        assert!(tree(&after) == tree(&before));
        // The others have none.
        let node = outline::at(&root, "splines.0").unwrap();
        assert!(Outside::of("splines.0", node, &before).is_none());
    }
}
