//! The critic's tree: leaves of black and white squares. Outlines cannot see that the inside of a crown stands
//! elsewhere; colours can, and what they say must not depend on the light.

mod common;

use common::small;
use pleach::asset::TreeAsset;
use pleach::evaluate::{Evaluation, Lod, Settings, Subject, evaluate, with_reference};
use pleach::image::{Image, png};
use pleach::mesh::Mesh;
use pleach::pipeline;
use pleach::report::Quiet;
use pleach::species::Files;
use pleach::species::schema::{LeafLook, LevelKind};

/// Squares along the edge of a leaf's picture.
const SQUARES: u32 = 4;

/// Texels along the edge of a square.
const SQUARE: u32 = 8;

/// A folder that holds the checkered leaf alone.
struct Checker;

impl Files for Checker {
    fn read_text(&self, path: &str) -> Result<String, String> {
        Err(format!("{path} is no text"))
    }

    fn read_bytes(&self, _path: &str) -> Result<Vec<u8>, String> {
        let edge = SQUARES * SQUARE;
        let texel = |at: u32| {
            let (x, y) = (at % edge / SQUARE, at / edge / SQUARE);
            let shade = if (x + y).is_multiple_of(2) { 10 } else { 245 };
            [shade, shade, shade, 255]
        };
        let leaf = Image::from_texels(edge, edge, (0..edge * edge).map(texel).collect());
        png::encode(&leaf).map_err(|e| e.to_string())
    }

    fn exists(&self, _path: &str) -> Result<(), String> {
        Ok(())
    }
}

/// A small tree whose leaves are large and checkered.
fn checkered(budgets: &[u64]) -> TreeAsset {
    let mut species = small().species();
    species.leaves.truncate(1);
    species.leaves[0].look = LeafLook::Image("checker.png".to_owned());
    for level in &mut species.levels {
        if let LevelKind::Leaf(leaves) = &mut level.kind {
            leaves.kinds = vec![(0, 1.0)];
        }
    }
    let mut settings = pipeline::Settings {
        budgets: Some(budgets.to_vec()),
        bark_size: 64,
        ..pipeline::Settings::default()
    };
    settings.captures.atlas_size = 512;
    let settings = with_reference(&species, &settings).expect("a small tree");
    pipeline::generate(&species, &settings, &Checker, &Quiet).expect("a small tree")
}

fn judged(subject: &Subject<'_>) -> Evaluation {
    let settings = Settings {
        side_views: 3,
        aerial_views: 1,
        heights: vec![256, 64],
        ..Settings::default()
    };
    evaluate(subject, &settings, &Quiet).expect("nobody cancels")
}

