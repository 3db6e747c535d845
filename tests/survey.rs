//! `pleach measure`: figures of trees that were made by hand, so that the answers are known.
#![expect(clippy::unwrap_used, reason = "in a test, a panic is the report")]

mod cli_common;

use cli_common::{SAPLING, pleach as program, utf8};
use pleach::report::Quiet;
use pleach::species::{self, NoFiles};
use pleach::survey::reference::of_latin;
use pleach::survey::{self, Foliage, Line, Measures, Verdict, forks, strahler};
use pleach::tree::{Limits, Part, Tree, grow};

/// A tree of a script whose levels are given; its splines are straight and its leaves 20 x 10 cm cards.
fn tree(stems: &str, levels: &str) -> Tree {
    let text = format!(
        "(format: 1, name: \"Model\", bark: Smooth(), {stems}
          splines: [(name: \"straight\", points: [(0, 0, 0), (0, 1, 0)])],
          leaves: [(name: \"leaf\", length_m: 0.2, width_m: 0.1)],
          levels: [{levels}])"
    );
    let species = species::parse("model.ron", &text, &NoFiles)
        .map_err(|faults| faults.render(false))
        .unwrap();
    grow(&species, 1, &Limits::default()).unwrap()
}

/// One blade of 100 cm2 a card.
fn measure(tree: &Tree) -> Measures {
    let foliage = Foliage {
        blades: 1,
        area_m2: 0.01,
    };
    survey::measure(tree, &[foliage])
}

fn near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

/// A 10 m trunk of even thickness.
const POLE: &str =
    r#"Branch(name: "trunk", length_m: 10, radius_m: 0.2, splines: ["straight"], taper: 1)"#;

#[test]
fn a_pole_has_its_height_and_diameter_and_no_crown() {
    let pole = measure(&tree("", POLE));
    assert!(near(pole.height_m, 10.0, 1e-3), "{}", pole.height_m);
    assert!(near(pole.dbh_cm.unwrap(), 40.0, 0.1), "{pole:?}");
    assert_eq!(pole.stems, 1);
    assert_eq!((pole.leaves, pole.leaf_area_m2), (0, 0.0));
    assert_eq!((pole.crown_width_m, pole.crown_base_m), (None, None));
    assert_eq!((pole.clear_bole, pole.leaf_area_index), (None, None));
    assert_eq!(pole.strahler, [1]);
    assert_eq!((pole.bifurcation_ratio, pole.fork_area_ratio), (None, None));
    assert!(pole.insertion_deg.is_empty());
}

#[test]
fn the_diameter_is_taken_at_breast_height_of_what_is_there() {
    let cone = r#"Branch(name: "trunk", length_m: 13, radius_m: 0.2, splines: ["straight"], taper: [(0, 1), (1, 0)])"#;
    let cone = measure(&tree("", cone));
    assert!(near(cone.dbh_cm.unwrap(), 36.0, 0.2), "{cone:?}");
    // A trunk of 1 m that forks in two: the limbs are stems there.
    let low = r#"
        Branch(name: "trunk", length_m: 1, radius_m: 0.3, splines: ["straight"], taper: 1),
        Branch(name: "limbs", children: 2, down: 20, length_m: 4, radius_m: 0.1, splines: ["straight"],
               taper: 1, collar: 1)"#;
    let low = measure(&tree("", low));
    assert_eq!(low.stems, 2);
    assert!(
        near(low.dbh_cm.unwrap(), 20.0 * 2.0_f32.sqrt(), 0.2),
        "{low:?}"
    );
    let shrub =
        r#"Branch(name: "stem", length_m: 3, radius_m: 0.05, splines: ["straight"], taper: 1)"#;
    let shrub = measure(&tree("stems: (count: 4, spread_m: 0.5),", shrub));
    assert_eq!(shrub.stems, 4);
    assert!(near(shrub.dbh_cm.unwrap(), 20.0, 0.2), "{shrub:?}");
    let bush = r#"Branch(name: "stem", length_m: 1, radius_m: 0.05, splines: ["straight"])"#;
    let bush = measure(&tree("", bush));
    assert_eq!((bush.dbh_cm, bush.stems), (None, 0));
}

/// Eight level limbs of 3 m at 4 to 8 m on the pole, with a leaf at each tip; the lowest stands alone.
fn umbrella() -> Tree {
    let levels = format!(
        r#"{POLE},
        Branch(name: "limbs", links: 2, children: 8, start: 0.4, end: 0.8, around: (step: 0), down: 90,
               length_m: 3, radius_m: 0.05, splines: ["straight"], taper: 1, collar: 1),
        Leaves(name: "leaves", links: 1, start: 1, end: 1, kinds: ["leaf"])"#
    );
    tree("", &levels)
}

#[test]
fn crown_and_bole_are_those_of_the_foliage() {
    let umbrella = measure(&umbrella());
    // Leaves start 4 cm below the limbs' blunt ends: octagons of radius 3.16, whose mean diameter is their
    // perimeter over pi.
    let width = umbrella.crown_width_m.unwrap();
    assert!(near(width, 6.16, 0.01), "{width}");
    assert!(
        near(umbrella.crown_base_m.unwrap(), 4.0, 0.12),
        "{umbrella:?}"
    );
    assert!(
        near(umbrella.clear_bole.unwrap(), 0.4, 0.01),
        "{umbrella:?}"
    );
    assert_eq!((umbrella.leaves, umbrella.leafy_limbs), (16, 16));
    assert!(near(umbrella.leaf_area_m2, 0.16, 1e-5));
    let disc = core::f32::consts::PI * width * width / 4.0;
    assert!(near(umbrella.leaf_area_index.unwrap(), 0.16 / disc, 1e-5));
    let angle = umbrella.insertion_deg[0];
    assert!(
        near(angle.median, 90.0, 0.1) && near(angle.p10, 90.0, 0.1),
        "{angle:?}"
    );
}

#[test]
fn leaf_area_goes_with_the_square_of_the_scale() {
    let at = |scale: &str| {
        let levels = format!(
            r#"{POLE}, Leaves(name: "leaves", links: 10, scale: {scale}, down: 60, kinds: ["leaf"])"#
        );
        measure(&tree("", &levels))
    };
    assert!(near(at("1").leaf_area_m2, 0.1, 1e-6));
    assert!(near(at("2").leaf_area_m2, 0.4, 1e-6));
    assert_eq!(at("2").leaves, 10);
}

#[test]
fn a_few_low_leaves_are_no_crown_base() {
    // 200 leaves from 5 m up; one sucker at the foot.
    let levels = format!(
        r#"{POLE},
        Leaves(name: "leaves", links: 200, start: 0.5, end: 1, down: 90, kinds: ["leaf"]),
        Leaves(name: "sucker", on: "trunk", links: 1, start: 0.05, end: 0.05, down: 90, kinds: ["leaf"])"#
    );
    let measures = measure(&tree("", &levels));
    assert!(
        near(measures.crown_base_m.unwrap(), 5.08, 0.05),
        "{measures:?}"
    );
    assert!(
        near(measures.clear_bole.unwrap(), 0.508, 0.01),
        "{measures:?}"
    );
}

#[test]
fn strahler_orders_are_those_of_the_books() {
    // A comb: a trunk tip and nine twigs; the first two tips make order 2, and it stays so.
    let comb = format!(
        r#"{POLE}, Branch(name: "twigs", links: 9, start: 0.1, end: 0.9, down: 60, length_m: 1, radius_m: 0.02,
                  splines: ["straight"])"#
    );
    assert_eq!(strahler::counts(&tree("", &comb)), [10, 1]);
    // Forks of two all the way, each at its parent's end: a perfect binary tree.
    let mut levels = POLE.to_owned();
    for level in 1..=4 {
        levels += &format!(
            r#", Branch(name: "fork {level}", children: 2, start: 1, end: 1, down: 30, length_of_parent: 0.7,
                radius_of_parent: 0.7071, splines: ["straight"], taper: 1, collar: 1)"#
        );
    }
    let binary = tree("", &levels);
    assert_eq!(strahler::counts(&binary), [16, 8, 4, 2, 1]);
    let fit = strahler::bifurcation(&strahler::counts(&binary)).unwrap();
    assert!(
        near(fit.ratio, 2.0, 1e-4) && near(fit.r2.unwrap(), 1.0, 1e-5),
        "{fit:?}"
    );
    // And the same tree keeps its cross-section at every fork.
    let ratios = forks::ratios(&binary);
    assert_eq!(ratios.iter().map(|r| r.1).sum::<u64>(), 15);
    assert!(ratios.iter().all(|r| near(r.0, 1.0, 0.01)), "{ratios:?}");
    assert_eq!(strahler::bifurcation(&[7]), None);
    assert_eq!(strahler::bifurcation(&[6, 2]).map(|f| f.r2), Some(None));
}

#[test]
fn leaves_and_a_continued_branch_are_no_forks_of_higher_order() {
    let levels = format!(
        r#"{POLE},
        Branch(name: "leader", start: 1, end: 1, length_m: 3, radius_m: 0.1, splines: ["straight"]),
        Leaves(name: "leaves", links: 9, kinds: ["leaf"])"#
    );
    assert_eq!(strahler::counts(&tree("", &levels)), [1]);
}

#[test]
fn fork_ratios_take_the_trunk_as_it_comes_and_goes_on() {
    // Two forks of one side branch each, half as thick as an even trunk: 1 + 1/4 each.
    let levels = format!(
        r#"{POLE}, Branch(name: "sides", links: 2, start: 0.3, end: 0.6, down: 60, length_m: 2, radius_m: 0.1,
                  splines: ["straight"], taper: 1, collar: 1.5)"#
    );
    let ratios = forks::ratios(&tree("", &levels));
    assert_eq!(ratios.len(), 2);
    assert!(ratios.iter().all(|r| near(r.0, 1.25, 0.01)), "{ratios:?}");
    assert_eq!(forks::part_within(&ratios, 0.8, 1.7), Some(1.0));
    assert_eq!(forks::part_within(&ratios, 1.3, 1.7), Some(0.0));
    assert_eq!(forks::part_within(&[], 0.8, 1.7), None);
}

