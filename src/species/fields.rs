//! Every field of a script: what it holds, in which unit and range, and what it is when left out.
//!
//! One place for all ranges. The reader takes its checks, its defaults and its lists of valid names
//! from here, so what stands here is what holds. Defaults are written as they would be in a script.
//! Ranges are wide: they refuse what can only be a slip, or what would never finish.

/// Fields of one kind of struct.
#[derive(Debug)]
pub struct Table {
    /// Name in reports and, for variants, in scripts.
    pub name: &'static str,
    /// What it stands for.
    pub doc: &'static str,
    /// Its fields, in groups that several tables may share.
    pub groups: &'static [&'static [Field]],
}

/// One field.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Name in the script.
    pub name: &'static str,
    /// What it holds.
    pub holds: Holds,
    /// Whether it may be left out.
    pub absent: Absent,
    /// What it means.
    pub doc: &'static str,
}

/// A field that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// Is a fault.
    Fault,
    /// Means this, in the script's own words.
    Means(&'static str),
    /// Has a meaning of its own, told in the field's `doc`.
    Special,
}

/// What a field holds.
#[derive(Clone, Copy, Debug)]
pub enum Holds {
    /// A number.
    Number(Limits),
    /// A whole number.
    Whole(u64, u64),
    /// An angle that may depend on the place, the link and chance, degrees.
    Angle(Limits),
    /// A factor that may depend on the place and on chance.
    Factor(Limits),
    /// A function of a position in 0..=1.
    Curve(Limits),
    /// Text.
    Text,
    /// A colour, `"#rrggbb"`, sRGB.
    Colour,
    /// A file beside the script.
    Path,
    /// One of some names.
    OneOf(&'static [&'static str]),
    /// Something with fields or items of its own, in words.
    Other(&'static str),
}

/// Range of a number, ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Smallest.
    pub min: f32,
    /// Largest.
    pub max: f32,
    /// Unit in words; empty for a bare number.
    pub unit: &'static str,
}

impl Table {
    /// All fields.
    pub fn fields(&self) -> impl Iterator<Item = &'static Field> {
        self.groups.iter().flat_map(|group| group.iter())
    }

    /// A field by name.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&'static Field> {
        self.fields().find(|field| field.name == name)
    }
}

const fn field(name: &'static str, holds: Holds, absent: Absent, doc: &'static str) -> Field {
    Field {
        name,
        holds,
        absent,
        doc,
    }
}

const fn limits(min: f32, max: f32, unit: &'static str) -> Limits {
    Limits { min, max, unit }
}

use Absent::{Fault, Means, Special};
use Holds::{Angle, Colour, Curve, Factor, Number, OneOf, Other, Path, Text, Whole};

/// Lengths of branches, and what else is as large: a millimetre to more than the tallest tree.
const LENGTH: Limits = limits(0.001, 200.0, "metres");
/// Radii: a tenth of a millimetre to a thick baobab.
const RADIUS: Limits = limits(0.0001, 20.0, "metres");
/// Leaf cards.
const CARD: Limits = limits(0.001, 20.0, "metres");
/// Two turns either way.
const DEGREES: Limits = limits(-720.0, 720.0, "degrees");
/// Factors that must not make things vanish.
const FACTOR: Limits = limits(0.001, 100.0, "");
/// A part of a whole.
const PART: Limits = limits(0.0, 1.0, "");
/// Random part of a size: below 1, so that no size reaches zero.
const VARY: Limits = limits(0.0, 0.95, "");
/// Coordinates of control points, in any unit.
pub const COORDINATE: Limits = limits(-100_000.0, 100_000.0, "");
/// Weights of splines and leaf kinds.
pub const WEIGHT: Limits = limits(0.0, 1_000_000.0, "");
/// Positions of a curve.
pub const POSITION: Limits = PART;
/// Spline tolerances.
pub const TOLERANCE: Limits = limits(0.000_01, 1.0, "of the branch's length");
/// Triangles of a budget: the smallest form, one cross-quad, has four.
pub const BUDGET: (u64, u64) = (4, 1_000_000_000);

