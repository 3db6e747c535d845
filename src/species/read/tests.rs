use super::*;
use crate::math::linear_from_srgb;

use crate::species::fields::BARKS;
use crate::species::files::NoFiles;
use crate::species::schema::{Bark, BarkPattern, Curve, Knots, LevelKind, Lod, Param, Size};

fn read(source: &str) -> Species {
    parse("test.ron", source, &NoFiles).unwrap_or_else(|faults| panic!("{faults}"))
}

const LEAST: &str = r#"(format: 1, name: "Säge 2", splines: [(name: "s", points: [(0,0,0), (0,1,0)])],
    levels: [Branch(name: "trunk", splines: ["s"], length_m: 3, radius_m: 0.2)])"#;

#[test]
fn the_shortest_script_takes_every_default() {
    let species = read(LEAST);
    assert_eq!(species.slug, "s-ge-2");
    assert_eq!((species.seed, species.latin.as_str()), (1, ""));
    assert_eq!(species.lod, Lod::default());
    assert_eq!(species.splines[0].knots, Knots::Centripetal);
    let LevelKind::Branch(branch) = &species.levels[0].kind else {
        panic!("no branch")
    };
    assert_eq!(
        (branch.sides, branch.variants, branch.collar),
        (16, 1, 1.25)
    );
    assert_eq!(branch.taper.points, [(0.0, 1.0), (1.0, 0.15)]);
    assert_eq!(branch.length, Size::Metres(3.0));
    let placement = &species.levels[0].placement;
    assert_eq!(
        (placement.around.step, placement.scale.clone()),
        (137.5, Param::constant(1.0))
    );
}

#[test]
fn every_default_of_every_table_reads_without_a_fault() {
    for table in fields::TABLES {
        for field in table.fields() {
            if let fields::Absent::Means(text) = field.absent {
                let (tree, faults) = syntax::parse(text);
                assert!(
                    tree.is_some() && faults.is_empty(),
                    "{}.{}",
                    table.name,
                    field.name
                );
                assert!(text.parse::<ron::Value>().is_ok(), "{text}");
            }
        }
    }
}

#[test]
fn a_number_where_an_angle_may_be_stands_for_a_fixed_one() {
    let child = |around: &str| {
        let level = format!(
            r#", Branch(name: "limb", splines: [("s", 2)], length_of_parent: 0.5,
                radius_of_parent: 1, down: [(0.5, 60), (1, 30)], scale: Conical{around})])"#
        );
        let mut species = read(&(LEAST.strip_suffix("])").unwrap().to_owned() + &level));
        species.levels.remove(1)
    };
    let level = child("");
    assert_eq!(level.parent, Some(0));
    assert_eq!(
        (
            level.placement.around.step,
            level.placement.around.at.at(0.0)
        ),
        (137.5, 0.0)
    );
    assert_eq!(level.placement.down.at.points, [(0.5, 60.0), (1.0, 30.0)]);
    assert_eq!(level.placement.scale.at.points, [(0.0, 1.0), (1.0, 0.2)]);
    let around = |text: &str| child(text).placement.around;
    assert_eq!(around(", around: 90"), Param::constant(90.0));
    let spiral = Param {
        at: Curve::constant(0.0),
        step: 137.5,
        vary: 20.0,
    };
    assert_eq!(around(", around: (vary: 20)"), spiral);
    assert_eq!(around(", around: (step: 90, at: None)").step, 90.0);
}

#[test]
fn every_bark_is_usual_where_the_script_says_no_more_than_its_name() {
    let mut seen = Vec::new();
    for name in BARKS.iter().filter(|name| **name != "Image") {
        let source = LEAST.replacen("(format", &format!("(bark: {name}, format"), 1);
        let Bark::Drawn(bark) = read(&source).bark else {
            panic!("no drawn bark")
        };
        let pattern = format!("{:?}", bark.pattern);
        assert!(pattern.starts_with(name), "{name} is read as {pattern}");
        // Four parts to a repeat at least, so that it does not show.
        let most = bark.height_m / 2.0;
        assert!(bark.width_m <= most && bark.length_m <= most, "{bark:?}");
        assert!(bark.depth_m < bark.width_m, "{bark:?}");
        assert_eq!((bark.age, bark.lichen, bark.moss), (1.0, 0.0, 0.0));
        seen.push(bark);
    }
    assert_eq!(seen.len(), 10);
}

#[test]
fn a_bark_takes_what_the_script_says() {
    let bark = "Plates(flakes: 0.25, lift: 0.75, width_m: 0.02, age: 0.5, lichen: 0.1, moss: 0.2)";
    let source = LEAST.replacen("(format", &format!("(bark: {bark}, format"), 1);
    let Bark::Drawn(bark) = read(&source).bark else {
        panic!("no drawn bark")
    };
    let (flakes, lift) = (0.25, 0.75);
    assert_eq!(bark.pattern, BarkPattern::Plates { flakes, lift });
    assert_eq!((bark.width_m, bark.age), (0.02, 0.5));
    assert_eq!((bark.lichen, bark.moss), (0.1, 0.2));
}

#[test]
fn colours_become_linear() {
    let source = LEAST.replacen("(format", "(bark: Smooth(light: \"#ff8000\"), format", 1);
    let Bark::Drawn(bark) = read(&source).bark else {
        panic!("no drawn bark")
    };
    assert_eq!(bark.light, [1.0, linear_from_srgb(0x80), 0.0]);
}
