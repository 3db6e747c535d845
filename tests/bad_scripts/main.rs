//! Scripts with faults: every fault is told at once, at its place, in words that help.

mod levels;

use std::path::Path;

use pleach::species::schema::{ClosedForm, LodSelector};
use pleach::species::{self, Beside, Faults, Files, NoFiles};
use proptest::prelude::*;

/// Spline files by name, in memory.
struct Shelf(&'static [(&'static str, &'static str)]);

impl Files for Shelf {
    fn read_text(&self, path: &str) -> Result<String, String> {
        let found = self.0.iter().find(|(name, _)| *name == path);
        found.map_or_else(
            || Err(format!("no such file `{path}`; looked on the shelf")),
            |(_, text)| Ok((*text).to_owned()),
        )
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read_text(path).map(String::into_bytes)
    }

    fn exists(&self, path: &str) -> Result<(), String> {
        self.read_text(path).map(drop)
    }
}

/// A script that is right, with all its parts.
const GOOD: &str = r##"(
  format: 1, name: "Olive", latin: "Olea europaea", slug: "olive", seed: 12,
  stems: (count: 3, spread_m: 0.3, lean: (at: [(0, 5), (1, 12)], vary: 3), scale: (at: 1, vary: 0.1)),
  bark: Gnarled(light: "#8a8378", dark: "#2b2621", height_m: 0.6, depth_m: 0.02),
  splines: [
    (name: "trunk", points: [(0, 0, 0), (0.1, 1, 0), (0, 2, 0.1)], knots: Centripetal),
    (name: "limb", file: "limb.spline"),
  ],
  leaves: [
    (name: "sprig", length_m: 0.16, width_m: 0.07, fold_deg: 20,
     arrangement: Opposite(pairs: 6, angle_deg: 50, blade: 0.35),
     blade: (width: 0.2, widest: 0.5, sharpness: 0.7, margin: Entire, veins: Pinnate(pairs: 6)),
     colour: "#455f34", colour_vary: 0.12, stalk_colour: "#6b5b43", gloss: 0.4, translucency: 0.2),
    (name: "photo", length_m: 0.1, width_m: 0.05, image: "leaf.png"),
  ],
  levels: [
    Branch(name: "trunk", length_m: 2.2, radius_m: 0.25, splines: ["trunk"],
           taper: [(0, 1), (1, 0.6)], gnarl: 0.05, sides: 16,
           flare: (height_m: 0.5, amount: 0.8, lobes: 5, depth: 0.4),
           flutes: (count: 6, depth: 0.15, twist_turns: 0.3)),
    Branch(name: "limbs", links: 5, children: 1, start: 0.5, end: 1.0,
           around: (step: 137.5, vary: 20), down: (at: [(0.5, 60), (1, 30)], vary: 8),
           length_of_parent: 0.9, length_vary: 0.1, radius_of_parent: 0.7,
           splines: [("limb", 2.0), "trunk"], variants: 1, tropism: 0.2,
           scale: (at: [(0, 1), (1, 0.7)], vary: 0.1), thickness: 1, collar: 1.3, sides: 10,
           envelope: (height_m: 8, radius_m: [(0.2, 2), (0.6, 4), (1, 1)])),
    Leaves(name: "sprigs", on: "limbs", links: 8, children: 2, kinds: [("sprig", 3), "photo"],
           around: (step: 90, vary: 10), down: 50, spin: 0),
    Branch(name: "roots", on: "trunk", end: 0.02, down: 100, links: 2, children: 4,
           length_m: 1.5, radius_m: 0.06, splines: ["limb"], scale: Flame),
  ],
  lod: (budgets: [10000, 2000, 400, 4], priorities: [Splines, Branches, Levels],
        tolerances: [0.004, 0.01, 0.025, 0.06, 0.15], selector: Cut, calibrate: true,
        forms: [("trunk", StarTop), ("limbs", Planes(8))]),
)"##;

