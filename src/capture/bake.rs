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

use super::plan::{Plan, Subject, VIEWS};
use super::raster::{ALPHA_CUTOFF, Textures};
use super::studio::{Node, Shot, Studio};
use crate::image::atlas::{self, Rect, Wanted};
use crate::image::{Image, Texel, mips};
use crate::impostor::cross_quad::{CrossQuads, scaled};
use crate::math::{Bounds, Quat, Similarity, Vec3, float};
use crate::mesh::TooLarge;
use crate::mesh::card::{Quad, UvRect};
use crate::report::{Cancelled, Progress, Warning};
use crate::tree::{Kind, Part, Tree};
use rayon::prelude::*;

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

/// A slim leaf gets at least this width as a part of its length, more texels across than along: a few
/// columns would sink below the alpha cutoff in the mips that engines make.
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

/// Captures everything in `plan`.
///
/// `bark` are the mips of the bark texture, `bark_height` the real height of one repeat in metres.
///
/// # Errors
/// If the parts do not fit the atlas, a sub-tree is too large, or the work is cancelled.
pub fn bake(
    tree: &Tree,
    plan: &Plan,
    leaves: &dyn LeafArtwork,
    bark: (&[Image<Texel>], f32),
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    let rects = layout(tree, plan, leaves, settings.atlas_size)?;
    let mut warnings = crowding(&rects, plan, settings.atlas_size);
    let mut atlas = Image::filled(settings.atlas_size, settings.atlas_size, Texel::EMPTY);
    let kinds = leaves.kinds();
    let leaf_rects = &rects[plan.captures()..plan.captures() + kinds];
    for (kind, rect) in leaf_rects.iter().enumerate() {
        let (width, height) = inner_size(rect);
        copy_into(&mut atlas, rect, &leaves.draw(kind, width, height));
    }
    let uv = |rect: &Rect| uv_of(rect, settings.atlas_size);
    let mut quads = CrossQuads::none(tree, leaf_rects.iter().map(uv).collect());
    progress.begin("captures", plan.subjects.len() as u64);
    let turns = standing(tree);
    let thickness = tree.mean_thickness();
    let sources = sources(tree, plan, settings.source);
    for &level in sources.iter().flatten() {
        let level = tree.levels[level].name.clone();
        if !warnings
            .iter()
            .any(|w| matches!(w, Warning::CapturesFromCaptures { level: l } if *l == level))
        {
            warnings.push(Warning::CapturesFromCaptures { level });
        }
    }
    // Outermost first: a pass may sample what the passes before it wrote.
    let mut passes: Vec<Vec<usize>> = vec![Vec::new()];
    let mut by_depth: Vec<usize> = (0..plan.subjects.len()).collect();
    by_depth.sort_by_key(|&s| core::cmp::Reverse(depth(tree, plan.subjects[s])));
    for subject in by_depth {
        match sources[subject] {
            None => passes[0].push(subject),
            Some(_) => passes.push(vec![subject]),
        }
    }
    for pass in passes.iter().filter(|p| !p.is_empty()) {
        let mut pyramid = mips::chain(atlas, MIPS, ALPHA_CUTOFF);
        let reliefs = quads.reliefs();
        let drawn: Result<Vec<[Shot; VIEWS]>, BakeError> = pass
            .par_iter()
            .map(|&index| {
                if progress.cancelled() {
                    return Err(Cancelled.into());
                }
                let studio = Studio {
                    tree,
                    quads: &quads,
                    textures: Textures {
                        bark: bark.0,
                        foliage: &pyramid,
                        reliefs: &reliefs,
                    },
                    bark_height: bark.1,
                    supersample: settings.supersample,
                };
                let pair = [&rects[index * VIEWS], &rects[index * VIEWS + 1]];
                let (level, prototype) = subject_at(plan.subjects[index]);
                let node = Node {
                    turn: turns[level],
                    thickness: thickness[level][prototype],
                    cross: plan.turns[level][prototype],
                };
                let shots = studio.shoot(plan.subjects[index], sources[index], node, pair);
                progress.step();
                shots
            })
            .collect();
        let drawn = drawn?;
        atlas = pyramid.swap_remove(0);
        for (&index, shots) in pass.iter().zip(drawn) {
            let pair = core::array::from_fn(|view| {
                let rect = &rects[index * VIEWS + view];
                copy_into(&mut atlas, rect, &shots[view].image);
                Quad {
                    uv: uv_of(rect, settings.atlas_size),
                    ..shots[view].quad
                }
            });
            if let Subject::Combined { level, prototype } = plan.subjects[index] {
                quads.combined[level][prototype] = Some(pair);
            } else {
                assign_branches(&mut quads, plan, index, &pair);
            }
        }
    }
    let stage = Stage {
        tree,
        plan,
        rects: &rects[plan.captures() + kinds..],
        turns: &turns,
        thickness: &thickness,
        sources: &sources,
    };
    atlas = stage.planes(atlas, &mut quads, bark, settings, progress)?;
    Ok(Baked {
        atlas,
        quads,
        rects,
        warnings,
    })
}

