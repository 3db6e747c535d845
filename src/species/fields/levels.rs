//! Fields of levels and of what belongs to them.

use super::Absent::{Fault, Means, Special};
use super::Holds::{Angle, Curve, Factor, Number, Other, Text, Whole};
use super::{DEGREES, FACTOR, Field, LENGTH, PART, RADIUS, Table, VARY, field, limits};

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
    "skip",
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
            field(
                "skip",
                Curve(limits(0.0, 8.0, "levels")),
                Means("0"),
                "Levels that places skip, by their part of all (0 the first, 1 the last): branches that have not branched as often.",
            ),
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
                "pipe_model",
                Number(PART),
                Means("0"),
                "Part of the taper that follows from what grows on it: 1 keeps the cross-section at forks.",
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