const SHELF: Shelf = Shelf(&[
    ("limb.spline", "knots chordal\n0 0 0\n0.2 1 0\n"),
    ("bad.spline", "# limb\n0 0 0\n  0 1,5 0\n1 2\n"),
    ("leaf.png", ""),
]);

/// Faults of a script, if it has any.
fn faults(source: &str) -> Option<Faults> {
    species::parse("t.ron", source, &SHELF).err()
}

/// Faults of the good script after one part of it was replaced.
fn after(part: &str, with: &str) -> String {
    assert!(GOOD.contains(part), "`{part}` is not in the script");
    let faults = faults(&GOOD.replacen(part, with, 1));
    faults.map(|faults| faults.to_string()).unwrap_or_default()
}

/// Asserts one fault only, which holds all of some words.
#[track_caller]
fn one_fault(part: &str, with: &str, words: &[&str]) {
    let report = after(part, with);
    let blocks = report.lines().filter(|line| !line.starts_with(' ')).count();
    assert_eq!(blocks, 1, "{with}:\n{report}");
    for word in words {
        assert!(report.contains(word), "no `{word}` in:\n{report}");
    }
}

#[test]
fn ages_habits_and_variations_are_checked() {
    let with = |more: &str| after("format: 1,", &format!("format: 1, {more},"));
    let told = |more: &str, words: &[&str]| {
        let report = with(more);
        for word in words {
            assert!(report.contains(word), "no `{word}` in:\n{report}");
        }
    };
    assert_eq!(
        with("age: 0.3, habit: Forest, variations: [(name: \"a-1\", seed: 2)]"),
        ""
    );
    told("age: 0", &["age", "out of range", "0.05 to 1.5"]);
    told(
        "habit: Wood",
        &["habit", "unknown name `Wood`", "Open, Forest"],
    );
    told(
        "variations: [(name: \"Old one\", seed: 1)]",
        &["variations[0].name", "a-z, 0-9"],
    );
    told("variations: [(name: \"a\")]", &["missing field `seed`"]);
    told(
        "variations: [(name: \"a\", seed: 1), (name: \"a\", seed: 2)]",
        &["variations[1].name", "another variation named `a`"],
    );
    told(
        "variations: [(name: \"a\", seed: 1, age: 2)]",
        &["variations[0].age", "out of range"],
    );
    told(
        "season: Fall",
        &["season", "Spring, Summer, Autumn, Winter"],
    );
    told("season: 4", &["season", "out of range", "0 to 3"]);
    told("variations: 3", &["expected a list of variations"]);
}

#[test]
fn a_good_script_has_no_fault() {
    let species = species::parse("t.ron", GOOD, &SHELF);
    let species = species.unwrap_or_else(|faults| panic!("{faults}"));
    assert!(GOOD.parse::<ron::Value>().is_ok(), "it is RON");
    let parents: Vec<_> = species.levels.iter().map(|level| level.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(0)]);
    assert_eq!(species.splines[1].knots, species::schema::Knots::Chordal);
    let forms = [
        ("trunk".to_owned(), ClosedForm::StarTop),
        ("limbs".to_owned(), ClosedForm::Planes(8)),
    ];
    assert_eq!(species.lod.forms, forms);
    let other = GOOD.replace("Cut, calibrate: true", "Levels, calibrate: false");
    let lod = species::parse("t.ron", &other, &SHELF).unwrap().lod;
    assert_eq!((lod.selector, lod.calibrate), (LodSelector::Levels, false));
}

