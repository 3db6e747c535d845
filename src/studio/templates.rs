//! Species to begin with: those that are shipped and need no other file.

/// Name and script of each.
pub const ALL: &[(&str, &str)] = &[
    (
        "American elm",
        include_str!("../../species/american_elm.ron"),
    ),
    (
        "Canary date palm",
        include_str!("../../species/canary_date_palm.ron"),
    ),
    (
        "Coast redwood",
        include_str!("../../species/coast_redwood.ron"),
    ),
    (
        "Common hazel",
        include_str!("../../species/common_hazel.ron"),
    ),
    ("English oak", include_str!("../../species/english_oak.ron")),
    (
        "European ash",
        include_str!("../../species/european_ash.ron"),
    ),
    (
        "European beech",
        include_str!("../../species/european_beech.ron"),
    ),
    (
        "European larch",
        include_str!("../../species/european_larch.ron"),
    ),
    (
        "Horse chestnut",
        include_str!("../../species/horse_chestnut.ron"),
    ),
    (
        "Italian cypress",
        include_str!("../../species/italian_cypress.ron"),
    ),
    (
        "Japanese cherry",
        include_str!("../../species/japanese_cherry.ron"),
    ),
    (
        "Japanese maple",
        include_str!("../../species/japanese_maple.ron"),
    ),
    (
        "Lombardy poplar",
        include_str!("../../species/lombardy_poplar.ron"),
    ),
    (
        "London plane",
        include_str!("../../species/london_plane.ron"),
    ),
    (
        "Mexican fan palm",
        include_str!("../../species/mexican_fan_palm.ron"),
    ),
    (
        "Norway maple",
        include_str!("../../species/norway_maple.ron"),
    ),
    (
        "Norway spruce",
        include_str!("../../species/norway_spruce.ron"),
    ),
    ("Olive", include_str!("../../species/olive.ron")),
    (
        "Quaking aspen",
        include_str!("../../species/quaking_aspen.ron"),
    ),
    ("Scots pine", include_str!("../../species/scots_pine.ron")),
    (
        "Silver birch",
        include_str!("../../species/silver_birch.ron"),
    ),
    (
        "Small-leaved lime",
        include_str!("../../species/small_leaved_lime.ron"),
    ),
    ("Stone pine", include_str!("../../species/stone_pine.ron")),
    (
        "Umbrella thorn",
        include_str!("../../species/umbrella_thorn.ron"),
    ),
    (
        "Weeping willow",
        include_str!("../../species/weeping_willow.ron"),
    ),
];

/// The least that grows: a trunk, limbs and leaves.
pub const BLANK: &str = "\
// A species to make your own: a trunk, limbs that leave it, and leaves on them.
(
    format: 1,
    name: \"My tree\",
    seed: 1,

    splines: [
        (name: \"trunk\", points: [(0, 0, 0), (0.1, 1, 0), (-0.05, 2, 0.05), (0, 3, 0)]),
        (name: \"limb\", points: [(0, 0, 0), (0.1, 1, 0.1), (0, 2, 0.4)]),
    ],

    leaves: [
        (name: \"shoot\", length_m: 0.3, width_m: 0.25, arrangement: Alternate(count: 7)),
    ],

    levels: [
        Branch(name: \"trunk\", length_m: 6, radius_m: 0.14, splines: [\"trunk\"]),
        Branch(
            name: \"limbs\", links: 18, start: 0.3, splines: [\"limb\"],
            down: (at: [(0.3, 70), (1, 25)], vary: 10),
            length_of_parent: 0.45, radius_of_parent: 0.45,
            scale: (at: [(0.3, 1), (1, 0.4)], vary: 0.15),
        ),
        Leaves(name: \"leaves\", links: 26, start: 0.2, kinds: [\"shoot\"], down: (at: 50, vary: 15)),
    ],
)
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, NoFiles};

    #[test]
    fn every_template_is_sound_and_called_what_the_menu_says() {
        for (name, text) in ALL {
            let species = species::parse(name, text, &NoFiles);
            let species = species.unwrap_or_else(|faults| panic!("{}", faults.render(false)));
            assert_eq!(species.name, *name);
        }
        let blank = species::parse("blank", BLANK, &NoFiles);
        assert!(blank.is_ok(), "{}", blank.unwrap_err().render(false));
    }
}
