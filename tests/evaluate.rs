//! The evaluation measures what it says: a tree is equal to itself, worse LODs score worse, and neither size,
//! colour nor the number of threads changes what they should not.

mod cli_common;
mod common;

use std::fs;

use cli_common::{generate, names, nursery, pleach as program, utf8};
use common::{Sketch, small};
use pleach::asset::TreeAsset;
use pleach::evaluate::{
    Evaluation, Lod, Score, Settings, Subject, evaluate, html, rivals, same_atlas, settings_of,
    with_reference,
};
use pleach::math::Vec3;
use pleach::mesh::card::{Pane, leaf};
use pleach::mesh::{Mesh, Primitive};
use pleach::pack::{self, Options, Replace};
use pleach::pipeline;
use pleach::report::{Progress, Quiet};
use pleach::species::{self, NoFiles};

/// Few and small pictures.
fn few() -> Settings {
    Settings {
        side_views: 2,
        aerial_views: 1,
        heights: vec![64, 16],
        ..Settings::default()
    }
}

fn quick(budgets: &[u64]) -> pipeline::Settings {
    let mut settings = pipeline::Settings {
        budgets: Some(budgets.to_vec()),
        bark_size: 64,
        ..pipeline::Settings::default()
    };
    settings.captures.atlas_size = 256;
    settings
}

fn grown(sketch: &Sketch, budgets: &[u64]) -> TreeAsset {
    let species = sketch.species();
    let settings = with_reference(&species, &quick(budgets)).expect("a small tree");
    pipeline::generate(&species, &settings, &NoFiles, &Quiet).expect("a small tree")
}

fn judged(subject: &Subject<'_>) -> Evaluation {
    evaluate(subject, &few(), &Quiet).expect("nobody cancels")
}

fn json(evaluation: &Evaluation) -> String {
    serde_json::to_string(evaluation).expect("numbers")
}

/// The textures of an asset on other meshes, the first of them the reference.
fn wearing<'a>(asset: &'a TreeAsset, full: &'a Mesh, lods: &[&'a Mesh]) -> Subject<'a> {
    Subject {
        full,
        lods: lods
            .iter()
            .map(|mesh| Lod {
                budget: Some(mesh.triangles()),
                state: "",
                error_m: 0.0,
                screen_size: 1.0,
                mesh,
            })
            .collect(),
        ..Subject::of_asset(asset, false)
    }
}

#[track_caller]
fn assert_perfect(evaluation: &Evaluation) {
    assert!(!evaluation.models.is_empty());
    for model in &evaluation.models {
        assert!(model.pop.is_none_or(|p| p.flip == 0.0 && p.worst == 0.0));
        assert!(model.flicker.is_none_or(|f| f.ratio == 1.0));
        assert_eq!(model.pop.is_none(), model.rival);
        for (index, scores) in model.scores.iter().enumerate() {
            let perfect = Score {
                iou: 1.0,
                ..Score::default()
            };
            // Of a rival at the largest height only the outline is drawn.
            let is_outline = model.rival && index == 0;
            for score in [scores.all, scores.side, scores.aerial] {
                assert_eq!(score.flip.is_nan(), is_outline, "{score:?}");
                let seen = if is_outline {
                    Score {
                        flip: 0.0,
                        flip_by_light: [0.0; 2],
                        flip_worst: 0.0,
                        normal_deg: 0.0,
                        ..score
                    }
                } else {
                    score
                };
                assert_eq!(seen, perfect);
            }
        }
    }
}

#[test]
fn full_detail_against_itself_is_perfect() {
    let asset = grown(&small(), &[100_000, 200]);
    let mut subject = Subject::of_asset(&asset, false);
    subject.lods.truncate(1);
    let evaluation = judged(&subject);
    assert_eq!(
        evaluation.models[0].triangles,
        evaluation.reference_triangles
    );
    assert_eq!(
        evaluation.models.len(),
        2,
        "and the random rival that leaves nothing out"
    );
    assert_perfect(&evaluation);
    assert!(
        evaluation.models[0].loses_to.is_empty(),
        "a draw is no loss"
    );
    assert!(evaluation.models[0].layers > 0.1);
}

#[test]
fn a_first_budget_that_the_full_tree_meets_is_a_lod_and_others_are_not() {
    let species = small().species();
    let full = |settings| with_reference(&species, &settings).expect("small").full;
    assert!(!full(quick(&[100_000, 4])));
    assert!(full(quick(&[100, 4])));
    let asset = grown(&small(), &[100, 4]);
    let budgets = |full| -> Vec<_> {
        let subject = Subject::of_asset(&asset, full);
        subject.lods.iter().map(|lod| lod.budget).collect()
    };
    assert_eq!(budgets(true)[0], None);
    assert_eq!(budgets(false), budgets(true)[1..]);
}

