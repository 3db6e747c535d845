//! What draws the pictures: the GPU where the build and the machine have one, else the CPU rasteriser.

use super::super::Failure;
use super::super::args::{Blend, Light, Painter, Render, Show};
use crate::asset::Drawable;
use crate::image::Image;
use crate::math::{Vec2, Vec3};
use crate::mesh::Mesh;
use crate::preview;
use crate::wind::Wind;

/// How gusty winds are that nobody says more of.
const GUSTINESS: f32 = 0.7;

/// One picture that is wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shot {
    pub(super) size: [u32; 2],
    pub(super) lod: usize,
    /// Degrees about the tree and above the horizon.
    pub(super) camera: [f32; 2],
    sun: [f32; 2],
    /// Metres a second, degrees whither it blows.
    wind: [f32; 2],
    /// Seconds.
    pub(super) time: f32,
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "for the GPU alone"))]
    look: Look,
}

/// What only the GPU can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Look {
    transparent: bool,
    light: Light,
    view: Show,
    filter: Blend,
}

impl Look {
    const PLAIN: Self = Self {
        transparent: false,
        light: Light::Product,
        view: Show::Lit,
        filter: Blend::None,
    };

    fn of(args: &Render) -> Self {
        Self {
            transparent: args.transparent,
            light: args.light,
            view: args.view,
            filter: args.filter,
        }
    }
}

impl Shot {
    pub(super) fn of(args: &Render, lod: usize) -> Self {
        Self {
            size: args.size(),
            lod,
            camera: args.camera,
            sun: args.sun,
            wind: args.wind,
            time: args.time,
            look: Look::of(args),
        }
    }

    fn wind(self) -> Wind {
        let [speed_m_s, turn] = self.wind;
        let (x, z) = libm::sincosf(turn.to_radians());
        Wind {
            direction: Vec2::new(x, z),
            speed_m_s,
            gustiness: GUSTINESS,
        }
    }

    /// Toward the sun.
    fn to_sun(self) -> Vec3 {
        toward(self.sun)
    }
}

/// Unit vector toward a point given by degrees about the tree, 0 being +Z, and above the horizon.
fn toward([turn, height]: [f32; 2]) -> Vec3 {
    let (side, front) = libm::sincosf(turn.to_radians());
    let (up, level) = libm::sincosf(height.to_radians());
    Vec3::new(side * level, up, front * level)
}

/// What draws.
pub(super) enum Brush {
    /// A device with the trees that were put on it.
    #[cfg(feature = "gpu")]
    Gpu(Box<gpu::Brush>),
    /// The CPU rasteriser.
    Cpu,
}

/// The brush that the command line and the machine allow.
pub(super) fn brush(args: &Render) -> Result<Brush, Failure> {
    if args.renderer == Painter::Cpu {
        return cpu(args, "--renderer cpu");
    }
    #[cfg(feature = "gpu")]
    match gpu::Brush::new() {
        Ok(brush) => Ok(Brush::Gpu(Box::new(brush))),
        Err(error) if super::insists(args) => Err(gpu::failure(&error)),
        Err(error) => {
            eprintln!("warning: {error}; drawing with the CPU rasteriser");
            cpu(args, "a machine without a graphics driver")
        }
    }
    #[cfg(not(feature = "gpu"))]
    if super::insists(args) {
        Err(Failure::usage(
            "--renderer gpu: this build has no GPU renderer; build with `cargo build --release --features gpu`, or \
             leave the option out for the CPU rasteriser",
        ))
    } else {
        cpu(args, "a build without the feature `gpu`")
    }
}

/// The CPU rasteriser, if it can do what is asked for.
fn cpu(args: &Render, why: &str) -> Result<Brush, Failure> {
    if Look::of(args) == Look::PLAIN {
        return Ok(Brush::Cpu);
    }
    Err(Failure::usage(format!(
        "{why} draws with the CPU rasteriser, which knows no --transparent, --light, --view or --filter; leave \
         them out, or build with the feature `gpu`"
    )))
}

