//! Flattening: the graph of prototypes becomes one mesh.
//!
//! Every prototype's sub-tree has a known size in a given form, so each node knows its place in the
//! output before it is written: the walk allocates nothing, splits the output between threads without
//! locks, and gives the same bytes at any thread count.
//!
//! Small sub-trees, a twig's leaves say, are flattened once in the frame of what carries them and copied
//! from there: one matrix for all of them instead of one for each. Where nodes turn toward gravity, only
//! what hangs below them can be copied so.

use super::template::{Material, Template, write_rigid};
use super::{Mesh, Primitive, Vertex};
use crate::math::Similarity;
use crate::tree::{Link, Tree};

/// Vertices and indices of both materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Bark vertices, bark indices, foliage vertices, foliage indices.
    counts: [usize; 4],
}

impl Sizes {
    fn of(template: Option<&Template>) -> Self {
        let Some(template) = template else {
            return Self::default();
        };
        let (v, i) = (template.vertices.len(), template.indices.len());
        match template.material {
            Material::Bark => Self {
                counts: [v, i, 0, 0],
            },
            Material::Foliage => Self {
                counts: [0, 0, v, i],
            },
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            counts: core::array::from_fn(|i| self.counts[i] + other.counts[i]),
        }
    }

    fn vertices(self) -> usize {
        self.counts[0] + self.counts[2]
    }

    fn is_zero(self) -> bool {
        self.counts == [0; 4]
    }

    /// Triangles of both materials.
    #[must_use]
    pub fn triangles(self) -> u64 {
        (self.counts[1] + self.counts[3]) as u64 / 3
    }
}

/// What to draw for each prototype, and where to stop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// By level and prototype: its own part's geometry, or nothing.
    pub templates: Vec<Vec<Option<Template>>>,
    /// By level: true if its children are drawn too.
    pub open: Vec<bool>,
}

/// The output is larger than 32-bit indices can address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the mesh would have {vertices} vertices; 32-bit indices allow {}",
    u32::MAX
)]
pub struct TooLarge {
    /// Vertices of the larger material.
    pub vertices: usize,
}

/// Output slices below this many vertices are written by one thread.
const PARALLEL_ABOVE: usize = 16_384;

/// What hangs on a prototype is flattened once if it has at most so many vertices. The copies are read
/// over and over, so they should stay in a core's second cache.
const CLUSTER_VERTICES: usize = 2048;

/// A form made ready for one tree.
#[derive(Debug)]
pub struct Flattener<'a> {
    tree: &'a Tree,
    form: &'a Form,
    sizes: Vec<Vec<Sizes>>,
    /// By level and prototype: all that hangs on it, in its frame, where that is small and rigid.
    clusters: Vec<Vec<Option<Mesh>>>,
}

impl<'a> Flattener<'a> {
    /// Computes the size of every sub-tree, once.
    #[must_use]
    pub fn new(tree: &'a Tree, form: &'a Form) -> Self {
        let mut sizes: Vec<Vec<Sizes>> = tree
            .levels
            .iter()
            .map(|l| vec![Sizes::default(); l.prototypes.len()])
            .collect();
        for level in (0..tree.levels.len()).rev() {
            for (index, prototype) in tree.levels[level].prototypes.iter().enumerate() {
                let mut size = Sizes::of(form.templates[level][index].as_ref());
                if form.open[level] {
                    for link in &prototype.links {
                        size = size.plus(sizes[link.level as usize][link.prototype as usize]);
                    }
                }
                sizes[level][index] = size;
            }
        }
        let clusters = tree
            .levels
            .iter()
            .map(|l| vec![None; l.prototypes.len()])
            .collect();
        let mut flattener = Self {
            tree,
            form,
            sizes,
            clusters,
        };
        flattener.cluster();
        flattener
    }

    /// Flattens what hangs on each prototype that is drawn more than once, from the leaves inward, as
    /// long as it is small.
    fn cluster(&mut self) {
        let nodes = self.tree.nodes();
        for level in (0..self.tree.levels.len()).rev() {
            if !self.form.open[level] || self.tree.turns_below(level) {
                continue;
            }
            for (prototype, &count) in nodes[level].iter().enumerate() {
                let links = &self.tree.levels[level].prototypes[prototype].links;
                let size = self.size_of_all(links);
                if count > 1 && (1..=CLUSTER_VERTICES).contains(&size.vertices()) {
                    let mut mesh = Mesh::default();
                    self.links(links, &Similarity::IDENTITY, Out::of(&mut mesh, size));
                    self.clusters[level][prototype] = Some(mesh);
                }
            }
        }
    }

    /// Size of one prototype's sub-tree.
    #[must_use]
    pub fn size(&self, level: usize, prototype: usize) -> Sizes {
        self.sizes[level][prototype]
    }

    /// Flattens the whole tree.
    ///
    /// # Errors
    /// If 32-bit indices cannot address the result.
    pub fn tree(&self) -> Result<Mesh, TooLarge> {
        let mut mesh = Mesh::default();
        self.write(0, 0, &Similarity::IDENTITY, 1.0, &mut mesh)?;
        Ok(mesh)
    }

