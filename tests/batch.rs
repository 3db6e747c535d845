//! Batches: many trees from one list, in parts, again, and beside trees that fail.
#![expect(clippy::unwrap_used, reason = "in a test, a panic is the report")]

mod cli_common;

use cli_common::{
    Run, assert_same, files, generate, manifest, names, nursery, pleach, utf8, whole,
};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Runs a batch with `--json`.
fn batch(jobs: &Path, out: &Path, more: &[&str]) -> Run {
    let mut args = vec!["batch", utf8(jobs), "--out", utf8(out), "--json"];
    args.extend(more);
    pleach(&args)
}

/// Writes a job list of small trees into a folder.
fn list(folder: &Path, jobs: &str) -> PathBuf {
    let path = folder.join("jobs.ron");
    let text = format!("(format: 1, texture_size: 256, jobs: [\n{jobs}\n])");
    fs::write(&path, text).unwrap();
    path
}

/// Pack and status of every item.
fn statuses(run: &Run) -> Vec<(String, String)> {
    let word = |item: &Value, key: &str| item[key].as_str().unwrap().to_owned();
    let items = run.json();
    let items = items.as_array().unwrap();
    items
        .iter()
        .map(|i| (word(i, "pack"), word(i, "status")))
        .collect()
}

fn ci() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("species/jobs/ci.ron")
}

#[test]
fn the_list_that_comes_with_the_program_makes_what_generate_makes() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("packs");
    let run = batch(&ci(), &out, &["--threads", "2"]);
    run.ends(0, &["3 made, 0 there already, 0 failed"]);
    let packs = ["olive-1", "olive-2", "olive-sparse-1"];
    let made = packs.map(|p| (p.to_owned(), "made".to_owned()));
    assert_eq!(statuses(&run), made, "in the list's order");
    assert_eq!(names(&out), packs);
    for pack in packs {
        assert_eq!(whole(&out.join(pack)), Ok(()));
    }
    // The script gives the pack, and so does the pack's own script, variation and all.
    let olive = Path::new(env!("CARGO_MANIFEST_DIR")).join("species/olive.ron");
    let own = out.join("olive-sparse-1/species.ron");
    let again = dir.path().join("again");
    for (script, seed, pack) in [(olive, "2", packs[1]), (own, "1", packs[2])] {
        let budgets = ["--seed", seed, "--budgets", "2000,400,4"];
        generate(&script, &again, &budgets).ends(0, &[]);
        assert_same(&out.join(pack), &again.join(pack));
    }
    let levels = |pack: &str| manifest(&out.join(pack))["levels"].clone();
    assert_ne!(levels("olive-1")[1]["nodes"], 5);
    assert_eq!(
        levels("olive-sparse-1")[1]["nodes"],
        5,
        "`set` changes the tree"
    );
}

#[test]
fn the_papers_list_has_180_trees_and_no_fault() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("species/jobs/paper.ron");
    let plan = pleach::batch::Plan::read(&path).unwrap();
    assert_eq!(plan.items.len(), 180);
    for item in &plan.items {
        let species = item
            .species
            .as_ref()
            .unwrap_or_else(|faults| panic!("{faults}"));
        let limits = pleach::tree::Limits::default();
        pleach::tree::grow(species, item.seed, &limits).unwrap();
    }
}

#[test]
fn resuming_remakes_a_tree_whose_spline_file_changed() {
    let dir = tempfile::tempdir().unwrap();
    let species = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
    for file in ["palm.ron", "palm_trunk.spline"] {
        fs::copy(species.join(file), dir.path().join(file)).unwrap();
    }
    let job = r#"(species: "palm.ron", texture_size: 256, budgets: [400, 4])"#;
    let (jobs, out) = (list(dir.path(), job), dir.path().join("packs"));
    batch(&jobs, &out, &[]).ends(0, &["1 made"]);
    batch(&jobs, &out, &["--resume"]).ends(0, &["1 there already"]);
    let spline = dir.path().join("palm_trunk.spline");
    let text = fs::read_to_string(&spline).unwrap();
    fs::write(&spline, format!("{text}# touched\n")).unwrap();
    batch(&jobs, &out, &["--resume"]).ends(0, &["1 made"]);
}

