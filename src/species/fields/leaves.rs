//! Fields of leaves.

use super::Absent::{Fault, Means, Special};
use super::Holds::{Colour, Number, OneOf, Other, Path, Text, Whole};
use super::{CARD, Field, Limits, PART, Table, field, limits};

/// Names of the arrangements.
pub const ARRANGEMENTS: &[&str] = &[
    "Single",
    "Opposite",
    "Alternate",
    "Brush",
    "Tufts",
    "Scales",
];
/// Names of the forms of a leaf.
pub const FORMS: &[&str] = &["Simple", "Pinnate", "Bipinnate", "Palmate"];
/// Names of the seasons, 0 to 3.
pub const SEASONS: &[&str] = &["Spring", "Summer", "Autumn", "Winter"];
/// Names of the measured leaf colours.
pub const TISSUES: &[&str] = &[
    "Young",
    "LightGreen",
    "MidGreen",
    "DarkGreen",
    "Evergreen",
    "BlueGreen",
    "Turning",
    "Yellow",
    "Orange",
    "Red",
    "Purple",
    "Russet",
    "Dead",
];

/// Seasons as numbers.
pub const SEASON: Limits = limits(0.0, 3.0, "");
/// Length of a blade on a card.
const LENGTH_ON_CARD: Limits = limits(0.004, 1.0, "");
/// Angles away from a twig, rachis or midrib.
pub(super) const AWAY: Limits = limits(0.0, 180.0, "degrees");
/// Angles of a fan.
pub(super) const SPREAD: Limits = limits(0.0, 350.0, "degrees");
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
        "How leaves stand on the card: Single, Opposite, Alternate, Brush, Tufts or Scales.",
    ),
    field(
        "spray",
        Other("Spray"),
        Special,
        "Side shoots with leaves of their own; one twig if left out.",
    ),
    field(
        "form",
        Other("Form"),
        Means("Simple"),
        "How a leaf is made of blades: Simple, Pinnate, Bipinnate or Palmate.",
    ),
    field(
        "petiole",
        Number(limits(0.0, 3.0, "")),
        Special,
        "Leaf stalk, as a part of the leaf's length; by arrangement if left out.",
    ),
    field(
        "blade",
        Other("Blade"),
        Means("()"),
        "Outline, margin and veins of one blade, leaflet, needle or scale.",
    ),
    field(
        "flowers",
        Other("Flowers"),
        Special,
        "Flowers among the leaves; none if left out.",
    ),
    field(
        "summer",
        OneOf(TISSUES),
        Means("MidGreen"),
        "Measured colour in summer.",
    ),
    field(
        "autumn",
        OneOf(TISSUES),
        Special,
        "Measured colour in autumn; the leaf stays green if left out.",
    ),
    field(
        "colour",
        Colour,
        Special,
        "Summer colour of the upper side by hand; that of `summer` if left out.",
    ),
    field(
        "season",
        Other("Spring, Summer, Autumn, Winter or a number from 0 to 3"),
        Special,
        "Season it is drawn in, if not the species'; 1.5 is late summer.",
    ),
    field(
        "age",
        Number(PART),
        Means("0.5"),
        "0 unfolding, 0.5 grown, 1 about to fall.",
    ),
    field(
        "health",
        Number(PART),
        Means("1"),
        "1 whole, less has spots, brown margins and holes.",
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
        "Colour of the twig.",
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
        Special,
        "Light let through, as a part of the light reflected; as measured if left out.",
    ),
];

/// A twig with opposite pairs of leaves and one at the tip.
pub static OPPOSITE: Table = Table {
    name: "Opposite",
    doc: "A twig with opposite pairs of leaves and one at the tip.",
    groups: &[&[
        field("pairs", Whole(1, 200), Fault, "Pairs along the twig."),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a leaf from the twig.",
        ),
        field(
            "blade",
            Number(LENGTH_ON_CARD),
            Means("0.4"),
            "Leaf length, as a part of the card's length.",
        ),
    ]],
};

/// A twig with single leaves on alternating sides and one at the tip.
pub static ALTERNATE: Table = Table {
    name: "Alternate",
    doc: "A twig with single leaves on alternating sides and one at the tip.",
    groups: &[&[
        field("count", Whole(1, 400), Fault, "Leaves along the twig."),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a leaf from the twig.",
        ),
        field(
            "blade",
            Number(LENGTH_ON_CARD),
            Means("0.4"),
            "Leaf length, as a part of the card's length.",
        ),
    ]],
};

/// A twig with needles all around it.
pub static BRUSH: Table = Table {
    name: "Brush",
    doc: "A twig with needles all around it.",
    groups: &[&[
        field(
            "count",
            Whole(1, 1000),
            Fault,
            "Needles, or bundles of them, along the twig.",
        ),
        field("bundle", Whole(1, 8), Means("1"), "Needles in a bundle."),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a leaf from the twig.",
        ),
        field(
            "blade",
            Number(LENGTH_ON_CARD),
            Means("0.15"),
            "Needle length, as a part of the card's length.",
        ),
    ]],
};

