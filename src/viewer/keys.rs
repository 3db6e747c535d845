//! Keys and mouse: what each does, in one table that the window and its help both read.

use eframe::egui::{Context, Key, Modifiers};

/// What a key does at once; keys that are held to walk are in [`WALKING`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Shows all of what stands in the picture.
    Frame,
    /// Draws with the finest LOD, the second, ...
    Lod(usize),
    /// Draws with LODs by distance.
    ByDistance,
    /// Goes on to the next view.
    NextView,
    /// Shows a forest, or one tree again.
    Forest,
    /// Shows all LODs side by side, or one tree again.
    Strip,
    /// Turns about the tree, or stops.
    Turntable,
    /// Lets the wind blow, or stops it.
    Wind,
    /// Walks slower.
    Slower,
    /// Walks faster.
    Faster,
    /// Writes the picture to a file.
    Screenshot,
    /// Shows or hides the panel.
    Panel,
    /// Shows or hides the help.
    Help,
    /// Closes the help, or the window.
    Quit,
}

/// A line of the help: keys or mouse, and what they do.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Keys or mouse, in words.
    pub keys: &'static str,
    /// What they do.
    pub does: &'static str,
}

/// The mouse, and keys that are held.
pub const HELD: [Line; 7] = [
    Line {
        keys: "Left drag",
        does: "orbit; on foot, look around",
    },
    Line {
        keys: "Right or middle drag",
        does: "pan",
    },
    Line {
        keys: "Wheel",
        does: "zoom",
    },
    Line {
        keys: "Ctrl + left drag",
        does: "move the sun",
    },
    Line {
        keys: "Double click",
        does: "frame",
    },
    Line {
        keys: "W A S D",
        does: "walk, 1.7 m over the ground",
    },
    Line {
        keys: "Shift",
        does: "hurry",
    },
];

/// Keys that do something at once.
pub const KEYS: [(Line, &[(Key, Action)]); 13] = [
    (
        Line {
            keys: "Q  E",
            does: "walk slower, faster",
        },
        &[(Key::Q, Action::Slower), (Key::E, Action::Faster)],
    ),
    (
        Line {
            keys: "F",
            does: "frame what is shown",
        },
        &[(Key::F, Action::Frame)],
    ),
    (
        Line {
            keys: "1 ... 9",
            does: "LOD by hand, the finest first",
        },
        &[
            (Key::Num1, Action::Lod(0)),
            (Key::Num2, Action::Lod(1)),
            (Key::Num3, Action::Lod(2)),
            (Key::Num4, Action::Lod(3)),
            (Key::Num5, Action::Lod(4)),
            (Key::Num6, Action::Lod(5)),
            (Key::Num7, Action::Lod(6)),
            (Key::Num8, Action::Lod(7)),
            (Key::Num9, Action::Lod(8)),
        ],
    ),
    (
        Line {
            keys: "0",
            does: "LOD by distance",
        },
        &[(Key::Num0, Action::ByDistance)],
    ),
    (
        Line {
            keys: "V",
            does: "next view: lit, LOD colours, level colours, wireframe, ...",
        },
        &[(Key::V, Action::NextView)],
    ),
    (
        Line {
            keys: "G",
            does: "forest, or one tree",
        },
        &[(Key::G, Action::Forest)],
    ),
    (
        Line {
            keys: "L",
            does: "all LODs side by side, or one tree",
        },
        &[(Key::L, Action::Strip)],
    ),
    (
        Line {
            keys: "T",
            does: "turntable",
        },
        &[(Key::T, Action::Turntable)],
    ),
    (
        Line {
            keys: "Space",
            does: "wind",
        },
        &[(Key::Space, Action::Wind)],
    ),
    (
        Line {
            keys: "P or F12",
            does: "screenshot, into the working folder",
        },
        &[(Key::P, Action::Screenshot), (Key::F12, Action::Screenshot)],
    ),
    (
        Line {
            keys: "N",
            does: "show or hide the panel",
        },
        &[(Key::N, Action::Panel)],
    ),
    (
        Line {
            keys: "H or F1",
            does: "show or hide this help",
        },
        &[(Key::H, Action::Help), (Key::F1, Action::Help)],
    ),
    (
        Line {
            keys: "Esc",
            does: "close the help, or quit",
        },
        &[(Key::Escape, Action::Quit)],
    ),
];

/// Keys that walk while they are held: parts of a step to the right and ahead.
pub const WALKING: [(Key, [f32; 2]); 4] = [
    (Key::W, [0.0, 1.0]),
    (Key::S, [0.0, -1.0]),
    (Key::A, [-1.0, 0.0]),
    (Key::D, [1.0, 0.0]),
];

/// What the keys pressed since the last frame do. None of them is left for widgets, and none is taken while a
/// person writes into a field. A widget that was reached by keys keeps those that work it.
pub fn pressed(ctx: &Context) -> Vec<Action> {
    pressed_of(ctx, |_| true)
}

/// As [`pressed`], for keys that do something that is `obeyed`; the others are left for widgets.
pub fn pressed_of(ctx: &Context, obeyed: impl Fn(Action) -> bool) -> Vec<Action> {
    if ctx.egui_wants_keyboard_input() {
        return Vec::new();
    }
    let focused = ctx.memory(|memory| memory.focused().is_some());
    ctx.input_mut(|input| {
        let pairs = KEYS.iter().flat_map(|(_, pairs)| pairs.iter());
        let pairs = pairs.filter(|(_, action)| obeyed(*action));
        let free = pairs.filter(|(key, _)| !(focused && *key == Key::Space));
        free.filter(|&&(key, _)| input.consume_key(Modifiers::NONE, key))
            .map(|&(_, action)| action)
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let mut keys: Vec<Key> = WALKING.iter().map(|(key, _)| *key).collect();
        keys.extend(
            KEYS.iter()
                .flat_map(|(_, pairs)| pairs.iter().map(|(key, _)| *key)),
        );
        for (index, key) in keys.iter().enumerate() {
            assert!(!keys[..index].contains(key), "{key:?}");
        }
    }
}
