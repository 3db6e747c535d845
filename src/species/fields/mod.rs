//! Every field of a script: what it holds, in which unit and range, and what it is when left out.
//!
//! One place for all ranges. The reader takes its checks, its defaults and its lists of valid names
//! from here, so what stands here is what holds. Defaults are written as they would be in a script.
//! Ranges are wide: they refuse what can only be a slip, or what would never finish.

mod barks;
mod blades;
mod leaves;
mod levels;
mod species;

pub use barks::{
    BANDED, BARK_IMAGE, BARKS, FIBROUS, GNARLED, LATTICE, MOSAIC, PAPERY, PLATES, RIDGED, RINGS,
    SMOOTH,
};
pub use blades::{
    BLADE, LOBES, LOOPING_VEINS, MARGIN, MARGINS, PALMATE_LOBES, PALMATE_VEINS, PARALLEL_VEINS,
    PINNATE_LOBES, PINNATE_VEINS, VEINS,
};
pub use leaves::{
    ALTERNATE, ARRANGEMENTS, BIPINNATE, BRUSH, DRAWN_LEAF, FLOWERS, FORMS, LEAF, OPPOSITE,
    PALMATE_LEAF, PINNATE_LEAF, SCALES, SEASON, SEASONS, SPRAY, TISSUES, TUFTS,
};
pub use levels::{
    ANGLE, BRANCH, ENVELOPE, FACTOR_PARTS, FLARE, FLUTES, LEAVES, LEVELS, NOT_FOR_TRUNK,
};
pub use species::{
    CLOSED_FORMS, HABITS, KNOTS, LOD, SELECTORS, SIMPLIFICATIONS, SPECIES, SPLINE, STEMS, VARIATION,
};

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
/// Fitted planes of a closed form.
pub const PLANES: (u64, u64) = (1, 64);

/// Numbers of strips of a node.
pub const STRIPS: (u64, u64) = (1, 4);

/// Numbers of segments of a strip.
pub const SEGMENTS: (u64, u64) = (1, 16);

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

/// All tables, for tests and for whoever prints a reference.
pub static TABLES: &[&Table] = &[
    &SPECIES,
    &VARIATION,
    &STEMS,
    &RIDGED,
    &GNARLED,
    &SMOOTH,
    &PAPERY,
    &BANDED,
    &PLATES,
    &MOSAIC,
    &FIBROUS,
    &RINGS,
    &LATTICE,
    &BARK_IMAGE,
    &SPLINE,
    &LEAF,
    &OPPOSITE,
    &ALTERNATE,
    &BRUSH,
    &TUFTS,
    &SCALES,
    &SPRAY,
    &PINNATE_LEAF,
    &BIPINNATE,
    &PALMATE_LEAF,
    &BLADE,
    &MARGIN,
    &PINNATE_LOBES,
    &PALMATE_LOBES,
    &PINNATE_VEINS,
    &LOOPING_VEINS,
    &PALMATE_VEINS,
    &PARALLEL_VEINS,
    &FLOWERS,
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
    use super::Holds::{Curve, Number};
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