#[test]
fn names_that_are_unknown_are_told_with_the_nearest() {
    one_fault(
        "gnarl: 0.05",
        "gnral: 0.05",
        &[
            "levels[0].gnral",
            "unknown field",
            "did you mean `gnarl`?",
            "collar",
        ],
    );
    one_fault(
        "length_m: 2.2",
        "length: 2.2",
        &["did you mean `length_m`?"],
    );
    one_fault(
        "Leaves(name",
        "Leafs(name",
        &["levels[2]: unknown kind of level", "did you mean `Leaves`?"],
    );
    one_fault(
        "on: \"limbs\"",
        "on: \"limb\"",
        &["levels[2].on", "no level is named `limb`", "`limbs`"],
    );
    one_fault(
        "(\"limb\", 2.0)",
        "(\"linb\", 2.0)",
        &["levels[1].splines[0].0", "did you mean `limb`?"],
    );
    one_fault(
        "[(\"sprig\", 3)",
        "[(\"spring\", 3)",
        &["no leaf kind is named", "did you mean `sprig`?"],
    );
    one_fault(
        "bark: Gnarled",
        "bark: Bumpy",
        &["unknown bark `Bumpy`", "Ridged, Gnarled"],
    );
    one_fault(
        "height_m: 0.6, depth_m: 0.02",
        "height_m: 0.6, scale: 0.2",
        &["bark.scale", "did you mean `scales`? Fields of Gnarled"],
    );
    one_fault(
        "height_m: 0.6, depth_m: 0.02",
        "height_m: 0.6, peel: 0.2",
        &["unknown field `peel` in Gnarled", "lichen, moss"],
    );
    one_fault(
        "height_m: 0.6, depth_m: 0.02",
        "height_m: 0.6, width_m: 45",
        &["bark.width_m", "45 is out of range", "0.002 to 10 metres"],
    );
    one_fault(
        "arrangement: Opposite(",
        "arrangement: Oposite(",
        &["leaves[0].arrangement", "did you mean `Opposite`?"],
    );
    one_fault(
        "margin: Entire",
        "margin: Serate(teeth: 20)",
        &["leaves[0].blade.margin", "did you mean `Serrate`?"],
    );
    one_fault(
        "margin: Entire",
        "margin: Serrate(depth: 0.1)",
        &["missing field `teeth` in Margin", "Teeth on each side"],
    );
    one_fault(
        "margin: Entire",
        "lobes: Palmate(count: 40)",
        &["leaves[0].blade.lobes.count", "from 2 to 15"],
    );
    one_fault(
        "veins: Pinnate(pairs: 6)",
        "veins: 6",
        &["leaves[0].blade.veins", "Midrib, Pinnate, Looping"],
    );
    one_fault(
        "fold_deg: 20,",
        "fold_deg: 20, season: Fall,",
        &["leaves[0].season", "Spring, Summer, Autumn, Winter"],
    );
    one_fault(
        "fold_deg: 20,",
        "fold_deg: 20, season: 7,",
        &["7 is out of range; expected 0 to 3"],
    );
    one_fault(
        "fold_deg: 20,",
        "fold_deg: 20, autumn: Yelow,",
        &["leaves[0].autumn", "did you mean `Yellow`?"],
    );
    one_fault(
        "scale: Flame",
        "scale: Flam",
        &["unknown crown shape", "did you mean `Flame`?"],
    );
    one_fault(
        "knots: Centripetal",
        "knots: Centripetel",
        &["did you mean `Centripetal`?"],
    );
}

#[test]
fn wrong_types_tell_what_was_expected_and_found() {
    one_fault(
        "gnarl: 0.05",
        "gnarl: \"0.05\"",
        &["expected a number, 0 to 1, found text", "without quotes"],
    );
    one_fault(
        "name: \"Olive\"",
        "name: Olive",
        &["name: expected text in quotes", "\"Olive\""],
    );
    one_fault(
        "sides: 16",
        "sides: 16.5",
        &["expected a whole number from 3 to 256, found 16.5"],
    );
    one_fault(
        "down: 50",
        "down: Flame",
        &["levels[2].down", "crown shape is a factor"],
    );
    one_fault(
        "(0.5, 60)",
        "(0.5, 60, 1)",
        &[
            "levels[1].down.at[0]",
            "(position, value), found a tuple of 3",
        ],
    );
    one_fault(
        "stems: (count",
        "stems: Flare(count",
        &["expected the fields of Stems"],
    );
    one_fault(
        "scale: (at: 1, vary: 0.1)",
        "scale: (at: 1, step: 2)",
        &["stems.scale.step", "unknown field `step` in Factor"],
    );
    one_fault("#455f34", "455f34", &["leaves[0].colour", "#rrggbb"]);
    one_fault(
        "[Splines, Branches, Levels]",
        "[Splines, \"Levels\"]",
        &["lod.priorities[1]", "found text"],
    );
    assert!(after("levels: [", "levels: {").contains("found `]`"));
}

