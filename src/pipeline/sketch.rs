//! A tree at full detail, without captures, LODs and shadows: what an editor shows while something changes.

use super::stand_in::{STAND_INS, thinned};
use super::{GenerateError, Settings, artwork, bark};
use crate::asset::{AssetLod, Surface, TreeAsset};
use crate::capture::{self, LeafSheet};
use crate::image::atlas::Rect;
use crate::image::dilate::dilate;
use crate::image::{Image, Texel};
use crate::impostor::cross_quad::CrossQuads;
use crate::lod::{Counts, Selector, State};
use crate::mesh::card::Pane;
use crate::mesh::{Coat, Flattener, Mesh, Swayer, TooLarge};
use crate::shadow::Shadows;
use crate::species::Files;
use crate::species::schema::{Bark, LeafKind, LeafLook, Species};
use crate::tree::{self, Tree};
use crate::wind::Rig;

/// Trees of more triangles are not sketched: they would not follow a hand.
const MOST_TRIANGLES: u64 = 1_500_000;

/// Texels along the edge of the bark.
const BARK: u32 = 256;

/// Sketches trees, and keeps their textures from one to the next as long as they stay the same.
#[derive(Debug, Default)]
pub struct Sketcher {
    kept: Option<Kept>,
    /// Number of the textures that are kept.
    number: u64,
}

/// A sketch.
#[derive(Debug)]
pub struct Sketch {
    /// The tree, with one LOD, and without captures and shadows.
    pub asset: TreeAsset,
    /// Number of its textures: the same as that of another sketch of the same sketcher if they are the same.
    pub textures: u64,
    /// Meshes of few triangles that stand in for it while something moves, falling.
    pub stand_ins: Vec<Mesh>,
    /// True if its own mesh stands in for full detail.
    pub is_rough: bool,
}

/// How soon a sketch is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Haste {
    /// At full detail, and no other.
    None,
    /// At full detail, with meshes that stand in for it.
    Some,
    /// In few triangles where full detail has many: it follows a hand on a slow machine.
    Great,
}

/// Textures and what they were drawn from.
#[derive(Debug)]
pub(super) struct Kept {
    leaves: Vec<LeafKind>,
    bark: Bark,
    seed: u64,
    foliage: Surface,
    rects: Vec<Rect>,
    panes: Vec<Pane>,
    wood: Surface,
    /// The same as texels, with their mips.
    pub(super) bark_mips: Vec<Image<Texel>>,
    pub(super) coat: Coat,
}

