//! How meshes sway: what stands on the ground stays, nothing tears, all LODs sway together, and the shader
//! says the same as the CPU.

mod common;

use std::sync::OnceLock;

use common::{Script, Sketch, cases, scripts, sketches, small, stand_ins};
use pleach::asset::{AssetLod, TreeAsset};
use pleach::lod::{Form, State};
use pleach::math::{Vec2, Vec3, float, floor_to_u32};
use pleach::mesh::{Flattener, Mesh, Swayer, check};
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::Beside;
use pleach::tree::{Part, Tree};
use pleach::wind::{Rig, Sway, Wind, displacement};
use proptest::prelude::*;

fn generated(script: &Script) -> TreeAsset {
    let settings = Settings {
        full: true,
        ..Settings::default()
    };
    let files = Beside(script.folder.clone());
    pipeline::generate(&script.species, &settings, &files, &Quiet).expect("a tree")
}

fn breeze() -> Wind {
    Wind {
        direction: Vec2::X,
        speed_m_s: 10.0,
        gustiness: 0.8,
    }
}

/// Where a vertex goes, its leaf's turn left out.
fn lean(rig: &Rig, sway: &Sway, height: f32, time: f32) -> Vec3 {
    let sway = Sway {
        leaf: [0; 4],
        ..*sway
    };
    displacement(&breeze(), rig, time, height, sway, Vec3::Z)
}

/// Sums over the foliage that is seen: area, and by time its displacement, by quarter of the height.
struct Means {
    area: [f32; 4],
    moved: [Vec<Vec3>; 4],
}

/// Places on each edge of a triangle at which it is looked at.
const GRID: u8 = 24;

fn means(asset: &TreeAsset, lod: &AssetLod, times: &[f32]) -> Means {
    let foliage = &lod.mesh.foliage;
    let alpha = &asset.foliage.albedo;
    let mut means = Means {
        area: [0.0; 4],
        moved: core::array::from_fn(|_| vec![Vec3::ZERO; times.len()]),
    };
    let grid = if foliage.indices.len() > 60_000 {
        6
    } else {
        GRID
    };
    for corners in foliage.indices.chunks_exact(3) {
        let vertex = |i: usize| &foliage.vertices[corners[i] as usize];
        let at = |i: usize| Vec3::from(vertex(i).position);
        let area =
            (at(1) - at(0)).cross(at(2) - at(0)).length() / (f32::from(grid) * f32::from(grid));
        let leans: Vec<[Vec3; 3]> = times
            .iter()
            .map(|&time| {
                [0, 1, 2].map(|i| {
                    let sway = &foliage.sway[corners[i] as usize];
                    lean(&asset.wind, sway, at(i).y, time)
                })
            })
            .collect();
        for (i, j) in (0..grid).flat_map(|i| (0..grid - i).map(move |j| (i, j))) {
            let (s, t) = (
                (f32::from(i) + 0.33) / f32::from(grid),
                (f32::from(j) + 0.33) / f32::from(grid),
            );
            let mix = |a: f32, b: f32, c: f32| a * (1.0 - s - t) + b * s + c * t;
            let uv = [0, 1].map(|k| mix(vertex(0).uv[k], vertex(1).uv[k], vertex(2).uv[k]));
            let texel = |u: f32, size: u32| floor_to_u32(u * float(size)).min(size - 1);
            let [_, _, _, a] = alpha.at(texel(uv[0], alpha.width()), texel(uv[1], alpha.height()));
            if *a < 128 {
                continue;
            }
            let height = mix(at(0).y, at(1).y, at(2).y) / asset.bounds.max.y;
            let quarter = floor_to_u32(height * 4.0).min(3) as usize;
            means.area[quarter] += area;
            for (sum, [a, b, c]) in means.moved[quarter].iter_mut().zip(&leans) {
                *sum += (*a * (1.0 - s - t) + *b * s + *c * t) * area;
            }
        }
    }
    means
}

/// Every species with its LODs, made once.
fn species() -> &'static [TreeAsset] {
    static ALL: OnceLock<Vec<TreeAsset>> = OnceLock::new();
    ALL.get_or_init(|| scripts().iter().map(generated).collect())
}

#[test]
fn the_upper_half_of_every_lod_moves_as_that_of_the_full_tree() {
    let times = [0.4, 1.9, 3.3, 5.2, 7.7, 11.1];
    for asset in species() {
        let upper = |lod: &AssetLod| {
            let means = means(asset, lod, &times);
            let area = means.area[2] + means.area[3];
            let sums = means.moved[2].iter().zip(&means.moved[3]);
            sums.map(|(a, b)| (*a + *b) / area).collect::<Vec<Vec3>>()
        };
        let full = upper(&asset.lods[0]);
        for lod in &asset.lods[1..] {
            for ((time, full), coarse) in times.iter().zip(&full).zip(upper(lod)) {
                let miss = full.distance(coarse) / full.length();
                let triangles = lod.triangles.total();
                assert!(
                    miss < 0.15,
                    "{} at {triangles} triangles and {time} s: {coarse} m for {full} m",
                    asset.slug
                );
            }
        }
    }
}