#[test]
fn a_tropic_level_is_measured_as_it_stands() {
    // Limbs at 90 degrees, turned half of the way up by their tropism.
    let levels = format!(
        r#"{POLE}, Branch(name: "limbs", links: 6, start: 0.4, down: 90, tropism: 0.5, length_m: 2,
                  radius_m: 0.05, splines: ["straight"])"#
    );
    let angle = measure(&tree("", &levels)).insertion_deg[0];
    assert!(near(angle.median, 45.0, 0.2), "{angle:?}");
}

/// A tree on the olive's regression, off it by so many standard deviations in height.
fn olive(deviations: f32) -> Measures {
    let fit = of_latin("Olea europaea").unwrap().fit.clone().unwrap();
    Measures {
        height_m: fit.ln_height.metres(60.0) * libm::expf(deviations * fit.ln_height.2),
        dbh_cm: Some(60.0),
        crown_width_m: Some(fit.ln_crown.metres(60.0)),
        leaves: 200_000,
        leaf_area_index: Some(2.4),
        ..Measures::default()
    }
}

fn line<'a>(lines: &'a [Line], name: &str) -> &'a Line {
    lines.iter().find(|l| l.name == name).unwrap()
}

#[test]
fn verdicts_follow_the_share_of_trees_within_two_deviations() {
    let reference = of_latin("Olea europaea");
    let judged = |trees: &[Measures]| {
        let lines = survey::lines(trees, reference);
        line(&lines, "height for the DBH").verdict
    };
    assert_eq!(judged(&[olive(1.9), olive(-1.9)]), Verdict::Within);
    assert_eq!(judged(&[olive(2.1), olive(1.0)]), Verdict::Above);
    assert_eq!(judged(&[olive(-2.1), olive(-1.0)]), Verdict::Below);
    let mut most: Vec<Measures> = vec![olive(0.0); 19];
    most.push(olive(3.0));
    assert_eq!(judged(&most), Verdict::Within, "19 of 20 are 95 %");
    most.push(olive(3.0));
    assert_eq!(judged(&most), Verdict::Above);
}

