//! The model's parameters: names, ranges, and what they are when a file leaves them out.

use super::arbaro::Read;
use crate::import::{ImportFault, Mark, Note};
use std::collections::BTreeMap;

/// Levels that have parameters of their own: the trunk and three of branches.
pub const LEVELS: usize = 4;

/// One parameter of the tree: name, default, least and greatest value.
type Known = (&'static str, f32, f32, f32);

/// Parameters of the whole tree.
const GENERAL: &[Known] = &[
    ("Shape", 0.0, 0.0, 8.0),
    ("Levels", 3.0, 1.0, 4.0),
    ("Scale", 10.0, 0.05, 150.0),
    ("ScaleV", 0.0, 0.0, 150.0),
    ("ZScale", 1.0, 0.01, 100.0),
    ("ZScaleV", 0.0, 0.0, 100.0),
    ("BaseSize", 0.25, 0.0, 1.0),
    ("Ratio", 0.05, 0.0005, 1.0),
    ("RatioPower", 1.0, 0.0, 10.0),
    ("Lobes", 0.0, 0.0, 64.0),
    ("LobeDepth", 0.0, 0.0, 1.0),
    ("Flare", 0.5, -1.0, 10.0),
    ("Leaves", 0.0, -1000.0, 1000.0),
    ("LeafScale", 0.2, 0.001, 10.0),
    ("LeafScaleX", 0.5, 0.005, 5.0),
    ("LeafBend", 0.3, -10.0, 10.0),
    ("LeafStemLen", 0.5, -100.0, 100.0),
    ("LeafQuality", 1.0, 0.0, 1.0),
    ("LeafDistrib", 4.0, 0.0, 8.0),
    ("AttractionUp", 0.0, -20.0, 20.0),
    ("PruneRatio", 0.0, 0.0, 1.0),
    ("PruneWidth", 0.5, 0.0, 10.0),
    ("PruneWidthPeak", 0.5, 0.0, 1.0),
    ("PrunePowerLow", 0.5, 0.0, 100.0),
    ("PrunePowerHigh", 0.5, 0.0, 100.0),
    ("Smooth", 0.5, 0.0, 1.0),
    ("0Scale", 1.0, 0.01, 100.0),
    ("0ScaleV", 0.0, 0.0, 100.0),
    ("0BaseSplits", 0.0, -16.0, 16.0),
];

/// Parameters of each level: name without the level's number, default by level, least and greatest value.
const OF_LEVEL: &[(&str, [f32; LEVELS], f32, f32)] = &[
    ("DownAngle", [0.0, 30.0, 30.0, 30.0], -360.0, 360.0),
    ("DownAngleV", [0.0; LEVELS], -360.0, 360.0),
    ("Rotate", [0.0, 120.0, 120.0, 120.0], -360.0, 360.0),
    ("RotateV", [0.0; LEVELS], -360.0, 360.0),
    ("Branches", [1.0, 10.0, 5.0, 5.0], -1000.0, 5000.0),
    ("BranchDist", [0.0, 0.0, 0.0, 0.0], 0.0, 1.0),
    ("Length", [1.0, 0.5, 0.5, 0.5], 0.0, 10.0),
    ("LengthV", [0.0; LEVELS], -10.0, 10.0),
    ("Taper", [1.0; LEVELS], 0.0, 2.999),
    ("SegSplits", [0.0; LEVELS], 0.0, 10.0),
    ("SplitAngle", [0.0; LEVELS], -360.0, 360.0),
    ("SplitAngleV", [0.0; LEVELS], -360.0, 360.0),
    ("CurveRes", [3.0, 3.0, 1.0, 1.0], 1.0, 100.0),
    ("Curve", [0.0; LEVELS], -720.0, 720.0),
    ("CurveBack", [0.0; LEVELS], -720.0, 720.0),
    ("CurveV", [0.0; LEVELS], -720.0, 720.0),
];

/// Other names for the same, as the paper has them.
const ALIASES: &[(&str, &str)] = &[
    ("BaseSplits", "0BaseSplits"),
    ("TrunkScale", "0Scale"),
    ("TrunkScaleV", "0ScaleV"),
];

/// Parameters without which a tree would be made of defaults alone.
const NEEDED: &[&str] = &["Shape", "Levels", "Scale", "Ratio"];

/// The parameters of one tree, all within their ranges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters {
    /// The tree's name; may be empty.
    pub name: String,
    /// How leaves look, in the file's word; empty if it has none.
    pub leaf_shape: String,
    given: BTreeMap<String, f32>,
}

