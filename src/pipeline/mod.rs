//! The list of stages: from a species and a seed to a finished [`TreeAsset`].

mod choose;
mod furnish;
mod sketch;
mod stand_in;
mod tone;

pub use choose::Selection;
pub use sketch::{Haste, Sketch, Sketcher};

use self::choose::Fitting;
use self::tone::Tones;
use crate::asset::{Asked, AssetLod, Surface, TreeAsset};
use crate::capture::{self, ALPHA_CUTOFF, BakeError, LeafArtwork, Plan};
use crate::image::dilate::dilate;
use crate::image::{Image, Texel, mips};
use crate::impostor::cross_quad::CrossQuads;
use crate::lod::Selector;
use crate::math::{Bounds, byte_from_unit};
use crate::measure::MeasureError;
use crate::measure::menu::{self, Forms};
use crate::measure::silhouette::Cutouts;
use crate::measure::yardstick::Yardstick;
use crate::mesh::{Coat, Flattener, Mesh, Swayer, TooLarge};
use crate::report::{Cancelled, MachineFault, Progress, Warning};
use crate::shadow;
use crate::species::Files;
use crate::species::schema::{LeafLook, LodSelector, Species};
use crate::texture;
use crate::tree::{self, GrowError, Limits, Tree};

/// What to make of a species.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Seed; the script's own if `None`.
    pub seed: Option<u64>,
    /// Triangle budgets, falling; the script's own if `None`.
    pub budgets: Option<Vec<u64>>,
    /// True to lead the chain with full detail.
    pub full: bool,
    /// How captures are made.
    pub captures: capture::Settings,
    /// Edge of the bark texture, texels.
    pub bark_size: u32,
    /// How shadows are baked.
    pub shadows: shadow::Settings,
    /// How LODs are chosen under their budgets; the script's word if `None`.
    pub selection: Option<Selection>,
    /// True to scale each LOD's quads so that it covers as much as full detail; the script's word if `None`.
    pub calibrate: Option<bool>,
    /// How large a tree may be.
    pub limits: Limits,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: None,
            budgets: None,
            full: false,
            captures: capture::Settings::default(),
            bark_size: 512,
            shadows: shadow::Settings::default(),
            selection: None,
            calibrate: None,
            limits: Limits::default(),
        }
    }
}

impl From<LodSelector> for Selection {
    fn from(selector: LodSelector) -> Self {
        match selector {
            LodSelector::Cut => Self::Cut,
            LodSelector::Levels => Self::Levels,
        }
    }
}

impl Settings {
    /// What is asked of the chain of LODs: these settings, and the script's word where they have none.
    #[must_use]
    pub fn asked(&self, species: &Species) -> Asked {
        let lod = &species.lod;
        Asked {
            budgets: self.budgets.clone().unwrap_or_else(|| lod.budgets.clone()),
            full: self.full,
            selector: match self.selection {
                Some(Selection::Cut) => LodSelector::Cut,
                Some(Selection::Levels) => LodSelector::Levels,
                None => lod.selector,
            },
            calibrate: self.calibrate.unwrap_or(lod.calibrate),
        }
    }
}

/// Why a tree could not be made.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// The species cannot be grown.
    #[error(transparent)]
    Grow(#[from] GrowError),
    /// A file named in the script is of no use.
    #[error("`{path}`: {reason}")]
    File {
        /// Path as the script has it.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// Captures could not be made.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The machine that draws captures or shadows failed.
    #[error(transparent)]
    Machine(#[from] MachineFault),
    /// A mesh would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// No budget asked for got a LOD.
    #[error(
        "none of the budgets {budgets:?} gives a LOD; the smallest form has {smallest} triangles"
    )]
    NoLod {
        /// Budgets asked for.
        budgets: Vec<u64>,
        /// Triangles of the smallest form.
        smallest: u64,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl GenerateError {
    /// True if the machine is at fault and another try may help.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        match self {
            Self::Machine(fault) | Self::Bake(BakeError::Machine(fault)) => fault.passing,
            _ => false,
        }
    }
}

