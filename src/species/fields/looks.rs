//! Fields of bark.

use super::Absent::{Fault, Means};
use super::Holds::{Colour, Number, Path};
use super::{Table, field, limits};

/// Names of the bark variants.
pub const BARKS: &[&str] = &["Ridged", "Gnarled", "Smooth", "Rings", "Image"];

/// A procedural bark.
pub static BARK: Table = Table {
    name: "Bark",
    doc: "A drawn bark: Ridged, Gnarled, Smooth or Rings.",
    groups: &[&[
        field(
            "light",
            Colour,
            Means("\"#8a8378\""),
            "Colour of the ridges.",
        ),
        field(
            "dark",
            Colour,
            Means("\"#3a322b\""),
            "Colour of the furrows.",
        ),
        field(
            "height_m",
            Number(limits(0.01, 20.0, "metres")),
            Means("0.6"),
            "Real height of one repeat.",
        ),
        field(
            "depth_m",
            Number(limits(0.0, 0.5, "metres")),
            Means("0.015"),
            "Real depth of the relief.",
        ),
    ]],
};

/// A bark from an image.
pub static BARK_IMAGE: Table = Table {
    name: "Image",
    doc: "A bark from an image that repeats in both directions.",
    groups: &[&[
        field("path", Path, Fault, "The image."),
        field(
            "height_m",
            Number(limits(0.01, 20.0, "metres")),
            Fault,
            "Real height of one repeat.",
        ),
    ]],
};
