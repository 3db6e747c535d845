//! The bake: leaves into the atlas, then every capture of the plan.
//!
//! A capture is drawn either from the meshes below it (direct) or from the finished captures of a level
//! further out (hierarchical). Direct is the better picture; its cost goes with the number of leaves.
//! So a sub-tree is drawn directly up to a number of cards, and from captures beyond it, which keeps the
//! cost of a whole-tree capture bounded whatever the number of leaves.
//!
//! Changes versus the paper: a prototype is captured in its own frame, which is what relocating a node
//! by its inverse matrix gives; where a level below turns toward gravity, the frame is first turned as
//! the mean node of the level stands, so that the capture shows a typical one.

use super::backend::{Backend, Pass, Picture, Scene};
use super::cpu::Cpu;
use super::plan::{Plan, PlaneSet, Subject, VIEWS};
use super::raster::{Foliage, Textures};
use super::studio::{self, Node, Studio};
use crate::image::atlas::{self, Rect, Wanted};
use crate::image::cutouts::ALPHA_CUTOFF;
use crate::image::trim::trimmed;
use crate::image::{Image, Texel};
use crate::impostor::cross_quad::{CrossQuads, scaled};
use crate::math::{Bounds, Quat, Similarity, Vec3, float};
use crate::mesh::card::{Pane, Quad, UvRect};
use crate::mesh::{Coat, TooLarge};
use crate::report::{Cancelled, MachineFault, Progress, Warning};
use crate::tree::{Kind, Part, Tree};

/// How captures are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Edge of the atlas, texels. The largest capture gets about half of it.
    pub atlas_size: u32,
    /// Samples along each edge of a texel, 1..=4: smoother alpha for more time.
    pub supersample: u32,
    /// What captures are drawn from.
    pub source: Source,
}

/// What a capture of a sub-tree is drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Always the meshes of everything below.
    Direct,
    /// Always the captures of the next level, where there are some.
    Hierarchical,
    /// Meshes, as long as the sub-tree has at most so many leaf cards.
    DirectUpTo(u64),
}

impl Default for Settings {
    fn default() -> Self {
        // 150,000 cards take about as long to draw as all the rest of a pack.
        Self {
            atlas_size: 1024,
            supersample: 2,
            source: Source::DirectUpTo(150_000),
        }
    }
}

/// Mips that captures sample from: with gutters of four texels, the fourth would bleed.
const MIPS: usize = 4;

/// Wanted length of the longer edge, as a part of half the atlas, of combined captures by depth.
const COMBINED_SHARE: [f32; 5] = [1.0, 0.8, 0.65, 0.5, 0.4];

/// The same for single branches and for leaves.
const BRANCH_SHARE: f32 = 0.5;
const LEAF_SHARE: f32 = 0.45;

/// Density of sets of planes against the crossed quads of the same level.
const SET_SHARE: f32 = 0.8;

/// The part that is left of a capture that no LOD of the chain shows: it is there for other chains.
const UNUSED_SHARE: f32 = 0.4;

/// Wanted length of a combined capture's longer edge, as a part of half the atlas.
fn combined_share(tree: &Tree, level: usize) -> f32 {
    COMBINED_SHARE[tree.levels[level].depth.min(COMBINED_SHARE.len() - 1)]
}

/// A slim leaf gets at least this width as a part of its length, more texels across than along: in the mips that
/// engines make, a few columns would run into what lies beside them.
const SLIMMEST_LEAF: f32 = 0.3;

/// Draws the card of one leaf kind at a size in texels.
pub trait LeafArtwork: Sync {
    /// Width over height of a leaf kind's card.
    fn aspect(&self, kind: usize) -> f32;
    /// The card, stalk at the middle of the lower edge.
    fn draw(&self, kind: usize, width: u32, height: u32) -> Image<Texel>;
    /// How many leaf kinds there are.
    fn kinds(&self) -> usize;
}