/// What the captures of planes need.
struct Stage<'a> {
    tree: &'a Tree,
    plan: &'a Plan,
    /// Rectangles of the planes.
    rects: &'a [Rect],
    turns: &'a [Quat],
    thickness: &'a [Vec<f32>],
    sources: &'a [Option<usize>],
}

impl Stage<'_> {
    /// Captures all sets of planes into the atlas.
    fn planes(
        &self,
        atlas: Image<Texel>,
        quads: &mut CrossQuads,
        bark: (&[Image<Texel>], f32),
        settings: &Settings,
        progress: &dyn Progress,
    ) -> Result<Image<Texel>, BakeError> {
        if self.plan.sets.is_empty() {
            return Ok(atlas);
        }
        let mut pyramid = mips::chain(atlas, MIPS, ALPHA_CUTOFF);
        let reliefs = quads.reliefs();
        let mut first = 0;
        let firsts: Vec<usize> = self
            .plan
            .sets
            .iter()
            .map(|set| {
                first += set.planes.len();
                first - set.planes.len()
            })
            .collect();
        let drawn: Result<Vec<Vec<Shot>>, BakeError> = self
            .plan
            .sets
            .par_iter()
            .zip(&firsts)
            .map(|(set, &first)| {
                if progress.cancelled() {
                    return Err(Cancelled.into());
                }
                let studio = Studio {
                    tree: self.tree,
                    quads,
                    textures: Textures {
                        bark: bark.0,
                        foliage: &pyramid,
                        reliefs: &reliefs,
                    },
                    bark_height: bark.1,
                    supersample: settings.supersample,
                };
                let node = Node {
                    turn: self.turns[set.level],
                    thickness: self.thickness[set.level][set.prototype],
                    cross: 0.0,
                };
                // Planes that pick their leaves need the leaves; those that show all may show captures.
                let source = if set.planes.iter().any(|p| p.members.is_some()) {
                    None
                } else {
                    let of = self.plan.combined(set.level, set.prototype);
                    of.and_then(|subject| self.sources[subject])
                };
                studio.shoot_planes(set, source, node, &self.rects[first..])
            })
            .collect();
        let drawn = drawn?;
        let mut atlas = pyramid.swap_remove(0);
        for (shots, first) in drawn.into_iter().zip(firsts) {
            let set = shots
                .into_iter()
                .zip(&self.rects[first..])
                .map(|(shot, rect)| {
                    copy_into(&mut atlas, rect, &shot.image);
                    Quad {
                        uv: uv_of(rect, settings.atlas_size),
                        ..shot.quad
                    }
                });
            quads.sets.push(set.collect());
        }
        Ok(atlas)
    }
}

/// Texels along an edge of the sheet of leaves.
const LEAF_SHEET: u32 = 512;

/// All leaf kinds on a small sheet of their own, with their places: enough to measure with before there is
/// an atlas.
///
/// # Errors
/// If there are too many kinds.
pub fn leaf_sheet(leaves: &dyn LeafArtwork) -> Result<(Image<Texel>, Vec<UvRect>), BakeError> {
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
    let mut sheet = Image::filled(LEAF_SHEET, LEAF_SHEET, Texel::EMPTY);
    for (kind, rect) in rects.iter().enumerate() {
        let (width, height) = inner_size(rect);
        copy_into(&mut sheet, rect, &leaves.draw(kind, width, height));
    }
    let places = rects.iter().map(|rect| uv_of(rect, LEAF_SHEET));
    Ok((sheet, places.collect()))
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
