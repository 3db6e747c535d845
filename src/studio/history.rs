//! Undo and redo of everything, with names.

/// Steps that are remembered; those before them are forgotten.
const MOST: usize = 2000;

/// Texts of a document, one for each thing that was done to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct History {
    first: String,
    steps: Vec<Step>,
    /// Steps that are done; those behind it were undone.
    done: usize,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Step {
    name: String,
    gesture: Option<String>,
    text: String,
}

impl History {
    /// A document to which nothing was done.
    #[must_use]
    pub fn new(text: String) -> Self {
        Self {
            first: text,
            steps: Vec::new(),
            done: 0,
        }
    }

    /// The text as it is.
    #[must_use]
    pub fn text(&self) -> &str {
        self.done
            .checked_sub(1)
            .map_or(&self.first, |last| &self.steps[last].text)
    }

    /// Takes in a new text. What was undone is forgotten. Texts that follow one another in one `gesture`, a
    /// slider that is dragged or a word that is typed, are one step.
    pub fn take(&mut self, name: &str, gesture: Option<&str>, text: String) {
        if text == self.text() {
            return;
        }
        self.steps.truncate(self.done);
        let goes_on = |last: &&mut Step| gesture.is_some() && last.gesture.as_deref() == gesture;
        if let Some(last) = self.steps.last_mut().filter(goes_on) {
            name.clone_into(&mut last.name);
            last.text = text;
            return;
        }
        self.steps.push(Step {
            name: name.to_owned(),
            gesture: gesture.map(str::to_owned),
            text,
        });
        if self.steps.len() > MOST {
            self.first = self.steps.remove(0).text;
        }
        self.done = self.steps.len();
    }

    /// Ends the gesture that goes on: what comes next is a step of its own.
    pub fn rest(&mut self) {
        if let Some(last) = self.done.checked_sub(1) {
            self.steps[last].gesture = None;
        }
    }

    /// What [`History::undo`] would undo.
    #[must_use]
    pub fn undoable(&self) -> Option<&str> {
        self.done.checked_sub(1).map(|last| &*self.steps[last].name)
    }

    /// What [`History::redo`] would do again.
    #[must_use]
    pub fn redoable(&self) -> Option<&str> {
        self.steps.get(self.done).map(|next| &*next.name)
    }

    /// Goes back by one step; false if there is none.
    pub fn undo(&mut self) -> bool {
        self.rest();
        let possible = self.done > 0;
        self.done -= usize::from(possible);
        possible
    }

    /// Goes forth by one step; false if there is none.
    pub fn redo(&mut self) -> bool {
        let possible = self.done < self.steps.len();
        self.done += usize::from(possible);
        self.rest();
        possible
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn history() -> History {
        History::new("a".to_owned())
    }

    #[test]
    fn steps_are_undone_and_done_again_by_name() {
        let mut history = history();
        history.take("Set length", None, "b".to_owned());
        history.take("Set radius", None, "c".to_owned());
        assert_eq!(history.undoable(), Some("Set radius"));
        assert!(history.undo() && history.undo() && !history.undo());
        assert_eq!(
            (history.text(), history.redoable()),
            ("a", Some("Set length"))
        );
        assert!(history.redo() && history.redo() && !history.redo());
        assert_eq!((history.text(), history.redoable()), ("c", None));
        history.undo();
        history.take("Set sides", None, "d".to_owned());
        assert_eq!(
            (history.undoable(), history.redoable()),
            (Some("Set sides"), None)
        );
    }

    #[test]
    fn a_gesture_is_one_step_until_it_rests() {
        let mut history = history();
        for text in ["b", "c", "d"] {
            history.take("Set length", Some("length"), text.to_owned());
        }
        history.rest();
        history.take("Set length", Some("length"), "e".to_owned());
        assert!(history.undo());
        assert_eq!(history.text(), "d");
        assert!(history.undo() && !history.undo());
        // An undone gesture does not go on.
        history.redo();
        history.take("Set length", Some("length"), "f".to_owned());
        history.undo();
        assert_eq!(history.text(), "d");
    }

    #[test]
    fn nothing_done_is_no_step_and_the_oldest_are_forgotten() {
        let mut history = history();
        history.take("Nothing", None, "a".to_owned());
        assert_eq!(history.undoable(), None);
        for step in 0..MOST + 5 {
            history.take("Step", None, step.to_string());
        }
        let mut back = 0;
        while history.undo() {
            back += 1;
        }
        assert_eq!((back, history.text()), (MOST, "4"));
    }

    proptest! {
        #[test]
        fn undoing_all_and_doing_all_again_ends_where_it_began(
            steps in prop::collection::vec((0_u8..3, 0_u8..4, any::<u8>()), 0..60),
        ) {
            let mut history = history();
            for (what, gesture, text) in steps {
                match what {
                    0 => { history.undo(); }
                    1 => { history.redo(); }
                    _ => {
                        let gesture = (gesture > 0).then(|| gesture.to_string());
                        history.take("Step", gesture.as_deref(), text.to_string());
                    }
                }
            }
            while history.redo() {}
            let last = history.text().to_owned();
            while history.undo() {}
            prop_assert_eq!(history.text(), "a");
            while history.redo() {}
            prop_assert_eq!(history.text(), last);
        }
    }
}