#[test]
fn fewer_leaves_score_worse() {
    let asset = grown(&small(), &[100, 4]);
    let full = &asset.lods[0].mesh;
    let parts = [800, 400, 100].map(|budget| rivals::random(full, budget, 7, 1.0));
    let lods: Vec<&Mesh> = parts.iter().collect();
    let evaluation = judged(&wearing(&asset, full, &lods));
    assert!(full.triangles() > 900);
    for height in 0..2 {
        let of = |lod: usize| evaluation.models[lod].scores[height].all;
        for lod in 1..3 {
            let (better, worse) = (of(lod - 1), of(lod));
            let both_lost = better.iou == 0.0 && worse.iou == 0.0;
            assert!(both_lost || worse.iou < better.iou, "{better:?} {worse:?}");
            assert!(worse.flip > better.flip, "{better:?} {worse:?}");
            assert!(worse.coverage < better.coverage, "{better:?} {worse:?}");
            assert_eq!(worse.coverage_abs, -worse.coverage, "thinner in every view");
        }
    }
    // The rival may scale its leaves, and these could not.
    assert_eq!(evaluation.models[2].loses_to, ["random"]);
}

#[test]
fn in_a_black_tree_flip_sees_only_the_outline() {
    let mut asset = grown(&small(), &[100, 4]);
    let mut turned = asset.lods[0].mesh.clone();
    for vertex in &mut turned.foliage.vertices {
        let [x, y, z] = vertex.normal;
        vertex.normal = [y, z, x];
    }
    let full = asset.lods[0].mesh.clone();
    let score =
        |asset: &TreeAsset| judged(&wearing(asset, &full, &[&turned])).models[0].scores[0].all;
    let lit = score(&asset);
    assert!(lit.flip > 0.01 && lit.normal_deg > 5.0, "{lit:?}");
    for surface in [&mut asset.foliage, &mut asset.bark] {
        surface.albedo = surface.albedo.map(|&[.., a]| [0, 0, 0, a]);
    }
    let black = score(&asset);
    assert_eq!((black.iou, black.flip), (1.0, 0.0));
    assert_eq!(black.normal_deg, lit.normal_deg);
}

#[test]
fn size_does_not_matter() {
    let asset = grown(&small(), &[200]);
    let scores = |factor: f32| {
        let mut asset = asset.clone();
        for lod in &mut asset.lods {
            let Mesh { bark, foliage } = &mut lod.mesh;
            for vertex in bark.vertices.iter_mut().chain(&mut foliage.vertices) {
                vertex.position = vertex.position.map(|x| x * factor);
            }
        }
        asset.reliefs.iter_mut().for_each(|r| r.longer *= factor);
        judged(&Subject::of_asset(&asset, false)).models
    };
    let real = scores(1.0);
    for factor in [0.001, 1000.0] {
        for (a, b) in real.iter().zip(scores(factor)) {
            assert!((a.layers / b.layers - 1.0).abs() < 0.02);
            for (a, b) in a.scores.iter().zip(b.scores) {
                let (a, b) = (a.all, b.all);
                // Rounding moves single samples across edges.
                assert!((a.iou - b.iou).abs() < 0.02, "{factor}: {a:?} {b:?}");
                assert!(
                    (a.coverage - b.coverage).abs() < 0.02,
                    "{factor}: {a:?} {b:?}"
                );
                let alike = |a: f32, b: f32| (a - b).abs() < 0.01 || (a.is_nan() && b.is_nan());
                assert!(alike(a.flip, b.flip), "{factor}: {a:?} {b:?}");
            }
        }
    }
}

/// Leaf cards, each moved by a vector.
fn cards(places: &[Vec3], flat: bool) -> Mesh {
    let card = leaf(0.3, 0.15, 0.0, &Pane::ALL);
    let mut foliage = Primitive::default();
    for &place in places {
        let base = u32::try_from(foliage.vertices.len()).expect("few");
        let mesh = card.placed(&pleach::math::Similarity::IDENTITY, 1.0);
        for mut vertex in mesh.foliage.vertices {
            let [x, y, z] = vertex.position;
            let at = if flat { [x, 0.0, y] } else { [x, y, z] };
            vertex.position = (Vec3::from(at) + place).to_array();
            foliage.vertices.push(vertex);
        }
        foliage
            .indices
            .extend(mesh.foliage.indices.iter().map(|i| base + i));
    }
    Mesh {
        foliage,
        ..Mesh::default()
    }
}