#[test]
fn a_bad_species_fails_alone() {
    let (dir, script) = nursery();
    let text = fs::read_to_string(script).unwrap();
    let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
    write("typo.ron", &text.replace("links: 5", "lnks: 5"));
    write("torn.ron", &text[..text.len() / 2]);
    write(
        "many.ron",
        &text.replace("links: 6", "links: 200000, children: 1000"),
    );
    write(
        "image.ron",
        &text.replace("width_m: 0.15", "width_m: 0.15, image: \"leaf.png\""),
    );
    write("leaf.png", "no image");
    let jobs = list(
        dir.path(),
        r#"(species: "sapling.ron"), (species: "typo.ron"), (species: "torn.ron"),
           (species: "torn.ron", name: "set", set: {"levels.limbs.links": "3"}),
           (species: "many.ron", name: "many"), (species: "image.ron", name: "image"),
           (species: "sapling.ron", seeds: List([9]))"#,
    );
    let out = dir.path().join("packs");
    let run = batch(&jobs, &out, &[]);
    run.ends(
        1,
        &[
            "why",
            "2 made, 0 there already, 5 failed",
            "lnks",
            "200000",
            "leaf.png",
            "typo.ron",
        ],
    );
    let status: Vec<String> = statuses(&run).into_iter().map(|(_, s)| s).collect();
    assert_eq!(
        status,
        [
            "made", "failed", "failed", "failed", "failed", "failed", "made"
        ]
    );
    for item in run.json().as_array().unwrap() {
        if item["status"] == "failed" {
            assert_eq!(item["machine"], false);
            assert!(item["reason"].as_str().is_some_and(|r| r.len() > 20));
        }
    }
    assert_eq!(names(&out), ["sapling-3", "sapling-9"]);
    assert!(
        names(&out)
            .iter()
            .all(|pack| whole(&out.join(pack)).is_ok())
    );
    let fine = |c: char| c == '\n' || !c.is_control();
    assert!(
        run.err.chars().all(fine),
        "no bars on a pipe: {:?}",
        run.err
    );
}

