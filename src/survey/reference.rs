//! What is known of real trees: a table of 27 species, and figures that hold for most.
//!
//! The table is `reference.ron` beside this file, which says where its figures come from. A script's tree is
//! looked up by the script's `latin` name.

use serde::Deserialize;
use std::sync::LazyLock;

/// What is known of one species. Pairs are (low, high) over mature trees.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Botanical name.
    pub latin: String,
    /// Common name.
    pub common: String,
    /// What kind of tree it is.
    pub group: Group,
    /// Height, metres.
    pub height_m: (f32, f32),
    /// Diameter at breast height, centimetres.
    pub dbh_cm: (f32, f32),
    /// Crown width, metres.
    pub crown_width_m: (f32, f32),
    /// Crown width over height.
    pub crown_over_height: (f32, f32),
    /// Height without live branches over the tree's height.
    pub clear_bole: (f32, f32),
    /// Insertion angles of limbs from the foot to the top of the crown, degrees.
    pub order1_deg: (f32, f32),
    /// Leaves of a tree.
    #[serde(default)]
    pub leaves: Option<(f32, f32)>,
    /// What counts as a leaf there.
    pub leaf_unit: LeafUnit,
    /// Regressions on the diameter.
    #[serde(default)]
    pub fit: Option<Fit>,
    /// Columnar: regressions of other trees' crowns say nothing of it.
    #[serde(default)]
    pub columnar: bool,
    /// Green all year round.
    #[serde(default)]
    pub evergreen: bool,
    /// Figures that were read in no source.
    #[serde(default)]
    pub estimated: Vec<Estimated>,
    /// Where the others come from.
    pub sources: String,
}

/// Kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Group {
    /// Broadleaved trees.
    Broadleaf,
    /// Conifers.
    Conifer,
    /// Palms.
    Palm,
    /// Shrubs.
    Shrub,
}

/// What counts as a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum LeafUnit {
    /// Simple leaves: one blade each.
    Leaves,
    /// Leaves of several leaflets.
    CompoundLeaves,
    /// Needles.
    Needles,
    /// Needles in pairs.
    NeedlePairs,
    /// Sprays of scale leaves.
    Sprays,
    /// Fronds of palms.
    Fronds,
}

impl LeafUnit {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Leaves => "leaves",
            Self::CompoundLeaves => "leaves of several leaflets",
            Self::Needles => "needles",
            Self::NeedlePairs => "pairs of needles",
            Self::Sprays => "sprays of scales",
            Self::Fronds => "fronds",
        }
    }
}

/// Figures that may be estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Estimated {
    /// Insertion angles.
    Angles,
    /// Clear bole.
    Bole,
    /// Crown width over height.
    CrownOverHeight,
    /// Number of leaves.
    Leaves,
}

/// Regressions of one species, or of all of a type.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// What was measured.
    pub of: String,
    /// How many trees.
    pub trees: u32,
    /// Height.
    pub ln_height: LogLog,
    /// Crown width.
    pub ln_crown: LogLog,
    /// Leaf area over crown projection: 10th, 50th and 90th percentile. Only of single species.
    #[serde(default)]
    pub leaf_area_index: Option<(f32, f32, f32)>,
}

/// ln y = a + b ln D, with D the diameter at breast height in centimetres and y in metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct LogLog(
    /// a.
    pub f32,
    /// b.
    pub f32,
    /// Standard deviation of ln y about the line.
    pub f32,
);

impl LogLog {
    /// How many standard deviations `metres` lie above the line at `dbh_cm`.
    #[must_use]
    pub fn deviations(self, dbh_cm: f32, metres: f32) -> f32 {
        let Self(a, b, sd) = self;
        (libm::logf(metres) - (a + b * libm::logf(dbh_cm))) / sd
    }

    /// The line's height at `dbh_cm`, metres.
    #[must_use]
    pub fn metres(self, dbh_cm: f32) -> f32 {
        libm::expf(self.0 + self.1 * libm::logf(dbh_cm))
    }
}

/// The Urban Tree Database's large deciduous broadleaved trees, for species without a fit of their own.
fn large_deciduous() -> Fit {
    Fit {
        of: "large deciduous broadleaved trees".to_owned(),
        trees: 5986,
        ln_height: LogLog(0.452, 0.586, 0.24),
        ln_crown: LogLog(-0.340, 0.722, 0.23),
        leaf_area_index: None,
    }
}