#[test]
fn where_nothing_is_known_it_says_so() {
    let lines = survey::lines(&[olive(0.0)], None);
    for name in [
        "height",
        "DBH",
        "crown width",
        "leaf blades",
        "Strahler bifurcation",
    ] {
        let line = line(&lines, name);
        assert_eq!(line.verdict, Verdict::NoReference, "{name}");
        assert!(line.reference.is_none() && !line.note.is_empty(), "{name}");
    }
    // What holds of all trees still does.
    assert_eq!(line(&lines, "leaf-area index").verdict, Verdict::Within);
    let palm = survey::lines(&[olive(0.0)], of_latin("Cocos nucifera"));
    assert!(line(&palm, "height for the DBH").reference.is_none());
    assert!(line(&palm, "leaf blades").note.contains("fronds"));
    let poplar = survey::lines(&[olive(0.0)], of_latin("Populus nigra 'Italica'"));
    assert!(line(&poplar, "height for the DBH").reference.is_some());
    assert!(
        line(&poplar, "crown width for the DBH")
            .note
            .contains("columnar")
    );
}

#[test]
fn no_trees_have_no_figures() {
    let lines = survey::lines(&[], of_latin("Olea europaea"));
    assert!(
        lines
            .iter()
            .all(|l| l.value.is_none() && l.verdict == Verdict::NoReference)
    );
}