#[test]
fn single_flat_and_missing_leaves_are_measured_too() {
    let asset = grown(&small(), &[4]);
    let single = cards(&[Vec3::ZERO], false);
    assert_perfect(&judged(&wearing(&asset, &single, &[&single])));
    let places: Vec<Vec3> = (0..5_u8).map(|i| Vec3::X * f32::from(i) * 0.2).collect();
    for flat in [false, true] {
        let row = cards(&places, flat);
        assert_perfect(&judged(&wearing(&asset, &row, &[&row])));
    }
    let nothing = Mesh::default();
    let evaluation = judged(&wearing(&asset, &single, &[&nothing]));
    let lost = evaluation.models[0].scores[0].all;
    assert_eq!(
        (lost.iou, lost.coverage, lost.coverage_abs),
        (0.0, -1.0, 1.0)
    );
    assert!(
        lost.flip > 0.0 && lost.normal_deg.is_nan(),
        "no normals to compare"
    );
    let evaluation = judged(&wearing(&asset, &nothing, &[&nothing, &single]));
    assert_eq!(
        evaluation.models[0].scores[0].all.iou, 1.0,
        "nothing is equal to nothing"
    );
    assert_eq!(
        evaluation.models[1].scores[0].all.coverage, 1.0,
        "all of it is too much"
    );
}

#[test]
fn a_tree_of_one_level_of_branches_is_measured() {
    let mut sketch = small();
    sketch.branches.truncate(1);
    let asset = grown(&sketch, &[4]);
    let evaluation = judged(&Subject::of_asset(&asset, false));
    for scores in &evaluation.models[0].scores {
        assert!((0.2..=1.0).contains(&scores.all.iou), "{scores:?}");
        assert!(scores.all.flip > 0.0 && scores.all.flip < 0.7, "{scores:?}");
    }
}

#[test]
fn the_figures_do_not_depend_on_the_threads() {
    let asset = grown(&small(), &[200, 4]);
    let settings = Settings {
        plates: true,
        ..few()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        let subject = Subject::of_asset(&asset, false);
        pool.install(|| evaluate(&subject, &settings, &Quiet).expect("nobody cancels"))
    };
    let (one, two) = (with(1), with(2));
    assert_eq!(json(&one), json(&two));
    assert_eq!(html(&one), html(&two));
    let lods = asset.lods.iter().filter(|l| l.budget.is_some()).count();
    assert_eq!(one.plates.len(), 2 * 2, "two views at two heights");
    for plate in &one.plates {
        assert!(!plate.reference.is_empty());
        assert_eq!(plate.shown.len(), lods);
        for shown in &plate.shown {
            assert!(!shown.picture.is_empty());
            assert_eq!(shown.error.is_empty(), plate.height != 64);
        }
    }
}

#[test]
fn rivals_are_measured_at_the_largest_height_and_at_64_pixels() {
    let asset = grown(&small(), &[200]);
    let settings = Settings {
        heights: vec![96, 64, 32],
        ..few()
    };
    let subject = Subject::of_asset(&asset, false);
    let evaluation = evaluate(&subject, &settings, &Quiet).expect("nobody cancels");
    let heights = |model: usize| -> Vec<u32> {
        let scores = evaluation.models[model].scores.iter();
        scores.map(|s| s.height).collect()
    };
    assert_eq!((heights(0), heights(1)), (vec![96, 64, 32], vec![96, 64]));
    let [lod, rival] = [0, 1].map(|i| evaluation.models[i].triangles);
    assert!(rival <= lod);
    assert!(html(&evaluation).contains("random"));
}

#[test]
fn a_pack_and_its_script_give_the_same_figures() {
    let dir = tempfile::tempdir().expect("a folder");
    let script = cli_common::SAPLING;
    let species = species::parse("sapling.ron", script, &NoFiles).expect("a sound script");
    for budgets in [vec![400, 60, 4], vec![60, 4]] {
        let wanted = quick(&budgets);
        let made = pipeline::generate(&species, &wanted, &NoFiles, &Quiet).expect("small");
        let files = pack::build(&made, script.as_bytes(), Options::default()).expect("a pack");
        let folder = pack::write(dir.path(), "p", &files, Replace::OwnPacks).expect("written");
        let pack = pack::read(&folder).expect("a sound pack");
        let settings = with_reference(&species, &settings_of(&pack)).expect("small");
        let grown = pipeline::generate(&species, &settings, &NoFiles, &Quiet).expect("small");
        assert!(same_atlas(&pack, &grown));
        let of_pack = judged(&Subject::of_pack(&pack, &grown));
        let settings = with_reference(&species, &wanted).expect("small");
        let asset = pipeline::generate(&species, &settings, &NoFiles, &Quiet).expect("small");
        assert_eq!(
            json(&of_pack),
            json(&judged(&Subject::of_asset(&asset, false)))
        );
    }
}