/// Most levels of a species.
pub const MAX_LEVELS: usize = 16;
/// Most budgets of a chain.
pub const MAX_BUDGETS: usize = 16;
/// Most spline tolerances, and so geometry LODs.
pub const MAX_TOLERANCES: usize = 8;
/// Most points of a curve.
pub const MAX_CURVE_POINTS: usize = 256;
/// Most control points of a spline.
pub const MAX_SPLINE_POINTS: usize = 4096;
/// Most named splines, and most named leaf kinds.
pub const MAX_NAMED: usize = 256;
/// Most characters of a name.
pub const MAX_NAME: usize = 100;
/// Most links that all prototypes of a species may hold together (each takes some hundred bytes).
pub const MAX_LINKS: u64 = 4_000_000;
/// Most nodes of one level: what a 64-bit float still counts exactly, with room to spare.
pub const MAX_NODES: u64 = 1_000_000_000_000_000;

/// A whole script.
pub static SPECIES: Table = Table {
    name: "Species",
    doc: "One species: a tree as a list of branching levels.",
    groups: &[&[
        field(
            "format",
            Whole(0, u32::MAX as u64),
            Fault,
            "Version of the script language.",
        ),
        field("name", Text, Fault, "Common name."),
        field("latin", Text, Means("\"\""), "Botanical name."),
        field(
            "slug",
            Text,
            Special,
            "Name for files: a-z, 0-9 and `-`. Made from `name` if left out.",
        ),
        field(
            "seed",
            Whole(0, u64::MAX),
            Means("1"),
            "Seed used when none is given elsewhere.",
        ),
        field(
            "stems",
            Other("Stems"),
            Special,
            "Several stems out of one stool; one trunk if left out.",
        ),
        field(
            "bark",
            Other("Bark"),
            Means("Ridged"),
            "Bark of all branches.",
        ),
        field(
            "splines",
            Other("list of Spline"),
            Fault,
            "Named shapes of branches.",
        ),
        field(
            "leaves",
            Other("list of Leaf"),
            Means("[]"),
            "Named leaf kinds.",
        ),
        field(
            "levels",
            Other("list of Branch and Leaves"),
            Fault,
            "Branching levels, the trunk first.",
        ),
        field(
            "lod",
            Other("Lod"),
            Means("()"),
            "How the chain of LODs is made.",
        ),
    ]],
};

/// Stems of a multi-stemmed tree.
pub static STEMS: Table = Table {
    name: "Stems",
    doc: "Several stems out of one stool.",
    groups: &[&[
        field("count", Whole(1, 64), Fault, "How many stems."),
        field(
            "spread_m",
            Number(limits(0.0, 50.0, "metres")),
            Means("0.3"),
            "Radius of the ring they stand on.",
        ),
        field(
            "lean",
            Angle(limits(-90.0, 90.0, "degrees")),
            Means("0"),
            "Lean outward from the vertical; position 0 is the first stem, 1 the last.",
        ),
        field("scale", Factor(FACTOR), Means("1"), "Size of each stem."),
    ]],
};

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

/// Names of the spline parametrisations.
pub const KNOTS: &[&str] = &["Centripetal", "Uniform", "Chordal"];

/// A named spline.
pub static SPLINE: Table = Table {
    name: "Spline",
    doc: "A named shape of a branch; its size does not matter, only its form.",
    groups: &[&[
        field("name", Text, Fault, "Unique name."),
        field(
            "points",
            Other("list of (x, y, z)"),
            Special,
            "Two control points or more, mainly along +y; this or `file`.",
        ),
        field(
            "file",
            Path,
            Special,
            "Text file with one control point a line; this or `points`.",
        ),
        field(
            "knots",
            OneOf(KNOTS),
            Special,
            "Parametrisation; Centripetal if neither this nor the file says.",
        ),
    ]],
};

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

/// Names of the kinds of level.
pub const LEVELS: &[&str] = &["Branch", "Leaves"];

