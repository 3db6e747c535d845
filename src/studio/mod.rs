//! The studio: a window in which a species is made.
//!
//! The script's text is the truth ([`document`]): each panel reads it and changes it by an [`document::Edit`], so
//! that the text, the panels and the tree cannot disagree, comments survive, and undo covers everything
//! ([`history`]). [`recovery`] keeps what is unsaved over a kill, [`kept`] what outlives every window. Pages are made from the tables of
//! [`crate::species::fields`] ([`outline`], [`form`]): a field that the language gets is in the studio at once.

pub mod adding;
mod angles;
mod app;
mod asking;
mod baking;
mod bearer;
mod bending;
mod bringing;
mod browser;
mod budgets;
mod closeups;
mod crown;
mod curve;
mod dock;
pub mod document;
mod drawings;
mod dropping;
mod export;
mod folder;
pub mod form;
mod girth;
mod grips;
mod growing;
mod hand;
mod handles;
pub mod history;
mod judging;
pub mod kept;
mod lod_table;
mod lods;
mod marks;
mod menu;
mod nearby;
pub mod outline;
mod palette;
mod panes;
mod parts;
mod picking;
mod pictures;
mod presence;
mod priorities;
mod questions;
pub mod recovery;
mod saving;
mod scribe;
mod script;
mod seeds;
mod settling;
mod skeleton;
mod spline_editor;
pub mod templates;
mod viewing;
mod welcome;
mod window;

pub use app::{Begin, Studio};
pub use baking::SketchBaker;
pub use window::run;
