//! A sub-tree in front of the measuring camera, with the nodes of one level exchangeable.
//!
//! How bad a form of a level looks depends on what surrounds it, so a form is tried on the nodes that one
//! parent carries, with everything else at full detail. Silhouettes of parts unite, so what does not change
//! is drawn once.

use super::silhouette::{Cutouts, Silhouette, seen_bounds};
use super::views::{Direction, calibration, sphere};
use crate::capture::{CAPTURE_SPLINE_LOD, View};
use crate::impostor::cross_quad::CrossQuads;
use crate::impostor::planes::Plane;
use crate::impostor::planes::strips::{self, Strip};
use crate::lod::{Form as LodForm, State};
use crate::math::{Bounds, Quat, Similarity, Vec3};
use crate::mesh::card::{Quad, UvRect};
use crate::mesh::{Flattener, Form, Mesh, TooLarge, card};
use crate::tree::{Kind, Tree};
use rayon::prelude::*;

/// Samples along the longer side of a sub-tree's pictures.
const SUBTREE_SAMPLES: f32 = 128.0;

/// Samples along the height of the whole tree's pictures.
const TREE_SAMPLES: f32 = 160.0;

/// Texels of a trial capture along each edge of a sample.
const TRIAL_DENSITY: f32 = 2.0;

/// Views on sub-trees, from all around: nodes stand at any angle.
const SUBTREE_VIEWS: usize = 6;

/// What all measuring of one tree needs.
pub(super) struct Gauge<'a> {
    pub(super) tree: &'a Tree,
    /// Leaf kinds' places in `cutouts`.
    pub(super) quads: &'a CrossQuads,
    pub(super) cutouts: &'a Cutouts,
    /// How the mean node of each level stands, where that matters.
    pub(super) turns: &'a [Quat],
    /// Triangle budgets.
    pub(super) budgets: &'a [u64],
}

/// Reference and exchangeable nodes of one measurement.
pub(super) struct Context {
    /// Pictures are taken with these.
    pub(super) views: Vec<View>,
    /// Everything but what is exchanged.
    rest: Vec<Silhouette>,
    /// Everything.
    pub(super) full: Vec<Silhouette>,
    /// Nodes of the prototype that is exchanged.
    pub(super) nodes: Vec<Similarity>,
    /// Edge of a sample, metres.
    pub(super) sample: f32,
}

/// The whole tree as seen from some views.
pub(super) struct Whole {
    views: Vec<View>,
    full: Vec<Silhouette>,
    sample: f32,
}

impl Whole {
    /// Mean covered area of full detail, square metres.
    pub(super) fn area(&self) -> f32 {
        let sum: u64 = self.full.iter().map(Silhouette::area).sum();
        real(sum) * self.sample * self.sample / real(self.views.len().max(1) as u64)
    }
}

/// How a form compares with full detail in a context.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// Area covered in one and not in the other, mean over views, square metres at scale 1 of a node.
    pub(super) error: f32,
    /// Covered area over full detail's.
    pub(super) coverage: f32,
    /// The same from the first views and from the last third of them: from the side and from above, for the
    /// whole tree.
    pub(super) parts: [f32; 2],
}

