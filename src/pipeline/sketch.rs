//! A tree at full detail, without captures, LODs and shadows: what an editor shows while something changes.

use super::{GenerateError, Settings, artwork, bark};
use crate::asset::{AssetLod, Surface, TreeAsset};
use crate::capture::{self, LeafSheet};
use crate::image::atlas::Rect;
use crate::image::dilate::dilate;
use crate::impostor::cross_quad::CrossQuads;
use crate::lod::{Counts, Selector, State};
use crate::mesh::card::Pane;
use crate::mesh::{Coat, Flattener, Swayer};
use crate::shadow::Shadows;
use crate::species::Files;
use crate::species::schema::{Bark, LeafKind, LeafLook, Species};
use crate::tree;

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
}

/// Textures and what they were drawn from.
#[derive(Debug)]
struct Kept {
    leaves: Vec<LeafKind>,
    bark: Bark,
    seed: u64,
    foliage: Surface,
    rects: Vec<Rect>,
    panes: Vec<Pane>,
    wood: Surface,
    coat: Coat,
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
        let seed = settings.seed.unwrap_or(species.seed);
        self.shape(species, (seed, seed), settings, files)
    }

    /// Sketches the tree of one seed in the textures of another: to look at many shapes soon.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn shape(
        &mut self,
        species: &Species,
        (seed, textures): (u64, u64),
        settings: &Settings,
        files: &dyn Files,
    ) -> Result<Option<Sketch>, GenerateError> {
        let tree = tree::grow(species, seed, &settings.limits)?;
        if Selector::new(&tree, &species.lod).full_triangles() > MOST_TRIANGLES {
            return Ok(None);
        }
        let kept = self.textures(species, textures, files)?;
        let quads = CrossQuads::none(&tree, kept.panes.clone());
        let state = State::full(&tree);
        let form = quads.form(&tree, &state, kept.coat);
        let mut mesh = Flattener::new(&tree, &form).tree()?;
        let swayer = Swayer::new(&tree);
        swayer.form(&form, &mut mesh);
        let (foliage, wood) = (kept.foliage.clone(), kept.wood.clone());
        let rects = kept.rects.clone();
        let coat = kept.coat;
        let lod = AssetLod {
            budget: None,
            state: "full detail".to_owned(),
            triangles: Counts::of(&tree, 1).triangles(&tree, &state),
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
            wind: swayer.rig(),
            warnings: Vec::new(),
            tree,
        };
        Ok(Some(Sketch {
            asset,
            textures: self.number,
        }))
    }

    /// The textures of a species, drawn anew if they are others than before. Those of images always are: their
    /// files may have changed.
    fn textures(
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
