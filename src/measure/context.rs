//! A sub-tree in front of the measuring camera, with the nodes of one level exchangeable.
//!
//! How bad a form of a level looks depends on what surrounds it, so a form is tried on the nodes that one
//! parent carries, with everything else at full detail. Silhouettes of parts unite, so what does not change
//! is drawn once.

use super::MeasureError;
use super::silhouette::{Cutouts, Silhouette, seen_bounds};
use super::views::{Direction, calibration, sphere};
use crate::capture::{CAPTURE_SPLINE_LOD, View};
use crate::image::trim::trimmed;
use crate::impostor::cross_quad::CrossQuads;
use crate::impostor::planes::Plane;
use crate::impostor::planes::strips::{self, Strip};
use crate::lod::{Form as LodForm, State};
use crate::math::{Bounds, Quat, Similarity, Vec3};
use crate::mesh::card::{Pane, Quad, UvRect};
use crate::mesh::{Coat, Flattener, Form, Mesh, TooLarge, card};
use crate::report::{Cancelled, Progress};
use crate::tree::{Kind, Tree};
use rayon::prelude::*;
use std::borrow::Cow;

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
    /// Edge of the atlas, texels.
    pub(super) atlas_size: u32,
    /// Asked whether to give up.
    pub(super) progress: &'a dyn Progress,
}

/// What all trials on a tree look at, drawn once.
pub(super) struct Scenes {
    /// By level and prototype; none for leaves.
    scenes: Vec<Vec<Option<Scene>>>,
    /// By level and prototype of the parent: the nodes of the level that it carries, if they are measured in it.
    families: Vec<Vec<Option<Family>>>,
}

/// Everything that a prototype stands for, by itself.
pub(super) struct Scene {
    pub(super) mesh: Mesh,
    /// Pictures are taken with these.
    views: Vec<View>,
    /// Everything.
    full: Vec<Silhouette>,
    /// Edge of a sample, metres.
    sample: f32,
}

/// The nodes of one level under one parent, in the parent's views.
struct Family {
    /// The parent without these nodes.
    rest: Vec<Silhouette>,
    /// By prototype: its nodes, and all of them drawn.
    members: Vec<(Vec<Similarity>, Vec<Silhouette>)>,
}

/// Reference and exchangeable nodes of one measurement.
pub(super) struct Context<'a> {
    scene: &'a Scene,
    /// Everything but what is exchanged.
    rest: Vec<Silhouette>,
    /// Nodes of the prototype that is exchanged.
    nodes: &'a [Similarity],
    /// Edge of a sample, metres.
    pub(super) sample: f32,
}

/// A node by itself.
const ALONE: &[Similarity] = &[Similarity::IDENTITY];

impl Scenes {
    /// A prototype that is no leaf.
    pub(super) fn of(&self, (level, prototype): (usize, usize)) -> Option<&Scene> {
        self.scenes[level][prototype].as_ref()
    }
}

impl Scene {
    /// Mean covered area, square metres, of every other view.
    pub(super) fn area(&self) -> f32 {
        let seen = || self.full.iter().step_by(2);
        let sum: u64 = seen().map(Silhouette::area).sum();
        real(sum) * self.sample * self.sample / real(seen().count().max(1) as u64)
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
        self.quads.form(tree, &state, Coat::plain(1.0))
    }

