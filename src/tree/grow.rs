//! Growth: a species and a seed become prototypes and links.
//!
//! Cost: time and memory go with the links of the prototypes, not with the nodes of the tree.

use super::branch::Recipe;
use super::growth::grown_up;
use super::hosts::{self, Host};
use super::links::{self, ChildLevel};
use super::{Branch, Kind, Limits, Part, Prototype, Tree, TreeLevel, pipes};
use crate::math::{Quat, Vec3};
use crate::rng::{Key, Parameter, unit_from_bits};
use crate::species::schema::{BranchParams, Curve, Level, LevelKind, Size, Species};
use rand::Rng;

/// Name of the level that carries the stems of a multi-stemmed tree.
pub(super) const STOOL: &str = "stool";

/// Why a species cannot be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GrowError {
    /// Too many nodes.
    #[error(
        "level `{level}` would bring the tree to {would_be} nodes; the limit is {limit}. \
         Lower `links` or `children` there or above"
    )]
    TooManyNodes {
        /// Level that passes the limit.
        level: String,
        /// Nodes of all levels down to this one.
        would_be: u64,
        /// The limit.
        limit: u64,
    },
    /// Too many links on one prototype.
    #[error("level `{level}` would put {would_be} children on each parent; the limit is {limit}")]
    TooManyLinks {
        /// Level.
        level: String,
        /// Links times children.
        would_be: u64,
        /// The limit.
        limit: u64,
    },
    /// Too many triangles at full detail.
    #[error(
        "level `{level}` would bring the tree to {would_be} triangles at full detail; the limit is \
         {limit}. Lower `links`, `children` or `sides` there or above"
    )]
    TooManyTriangles {
        /// Level that passes the limit.
        level: String,
        /// Triangles of all levels down to this one.
        would_be: u64,
        /// The limit.
        limit: u64,
    },
    /// A spline without extent.
    #[error("level `{level}`: all control points of its spline coincide")]
    NoLength {
        /// Level.
        level: String,
    },
    /// The species has no level, or names one that is not there. A script that was read cannot.
    #[error("level `{level}` is not part of the species, or has no parent, spline or leaf kind")]
    Incomplete {
        /// Level.
        level: String,
    },
}

/// Grows the tree of one species and seed, at the age and in the habit that the species says.
///
/// # Errors
/// If the tree would pass one of `limits`, or the species is not whole ([`GrowError`]).
pub fn grow(species: &Species, seed: u64, limits: &Limits) -> Result<Tree, GrowError> {
    let species = &*grown_up(species);
    for (index, level) in species.levels.iter().enumerate() {
        let sound = match level.parent {
            Some(parent) => parent < index,
            None => index == 0,
        };
        if !sound {
            return Err(GrowError::Incomplete {
                level: level.name.clone(),
            });
        }
    }
    check_counts(species, limits)?;
    let mut levels: Vec<TreeLevel> = Vec::with_capacity(species.levels.len() + 1);
    let mut thinnest: Vec<Vec<f32>> = Vec::new();
    let shift = usize::from(species.stems.is_some());
    let key = Key::of_seed(seed);
    if shift == 1 {
        levels.push(stool());
        thinnest.push(vec![1.0]);
    }
    for (index, script) in species.levels.iter().enumerate() {
        let parent = script
            .parent
            .map(|p| p + shift)
            .or((shift == 1).then_some(0));
        let nominal = Nominal::of(script, parent.map(|p| &levels[p]))?;
        let weights = weights(script)?;
        let child = ChildLevel {
            index: u16::try_from(index + shift).unwrap_or(u16::MAX),
            script,
            places: script,
            pipe_model: 0.0,
            length: nominal.length,
            radius: nominal.radius,
            weights: &weights,
        };
        let mut carriers: Vec<usize> = Vec::new();
        for host in hosts::hosts(species, index) {
            attach(species, &mut levels[host.level + shift], host, &child, key);
            carriers.push(host.level + shift);
        }
        if let (Some(stool), None) = (parent, script.parent) {
            let links = links::on_stool(species, &child, key);
            levels[stool].prototypes[0].links.extend(links);
            carriers.push(stool);
        }
        // Where no place skips a level, only its parent carries it.
        carriers.retain(|&c| Some(c) == parent || carries(&levels[c], index + shift));
        let on: Vec<(&TreeLevel, &[f32])> = carriers
            .iter()
            .map(|&c| (&levels[c], &thinnest[c][..]))
            .collect();
        let prototypes = prototypes(species, index, &nominal, key, &on, shift)?;
        let thin = thinnest_nodes(&on, index + shift, prototypes.len());
        thinnest.push(thin);
        levels.push(TreeLevel {
            name: script.name.clone(),
            parent,
            carriers,
            depth: parent.map_or(0, |p| levels[p].depth + 1),
            kind: if matches!(script.kind, LevelKind::Leaf(_)) {
                Kind::Leaf
            } else {
                Kind::Branch
            },
            tropism: script.placement.tropism,
            prototypes,
        });
    }
    let tree = Tree { levels, seed };
    check_triangles(&tree, limits)?;
    Ok(tree)
}