    /// Flattens one prototype's sub-tree, placed at `place` with its own tube `thickness` times as thick,
    /// into `mesh`, reusing its buffers.
    ///
    /// # Errors
    /// If 32-bit indices cannot address the result.
    pub fn write(
        &self,
        level: usize,
        prototype: usize,
        place: &Similarity,
        thickness: f32,
        mesh: &mut Mesh,
    ) -> Result<(), TooLarge> {
        let size = self.sizes[level][prototype];
        let vertices = size.counts[0].max(size.counts[2]);
        if u32::try_from(vertices).is_err() {
            return Err(TooLarge { vertices });
        }
        self.node(level, prototype, place, thickness, Out::of(mesh, size));
        Ok(())
    }

    fn node(
        &self,
        level: usize,
        prototype: usize,
        place: &Similarity,
        thickness: f32,
        mut out: Out<'_>,
    ) {
        if let Some(template) = &self.form.templates[level][prototype] {
            let (own, rest) = out.split(Sizes::of(Some(template)));
            let slot = match template.material {
                Material::Bark => own.bark,
                Material::Foliage => own.foliage,
            };
            template.write(place, thickness, slot.vertices, slot.indices, slot.base);
            out = rest;
        }
        if let Some(cluster) = &self.clusters[level][prototype] {
            out.copy(cluster, place);
        } else if self.form.open[level] {
            self.links(
                &self.tree.levels[level].prototypes[prototype].links,
                place,
                out,
            );
        }
    }

    fn links(&self, links: &[Link], place: &Similarity, mut out: Out<'_>) {
        if links.len() > 1 && out.vertices() > PARALLEL_ABOVE {
            let (first, second) = links.split_at(links.len() / 2);
            let (left, right) = out.split(self.size_of_all(first));
            rayon::join(
                || self.links(first, place, left),
                || self.links(second, place, right),
            );
            return;
        }
        for link in links {
            let size = self.size_of(link);
            if !size.is_zero() {
                let (own, rest) = out.split(size);
                out = rest;
                let place = self.tree.place(place, link);
                self.node(
                    link.level as usize,
                    link.prototype as usize,
                    &place,
                    link.thickness,
                    own,
                );
            }
        }
    }

    fn size_of_all(&self, links: &[Link]) -> Sizes {
        links
            .iter()
            .fold(Sizes::default(), |sum, link| sum.plus(self.size_of(link)))
    }

    fn size_of(&self, link: &Link) -> Sizes {
        self.sizes[link.level as usize][link.prototype as usize]
    }
}

/// Output space of one material.
struct Slot<'a> {
    vertices: &'a mut [Vertex],
    indices: &'a mut [u32],
    /// Index of the first vertex in the whole output.
    base: u32,
}

impl<'a> Slot<'a> {
    fn of(primitive: &'a mut Primitive, vertices: usize, indices: usize) -> Self {
        let zero: Vertex = bytemuck::Zeroable::zeroed();
        primitive.vertices.resize(vertices, zero);
        primitive.indices.resize(indices, 0);
        Self {
            vertices: &mut primitive.vertices,
            indices: &mut primitive.indices,
            base: 0,
        }
    }

    fn copy(self, from: &Primitive, place: &Similarity) {
        if !from.vertices.is_empty() {
            write_rigid(from, place, self.vertices, self.indices, self.base);
        }
    }

    fn split(self, vertices: usize, indices: usize) -> (Self, Self) {
        let (v0, v1) = self.vertices.split_at_mut(vertices);
        let (i0, i1) = self.indices.split_at_mut(indices);
        // The total was checked against u32 before anything was written.
        let base = self.base + u32::try_from(vertices).unwrap_or(u32::MAX);
        (
            Self {
                vertices: v0,
                indices: i0,
                base: self.base,
            },
            Self {
                vertices: v1,
                indices: i1,
                base,
            },
        )
    }
}

/// Output space of a sub-tree.
struct Out<'a> {
    bark: Slot<'a>,
    foliage: Slot<'a>,
}

impl<'a> Out<'a> {
    /// The whole of a mesh, made to hold `size`.
    fn of(mesh: &'a mut Mesh, size: Sizes) -> Self {
        let [bark_v, bark_i, foliage_v, foliage_i] = size.counts;
        Self {
            bark: Slot::of(&mut mesh.bark, bark_v, bark_i),
            foliage: Slot::of(&mut mesh.foliage, foliage_v, foliage_i),
        }
    }

    fn copy(self, cluster: &Mesh, place: &Similarity) {
        self.bark.copy(&cluster.bark, place);
        self.foliage.copy(&cluster.foliage, place);
    }

    fn split(self, size: Sizes) -> (Self, Self) {
        let [bark_v, bark_i, foliage_v, foliage_i] = size.counts;
        let (b0, b1) = self.bark.split(bark_v, bark_i);
        let (f0, f1) = self.foliage.split(foliage_v, foliage_i);
        (
            Self {
                bark: b0,
                foliage: f0,
            },
            Self {
                bark: b1,
                foliage: f1,
            },
        )
    }

    fn vertices(&self) -> usize {
        self.bark.vertices.len() + self.foliage.vertices.len()
    }
}
