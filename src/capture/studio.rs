//! The studio: one subject in front of the camera, its two pictures resolved to texels.

use super::BakeError;
use super::bake::{inner_size, subject_at};
use super::occlusion::Occlusion;
use super::plan::{PlaneSet, Subject, VIEWS};
use super::raster::{Textures, View, Visibility};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use crate::impostor::cross_quad::{self, CrossQuads, RIGHT};
use crate::impostor::planes::{self, Plane, strips};
use crate::lod::{Form as LodForm, State};
use crate::math::{Bounds, Quat, Similarity, Vec3, float};
use crate::mesh::card::{Quad, UvRect};
use crate::mesh::{Flattener, Mesh, TooLarge, Vertex};
use crate::tree::{Part, Tree};
use rayon::prelude::*;

/// Geometry LOD of the captured branch itself: finer rings than a texel can show are wasted. Each level
/// further out is smaller in the same picture, and takes one coarser.
pub(crate) const CAPTURE_SPLINE_LOD: usize = 1;

/// One finished capture: its texels, and the quad to put them on (without its place in the atlas).
pub(super) struct Shot {
    pub(super) image: Image<Texel>,
    pub(super) quad: Quad,
}

/// The node that stands for all of its level in a capture.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// How the mean node stands in the world, where that matters.
    pub(super) turn: Quat,
    /// Mean thickness of the prototype's nodes.
    pub(super) thickness: f32,
    /// Turn of the two views about +Y.
    pub(super) cross: f32,
}

/// The right-hand directions of two captures turned about +Y.
fn turned(cross: f32) -> [Vec3; VIEWS] {
    if cross == 0.0 {
        return RIGHT;
    }
    let turn = Quat::from_rotation_y(cross);
    RIGHT.map(|right| turn * right)
}

/// What both views of a subject share.
struct Frame {
    /// Bounds of the whole subject, metres.
    bounds: Bounds,
    /// Mean point of its branch's curve.
    axis: Option<Vec3>,
    /// Radius of a single branch as captured, metres; 0 for combined levels.
    thick: f32,
    /// Thickness of the captured node.
    thickness: f32,
}

/// The mean point of a part's curve.
fn mean_axis(part: &Part) -> Option<Vec3> {
    match part {
        Part::Branch(branch) => Some(cross_quad::mean_axis(branch)),
        Part::Stool | Part::Leaf { .. } => None,
    }
}

/// All that is needed to draw any subject.
pub(super) struct Studio<'a> {
    pub(super) tree: &'a Tree,
    pub(super) quads: &'a CrossQuads,
    pub(super) textures: Textures<'a>,
    pub(super) bark_height: f32,
    pub(super) supersample: u32,
}

