//! What several test files share: species drawn by chance, the scripts of `species/`, stand-in
//! quads, and the walk over all nodes of a tree.

#![allow(dead_code, reason = "each test file uses its own part of it")]

#[cfg(feature = "gpu")]
pub(crate) mod adapter;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;

use std::path::{Path, PathBuf};

use pleach::impostor::cross_quad::{CrossQuads, RIGHT};
use pleach::lod::{Selector, State, Triangles};
use pleach::math::{Similarity, Vec3};
use pleach::mesh::card::{Pane, Quad};
use pleach::species::schema::{
    Bark, BarkArt, BarkPattern, Blade, BranchParams, Curve, Habit, Knots, LeafArt, LeafKind,
    LeafLook, LeafParams, Level, LevelKind, Lod, Param, Placement, Size, Species, Spline, Stems,
};
use pleach::species::{self, Beside};
use pleach::tree::{Limits, Tree, grow};
use proptest::prelude::*;

/// So many cases, drawn from the seed in `.cargo/config.toml`; a failing one is printed small enough to be kept
/// as a test.
pub(crate) fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// A species in few numbers, so that a failing case is short to read.
#[derive(Clone, Debug)]
pub(crate) struct Sketch {
    pub(crate) seed: u64,
    pub(crate) stems: Option<u32>,
    pub(crate) roots: bool,
    /// The trunk and what grows on it in turn; the first one's `links` and `children` do not count.
    pub(crate) branches: Vec<BranchSketch>,
    pub(crate) leaves: LeafSketch,
}

/// One branch level of a [`Sketch`].
#[derive(Clone, Debug)]
pub(crate) struct BranchSketch {
    pub(crate) links: u32,
    pub(crate) children: u32,
    pub(crate) variants: u32,
    pub(crate) splines: usize,
    pub(crate) gnarl: f32,
    pub(crate) vary: f32,
    pub(crate) sides: u32,
    pub(crate) tropism: f32,
    /// Levels that the last place skips; none where none grows on it.
    pub(crate) skip: u32,
    pub(crate) pipe_model: f32,
}

/// The leaf level of a [`Sketch`].
#[derive(Clone, Debug)]
pub(crate) struct LeafSketch {
    pub(crate) links: u32,
    pub(crate) children: u32,
    pub(crate) kinds: usize,
    pub(crate) tropism: f32,
}

/// Hundredths: short to read, and drawn without `proptest`'s ranges of floats, which may panic.
fn parts(range: core::ops::RangeInclusive<i16>) -> impl Strategy<Value = f32> {
    range.prop_map(|hundredths| f32::from(hundredths) / 100.0)
}

/// Nodes that a sketch has at most at any level: what a test can walk in a moment.
const MOST_NODES: u32 = 1500;

/// Sketches of 2 to 5 levels; `tropism` says whether levels may turn their nodes.
pub(crate) fn sketches(tropism: bool) -> impl Strategy<Value = Sketch> {
    let turn = move || {
        if tropism {
            prop_oneof![2 => Just(0.0), 1 => parts(-100..=100)].boxed()
        } else {
            Just(0.0_f32).boxed()
        }
    };
    let branch = (
        (1..=6_u32, 1..=3_u32, 1..=3_u32, 1..=3_usize),
        prop_oneof![Just(0.0_f32), parts(0..=15)],
        parts(5..=40),
        3..=9_u32,
        turn(),
        prop_oneof![2 => Just(0_u32), 1 => 1..=2_u32],
        prop_oneof![Just(0.0_f32), parts(0..=100)],
    )
        .prop_map(
            |(
                (links, children, variants, splines),
                gnarl,
                vary,
                sides,
                tropism,
                skip,
                pipe_model,
            )| BranchSketch {
                links,
                children,
                variants,
                splines,
                gnarl,
                vary,
                sides,
                tropism,
                skip,
                pipe_model,
            },
        );
    let leaves = (1..=6_u32, 1..=3_u32, 1..=3_usize, turn()).prop_map(
        |(links, children, kinds, tropism)| LeafSketch {
            links,
            children,
            kinds,
            tropism,
        },
    );
    (
        any::<u64>(),
        prop_oneof![3 => Just(None), 1 => (1..=4_u32).prop_map(Some)],
        any::<bool>(),
        prop::collection::vec(branch, 1..=4),
        leaves,
    )
        .prop_map(|(seed, stems, roots, branches, leaves)| {
            let mut sketch = Sketch {
                seed,
                stems,
                roots,
                branches,
                leaves,
            };
            sketch.branches[0].tropism = 0.0;
            let last = u32::try_from(sketch.branches.len() - 1).expect("a few levels");
            for (below, branch) in (0..=last).rev().zip(&mut sketch.branches) {
                branch.skip = branch.skip.min(below);
            }
            sketch.thin_out();
            sketch
        })
}