impl Gauge<'_> {
    /// A prototype's sub-tree in its own frame, its own level at spline LOD 1; `keep` says which levels and
    /// prototypes show their own part and which are open.
    fn form(&self, level: usize) -> Form {
        let tree = self.tree;
        let form = |l: usize| {
            if !tree.is_below(l, level) {
                return LodForm::Inside;
            }
            let out = tree.levels[l].depth - tree.levels[level].depth;
            LodForm::Geometry(u8::try_from(CAPTURE_SPLINE_LOD + out).unwrap_or(u8::MAX))
        };
        let state = State {
            forms: (0..tree.levels.len()).map(form).collect(),
        };
        self.quads.form(tree, &state, 1.0)
    }

    fn flatten(&self, form: &Form, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        let turn = self.turns[level];
        let place = Similarity {
            rotation: turn,
            ..Similarity::IDENTITY
        };
        let mut mesh = Mesh::default();
        Flattener::new(self.tree, form).write(level, prototype, &place, 1.0, &mut mesh)?;
        if turn != Quat::IDENTITY {
            let back = turn.conjugate();
            let vertices = mesh.bark.vertices.iter_mut();
            for vertex in vertices.chain(&mut mesh.foliage.vertices) {
                vertex.position = (back * Vec3::from(vertex.position)).to_array();
                vertex.normal = (back * Vec3::from(vertex.normal)).to_array();
            }
        }
        Ok(mesh)
    }

    /// Everything that a prototype stands for.
    pub(super) fn subtree(&self, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        self.flatten(&self.form(level), level, prototype)
    }

    /// The same with its own branch laid along +Y.
    pub(super) fn straightened(&self, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        let (form, seat) = (self.form(level), (level, prototype));
        let standing = (self.turns[level], 1.0);
        strips::straightened(self.tree, &form, seat, (CAPTURE_SPLINE_LOD, 1.0), standing)
    }

    /// A prototype's sub-tree without its own branch.
    fn without_own(&self, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        let mut form = self.form(level);
        form.templates[level][prototype] = None;
        self.flatten(&form, level, prototype)
    }

    /// A prototype's sub-tree without the nodes of a level below it.
    fn without_level(
        &self,
        (level, prototype): (usize, usize),
        below: usize,
    ) -> Result<Mesh, TooLarge> {
        let mut form = self.form(level);
        form.templates[below].iter_mut().for_each(|t| *t = None);
        form.open[below] = false;
        self.flatten(&form, level, prototype)
    }

    /// Nodes of `below` under one node of a prototype, by their prototype.
    fn nodes(&self, at: (usize, usize), below: usize) -> Vec<Vec<Similarity>> {
        let mut nodes = vec![Vec::new(); self.tree.levels[below].prototypes.len()];
        let turn = self.turns[at.0];
        let place = Similarity {
            rotation: turn,
            ..Similarity::IDENTITY
        };
        let back = Similarity {
            rotation: turn.conjugate(),
            ..Similarity::IDENTITY
        };
        self.collect(at, below, &place, &mut |prototype, place| {
            nodes[prototype].push(back.then_inner(place));
        });
        nodes
    }

    fn collect(
        &self,
        (level, prototype): (usize, usize),
        below: usize,
        place: &Similarity,
        found: &mut impl FnMut(usize, &Similarity),
    ) {
        if level == below {
            found(prototype, place);
            return;
        }
        for link in &self.tree.prototype(level, prototype).links {
            let next = link.level as usize;
            if self.tree.is_below(below, next) {
                let place = self.tree.place(place, link);
                self.collect((next, link.prototype as usize), below, &place, found);
            }
        }
    }

    /// The context in which a prototype's own branch is exchanged: its sub-tree.
    pub(super) fn own_part(&self, level: usize, prototype: usize) -> Result<Context, TooLarge> {
        let full = self.subtree(level, prototype)?;
        let rest = self.without_own(level, prototype)?;
        Ok(self.context(level, &full, &rest, vec![Similarity::IDENTITY]))
    }

    /// The context in which whole nodes of a prototype are exchanged: one parent with all its children if
    /// there is one with at most `limit` cards, else the node alone.
    pub(super) fn whole_node(
        &self,
        (level, prototype): (usize, usize),
        limit: u64,
    ) -> Result<Context, TooLarge> {
        let Some(parent) = self.parent((level, prototype), limit) else {
            let full = self.subtree(level, prototype)?;
            return Ok(self.context(level, &full, &Mesh::default(), vec![Similarity::IDENTITY]));
        };
        let full = self.subtree(parent.0, parent.1)?;
        let mut rest = vec![(
            self.without_level(parent, level)?,
            vec![Similarity::IDENTITY],
        )];
        let mut nodes = self.nodes(parent, level);
        let own = core::mem::take(&mut nodes[prototype]);
        for (other, places) in nodes.into_iter().enumerate() {
            if !places.is_empty() {
                rest.push((self.subtree(level, other)?, places));
            }
        }
        let views = self.views(parent.0, &full);
        let draw = |view: &View| {
            let mut silhouette = Silhouette::empty(view);
            for (mesh, places) in &rest {
                for place in places {
                    silhouette.add(mesh, place, self.cutouts, view);
                }
            }
            silhouette
        };
        Ok(Context {
            rest: views.0.par_iter().map(draw).collect(),
            full: silhouettes(&full, self.cutouts, &views.0),
            views: views.0,
            nodes: own,
            sample: views.1,
        })
    }

    fn context(&self, level: usize, full: &Mesh, rest: &Mesh, nodes: Vec<Similarity>) -> Context {
        let (views, sample) = self.views(level, full);
        Context {
            rest: silhouettes(rest, self.cutouts, &views),
            full: silhouettes(full, self.cutouts, &views),
            views,
            nodes,
            sample,
        }
    }

    /// Views on a sub-tree: the calibration views on the whole tree, others from all around.
    fn views(&self, level: usize, mesh: &Mesh) -> (Vec<View>, f32) {
        let size = mesh.bounds().size();
        let (directions, sample) = if level == 0 {
            // A carpet seen from above must not ask for more samples than a tree.
            let height = size.y.max(size.max_element() * 0.25);
            (calibration(), height / TREE_SAMPLES)
        } else {
            (sphere(SUBTREE_VIEWS), size.max_element() / SUBTREE_SAMPLES)
        };
        let sample = sample.max(1e-6);
        // Quads may reach a little outside.
        let air = Vec3::splat(size.max_element() * 0.1);
        let view = |direction: &Direction| {
            let seen = seen_bounds(mesh, direction);
            let seen = Bounds {
                min: seen.min - air,
                max: seen.max + air,
            };
            direction.view(&seen, sample)
        };
        (directions.iter().map(view).collect(), sample)
    }

    /// Full detail of the whole tree from every other calibration view.
    pub(super) fn whole_tree(&self) -> Result<Whole, TooLarge> {
        let full = self.subtree(0, 0)?;
        let (views, sample) = self.views(0, &full);
        let views: Vec<View> = views.into_iter().step_by(2).collect();
        Ok(Whole {
            full: silhouettes(&full, self.cutouts, &views),
            views,
            sample,
        })
    }

    /// The error of the whole tree with all nodes of a level as crossed quads, square metres. `crosses` gives
    /// each prototype's quads with their scale; those without stay as they are.
    pub(super) fn level_error(
        &self,
        whole: &Whole,
        level: usize,
        crosses: &[Option<(&[TrialQuad], f32)>],
    ) -> Result<f32, TooLarge> {
        let rest = self.without_level((0, 0), level)?;
        let nodes = self.nodes((0, 0), level);
        let mut drawn: Vec<(Vec<Mesh>, Vec<&Cutouts>)> = Vec::new();
        for (prototype, cross) in crosses.iter().enumerate() {
            drawn.push(match cross {
                Some((quads, scale)) => (
                    quads.iter().map(|q| q.mesh(*scale)).collect(),
                    quads.iter().map(|q| &q.cutouts).collect(),
                ),
                None => (vec![self.subtree(level, prototype)?], vec![self.cutouts]),
            });
        }
        let miss = |(view, full): (&View, &Silhouette)| {
            let mut silhouette = Silhouette::of(&rest, self.cutouts, view);
            for (places, (meshes, cutouts)) in nodes.iter().zip(&drawn) {
                for place in places {
                    for (mesh, cutouts) in meshes.iter().zip(cutouts) {
                        silhouette.add(mesh, place, cutouts, view);
                    }
                }
            }
            full.difference(&silhouette)
        };
        let misses: Vec<u64> = whole.views.par_iter().zip(&whole.full).map(miss).collect();
        let views = real(whole.views.len().max(1) as u64);
        Ok(real(misses.iter().sum()) * whole.sample * whole.sample / views)
    }

    /// The parent of at most `limit` cards that carries a prototype.
    fn parent(&self, (level, prototype): (usize, usize), limit: u64) -> Option<(usize, usize)> {
        let parent = self.tree.levels[level].parent?;
        let carries = |p: &usize| {
            let links = &self.tree.prototype(parent, *p).links;
            links
                .iter()
                .any(|l| (l.level as usize, l.prototype as usize) == (level, prototype))
        };
        let found = (0..self.tree.levels[parent].prototypes.len()).find(carries)?;
        (cards(self.tree, parent, found) <= limit).then_some((parent, found))
    }
}