impl From<shadow::BakeError> for GenerateError {
    fn from(error: shadow::BakeError) -> Self {
        match error {
            shadow::BakeError::Cancelled(error) => error.into(),
            shadow::BakeError::Machine(error) => error.into(),
        }
    }
}

impl From<MeasureError> for GenerateError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::TooLarge(error) => error.into(),
            MeasureError::Cancelled(error) => error.into(),
        }
    }
}

/// What draws captures and shadows.
#[derive(Clone, Copy)]
pub struct Bakers<'a> {
    /// Captures.
    pub captures: &'a dyn capture::Backend,
    /// Shadows.
    pub shadows: &'a dyn shadow::Backend,
}

impl Bakers<'static> {
    /// The processor: the same bytes everywhere.
    pub const CPU: Self = Self {
        captures: &capture::Cpu,
        shadows: &shadow::Cpu,
    };
}

impl Bakers<'_> {
    /// What drew, in words, unless the processor did.
    fn inexact(&self) -> Option<String> {
        self.captures.inexact().or_else(|| self.shadows.inexact())
    }
}

/// Makes a tree: grow, texture, capture, choose LODs, flatten, shadow.
///
/// # Errors
/// See [`GenerateError`]; warnings travel in the asset.
pub fn generate(
    species: &Species,
    settings: &Settings,
    files: &dyn Files,
    progress: &dyn Progress,
) -> Result<TreeAsset, GenerateError> {
    generate_with(Bakers::CPU, species, settings, files, progress)
}

/// The same with captures and shadows drawn by somebody else. Only the processor gives the same bytes for the
/// same script and seed on any machine.
///
/// # Errors
/// See [`GenerateError`]; warnings travel in the asset.
pub fn generate_with(
    bakers: Bakers<'_>,
    species: &Species,
    settings: &Settings,
    files: &dyn Files,
    progress: &dyn Progress,
) -> Result<TreeAsset, GenerateError> {
    let seed = settings.seed.unwrap_or(species.seed);
    let tree = tree::grow(species, seed, &settings.limits)?;
    let artwork = artwork(species, seed, files)?;
    let (coat, bark) = bark(species, seed, settings.bark_size, files)?;
    let mut plan = Plan::of(&tree);
    let forms = forms(species, settings, &tree, &artwork, progress)?;
    let budgets = settings.budgets.as_deref().unwrap_or(&species.lod.budgets);
    let budgets = (budgets, settings.full);
    let drafts = choose::draft(&tree, &species.lod, forms.as_ref(), budgets);
    let used = choose::extend(&mut plan, &tree, forms.as_ref(), &drafts);
    let baked = capture::bake_with(
        bakers.captures,
        &tree,
        &plan,
        &artwork,
        (&bark, coat),
        &settings.captures,
        progress,
    )?;
    let swayer = Swayer::new(&tree);
    let wind = swayer.rig();
    let fitting = Fitting {
        tree: &tree,
        forms: forms.as_ref(),
        used: &used,
        quads: &baked.quads,
        swayer: &swayer,
        coat,
        calibrate: settings.calibrate.unwrap_or(species.lod.calibrate),
        selection: settings.asked(species).selector.into(),
        progress,
    };
    let (lods, tones) = lods(species, &fitting, &drafts.drafts, &baked, &bark)?;
    if lods.is_empty() {
        return Err(GenerateError::NoLod {
            budgets: budgets.0.to_vec(),
            smallest: Selector::new(&tree, &species.lod).smallest_triangles(),
        });
    }
    let mut warnings = baked.warnings;
    warnings.extend(drafts.warnings);
    let mesh = caster(species, &tree, &baked.quads, coat)?;
    warnings.extend(simplified(species, &tree, &mesh));
    let alpha = baked.atlas.map(|t| byte_from_unit(t.alpha));
    let alpha = (&alpha, byte_from_unit(ALPHA_CUTOFF));
    let shadows = shadow::bake_with(bakers.shadows, &mesh, alpha, &settings.shadows, progress)?;
    let sources = sources(species, files)?;
    let mut atlas = baked.atlas;
    let kinds = plan.captures()..plan.captures() + artwork.kinds();
    tones.apply(&mut atlas, &baked.rects[kinds]);
    dilate(&mut atlas);
    Ok(TreeAsset {
        name: species.name.clone(),
        latin: species.latin.clone(),
        slug: species.slug.clone(),
        seed,
        baker: bakers.inexact(),
        asked: settings.asked(species),
        captures: plan.captures(),
        plane_captures: plan.plane_captures(),
        sources,
        bounds: lods
            .iter()
            .fold(Bounds::EMPTY, |all, lod| all.union(&lod.mesh.bounds())),
        lods,
        foliage: Surface::of_atlas(&atlas, &baked.rects),
        bark: Surface::of(&tones.apply_to_bark(&bark[0])),
        tones: tones.tones(),
        rects: baked.rects,
        reliefs: baked.quads.reliefs(),
        leaves: baked.quads.leaves,
        coat,
        shadows,
        wind,
        warnings,
        tree,
    })
}