#[test]
fn all_vertices_sway_and_only_leaves_turn() {
    for asset in species() {
        for lod in &asset.lods {
            check::mesh(&lod.mesh).unwrap();
            for primitive in [&lod.mesh.bark, &lod.mesh.foliage] {
                assert_eq!(primitive.sway.len(), primitive.vertices.len());
            }
            assert!(lod.mesh.bark.sway.iter().all(|s| s.leaf == [0; 4]));
        }
        let leaves = &asset.lods[0].mesh.foliage.sway;
        assert!(leaves.iter().all(|s| s.leaf[..3] != [0; 3]));
        let longest = leaves.iter().map(|s| {
            let [x, y, z, _] = s.turns();
            Vec3::new(x, y, z).length()
        });
        let longest = longest.fold(0.0, f32::max);
        // The reach is that of whole cards; they are trimmed to what they show.
        assert!((0.8..1.02).contains(&longest), "{longest} of the reach");
    }
}

#[test]
fn what_stands_on_the_ground_stays_in_every_lod() {
    for asset in species() {
        for lod in &asset.lods {
            let mut standing = 0;
            for primitive in [&lod.mesh.bark, &lod.mesh.foliage] {
                for (vertex, sway) in primitive.vertices.iter().zip(&primitive.sway) {
                    if vertex.position[1] < 1e-3 {
                        standing += 1;
                        assert_eq!(sway.wind[..3], [0; 3], "{} {}", asset.slug, lod.state);
                    }
                }
            }
            assert!(standing >= 2, "{} {}", asset.slug, lod.state);
        }
    }
}

#[test]
fn trees_bend_as_far_as_trees_do() {
    let steady = Wind {
        gustiness: 0.0,
        ..breeze()
    };
    for (slug, low, high) in [
        ("olive", 0.06, 0.3),
        ("lombardy-poplar", 0.6, 1.4),
        ("palm", 1.1, 2.0),
    ] {
        let asset = species().iter().find(|a| a.slug == slug).expect(slug);
        let foliage = &asset.lods[0].mesh.foliage;
        let leans = foliage.sway.iter().map(|sway| {
            let still = Sway {
                leaf: [0; 4],
                ..*sway
            };
            displacement(&steady, &asset.wind, 0.0, 50.0, still, Vec3::Z).x
        });
        let most = leans.fold(0.0, f32::max);
        assert!((low..high).contains(&most), "{slug}: {most} m");
    }
}

/// Places in the vertices of a mesh, as the tree's nodes are walked in the order of flattening.
struct Walk<'a> {
    tree: &'a Tree,
    lod: usize,
    mesh: &'a Mesh,
    bark: usize,
    foliage: usize,
    joints: usize,
}

impl Walk<'_> {
    /// Checks the joints of a node's sub-tree; tells how its first vertex sways.
    fn node(&mut self, level: usize, prototype: usize) -> [u8; 3] {
        let node = self.tree.prototype(level, prototype);
        let bands = |sway: &Sway| [sway.wind[0], sway.wind[1], sway.wind[2]];
        let mut line: Vec<(f32, [u8; 3])> = Vec::new();
        let mut first = [0; 3];
        match &node.part {
            Part::Stool => {}
            Part::Leaf { .. } => {
                first = bands(&self.mesh.foliage.sway[self.foliage]);
                self.foliage += count(node.part.full_triangles()) + 2;
            }
            Part::Branch(branch) => {
                let sway = |vertex: usize| bands(&self.mesh.bark.sway[self.bark + vertex]);
                let mut vertex = 0;
                for (ring, sides) in branch.tube(self.lod) {
                    line.push((branch.axis[ring].t, sway(vertex)));
                    vertex += sides as usize + 1;
                }
                line.push((1.0, sway(vertex)));
                first = line[0].1;
                self.bark += count(branch.vertices(self.lod));
            }
        }
        for link in &node.links {
            let child = self.node(link.level as usize, link.prototype as usize);
            if line.is_empty() {
                assert_eq!(child, [0; 3], "a stem stands still");
                continue;
            }
            let after = line
                .partition_point(|k| k.0 <= link.at)
                .clamp(1, line.len() - 1);
            let (a, b) = (line[after - 1], line[after]);
            let part = ((link.at - a.0) / (b.0 - a.0).max(1e-6)).clamp(0.0, 1.0);
            for (band, &found) in child.iter().enumerate() {
                let [a, b] = [a.1[band], b.1[band]].map(f32::from);
                let miss = (f32::from(found) - (a + (b - a) * part)).abs();
                // Each of the three numbers is rounded by half a step.
                assert!(miss <= 1.01, "level {level} at {}: {miss} steps", link.at);
            }
            self.joints += 1;
        }
        first
    }
}