fn stool() -> TreeLevel {
    TreeLevel {
        name: STOOL.to_owned(),
        parent: None,
        carriers: Vec::new(),
        depth: 0,
        kind: Kind::Stool,
        tropism: 0.0,
        prototypes: vec![Prototype {
            part: Part::Stool,
            links: Vec::new(),
        }],
    }
}

/// Adds the links of one child level to all prototypes of a level that carries it.
fn attach(
    species: &Species,
    carrier: &mut TreeLevel,
    host: Host,
    child: &ChildLevel<'_>,
    key: Key,
) {
    let pipe_model = match &species.levels[host.level].kind {
        LevelKind::Branch(branch) => branch.pipe_model,
        LevelKind::Leaf(_) => 0.0,
    };
    let child = ChildLevel {
        places: &species.levels[host.places],
        pipe_model,
        ..*child
    };
    for (variant, prototype) in carrier.prototypes.iter_mut().enumerate() {
        if let Part::Branch(branch) = &prototype.part {
            let places = hosts::places(species, host);
            let links = links::on_branch(branch, &child, places, key, variant as u64);
            prototype.links.extend(links);
        }
    }
}

/// True if a level has links to another.
fn carries(carrier: &TreeLevel, level: usize) -> bool {
    let mut links = carrier.prototypes.iter().flat_map(|p| &p.links);
    links.any(|link| usize::from(link.level) == level)
}

/// Weight of each prototype of a level.
fn weights(script: &Level) -> Result<Vec<f32>, GrowError> {
    let weights: Vec<f32> = match &script.kind {
        LevelKind::Branch(branch) => vec![1.0; branch.variants.max(1) as usize],
        LevelKind::Leaf(leaf) => leaf.kinds.iter().map(|&(_, weight)| weight).collect(),
    };
    if weights.is_empty() {
        return Err(GrowError::Incomplete {
            level: script.name.clone(),
        });
    }
    Ok(weights)
}

/// Length and radius of a level's prototypes before chance, metres at scale 1.
struct Nominal {
    length: f32,
    radius: f32,
    /// Radius of the parent's prototype at its base; 0 for the trunk.
    parent_radius: f32,
}

impl Nominal {
    fn of(script: &Level, parent: Option<&TreeLevel>) -> Result<Self, GrowError> {
        let LevelKind::Branch(params) = &script.kind else {
            return Ok(Self {
                length: 0.0,
                radius: 0.0,
                parent_radius: 0.0,
            });
        };
        let parent_branch = parent.and_then(|p| match &p.prototypes[0].part {
            Part::Branch(branch) => Some(branch),
            Part::Stool | Part::Leaf { .. } => None,
        });
        let size = |size: Size, of: fn(&Branch) -> f32| match (size, parent_branch) {
            (Size::Metres(metres), _) => Ok(metres),
            (Size::OfParent(ratio), Some(branch)) => Ok(ratio * of(branch)),
            (Size::OfParent(_), None) => Err(GrowError::Incomplete {
                level: script.name.clone(),
            }),
        };
        Ok(Self {
            length: size(params.length, |b| b.length)?,
            radius: size(params.radius, |b| b.radius)?,
            parent_radius: parent_branch.map_or(0.0, |b| b.radius),
        })
    }
}