impl Sketch {
    /// Lowers links from the outermost level inward until no level has too many nodes.
    fn thin_out(&mut self) {
        let mut parents = self.stems.unwrap_or(1);
        for branch in self.branches.iter_mut().skip(1) {
            if parents * branch.links * branch.children > MOST_NODES {
                (branch.links, branch.children) = (1, 2);
            }
            parents *= branch.links * branch.children;
        }
        if parents * self.leaves.links * self.leaves.children > 2 * MOST_NODES {
            (self.leaves.links, self.leaves.children) = (1, 2);
        }
    }

    /// The species that the sketch stands for. Levels are called `b0`, `b1`, ..., `leaves` and `roots`;
    /// the roots stand right after the trunk, so that they shift the place of all other levels.
    pub(crate) fn species(&self) -> Species {
        let roots_at = self.roots.then_some(1_usize);
        let index = |branch: usize| match roots_at {
            Some(at) if branch >= at => branch + 1,
            _ => branch,
        };
        let mut levels: Vec<Level> = Vec::new();
        for (number, branch) in self.branches.iter().enumerate() {
            levels.push(Level {
                name: format!("b{number}"),
                parent: number.checked_sub(1).map(index),
                placement: Placement {
                    skip: Curve {
                        points: vec![(0.0, 0.0), (1.0, skip_of(branch))],
                    },
                    ..placement(branch.links, branch.children, branch.vary, branch.tropism)
                },
                kind: LevelKind::Branch(branch_params(branch, number == 0)),
            });
            if roots_at == Some(number + 1) {
                levels.push(roots());
            }
        }
        let LeafSketch {
            links,
            children,
            kinds,
            tropism,
        } = self.leaves;
        levels.push(Level {
            name: "leaves".to_owned(),
            parent: Some(index(self.branches.len() - 1)),
            placement: placement(links, children, 0.2, tropism),
            kind: LevelKind::Leaf(LeafParams {
                kinds: [(0, 1.0), (1, 0.5), (2, 2.0)][..kinds].to_vec(),
            }),
        });
        Species {
            name: "Sketch".to_owned(),
            latin: String::new(),
            slug: "sketch".to_owned(),
            seed: self.seed,
            age: 1.0,
            habit: Habit::Open,
            season: 1.0,
            variations: Vec::new(),
            stems: self.stems.map(|count| Stems {
                count,
                spread_m: 0.4,
                lean: Param {
                    vary: 4.0,
                    ..Param::constant(9.0)
                },
                scale: Param {
                    vary: 0.2,
                    ..Param::constant(1.0)
                },
            }),
            levels,
            splines: splines(),
            leaves: vec![
                leaf("flat", 0.0, 0.12),
                leaf("folded", 25.0, 0.2),
                leaf("wide", 0.0, 0.3),
            ],
            bark: bark(),
            lod: Lod::default(),
            files: Vec::new(),
        }
    }

    /// The tree of the sketch's own seed.
    pub(crate) fn tree(&self) -> Tree {
        grown(&self.species(), self.seed)
    }
}

/// Grows a species that is known to be sound.
pub(crate) fn grown(species: &Species, seed: u64) -> Tree {
    grow(species, seed, &Limits::default()).expect("a sketch grows")
}

