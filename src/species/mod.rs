//! Species scripts: from RON text to the plain data of [`schema`].
//!
//! Text -> [`syntax`] tree with spans -> [`read`] -> [`schema::Species`], or all [`fault`]s of the
//! text at once. Pure, but for the files that a script names, which come through [`files::Files`].
//! A reader of our own, and not a `serde` one, because `serde` stops at the first fault, and because
//! an editor that keeps comments needs the spans.

mod bark;
mod decode;
pub mod edit;
pub mod fault;
pub mod fields;
pub mod files;
pub mod read;
pub mod schema;
pub mod spline_file;
pub mod syntax;

pub use fault::{Fault, Faults};
pub use files::{Beside, Files, NoFiles};
pub use read::parse;