/// Leaf cards below a prototype.
pub(super) fn cards(tree: &Tree, level: usize, prototype: usize) -> u64 {
    let below = tree.nodes_below(level, prototype).nodes;
    let levels = tree.levels.iter().zip(below);
    levels
        .filter(|(l, _)| l.kind == Kind::Leaf)
        .map(|(_, n)| n)
        .sum()
}

fn silhouettes(mesh: &Mesh, cutouts: &Cutouts, views: &[View]) -> Vec<Silhouette> {
    views
        .par_iter()
        .map(|view| Silhouette::of(mesh, cutouts, view))
        .collect()
}

/// A trial capture: a quad with its own little texture of coverage.
pub(super) struct TrialQuad {
    quad: Quad,
    cutouts: Cutouts,
}

impl TrialQuad {
    /// Captures what a plane shows.
    pub(super) fn of(part: &Mesh, plane: &Plane, cutouts: &Cutouts, sample: f32) -> Self {
        let count = |half: f32| {
            crate::math::floor_to_u32((2.0 * half / sample * TRIAL_DENSITY).min(2048.0)).max(1)
        };
        let view = View {
            centre: plane.centre,
            right: plane.right,
            up: plane.up,
            half: plane.half,
            width: count(plane.half[0]),
            height: count(plane.half[1]),
        };
        let mut silhouette = Silhouette::empty(&view);
        silhouette.add(part, &Similarity::IDENTITY, cutouts, &view);
        Self {
            quad: Quad {
                centre: plane.centre,
                right: plane.right,
                up: plane.up,
                half: plane.half,
                thick: 0.0,
                captured_thickness: 1.0,
                uv: UvRect::ALL,
            },
            cutouts: Cutouts::from_silhouette(silhouette),
        }
    }