#[test]
fn a_survey_is_in_the_order_of_its_seeds() {
    let species = species::parse("sapling.ron", SAPLING, &NoFiles).unwrap();
    let foliage = survey::foliage(&species, &NoFiles).unwrap();
    // A leaf of elliptic outline fills some three quarters of its card.
    assert_eq!(foliage[0].blades, 1);
    assert!(
        (0.5..0.85).contains(&(foliage[0].area_m2 / 0.045)),
        "{foliage:?}"
    );
    let survey = |seeds: &[u64]| {
        survey::survey(&species, &foliage, seeds, &Limits::default(), &Quiet).unwrap()
    };
    let all = survey(&[5, 1, 9]);
    assert_eq!(all.iter().map(|m| m.seed).collect::<Vec<_>>(), [5, 1, 9]);
    assert_eq!(all[1], survey(&[1])[0]);
    assert_ne!(all[0].height_m, all[1].height_m);
}

#[test]
fn the_command_tells_people_and_machines() {
    let dir = tempfile::tempdir().unwrap();
    let script = dir.path().join("sapling.ron");
    std::fs::write(&script, SAPLING).unwrap();
    let run = program(&["measure", utf8(&script), "--seeds", "3", "--json"]);
    run.ends(
        0,
        &[
            "Sapling",
            "seeds 1 to 3",
            "no reference",
            "`Arbor minima` is not among the 27",
        ],
    );
    let json = run.json();
    assert_eq!(json["trees"].as_array().unwrap().len(), 3);
    assert_eq!(json["trees"][2]["seed"], 3);
    assert_eq!(json["reference"], serde_json::Value::Null);
    let height = &json["lines"][0];
    assert_eq!(
        (&height["name"], &height["unit"]),
        (&"height".into(), &"m".into())
    );
    assert_eq!(height["verdict"], "no_reference");
    assert!(height["value"]["median"].as_f64().unwrap() > 1.0);
    program(&["measure", utf8(&script), "--seeds", "0"]).ends(2, &["--seeds"]);
    program(&["measure", utf8(&dir.path().join("none.ron"))]).ends(1, &["none.ron"]);
    std::fs::write(&script, "(").unwrap();
    program(&["measure", utf8(&script)]).ends(1, &["sapling.ron"]);
}

