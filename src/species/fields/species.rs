//! Fields of the whole script, of splines and of the LOD chain.

use super::Absent::{Fault, Means, Special};
use super::Holds::{Angle, Factor, Number, OneOf, Other, Path, Text, Whole};
use super::{FACTOR, Limits, Table, field, limits};

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
            "age",
            Number(AGE),
            Means("1"),
            "Diameter of the trunk as a part of a mature tree's: 0.1 a sapling, 0.4 young, 1 as the levels say, \
             1.3 a veteran.",
        ),
        field(
            "habit",
            OneOf(HABITS),
            Means("Open"),
            "Where it has grown up: Open as the levels say; Forest higher, slimmer, its crown beginning higher.",
        ),
        field(
            "season",
            Other("Spring, Summer, Autumn, Winter or a number from 0 to 3"),
            Means("Summer"),
            "Season; leaves that have an `autumn` turn, thin out from 2.2 on and are gone in winter.",
        ),
        field(
            "variations",
            Other("list of Variation"),
            Means("[]"),
            "Trees of the kind that are worth keeping, by name.",
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

/// Part of a mature tree's diameter.
const AGE: Limits = limits(0.05, 1.5, "");

/// Names of the habits.
pub const HABITS: &[&str] = &["Open", "Forest"];

/// A named variation.
pub static VARIATION: Table = Table {
    name: "Variation",
    doc: "A tree of the kind that is worth keeping.",
    groups: &[&[
        field(
            "name",
            Text,
            Fault,
            "Unique name: a-z, 0-9 and `-`, not first or last.",
        ),
        field("seed", Whole(0, u64::MAX), Fault, "Its seed."),
        field(
            "age",
            Number(AGE),
            Special,
            "Its age; the script's if left out.",
        ),
        field(
            "season",
            Other("Spring, Summer, Autumn, Winter or a number from 0 to 3"),
            Special,
            "Its season; the script's if left out.",
        ),
        field(
            "habit",
            OneOf(HABITS),
            Special,
            "Its habit; the script's if left out.",
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

/// Names of the simplifications.
pub const SIMPLIFICATIONS: &[&str] = &["Splines", "Branches", "Levels"];

/// Names of the selectors.
pub const SELECTORS: &[&str] = &["Cut", "Levels"];

/// Names of the closed forms of a level's nodes.
pub const CLOSED_FORMS: &[&str] = &["Cross", "CrossTop", "StarTop", "Planes", "Strips"];

/// How the LOD chain is made.
pub static LOD: Table = Table {
    name: "Lod",
    doc: "How the chain of LODs is made.",
    groups: &[&[
        field(
            "budgets",
            Other("list of whole numbers"),
            Means("[10000, 2000, 400, 8]"),
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
        field(
            "selector",
            OneOf(SELECTORS),
            Means("Cut"),
            "Cut chooses node by node which are closed to flat forms; Levels goes level by level.",
        ),
        field(
            "calibrate",
            Other("true or false"),
            Means("true"),
            "Whether each LOD's quads are scaled until it covers as much as full detail.",
        ),
        field(
            "forms",
            Other(
                "list of (level, Cross, CrossTop, StarTop, Planes(1 to 64) or \
                 Strips(1 to 4, 1 to 16))",
            ),
            Means("[]"),
            "By branch level, the one closed form that its nodes may take: Cross is two crossed \
             quads, CrossTop adds a level one, StarTop is three upright quads and a level one, \
             Planes(n) is n fitted planes, Strips(n, m) is n strips of m segments that follow \
             the bend of the node's branch. Levels not named may take any.",
        ),
    ]],
};
