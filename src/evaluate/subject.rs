//! What is evaluated: a full tree and its LODs, from a made tree or from a pack.

use crate::asset::{Surface, TreeAsset};
use crate::lod::{Counts, Selector, State};
use crate::mesh::Mesh;
use crate::mesh::card::Relief;
use crate::pack::PackContents;
use crate::pipeline;
use crate::shadow;
use crate::species::schema::Species;
use crate::tree::{self, GrowError};

/// A full tree and its LODs.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    /// Common name.
    pub name: &'a str,
    /// Botanical name; may be empty.
    pub latin: &'a str,
    /// File-name form of the name.
    pub slug: &'a str,
    /// Seed of the tree, and of the random rival.
    pub seed: u64,
    /// Every branch at its finest, every leaf a card: the reference.
    pub full: &'a Mesh,
    /// Textures of the full tree, and of rivals, which are parts of it.
    pub full_look: Look<'a>,
    /// LODs from the finest to the coarsest.
    pub lods: Vec<Lod<'a>>,
    /// Textures of the LODs.
    pub look: Look<'a>,
}

/// Textures of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Foliage atlas.
    pub foliage: &'a Surface,
    /// Bark; repeats. Its alpha does not count.
    pub bark: &'a Surface,
    /// Captures in the atlas with their real sizes; without them, what a capture shows lies in its plane, and
    /// is shaded as single leaves are.
    pub reliefs: &'a [Relief],
}

/// One LOD.
#[derive(Clone, Debug)]
pub struct Lod<'a> {
    /// Triangle budget; none for full detail.
    pub budget: Option<u64>,
    /// Forms of the levels, in words.
    pub state: &'a str,
    /// Measured error, metres.
    pub error_m: f32,
    /// Part of the picture's height up to which it may be shown.
    pub screen_size: f32,
    /// Geometry.
    pub mesh: &'a Mesh,
}

/// Why there is no reference to compare with.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The species cannot be grown.
    #[error(transparent)]
    Grow(#[from] GrowError),
    /// All leaves and branches together are more than can be drawn in a reasonable time.
    #[error(
        "the full tree has {triangles} triangles, and at most {} can be drawn to compare with; evaluate a \
         smaller tree of the species",
        LARGEST_REFERENCE
    )]
    TooLarge {
        /// Triangles of the full tree.
        triangles: u64,
    },
}

/// Triangles of the largest full tree that is drawn: about a gigabyte of mesh.
const LARGEST_REFERENCE: u64 = 8_000_000;

/// The same settings, changed so that the first LOD is the full tree, and without the work on shadows, which
/// no picture here shows. The LODs that `settings` asks for stay the same.
///
/// # Errors
/// If the species cannot be grown, or if its full tree is too large to be drawn.
pub fn with_reference(
    species: &Species,
    settings: &pipeline::Settings,
) -> Result<pipeline::Settings, ReferenceError> {
    let seed = settings.seed.unwrap_or(species.seed);
    let tree = tree::grow(species, seed, &settings.limits)?;
    let triangles = Selector::new(&tree, &species.lod).full_triangles();
    if triangles > LARGEST_REFERENCE {
        return Err(ReferenceError::TooLarge { triangles });
    }
    let budgets = settings.budgets.as_ref().unwrap_or(&species.lod.budgets);
    // A first budget that the full tree meets gets the full tree; one more LOD before it would turn it into
    // the next simpler one.
    let meets = budgets.first().is_some_and(|&first| triangles <= first);
    Ok(pipeline::Settings {
        full: settings.full || !meets,
        shadows: shadow::Settings {
            size: 16,
            bands: 0,
            samples: 1,
            ..settings.shadows
        },
        ..settings.clone()
    })
}

/// The full tree of one that was grown without it as its first LOD: the same that [`with_reference`] has made.
///
/// # Errors
/// If it is too large to be drawn.
pub fn reference(asset: &TreeAsset) -> Result<Mesh, ReferenceError> {
    let counts = Counts::of(&asset.tree, 1);
    let triangles = counts.triangles(&asset.tree, &State::full(&asset.tree));
    let triangles = triangles.total();
    let too_large = ReferenceError::TooLarge { triangles };
    if triangles > LARGEST_REFERENCE {
        return Err(too_large);
    }
    asset.full_detail().map_err(|_| too_large)
}