/// Why captures could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// Too many parts for the atlas.
    #[error(
        "{parts} captures and leaves do not fit an atlas of {size} x {size} texels; raise \
         --texture-size or lower `variants`"
    )]
    AtlasTooSmall {
        /// Rectangles wanted.
        parts: usize,
        /// Edge of the atlas.
        size: u32,
    },
    /// A sub-tree is too large to be drawn.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The machine that a backend draws with failed.
    #[error(transparent)]
    Machine(#[from] MachineFault),
}

/// The foliage atlas with all that was captured into it.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The atlas; not yet dilated.
    pub atlas: Image<Texel>,
    /// Quads over the captures.
    pub quads: CrossQuads,
    /// Rectangles of the atlas: for each subject its two views, then one a leaf kind.
    pub rects: Vec<Rect>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// Captures everything in `plan` with the processor.
///
/// `bark` are the mips of the bark texture, and how it lies on stems.
///
/// # Errors
/// If the parts do not fit the atlas, a sub-tree is too large, or the work is cancelled.
pub fn bake(
    tree: &Tree,
    plan: &Plan,
    leaves: &dyn LeafArtwork,
    bark: (&[Image<Texel>], Coat),
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    bake_with(&Cpu, tree, plan, leaves, bark, settings, progress)
}

/// Captures everything in `plan` with a backend; see [`bake`].
///
/// # Errors
/// If the parts do not fit the atlas, a sub-tree is too large, the work is cancelled, or the backend's machine
/// fails.
pub fn bake_with(
    backend: &dyn Backend,
    tree: &Tree,
    plan: &Plan,
    leaves: &dyn LeafArtwork,
    bark: (&[Image<Texel>], Coat),
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    let rects = layout(tree, plan, leaves, settings.atlas_size)?;
    let mut warnings = crowding(&rects, plan, settings.atlas_size);
    let mut atlas = Image::filled(settings.atlas_size, settings.atlas_size, Texel::EMPTY);
    let kinds = leaves.kinds();
    let leaf_rects = &rects[plan.captures()..plan.captures() + kinds];
    let panes = draw_leaves(&mut atlas, leaf_rects, leaves);
    let quads = CrossQuads::none(tree, panes);
    let sources = sources(tree, plan, settings.source);
    warnings.extend(from_captures(tree, &sources));
    progress.begin("captures", (plan.subjects.len() + plan.sets.len()) as u64);
    let mut stage = Stage {
        backend,
        tree,
        plan,
        bark,
        settings,
        rects: &rects,
        leaves: leaf_rects,
        turns: standing(tree),
        thickness: tree.mean_thickness(),
        sources,
        atlas,
        quads,
        progress,
    };
    for pass in stage.passes() {
        stage.subjects(&pass)?;
    }
    stage.planes()?;
    let Stage { atlas, quads, .. } = stage;
    Ok(Baked {
        atlas,
        quads,
        rects,
        warnings,
    })
}

