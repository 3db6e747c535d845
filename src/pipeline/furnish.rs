//! The captures and the shadows of a sketch: what an author sees of them soon after an edit, before LODs are measured.
//!
//! Captures are those from two sides alone, since planes are fitted where forms are measured. Shadows are cast by fewer,
//! larger leaves. Both are made anew, and finer, with the LODs.

use super::stand_in::{STAND_INS, thinned};
use super::{ALPHA_CUTOFF, Bakers, GenerateError, Settings, Sketcher, artwork};
use crate::asset::{Surface, TreeAsset};
use crate::capture::{self, Plan};
use crate::image::dilate::dilate;
use crate::impostor::cross_quad::CrossQuads;
use crate::lod::State;
use crate::math::byte_from_unit;
use crate::mesh::Flattener;
use crate::report::Progress;
use crate::shadow;
use crate::species::Files;
use crate::species::schema::Species;

impl Sketcher {
    /// A sketch at full detail with captures and shadows. Its LODs stay as they are.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn furnish(
        &mut self,
        bakers: Bakers<'_>,
        (sketch, species): (&TreeAsset, &Species),
        settings: &Settings,
        files: &dyn Files,
        progress: &dyn Progress,
    ) -> Result<TreeAsset, GenerateError> {
        let mut asset = sketch.clone();
        let tree = &asset.tree;
        let artwork = artwork(species, asset.seed, files)?;
        let kept = self.textures(species, asset.seed, files)?;
        let plan = Plan::of(tree);
        let (splines, leaves) = (species.lod.tolerances.len(), sketch.leaves.clone());
        let captures = || {
            let bark = (&kept.bark_mips[..], kept.coat);
            let settings = &settings.captures;
            capture::bake_with(
                bakers.captures,
                tree,
                &plan,
                &artwork,
                bark,
                settings,
                progress,
            )
        };
        let shadows = || {
            let (thin, state) = thinned(tree, splines, STAND_INS[0]);
            let form = CrossQuads::none(&thin, leaves).form(&thin, &state, kept.coat);
            let mesh = Flattener::new(&thin, &form).tree()?;
            // The third byte is the coverage.
            let alpha = sketch.foliage.extra.map(|e| e[2]);
            let alpha = (&alpha, byte_from_unit(ALPHA_CUTOFF));
            let told = Unnamed(progress);
            let shadows =
                shadow::bake_with(bakers.shadows, &mesh, alpha, &settings.shadows, &told)?;
            Ok::<_, GenerateError>(shadows)
        };
        let (baked, shadows) = rayon::join(captures, shadows);
        let (baked, shadows) = (baked?, shadows?);
        let form = baked.quads.form(tree, &State::full(tree), kept.coat);
        let mut mesh = Flattener::new(tree, &form).tree()?;
        let mut atlas = baked.atlas;
        dilate(&mut atlas);
        if let Some(full) = asset.lods.first_mut() {
            // The same vertices, with other places in the atlas.
            mesh.bark.sway = core::mem::take(&mut full.mesh.bark.sway);
            mesh.foliage.sway = core::mem::take(&mut full.mesh.foliage.sway);
            full.mesh = mesh;
        }
        asset.baker = bakers.inexact();
        asset.captures = plan.captures();
        asset.foliage = Surface::of_atlas(&atlas, &baked.rects);
        asset.rects = baked.rects;
        asset.reliefs = baked.quads.reliefs();
        asset.leaves = baked.quads.leaves;
        asset.shadows = shadows;
        asset.warnings = baked.warnings;
        Ok(asset)
    }
}

/// Tells when to give up, and takes no steps: two works at once have one name.
struct Unnamed<'a>(&'a dyn Progress);

impl Progress for Unnamed<'_> {
    fn begin(&self, _stage: &'static str, _steps: u64) {}

    fn step(&self) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Haste;
    use crate::report::Quiet;
    use crate::species::{self, NoFiles};

    #[test]
    fn a_furnished_sketch_has_captures_and_shadows_and_its_own_shape() {
        let text = include_str!("../../species/olive.ron");
        let species = species::parse("olive.ron", text, &NoFiles).expect("a sound script");
        let settings = Settings::default();
        let mut sketcher = Sketcher::default();
        let sketch = sketcher.sketch_in(Haste::Some, &species, &settings, &NoFiles);
        let sketch = sketch.expect("it grows").expect("it is small").asset;
        let made = sketcher.furnish(
            Bakers::CPU,
            (&sketch, &species),
            &settings,
            &NoFiles,
            &Quiet,
        );
        let made = made.expect("it is furnished");
        assert_eq!(made.shadows.maps.len(), shadow::COUNT);
        assert_eq!(made.captures, Plan::of(&sketch.tree).captures());
        assert!(made.rects.len() > made.captures && !made.reliefs.is_empty());
        let [own, before] = [&made, &sketch].map(|a| &a.lods[0].mesh);
        let places = |mesh: &crate::mesh::Mesh| -> Vec<[f32; 3]> {
            mesh.bark.vertices.iter().map(|v| v.position).collect()
        };
        assert!(places(own) == places(before));
        assert_eq!(own.foliage.sway.len(), own.foliage.vertices.len());
        let shade = |map: &shadow::ShadowMap| map.image.texels().iter().any(|&t| t > 128);
        assert!(made.shadows.maps.iter().all(shade));
    }
}