#[test]
fn the_olive_is_measured_against_its_own_kind() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/species/olive.ron");
    let json = program(&["measure", script, "--seeds", "2", "--json"]).json();
    assert_eq!(json["reference"], "Olea europaea");
    let lines = json["lines"].as_array().unwrap();
    let of = |name: &str| lines.iter().find(|l| l["name"] == name).unwrap();
    assert_eq!(of("height")["verdict"], "within");
    assert_eq!(
        of("height for the DBH")["reference"]["of"],
        "36 trees, Olea europaea"
    );
}

#[test]
fn a_guide_has_a_plate_and_the_measures_of_each_species() {
    let (dir, script) = cli_common::nursery();
    let page = dir.path().join("README.md");
    let args = ["guide", utf8(&script), "--seeds", "2", "--out", utf8(&page)];
    program(&args).ends(0, &["README.md", "sapling.jpg"]);
    let files = cli_common::files(dir.path());
    let text = String::from_utf8(files["README.md"].clone()).unwrap();
    for part in [
        "pleach guide sapling.ron --out README.md",
        "| [Sapling](#sapling) | *Arbor minima* |",
        "[sapling.ron](sapling.ron)",
        "](plates/sapling.jpg)",
        "Measured over 2 seeds",
        "| height, m |",
    ] {
        assert!(text.contains(part), "no `{part}` in:\n{text}");
    }
    let plate = image::load_from_memory(&files["plates/sapling.jpg"]).unwrap();
    let plate = plate.to_rgb8();
    assert_eq!(plate.dimensions(), (990, 710));
    // The silhouette stands in the middle of its part, black on paper.
    let silhouette = image::imageops::crop_imm(&plate, 400, 0, 360, 460).to_image();
    let dark = silhouette.pixels().filter(|p| p.0[1] < 60).count();
    let light = silhouette.pixels().filter(|p| p.0[1] > 220).count();
    assert!(dark > 2_000 && light > 80_000, "{dark} dark, {light} light");

    program(&args).ends(0, &[]);
    assert_eq!(cli_common::files(dir.path()), files);
    let nowhere = dir.path().join("none/README.md");
    program(&["guide", utf8(&script), "--out", utf8(&nowhere)]).ends(2, &["--out", "none"]);
    program(&["guide", "--out", utf8(&page)]).ends(2, &["SPECIES"]);
}

/// A trunk with twelve limbs of half its radius, each with six twigs.
fn forked(pipes: f32, skip: &str) -> Tree {
    let levels = format!(
        r#"Branch(name: "trunk", length_m: 12, radius_m: 0.3, splines: ["straight"], pipe_model: {pipes}, sides: 24),
        Branch(name: "limbs", links: 12, start: 0.3, end: 0.9, down: 60, length_m: 4, radius_of_parent: 0.4,
               splines: ["straight"], collar: 1, pipe_model: {pipes}, skip: {skip}),
        Branch(name: "branches", links: 6, start: 0.3, end: 0.9, down: 60, length_m: 1.5, radius_of_parent: 0.4,
               splines: ["straight"], collar: 1, pipe_model: {pipes}),
        Branch(name: "twigs", links: 3, start: 0.3, end: 0.9, down: 60, length_m: 0.4, radius_of_parent: 0.5,
               splines: ["straight"], collar: 1)"#
    );
    tree("", &levels)
}

#[test]
fn the_pipe_model_keeps_the_cross_section_at_every_fork() {
    for skip in ["0", "[(0, 0), (1, 2)]"] {
        let ratios = forks::ratios(&forked(1.0, skip));
        // Beyond the last fork the trunk is drawn out, in the steps of its curve.
        let trunk = forks::part_within(&ratios[..11], 0.97, 1.03);
        assert_eq!(trunk, Some(1.0), "{ratios:?}");
        // Limbs that are thinner than their prototype carry twigs that are not.
        let all = forks::part_within(&ratios, 0.8, 1.8).unwrap();
        assert!(all > 0.9, "{all} of {ratios:?}");
    }
    let written = forks::ratios(&forked(0.0, "0"));
    let part = forks::part_within(&written[..11], 0.97, 1.03).unwrap();
    assert!(part < 0.7, "{part}: the rule would show nothing");
    // Half the rule lies between.
    let radius = |pipes: f32| match &forked(pipes, "0").levels[0].prototypes[0].part {
        Part::Branch(branch) => branch.at(0.8).radius,
        _ => panic!("a trunk"),
    };
    let [none, half, whole] = [0.0, 0.5, 1.0].map(radius);
    assert!(
        near(half, (none + whole) * 0.5, 0.004),
        "{none} {half} {whole}"
    );
    assert_eq!(radius(0.0), forked_as_written());
}

