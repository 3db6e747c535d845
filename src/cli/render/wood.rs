//! A wood of the trees given, as seen from a clearing.

use super::super::Failure;
use super::super::args::Render;
use super::painter::{Shot, gpu};
use crate::asset::Drawable;
use crate::image::Image;
use crate::math::{Bounds, PI, Vec2, Vec3, float};
use crate::render::forest::{Clearing, Forest, ForestError, Planting, plant};
use crate::render::{Camera, Lens, Model, Scene};

/// Height of a standing person's eyes, metres.
const EYES_M: f32 = 1.7;

/// Vertical angle of view: that of a landscape.
const LANDSCAPE: f32 = 0.21 * PI;

impl gpu::Brush {
    /// Draws a wood in which all trees have equal shares.
    pub(super) fn forest(
        &mut self,
        trees: &[Drawable<'_>],
        args: &Render,
    ) -> Result<Image<[u8; 4]>, Failure> {
        self.renderer.clear();
        for tree in trees {
            self.renderer.add(tree).map_err(|e| gpu::failure(&e))?;
        }
        let (planting, camera) = wood(self.renderer.models(), args);
        let mut forest = self
            .renderer
            .forest(&plant(&planting))
            .map_err(|e| failure(&e))?;
        forest.settings.lod = args.lod.and_then(|lod| u32::try_from(lod).ok());
        let shot = Shot::of(args, 0);
        let mut scene = Scene {
            camera,
            groups: Vec::new(),
            ..Scene::of_one(camera, 0, 0)
        };
        gpu::dress(&mut scene, &shot);
        let picture = self
            .renderer
            .picture_of_forest(&mut forest, &scene, shot.size)
            .map_err(|e| gpu::failure(&e))?;
        tell(&self.renderer, &forest).map_err(|e| gpu::failure(&e))?;
        Ok(picture)
    }
}

fn failure(error: &ForestError) -> Failure {
    match error {
        ForestError::Gpu(error) => gpu::failure(error),
        other => Failure::usage(other),
    }
}

/// Where trees stand and where the eye is: at the rim of a clearing, looking over the middle of the wood.
fn wood(models: &[Model], args: &Render) -> (Planting, Camera) {
    let of_all = |size: fn(&Bounds) -> f32| {
        let sum: f32 = models.iter().map(|m| size(&m.bounds)).sum();
        sum / float(u32::try_from(models.len()).unwrap_or(1).max(1))
    };
    let height = of_all(|b| b.size().y);
    let width = of_all(|b| (b.size().x + b.size().z) * 0.5);
    let mut planting = Planting {
        trees: args.trees,
        seed: args.seed.unwrap_or(1),
        shares: vec![1.0; models.len()],
        spacing_m: (width * 0.8).max(0.1),
        group_m: height * 4.0,
        ..Planting::default()
    };
    let [turn, above] = args.camera.map(f32::to_radians);
    let (side, front) = libm::sincosf(turn);
    let out = Vec2::new(side, front);
    let away = planting.half_edge_m() * 0.45;
    let foot = out * away;
    planting.clearings = vec![Clearing {
        middle: foot - out * height * 0.8,
        radius: height * 1.5,
    }];
    let ahead = height * 4.0;
    let rise = libm::tanf(above.clamp(-1.4, 1.4)) * ahead;
    let eye = Vec3::new(foot.x, (EYES_M + rise).max(0.3), foot.y);
    let target = eye - Vec3::new(out.x, 0.0, out.y) * ahead;
    let camera = Camera {
        eye,
        target: target.with_y(height * 0.45 + (rise * 0.3).max(0.0)),
        lens: Lens::Perspective(LANDSCAPE),
    };
    (planting, camera)
}

/// Says what was drawn.
fn tell(renderer: &crate::render::Renderer, forest: &Forest) -> Result<(), crate::gpu::GpuError> {
    let lists = forest.lists(renderer.gpu())?;
    let counts = forest.counts(&lists, renderer.models());
    eprintln!(
        "{} of {} trees seen, {} triangles in {} draw calls; by LOD {:?}",
        counts.trees,
        forest.trees().len(),
        counts.triangles,
        forest.calls(),
        counts.by_lod
    );
    Ok(())
}