/// A twig with rosettes of leaves on short shoots.
pub static TUFTS: Table = Table {
    name: "Tufts",
    doc: "A twig with rosettes of leaves on short shoots.",
    groups: &[&[
        field(
            "count",
            Whole(1, 100),
            Fault,
            "Rosettes along the twig, the one at its end included.",
        ),
        field("leaves", Whole(1, 200), Fault, "Leaves of a rosette."),
        field(
            "spread_deg",
            Number(SPREAD),
            Means("150"),
            "Angle that a rosette fills.",
        ),
        field(
            "blade",
            Number(LENGTH_ON_CARD),
            Means("0.15"),
            "Leaf length, as a part of the card's length.",
        ),
    ]],
};

/// A twig hidden under pairs of scales.
pub static SCALES: Table = Table {
    name: "Scales",
    doc: "A twig hidden under pairs of scales.",
    groups: &[&[
        field("pairs", Whole(1, 200), Fault, "Pairs along the twig."),
        field(
            "blade",
            Number(LENGTH_ON_CARD),
            Means("0.05"),
            "Scale length, as a part of the card's length.",
        ),
    ]],
};

/// Side shoots in the plane of the card.
pub static SPRAY: Table = Table {
    name: "Spray",
    doc: "Side shoots in the plane of the card.",
    groups: &[&[
        field(
            "shoots",
            Whole(1, 64),
            Fault,
            "Side shoots along the twig, or pairs of them.",
        ),
        field(
            "opposite",
            Other("true or false"),
            Means("false"),
            "True for pairs, false for alternating sides.",
        ),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a side shoot from the twig.",
        ),
        field(
            "length",
            Number(limits(0.05, 2.0, "")),
            Means("0.5"),
            "Length of the longest, as a part of the twig's.",
        ),
        field(
            "orders",
            Whole(1, 2),
            Means("1"),
            "How often shoots branch.",
        ),
    ]],
};

/// Leaflets in pairs along a rachis, and one at its tip.
pub static PINNATE_LEAF: Table = Table {
    name: "Pinnate",
    doc: "Leaflets in pairs along a rachis, and one at its tip.",
    groups: &[&[
        field("pairs", Whole(1, 200), Fault, "Pairs of leaflets."),
        field(
            "leaflet",
            Number(LENGTH_ON_CARD),
            Means("0.35"),
            "Length of the longest leaflet, as a part of the leaf's.",
        ),
        field(
            "angle_deg",
            Number(AWAY),
            Means("60"),
            "Angle of a leaflet from the rachis.",
        ),
        field(
            "bare",
            Number(PART),
            Means("0.15"),
            "Part of the rachis without leaflets.",
        ),
        field(
            "taper",
            Number(PART),
            Means("0.2"),
            "How much shorter the last leaflets are.",
        ),
    ]],
};

/// Pinnae in pairs along a rachis, each with leaflets of its own.
pub static BIPINNATE: Table = Table {
    name: "Bipinnate",
    doc: "Pinnae in pairs along a rachis, each with leaflets of its own.",
    groups: &[&[
        field("pinnae", Whole(1, 40), Fault, "Pairs of pinnae."),
        field(
            "pinna",
            Number(LENGTH_ON_CARD),
            Means("0.5"),
            "Length of the longest pinna, as a part of the leaf's.",
        ),
        field(
            "pairs",
            Whole(1, 60),
            Fault,
            "Pairs of leaflets on a pinna.",
        ),
        field(
            "leaflet",
            Number(LENGTH_ON_CARD),
            Means("0.2"),
            "Length of a leaflet, as a part of the pinna's.",
        ),
    ]],
};

/// Leaflets that spread from one point.
pub static PALMATE_LEAF: Table = Table {
    name: "Palmate",
    doc: "Leaflets that spread from one point.",
    groups: &[&[
        field("leaflets", Whole(1, 200), Fault, "Leaflets."),
        field(
            "spread_deg",
            Number(SPREAD),
            Means("200"),
            "Angle between the outermost.",
        ),
        field(
            "outer",
            Number(limits(0.05, 1.0, "")),
            Means("0.5"),
            "Length of the outermost, as a part of the middle one's.",
        ),
        field(
            "costa",
            Number(PART),
            Means("0"),
            "Length of a midrib from which they spread, as a part of the leaf's.",
        ),
    ]],
};

/// Flowers among the leaves.
pub static FLOWERS: Table = Table {
    name: "Flowers",
    doc: "Flowers among the leaves.",
    groups: &[&[
        field("count", Whole(1, 200), Fault, "Flowers on the card."),
        field("petals", Whole(3, 30), Means("5"), "Petals of a flower."),
        field(
            "size",
            Number(LENGTH_ON_CARD),
            Means("0.15"),
            "Width of a flower, as a part of the card's length.",
        ),
        field(
            "colour",
            Colour,
            Means("\"#f2e4e6\""),
            "Colour of the petals.",
        ),
    ]],
};