impl Parameters {
    /// Checks what a file holds. Unknown and left-out parameters become notes.
    pub(super) fn read(read: Read) -> Result<(Self, Vec<Note>), Vec<ImportFault>> {
        let mut parameters = Self {
            name: read.name,
            ..Self::default()
        };
        let mut faults = Vec::new();
        let mut notes = Vec::new();
        for entry in &read.entries {
            if entry.name == "LeafShape" {
                parameters.leaf_shape.clone_from(&entry.value);
                continue;
            }
            if entry.name == "Species" {
                parameters.name.clone_from(&entry.value);
                continue;
            }
            let alias = ALIASES.iter().find(|alias| alias.0 == entry.name);
            let name = alias.map_or(entry.name.as_str(), |alias| alias.1);
            let Some((_, min, max)) = known(name) else {
                let text = match nearest(name) {
                    Some(near) => format!("not known (did you mean {near}?); left out"),
                    None => "not known; left out".to_owned(),
                };
                notes.push(Note {
                    mark: Mark::Warning,
                    parameters: format!("{} {}", entry.name, entry.value),
                    text,
                });
                continue;
            };
            match entry.value.parse::<f32>() {
                Ok(value) if (min..=max).contains(&value) => {
                    if parameters.given.insert(name.to_owned(), value).is_some() {
                        faults.push(entry.fault(format!("{name} is given twice")));
                    }
                }
                Ok(value) if value.is_finite() => faults.push(entry.fault(format!(
                    "{name}: {} is out of range; expected {min} to {max}",
                    entry.value
                ))),
                _ => faults.push(entry.fault(format!(
                    "{name}: expected a number from {min} to {max}, found `{}`",
                    entry.value
                ))),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let absent = |name: &&&str| !parameters.given.contains_key(**name);
        let missing: Vec<&str> = NEEDED.iter().filter(absent).copied().collect();
        if missing.len() == NEEDED.len() {
            return Err(vec![ImportFault {
                line: 1,
                column: 1,
                message: format!(
                    "no parameters of the model found, not even {}",
                    NEEDED.join(", ")
                ),
            }]);
        }
        for name in missing {
            let default = parameters.get(name);
            notes.push(Note {
                mark: Mark::Warning,
                parameters: name.to_owned(),
                text: format!("not in the file; taken as {default}"),
            });
        }
        Ok((parameters, notes))
    }

    /// A parameter, or what it is when left out.
    #[must_use]
    pub fn get(&self, name: &str) -> f32 {
        let given = self.given.get(name).copied();
        given.or(known(name).map(|k| k.0)).unwrap_or(0.0)
    }

    /// A parameter of a level. Levels beyond the third are like it.
    #[must_use]
    pub fn of(&self, level: usize, name: &str) -> f32 {
        self.get(&of_level(level, name))
    }

    /// True if the file has it.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.given.contains_key(name)
    }

    /// All names that the file has.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.given.keys().map(String::as_str)
    }
}

/// A level's parameter by its full name.
pub(super) fn of_level(level: usize, name: &str) -> String {
    format!("{}{name}", level.min(LEVELS - 1))
}

/// Default, least and greatest value.
fn known(name: &str) -> Option<(f32, f32, f32)> {
    if let Some(&(_, default, min, max)) = GENERAL.iter().find(|known| known.0 == name) {
        return Some((default, min, max));
    }
    let digit = name.chars().next()?.to_digit(10)? as usize;
    let plain = name.get(1..)?;
    let &(_, defaults, min, max) = OF_LEVEL.iter().find(|known| known.0 == plain)?;
    Some((*defaults.get(digit)?, min, max))
}

/// The name that was probably meant.
fn nearest(name: &str) -> Option<String> {
    let general = GENERAL.iter().map(|known| known.0.to_owned());
    let levels = (0..LEVELS).flat_map(|l| OF_LEVEL.iter().map(move |k| of_level(l, k.0)));
    general
        .chain(levels)
        .map(|known| (strsim::damerau_levenshtein(name, &known), known))
        .filter(|(distance, known)| name.len() < 100 && distance * 3 <= known.len())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, known)| known)
}