#[test]
fn numbers_that_are_not_finite_or_out_of_range_are_refused_with_the_range() {
    one_fault(
        "gnarl: 0.05",
        "gnarl: NaN",
        &["`NaN` is not a finite number", "0 to 1"],
    );
    one_fault(
        "gnarl: 0.05",
        "gnarl: -inf",
        &["`-inf` is not a finite number"],
    );
    one_fault("gnarl: 0.05", "gnarl: 1e99", &["1e99 is out of range"]);
    one_fault(
        "radius_m: 0.25",
        "radius_m: -0.25",
        &[
            "levels[0].radius_m",
            "-0.25 is out of range",
            "0.0001 to 20 metres",
        ],
    );
    one_fault("links: 8", "links: 10001", &["1 to 10000"]);
    one_fault(
        "children: 2",
        "children: 1000000",
        &["levels[2].children", "1000000 is out of range", "1 to 64"],
    );
    one_fault("children: 2", "children: -2", &["-2 is out of range"]);
    one_fault(
        "seed: 12",
        "seed: 18446744073709551616",
        &["0 to 18446744073709551615"],
    );
    one_fault("vary: 8", "vary: inf", &["levels[1].down.vary"]);
    one_fault("(0.1, 1, 0)", "(0.1, NaN, 0)", &["splines[0].points[1].1"]);
}

#[test]
fn budgets_below_the_smallest_form_are_refused_with_the_reason() {
    for budget in ["0", "3", "-5"] {
        let with = format!("[10000, {budget}]");
        one_fault(
            "[10000, 2000, 400, 4]",
            &with,
            &["lod.budgets[1]", "one cross-quad, has 4 triangles"],
        );
    }
    one_fault(
        "[10000, 2000, 400, 4]",
        "[10, 10]",
        &["budgets must fall: 10 comes after 10"],
    );
    one_fault("[10000, 2000, 400, 4]", "[]", &["1 to 16 budgets, found 0"]);
    one_fault("[0.004, 0.01,", "[0.004, 0.001,", &["tolerances must rise"]);
    one_fault(
        "Splines, Branches, Levels",
        "Splines, Splines",
        &["listed twice"],
    );
}

#[test]
fn selectors_and_calibration_take_their_own_words_only() {
    one_fault(
        "selector: Cut",
        "selector: Level",
        &[
            "lod.selector",
            "one of Cut, Levels",
            "did you mean `Levels`?",
        ],
    );
    one_fault(
        "calibrate: true",
        "calibrate: 1",
        &["lod.calibrate", "expected true or false, found"],
    );
}

