//! A field guide to species: of each a plate of pictures, and what was measured beside what is known of real
//! trees. (species, grown tree, measures) -> [`Plate`](plate) and [`page`], pure; the command line grows the
//! trees and writes the files.

mod page;
mod plate;

pub use crate::preview::closeups::Paint;
pub use page::{Entry, page};
pub use plate::plate;
