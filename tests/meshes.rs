//! Meshes: the invariants of every species at every LOD, seams, bark coordinates, the same bytes at
//! any number of threads, and the checkers themselves.

mod common;

use common::{cases, descent, scripts, sketches, small, stand_ins};
use pleach::lod::{Selector, State};
use pleach::math::{Similarity, Vec3};
use pleach::mesh::{Coat, Flattener, Form, Mesh, Template, check, tube};
use pleach::species::schema::Lod;
use pleach::tree::{Branch, Part, Tree};
use proptest::prelude::*;

#[test]
fn every_species_has_sound_meshes_at_every_lod() {
    for script in scripts() {
        let tree = common::grown(&script.species, script.species.seed);
        check::junctions(&tree).unwrap_or_else(|fault| panic!("{}: {fault}", script.slug));
        let lod = &script.species.lod;
        let chain = Selector::new(&tree, lod).chain(&lod.budgets, true);
        let states = descent(&tree, lod).into_iter().map(|(state, _)| state);
        let chosen = chain.lods.into_iter().map(|lod| lod.state);
        let mut seen: Vec<State> = Vec::new();
        for state in states.chain(chosen) {
            if !seen.contains(&state) {
                let mesh = flat(&tree, &state, Coat::plain(script.species.bark.height_m()));
                check::mesh(&mesh).unwrap_or_else(|fault| {
                    panic!("{}: {}: {fault}", script.slug, state.describe(&tree))
                });
                seen.push(state);
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn species_drawn_by_chance_have_sound_meshes(sketch in sketches(true)) {
        let tree = sketch.tree();
        check::junctions(&tree).map_err(TestCaseError::fail)?;
        for (state, _) in descent(&tree, &Lod::default()) {
            check::mesh(&flat(&tree, &state, Coat::plain(0.5))).map_err(TestCaseError::fail)?;
        }
    }

    #[test]
    fn a_node_is_its_prototype_moved(sketch in sketches(true)) {
        // What the flattener writes for a whole tree is what the walk places node by node.
        let tree = sketch.tree();
        let form = stand_ins(&tree).form(&tree, &State::full(&tree), Coat::plain(0.5));
        let mesh = Flattener::new(&tree, &form).tree().expect("small");
        let (mut bark, mut foliage) = (mesh.bark.vertices.iter(), mesh.foliage.vertices.iter());
        for node in common::walk(&tree) {
            let Some(template) = &form.templates[node.level][node.prototype] else {
                continue;
            };
            for vertex in &template.vertices {
                let out = match template.material {
                    pleach::mesh::Material::Bark => bark.next(),
                    pleach::mesh::Material::Foliage => foliage.next(),
                };
                let out = out.expect("a vertex for each of the walk's");
                let at = node.place.point(vertex.axis + vertex.offset * node.thickness);
                prop_assert!(at.distance(Vec3::from(out.position)) < 2e-5, "{at} {out:?}");
                let normal = node.place.rotation * vertex.normal;
                prop_assert!(normal.distance(Vec3::from(out.normal)) < 2e-4, "{normal} {out:?}");
                prop_assert_eq!(vertex.uv, out.uv);
            }
        }
        prop_assert!(bark.next().is_none() && foliage.next().is_none());
    }
}

fn flat(tree: &Tree, state: &State, coat: Coat) -> Mesh {
    let form = stand_ins(tree).form(tree, state, coat);
    Flattener::new(tree, &form)
        .tree()
        .expect("a tree of this size can be flattened")
}

/// All branches of the species' scripts, with the names of script and level.
fn branches() -> Vec<(String, Branch)> {
    let mut branches = Vec::new();
    for script in scripts() {
        for level in common::grown(&script.species, script.species.seed).levels {
            for prototype in level.prototypes {
                if let Part::Branch(branch) = prototype.part {
                    branches.push((format!("{}: {}", script.slug, level.name), branch));
                }
            }
        }
    }
    branches
}

/// The rings of a tube's vertices, each with its corners: one vertex more, for the seam.
fn rows<'v, V>(branch: &Branch, lod: usize, vertices: &'v [V]) -> Vec<(&'v [V], usize)> {
    let mut rest = vertices;
    let row = |(_, sides): (usize, u32)| {
        let (row, after) = rest.split_at(sides as usize + 1);
        rest = after;
        (row, sides as usize)
    };
    branch.tube(lod).map(row).collect()
}

#[test]
fn seams_of_tubes_are_closed_to_the_bit() {
    for (name, branch) in branches() {
        for lod in 0..branch.rings.len() {
            let template = tube(&branch, lod, Coat::plain(0.5));
            for (row, sides) in rows(&branch, lod, &template.vertices) {
                let (first, last) = (&row[0], &row[sides]);
                assert_eq!(
                    (first.axis, first.offset, first.normal),
                    (last.axis, last.offset, last.normal),
                    "{name}, LOD {lod}"
                );
            }
            let turned = turned(&template);
            for (row, sides) in rows(&branch, lod, &turned.bark.vertices) {
                let (first, last) = (&row[0], &row[sides]);
                assert_eq!(first.position, last.position, "{name}, LOD {lod}, placed");
                assert_eq!(first.normal, last.normal, "{name}, LOD {lod}, placed");
            }
        }
    }
}

/// A template as the one part of a tree, placed askew.
fn turned(template: &Template) -> Mesh {
    let mut sketch = small();
    sketch.branches.truncate(1);
    let tree = sketch.tree();
    let form = Form {
        templates: vec![vec![Some(template.clone())], vec![None, None]],
        open: vec![false, false],
    };
    let place = Similarity {
        rotation: pleach::math::Quat::from_rotation_x(0.7)
            * pleach::math::Quat::from_rotation_y(2.0),
        translation: Vec3::new(0.3, 2.0, -1.0),
        scale: 0.37,
    };
    let mut mesh = Mesh::default();
    Flattener::new(&tree, &form)
        .write(0, 0, &place, 1.3, &mut mesh)
        .expect("small");
    mesh
}

#[test]
fn bark_does_not_swim_between_lods() {
    for (name, branch) in branches() {
        let finest = tube(&branch, 0, Coat::plain(0.5));
        let finest = rows(&branch, 0, &finest.vertices);
        for lod in 1..branch.rings.len() {
            let coarse = tube(&branch, lod, Coat::plain(0.5));
            let coarse = rows(&branch, lod, &coarse.vertices);
            for ((row, sides), (ring, _)) in coarse.into_iter().zip(branch.tube(lod)) {
                let twin = branch
                    .tube(0)
                    .position(|(r, _)| r == ring)
                    .unwrap_or_else(|| panic!("{name}: ring {ring} is not among the finest"));
                let (fine, finest_sides) = finest[twin];
                // The seam's two sides carry u = 0 and u = whole repeats.
                assert_eq!(row[0].uv, fine[0].uv, "{name}, LOD {lod}");
                assert_eq!(row[sides].uv, fine[finest_sides].uv, "{name}, LOD {lod}");
                assert_eq!(row[sides].uv[0].fract(), 0.0, "whole repeats");
                // A texel of bark stays at its angle about the stem.
                for side in 0..=sides {
                    let part = row[side].uv[0] / row[sides].uv[0];
                    let even = side as f32 / sides as f32;
                    assert!((part - even).abs() < 1e-6, "{name}, LOD {lod}");
                }
            }
        }
    }
}

#[test]
fn flattening_gives_the_same_bytes_at_any_number_of_threads() {
    for script in scripts() {
        let tree = common::grown(&script.species, script.species.seed);
        let state = State::full(&tree);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be started");
            pool.install(|| flat(&tree, &state, Coat::plain(0.5)))
        };
        let (one, two) = (on(1), on(2));
        for (a, b) in [(&one.bark, &two.bark), (&one.foliage, &two.foliage)] {
            let bytes = |p: &pleach::mesh::Primitive| -> Vec<u8> {
                [
                    bytemuck::cast_slice::<_, u8>(&p.vertices),
                    bytemuck::cast_slice(&p.indices),
                ]
                .concat()
            };
            assert!(bytes(a) == bytes(b), "{}", script.slug);
        }
    }
}

#[test]
fn buffers_are_reused_and_leave_nothing_behind() {
    let tree = small().tree();
    let form = stand_ins(&tree).form(&tree, &State::full(&tree), Coat::plain(0.5));
    let flattener = Flattener::new(&tree, &form);
    let fresh = flattener.tree().expect("small");
    let mut used = flattener.tree().expect("small");
    let at = used.foliage.vertices.as_ptr();
    for (level, place) in [(2, 1.0), (1, 0.5), (0, 1.0)] {
        let place = Similarity {
            scale: place,
            ..Similarity::IDENTITY
        };
        flattener
            .write(level, 0, &place, 1.0, &mut used)
            .expect("small");
    }
    assert_eq!(used, fresh);
    assert_eq!(used.foliage.vertices.as_ptr(), at, "the buffer was moved");
}

/// A sound mesh with one fault planted in it.
fn with_fault(plant: impl Fn(&mut Mesh)) -> Result<(), String> {
    let tree = small().tree();
    let mut mesh = flat(&tree, &State::full(&tree), Coat::plain(0.5));
    check::mesh(&mesh).expect("sound before the fault is planted");
    plant(&mut mesh);
    check::mesh(&mesh)
}

#[test]
fn the_mesh_checker_catches_planted_faults() {
    type Plant = fn(&mut Mesh);
    // What is planted, a word of the report, and how.
    let faults: [(&str, &str, Plant); 9] = [
        ("an index past the end", "past", |m| {
            m.bark.indices[7] = u32::MAX;
        }),
        ("a part of a triangle", "whole", |m| {
            m.foliage.indices.pop();
        }),
        ("an orphan", "no triangle", |m| {
            let copy = m.bark.vertices[0];
            m.bark.vertices.push(copy);
        }),
        ("NaN", "broken", |m| {
            m.foliage.vertices[3].position[1] = f32::NAN;
        }),
        ("an endless uv", "broken", |m| {
            m.bark.vertices[3].uv[0] = f32::INFINITY;
        }),
        ("a long normal", "broken", |m| {
            m.bark.vertices[5].normal = m.bark.vertices[5].normal.map(|x| x * 1.01);
        }),
        ("a handedness of 0", "broken", |m| {
            m.foliage.vertices[9].tangent[3] = 0.0;
        }),
        ("a tangent along the normal", "leans", |m| {
            let [x, y, z] = m.foliage.vertices[2].normal;
            m.foliage.vertices[2].tangent = [x, y, z, 1.0];
        }),
        ("a uv outside the atlas", "outside", |m| {
            m.foliage.vertices[1].uv[1] = 1.1;
        }),
    ];
    for (what, word, plant) in faults {
        let fault = with_fault(plant).expect_err(what);
        assert!(fault.contains(word), "{what}: {fault}");
    }
}

#[test]
fn the_junction_checker_catches_an_open_junction() {
    let mut tree = small().tree();
    check::junctions(&tree).expect("sound before the fault is planted");
    tree.levels[0].prototypes[0].links[2].thickness *= 4.0;
    let fault = check::junctions(&tree).expect_err("a ring as wide as its parent");
    assert!(fault.contains("b1"), "{fault}");
}

#[test]
fn a_junction_opens_when_the_parent_is_thinned() {
    let mut tree = small().tree();
    for link in &mut tree.levels[0].prototypes[0].links {
        link.thickness *= 0.3;
    }
    assert!(check::junctions(&tree).is_err());
}
