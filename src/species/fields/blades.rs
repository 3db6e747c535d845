//! Fields of a leaf blade.

use super::Absent::{Fault, Means};
use super::Holds::{Number, Other, Whole};
use super::leaves::{AWAY, SPREAD};
use super::{Limits, PART, Table, field, limits};

/// Names of the kinds of lobes.
pub const LOBES: &[&str] = &["None", "Pinnate", "Palmate"];
/// Names of the margins.
pub const MARGINS: &[&str] = &[
    "Entire",
    "Serrate",
    "DoublySerrate",
    "Crenate",
    "Dentate",
    "Wavy",
];
/// Names of the kinds of veins.
pub const VEINS: &[&str] = &["Midrib", "Pinnate", "Looping", "Palmate", "Parallel"];
/// Shifts of a shape either way.
const EITHER_WAY: Limits = limits(-1.0, 1.0, "");

/// Outline, margin and veins of one blade.
pub static BLADE: Table = Table {
    name: "Blade",
    doc: "Outline, margin and veins of one blade.",
    groups: &[&[
        field(
            "width",
            Number(limits(0.005, 5.0, "")),
            Means("0.5"),
            "Greatest width over length; a single blade fills its card instead.",
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
        field(
            "base",
            Number(EITHER_WAY),
            Means("0"),
            "Below 0 heart-shaped, above 0 drawn out into a wedge.",
        ),
        field(
            "tip",
            Number(EITHER_WAY),
            Means("0"),
            "Below 0 notched, above 0 drawn out to a point.",
        ),
        field(
            "oblique",
            Number(PART),
            Means("0"),
            "How much lower one half begins than the other.",
        ),
        field(
            "auricles",
            Number(PART),
            Means("0"),
            "Size of two ears at the foot.",
        ),
        field(
            "lobes",
            Other("None, Pinnate or Palmate"),
            Means("None"),
            "Lobes along the sides, or spread from the foot.",
        ),
        field(
            "margin",
            Other("Margin"),
            Means("Entire"),
            "Teeth: Entire, Serrate, DoublySerrate, Crenate, Dentate or Wavy.",
        ),
        field(
            "veins",
            Other("Veins"),
            Means("Pinnate()"),
            "Veins: Midrib, Pinnate, Looping, Palmate or Parallel.",
        ),
    ]],
};

/// Teeth of a blade.
pub static MARGIN: Table = Table {
    name: "Margin",
    doc: "Teeth of a blade.",
    groups: &[&[
        field(
            "teeth",
            Whole(1, 400),
            Fault,
            "Teeth on each side of the blade.",
        ),
        field(
            "depth",
            Number(PART),
            Means("0.08"),
            "Depth of the teeth, as a part of the half width.",
        ),
    ]],
};

/// Lobes along both sides of a blade.
pub static PINNATE_LOBES: Table = Table {
    name: "Pinnate",
    doc: "Lobes along both sides of a blade.",
    groups: &[&[
        field(
            "pairs",
            Whole(1, 40),
            Fault,
            "Pairs of lobes below the end lobe.",
        ),
        field(
            "depth",
            Number(PART),
            Means("0.45"),
            "Depth of the cuts, as a part of the half width.",
        ),
        field("sharp", Number(PART), Means("0"), "0 rounded, 1 pointed."),
    ]],
};

/// Lobes that spread from the foot of a blade; `widest` and `sharpness` are a lobe's.
pub static PALMATE_LOBES: Table = Table {
    name: "Palmate",
    doc: "Lobes that spread from the foot of a blade; `widest` and `sharpness` are a lobe's.",
    groups: &[&[
        field("count", Whole(2, 15), Fault, "Lobes."),
        field(
            "spread_deg",
            Number(SPREAD),
            Means("180"),
            "Angle between the outermost.",
        ),
        field(
            "depth",
            Number(PART),
            Means("0.5"),
            "Depth of the cuts, as a part of the way from tip to foot.",
        ),
        field(
            "outer",
            Number(limits(0.05, 1.0, "")),
            Means("0.6"),
            "Length of the outermost, as a part of the middle one's.",
        ),
    ]],
};

/// Side veins that run out into the margin.
pub static PINNATE_VEINS: Table = Table {
    name: "Pinnate",
    doc: "Side veins that run out into the margin.",
    groups: &[&[
        field(
            "pairs",
            Whole(0, 100),
            Means("6"),
            "Side veins on each side.",
        ),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a side vein from the midrib.",
        ),
    ]],
};

/// Side veins that bend round inside the margin and join.
pub static LOOPING_VEINS: Table = Table {
    name: "Looping",
    doc: "Side veins that bend round inside the margin and join.",
    groups: &[&[
        field(
            "pairs",
            Whole(0, 100),
            Means("6"),
            "Side veins on each side.",
        ),
        field(
            "angle_deg",
            Number(AWAY),
            Means("50"),
            "Angle of a side vein from the midrib.",
        ),
    ]],
};

/// Several main veins from the foot.
pub static PALMATE_VEINS: Table = Table {
    name: "Palmate",
    doc: "Several main veins from the foot.",
    groups: &[&[
        field(
            "count",
            Whole(1, 15),
            Means("5"),
            "Main veins; a palmately lobed blade has one in each lobe.",
        ),
        field(
            "pairs",
            Whole(0, 100),
            Means("3"),
            "Side veins on each side of the middle one.",
        ),
    ]],
};

/// Veins beside the midrib from base to tip.
pub static PARALLEL_VEINS: Table = Table {
    name: "Parallel",
    doc: "Veins beside the midrib from base to tip.",
    groups: &[&[field(
        "count",
        Whole(0, 100),
        Means("4"),
        "Veins on each side.",
    )]],
};