/// The prototypes of script level `index`, which hang on the levels `on`, each with its thinnest nodes.
fn prototypes(
    species: &Species,
    index: usize,
    nominal: &Nominal,
    seed: Key,
    on: &[(&TreeLevel, &[f32])],
    shift: usize,
) -> Result<Vec<Prototype>, GrowError> {
    let script = &species.levels[index];
    match &script.kind {
        LevelKind::Leaf(leaf) => leaf
            .kinds
            .iter()
            .map(|&(kind, _)| {
                let art = species
                    .leaves
                    .get(kind)
                    .ok_or_else(|| GrowError::Incomplete {
                        level: script.name.clone(),
                    })?;
                let part = Part::Leaf {
                    kind: u16::try_from(kind).unwrap_or(u16::MAX),
                    length: art.length_m,
                    width: art.width_m,
                    fold: art.fold_deg.to_radians(),
                };
                Ok(Prototype {
                    part,
                    links: Vec::new(),
                })
            })
            .collect(),
        LevelKind::Branch(params) => {
            let variants = params.variants.max(1) as usize;
            let level = u16::try_from(index + shift).unwrap_or(u16::MAX);
            let mut hidden = vec![f32::INFINITY; variants];
            for (carrier, thinnest) in on {
                links::hide(&mut hidden, &carrier.prototypes, thinnest, level);
            }
            (0..variants)
                .map(|variant| {
                    let number = variant as u64;
                    let key = seed.level(&script.name).with(number);
                    let radius = nominal.radius * own_size(script, key);
                    let taper = pipes::taper(species, index, number, seed, radius);
                    let make = Make {
                        params,
                        nominal,
                        taper: taper.as_ref().unwrap_or(&params.taper),
                        hidden: hidden[variant],
                        key,
                    };
                    let branch = branch(species, script, &make)?;
                    Ok(Prototype {
                        part: Part::Branch(branch),
                        links: Vec::new(),
                    })
                })
                .collect()
        }
    }
}

/// What makes one prototype of a branch level.
struct Make<'a> {
    params: &'a BranchParams,
    nominal: &'a Nominal,
    taper: &'a Curve,
    /// Largest radius of a first ring that stays hidden, metres.
    hidden: f32,
    key: Key,
}

fn branch(species: &Species, script: &Level, make: &Make<'_>) -> Result<Branch, GrowError> {
    let Make {
        params,
        nominal,
        key,
        ..
    } = *make;
    let incomplete = || GrowError::Incomplete {
        level: script.name.clone(),
    };
    let weights: Vec<f32> = params.splines.iter().map(|&(_, weight)| weight).collect();
    let choice = key
        .pick(Parameter::Spline, &weights)
        .ok_or_else(incomplete)?;
    let spline_index = params.splines[choice].0;
    let spline = species.splines.get(spline_index).ok_or_else(incomplete)?;
    let mut control = gnarled(&spline.points, params.gnarl, key);
    let size = own_size(script, key);
    if script.parent.is_none() {
        // A trunk hangs on no link: its own turn is part of the prototype.
        let turn = own_turn(script, key);
        control.iter_mut().for_each(|point| *point = turn * *point);
    }
    // A chance of more than the whole length would turn the branch inside out.
    let length = nominal.length
        * size
        * (1.0 + params.length_vary * key.signed(Parameter::Length)).max(0.05);
    Branch::build(&Recipe {
        spline: u16::try_from(spline_index).unwrap_or(u16::MAX),
        control: &control,
        knots: spline.knots,
        length,
        radius: nominal.radius * size,
        taper: make.taper,
        collar: (params.collar, nominal.parent_radius),
        hidden: make.hidden,
        upright: script.parent.is_none(),
        flare: params.flare,
        flutes: params.flutes,
        phase: key.unit(Parameter::Phase) * crate::math::TAU,
        sides: params.sides,
        tolerances: &species.lod.tolerances,
    })
    .ok_or_else(|| GrowError::NoLength {
        level: script.name.clone(),
    })
}

/// The size of a trunk, which hangs on no link: a part of the prototype.
fn own_size(script: &Level, key: Key) -> f32 {
    if script.parent.is_some() {
        return 1.0;
    }
    links::factor(&script.placement.scale, key, Parameter::Scale, 0.0)
}