impl Sketcher {
    /// Sketches a tree; `None` if it has too many triangles to be sketched.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn sketch(
        &mut self,
        species: &Species,
        settings: &Settings,
        files: &dyn Files,
    ) -> Result<Option<Sketch>, GenerateError> {
        self.sketch_in(Haste::None, species, settings, files)
    }

    /// Sketches a tree in more or less haste.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn sketch_in(
        &mut self,
        haste: Haste,
        species: &Species,
        settings: &Settings,
        files: &dyn Files,
    ) -> Result<Option<Sketch>, GenerateError> {
        let seed = settings.seed.unwrap_or(species.seed);
        self.draw(haste, species, (seed, seed), settings, files)
    }

    /// Sketches the tree of one seed in the textures of another: to look at many shapes soon.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn shape(
        &mut self,
        species: &Species,
        seeds: (u64, u64),
        settings: &Settings,
        files: &dyn Files,
    ) -> Result<Option<Sketch>, GenerateError> {
        self.draw(Haste::None, species, seeds, settings, files)
    }

    fn draw(
        &mut self,
        haste: Haste,
        species: &Species,
        (seed, textures): (u64, u64),
        settings: &Settings,
        files: &dyn Files,
    ) -> Result<Option<Sketch>, GenerateError> {
        let tree = tree::grow(species, seed, &settings.limits)?;
        let full = Selector::new(&tree, &species.lod).full_triangles();
        if full > MOST_TRIANGLES {
            return Ok(None);
        }
        let kept = self.textures(species, textures, files)?;
        let quads = CrossQuads::none(&tree, kept.panes.clone());
        let splines = species.lod.tolerances.len();
        let stand_in = |most: &u64| {
            let (thin, state) = thinned(&tree, splines, *most);
            drawn(&thin, &state, (&quads, kept.coat)).map(|(mesh, rig)| (mesh, rig, (thin, state)))
        };
        let mut smaller = STAND_INS
            .iter()
            .filter(|&&most| haste != Haste::None && full > most);
        let rough = match (haste, full > STAND_INS[0]) {
            (Haste::Great, true) => smaller.next().map(stand_in).transpose()?,
            _ => None,
        };
        let is_rough = rough.is_some();
        let stand_ins: Result<Vec<Mesh>, TooLarge> =
            smaller.map(|most| Ok(stand_in(most)?.0)).collect();
        let stand_ins = stand_ins?;
        let (mesh, rig, triangles, state) = match rough {
            Some((mesh, rig, (thin, state))) => {
                let triangles = Counts::of(&thin, splines).triangles(&thin, &state);
                (mesh, rig, triangles, "sketch")
            }
            None => {
                let state = State::full(&tree);
                let (mesh, rig) = drawn(&tree, &state, (&quads, kept.coat))?;
                let triangles = Counts::of(&tree, 1).triangles(&tree, &state);
                (mesh, rig, triangles, "full detail")
            }
        };
        let (foliage, wood) = (kept.foliage.clone(), kept.wood.clone());
        let rects = kept.rects.clone();
        let coat = kept.coat;
        let lod = AssetLod {
            budget: None,
            state: state.to_owned(),
            triangles,
            error_m: 0.0,
            screen_size: 1.0,
            scale: 1.0,
            iou: 1.0,
            coverage: 1.0,
            mesh,
        };
        let asset = TreeAsset {
            name: species.name.clone(),
            latin: species.latin.clone(),
            slug: species.slug.clone(),
            seed,
            sources: Vec::new(),
            baker: None,
            captures: 0,
            plane_captures: 0,
            asked: settings.asked(species),
            bounds: lod.mesh.bounds(),
            lods: vec![lod],
            foliage,
            bark: wood,
            rects,
            reliefs: Vec::new(),
            leaves: quads.leaves,
            coat,
            tones: Vec::new(),
            shadows: Shadows { maps: Vec::new() },
            wind: rig,
            warnings: Vec::new(),
            tree,
        };
        Ok(Some(Sketch {
            asset,
            textures: self.number,
            stand_ins,
            is_rough,
        }))
    }

    /// The textures of a species, drawn anew if they are others than before. Those of images always are: their
    /// files may have changed.
    pub(super) fn textures(
        &mut self,
        species: &Species,
        seed: u64,
        files: &dyn Files,
    ) -> Result<&Kept, GenerateError> {
        let images = species
            .leaves
            .iter()
            .any(|l| matches!(l.look, LeafLook::Image(_)))
            || matches!(species.bark, Bark::Image { .. });
        let same = |kept: &Kept| {
            !images
                && (&kept.leaves, &kept.bark, kept.seed) == (&species.leaves, &species.bark, seed)
        };
        if !self.kept.as_ref().is_some_and(same) {
            let artwork = artwork(species, seed, files)?;
            let (sheet, wood) = rayon::join(
                || capture::leaf_sheet(&artwork),
                || bark(species, seed, BARK, files),
            );
            let LeafSheet {
                mut image,
                rects,
                panes,
            } = sheet?;
            let (coat, wood) = wood?;
            dilate(&mut image);
            self.number += 1;
            self.kept = Some(Kept {
                leaves: species.leaves.clone(),
                bark: species.bark.clone(),
                seed,
                foliage: Surface::of_atlas(&image, &rects),
                rects,
                panes,
                wood: Surface::of(&wood[0]),
                bark_mips: wood,
                coat,
            });
        }
        // It was made just now if it was not there.
        self.kept.as_ref().ok_or(GenerateError::NoLod {
            budgets: Vec::new(),
            smallest: 0,
        })
    }
}