/// The files that a script names, with their bytes.
fn sources(species: &Species, files: &dyn Files) -> Result<Vec<(String, Vec<u8>)>, GenerateError> {
    let read = |path: &String| {
        let bytes = files.read_bytes(path);
        let bytes = bytes.map_err(|reason| GenerateError::File {
            path: path.clone(),
            reason,
        })?;
        Ok((path.clone(), bytes))
    };
    species.files.iter().map(read).collect()
}

/// Leaf kinds with their images read.
struct Artwork<'a> {
    species: &'a Species,
    seed: u64,
    images: Vec<Option<Image<Texel>>>,
}

/// Image files of more texels are refused: 8192 x 8192.
const IMAGE_LIMIT: u64 = 1 << 26;

/// Reads an image that a script names; [`GenerateError::Image`] if it is of no use.
pub(crate) fn read_image(path: &str, files: &dyn Files) -> Result<Image<Texel>, GenerateError> {
    let fault = |reason: String| GenerateError::File {
        path: path.to_owned(),
        reason,
    };
    let bytes = files.read_bytes(path).map_err(fault)?;
    let image = crate::image::png::decode(&bytes, IMAGE_LIMIT).map_err(fault)?;
    Ok(texture::texels_from_srgb(&image))
}

fn artwork<'a>(
    species: &'a Species,
    seed: u64,
    files: &dyn Files,
) -> Result<Artwork<'a>, GenerateError> {
    let image = |kind: &crate::species::schema::LeafKind| match &kind.look {
        LeafLook::Drawn(_) => Ok(None),
        LeafLook::Image(path) => read_image(path, files).map(Some),
    };
    let images: Result<Vec<_>, GenerateError> = species.leaves.iter().map(image).collect();
    Ok(Artwork {
        species,
        seed,
        images: images?,
    })
}

impl LeafArtwork for Artwork<'_> {
    fn aspect(&self, kind: usize) -> f32 {
        let kind = &self.species.leaves[kind];
        kind.width_m / kind.length_m
    }

    fn draw(&self, kind: usize, width: u32, height: u32) -> Image<Texel> {
        let leaf = &self.species.leaves[kind];
        match (&leaf.look, &self.images[kind]) {
            (LeafLook::Drawn(art), _) => {
                texture::leaf(leaf, art, art.state, self.seed, width, height)
            }
            (LeafLook::Image(_), Some(image)) => texture::resized(image, width, height),
            (LeafLook::Image(_), None) => Image::filled(width, height, Texel::EMPTY),
        }
    }

    fn kinds(&self) -> usize {
        self.species.leaves.len()
    }
}

/// How bark lies on stems, and its texture as mips, of the asked size whatever the image file's.
fn bark(
    species: &Species,
    seed: u64,
    size: u32,
    files: &dyn Files,
) -> Result<(Coat, Vec<Image<Texel>>), GenerateError> {
    use crate::species::schema::Bark;
    let base = match &species.bark {
        Bark::Drawn(art) => texture::bark(art, seed, size),
        Bark::Image { path, .. } => texture::resized(&read_image(path, files)?, size, size),
    };
    let (coat, base) = Coat::of(&species.bark, base);
    Ok((coat, mips::chain(base, 10, ALPHA_CUTOFF)))
}