/// Where the nodes of a level sit on their parents.
const PLACEMENT: &[Field] = &[
    field(
        "name",
        Text,
        Fault,
        "Unique name; also the key of its random draws.",
    ),
    field(
        "on",
        Text,
        Special,
        "Level whose branches carry it; the level before if left out.",
    ),
    field(
        "links",
        Whole(1, 10_000),
        Means("1"),
        "Places along each parent at which children grow.",
    ),
    field(
        "children",
        Whole(1, 64),
        Means("1"),
        "Children at each place: 1 spiral, 2 opposite, more a whorl.",
    ),
    field(
        "start",
        Number(PART),
        Means("0"),
        "First position on the parent.",
    ),
    field(
        "end",
        Number(PART),
        Means("1"),
        "Last position on the parent.",
    ),
    field(
        "jitter",
        Number(PART),
        Means("0"),
        "Random shift of each place, as a part of the distance between places.",
    ),
    field(
        "crowding",
        Number(limits(0.05, 20.0, "")),
        Means("1"),
        "1 spaces evenly, less crowds towards the end.",
    ),
    field(
        "around",
        Angle(DEGREES),
        Means("(step: 137.5)"),
        "Turn about the parent's axis.",
    ),
    field(
        "down",
        Angle(DEGREES),
        Means("0"),
        "Angle away from the parent's axis.",
    ),
    field("sideways", Angle(DEGREES), Means("0"), "Sideways tilt."),
    field(
        "spin",
        Angle(DEGREES),
        Means("0"),
        "Turn about the child's own axis.",
    ),
    field(
        "scale",
        Factor(FACTOR),
        Means("1"),
        "Size of the child with all that grows on it.",
    ),
    field(
        "thickness",
        Factor(FACTOR),
        Means("1"),
        "Thickness of the child's own tube.",
    ),
    field(
        "tropism",
        Number(limits(-1.0, 1.0, "")),
        Means("0"),
        "Rigid turn towards the sky (1) or the ground (-1).",
    ),
    field(
        "envelope",
        Other("Envelope"),
        Special,
        "A shape that the tips stay within; none if left out.",
    ),
];

/// Fields of the trunk that concern its place on a parent, and so mean nothing.
pub const NOT_FOR_TRUNK: &[&str] = &[
    "on",
    "links",
    "children",
    "start",
    "end",
    "jitter",
    "crowding",
    "down",
    "sideways",
    "spin",
    "thickness",
    "tropism",
    "envelope",
    "length_of_parent",
    "radius_of_parent",
];

/// A level of branches.
pub static BRANCH: Table = Table {
    name: "Branch",
    doc: "A level of branches.",
    groups: &[
        PLACEMENT,
        &[
            field("variants", Whole(1, 16), Means("1"), "Distinct prototypes."),
            field(
                "splines",
                Other("list of names, or (name, weight)"),
                Fault,
                "Shapes to choose from.",
            ),
            field(
                "length_m",
                Number(LENGTH),
                Special,
                "Length; this or `length_of_parent`.",
            ),
            field(
                "length_of_parent",
                Number(limits(0.001, 100.0, "times the parent's length")),
                Special,
                "Length relative to the parent's.",
            ),
            field(
                "length_vary",
                Number(VARY),
                Means("0"),
                "Random part of the length.",
            ),
            field(
                "radius_m",
                Number(RADIUS),
                Special,
                "Radius at the base; this or `radius_of_parent`.",
            ),
            field(
                "radius_of_parent",
                Number(limits(0.001, 2.0, "times the parent's radius")),
                Special,
                "Radius relative to the parent's where the branch leaves it.",
            ),
            field(
                "taper",
                Curve(limits(0.0, 10.0, "")),
                Means("[(0, 1), (1, 0.15)]"),
                "Radius along the branch, as a factor of the base radius.",
            ),
            field(
                "gnarl",
                Number(PART),
                Means("0"),
                "Sideways wander of the control points, as a part of the length.",
            ),
            field(
                "collar",
                Number(limits(1.0, 4.0, "")),
                Means("1.25"),
                "Widening where it leaves its parent.",
            ),
            field(
                "flare",
                Other("Flare"),
                Special,
                "Root flare; none if left out.",
            ),
            field(
                "flutes",
                Other("Flutes"),
                Special,
                "Lengthwise lobes; none if left out.",
            ),
            field(
                "sides",
                Whole(3, 256),
                Special,
                "Corners of the cross-section; 16, 10, 6, then 4 by depth if left out.",
            ),
        ],
    ],
};

/// A level of leaves.
pub static LEAVES: Table = Table {
    name: "Leaves",
    doc: "A level of leaf cards.",
    groups: &[
        PLACEMENT,
        &[field(
            "kinds",
            Other("list of names, or (name, weight)"),
            Fault,
            "Leaf kinds to choose from.",
        )],
    ],
};

/// A crown envelope.
pub static ENVELOPE: Table = Table {
    name: "Envelope",
    doc: "A surface of revolution that the tips of a level stay within.",
    groups: &[&[
        field("height_m", Number(LENGTH), Fault, "Height of its top."),
        field(
            "radius_m",
            Curve(limits(0.0, 200.0, "metres")),
            Fault,
            "Radius by height: 0 the ground, 1 the top.",
        ),
    ]],
};