/// A warning for each level whose captures others are drawn from.
fn from_captures(tree: &Tree, sources: &[Option<usize>]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for &level in sources.iter().flatten() {
        let level = tree.levels[level].name.clone();
        let warning = Warning::CapturesFromCaptures { level };
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings
}

/// What all captures need, and what was captured so far.
struct Stage<'a> {
    backend: &'a dyn Backend,
    tree: &'a Tree,
    plan: &'a Plan,
    /// Mips of the bark, and how it lies on stems.
    bark: (&'a [Image<Texel>], Coat),
    settings: &'a Settings,
    /// Rectangles of all captures.
    rects: &'a [Rect],
    /// Those of the leaf kinds.
    leaves: &'a [Rect],
    turns: Vec<Quat>,
    thickness: Vec<Vec<f32>>,
    sources: Vec<Option<usize>>,
    atlas: Image<Texel>,
    quads: CrossQuads,
    progress: &'a dyn Progress,
}

impl Stage<'_> {
    /// The subjects, outermost first: a pass may sample what the passes before it wrote.
    fn passes(&self) -> Vec<Vec<usize>> {
        let mut passes: Vec<Vec<usize>> = vec![Vec::new()];
        let mut by_depth: Vec<usize> = (0..self.plan.subjects.len()).collect();
        by_depth.sort_by_key(|&s| core::cmp::Reverse(depth(self.tree, self.plan.subjects[s])));
        for subject in by_depth {
            match self.sources[subject] {
                None => passes[0].push(subject),
                Some(_) => passes.push(vec![subject]),
            }
        }
        passes.retain(|pass| !pass.is_empty());
        passes
    }

    /// Captures subjects into the atlas.
    fn subjects(&mut self, pass: &[usize]) -> Result<(), BakeError> {
        let from_captures = pass.iter().any(|&index| self.sources[index].is_some());
        let pyramid = self.pyramid();
        let scene = |studio: &Studio<'_>, at: usize| {
            let index = pass[at];
            let pair = [&self.rects[index * VIEWS], &self.rects[index * VIEWS + 1]];
            let subject = self.plan.subjects[index];
            let (level, prototype) = subject_at(subject);
            let node = Node {
                turn: self.turns[level],
                thickness: self.thickness[level][prototype],
                cross: self.plan.turns[level][prototype],
            };
            studio.scene(subject, self.sources[index], node, pair)
        };
        let drawn = self.draw(pass.len(), (&pyramid, from_captures), &scene)?;
        self.atlas = pyramid.into_atlas();
        for (&index, pictures) in pass.iter().zip(drawn) {
            let rects = &self.rects[index * VIEWS..];
            let quads = self.hang(pictures, rects);
            let pair = <[Quad; VIEWS]>::try_from(quads).expect("a picture for each view");
            if let Subject::Combined { level, prototype } = self.plan.subjects[index] {
                self.quads.combined[level][prototype] = Some(pair);
            } else {
                assign_branches(&mut self.quads, self.plan, index, &pair);
            }
        }
        Ok(())
    }

    /// Captures all sets of planes into the atlas.
    fn planes(&mut self) -> Result<(), BakeError> {
        let sets = &self.plan.sets;
        if sets.is_empty() {
            return Ok(());
        }
        let pyramid = self.pyramid();
        let mut first = self.plan.captures() + self.leaves.len();
        let firsts: Vec<usize> = sets
            .iter()
            .map(|set| {
                first += set.planes.len();
                first - set.planes.len()
            })
            .collect();
        // Planes that pick their leaves need the leaves; those that show all may show captures.
        let source = |set: &PlaneSet| {
            if set.planes.iter().any(|p| p.members.is_some()) {
                return None;
            }
            let of = self.plan.combined(set.level, set.prototype);
            of.and_then(|subject| self.sources[subject])
        };
        let scene = |studio: &Studio<'_>, at: usize| {
            let set = &sets[at];
            let node = Node {
                turn: self.turns[set.level],
                thickness: self.thickness[set.level][set.prototype],
                cross: 0.0,
            };
            studio.scene_of_planes(set, source(set), node, &self.rects[firsts[at]..])
        };
        let from_captures = sets.iter().any(|set| source(set).is_some());
        let drawn = self.draw(sets.len(), (&pyramid, from_captures), &scene)?;
        self.atlas = pyramid.into_atlas();
        for (pictures, first) in drawn.into_iter().zip(firsts) {
            let set = self.hang(pictures, &self.rects[first..]);
            self.quads.sets.push(set);
        }
        Ok(())
    }

    /// Mips of the atlas as it stands; the atlas itself moves into them, and is to be put back.
    fn pyramid(&mut self) -> Foliage {
        let atlas = core::mem::replace(&mut self.atlas, Image::filled(0, 0, Texel::EMPTY));
        Foliage::of(atlas, MIPS)
    }

    /// Draws one pass with mips of the atlas, of which only the leaves are shown, or captures as well.
    fn draw(
        &self,
        scenes: usize,
        (pyramid, from_captures): (&Foliage, bool),
        scene: &(dyn Fn(&Studio<'_>, usize) -> Result<Scene, BakeError> + Sync),
    ) -> Result<Vec<Vec<Picture>>, BakeError> {
        let reliefs = self.quads.reliefs();
        let studio = Studio {
            tree: self.tree,
            quads: &self.quads,
            coat: self.bark.1,
            supersample: self.settings.supersample,
        };
        let pass = Pass {
            textures: Textures {
                bark: self.bark.0,
                foliage: pyramid,
                reliefs: &reliefs,
            },
            parts: if from_captures {
                self.rects
            } else {
                self.leaves
            },
            supersample: self.settings.supersample,
            scenes,
            scene: &|at| scene(&studio, at),
        };
        self.backend.draw(&pass, self.progress)
    }

    /// Copies pictures into their rectangles; gives the quads that show them.
    fn hang(&mut self, pictures: Vec<Picture>, rects: &[Rect]) -> Vec<Quad> {
        let mut quads = Vec::new();
        for (picture, rect) in pictures.into_iter().zip(rects) {
            let capture = studio::mounted(picture);
            copy_into(&mut self.atlas, rect, &capture.image);
            quads.push(Quad {
                pane: pane(rect, self.settings.atlas_size, &capture.image),
                ..capture.quad
            });
        }
        quads
    }
}

/// Texels along an edge of the sheet of leaves.
const LEAF_SHEET: u32 = 512;

/// All leaf kinds on a sheet of their own.
#[derive(Clone, Debug)]
pub struct LeafSheet {
    /// The sheet.
    pub image: Image<Texel>,
    /// Part of it of each leaf kind.
    pub rects: Vec<Rect>,
    /// What is seen of each.
    pub panes: Vec<Pane>,
}

/// All leaf kinds on a small sheet: enough to measure with before there is an atlas, and to draw a tree at full
/// detail.
///
/// # Errors
/// If there are too many kinds.
pub fn leaf_sheet(leaves: &dyn LeafArtwork) -> Result<LeafSheet, BakeError> {
    let wanted: Vec<Wanted> = (0..leaves.kinds())
        .map(|kind| {
            let aspect = leaves.aspect(kind);
            let longer = float(LEAF_SHEET) * LEAF_SHARE * 0.5;
            Wanted {
                width: longer * aspect.clamp(SLIMMEST_LEAF, 1.0),
                height: longer / aspect.max(1.0),
            }
        })
        .collect();
    let rects = atlas::layout(LEAF_SHEET, &wanted).ok_or(BakeError::AtlasTooSmall {
        parts: wanted.len(),
        size: LEAF_SHEET,
    })?;
    let mut image = Image::filled(LEAF_SHEET, LEAF_SHEET, Texel::EMPTY);
    let panes = draw_leaves(&mut image, &rects, leaves);
    Ok(LeafSheet {
        image,
        rects,
        panes,
    })
}

/// Draws the leaf kinds into their parts of an atlas.
fn draw_leaves(atlas: &mut Image<Texel>, rects: &[Rect], leaves: &dyn LeafArtwork) -> Vec<Pane> {
    let mut panes = Vec::new();
    for (kind, rect) in rects.iter().enumerate() {
        let (width, height) = inner_size(rect);
        let image = leaves.draw(kind, width, height);
        copy_into(atlas, rect, &image);
        panes.push(pane(rect, atlas.width(), &image));
    }
    panes
}

/// Gives a branch type's quads to all prototypes of that type.
fn assign_branches(quads: &mut CrossQuads, plan: &Plan, subject: usize, pair: &[Quad; 2]) {
    for (level, prototypes) in plan.branch_types.iter().enumerate() {
        for (prototype, of_type) in prototypes.iter().enumerate() {
            if let Some((_, factor)) = of_type.filter(|(s, _)| *s == subject) {
                quads.branches[level][prototype] = Some(scaled(pair, factor));
            }
        }
    }
}

pub(super) fn subject_at(subject: Subject) -> (usize, usize) {
    match subject {
        Subject::Combined { level, prototype } | Subject::Branch { level, prototype } => {
            (level, prototype)
        }
    }
}

fn depth(tree: &Tree, subject: Subject) -> usize {
    tree.levels[subject_at(subject).0].depth
}

/// For each subject, the level whose captures it is drawn from; `None` to draw it directly.
fn sources(tree: &Tree, plan: &Plan, source: Source) -> Vec<Option<usize>> {
    let limit = match source {
        Source::Direct => u64::MAX,
        Source::Hierarchical => 0,
        Source::DirectUpTo(limit) => limit,
    };
    let choose = |&subject: &Subject| {
        let Subject::Combined { level, prototype } = subject else {
            return None;
        };
        let below = tree.nodes_below(level, prototype).nodes;
        let cards = |l: usize| tree.levels[l].kind == Kind::Leaf && tree.is_below(l, level);
        let leaves: u64 = (0..tree.levels.len())
            .filter(|&l| cards(l))
            .map(|l| below[l])
            .sum();
        if leaves <= limit {
            return None;
        }
        // The outermost level below that has captures and few enough nodes; else the next one.
        let has_captures = |l: usize| {
            l != level
                && tree.is_below(l, level)
                && tree.levels[l].kind != Kind::Leaf
                && tree.has_children(l)
        };
        let candidates = (0..tree.levels.len()).filter(|&l| has_captures(l));
        candidates
            .clone()
            .filter(|&l| below[l] <= limit)
            .max_by_key(|&l| tree.levels[l].depth)
            .or_else(|| candidates.min_by_key(|&l| tree.levels[l].depth))
    };
    plan.subjects.iter().map(choose).collect()
}

/// Rectangles for all views of all subjects, then for all leaf kinds.
fn layout(
    tree: &Tree,
    plan: &Plan,
    leaves: &dyn LeafArtwork,
    size: u32,
) -> Result<Vec<Rect>, BakeError> {
    let extents = tree.extents();
    let half = float(size) * 0.5;
    let mut wanted = Vec::new();
    for (&subject, &small) in plan.subjects.iter().zip(&plan.small) {
        let (level, prototype) = subject_at(subject);
        let (bounds, share) = match subject {
            Subject::Combined { .. } => {
                let back = Similarity {
                    rotation: Quat::from_rotation_y(-plan.turns[level][prototype]),
                    ..Similarity::IDENTITY
                };
                (
                    extents[level][prototype].bounds(&back),
                    combined_share(tree, level),
                )
            }
            Subject::Branch { .. } => (
                part_bounds(&tree.prototype(level, prototype).part),
                BRANCH_SHARE,
            ),
        };
        let share = if small { share * UNUSED_SHARE } else { share };
        let size = bounds.size().max(Vec3::splat(1e-6));
        for width in [size.x, size.z] {
            let density = half * share / width.max(size.y);
            wanted.push(Wanted {
                width: width * density,
                height: size.y * density,
            });
        }
    }
    for kind in 0..leaves.kinds() {
        let aspect = leaves.aspect(kind);
        let longer = half * LEAF_SHARE;
        wanted.push(Wanted {
            width: longer * aspect.clamp(SLIMMEST_LEAF, 1.0),
            height: longer / aspect.max(1.0),
        });
    }
    for set in &plan.sets {
        let bounds = extents[set.level][set.prototype].bounds(&Similarity::IDENTITY);
        let share = combined_share(tree, set.level) * SET_SHARE;
        let density = half * share / bounds.size().max_element().max(1e-6);
        wanted.extend(set.planes.iter().map(|plane| Wanted {
            width: 2.0 * plane.half[0] * density,
            height: 2.0 * plane.half[1] * density,
        }));
    }
    atlas::layout(size, &wanted).ok_or(BakeError::AtlasTooSmall {
        parts: wanted.len(),
        size,
    })
}

fn part_bounds(part: &Part) -> Bounds {
    let Part::Branch(branch) = part else {
        return Bounds::EMPTY;
    };
    branch.axis.iter().fold(Bounds::EMPTY, |bounds, sample| {
        let radius = Vec3::splat(sample.radius);
        bounds
            .with_point(sample.position - radius)
            .with_point(sample.position + radius)
    })
}

/// A warning if the largest capture has too few texels to look like anything.
fn crowding(rects: &[Rect], plan: &Plan, size: u32) -> Vec<Warning> {
    const FEWEST: u32 = 48;
    let largest = rects[..plan.captures()]
        .iter()
        .map(|r| r.width.max(r.height))
        .max()
        .unwrap_or(0);
    if largest < FEWEST {
        vec![Warning::AtlasCrowded { size, largest }]
    } else {
        Vec::new()
    }
}

/// The rectangle without its transparent border of one texel.
pub(super) fn inner_size(rect: &Rect) -> (u32, u32) {
    (rect.width - 2, rect.height - 2)
}

fn uv_of(rect: &Rect, size: u32) -> UvRect {
    let part = |texels: u32| float(texels) / float(size);
    UvRect {
        u0: part(rect.x + 1),
        v0: part(rect.y + 1),
        u1: part(rect.x + rect.width - 1),
        v1: part(rect.y + rect.height - 1),
    }
}

/// Corners may lie so many texels outside of a part of the atlas: over its border and half of its gutter. The
/// next part is seven texels away then, so no mip of less than that brings it in.
const TRIM_OVER: f32 = 3.0;

/// An image at its place in an atlas, trimmed to what it shows.
fn pane(rect: &Rect, size: u32, image: &Image<Texel>) -> Pane {
    let is_there = |x, y| image.at(x, y).alpha >= ALPHA_CUTOFF;
    Pane {
        uv: uv_of(rect, size),
        corners: trimmed((image.width(), image.height()), TRIM_OVER, is_there),
    }
}

fn copy_into(atlas: &mut Image<Texel>, rect: &Rect, image: &Image<Texel>) {
    for y in 0..image.height() {
        for x in 0..image.width() {
            *atlas.at_mut(rect.x + 1 + x, rect.y + 1 + y) = *image.at(x, y);
        }
    }
}

/// By level: the turn in which its mean node stands in the world, where that matters for what it
/// carries (a level below turns toward gravity); else no turn.
#[must_use]
pub fn standing(tree: &Tree) -> Vec<Quat> {
    /// Nodes looked at; the mean of more would hardly differ.
    const NODES: usize = 4096;
    let mut ups = vec![Vec3::ZERO; tree.levels.len()];
    let mut queue = std::collections::VecDeque::from([(0_usize, 0_usize, Similarity::IDENTITY)]);
    let mut seen = vec![0_usize; tree.levels.len()];
    while let Some((level, prototype, place)) = queue.pop_front() {
        ups[level] += place.rotation.conjugate() * Vec3::Y;
        for link in &tree.prototype(level, prototype).links {
            let next = link.level as usize;
            if seen[next] < NODES && tree.levels[next].kind != Kind::Leaf {
                seen[next] += 1;
                queue.push_back((next, link.prototype as usize, tree.place(&place, link)));
            }
        }
    }
    let turn = |(level, up): (usize, &Vec3)| {
        let up = up.normalize_or(Vec3::Y);
        // A mean that points straight down has no shortest way up; any half turn will do.
        if tree.turns_below(level) {
            Quat::from_rotation_arc(up, Vec3::Y)
        } else {
            Quat::IDENTITY
        }
    };
    ups.iter().enumerate().map(turn).collect()
}