/// Radius of the trunk above, at 0.8 of its length, by its taper alone.
fn forked_as_written() -> f32 {
    let levels =
        r#"Branch(name: "trunk", length_m: 12, radius_m: 0.3, splines: ["straight"], sides: 24)"#;
    match &tree("", levels).levels[0].prototypes[0].part {
        Part::Branch(branch) => branch.at(0.8).radius,
        _ => panic!("a trunk"),
    }
}

#[test]
fn radii_stay_finite_however_much_leaves() {
    let levels = r#"Branch(name: "trunk", length_m: 9, radius_m: 0.3, splines: ["straight"], pipe_model: 1),
        Branch(name: "limbs", links: 400, children: 3, end: 0.9, length_m: 1, radius_of_parent: 0.6, splines: ["straight"])"#;
    let Part::Branch(trunk) = &tree("", levels).levels[0].prototypes[0].part.clone() else {
        panic!("a trunk");
    };
    let radii: Vec<f32> = trunk.axis[1..].iter().map(|s| s.radius).collect();
    assert!(
        radii.iter().all(|r| (0.002..=0.31).contains(r)),
        "{radii:?}"
    );
}

#[test]
fn what_leaves_at_the_very_end_goes_on_in_the_branch_s_stead() {
    let end = |pipes: f32| {
        let levels = format!(
            r#"Branch(name: "trunk", length_m: 4, radius_m: 0.1, splines: ["straight"], taper: 1, pipe_model: {pipes}),
            Branch(name: "limbs", links: 4, start: 0.4, down: 30, length_m: 1, radius_of_parent: 0.5,
                   splines: ["straight"], collar: 1, sides: 12)"#
        );
        let ratios = forks::ratios(&tree("", &levels));
        assert_eq!(ratios.len(), 4);
        ratios[3].0
    };
    assert!(near(end(0.0), 0.25, 0.02), "{}", end(0.0));
    assert!(near(end(1.0), 0.9, 0.03), "{}", end(1.0));
}

#[test]
fn places_that_skip_levels_carry_what_comes_after() {
    let tree = forked(0.0, "[(0, 0), (1, 2)]");
    // Of twelve places three skip nothing, six one level and three two.
    let limbs = 3;
    let branches = limbs * 6 + 6;
    let twigs = branches * 3 + 3;
    let nodes: Vec<u64> = tree
        .nodes()
        .iter()
        .map(|level| level.iter().sum())
        .collect();
    assert_eq!(nodes, [1, limbs, branches, twigs]);
    let carriers: Vec<&[usize]> = tree.levels.iter().map(|l| &l.carriers[..]).collect();
    assert_eq!(carriers, [&[][..], &[0], &[1, 0], &[2, 0]]);
    // A skipped level's nodes stand where the script's places are, at their own size.
    let skipping = &tree.levels[0].prototypes[0].links;
    let plain = forked(0.0, "0");
    let mut places: Vec<f32> = skipping.iter().map(|link| link.at).collect();
    places.sort_by(f32::total_cmp);
    let all: Vec<f32> = plain.levels[0].prototypes[0]
        .links
        .iter()
        .map(|l| l.at)
        .collect();
    assert_eq!(places, all);
    assert!(
        skipping
            .iter()
            .all(|link| near(link.place.scale, 1.0, 1e-6))
    );
    // What skips is of low order, so that the axis falls into streams of few.
    let ratio = |tree: &Tree| {
        strahler::bifurcation(&strahler::counts(tree))
            .unwrap()
            .ratio
    };
    assert!(
        ratio(&tree) < 0.75 * ratio(&plain),
        "{} {}",
        ratio(&tree),
        ratio(&plain)
    );
}
