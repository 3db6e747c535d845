//! `pleach import weber-penn`: the four published trees come out as trees, and no parameter is lost in silence.
#![expect(clippy::unwrap_used, reason = "in a test, a panic is the report")]

mod cli_common;

use cli_common::{pleach as program, utf8};
use pleach::import::weber_penn::import;
use pleach::import::{Imported, Mark};
use pleach::math::Similarity;
use pleach::report::Quiet;
use pleach::species::{self, NoFiles};
use pleach::survey::{self, Measures, Spread};
use pleach::tree::{Kind, Limits, Tree, grow};
use std::path::{Path, PathBuf};

const PUBLISHED: [&str; 4] = [
    "quaking_aspen",
    "black_tupelo",
    "weeping_willow",
    "ca_black_oak",
];

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/weber_penn");
    folder.join(name).with_extension("xml")
}

fn published(name: &str) -> (String, Imported) {
    let text = std::fs::read_to_string(file(name)).unwrap();
    let imported = import(&text).unwrap();
    (text, imported)
}

fn grown(script: &str) -> (species::schema::Species, Tree) {
    let species = species::parse("imported.ron", script, &NoFiles)
        .map_err(|faults| faults.render(false))
        .unwrap();
    let tree = grow(&species, species.seed, &Limits::default()).unwrap();
    (species, tree)
}

/// The trees of nine seeds.
fn measured(name: &str) -> Vec<Measures> {
    let (species, _) = grown(&published(name).1.script);
    let foliage = survey::foliage(&species, &NoFiles).unwrap();
    let seeds: Vec<u64> = (1..=9).collect();
    survey::survey(&species, &foliage, &seeds, &Limits::default(), &Quiet).unwrap()
}

fn median(trees: &[Measures], figure: impl Fn(&Measures) -> f32) -> f32 {
    let figures: Vec<f32> = trees.iter().map(figure).collect();
    Spread::of(&figures).unwrap().median
}

/// A tree of a few parameters.
fn small(more: &str) -> String {
    format!(
        "<arbaro><species name='Small'>
         <param name='Shape' value='0'/><param name='Levels' value='2'/>
         <param name='Scale' value='8'/><param name='Ratio' value='0.02'/>
         {more}</species></arbaro>"
    )
}

#[test]
fn every_parameter_of_the_published_trees_is_named_in_one_note() {
    for name in PUBLISHED {
        let (text, imported) = published(name);
        let mut names: Vec<&str> = text
            .split("param name='")
            .skip(1)
            .map(|rest| rest.split('\'').next().unwrap())
            .collect();
        names.sort_unstable();
        let notes = imported.notes.iter().flat_map(|n| n.parameters.split(", "));
        let mut told: Vec<&str> = notes
            .map(|entry| entry.split(' ').next().unwrap())
            .collect();
        told.sort_unstable();
        assert_eq!(told, names, "{name}");
        for note in &imported.notes {
            assert_ne!(note.mark, Mark::Warning, "{name}: {note}");
            let first = note.text.split_whitespace().next().unwrap();
            assert!(imported.script.contains(first), "{name}: {note}");
        }
    }
}

#[test]
fn the_published_trees_keep_within_sane_numbers_of_cards_and_nodes() {
    for name in PUBLISHED {
        let (_, tree) = grown(&published(name).1.script);
        let nodes = tree.nodes();
        let of = |kind: Kind| -> u64 {
            let levels = tree
                .levels
                .iter()
                .zip(&nodes)
                .filter(|(l, _)| l.kind == kind);
            levels.flat_map(|(_, nodes)| nodes).sum()
        };
        let (cards, branches) = (of(Kind::Leaf), of(Kind::Branch));
        assert!((5_000..45_000).contains(&cards), "{name}: {cards} cards");
        assert!(
            (500..25_000).contains(&branches),
            "{name}: {branches} branches"
        );
    }
}

#[test]
fn the_published_trees_have_the_sizes_that_their_parameters_say() {
    // Scale, a part of it varied; crowns about as wide as the limbs are long, twice.
    for (name, height, width) in [
        ("quaking_aspen", 10.0..18.0, 5.0..11.0),
        ("black_tupelo", 18.0..30.0, 8.0..20.0),
        ("weeping_willow", 9.0..20.0, 8.0..16.0),
        ("ca_black_oak", 6.0..18.0, 8.0..22.0),
    ] {
        let trees = measured(name);
        let high = median(&trees, |m| m.height_m);
        assert!(height.contains(&high), "{name}: {high} m high");
        let wide = median(&trees, |m| m.crown_width_m.unwrap());
        assert!(width.contains(&wide), "{name}: {wide} m wide");
    }
    // 40 % of the aspen's trunk are bare; the willow's leaves hang to the ground, but not through it.
    let bole = median(&measured("quaking_aspen"), |m| m.clear_bole.unwrap());
    assert!((0.3..0.5).contains(&bole), "{bole}");
    let base = median(&measured("weeping_willow"), |m| m.crown_base_m.unwrap());
    assert!((0.2..3.0).contains(&base), "{base}");
}