#[test]
fn the_program_judges_scripts_and_packs_alike() {
    let (dir, script) = nursery();
    generate(&script, dir.path(), &["--budgets", "60,4"]).ends(0, &[]);
    let report = dir.path().join("report.html");
    let of_script = program(&[
        "evaluate",
        utf8(&script),
        "--budgets",
        "60,4",
        "--texture-size",
        "256",
        "--views",
        "2",
        "--json",
        "--report",
        utf8(&report),
    ]);
    of_script.ends(0, &["Sapling", "LOD1", "random", "verdict", "report"]);
    let pack = dir.path().join("sapling-3");
    let of_pack = program(&[
        "evaluate",
        utf8(&pack),
        "--views",
        "2",
        "--threads",
        "1",
        "--json",
    ]);
    of_pack.ends(0, &["LOD0"]);
    assert_eq!(of_script.json(), of_pack.json());
    assert_eq!(of_pack.json()["aerial_views"], 1);
    let page = fs::read_to_string(&report).expect("a report");
    assert!(page.ends_with("</html>\n") && page.contains("data:image/png;base64,"));
    assert_eq!(
        names(dir.path()),
        ["report.html", "sapling-3", "sapling.ron"]
    );
}

#[test]
fn the_gate_closes_on_what_is_above_it_and_says_which() {
    let (_dir, script) = nursery();
    let gate = |budgets: &str, limit: &str| {
        program(&[
            "evaluate",
            utf8(&script),
            "--texture-size",
            "256",
            "--views",
            "2",
            "--budgets",
            budgets,
            "--fail-above",
            limit,
        ])
    };
    gate("4000", "0").ends(0, &["LOD0"]);
    gate("4000,4", "0").ends(1, &["LOD1: ", "more than 0.0%", "LOD0"]);
    let open = gate("4000,4", "nan");
    open.ends(2, &["--fail-above"]);
}

#[test]
fn faults_of_the_command_line_are_told_before_the_work() {
    let (dir, script) = nursery();
    let with = |more: &[&str]| {
        let mut args = vec!["evaluate", utf8(&script)];
        args.extend(more);
        program(&args)
    };
    with(&["--report", utf8(dir.path())]).ends(2, &["folder"]);
    let nowhere = dir.path().join("nowhere/report.html");
    with(&["--report", utf8(&nowhere)]).ends(2, &["nowhere"]);
    with(&["--views", "0"]).ends(2, &[]);
    with(&["--texture-size", "100"]).ends(2, &["power of two"]);
    if cfg!(not(feature = "rivals")) {
        with(&["--rivals"]).ends(2, &["--features rivals"]);
    }
    let pack = generate(&script, dir.path(), &[]);
    pack.ends(0, &[]);
    let folder = dir.path().join("sapling-3");
    program(&["evaluate", utf8(&folder), "--seed", "4"]).ends(2, &["its own seed"]);
    fs::write(folder.join("species.ron"), "(").expect("damaged");
    program(&["evaluate", utf8(&folder)]).ends(1, &["species.ron"]);
}

/// Cancels once a stage has begun.
struct Until(&'static str, std::sync::atomic::AtomicBool);

impl Progress for Until {
    fn begin(&self, stage: &'static str, _steps: u64) {
        if stage == self.0 {
            self.1.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    }

    fn step(&self) {}

    fn cancelled(&self) -> bool {
        self.1.load(std::sync::atomic::Ordering::Relaxed)
    }
}

#[test]
fn every_stage_ends_when_it_is_told_to() {
    let asset = grown(&small(), &[200]);
    let subject = Subject::of_asset(&asset, false);
    for stage in ["rivals", "comparing", "moving"] {
        let until = Until(stage, false.into());
        assert!(evaluate(&subject, &few(), &until).is_err(), "{stage}");
    }
    assert!(evaluate(&subject, &few(), &Until("none", false.into())).is_ok());
}

#[test]
fn a_first_look_gives_the_same_figures_of_the_lods_alone() {
    let asset = grown(&small(), &[200, 4]);
    let subject = Subject::of_asset(&asset, false);
    let only = Settings {
        only_lods: true,
        ..few()
    };
    let look = evaluate(&subject, &only, &Quiet).expect("nobody cancels");
    let whole = judged(&subject);
    assert!(look.orbit_flip.is_nan() && !whole.orbit_flip.is_nan());
    assert_eq!(look.models.len(), subject.lods.len());
    for (model, other) in look.models.iter().zip(&whole.models) {
        assert_eq!(model.label, other.label);
        for (a, b) in model.scores.iter().zip(&other.scores) {
            // Rivals widen the picture, which moves samples by a rounding error.
            let pairs = [
                (a.all.iou, b.all.iou),
                (a.all.coverage_abs, b.all.coverage_abs),
                (a.all.flip, b.all.flip),
            ];
            assert_eq!(a.height, b.height);
            assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-3), "{pairs:?}");
        }
        assert!(!model.rival && model.pop.is_none() && model.flicker.is_none());
    }
}