impl Studio<'_> {
    pub(super) fn shoot(
        &self,
        subject: Subject,
        source: Option<usize>,
        node: Node,
        rects: [&Rect; VIEWS],
    ) -> Result<[Shot; VIEWS], BakeError> {
        let (level, prototype) = subject_at(subject);
        let state = self.state(subject, source);
        let mut form = self.quads.form(self.tree, &state, self.bark_height);
        let mesh = self.mesh(&form, level, prototype, node)?;
        let occlusion = Occlusion::of(&mesh);
        let part = &self.tree.prototype(level, prototype).part;
        let rights = match subject {
            Subject::Combined { .. } => turned(node.cross),
            Subject::Branch { .. } => RIGHT,
        };
        let second = if matches!(subject, Subject::Combined { .. }) && strays(part, rights[0]) {
            form.templates[level][prototype] = None;
            Some(self.mesh(&form, level, prototype, node)?)
        } else {
            None
        };
        let thick = match (subject, part) {
            (Subject::Branch { .. }, Part::Branch(branch)) => branch.radius * node.thickness,
            _ => 0.0,
        };
        let frame = Frame {
            bounds: mesh.bounds(),
            axis: mean_axis(part),
            thick,
            thickness: node.thickness,
        };
        let second = second.as_ref().unwrap_or(&mesh);
        let views = rights.map(|right| Self::view(&mesh, &frame, right));
        Ok([
            self.shot(&mesh, views[0], &occlusion, &frame, rects[0]),
            self.shot(second, views[1], &occlusion, &frame, rects[1]),
        ])
    }

    /// Captures a set of planes.
    pub(super) fn shoot_planes(
        &self,
        set: &PlaneSet,
        source: Option<usize>,
        node: Node,
        rects: &[Rect],
    ) -> Result<Vec<Shot>, BakeError> {
        let (level, prototype) = (set.level, set.prototype);
        // What a plane's members count are the items of this very mesh.
        let state = self.state(Subject::Combined { level, prototype }, source);
        let form = self.quads.form(self.tree, &state, self.bark_height);
        let mesh = if set.straightened {
            let tube = (CAPTURE_SPLINE_LOD, self.bark_height);
            let standing = (node.turn, node.thickness);
            strips::straightened(self.tree, &form, (level, prototype), tube, standing)?
        } else {
            self.mesh(&form, level, prototype, node)?
        };
        let occlusion = Occlusion::of(&mesh);
        let items = planes::items(&mesh);
        let shot = |(plane, rect): (&Plane, &Rect)| {
            let part = planes::part(&mesh, &items, plane);
            let frame = Frame {
                thick: 0.0,
                thickness: 1.0,
                axis: Some(plane.centre),
                bounds: Bounds::EMPTY,
            };
            let view = View {
                centre: plane.centre,
                right: plane.right,
                up: plane.up,
                half: plane.half,
                width: 0,
                height: 0,
            };
            self.shot(&part, view, &occlusion, &frame, rect)
        };
        Ok(set.planes.par_iter().zip(rects).map(shot).collect())
    }

    /// The frame of one upright view, tight around a mesh; its size in samples is still to be set.
    fn view(mesh: &Mesh, frame: &Frame, right: Vec3) -> View {
        let bounds = &frame.bounds;
        let (centre, half) = if right == RIGHT[0] || right == RIGHT[1] {
            let size = bounds.size().max(Vec3::splat(1e-5));
            (bounds.centre(), [size.dot(right.abs()) * 0.5, size.y * 0.5])
        } else {
            let vertices = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
            let across = vertices.map(|v| Vec3::from(v.position).dot(right));
            let (low, high) = across.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            });
            let toward = right.cross(Vec3::Y);
            let middle = bounds.centre();
            (
                right * ((low + high) * 0.5) + Vec3::Y * middle.y + toward * middle.dot(toward),
                [
                    ((high - low) * 0.5).max(1e-5),
                    (bounds.size().y * 0.5).max(1e-5),
                ],
            )
        };
        View {
            centre,
            right,
            up: Vec3::Y,
            half,
            width: 0,
            height: 0,
        }
    }

    /// In which form each level is drawn in a capture of `subject`.
    fn state(&self, subject: Subject, source: Option<usize>) -> State {
        let (level, _) = subject_at(subject);
        let tree = self.tree;
        let form = |l: usize| {
            let outside = !tree.is_below(l, level);
            let alone = matches!(subject, Subject::Branch { .. }) && l != level;
            match source {
                _ if outside || alone => LodForm::Inside,
                Some(collapsed) if l == collapsed => LodForm::Collapsed,
                Some(collapsed) if tree.is_below(l, collapsed) => LodForm::Inside,
                _ => {
                    let out = tree.levels[l].depth - tree.levels[level].depth;
                    LodForm::Geometry(u8::try_from(CAPTURE_SPLINE_LOD + out).unwrap_or(u8::MAX))
                }
            }
        };
        State {
            forms: (0..tree.levels.len()).map(form).collect(),
        }
    }

    fn mesh(
        &self,
        form: &crate::mesh::Form,
        level: usize,
        prototype: usize,
        node: Node,
    ) -> Result<Mesh, TooLarge> {
        let mut mesh = Mesh::default();
        let place = Similarity {
            rotation: node.turn,
            ..Similarity::IDENTITY
        };
        Flattener::new(self.tree, form).write(
            level,
            prototype,
            &place,
            node.thickness,
            &mut mesh,
        )?;
        if node.turn != Quat::IDENTITY {
            let back = node.turn.conjugate();
            mesh.bark
                .vertices
                .iter_mut()
                .for_each(|v| turn_vertex(v, back));
            mesh.foliage
                .vertices
                .iter_mut()
                .for_each(|v| turn_vertex(v, back));
        }
        Ok(mesh)
    }

    fn shot(
        &self,
        mesh: &Mesh,
        view: View,
        occlusion: &Occlusion,
        frame: &Frame,
        rect: &Rect,
    ) -> Shot {
        let (width, height) = inner_size(rect);
        let half = view.half;
        let view = View {
            width: width * self.supersample,
            height: height * self.supersample,
            ..view
        };
        let seen = Visibility::draw(mesh, self.textures, &view);
        let mut image = self.resolve(&seen, mesh, &view, occlusion, (width, height));
        // Where the branch itself stands, so that it is not seen beside itself; else in the mean.
        let plane = frame.axis.map_or_else(
            || mean_depth(&image),
            |axis| (axis - view.centre).dot(view.toward()),
        );
        let longer = (2.0 * half[0]).max(2.0 * half[1]);
        for texel in image.texels_mut().iter_mut().filter(|t| t.alpha > 0.0) {
            texel.depth = ((texel.depth - plane) / longer).clamp(-1.0, 1.0);
        }
        let centre = view.centre + view.toward() * plane;
        let thick = frame.thick.min(half[0] * 0.95);
        Shot {
            image,
            quad: Quad {
                centre,
                right: view.right,
                up: view.up,
                half,
                thick,
                captured_thickness: frame.thickness,
                uv: UvRect::ALL,
            },
        }
    }

    /// Averages the samples of each texel; depth is still in metres.
    fn resolve(
        &self,
        seen: &Visibility,
        mesh: &Mesh,
        view: &View,
        occlusion: &Occlusion,
        (width, height): (u32, u32),
    ) -> Image<Texel> {
        let n = self.supersample;
        let row = |y: u32| {
            (0..width).map(move |x| {
                let mut sum = Sum::default();
                for (sx, sy) in (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j))) {
                    if let Some(seen) = seen.surface(sx, sy, mesh, self.textures, view) {
                        sum.add(&seen.texel);
                    }
                }
                let mut texel = sum.mean(n * n);
                if texel.alpha > 0.0 {
                    let at = glam::Vec2::new(
                        float(x * n) + 0.5 * float(n),
                        float(y * n) + 0.5 * float(n),
                    );
                    texel.occlusion *= occlusion.open(view.unproject(at, texel.depth));
                }
                texel
            })
        };
        let texels: Vec<Texel> = (0..height).into_par_iter().flat_map_iter(row).collect();
        Image::from_texels(width, height, texels)
    }
}