fn placement(links: u32, children: u32, vary: f32, tropism: f32) -> Placement {
    let degrees = |at: f32, step: f32| Param {
        at: Curve::constant(at),
        step,
        vary: vary * 40.0,
    };
    let size = |points: &[(f32, f32)]| Param {
        at: Curve {
            points: points.to_vec(),
        },
        step: 0.0,
        vary: vary * 0.5,
    };
    Placement {
        links,
        children,
        start: 0.25,
        end: 1.0,
        jitter: vary,
        crowding: 0.9,
        skip: Curve::constant(0.0),
        around: degrees(10.0, 137.5),
        down: degrees(50.0, 0.0),
        sideways: degrees(0.0, 0.0),
        spin: degrees(0.0, 0.0),
        scale: size(&[(0.2, 1.0), (1.0, 0.7)]),
        thickness: size(&[(0.0, 1.0)]),
        tropism,
        envelope: None,
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few levels")]
fn skip_of(branch: &BranchSketch) -> f32 {
    // One place alone is the first, which skips nothing.
    branch.skip as f32
}

fn branch_params(branch: &BranchSketch, trunk: bool) -> BranchParams {
    BranchParams {
        variants: if trunk { 1 } else { branch.variants },
        splines: [(0, 1.0), (1, 2.0), (2, 0.5)][..branch.splines].to_vec(),
        length: if trunk {
            Size::Metres(3.0)
        } else {
            Size::OfParent(0.5)
        },
        length_vary: branch.vary * 0.5,
        radius: if trunk {
            Size::Metres(0.2)
        } else {
            Size::OfParent(0.5)
        },
        taper: Curve {
            points: vec![(0.0, 1.0), (1.0, 0.35)],
        },
        pipe_model: branch.pipe_model,
        gnarl: branch.gnarl,
        collar: 1.3,
        flare: None,
        flutes: None,
        sides: branch.sides,
    }
}

fn roots() -> Level {
    let root = BranchSketch {
        links: 1,
        children: 3,
        variants: 1,
        splines: 1,
        gnarl: 0.05,
        vary: 0.1,
        sides: 5,
        tropism: 0.0,
        skip: 0,
        pipe_model: 0.0,
    };
    let mut placement = placement(1, 3, 0.1, 0.0);
    (placement.start, placement.end) = (0.05, 0.05);
    placement.down = Param::constant(110.0);
    Level {
        name: "roots".to_owned(),
        parent: Some(0),
        placement,
        kind: LevelKind::Branch(branch_params(&root, false)),
    }
}

fn splines() -> Vec<Spline> {
    let spline = |name: &str, points: &[[f32; 3]]| Spline {
        name: name.to_owned(),
        points: points.to_vec(),
        knots: Knots::Centripetal,
    };
    vec![
        spline("straight", &[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        spline(
            "bent",
            &[
                [0.0, 0.0, 0.0],
                [0.1, 1.0, 0.05],
                [-0.1, 2.0, 0.2],
                [0.0, 3.0, 0.5],
            ],
        ),
        spline(
            "arched",
            &[[0.0, 0.0, 0.0], [0.05, 1.0, 0.3], [0.0, 1.4, 1.2]],
        ),
    ]
}

fn leaf(name: &str, fold_deg: f32, length_m: f32) -> LeafKind {
    LeafKind {
        name: name.to_owned(),
        length_m,
        width_m: length_m * 0.5,
        fold_deg,
        look: LeafLook::Drawn(LeafArt {
            blade: Blade {
                widest: 0.4,
                ..Blade::default()
            },
            colour: Some([0.1, 0.3, 0.05]),
            colour_vary: 0.1,
            stalk_colour: [0.2, 0.1, 0.05],
            gloss: 0.3,
            translucency: Some(0.3),
            ..LeafArt::default()
        }),
    }
}

fn bark() -> Bark {
    Bark::Drawn(BarkArt {
        pattern: BarkPattern::Smooth {
            wrinkles: 0.3,
            lenticels: 0.2,
            scars: 0.1,
        },
        light: [0.4, 0.35, 0.3],
        dark: [0.1, 0.08, 0.06],
        accent: [0.05, 0.04, 0.03],
        young: [0.2, 0.2, 0.1],
        mature_radius_m: 0.0,
        height_m: 0.5,
        depth_m: 0.01,
        width_m: 0.1,
        length_m: 0.1,
        age: 1.0,
        roughness: 0.8,
        lichen: 0.0,
        moss: 0.0,
    })
}

/// A small tree of four plain levels: 6 limbs, 48 twigs, 576 leaves.
pub(crate) fn small() -> Sketch {
    let branch = |links, children, splines, sides| BranchSketch {
        links,
        children,
        variants: 1,
        splines,
        gnarl: 0.04,
        vary: 0.2,
        sides,
        tropism: 0.0,
        skip: 0,
        pipe_model: 0.0,
    };
    Sketch {
        seed: 5,
        stems: None,
        roots: false,
        branches: vec![branch(1, 1, 1, 9), branch(3, 2, 2, 6), branch(4, 2, 1, 4)],
        leaves: LeafSketch {
            links: 6,
            children: 2,
            kinds: 2,
            tropism: 0.0,
        },
    }
}

/// A script of `species/`.
pub(crate) struct Script {
    pub(crate) slug: String,
    pub(crate) folder: PathBuf,
    pub(crate) text: String,
    pub(crate) species: Species,
}

/// A broadleaf, a column and a palm: the species whose LODs tests measure. What holds for all species is asserted of
/// the program (`end_to_end`) and by the gates of CI, which go over all of `species/`.
const MEASURED: [&str; 3] = ["lombardy_poplar", "olive", "palm"];

/// The scripts of the measured species, by file name.
pub(crate) fn scripts() -> Vec<Script> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
    let named = MEASURED.map(|name| folder.join(format!("{name}.ron")));
    named.iter().map(|path| script(path)).collect()
}

/// All scripts that are shipped, by name.
pub(crate) fn all_scripts() -> Vec<Script> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
    let entries = std::fs::read_dir(folder).expect("the folder of scripts");
    let paths = entries.map(|entry| entry.expect("a file's name").path());
    let mut paths: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "ron"))
        .collect();
    paths.sort();
    paths.iter().map(|path| script(path)).collect()
}