    /// Fails once the work should be given up.
    pub(super) fn go_on(&self) -> Result<(), Cancelled> {
        if self.progress.cancelled() {
            return Err(Cancelled);
        }
        Ok(())
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
    fn subtree(&self, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        self.flatten(&self.form(level), level, prototype)
    }

    /// The same with its own branch laid along +Y.
    pub(super) fn straightened(&self, level: usize, prototype: usize) -> Result<Mesh, TooLarge> {
        let (form, seat) = (self.form(level), (level, prototype));
        let standing = (self.turns[level], 1.0);
        strips::straightened(
            self.tree,
            &form,
            seat,
            (CAPTURE_SPLINE_LOD, Coat::plain(1.0)),
            standing,
        )
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

    /// Draws what all trials look at. Sub-trees of more than `limit` cards are looked at by themselves, others
    /// with their siblings.
    pub(super) fn scenes(&self, limit: u64) -> Result<Scenes, MeasureError> {
        let levels = &self.tree.levels;
        let seats: Vec<(usize, usize)> = (0..levels.len())
            .filter(|&level| levels[level].kind != Kind::Leaf)
            .flat_map(|level| (0..levels[level].prototypes.len()).map(move |p| (level, p)))
            .collect();
        let drawn: Result<Vec<Scene>, MeasureError> =
            seats.par_iter().map(|&seat| self.scene(seat)).collect();
        let mut scenes = Scenes {
            scenes: rows(self.tree),
            families: levels
                .iter()
                .map(|l| rows_of(l.parent.map_or(0, |p| levels[p].prototypes.len())))
                .collect(),
        };
        for (&(level, prototype), scene) in seats.iter().zip(drawn?) {
            scenes.scenes[level][prototype] = Some(scene);
        }
        let mut parents: Vec<(usize, (usize, usize))> = seats
            .iter()
            .filter(|seat| self.tree.has_children(seat.0))
            .filter_map(|&seat| Some((seat.0, self.parent(seat, limit)?)))
            .collect();
        parents.sort_unstable();
        parents.dedup();
        let families: Result<Vec<Family>, MeasureError> = parents
            .par_iter()
            .map(|&(level, parent)| self.family(&scenes, level, parent))
            .collect();
        for ((level, parent), family) in parents.into_iter().zip(families?) {
            scenes.families[level][parent.1] = Some(family);
        }
        Ok(scenes)
    }

    fn scene(&self, (level, prototype): (usize, usize)) -> Result<Scene, MeasureError> {
        self.go_on()?;
        let mesh = self.subtree(level, prototype)?;
        let (views, sample) = self.views(level, &mesh);
        Ok(Scene {
            full: self.silhouettes(&mesh, &views)?,
            mesh,
            views,
            sample,
        })
    }

    fn family(
        &self,
        scenes: &Scenes,
        level: usize,
        parent: (usize, usize),
    ) -> Result<Family, MeasureError> {
        let views = scenes.of(parent).map_or(&[][..], |s| &s.views);
        let rest = self.silhouettes(&self.without_level(parent, level)?, views)?;
        let nodes = self.nodes(parent, level).into_iter().enumerate();
        let members: Result<Vec<_>, MeasureError> = nodes
            .map(|(prototype, places)| {
                let scene = scenes.of((level, prototype)).filter(|_| !places.is_empty());
                let Some(scene) = scene else {
                    return Ok((places, Vec::new()));
                };
                let draw = |view: &View| {
                    let mut silhouette = Silhouette::empty(view);
                    for place in &places {
                        self.go_on()?;
                        silhouette.add(&scene.mesh, place, self.cutouts, view);
                    }
                    Ok(silhouette)
                };
                let drawn: Result<Vec<Silhouette>, MeasureError> =
                    views.par_iter().map(draw).collect();
                Ok((places, drawn?))
            })
            .collect();
        Ok(Family {
            rest,
            members: members?,
        })
    }

    /// The context in which a prototype's own branch is exchanged: its sub-tree.
    pub(super) fn own_part<'s>(
        &self,
        scene: &'s Scene,
        (level, prototype): (usize, usize),
    ) -> Result<Context<'s>, MeasureError> {
        let rest = self.without_own(level, prototype)?;
        Ok(Context {
            rest: self.silhouettes(&rest, &scene.views)?,
            scene,
            nodes: ALONE,
            sample: scene.sample,
        })
    }