/// Trees of more leaf cards are not measured form by form: their LODs are chosen by level-wide steps.
const MEASURED_CARDS: u64 = 150_000;

/// The forms of all prototypes with their measured errors; `None` if nothing would use them.
fn forms(
    species: &Species,
    settings: &Settings,
    tree: &Tree,
    artwork: &Artwork<'_>,
    progress: &dyn Progress,
) -> Result<Option<Forms>, GenerateError> {
    let nodes = tree.nodes();
    let levels = nodes.iter().zip(&tree.levels);
    let cards: u64 = levels
        .filter(|(_, level)| level.kind == tree::Kind::Leaf)
        .flat_map(|(nodes, _)| nodes)
        .sum();
    let levels_only = settings.asked(species).selector == LodSelector::Levels;
    if levels_only || cards > MEASURED_CARDS {
        return Ok(None);
    }
    let sheet = capture::leaf_sheet(artwork)?;
    let cutouts = Cutouts::of(&sheet.image);
    let leaves = CrossQuads::none(tree, sheet.panes);
    let turns = capture::standing(tree);
    Ok(Some(menu::forms(
        tree,
        &species.lod,
        &leaves,
        &cutouts,
        (
            &turns,
            settings.budgets.as_deref().unwrap_or(&species.lod.budgets),
            settings.captures.atlas_size,
        ),
        progress,
    )?))
}

/// Triangles of the mesh that LODs are measured against: more would not show.
const REFERENCE_TRIANGLES: u64 = 600_000;

/// LODs from their drafts, measured against full detail, and the tones that their captures need.
fn lods(
    species: &Species,
    fitting: &Fitting<'_>,
    drafts: &[choose::Draft],
    baked: &capture::Baked,
    bark: &[Image<Texel>],
) -> Result<(Vec<AssetLod>, Tones), GenerateError> {
    fitting.progress.begin("choosing LODs", drafts.len() as u64);
    let full = choose::reference(
        fitting.tree,
        &species.lod,
        fitting.quads,
        fitting.coat,
        REFERENCE_TRIANGLES,
    )?;
    let cutouts = Cutouts::of(&baked.atlas);
    let yardstick = Yardstick::while_ok(&full, &cutouts, || fitting.go_on())?;
    let lods = fitting.lods(drafts, &yardstick, &cutouts, full.bounds().size().y)?;
    let tones = tone::measure(&full, &lods, (&baked.atlas, bark), fitting.quads);
    Ok((lods, tones))
}

/// Triangles that the shadows are cast by at most: more would not show in a soft shadow.
const SHADOW_TRIANGLES: u64 = 60_000;

/// A warning if the shadows are cast by fewer leaves than there are. (Coarser branches alone cannot be told
/// apart in a shadow.)
fn simplified(species: &Species, tree: &Tree, caster: &Mesh) -> Option<Warning> {
    (caster.foliage.triangles() < leaf_triangles(tree)).then(|| Warning::ShadowsSimplified {
        triangles: Selector::new(tree, &species.lod).full_triangles(),
        used: caster.triangles(),
    })
}

fn leaf_triangles(tree: &Tree) -> u64 {
    crate::lod::Counts::of(tree, 1)
        .triangles(tree, &crate::lod::State::full(tree))
        .foliage
}

/// The mesh that casts the shadows: the finest form that is not wastefully fine.
fn caster(
    species: &Species,
    tree: &Tree,
    quads: &CrossQuads,
    coat: Coat,
) -> Result<Mesh, TooLarge> {
    let selector = Selector::new(tree, &species.lod);
    let chain = selector.chain(&[SHADOW_TRIANGLES], false);
    let state = chain
        .lods
        .first()
        .map_or_else(|| crate::lod::State::full(tree), |l| l.state.clone());
    let form = quads.form(tree, &state, coat);
    Flattener::new(tree, &form).tree()
}
