//! A window on a tree: cameras, sun and wind, LODs by distance or by hand, the views that show how a tree is
//! made, and the script grown again whenever it is saved.
//!
//! [`Viewport`] is the view alone, to be put into any egui window; [`App`] is the window of `pleach preview`:
//! a view, the panel beside it, a thread that grows trees ([`loader`]) and one that watches files ([`watch`]).
//! What can be known without a window is plain data and functions over it: [`settings`], [`rig`] (cameras),
//! [`level`] and [`stage`] (which tree stands where, with which LOD), [`split`] (two LODs in one picture), [`pace`] (how fine while it moves).

mod app;
mod canvas;
pub mod keys;
pub mod legend;
pub mod level;
pub mod loader;
pub mod pace;
pub mod panel;
mod person;
pub mod projection;
pub mod rig;
pub mod settings;
pub mod shot;
mod show;
pub mod split;
pub mod stage;
mod subject;
mod viewport;
pub mod watch;
mod window;

pub use app::{App, Kept, Legacy, Start, StartError};
pub use subject::{LodFacts, Source, Subject};
pub use viewport::Viewport;
#[cfg(feature = "studio")]
pub(crate) use viewport::write;
pub use window::{Options, WindowError, open, run, setup};