fn count(number: u64) -> usize {
    usize::try_from(number).expect("a small mesh")
}

/// A tree with all levels as geometry of one spline LOD.
fn swayed(tree: &Tree, lod: u8) -> (Mesh, Rig) {
    let state = State {
        forms: vec![Form::Geometry(lod); tree.levels.len()],
    };
    let form = stand_ins(tree).form(tree, &state, pleach::mesh::Coat::plain(0.5));
    let mut mesh = Flattener::new(tree, &form).tree().expect("a small mesh");
    let swayer = Swayer::new(tree);
    swayer.form(&form, &mut mesh);
    (mesh, swayer.rig())
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn a_child_moves_as_its_parent_does_where_it_is_fixed(mut sketch in sketches(true), lod in 0..6_u8) {
        // What the ground holds stays, whatever carries it.
        sketch.roots = false;
        let tree = sketch.tree();
        let (mesh, _) = swayed(&tree, lod);
        let mut walk = Walk { tree: &tree, lod: usize::from(lod), mesh: &mesh, bark: 0, foliage: 0, joints: 0 };
        walk.node(0, 0);
        prop_assert_eq!(walk.bark, mesh.bark.sway.len());
        prop_assert_eq!(walk.foliage, mesh.foliage.sway.len());
        prop_assert!(walk.joints > 0);
    }

    #[test]
    fn no_vertex_of_any_tree_goes_too_far(sketch in sketches(true), time in 0_u16..500) {
        let (mesh, rig) = swayed(&sketch.tree(), 1);
        let wind = Wind { speed_m_s: 20.0, gustiness: 1.0, ..breeze() };
        let bound = rig.bound_m(&wind);
        prop_assert!(bound.is_finite());
        for primitive in [&mesh.bark, &mesh.foliage] {
            for (vertex, &sway) in primitive.vertices.iter().zip(&primitive.sway) {
                let away = displacement(&wind, &rig, f32::from(time), vertex.position[1], sway, Vec3::Z);
                prop_assert!(away.length() <= bound, "{} of {}", away, bound);
            }
        }
    }
}

#[test]
fn roots_are_held_by_the_ground() {
    let sketch = Sketch {
        roots: true,
        ..small()
    };
    let (mesh, _) = swayed(&sketch.tree(), 0);
    let deepest = mesh.bounds().min.y;
    let mut deep = 0;
    for (vertex, sway) in mesh.bark.vertices.iter().zip(&mesh.bark.sway) {
        if vertex.position[1] < 0.8 * deepest {
            deep += 1;
            assert!(sway.wind[..3].iter().all(|&w| w <= 4), "{sway:?}");
        }
    }
    assert!(deep >= 3, "{deep} vertices of roots");
}

#[test]
fn the_shader_has_the_constants_of_the_cpu() {
    let shader = include_str!("../shaders/wind.wgsl");
    let cpu = include_str!("../src/wind.rs");
    let numbers = |value: &str| -> Vec<f32> {
        let bare = value.split_once(">(").map_or(value, |v| v.1);
        let words = bare.split(|c: char| !(c.is_ascii_digit() || c == '.'));
        words.filter_map(|w| w.parse().ok()).collect()
    };
    let mut seen = 0;
    for line in shader.lines().filter(|l| l.starts_with("const WIND_")) {
        let (name, value) = line["const WIND_".len()..].split_once(':').expect("a type");
        let value = numbers(value.split_once('=').expect("a value").1);
        if name == "TAU" {
            assert_eq!(value, [core::f32::consts::TAU]);
            continue;
        }
        let same = cpu.lines().find(|l| {
            let bare = l.trim_start_matches("pub ");
            bare.strip_prefix("const ")
                .is_some_and(|l| l.starts_with(&format!("{name}:")))
        });
        let same = same.unwrap_or_else(|| panic!("{name} is not in src/wind.rs"));
        assert_eq!(
            value,
            numbers(same.split_once('=').expect("a value").1),
            "{name}"
        );
        seen += 1;
    }
    let all = cpu.lines().map(|l| l.trim_start_matches("pub "));
    let all = all
        .filter(|l| l.starts_with("const ") && !l.starts_with("const RIG"))
        .count();
    assert_eq!(seen, all, "constants of src/wind.rs that the shader lacks");
}
