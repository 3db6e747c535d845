//! Weber and Penn's trees.
//!
//! Paper: Weber J., Penn J. 1995: Creation and rendering of realistic trees. SIGGRAPH 95, 119-128; its names
//! of parameters, in the XML form of the program Arbaro. Arbaro itself was not looked at for this.
//!
//! A level of theirs is a level of ours. What differs:
//! - All nodes of a level of ours share a few prototypes, and are scaled with all that grows on them. So their
//!   laws of lengths become our `scale` over the position on the parent, and leaves are made larger by what
//!   the scales take from them in the mean.
//! - Stems of theirs split (`SegSplits`, `BaseSplits`); ours do not. Base splits become leaders, a level of its
//!   own on a short bole. Other splits become more and longer branches of the next level.
//! - Their pruning looks at each stem where it stands. Here it is worked out once for each height, and becomes
//!   part of the limbs' `scale`.
//! - Leaves stand on cards, several a card where there are many.

mod arbaro;
mod dress;
mod laws;
mod leaves;
mod levels;
mod notes;
mod parameters;
mod shape;
mod words;
mod write;

pub use parameters::{LEVELS, Parameters};

use super::{ImportFault, Imported};

/// Turns the XML text of a tree into a script.
///
/// # Errors
/// All faults of the text, in its order: broken XML (then only that), and values that are no numbers or out of
/// range.
pub fn import(text: &str) -> Result<Imported, Vec<ImportFault>> {
    let read = arbaro::read(text)?;
    let (parameters, mut notes) = Parameters::read(read)?;
    let plan = levels::plan(&parameters);
    notes.extend(plan.notes.iter().cloned());
    Ok(Imported {
        script: write::script(&parameters, &plan, &notes),
        notes,
    })
}