    fn mesh(&self, scale: f32) -> Mesh {
        card::quads(&[self.quad.scaled(scale)]).placed(&Similarity::IDENTITY, 1.0)
    }
}

impl Context {
    /// Draws the exchangeable nodes as quads, scaled by `scale`.
    pub(super) fn try_quads(&self, quads: &[TrialQuad], scale: f32) -> Trial {
        self.try_scaled(quads, &vec![scale; quads.len()])
    }

    /// The same with a scale for each quad.
    pub(super) fn try_scaled(&self, quads: &[TrialQuad], scales: &[f32]) -> Trial {
        let scaled = quads.iter().zip(scales);
        let meshes: Vec<Mesh> = scaled.map(|(q, &scale)| q.mesh(scale)).collect();
        self.try_meshes(quads, &meshes)
    }

    /// Draws the exchangeable nodes as strips with the pictures of quads, widened by `scale`.
    pub(super) fn try_strips(&self, quads: &[TrialQuad], strips: &[Strip], scale: f32) -> Trial {
        let bent = strips.iter().map(|strip| {
            let strip = core::slice::from_ref(strip);
            strips::template(strip, &[UvRect::ALL], &[scale])
        });
        let meshes: Vec<Mesh> = bent
            .map(|template| template.placed(&Similarity::IDENTITY, 1.0))
            .collect();
        self.try_meshes(quads, &meshes)
    }

    /// Draws the exchangeable nodes as meshes with the pictures of quads.
    fn try_meshes(&self, quads: &[TrialQuad], meshes: &[Mesh]) -> Trial {
        self.compare(|silhouette, node, view| {
            for (mesh, quad) in meshes.iter().zip(quads) {
                silhouette.add(mesh, node, &quad.cutouts, view);
            }
        })
    }

    /// Draws the exchangeable nodes as a mesh, or as nothing.
    pub(super) fn try_mesh(&self, mesh: Option<&Mesh>, cutouts: &Cutouts) -> Trial {
        self.compare(|silhouette, node, view| {
            if let Some(mesh) = mesh {
                silhouette.add(mesh, node, cutouts, view);
            }
        })
    }

    fn compare(&self, draw: impl Fn(&mut Silhouette, &Similarity, &View) + Sync) -> Trial {
        let sums: Vec<[u64; 3]> = (0..self.views.len())
            .into_par_iter()
            .map(|i| {
                let mut silhouette = self.rest[i].clone();
                for node in &self.nodes {
                    draw(&mut silhouette, node, &self.views[i]);
                }
                let full = &self.full[i];
                [full.difference(&silhouette), silhouette.area(), full.area()]
            })
            .collect();
        let sum = |k: usize| real(sums.iter().map(|s| s[k]).sum());
        let views = real(self.views.len() as u64);
        let first = sums.len() - sums.len() / 3;
        let scales: f32 = self.nodes.iter().map(|n| n.scale * n.scale).sum();
        Trial {
            error: sum(0) * self.sample * self.sample / views / scales.max(1e-12),
            coverage: sum(1) / sum(2).max(1.0),
            parts: [0..first, first..sums.len()].map(|range| {
                let part = |k: usize| real(sums[range.clone()].iter().map(|s| s[k]).sum());
                part(1) / part(2).max(1.0)
            }),
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a mean needs few digits")]
fn real(count: u64) -> f32 {
    count as f32
}