#[test]
fn lists_at_fault_end_with_two_and_make_nothing() {
    let (dir, _) = nursery();
    let out = dir.path().join("packs");
    let sapling = r#"(species: "sapling.ron")"#;
    for (jobs, words) in [
        ("(species: 3)", &["jobs.ron:2:10", "string"][..]),
        ("(specis: \"sapling.ron\")", &["jobs.ron:2:", "specis"]),
        ("(species: \"sapling.ron\"", &["jobs.ron:3:"]),
        ("(species: \"none.ron\")", &["jobs[0]", "none.ron"]),
        ("", &["there are no jobs"]),
        (
            &format!("{sapling}, {sapling}"),
            &["jobs[1]", "`sapling-3`", "`name`"],
        ),
        (
            r#"(species: "sapling.ron", seeds: List([4, 4]))"#,
            &["`sapling-4`"],
        ),
        (
            r#"(species: "sapling.ron", seeds: List([]))"#,
            &["no seeds"],
        ),
        (
            r#"(species: "sapling.ron", seeds: Range(4, 3))"#,
            &["ends before it begins"],
        ),
        (
            r#"(species: "sapling.ron", seeds: Range(0, 18446744073709551615))"#,
            &["at most"],
        ),
        (
            r#"(species: "sapling.ron", set: {"seed": "4"})"#,
            &["needs a `name`"],
        ),
        (r#"(species: "sapling.ron", name: "A b")"#, &["lower-case"]),
        (
            r#"(species: "sapling.ron", name: "../up")"#,
            &["lower-case"],
        ),
        (
            r#"(species: "sapling.ron", name: "x", set: {"levels.lims.links": "4"})"#,
            &["limbs"],
        ),
        (
            r#"(species: "sapling.ron", name: "x", set: {"seed": "4)"})"#,
            &["no value"],
        ),
        (r#"(species: "sapling.ron", budgets: [400, 3])"#, &["has 4"]),
        (
            r#"(species: "sapling.ron", budgets: [40, 400])"#,
            &["must fall"],
        ),
        (
            r#"(species: "sapling.ron", texture_size: 100)"#,
            &["jobs.ron", "power of two"],
        ),
    ] {
        let path = list(dir.path(), jobs);
        let run = batch(&path, &out, &[]);
        run.ends(2, words);
        assert_eq!(run.out, "", "{jobs}");
    }
    let path = list(dir.path(), sapling);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("format: 1", "format: 2")).unwrap();
    batch(&path, &out, &[]).ends(2, &["format 2 is not 1"]);
    batch(&dir.path().join("none.ron"), &out, &[]).ends(2, &["none.ron"]);
    for shard in ["0/2", "3/2", "1", "a/b"] {
        batch(&ci(), &out, &["--shard", shard]).ends(2, &["I/N"]);
    }
    assert!(!out.exists());
}

#[test]
fn resuming_keeps_whole_packs_and_remakes_damaged_ones() {
    let (dir, _) = nursery();
    let out = dir.path().join("packs");
    let jobs = list(
        dir.path(),
        r#"(species: "sapling.ron", seeds: Range(1, 4))"#,
    );
    batch(&jobs, &out, &[]).ends(0, &[]);
    let at = |path: &str| out.join(path);
    let before: Vec<_> = [1, 2, 3]
        .map(|i| files(&at(&format!("sapling-{i}"))))
        .into();
    // One byte changed, one file gone, the manifest torn.
    let texture = at("sapling-1/textures/foliage_albedo.png");
    let mut bytes = fs::read(&texture).unwrap();
    bytes[40] ^= 1;
    fs::write(&texture, bytes).unwrap();
    fs::remove_file(at("sapling-2/sapling_LOD1.glb")).unwrap();
    let text = fs::read_to_string(at("sapling-3/pack.json")).unwrap();
    let torn = text.replacen("\"seed\"", "\"sed\"", 1);
    fs::write(at("sapling-3/pack.json"), torn).unwrap();
    let run = batch(&jobs, &out, &["--resume"]);
    run.ends(0, &["3 made, 1 there already"]);
    let status: Vec<String> = statuses(&run).into_iter().map(|(_, s)| s).collect();
    assert_eq!(status, ["made", "made", "made", "kept"]);
    for (number, before) in (1..).zip(&before) {
        assert!(files(&at(&format!("sapling-{number}"))) == *before);
    }
}

#[test]
fn resuming_remakes_what_another_list_or_layout_made() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let jobs = |more: &str| list(dir.path(), &format!(r#"(species: "sapling.ron"{more})"#));
    let status = |path: &Path, more: &[&str]| -> String {
        let mut all = vec!["--resume"];
        all.extend(more);
        let run = batch(path, &out, &all);
        run.ends(0, &[]);
        statuses(&run)[0].1.clone()
    };
    let plain = jobs("");
    for more in [&[][..], &["--mips"], &["--mips", "--embed"], &[]] {
        assert_eq!(status(&plain, more), "made", "{more:?}");
        assert_eq!(status(&plain, more), "kept", "{more:?}");
    }
    for more in [
        &["--selector", "levels"][..],
        &["--no-calibrate"],
        &["--selector", "cut"],
    ] {
        assert_eq!(status(&plain, more), "made", "{more:?}");
        assert_eq!(status(&plain, more), "kept", "{more:?}");
    }
    // The script's own word, in so many flags.
    assert_eq!(status(&plain, &[]), "kept");
    let set = r#", name: "steps", set: {"lod.selector": "Levels", "lod.calibrate": "false"}"#;
    assert_eq!(status(&jobs(set), &[]), "made");
    let steps = manifest(&out.join("sapling-steps-3"));
    assert_eq!(steps["asked"]["selector"], "levels");
    assert_eq!(steps["asked"]["calibrate"], false);
    // The last budget of [5, 4] gets no LOD, and the pack is whole all the same.
    for more in [
        ", budgets: [100, 4]",
        ", budgets: [5, 4]",
        ", texture_size: 128",
    ] {
        assert_eq!(status(&jobs(more), &[]), "made", "{more}");
        assert_eq!(status(&jobs(more), &[]), "kept", "{more}");
    }
    let text = fs::read_to_string(&script).unwrap();
    fs::write(&script, text.replace("// A sapling.", "// Another.")).unwrap();
    assert_eq!(status(&jobs(""), &[]), "made");
}

#[test]
fn shards_make_each_tree_once_and_threads_change_no_byte() {
    let (dir, _) = nursery();
    let jobs = list(
        dir.path(),
        r#"(species: "sapling.ron", seeds: Range(1, 3)),
           (species: "sapling.ron", name: "tall", seeds: Range(1, 2), set: {"levels.trunk.length_m": "3"})"#,
    );
    let (all, parts) = (dir.path().join("all"), dir.path().join("parts"));
    batch(&jobs, &all, &["--threads", "1"]).ends(0, &["5 made"]);
    let first = batch(&jobs, &parts, &["--shard", "1/2", "--threads", "2"]);
    first.ends(0, &["3 made"]);
    let second = batch(&jobs, &parts, &["--shard", "2/2"]);
    second.ends(0, &["2 made"]);
    let mut packs: Vec<String> = [first, second]
        .iter()
        .flat_map(statuses)
        .map(|(pack, _)| pack)
        .collect();
    packs.sort();
    assert_eq!(packs, names(&all));
    assert_same(&all, &parts);
    // More shards than trees: the last ones have nothing to do.
    let run = batch(&jobs, &parts, &["--shard", "7/7"]);
    run.ends(0, &["0 made"]);
    assert_eq!(run.json(), serde_json::json!([]));
}

#[test]
fn a_variation_is_the_script_with_its_fields_set() {
    let (dir, script) = nursery();
    let jobs = list(
        dir.path(),
        r#"(species: "sapling.ron", name: "bushy", seeds: List([7]), set: {
               "levels.limbs.links": "9", "levels.2.children": "2", "name": "\"Bush\"",
           })"#,
    );
    let out = dir.path().join("packs");
    batch(&jobs, &out, &[]).ends(0, &[]);
    let pack = out.join("sapling-bushy-7");
    let made = manifest(&pack);
    assert_eq!(made["species"]["name"], "Bush");
    assert_eq!(made["species"]["slug"], "sapling-bushy");
    let nodes: Vec<&Value> = made["levels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|l| &l["nodes"])
        .collect();
    assert_eq!(nodes, [1, 9, 108]);
    let text = fs::read_to_string(pack.join("species.ron")).unwrap();
    assert!(text.starts_with("// A sapling.\n"), "comments stay");
    let again = dir.path().join("again");
    generate(&pack.join("species.ron"), &again, &["--seed", "7"]).ends(0, &[]);
    assert_same(&pack, &again.join("sapling-bushy-7"));
    // A value out of range is found in the script as changed, at its place.
    list(
        dir.path(),
        r#"(species: "sapling.ron", name: "odd", set: {"levels.limbs.links": "-1"})"#,
    );
    batch(&jobs, &out, &[]).ends(1, &["sapling.ron:13:35", "out of range"]);
    assert!(script.exists());
}
