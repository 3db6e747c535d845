//! Fields of leaves.

use super::Absent::{Fault, Means, Special};
use super::Holds::{Colour, Number, Other, Path, Text, Whole};
use super::{CARD, Field, PART, Table, field, limits};

/// A leaf card.
pub static LEAF: Table = Table {
    name: "Leaf",
    doc: "A leaf card, drawn or from an image.",
    groups: &[
        &[
            field("name", Text, Fault, "Unique name."),
            field(
                "length_m",
                Number(CARD),
                Fault,
                "Length of the card along the stalk.",
            ),
            field("width_m", Number(CARD), Fault, "Width of the card."),
            field(
                "fold_deg",
                Number(limits(-90.0, 90.0, "degrees")),
                Means("0"),
                "Angle by which each half is folded up along the midrib.",
            ),
            field(
                "image",
                Path,
                Special,
                "Image with alpha, stalk at the middle of the lower edge; drawn if left out.",
            ),
        ],
        DRAWN_LEAF,
    ],
};

/// The fields of a leaf that have no meaning beside an image.
pub const DRAWN_LEAF: &[Field] = &[
    field(
        "arrangement",
        Other("Arrangement"),
        Means("Single"),
        "How blades stand on the card.",
    ),
    field(
        "blade",
        Other("Blade"),
        Means("()"),
        "Outline of one blade.",
    ),
    field(
        "colour",
        Colour,
        Means("\"#4a6b34\""),
        "Colour of the upper side.",
    ),
    field(
        "colour_vary",
        Number(PART),
        Means("0.1"),
        "Random change of lightness from blade to blade.",
    ),
    field(
        "stalk_colour",
        Colour,
        Means("\"#6b5b43\""),
        "Colour of the stalk.",
    ),
    field(
        "gloss",
        Number(PART),
        Means("0.3"),
        "How mirror-smooth the surface is.",
    ),
    field(
        "translucency",
        Number(PART),
        Means("0.3"),
        "Light let through, as a part of the light reflected.",
    ),
];

/// Names of the arrangements.
pub const ARRANGEMENTS: &[&str] = &["Single", "Opposite", "Alternate"];

/// Angle and length of the blades on a twig.
const TWIG: &[Field] = &[
    field(
        "angle_deg",
        Number(limits(0.0, 180.0, "degrees")),
        Means("50"),
        "Angle of a blade from the twig.",
    ),
    field(
        "blade",
        Number(limits(0.01, 1.0, "")),
        Means("0.4"),
        "Blade length, as a part of the card's length.",
    ),
];

/// Opposite blades.
pub static OPPOSITE: Table = Table {
    name: "Opposite",
    doc: "A twig with opposite pairs of blades and one at the tip.",
    groups: &[
        &[field("pairs", Whole(1, 64), Fault, "Pairs along the twig.")],
        TWIG,
    ],
};

/// Alternate blades.
pub static ALTERNATE: Table = Table {
    name: "Alternate",
    doc: "A twig with single blades on alternating sides and one at the tip.",
    groups: &[
        &[field(
            "count",
            Whole(1, 128),
            Fault,
            "Blades along the twig.",
        )],
        TWIG,
    ],
};

/// A leaf blade.
pub static BLADE: Table = Table {
    name: "Blade",
    doc: "Outline of one blade.",
    groups: &[&[
        field(
            "width",
            Number(limits(0.005, 5.0, "")),
            Means("0.5"),
            "Greatest width over length.",
        ),
        field(
            "widest",
            Number(limits(0.02, 0.98, "")),
            Means("0.45"),
            "Where along the midrib it is widest.",
        ),
        field(
            "sharpness",
            Number(limits(0.05, 4.0, "")),
            Means("0.6"),
            "0.3 nearly parallel-sided, 0.5 elliptic, 1 rhombic.",
        ),
        field("teeth", Whole(0, 200), Means("0"), "Teeth on each side."),
        field(
            "tooth_depth",
            Number(PART),
            Means("0"),
            "Depth of the teeth, as a part of the half width.",
        ),
        field(
            "veins",
            Whole(0, 100),
            Means("6"),
            "Side veins on each side.",
        ),
    ]],
};
