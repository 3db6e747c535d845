//! Faults of levels, and of what names them.

use super::{GOOD, after, faults, one_fault};
use std::fmt::Write as _;

#[test]
fn forms_name_branch_levels_once_with_a_form_that_there_is() {
    let forms = |with: &str, words: &[&str]| {
        one_fault(
            "[(\"trunk\", StarTop), (\"limbs\", Planes(8))]",
            with,
            words,
        );
    };
    forms(
        "[(\"limb\", Cross)]",
        &[
            "lod.forms[0].0",
            "no level is named `limb`",
            "did you mean `limbs`?",
        ],
    );
    forms(
        "[(\"sprigs\", Cross)]",
        &[
            "lod.forms[0].0",
            "`sprigs` is a leaf level",
            "carries the leaves",
        ],
    );
    forms(
        "[(\"limbs\", Cross), (\"limbs\", StarTop)]",
        &["lod.forms[1].0", "given two forms", "first named here"],
    );
    for planes in ["0", "65", "-3"] {
        forms(
            &format!("[(\"limbs\", Planes({planes}))]"),
            &["lod.forms[0].1.0", "a whole number from 1 to 64"],
        );
    }
    for planes in ["Planes", "Planes()", "Planes(3, 4)", "Planes(n: 3)"] {
        let with = format!("[(\"limbs\", {planes})]");
        forms(&with, &["lod.forms[0].1", "takes one number", "Planes(8)"]);
    }
    for strips in ["Strips", "Strips(2)", "Strips(2, 4, 1)", "Strips(n: 2)"] {
        let with = format!("[(\"limbs\", {strips})]");
        let words = ["lod.forms[0].1", "takes two numbers", "Strips(2, 4)"];
        forms(&with, &words);
    }
    forms(
        "[(\"limbs\", Strips(5, 4))]",
        &["lod.forms[0].1.0", "a whole number from 1 to 4"],
    );
    forms(
        "[(\"limbs\", Strips(2, 17))]",
        &["lod.forms[0].1.1", "a whole number from 1 to 16"],
    );
    forms("[(\"limbs\", Cross(2))]", &["takes nothing in brackets"]);
    forms("[(\"limbs\", StarTopp)]", &["did you mean `StarTop`?"]);
    forms(
        "[\"limbs\"]",
        &["lod.forms[0]: expected (level, form)", "found text"],
    );
    forms("Cross", &["expected a list of (level, form)"]);
    // A level that is at fault itself is not reported as missing.
    let report = after("Branch(name: \"limbs\"", "Brnch(name: \"limbs\"");
    assert!(report.contains("unknown kind of level"), "{report}");
    assert!(!report.contains("lod.forms"), "{report}");
    let many = format!("[{}]", "(\"no\", Cross), ".repeat(100_000));
    forms(&many, &["at most 16 levels"]);
}

#[test]
fn levels_must_fit_together() {
    let levels = GOOD.find("levels: [").unwrap()..GOOD.find("  lod:").unwrap();
    one_fault(
        &GOOD[levels],
        "levels: [],\n",
        &["at least one level, the trunk"],
    );
    one_fault(
        "splines: [\"trunk\"],\n           taper",
        "taper",
        &["missing field `splines` in Branch", "7:", "t.ron"],
    );
    one_fault(
        "splines: [\"limb\"]",
        "splines: []",
        &["levels[3].splines", "name at least one spline"],
    );
    one_fault(
        "splines: [\"limb\"]",
        "splines: [(\"limb\", 0)]",
        &["all weights are 0"],
    );
    one_fault("on: \"limbs\"", "on: \"roots\"", &["comes later"]);
    one_fault(
        "on: \"trunk\"",
        "on: \"sprigs\"",
        &["`sprigs` is a leaf level and carries nothing"],
    );
    one_fault("on: \"trunk\"", "on: \"roots\"", &["cannot grow on itself"]);
    one_fault(
        "on: \"trunk\", ",
        "",
        &["leaf level and carries nothing; say `on`", "on: \"limbs\""],
    );
    one_fault(
        "\"roots\", on",
        "\"limbs\", on",
        &["two levels are named `limbs`", "first named here"],
    );
    one_fault(
        "start: 0.5, end: 1.0",
        "start: 0.5, end: 0.4",
        &["`start` (0.5) is beyond `end` (0.4)"],
    );
    one_fault(
        "gnarl: 0.05",
        "links: 3",
        &["the trunk: `links` has no meaning"],
    );
    one_fault(
        "length_m: 2.2",
        "length_of_parent: 1",
        &["give `length_m` instead"],
    );
    one_fault(
        "length_of_parent: 0.9",
        "length_of_parent: 0.9, length_m: 1",
        &["not both"],
    );
    one_fault(
        "length_of_parent: 0.9,",
        "",
        &["give `length_m` or `length_of_parent`"],
    );
    one_fault("[(0, 1), (1, 0.6)]", "[(0, 0), (1, 0)]", &["no thickness"]);
    one_fault(
        "[(0, 1), (1, 0.6)]",
        "[(0, 1), (0, 0.6)]",
        &["positions must rise"],
    );
    one_fault(
        "[(0, 1), (1, 0.6)]",
        "[(0, 1), (1.5, 0.6)]",
        &["levels[0].taper[1].0", "0 to 1"],
    );
}

