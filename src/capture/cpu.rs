//! The backend that needs no driver: visibility by [`super::raster`], samples averaged to texels.

use super::BakeError;
use super::backend::{Backend, Pass, Picture, Scene, Shot};
use super::occlusion::Occlusion;
use super::raster::{Textures, Visibility};
use crate::image::{Image, Texel};
use crate::math::{Vec3, float};
use crate::report::{Cancelled, Progress};
use rayon::prelude::*;

/// Draws with the processor: the same bytes on any machine, at any number of threads.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

impl Backend for Cpu {
    fn draw(
        &self,
        pass: &Pass<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Picture>>, BakeError> {
        let scenes = (0..pass.scenes).into_par_iter().map(|index| {
            if progress.cancelled() {
                return Err(Cancelled.into());
            }
            let mut scene = (pass.scene)(index)?;
            scene.occlusion.light();
            let picture = |&shot: &Shot| Picture {
                shot,
                image: picture(&scene, &shot, pass),
            };
            let pictures = scene.shots.par_iter().map(picture).collect();
            progress.step();
            Ok(pictures)
        });
        scenes.collect()
    }
}

/// Averages the samples of each texel; depth is still in metres.
fn picture(scene: &Scene, shot: &Shot, pass: &Pass<'_>) -> Image<Texel> {
    let (mesh, view, n) = (&scene.meshes[shot.mesh], &shot.view, pass.supersample);
    let textures: Textures<'_> = pass.textures;
    let occlusion: &Occlusion = &scene.occlusion;
    let seen = Visibility::draw(mesh, textures, view);
    let [width, height] = shot.texels;
    let row = |y: u32| {
        let seen = &seen;
        (0..width).map(move |x| {
            let mut sum = Sum::default();
            for (sx, sy) in (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j))) {
                if let Some(seen) = seen.surface(sx, sy, mesh, textures, view) {
                    sum.add(&seen.texel);
                }
            }
            let mut texel = sum.mean(n * n);
            if texel.alpha > 0.0 {
                let at =
                    glam::Vec2::new(float(x * n) + 0.5 * float(n), float(y * n) + 0.5 * float(n));
                texel.occlusion *= occlusion.open(view.unproject(at, texel.depth));
            }
            texel
        })
    };
    let texels: Vec<Texel> = (0..height).into_par_iter().flat_map_iter(row).collect();
    Image::from_texels(width, height, texels)
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
