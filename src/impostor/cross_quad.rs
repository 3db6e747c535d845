//! Crossed quads per level: a node with all that grows on it, or a branch alone, as two upright quads at
//! right angles, textured with the captures that all nodes of the level share.
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, section IV (replacement of sub-trees and branches by
//! cross-quads).
//!
//! Changes versus the paper: each quad stands at the mean of the branch's curve rather than at its base; a single branch's quad is widened by the node's thickness only by its radius, so that
//! a bend is not widened too.
//!
//! Cost: 4 triangles a node.

use crate::lod::{Form as LodForm, State};
use crate::math::Vec3;
use crate::mesh::card::{self, Pane, Quad, Relief};
use crate::mesh::{Coat, Form, Template, tube};
use crate::tree::{Branch, Kind, Part, Prototype, Tree};

/// The quads and cards that a tree's captures allow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossQuads {
    /// By level and prototype: the node with all that grows on it.
    pub combined: Vec<Vec<Option<[Quad; 2]>>>,
    /// By level and prototype: the branch alone.
    pub branches: Vec<Vec<Option<[Quad; 2]>>>,
    /// Sets of planes, in the order of the plan that was captured.
    pub sets: Vec<Vec<Quad>>,
    /// By leaf kind: its picture in the atlas.
    pub leaves: Vec<Pane>,
}

impl CrossQuads {
    /// Nothing captured yet.
    #[must_use]
    pub fn none(tree: &Tree, leaves: Vec<Pane>) -> Self {
        let empty: Vec<Vec<Option<[Quad; 2]>>> = tree
            .levels
            .iter()
            .map(|l| vec![None; l.prototypes.len()])
            .collect();
        Self {
            combined: empty.clone(),
            branches: empty,
            sets: Vec::new(),
            leaves,
        }
    }

    /// What to draw for each prototype in a LOD state. `coat` is the bark of its tubes.
    /// A prototype without the capture that its form asks for is not drawn.
    #[must_use]
    pub fn form(&self, tree: &Tree, state: &State, coat: Coat) -> Form {
        self.scaled_form(tree, state, coat, 1.0)
    }

    /// The same with the quads of collapsed nodes `scale` times as large, each about its middle.
    #[must_use]
    pub fn scaled_form(&self, tree: &Tree, state: &State, coat: Coat, scale: f32) -> Form {
        let template = |level: usize, index: usize, prototype: &Prototype| match state.forms[level]
        {
            LodForm::Inside => None,
            LodForm::Collapsed => self.combined[level][index]
                .map(|quads| card::quads(&quads.map(|q| q.scaled_on(level, scale)))),
            LodForm::Quads => self.branches[level][index].map(|quads| card::quads(&quads)),
            LodForm::Geometry(lod) => self.geometry(&prototype.part, lod as usize, coat),
        };
        let templates = tree.levels.iter().enumerate().map(|(level, shared)| {
            let prototypes = shared.prototypes.iter().enumerate();
            prototypes
                .map(|(index, prototype)| template(level, index, prototype))
                .collect()
        });
        let open = |level: usize| tree.levels[level].kind != Kind::Leaf && state.is_open(level);
        Form {
            templates: templates.collect(),
            open: (0..tree.levels.len()).map(open).collect(),
        }
    }

    /// The captures' places in the atlas with their sizes.
    #[must_use]
    pub fn reliefs(&self) -> Vec<Relief> {
        let relief = |quad: &Quad| Relief {
            uv: quad.pane.uv,
            longer: 2.0 * quad.half[0].max(quad.half[1]),
        };
        let all = self
            .combined
            .iter()
            .chain(&self.branches)
            .flatten()
            .flatten()
            .flatten();
        all.chain(self.sets.iter().flatten()).map(relief).collect()
    }

    /// A part's own geometry: a tube of a spline LOD, a leaf card, or nothing.
    #[must_use]
    pub fn geometry(&self, part: &Part, lod: usize, coat: Coat) -> Option<Template> {
        match part {
            Part::Stool => None,
            Part::Branch(branch) => Some(tube(branch, lod, coat)),
            &Part::Leaf {
                kind,
                length,
                width,
                fold,
            } => {
                let pane = self.leaves.get(kind as usize).unwrap_or(&Pane::ALL);
                Some(card::leaf(length, width, fold, pane))
            }
        }
    }
}

/// The mean point of a branch's curve: quads that stand there show the branch once.
#[must_use]
pub fn mean_axis(branch: &Branch) -> Vec3 {
    #[expect(clippy::cast_precision_loss, reason = "a few hundred samples")]
    let count = branch.axis.len() as f32;
    branch.axis.iter().map(|s| s.position).sum::<Vec3>() / count
}

/// A captured quad for a branch of the same shape and `factor` times the size.
#[must_use]
pub fn scaled(quads: &[Quad; 2], factor: f32) -> [Quad; 2] {
    quads.map(|quad| Quad {
        centre: quad.centre * factor,
        half: quad.half.map(|h| h * factor),
        thick: quad.thick * factor,
        ..quad
    })
}

/// The right-hand directions of the two captures: (x, y) seen from +Z and (z, y) seen from +X.
pub const RIGHT: [Vec3; 2] = [Vec3::X, Vec3::NEG_Z];