/// The same of large evergreen broadleaved trees.
fn large_evergreen() -> Fit {
    Fit {
        of: "large evergreen broadleaved trees".to_owned(),
        trees: 1119,
        ln_height: LogLog(0.114, 0.613, 0.32),
        ln_crown: LogLog(-0.704, 0.783, 0.31),
        leaf_area_index: None,
    }
}

/// The same of large evergreen conifers.
fn conifers() -> Fit {
    Fit {
        of: "large evergreen conifers".to_owned(),
        trees: 916,
        ln_height: LogLog(-0.057, 0.716, 0.32),
        ln_crown: LogLog(-0.474, 0.685, 0.24),
        leaf_area_index: None,
    }
}

impl Reference {
    /// The species' own regressions, else those of its type. None for palms, whose height says nothing about
    /// their stem's thickness, for shrubs, and for deciduous conifers, of which too few were measured.
    #[must_use]
    pub fn regressions(&self) -> Option<Fit> {
        match (self.group, self.evergreen) {
            (Group::Palm | Group::Shrub, _) => None,
            _ if self.fit.is_some() => self.fit.clone(),
            (Group::Broadleaf, false) => Some(large_deciduous()),
            (Group::Broadleaf, true) => Some(large_evergreen()),
            (Group::Conifer, true) => Some(conifers()),
            (Group::Conifer, false) => None,
        }
    }

    /// True if a figure was judged and read in no source.
    #[must_use]
    pub fn is_estimated(&self, figure: Estimated) -> bool {
        self.estimated.contains(&figure)
    }
}

static TABLE: LazyLock<Result<Vec<Reference>, String>> = LazyLock::new(|| {
    ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
        .from_str(include_str!("reference.ron"))
        .map_err(|e| e.to_string())
});

/// All species of the table.
#[must_use]
pub fn all() -> &'static [Reference] {
    // A slip in the table is shown by a test; a user is better off without it than with a panic.
    TABLE.as_deref().unwrap_or_default()
}

/// What is known of a species by its botanical name, whatever its capitals and spaces.
#[must_use]
pub fn of_latin(latin: &str) -> Option<&'static Reference> {
    let plain = |name: &str| {
        let words: Vec<String> = name.split_whitespace().map(str::to_lowercase).collect();
        words
            .join(" ")
            .replace(['\u{2019}', '\u{2018}'], "'")
            .replace('\u{d7}', "x")
    };
    let wanted = plain(latin);
    all().iter().find(|r| plain(&r.latin) == wanted)
}

/// What is known of a species by its common name, whatever its capitals.
#[must_use]
pub fn of_common(common: &str) -> Option<&'static Reference> {
    all()
        .iter()
        .find(|r| r.common.eq_ignore_ascii_case(common.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_whole_and_its_ranges_rise() {
        assert!(TABLE.is_ok(), "{TABLE:?}");
        assert_eq!(all().len(), 27);
        for species in all() {
            let ranges = [
                species.height_m,
                species.dbh_cm,
                species.crown_width_m,
                species.crown_over_height,
                species.clear_bole,
                species.order1_deg,
            ];
            for (low, high) in ranges.into_iter().chain(species.leaves) {
                assert!(low < high, "{}: {low}..{high}", species.latin);
            }
            if let Some(fit) = &species.fit {
                // Each line passes through trees of the size that the table gives, but for palms.
                let (low, high) = species.height_m;
                let middle = (species.dbh_cm.0 * species.dbh_cm.1).sqrt();
                let height = fit.ln_height.metres(middle);
                let is_near = (low * 0.45..=high * 1.3).contains(&height);
                assert!(
                    is_near || species.group == Group::Palm,
                    "{}: {height}",
                    species.latin
                );
            }
        }
    }

    #[test]
    fn a_species_is_found_however_its_name_is_typed() {
        let found = |name: &str| of_latin(name).map(|r| r.common.as_str());
        assert_eq!(found(" olea  Europaea"), Some("Olive"));
        assert_eq!(
            found("Populus nigra \u{2018}Italica\u{2019}"),
            Some("Lombardy poplar")
        );
        assert_eq!(found("Platanus \u{d7} acerifolia"), Some("London plane"));
        assert_eq!(found("Populus nigra"), None);
        assert_eq!(found(""), None);
    }

    #[test]
    fn deviations_are_counted_from_the_line() {
        let line = LogLog(-0.216, 0.621, 0.194);
        let height = line.metres(59.5);
        assert!((height - 10.19).abs() < 0.05, "{height}");
        assert!(line.deviations(59.5, height).abs() < 1e-4);
        let above = line.deviations(59.5, height * libm::expf(0.388));
        assert!((above - 2.0).abs() < 1e-3, "{above}");
    }
}