/// A root flare.
pub static FLARE: Table = Table {
    name: "Flare",
    doc: "Widening at the foot of a trunk.",
    groups: &[&[
        field(
            "height_m",
            Number(limits(0.001, 50.0, "metres")),
            Fault,
            "Height over which it fades.",
        ),
        field(
            "amount",
            Number(limits(0.0, 10.0, "")),
            Means("0.5"),
            "Extra radius at the ground, as a factor.",
        ),
        field(
            "lobes",
            Whole(0, 64),
            Means("0"),
            "Buttresses around the foot; 0 is round.",
        ),
        field(
            "depth",
            Number(PART),
            Means("0"),
            "Depth of the buttresses.",
        ),
    ]],
};

/// Flutes of a stem.
pub static FLUTES: Table = Table {
    name: "Flutes",
    doc: "Lengthwise lobes of a stem.",
    groups: &[&[
        field("count", Whole(1, 64), Fault, "How many around the stem."),
        field(
            "depth",
            Number(limits(0.0, 0.5, "")),
            Means("0.1"),
            "Depth, as a part of the radius.",
        ),
        field(
            "twist_turns",
            Number(limits(-20.0, 20.0, "turns")),
            Means("0"),
            "Turns about the axis over the length.",
        ),
    ]],
};

/// Names of the simplifications.
pub const SIMPLIFICATIONS: &[&str] = &["Splines", "Branches", "Levels"];

/// How the LOD chain is made.
pub static LOD: Table = Table {
    name: "Lod",
    doc: "How the chain of LODs is made.",
    groups: &[&[
        field(
            "budgets",
            Other("list of whole numbers"),
            Means("[10000, 2000, 400, 4]"),
            "Triangle budgets, falling.",
        ),
        field(
            "priorities",
            Other("list of Splines, Branches, Levels"),
            Means("[Splines, Branches, Levels]"),
            "Order in which simplifications are tried.",
        ),
        field(
            "tolerances",
            Other("list of numbers"),
            Means("[0.004, 0.01, 0.025, 0.06, 0.15]"),
            "Spline tolerances, as parts of the branch's length, rising.",
        ),
    ]],
};

/// An angle with all its parts.
pub static ANGLE: Table = Table {
    name: "Angle",
    doc: "An angle: `at + step * link + vary * random`.",
    groups: &[&[
        field(
            "at",
            Curve(DEGREES),
            Means("0"),
            "By position on the parent.",
        ),
        field(
            "step",
            Number(DEGREES),
            Special,
            "Added once more for each link. Left out: 137.5 for `around`, else 0.",
        ),
        field(
            "vary",
            Number(limits(0.0, 360.0, "degrees")),
            Means("0"),
            "Random part, either way.",
        ),
    ]],
};

/// A factor with all its parts.
pub static FACTOR_PARTS: Table = Table {
    name: "Factor",
    doc: "A factor: `at * (1 + vary * random)`.",
    groups: &[&[
        field(
            "at",
            Curve(FACTOR),
            Means("1"),
            "By position on the parent.",
        ),
        field("vary", Number(VARY), Means("0"), "Random part, either way."),
    ]],
};

/// All tables, for tests and for whoever prints a reference.
pub static TABLES: &[&Table] = &[
    &SPECIES,
    &STEMS,
    &BARK,
    &BARK_IMAGE,
    &SPLINE,
    &LEAF,
    &OPPOSITE,
    &ALTERNATE,
    &BLADE,
    &BRANCH,
    &LEAVES,
    &ENVELOPE,
    &FLARE,
    &FLUTES,
    &LOD,
    &ANGLE,
    &FACTOR_PARTS,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_names_each_field_once_and_says_what_it_means() {
        for table in TABLES {
            let names: Vec<_> = table.fields().map(|field| field.name).collect();
            let mut unique = names.clone();
            unique.sort_unstable();
            unique.dedup();
            assert_eq!(names.len(), unique.len(), "{}", table.name);
            assert!(
                table.fields().all(|field| field.doc.ends_with('.')),
                "{}",
                table.name
            );
        }
    }

    #[test]
    fn lengths_angles_and_times_carry_their_unit() {
        for field in TABLES.iter().flat_map(|table| table.fields()) {
            if let Number(limits) | Curve(limits) = field.holds {
                assert_eq!(
                    field.name.ends_with("_m"),
                    limits.unit == "metres",
                    "{}",
                    field.name
                );
            }
        }
    }

    #[test]
    fn what_the_trunk_may_not_have_are_fields_of_a_branch() {
        assert!(
            NOT_FOR_TRUNK
                .iter()
                .all(|name| BRANCH.field(name).is_some())
        );
    }
}
