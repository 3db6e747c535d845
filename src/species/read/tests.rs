use super::*;
use crate::math::linear_from_srgb;
use crate::species::files::NoFiles;
use crate::species::schema::{Curve, Knots, LevelKind, Lod, Param, Size};

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
fn colours_become_linear() {
    let source = LEAST.replacen("(format", "(bark: Smooth(light: \"#ff8000\"), format", 1);
    let super::super::schema::Bark::Drawn(bark) = read(&source).bark else {
        panic!("no drawn bark")
    };
    assert_eq!(bark.light, [1.0, linear_from_srgb(0x80), 0.0]);
}