/// The turn of a trunk about its own axis.
fn own_turn(script: &Level, key: Key) -> Quat {
    let turn = links::angle(&script.placement.around, key, Parameter::Around, 0.0, 0.0);
    Quat::from_rotation_y(turn)
}

impl Tree {
    /// The turn that is a part of a prototype's curve: none but for trunks, since others are turned by their links.
    #[must_use]
    pub fn own_turn(&self, species: &Species, level: usize, variant: usize) -> Quat {
        let shift = usize::from(species.stems.is_some());
        let script = level.checked_sub(shift).and_then(|l| species.levels.get(l));
        match script.filter(|script| script.parent.is_none()) {
            Some(script) => {
                let key = Key::of_seed(self.seed).level(&script.name);
                own_turn(script, key.with(variant as u64))
            }
            None => Quat::IDENTITY,
        }
    }
}

/// Control points, all but the first moved sideways by chance, as parts of the spline's extent.
fn gnarled(points: &[[f32; 3]], gnarl: f32, key: Key) -> Vec<Vec3> {
    let points: Vec<Vec3> = points.iter().map(|&p| Vec3::from(p)).collect();
    let length: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    points
        .iter()
        .enumerate()
        .map(|(i, &point)| {
            let mut stream = key.with(i as u64).stream(Parameter::Gnarl);
            let mut draw = || (unit_from_bits(stream.next_u32()) * 2.0 - 1.0) * gnarl * length;
            let shift = Vec3::new(draw(), draw() * 0.3, draw());
            if i == 0 { point } else { point + shift }
        })
        .collect()
}

/// Least thickness with which each prototype of a level is placed.
fn thinnest_nodes(on: &[(&TreeLevel, &[f32])], level: usize, prototypes: usize) -> Vec<f32> {
    let mut thinnest = vec![f32::INFINITY; prototypes];
    let carriers = on.iter().flat_map(|(carrier, _)| &carrier.prototypes);
    for link in carriers.flat_map(|p| &p.links) {
        if link.level as usize == level {
            let slot = &mut thinnest[link.prototype as usize];
            *slot = slot.min(link.thickness);
        }
    }
    thinnest
        .iter()
        .map(|&t| if t.is_finite() { t } else { 1.0 })
        .collect()
}

/// Node counts before anything is built: links times children of what carries a level, summed.
fn check_counts(species: &Species, limits: &Limits) -> Result<(), GrowError> {
    let stems = species.stems.as_ref().map_or(1, |s| u64::from(s.count));
    let mut nodes: Vec<u64> = Vec::with_capacity(species.levels.len());
    let mut total = u64::from(species.stems.is_some());
    for (index, script) in species.levels.iter().enumerate() {
        let per_parent = match script.parent {
            None => stems,
            Some(_) => u64::from(script.placement.links) * u64::from(script.placement.children),
        };
        if per_parent > limits.links {
            let level = script.name.clone();
            return Err(GrowError::TooManyLinks {
                level,
                would_be: per_parent,
                limit: limits.links,
            });
        }
        let on_host = |host: Host| {
            let children = u64::from(species.levels[host.places].placement.children);
            let places = hosts::places(species, host).count() as u64;
            let carriers = nodes.get(host.level).copied().unwrap_or(0);
            carriers.saturating_mul(places * children)
        };
        let here = match script.parent {
            None => per_parent,
            Some(_) => hosts::hosts(species, index)
                .into_iter()
                .map(on_host)
                .fold(0, u64::saturating_add),
        };
        total = total.saturating_add(here);
        if total > limits.nodes {
            let level = script.name.clone();
            return Err(GrowError::TooManyNodes {
                level,
                would_be: total,
                limit: limits.nodes,
            });
        }
        nodes.push(here);
    }
    Ok(())
}

fn check_triangles(tree: &Tree, limits: &Limits) -> Result<(), GrowError> {
    let mut total = 0_u64;
    for (level, nodes) in tree.levels.iter().zip(tree.nodes()) {
        for (prototype, count) in level.prototypes.iter().zip(nodes) {
            total = total.saturating_add(prototype.part.full_triangles().saturating_mul(count));
        }
        if total > limits.triangles {
            let level = level.name.clone();
            return Err(GrowError::TooManyTriangles {
                level,
                would_be: total,
                limit: limits.triangles,
            });
        }
    }
    Ok(())
}