fn script(path: &Path) -> Script {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).expect("a script can be read");
    let folder = path.parent().expect("a file has a folder").to_owned();
    let species = species::parse(&name, &text, &Beside(folder.clone()))
        .unwrap_or_else(|faults| panic!("{}", faults.render(false)));
    Script {
        slug: species.slug.clone(),
        folder,
        text,
        species,
    }
}

/// A quad of one square metre for every sub-tree and every branch: each state can be flattened
/// without a capture.
pub(crate) fn stand_ins(tree: &Tree) -> CrossQuads {
    let quads = RIGHT.map(|right| Quad {
        centre: Vec3::Y * 0.5,
        right,
        up: Vec3::Y,
        half: [0.5, 0.5],
        thick: 0.1,
        captured_thickness: 1.0,
        pane: Pane::ALL,
    });
    let all: Vec<Vec<Option<[Quad; 2]>>> = tree
        .levels
        .iter()
        .map(|level| vec![Some(quads); level.prototypes.len()])
        .collect();
    CrossQuads {
        combined: all.clone(),
        branches: all,
        sets: Vec::new(),
        leaves: Vec::new(),
    }
}

/// Every state that falling budgets can reach, led by full detail: each one is what a budget of one
/// triangle less than the one before gets.
pub(crate) fn descent(tree: &Tree, lod: &Lod) -> Vec<(State, Triangles)> {
    let selector = Selector::new(tree, lod);
    let full = State::full(tree);
    let triangles = pleach::lod::Counts::of(tree, lod.tolerances.len()).triangles(tree, &full);
    let mut states = vec![(full, triangles)];
    while let Some(next) = {
        let last = &states[states.len() - 1];
        selector
            .select(last, last.1.total().saturating_sub(1))
            .cloned()
    } {
        states.push(next);
    }
    states
}

/// One node of a tree, as the walk meets it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) level: usize,
    pub(crate) prototype: usize,
    pub(crate) thickness: f32,
    pub(crate) place: Similarity,
    /// Index of the first node after its sub-tree.
    pub(crate) end: usize,
}

/// All nodes, each before what grows on it, placed by [`Tree::place`] from the root.
pub(crate) fn walk(tree: &Tree) -> Vec<Node> {
    let mut nodes = Vec::new();
    visit(tree, 0, 0, 1.0, Similarity::IDENTITY, &mut nodes);
    nodes
}

fn visit(
    tree: &Tree,
    level: usize,
    prototype: usize,
    thickness: f32,
    place: Similarity,
    nodes: &mut Vec<Node>,
) {
    let index = nodes.len();
    nodes.push(Node {
        level,
        prototype,
        thickness,
        place,
        end: 0,
    });
    for link in &tree.prototype(level, prototype).links {
        visit(
            tree,
            link.level as usize,
            link.prototype as usize,
            link.thickness,
            tree.place(&place, link),
            nodes,
        );
    }
    nodes[index].end = nodes.len();
}