#[test]
fn files_that_are_missing_or_bad_are_told_with_their_own_lines() {
    one_fault(
        "limb.spline",
        "twig.spline",
        &[
            "t.ron:7:26: splines[1].file",
            "no such file `twig.spline`; looked on the shelf",
        ],
    );
    one_fault(
        "leaf.png",
        "leave.png",
        &["leaves[1].image: no such file `leave.png`"],
    );
    one_fault("limb.spline", "/limb.spline", &["not by an absolute path"]);
    one_fault("limb.spline", "../limb.spline", &["`..` is not allowed"]);
    let report = after("limb.spline", "bad.spline");
    assert_eq!(
        report,
        "bad.spline:3:5: `1,5` is not a number
    help: numbers are separated by spaces, with `.` for the decimals
bad.spline:4:1: expected three numbers, `x y z`, found 2"
    );
    one_fault(
        "image: \"leaf.png\"",
        "image: \"leaf.png\", gloss: 1",
        &["`gloss` has no effect beside `image`"],
    );
    let alone = species::parse("t.ron", GOOD, &NoFiles).unwrap_err();
    assert_eq!(alone.list().len(), 2);
    let dir = tempfile::tempdir().unwrap();
    let beside = species::parse("t.ron", GOOD, &Beside(dir.path().into())).unwrap_err();
    assert!(beside.to_string().contains("looked in"));
}

#[test]
fn splines_need_two_points_that_differ() {
    let points = "[(0, 0, 0), (0.1, 1, 0), (0, 2, 0.1)]";
    one_fault(
        points,
        "[(1, 0, 0)]",
        &["splines[0].points", "at least two points, found 1"],
    );
    one_fault(
        points,
        "[(1, 0, 0), (1, 0, 0)]",
        &["repeats the one before"],
    );
    one_fault(
        points,
        "[(1, 0), (1, 1, 0)]",
        &["splines[0].points[0]", "found a tuple of 2"],
    );
    one_fault(
        "knots: Centripetal",
        "name: \"b\"",
        &["field `name` is given twice", "first given here"],
    );
    one_fault(
        &format!("points: {points}, "),
        "",
        &["give `points` or `file`"],
    );
}

#[test]
fn other_formats_are_refused_in_one_clear_sentence() {
    one_fault(
        "format: 1",
        "format: 2, colour: 3",
        &["format 2", "reads up to 1", "newer version"],
    );
    one_fault("format: 1", "format: 0", &["no format 0"]);
    one_fault("format: 1, ", "", &["missing field `format` in Species"]);
    one_fault(
        "slug: \"olive\"",
        "slug: \"Olive tree\"",
        &["cannot be a slug"],
    );
}

#[test]
fn places_are_right_behind_tabs_and_letters_of_several_bytes() {
    let report = after("seed: 12", "/* Ölbäume */ x: 1,\n\t/* é */ seed: true");
    let places: Vec<_> = report
        .lines()
        .filter(|line| !line.starts_with(' '))
        .collect();
    assert!(
        places[0].starts_with("t.ron:2:82: x: unknown field"),
        "{report}"
    );
    assert_eq!(
        places[1],
        "t.ron:3:16: seed: expected a whole number, 0 to 18446744073709551615, found `true`"
    );
}

#[test]
fn a_file_of_nothing_but_faults_is_reported_briefly() {
    for part in [",", "'x", "x: 1, ", "[, ", "5deg "] {
        let source = format!("({})", part.repeat(200_000));
        let faults = faults(&source).unwrap();
        assert!((1..=1001).contains(&faults.list().len()), "{part}");
        assert!(faults.render(false).len() < 1_000_000, "{part}");
    }
    let unknown = "\"no\", ".repeat(100_000);
    one_fault(
        "splines: [\"limb\"]",
        &format!("splines: [{unknown}]"),
        &["at most 256 items"],
    );
}

/// The report of one bad script with many faults, as it is shown.
#[test]
fn a_script_full_of_slips_is_reported_whole_and_in_order() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bad");
    let source = std::fs::read_to_string(folder.join("olive.ron")).unwrap();
    let faults = species::parse("olive.ron", &source, &NoFiles).unwrap_err();
    let starts: Vec<_> = faults.list().iter().map(|fault| fault.span.start).collect();
    assert!(starts.is_sorted());
    let report = format!("{faults}\n\n{}", faults.render(false));
    let golden = folder.join("olive.txt");
    if std::env::var_os("PLEACH_ACCEPT").is_some() {
        std::fs::write(&golden, &report).unwrap();
    }
    let expected = std::fs::read_to_string(golden).unwrap();
    assert_eq!(report, expected, "set PLEACH_ACCEPT=1 to accept\n{report}");
}