/// The settings that make a pack's tree again.
#[must_use]
pub fn settings_of(pack: &PackContents) -> pipeline::Settings {
    let mut settings = pipeline::Settings {
        seed: Some(pack.manifest.seed),
        budgets: Some(pack.manifest.lods.iter().filter_map(|l| l.budget).collect()),
        full: pack.manifest.lods.iter().any(|l| l.budget.is_none()),
        bark_size: pack.bark.albedo.width(),
        ..pipeline::Settings::default()
    };
    settings.captures.atlas_size = pack.foliage.albedo.width();
    settings
}

impl<'a> Subject<'a> {
    /// A tree whose first LOD is the full tree, as [`with_reference`] asks for it. `full` says whether that one
    /// is also judged where it meets no budget.
    ///
    /// # Panics
    /// If the tree has no LOD, which no made tree lacks.
    #[must_use]
    pub fn of_asset(asset: &'a TreeAsset, full: bool) -> Self {
        let look = look_of(asset);
        let lods = asset.lods.iter().filter(|l| full || l.budget.is_some());
        Self {
            name: &asset.name,
            latin: &asset.latin,
            slug: &asset.slug,
            seed: asset.seed,
            full: &asset.lods[0].mesh,
            full_look: look,
            lods: lods
                .map(|lod| Lod {
                    budget: lod.budget,
                    state: &lod.state,
                    error_m: lod.error_m,
                    screen_size: lod.screen_size,
                    mesh: &lod.mesh,
                })
                .collect(),
            look,
        }
    }

    /// All LODs of a tree that may lack the full one, against that: `full` is [`reference()`] of the same tree.
    #[must_use]
    pub fn of_grown(asset: &'a TreeAsset, full: &'a Mesh) -> Self {
        Self {
            full,
            ..Self::of_asset(asset, true)
        }
    }

    /// The LODs of a pack as their files have them, against the full tree of `grown`, made by
    /// [`with_reference`] of the pack's [`settings_of`]. What a pack of earlier days does not hold, the sizes of its
    /// captures, is taken from `grown` if the atlases are the same ([`same_atlas`]), and else left out.
    ///
    /// # Panics
    /// As [`Subject::of_asset`].
    #[must_use]
    pub fn of_pack(pack: &'a PackContents, grown: &'a TreeAsset) -> Self {
        let manifest = &pack.manifest;
        let reliefs: &[Relief] = if !pack.reliefs.is_empty() {
            &pack.reliefs
        } else if same_atlas(pack, grown) {
            &grown.reliefs
        } else {
            &[]
        };
        let lods = manifest.lods.iter().zip(&pack.lods);
        Self {
            name: &manifest.species.name,
            latin: &manifest.species.latin,
            slug: &manifest.species.slug,
            seed: manifest.seed,
            full: &grown.lods[0].mesh,
            full_look: look_of(grown),
            lods: lods
                .map(|(entry, mesh)| Lod {
                    budget: entry.budget,
                    state: &entry.state,
                    error_m: entry.error_m,
                    screen_size: entry.screen_size,
                    mesh,
                })
                .collect(),
            look: Look {
                foliage: &pack.foliage,
                bark: &pack.bark,
                reliefs,
            },
        }
    }
}

fn look_of(asset: &TreeAsset) -> Look<'_> {
    Look {
        foliage: &asset.foliage,
        bark: &asset.bark,
        reliefs: &asset.reliefs,
    }
}

/// True if a pack's foliage atlas is what the same script and seed give now.
#[must_use]
pub fn same_atlas(pack: &PackContents, grown: &TreeAsset) -> bool {
    let (a, b) = (&pack.foliage, &grown.foliage);
    a.albedo == b.albedo && a.normal == b.normal && a.orm == b.orm && a.extra == b.extra
}
