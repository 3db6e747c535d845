//! Fields of bark.

use super::Absent::{Fault, Means};
use super::Holds::{Colour, Number, Path};
use super::{Field, Limits, PART, Table, field, limits};

/// Names of the bark variants.
pub const BARKS: &[&str] = &[
    "Ridged", "Gnarled", "Smooth", "Papery", "Banded", "Plates", "Mosaic", "Fibrous", "Rings",
    "Lattice", "Image",
];

/// Real height of one repeat.
const REPEAT: Limits = limits(0.01, 20.0, "metres");
/// Mean size of a part of a pattern: a few millimetres to the largest repeat.
const PIECE: Limits = limits(0.002, 10.0, "metres");

/// Radius from which on bark is mature: 0 for one bark on all stems.
const RADIUS: Limits = limits(0.0, 3.0, "metres");

const YOUNG: &str = "Colour of young bark, to be seen on thin stems and where `age` is below 1.";
const MATURE_RADIUS: &str = "Radius from which on stems have mature bark. Thinner ones take on the colour of young \
                             bark, twigs wholly; 0 if all stems look alike.";

/// What a bark is where a script does not say it, each in the script's words.
struct Usual {
    /// Light, dark, accent, young.
    colours: [&'static str; 4],
    /// Repeat, depth, width and length of a part.
    metres: [&'static str; 4],
    roughness: &'static str,
    mature_radius_m: &'static str,
}

/// The fields that all drawn barks have.
const fn common(usual: &Usual) -> [Field; 13] {
    let [light, dark, accent, young] = usual.colours;
    let [height_m, depth_m, width_m, length_m] = usual.metres;
    [
        field("light", Colour, Means(light), "Colour of the heights."),
        field("dark", Colour, Means(dark), "Colour of the depths."),
        field(
            "accent",
            Colour,
            Means(accent),
            "Third colour: inner bark, lenticels, scars, the middle layer of a mosaic.",
        ),
        field("young", Colour, Means(young), YOUNG),
        field(
            "mature_radius_m",
            Number(RADIUS),
            Means(usual.mature_radius_m),
            MATURE_RADIUS,
        ),
        field(
            "height_m",
            Number(REPEAT),
            Means(height_m),
            "Real height of one repeat.",
        ),
        field(
            "depth_m",
            Number(limits(0.0, 0.5, "metres")),
            Means(depth_m),
            "Real depth of the relief.",
        ),
        field(
            "width_m",
            Number(PIECE),
            Means(width_m),
            "Mean width of a ridge, plate, flake, diamond or lenticel; at most half a repeat counts.",
        ),
        field(
            "length_m",
            Number(PIECE),
            Means(length_m),
            "Mean length of such a part along the stem, or distance of bands and rings.",
        ),
        field(
            "age",
            Number(PART),
            Means("1"),
            "0 the smooth skin of a twig, 1 the bark of an old trunk.",
        ),
        field(
            "roughness",
            Number(PART),
            Means(usual.roughness),
            "0 mirror-smooth, 1 matt.",
        ),
        field(
            "lichen",
            Number(PART),
            Means("0"),
            "Share under pale crusts of lichen.",
        ),
        field(
            "moss",
            Number(PART),
            Means("0"),
            "Share of the hollows under moss or green algae.",
        ),
    ]
}

const fn part(name: &'static str, usual: &'static str, doc: &'static str) -> Field {
    field(name, Number(PART), Means(usual), doc)
}

/// Corky ridges along the stem between furrows: oak, ash, poplar, elm, willow, lime.
pub static RIDGED: Table = Table {
    name: "Ridged",
    doc: "Corky ridges along the stem between furrows: oak, ash, poplar, elm, willow, lime.",
    groups: &[
        &[
            part(
                "braid",
                "0.4",
                "0 ridges that furrows part, 1 a net of ridges around diamond-shaped furrows.",
            ),
            part(
                "flat",
                "0.3",
                "0 rounded crests, 1 flat-topped ridges with steep sides.",
            ),
            part(
                "cracks",
                "0.3",
                "Cracks across the ridges, from none to many.",
            ),
        ],
        &common(&Usual {
            colours: ["\"#8a8378\"", "\"#3a322b\"", "\"#5a4432\"", "\"#8a8068\""],
            metres: ["0.6", "0.015", "0.05", "0.21"],
            roughness: "0.9",
            mature_radius_m: "0.08",
        }),
    ],
};

/// Rounded twisted ridges with soft furrows and pits: old olives.
pub static GNARLED: Table = Table {
    name: "Gnarled",
    doc: "Rounded twisted ridges with soft furrows and pits: old olives.",
    groups: &[
        &[part(
            "scales",
            "0.5",
            "How much of it breaks up into scales.",
        )],
        &common(&Usual {
            colours: ["\"#8a8378\"", "\"#3a322b\"", "\"#7d6a55\"", "\"#8b8d80\""],
            metres: ["0.6", "0.015", "0.045", "0.095"],
            roughness: "0.87",
            mature_radius_m: "0.08",
        }),
    ],
};

/// A nearly smooth skin: beech, hazel, Japanese maple.
pub static SMOOTH: Table = Table {
    name: "Smooth",
    doc: "A nearly smooth skin: beech, hazel, Japanese maple.",
    groups: &[
        &[
            part("wrinkles", "0.4", "Fine wrinkles across the stem."),
            part(
                "lenticels",
                "0.2",
                "How many of the places for lenticels have one.",
            ),
            part(
                "scars",
                "0.1",
                "How many of the places for eye-shaped scars of lost branches have one.",
            ),
        ],
        &common(&Usual {
            colours: ["\"#90908b\"", "\"#6c6c67\"", "\"#383733\"", "\"#635c50\""],
            metres: ["0.6", "0.004", "0.12", "0.12"],
            roughness: "0.7",
            mature_radius_m: "0.05",
        }),
    ],
};

/// White paper that peels, with dark dashes and black diamonds: birch, aspen.
pub static PAPERY: Table = Table {
    name: "Papery",
    doc: "White paper that peels, with dark dashes and black diamonds: birch, aspen.",
    groups: &[
        &[
            part(
                "lenticels",
                "0.6",
                "How many of the places for short dark lines across the stem have one.",
            ),
            part("peel", "0.25", "Share of the paper that has peeled off."),
            part(
                "diamonds",
                "0.3",
                "How many of the places for black rough diamonds have one.",
            ),
        ],
        &common(&Usual {
            colours: ["\"#c2beb4\"", "\"#2b2724\"", "\"#a08a74\"", "\"#5c3f31\""],
            metres: ["0.9", "0.008", "0.13", "0.17"],
            roughness: "0.55",
            mature_radius_m: "0.04",
        }),
    ],
};

/// Satin skin with bands of corky lenticels across the stem: cherry.
pub static BANDED: Table = Table {
    name: "Banded",
    doc: "Satin skin with bands of corky lenticels across the stem: cherry.",
    groups: &[
        &[
            part(
                "lenticels",
                "0.6",
                "Share of the bands that bear lenticels.",
            ),
            part(
                "peel",
                "0.25",
                "Share that peels off in strips around the stem.",
            ),
        ],
        &common(&Usual {
            colours: ["\"#704639\"", "\"#3b231d\"", "\"#8c7058\"", "\"#6b4334\""],
            metres: ["0.6", "0.004", "0.024", "0.045"],
            roughness: "0.45",
            mature_radius_m: "0.05",
        }),
    ],
};

/// Plates or scales parted by cracks: pine, spruce, larch, horse chestnut.
pub static PLATES: Table = Table {
    name: "Plates",
    doc: "Plates or scales parted by cracks: pine, spruce, larch, horse chestnut.",
    groups: &[
        &[
            part(
                "flakes",
                "0.6",
                "How much the plates are layered in flakes.",
            ),
            part(
                "lift",
                "0.1",
                "0 flat plates, 1 scales whose lower edges lift over those below.",
            ),
        ],
        &common(&Usual {
            colours: ["\"#807064\"", "\"#2c231d\"", "\"#946a50\"", "\"#9a7048\""],
            metres: ["1", "0.025", "0.09", "0.18"],
            roughness: "0.9",
            mature_radius_m: "0.1",
        }),
    ],
};

/// Three layers, the outer ones shed in flakes: plane.
pub static MOSAIC: Table = Table {
    name: "Mosaic",
    doc: "Three layers, the outer ones shed in flakes: plane.",
    groups: &[
        &[part(
            "shed",
            "0.6",
            "Share of the oldest layer that has come off.",
        )],
        &common(&Usual {
            colours: ["\"#aea588\"", "\"#665f52\"", "\"#828064\"", "\"#6e6c4c\""],
            metres: ["1", "0.006", "0.11", "0.14"],
            roughness: "0.65",
            mature_radius_m: "0.05",
        }),
    ],
};

/// Fibrous strips along the stem: cypress, redwood, juniper.
pub static FIBROUS: Table = Table {
    name: "Fibrous",
    doc: "Fibrous strips along the stem: cypress, redwood, juniper.",
    groups: &[
        &[part("shreds", "0.4", "How much hangs in loose shreds.")],
        &common(&Usual {
            colours: ["\"#806c5b\"", "\"#3a2c23\"", "\"#8b8278\"", "\"#6c5a40\""],
            metres: ["0.8", "0.012", "0.035", "0.4"],
            roughness: "0.9",
            mature_radius_m: "0.06",
        }),
    ],
};

/// Rings of old leaf scars: palms.
pub static RINGS: Table = Table {
    name: "Rings",
    doc: "Rings of old leaf scars: palms.",
    groups: &[
        &[part(
            "fissures",
            "0.5",
            "Cracks along the stem, from none to many.",
        )],
        &common(&Usual {
            colours: ["\"#8a8378\"", "\"#4a4238\"", "\"#a09584\"", "\"#867d60\""],
            metres: ["0.6", "0.012", "0.016", "0.06"],
            roughness: "0.88",
            mature_radius_m: "0",
        }),
    ],
};

/// Leaf bases in a helical lattice of diamonds: date palm.
pub static LATTICE: Table = Table {
    name: "Lattice",
    doc: "Leaf bases in a helical lattice of diamonds: date palm.",
    groups: &[
        &[part(
            "boots",
            "0.6",
            "How far the leaf bases stand out at their upper end.",
        )],
        &common(&Usual {
            colours: ["\"#807261\"", "\"#302821\"", "\"#988365\"", "\"#867d60\""],
            metres: ["1", "0.05", "0.14", "0.11"],
            roughness: "0.9",
            mature_radius_m: "0",
        }),
    ],
};

/// A bark from an image.
pub static BARK_IMAGE: Table = Table {
    name: "Image",
    doc: "A bark from an image that repeats in both directions.",
    groups: &[&[
        field("path", Path, Fault, "The image."),
        field(
            "height_m",
            Number(REPEAT),
            Fault,
            "Real height of one repeat.",
        ),
        field("young", Colour, Means("\"#8a8068\""), YOUNG),
        field("mature_radius_m", Number(RADIUS), Means("0"), MATURE_RADIUS),
    ]],
};