fn turn_vertex(vertex: &mut Vertex, turn: Quat) {
    let [x, y, z, w] = vertex.tangent;
    let tangent = turn * Vec3::new(x, y, z);
    vertex.position = (turn * Vec3::from(vertex.position)).to_array();
    vertex.normal = (turn * Vec3::from(vertex.normal)).to_array();
    vertex.tangent = [tangent.x, tangent.y, tangent.z, w];
}

/// True if a branch bends so far along `across` that the quad at right angles to it would show the
/// branch a second time, beside itself (Koniaris et al., section IV.D).
fn strays(part: &Part, across: Vec3) -> bool {
    let Part::Branch(branch) = part else {
        return false;
    };
    let offsets = branch.axis.iter().map(|s| s.position.dot(across));
    let (low, high) = offsets.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    (high - low) * 0.5 > planes::DOUBLED_ABOVE * branch.radius
}

/// Coverage-weighted mean depth, metres.
fn mean_depth(image: &Image<Texel>) -> f32 {
    let (sum, weight) = image.texels().iter().fold((0.0_f64, 0.0_f64), |(s, w), t| {
        (s + f64::from(t.depth * t.alpha), w + f64::from(t.alpha))
    });
    #[expect(clippy::cast_possible_truncation, reason = "metres fit a float")]
    let mean = if weight > 0.0 {
        (sum / weight) as f32
    } else {
        0.0
    };
    mean
}

/// Running sum of covered samples.
#[derive(Default)]
struct Sum {
    albedo: Vec3,
    normal: Vec3,
    rest: [f32; 4],
    count: u32,
}

impl Sum {
    fn add(&mut self, texel: &Texel) {
        self.albedo += Vec3::from(texel.albedo);
        self.normal += Vec3::from(texel.normal);
        let rest = [
            texel.occlusion,
            texel.roughness,
            texel.translucency,
            texel.depth,
        ];
        for (sum, value) in self.rest.iter_mut().zip(rest) {
            *sum += value;
        }
        self.count += 1;
    }

    fn mean(&self, samples: u32) -> Texel {
        if self.count == 0 {
            return Texel::EMPTY;
        }
        let part = 1.0 / float(self.count);
        let [occlusion, roughness, translucency, depth] = self.rest.map(|x| x * part);
        Texel {
            albedo: (self.albedo * part).to_array(),
            alpha: float(self.count) / float(samples),
            normal: self.normal.normalize_or(Vec3::Z).to_array(),
            occlusion,
            roughness,
            translucency,
            depth,
        }
    }
}