/// Words of the schema with values that may or may not fit.
fn any_value() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        "-?[0-9]{1,7}(\\.[0-9]{1,3})?",
        prop::sample::select(vec![
            "NaN",
            "inf",
            "None",
            "true",
            "()",
            "Branch",
            "Flame",
            "Single",
            "\"trunk\"",
            "\"limb\"",
            "\"limbs\"",
            "\"#00ff00\"",
            "\"../x\"",
            "\"\"",
            "(0, 1)",
            "[(0, 1), (1, 0)]",
            "Smooth",
            "(0, 0, 0)",
            "[\"trunk\"]",
            "(count: 3)",
            "(step: 90)",
            "Gnarled(light: 3)",
            "[(\"limbs\", Planes(3))]",
            "Planes(99)",
        ])
        .prop_map(str::to_owned),
    ];
    leaf.prop_recursive(3, 16, 3, |inner| {
        let name = prop::sample::select(vec!["", "Branch", "Leaves", "Opposite", "Image", "Some"]);
        let key = prop::sample::select(
            species::fields::TABLES
                .iter()
                .flat_map(|table| table.fields())
                .map(|field| field.name)
                .collect::<Vec<_>>(),
        );
        let fields = prop::collection::vec((key, inner.clone()), 0..6);
        prop_oneof![
            prop::collection::vec(inner, 0..4).prop_map(|items| format!("[{}]", items.join(", "))),
            (name, fields).prop_map(|(name, fields)| {
                let fields: Vec<_> = fields.iter().map(|(k, v)| format!("{k}: {v}")).collect();
                format!("{name}({})", fields.join(", "))
            }),
        ]
    })
}

/// All spans can be shown, and both reports be written.
fn check(source: &str) -> Result<(), TestCaseError> {
    if let Some(faults) = faults(source) {
        prop_assert!(!faults.list().is_empty());
        for fault in faults.list() {
            let text = &faults.sources()[fault.source].text;
            prop_assert!(text.get(fault.span.clone()).is_some(), "{fault:?}");
        }
        prop_assert!(!faults.to_string().is_empty() && !faults.render(true).is_empty());
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn scripts_of_known_words_never_panic(
        values in prop::collection::vec(any_value(), species::fields::SPECIES.fields().count()),
    ) {
        let fields = species::fields::SPECIES.fields().zip(values);
        let fields: Vec<_> = fields.map(|(field, value)| match field.name {
            "format" => "format: 1".to_owned(),
            name => format!("{name}: {value}"),
        }).collect();
        check(&format!("({})", fields.join(",\n")))?;
    }

    #[test]
    fn a_good_script_with_one_value_replaced_never_panics(
        place in any::<prop::sample::Index>(), value in any_value(),
    ) {
        let colons: Vec<usize> = GOOD.match_indices(": ").map(|(at, _)| at).collect();
        let at = colons[place.index(colons.len())] + 2;
        let rest = &GOOD[at..];
        let end = rest.find([',', ')', ']']).unwrap_or(rest.len());
        check(&format!("{}{value}{}", &GOOD[..at], &rest[end..]))?;
    }

    #[test]
    fn damaged_scripts_never_panic(
        start in any::<prop::sample::Index>(), length in 0_usize..30, with in "[\\[\\](){}:,\"a1.é /*\n#-]{0,4}",
    ) {
        // The script is ASCII, so that any byte is an edge.
        let at = start.index(GOOD.len());
        let end = (at + length).min(GOOD.len());
        check(&format!("{}{with}{}", &GOOD[..at], &GOOD[end..]))?;
    }

    #[test]
    fn bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&String::from_utf8_lossy(&bytes))?;
    }
}