impl Brush {
    /// Draws one picture, framed around the tree.
    pub(super) fn paint(
        &mut self,
        tree: &Drawable<'_>,
        shot: &Shot,
    ) -> Result<Image<[u8; 4]>, Failure> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(brush) => brush.paint(tree, shot).map_err(|e| gpu::failure(&e)),
            Self::Cpu => {
                let settings = preview::Settings {
                    size: shot.size,
                    lod: shot.lod,
                    azimuth: shot.camera[0].to_radians(),
                    elevation: shot.camera[1].to_radians(),
                    sun: shot.to_sun(),
                    ..preview::Settings::default()
                };
                let moved = blown(tree, shot);
                let picture = match &moved {
                    None => preview::picture(tree, &settings),
                    // The tree at rest comes first: it says what the picture frames.
                    Some(mesh) => preview::picture(
                        &Drawable {
                            lods: vec![tree.lods[0], (mesh, tree.lods[shot.lod].1)],
                            ..tree.clone()
                        },
                        &preview::Settings { lod: 1, ..settings },
                    ),
                };
                Ok(picture.map(|&[r, g, b]| [r, g, b, 255]))
            }
        }
    }

    /// Draws a wood of several trees.
    pub(super) fn forest(
        &mut self,
        trees: &[Drawable<'_>],
        args: &Render,
    ) -> Result<Image<[u8; 4]>, Failure> {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(brush) => brush.forest(trees, args),
            Self::Cpu => Err(Failure::usage(format!(
                "--what forest: {} trees of {} kinds need the GPU renderer: a build with the feature `gpu`, and a \
                     graphics driver (on Debian and Ubuntu `apt install mesa-vulkan-drivers` brings one that needs no \
                     graphics card)",
                args.trees,
                trees.len()
            ))),
        }
    }

    /// Lets go of the tree that was drawn last: another one comes.
    pub(super) fn forget(&mut self) {
        #[cfg(feature = "gpu")]
        if let Self::Gpu(brush) = self {
            brush.forget();
        }
    }
}

/// A LOD's mesh in the wind; `None` in a calm.
fn blown(tree: &Drawable<'_>, shot: &Shot) -> Option<Mesh> {
    let wind = shot.wind();
    let [turn, height] = shot.camera;
    (wind.speed_m_s > 0.0).then(|| {
        let (mesh, _) = tree.lods[shot.lod];
        mesh.in_wind(&wind, &tree.wind, shot.time, -toward([turn, height]))
    })
}

#[cfg(feature = "gpu")]
pub(super) mod gpu {
    use super::super::super::Failure;
    use super::super::super::args::{Blend, Light, Show};
    use super::Shot;
    use crate::asset::Drawable;
    use crate::gpu::{Gpu, GpuError};
    use crate::image::Image;
    use crate::math::float;
    use crate::render::{self, Filter, LightMode, Orbit, Renderer, Scene, Setting, ViewMode};

    /// A device with the tree that was drawn last.
    pub(in super::super) struct Brush {
        pub(in super::super) renderer: Renderer,
    }

    pub(in super::super) fn failure(error: &GpuError) -> Failure {
        if error.is_worth_another_try() {
            Failure::machine(error)
        } else {
            Failure::input(error)
        }
    }

    impl Brush {
        pub(in super::super) fn new() -> Result<Self, GpuError> {
            let gpu = Gpu::headless()?;
            eprintln!("drawing with {}", gpu.describe());
            let renderer = Renderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb)?;
            Ok(Self { renderer })
        }

        pub(in super::super) fn forget(&mut self) {
            self.renderer.clear();
        }

        pub(super) fn paint(
            &mut self,
            tree: &Drawable<'_>,
            shot: &Shot,
        ) -> Result<Image<[u8; 4]>, GpuError> {
            if self.renderer.models().is_empty() {
                self.renderer.add(tree)?;
            }
            let hull = &self.renderer.models()[0].hull;
            let aspect = float(shot.size[0]) / float(shot.size[1]);
            let [turn, height] = shot.camera.map(f32::to_radians);
            let orbit = Orbit::around(hull, turn, height, render::PORTRAIT, aspect);
            let mut scene = Scene::of_one(orbit.camera(), 0, shot.lod);
            dress(&mut scene, shot);
            self.renderer.picture(&scene, shot.size)
        }
    }

    /// Light and looks as the command line has them.
    pub(in super::super) fn dress(scene: &mut Scene, shot: &Shot) {
        scene.setting = Setting {
            sun: shot.to_sun(),
            backdrop: !shot.look.transparent,
            light: match shot.look.light {
                Light::Product => LightMode::Product,
                Light::FourFactors => LightMode::FourFactors,
            },
            leaves_face_sun: shot.look.light == Light::FourFactors,
            ..Setting::default()
        };
        scene.wind = shot.wind();
        scene.time = shot.time;
        scene.view = match shot.look.view {
            Show::Lit => ViewMode::Lit,
            Show::Lods => ViewMode::Lods,
            Show::Levels => ViewMode::Levels,
            Show::Normals => ViewMode::Normals,
            Show::Albedo => ViewMode::Albedo,
            Show::Overdraw => ViewMode::Overdraw,
            Show::Wire => ViewMode::Wire,
        };
        scene.filter = match shot.look.filter {
            Blend::None => Filter::None,
            Blend::Bilinear => Filter::Bilinear,
            Blend::Alpha => Filter::Alpha,
            Blend::Combined => Filter::Combined,
        };
    }
}