/// The full tree against others that wear the same textures.
fn against<'a>(asset: &'a TreeAsset, meshes: &'a [Mesh]) -> Subject<'a> {
    Subject {
        lods: meshes
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

/// The same mesh with the inside of every leaf drawn together, or apart, about its middle: `part` of the way to
/// nothing. Its outline stays, since the picture is opaque.
fn shifted(mesh: &Mesh, part: f32) -> Mesh {
    let mut mesh = mesh.clone();
    let foliage = &mut mesh.foliage;
    // A leaf's vertices are those that its triangles share; leaves are stored one after the other.
    let uvs: Vec<[f32; 2]> = foliage.vertices.iter().map(|v| v.uv).collect();
    let low = |k: usize| uvs.iter().map(|uv| uv[k]).fold(f32::MAX, f32::min);
    let high = |k: usize| uvs.iter().map(|uv| uv[k]).fold(f32::MIN, f32::max);
    let middle = [0, 1].map(|k| (low(k) + high(k)) * 0.5);
    for vertex in &mut foliage.vertices {
        for (uv, middle) in vertex.uv.iter_mut().zip(middle) {
            *uv += (middle - *uv) * part;
        }
    }
    mesh
}

#[test]
fn colours_see_an_inside_that_moves_while_the_outline_stays() {
    let asset = checkered(&[100_000, 4]);
    let full = &asset.lods[0].mesh;
    let parts = [0.0, 0.05, 0.12, 0.25];
    let meshes = parts.map(|part| shifted(full, part));
    let evaluation = judged(&against(&asset, &meshes));
    for height in 0..2 {
        let scores = |lod: usize| evaluation.models[lod].scores[height].all;
        for lod in 0..parts.len() {
            let score = scores(lod);
            assert!(score.iou > 0.999 && score.coverage_abs < 1e-4, "{score:?}");
            assert_eq!(score.flip == 0.0, lod == 0, "{score:?}");
            if lod > 0 {
                for light in 0..2 {
                    let [before, after] = [lod - 1, lod].map(|l| scores(l).flip_by_light[light]);
                    assert!(after > before * 1.1, "{lod}: {before} then {after}");
                }
                assert!(score.flip_worst >= score.flip);
            }
        }
    }
}

#[test]
fn lods_of_a_checkered_tree_rank_alike_under_every_light() {
    let asset = checkered(&[100_000, 400, 100, 4]);
    let evaluation = judged(&Subject::of_asset(&asset, false));
    let lods: Vec<_> = evaluation.models.iter().filter(|m| !m.rival).collect();
    assert!(lods.len() >= 3, "{}", lods.len());
    for pair in lods.windows(2) {
        let [finer, coarser] = [pair[0], pair[1]].map(|m| m.scores[0].all);
        assert!(finer.flip < coarser.flip, "{finer:?} {coarser:?}");
        for light in 0..2 {
            assert!(
                finer.flip_by_light[light] < coarser.flip_by_light[light],
                "{light}: {finer:?} {coarser:?}"
            );
        }
    }
}

#[test]
fn a_switch_between_unlike_lods_pops_more_and_a_still_picture_does_not_flicker() {
    let asset = checkered(&[100_000, 4]);
    let full = &asset.lods[0].mesh;
    let meshes = [full.clone(), shifted(full, 0.02), shifted(full, 0.25)];
    let evaluation = judged(&against(&asset, &meshes));
    let pops: Vec<f32> = evaluation.models[..3]
        .iter()
        .map(|m| m.pop.expect("a LOD has a switch").flip)
        .collect();
    assert_eq!(pops[0], 0.0, "full detail against itself");
    assert!(pops[2] > pops[1] && pops[1] > 0.0, "{pops:?}");
    assert!(evaluation.orbit_flip > 0.0);
    let flicker = evaluation.models[0].flicker.expect("a LOD moves");
    assert_eq!(flicker.ratio, 1.0);
    // Nothing at all does not change from frame to frame.
    let nothing = [Mesh::default()];
    let evaluation = judged(&against(&asset, &nothing));
    let flicker = evaluation.models[0].flicker.expect("a LOD moves");
    assert_eq!((flicker.flip, flicker.ratio), (0.0, 0.0));
}

#[test]
fn the_machine_text_has_the_fields_that_its_page_explains() {
    let asset = checkered(&[100_000, 4]);
    let full = asset.lods[0].mesh.clone();
    let evaluation = judged(&against(&asset, &[full]));
    let text = serde_json::to_value(&evaluation).expect("numbers");
    let page = include_str!("../docs/evaluate.md");
    let mut names = Vec::new();
    names_in(&text, &mut names);
    assert!(names.len() > 30, "{names:?}");
    for name in names {
        let is_told = page.contains(&format!("`{name}`")) || page.contains(&format!(".{name}`"));
        assert!(is_told, "docs/evaluate.md does not explain `{name}`");
    }
}

/// The names of all fields, each once.
fn names_in(value: &serde_json::Value, names: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(fields) => {
            for (name, value) in fields {
                if !names.contains(name) {
                    names.push(name.clone());
                }
                names_in(value, names);
            }
        }
        serde_json::Value::Array(values) => values.iter().for_each(|v| names_in(v, names)),
        _ => {}
    }
}