#[test]
fn a_level_of_absurdly_many_nodes_is_refused() {
    let mut source = GOOD.to_owned();
    let mut extra = String::new();
    for level in 0..8 {
        let on = if level == 0 {
            "trunk".into()
        } else {
            format!("x{}", level - 1)
        };
        writeln!(
            extra,
            "Branch(name: \"x{level}\", on: \"{on}\", links: 1000, splines: [\"limb\"], length_m: 1, radius_m: 1),"
        )
        .unwrap();
    }
    source = source.replacen("  ],\n  lod", &format!("{extra}  ],\n  lod"), 1);
    let report = faults(&source).unwrap().to_string();
    assert!(
        report.contains("levels[9].links: this level would have 1000000000000000 x 1000 nodes"),
        "{report}"
    );
    let wide =
        "links: 10000, children: 64, variants: 16, length_m: 1, radius_m: 1, splines: [\"limb\"]),";
    let two =
        format!("Branch(name: \"a\", on: \"trunk\", {wide} Branch(name: \"b\", on: \"a\", {wide}");
    let source = GOOD.replacen("  ],\n  lod", &format!("{two}  ],\n  lod"), 1);
    let report = faults(&source).unwrap().to_string();
    assert!(report.contains("at most 4000000 can be held"), "{report}");
}

#[test]
fn only_levels_that_are_there_can_be_skipped() {
    let limbs = |skip: &str| {
        let report = after(
            "links: 5, children: 1,",
            &format!("links: 5, children: 1, skip: {skip},"),
        );
        assert!(
            report.is_empty() || report.contains("levels[1].skip"),
            "{report}"
        );
        report
    };
    let told = |skip: &str, words: &[&str]| {
        let report = limbs(skip);
        for word in words {
            assert!(report.contains(word), "no `{word}` in:\n{report}");
        }
    };
    assert_eq!(limbs("0"), "");
    assert_eq!(limbs("[(0, 0), (1, 0.4)]"), "");
    told("[(0, 0), (1, 1)]", &["no branches grow on `limbs`"]);
    told("[(0, 0), (1, 9)]", &["out of range", "0 to 8 levels"]);
    told("many", &["expected", "found"]);
    // With twigs on the limbs one level can be skipped, but not two, and not by all places.
    let twigs = |skip: &str| {
        let twigs = "Branch(name: \"twigs\", on: \"limbs\", links: 3, length_m: 0.3, radius_m: 0.01, splines: [\"limb\"]),";
        let good = GOOD.replacen(
            "links: 5, children: 1,",
            &format!("links: 5, skip: {skip},"),
            1,
        );
        let good = good.replacen(
            "Leaves(name: \"sprigs\"",
            &format!("{twigs} Leaves(name: \"sprigs\""),
            1,
        );
        faults(&good)
            .map(|faults| faults.to_string())
            .unwrap_or_default()
    };
    assert_eq!(twigs("[(0, 0), (1, 1)]"), "");
    let report = twigs("[(0, 0), (1, 2)]");
    assert!(
        report.contains("would skip 2 levels of branches, and 1 grows on `limbs`"),
        "{report}"
    );
    assert!(report.contains("keep the curve below 1.5"), "{report}");
    let report = twigs("1");
    assert!(report.contains("every place skips `limbs`"), "{report}");
    assert!(report.contains("[(0, 0), (1, 1)]"), "{report}");
    // The trunk has no places, and leaves are none that could be skipped.
    one_fault(
        "gnarl: 0.05",
        "skip: 1",
        &["levels[0].skip", "`skip` has no meaning"],
    );
    one_fault(
        "spin: 0),",
        "spin: 0, skip: 1),",
        &["levels[2].skip", "unknown field"],
    );
}