#[test]
fn the_willow_weeps_and_the_aspen_does_not() {
    let hanging = |name: &str| {
        let (_, tree) = grown(&published(name).1.script);
        let last = tree
            .levels
            .iter()
            .rposition(|l| l.kind == Kind::Branch)
            .unwrap();
        let mut tips = Vec::new();
        directions(&tree, (0, 0), &Similarity::IDENTITY, last, &mut tips);
        let down = tips.iter().filter(|&&y| y < -0.5).count();
        down * 100 / tips.len()
    };
    assert!(
        hanging("weeping_willow") > 70,
        "{} %",
        hanging("weeping_willow")
    );
    assert!(
        hanging("quaking_aspen") < 25,
        "{} %",
        hanging("quaking_aspen")
    );
}

/// Upward parts of the directions in which all branches of a level end.
fn directions(
    tree: &Tree,
    (level, prototype): (usize, usize),
    place: &Similarity,
    wanted: usize,
    tips: &mut Vec<f32>,
) {
    let shared = tree.prototype(level, prototype);
    if let pleach::tree::Part::Branch(branch) = &shared.part
        && level == wanted
    {
        let end = branch.at(1.0).position - branch.at(0.8).position;
        tips.push((place.rotation * end).normalize_or_zero().y);
    }
    for link in &shared.links {
        let child = tree.place(place, link);
        let next = (usize::from(link.level), usize::from(link.prototype));
        directions(tree, next, &child, wanted, tips);
    }
}

#[test]
fn shapes_and_angles_follow_the_models_formulas() {
    let limbs = "<param name='1Branches' value='10'/><param name='1Length' value='0.4'/>
                 <param name='1DownAngle' value='60'/><param name='1DownAngleV' value='-50'/>
                 <param name='BaseSize' value='0.2'/>";
    let script = import(&small(limbs)).unwrap().script;
    let (species, _) = grown(&script);
    let limbs = &species.levels[1].placement;
    assert_eq!((limbs.links, limbs.start), (10, 0.2));
    // Conical: as long as can be at the crown's base, a fifth at the top.
    assert!((limbs.scale.at.at(0.2) - 1.0).abs() < 0.01);
    assert!((limbs.scale.at.at(1.0) - 0.2).abs() < 0.01);
    // 60 - 50 (1 - 2 (0.2 + 0.8 r)): 110 degrees at the base, 30 at the top.
    assert!(
        (limbs.down.at.at(0.2) - 110.0).abs() < 0.6,
        "{:?}",
        limbs.down
    );
    assert!(
        (limbs.down.at.at(1.0) - 30.0).abs() < 0.6,
        "{:?}",
        limbs.down
    );
}

#[test]
fn a_negative_leaf_count_is_a_fan_at_the_tip() {
    let leaves = "<param name='1Branches' value='6'/><param name='Leaves' value='-12'/>";
    let (species, tree) = grown(&import(&small(leaves)).unwrap().script);
    let fan = &species.levels.last().unwrap().placement;
    assert_eq!(fan.links, 12);
    assert!(fan.start > 0.9);
    assert!(fan.down.at.at(fan.start) > 60.0 && fan.down.at.at(1.0) < -60.0);
    assert_eq!(tree.nodes().last().unwrap().iter().sum::<u64>(), 72);
}

#[test]
fn base_splits_become_leaders_that_carry_the_limbs() {
    let splits = "<param name='0BaseSplits' value='2'/><param name='0SplitAngle' value='15'/>
                  <param name='1Branches' value='8'/>";
    let (species, tree) = grown(&import(&small(splits)).unwrap().script);
    let names: Vec<&str> = species.levels.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["trunk", "leaders", "limbs"]);
    assert_eq!(tree.nodes()[1].iter().sum::<u64>(), 3);
    let height = survey::measure(&tree, &[]).height_m;
    assert!((6.0..9.5).contains(&height), "{height}");
}

#[test]
fn extremes_within_the_ranges_still_make_a_tree() {
    for more in [
        "<param name='Leaves' value='1000'/><param name='1Branches' value='300'/>",
        "<param name='0Taper' value='2.9'/><param name='Lobes' value='7'/><param name='LobeDepth' value='1'/>",
        "<param name='1Length' value='0'/><param name='LeafScale' value='0.001'/><param name='Leaves' value='3'/>",
        "<param name='BaseSize' value='1'/><param name='0CurveRes' value='100'/>",
        "<param name='1Rotate' value='-120'/><param name='1RotateV' value='-360'/>",
        "<param name='PruneRatio' value='1'/><param name='PruneWidth' value='0'/>",
        "<param name='0BaseSplits' value='-16'/><param name='AttractionUp' value='-20'/>",
        "<param name='RatioPower' value='10'/><param name='ScaleV' value='150'/>",
        "<param name='1LengthV' value='-10'/><param name='1Length' value='10'/>",
        "<param name='Flare' value='-1'/><param name='1DownAngle' value='360'/><param name='1DownAngleV' value='-360'/>",
    ] {
        grown(&import(&small(more)).unwrap().script);
    }
    for shape in 0..=8 {
        for levels in 1..=4 {
            let text = small("<param name='Leaves' value='5'/>")
                .replace(
                    "name='Shape' value='0'",
                    &format!("name='Shape' value='{shape}'"),
                )
                .replace(
                    "name='Levels' value='2'",
                    &format!("name='Levels' value='{levels}'"),
                );
            grown(&import(&text).unwrap().script);
        }
    }
}