/// The mesh of a tree in a state, and how its sway is to be read.
fn drawn(
    tree: &Tree,
    state: &State,
    (quads, coat): (&CrossQuads, Coat),
) -> Result<(Mesh, Rig), TooLarge> {
    let form = quads.form(tree, state, coat);
    let mut mesh = Flattener::new(tree, &form).tree()?;
    let swayer = Swayer::new(tree);
    swayer.form(&form, &mut mesh);
    Ok((mesh, swayer.rig()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::generate;
    use crate::report::Quiet;
    use crate::species::{self, NoFiles};

    fn olive() -> Species {
        let text = include_str!("../../species/olive.ron");
        species::parse("olive.ron", text, &NoFiles).expect("a sound script")
    }

    #[test]
    fn a_sketch_is_full_detail_in_its_places() {
        let species = olive();
        let settings = Settings {
            full: true,
            budgets: Some(vec![2_000]),
            ..Settings::default()
        };
        let made = generate(&species, &settings, &NoFiles, &Quiet).expect("it grows");
        let sketch = Sketcher::default().sketch(&species, &settings, &NoFiles);
        let sketch = sketch.expect("it grows").expect("it is small");
        let [full, own] = [&made, &sketch.asset].map(|asset| &asset.lods[0]);
        assert_eq!(full.triangles, own.triangles);
        assert_eq!(own.triangles.total(), own.mesh.triangles());
        let points = |lod: &AssetLod| -> Vec<[f32; 3]> {
            lod.mesh.bark.vertices.iter().map(|v| v.position).collect()
        };
        assert!(points(full) == points(own));
        assert_eq!(
            made.lods[0].mesh.foliage.sway.len(),
            own.mesh.foliage.sway.len()
        );
    }

    #[test]
    fn a_sketch_in_haste_has_few_triangles_and_one_with_time_has_the_same_to_stand_in() {
        let (species, settings) = (olive(), Settings::default());
        let mut sketcher = Sketcher::default();
        let mut sketch = |haste: Haste| {
            let sketch = sketcher.sketch_in(haste, &species, &settings, &NoFiles);
            sketch.expect("it grows").expect("it is small")
        };
        let (hasty, whole) = (sketch(Haste::Great), sketch(Haste::Some));
        assert!(hasty.is_rough && !whole.is_rough);
        let own = &hasty.asset.lods[0];
        assert_eq!(own.triangles.total(), own.mesh.triangles());
        assert!(own.mesh.triangles() < whole.asset.lods[0].mesh.triangles() / 2);
        assert_eq!((hasty.stand_ins.len(), whole.stand_ins.len()), (1, 2));
        assert!(own.mesh == whole.stand_ins[0]);
        assert!(hasty.stand_ins[0] == whole.stand_ins[1]);
        // Handles stand on the nodes of the tree itself.
        assert_eq!(hasty.asset.tree, whole.asset.tree);
        assert!(sketch(Haste::None).stand_ins.is_empty());
    }

    #[test]
    fn textures_are_drawn_again_only_if_they_change() {
        let (mut species, settings) = (olive(), Settings::default());
        let mut sketcher = Sketcher::default();
        let mut number = |species: &Species| {
            let sketch = sketcher.sketch(species, &settings, &NoFiles);
            sketch.expect("it grows").expect("it is small").textures
        };
        let first = number(&species);
        species.levels[1].placement.links += 3;
        assert_eq!(number(&species), first);
        species.leaves[0].length_m *= 1.5;
        assert_eq!(number(&species), first + 1);
    }
}
