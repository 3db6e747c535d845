//! The studio: one subject in front of the camera, and the quads that its pictures are put on.

use super::BakeError;
use super::backend::{Picture, Scene, Shot};
use super::bake::{inner_size, subject_at};
use super::occlusion::Occlusion;
use super::plan::{PlaneSet, Subject, VIEWS};
use super::raster::View;
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use crate::impostor::cross_quad::{self, CrossQuads, RIGHT};
use crate::impostor::planes::{self, Plane, strips};
use crate::lod::{Form as LodForm, State};
use crate::math::{Bounds, Quat, Similarity, Vec3};
use crate::mesh::card::{Pane, Quad};
use crate::mesh::{Coat, Flattener, Mesh, TooLarge, Vertex};
use crate::tree::{Kind, Part, Tree};

/// Geometry LOD of the captured branch itself: finer rings than a texel can show are wasted. Each level
/// further out is smaller in the same picture, and takes one coarser.
pub(crate) const CAPTURE_SPLINE_LOD: usize = 1;

/// One finished capture: its texels, and the quad to put them on (without its place in the atlas).
pub(super) struct Capture {
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
    pub(super) coat: Coat,
    pub(super) supersample: u32,
}

impl Studio<'_> {
    /// A subject seen from two sides.
    pub(super) fn scene(
        &self,
        subject: Subject,
        source: Option<usize>,
        node: Node,
        rects: [&Rect; VIEWS],
    ) -> Result<Scene, BakeError> {
        let (level, prototype) = subject_at(subject);
        let state = self.state(subject, source);
        let mut form = self.quads.form(self.tree, &state, self.coat);
        let mesh = self.mesh(&form, level, prototype, node)?;
        let part = &self.tree.prototype(level, prototype).part;
        let rights = match subject {
            Subject::Combined { .. } => turned(node.cross),
            Subject::Branch { .. } => RIGHT,
        };
        let mut meshes = vec![mesh];
        if matches!(subject, Subject::Combined { .. }) && strays(part, rights[0]) {
            form.templates[level][prototype] = None;
            meshes.push(self.mesh(&form, level, prototype, node)?);
        }
        let thick = match (subject, part) {
            (Subject::Branch { .. }, Part::Branch(branch)) => branch.radius * node.thickness,
            _ => 0.0,
        };
        let bounds = meshes[0].bounds();
        let shot = |index: usize| {
            let view = Self::view(&meshes[0], &bounds, rights[index]);
            Shot {
                mesh: index.min(meshes.len() - 1),
                axis: mean_axis(part),
                thick,
                thickness: node.thickness,
                ..self.shot(view, rects[index])
            }
        };
        Ok(Scene {
            occlusion: Occlusion::unlit(&meshes[0]),
            shots: (0..VIEWS).map(shot).collect(),
            meshes,
        })
    }

    /// A set of planes.
    pub(super) fn scene_of_planes(
        &self,
        set: &PlaneSet,
        source: Option<usize>,
        node: Node,
        rects: &[Rect],
    ) -> Result<Scene, BakeError> {
        let (level, prototype) = (set.level, set.prototype);
        // What a plane's members count are the items of this very mesh.
        let state = self.state(Subject::Combined { level, prototype }, source);
        let form = self.quads.form(self.tree, &state, self.coat);
        let mesh = if set.straightened {
            let tube = (CAPTURE_SPLINE_LOD, self.coat);
            let standing = (node.turn, node.thickness);
            strips::straightened(self.tree, &form, (level, prototype), tube, standing)?
        } else {
            self.mesh(&form, level, prototype, node)?
        };
        let occlusion = Occlusion::unlit(&mesh);
        let items = planes::items(&mesh);
        let parts = set.planes.iter().filter(|p| p.members.is_some());
        let mut meshes: Vec<Mesh> = parts.map(|p| planes::part(&mesh, &items, p)).collect();
        let whole = meshes.len();
        if whole < set.planes.len() {
            meshes.push(mesh);
        }
        let mut next = 0..whole;
        let mut shot = |(plane, rect): (&Plane, &Rect)| {
            let view = View {
                centre: plane.centre,
                right: plane.right,
                up: plane.up,
                half: plane.half,
                width: 0,
                height: 0,
            };
            let own = plane.members.as_ref().and_then(|_| next.next());
            Shot {
                mesh: own.unwrap_or(whole),
                axis: Some(plane.centre),
                ..self.shot(view, rect)
            }
        };
        Ok(Scene {
            shots: set.planes.iter().zip(rects).map(&mut shot).collect(),
            meshes,
            occlusion,
        })
    }

    /// A view with its size for a rectangle of the atlas.
    fn shot(&self, view: View, rect: &Rect) -> Shot {
        let (width, height) = inner_size(rect);
        let view = View {
            width: width * self.supersample,
            height: height * self.supersample,
            ..view
        };
        Shot::new(0, view, [width, height])
    }

    /// The frame of one upright view, tight around a mesh; its size in samples is still to be set.
    fn view(mesh: &Mesh, bounds: &Bounds, right: Vec3) -> View {
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
        let mut forms: Vec<LodForm> = Vec::with_capacity(tree.levels.len());
        for (l, drawn) in tree.levels.iter().enumerate() {
            let outside = !tree.is_below(l, level);
            let alone = matches!(subject, Subject::Branch { .. }) && l != level;
            let closed = |&c: &usize| matches!(forms[c], LodForm::Collapsed | LodForm::Inside);
            let form = match source {
                _ if outside || alone => LodForm::Inside,
                Some(collapsed) if l == collapsed => LodForm::Collapsed,
                // What hangs on collapsed nodes alone is in their captures; other nodes of it are drawn.
                Some(collapsed) if tree.is_below(l, collapsed) => {
                    match (drawn.kind, tree.has_children(l)) {
                        _ if drawn.carriers.iter().all(closed) => LodForm::Inside,
                        (Kind::Leaf, _) => LodForm::Geometry(0),
                        (_, true) => LodForm::Collapsed,
                        (_, false) => LodForm::Quads,
                    }
                }
                _ => {
                    let out = drawn.depth - tree.levels[level].depth;
                    LodForm::Geometry(u8::try_from(CAPTURE_SPLINE_LOD + out).unwrap_or(u8::MAX))
                }
            };
            forms.push(form);
        }
        State { forms }
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
}

/// Makes depth relative to the plane that a picture is put on, and says where that is.
pub(super) fn mounted(picture: Picture) -> Capture {
    let Picture { shot, mut image } = picture;
    let (view, half) = (&shot.view, shot.view.half);
    // Where the branch itself stands, so that it is not seen beside itself; else in the mean.
    let plane = shot.axis.map_or_else(
        || mean_depth(&image),
        |axis| (axis - view.centre).dot(view.toward()),
    );
    let longer = (2.0 * half[0]).max(2.0 * half[1]);
    for texel in image.texels_mut().iter_mut().filter(|t| t.alpha > 0.0) {
        texel.depth = ((texel.depth - plane) / longer).clamp(-1.0, 1.0);
    }
    Capture {
        image,
        quad: Quad {
            centre: view.centre + view.toward() * plane,
            right: view.right,
            up: view.up,
            half,
            thick: shot.thick.min(half[0] * 0.95),
            captured_thickness: shot.thickness,
            pane: Pane::ALL,
        },
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