#[test]
fn faults_are_told_with_their_places() {
    let said = |text: &str| -> Vec<String> {
        import(text)
            .unwrap_err()
            .iter()
            .map(ToString::to_string)
            .collect()
    };
    let broken = said("<arbaro>\n  <species name='x'>\n</arbaro>");
    assert_eq!(broken.len(), 1);
    assert!(
        broken[0].starts_with("3:") && broken[0].contains("not XML"),
        "{broken:?}"
    );
    assert!(said("")[0].contains("not XML"));
    let other = said("<svg/>");
    assert!(
        other[0].starts_with("1:1") && other[0].contains("<svg>"),
        "{other:?}"
    );
    let none = said("<arbaro><species name='x'/></arbaro>");
    assert!(none[0].contains("no parameters"), "{none:?}");
    // All faults at once, each with its parameter and its line.
    let values = said(&small(
        "\n<param name='BaseSize' value='3'/>\n<param name='1Length' value='long'/>
         <param name='Leaves'/>",
    ));
    assert!(values[0].contains("needs a name and a value"), "{values:?}");
    let values = said(&small(
        "\n<param name='BaseSize' value='3'/>\n<param name='1Length' value='long'/>
         <param name='Ratio' value='0.1'/><param name='Flare' value='NaN'/>",
    ));
    assert_eq!(values.len(), 4, "{values:?}");
    assert!(
        values[0].starts_with("5:")
            && values[0].contains("BaseSize: 3 is out of range; expected 0 to 1")
    );
    assert!(
        values[1].starts_with("6:")
            && values[1].contains("1Length")
            && values[1].contains("`long`")
    );
    assert!(values[2].contains("Ratio is given twice"));
    assert!(values[3].contains("Flare"));
}

#[test]
fn unknown_and_missing_parameters_are_warnings() {
    let imported = import(
        "<arbaro><species name='x'><param name='Scale' value='9'/><param name='1Lenght' value='1'/>
         <param name='LeafShape' value='heart'/></species></arbaro>",
    )
    .unwrap();
    let warnings: Vec<String> = imported
        .notes
        .iter()
        .filter(|note| note.mark == Mark::Warning)
        .map(ToString::to_string)
        .collect();
    let all = warnings.join("\n");
    for words in [
        "! 1Lenght 1: not known (did you mean 1Length?)",
        "! Shape: not in the file",
        "LeafShape heart: not known",
    ] {
        assert!(all.contains(words), "{words} in:\n{all}");
    }
}

#[test]
fn a_tree_that_is_known_gets_its_botanical_name() {
    let latin = |name: &str| grown(&published(name).1.script).0.latin;
    assert_eq!(latin("quaking_aspen"), "Populus tremuloides");
    assert_eq!(latin("weeping_willow"), "Salix babylonica");
    assert_eq!(latin("black_tupelo"), "", "which the table does not have");
}

#[test]
fn a_name_with_quotes_and_breaks_does_no_harm() {
    let text = small("").replace("name='Small'", "name='a \"b\" \\ &#10; ), x: ('");
    let (species, _) = grown(&import(&text).unwrap().script);
    assert!(species.name.contains("\"b\" \\"), "{}", species.name);
}

#[test]
fn the_command_writes_a_script_that_checks_and_never_over_another() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("aspen.ron");
    let aspen = file("quaking_aspen");
    let import = ["import", "weber-penn", utf8(&aspen), "--out", utf8(&out)];
    program(&import).ends(
        0,
        &["= Scale 13", "~ CurveV".trim_start_matches("~ "), "wrote"],
    );
    program(&["check", utf8(&out)]).ends(0, &["Quaking Aspen is fine"]);
    let script = std::fs::read_to_string(&out).unwrap();
    assert!(script.lines().all(|line| line.len() <= 110), "{script}");
    std::fs::write(&out, "mine").unwrap();
    program(&import).ends(1, &["aspen.ron is there already", "--force"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
    program(&[&import[..], &["--force"]].concat()).ends(0, &[]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), script);
    // Without --out the script is all of stdout.
    assert_eq!(program(&import[..3]).out, script);
    program(&["import", "weber-penn", utf8(&dir.path().join("none.xml"))]).ends(1, &["none.xml"]);
    std::fs::write(&out, "<arbaro>").unwrap();
    program(&["import", "weber-penn", utf8(&out)])
        .ends(1, &["aspen.ron:1:", "not XML", "nothing was made"]);
    program(&["import", "weber-penn"]).ends(2, &["FILE"]);
}