    /// The context in which whole nodes of a prototype are exchanged: one parent with all its children if
    /// there is one with at most `limit` cards, else the node alone.
    pub(super) fn whole_node<'s>(
        &self,
        scenes: &'s Scenes,
        scene: &'s Scene,
        seat: (usize, usize),
        limit: u64,
    ) -> Context<'s> {
        let parent = self.parent(seat, limit);
        let family =
            parent.and_then(|p| Some((scenes.of(p)?, scenes.families[seat.0][p.1].as_ref()?)));
        let Some((scene, family)) = family else {
            return Context {
                rest: scene.views.iter().map(Silhouette::empty).collect(),
                scene,
                nodes: ALONE,
                sample: scene.sample,
            };
        };
        let mut rest = family.rest.clone();
        for (other, (_, drawn)) in family.members.iter().enumerate() {
            if other != seat.1 {
                rest.iter_mut()
                    .zip(drawn)
                    .for_each(|(all, drawn)| all.unite(drawn));
            }
        }
        Context {
            rest,
            scene,
            nodes: &family.members[seat.1].0,
            sample: scene.sample,
        }
    }

    fn silhouettes(&self, mesh: &Mesh, views: &[View]) -> Result<Vec<Silhouette>, Cancelled> {
        let views = views.par_iter();
        views
            .map(|view| {
                self.go_on()?;
                Ok(Silhouette::of(mesh, self.cutouts, view))
            })
            .collect()
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

    /// The error of the whole tree with all nodes of a level as crossed quads, square metres. `crosses` gives
    /// each prototype's quads with their scale; those without stay as they are.
    pub(super) fn level_error(
        &self,
        scenes: &Scenes,
        level: usize,
        crosses: &[Option<(&[TrialQuad], f32)>],
    ) -> Result<f32, MeasureError> {
        let Some(whole) = scenes.of((0, 0)) else {
            return Ok(0.0);
        };
        let rest = self.without_level((0, 0), level)?;
        let nodes = self.nodes((0, 0), level);
        let mut drawn: Vec<(Vec<Cow<'_, Mesh>>, Vec<&Cutouts>)> = Vec::new();
        for (prototype, cross) in crosses.iter().enumerate() {
            let scene = scenes.of((level, prototype));
            drawn.push(match cross {
                Some((quads, scale)) => (
                    quads.iter().map(|q| Cow::Owned(q.mesh(*scale))).collect(),
                    quads.iter().map(|q| &q.cutouts).collect(),
                ),
                None => (
                    scene.iter().map(|s| Cow::Borrowed(&s.mesh)).collect(),
                    vec![self.cutouts],
                ),
            });
        }
        let miss = |(view, full): (&View, &Silhouette)| {
            let mut silhouette = Silhouette::of(&rest, self.cutouts, view);
            for (places, (meshes, cutouts)) in nodes.iter().zip(&drawn) {
                for place in places {
                    self.go_on()?;
                    for (mesh, cutouts) in meshes.iter().zip(cutouts) {
                        silhouette.add(mesh, place, cutouts, view);
                    }
                }
            }
            Ok(full.difference(&silhouette))
        };
        // Every other view tells enough.
        let views: Vec<(&View, &Silhouette)> =
            whole.views.iter().zip(&whole.full).step_by(2).collect();
        let misses: Result<Vec<u64>, Cancelled> =
            views.par_iter().map(|&view| miss(view)).collect();
        let count = real(views.len().max(1) as u64);
        Ok(real(misses?.iter().sum()) * whole.sample * whole.sample / count)
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

/// Nothing yet, by level and prototype.
fn rows<T>(tree: &Tree) -> Vec<Vec<Option<T>>> {
    let levels = tree.levels.iter();
    levels.map(|l| rows_of(l.prototypes.len())).collect()
}

fn rows_of<T>(count: usize) -> Vec<Option<T>> {
    core::iter::repeat_with(|| None).take(count).collect()
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
                pane: Pane {
                    corners: trimmed((view.width, view.height), 0.0, |x, y| {
                        silhouette.covered[y as usize * view.width as usize + x as usize]
                    }),
                    ..Pane::ALL
                },
            },
            cutouts: silhouette.cutouts(),
        }
    }

    fn mesh(&self, scale: f32) -> Mesh {
        card::quads(&[self.quad.scaled(scale)]).placed(&Similarity::IDENTITY, 1.0)
    }
}

impl Context<'_> {
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
        let Scene { views, full, .. } = self.scene;
        let sums: Vec<[u64; 3]> = (0..views.len())
            .into_par_iter()
            .map(|i| {
                let mut silhouette = self.rest[i].clone();
                for node in self.nodes {
                    draw(&mut silhouette, node, &views[i]);
                }
                let (both, either) = full[i].overlap(&silhouette);
                [either - both, silhouette.area(), full[i].area()]
            })
            .collect();
        let sum = |k: usize| real(sums.iter().map(|s| s[k]).sum());
        let views = real(views.len() as u64);
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
