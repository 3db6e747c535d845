//! One frame: shadow map, ground shadows, backdrop, trees, and the way to the screen.

use super::binding::group;
use super::camera::Lens;
use super::drawing::{
    AUXILIARY, Cast, Drawn, colour_attachment, depth_attachment, filter_code, flags, inner_size,
    light_code, light_projection, view_code,
};
use super::forest::{Forest, Woods};
use super::maker::Maker;
use super::model::{Model, extent};
use super::pipelines::Pipelines;
use super::scene::{CALM, Filter, Group, Scene, Setting, ViewMode};
use super::sun_map::{SHADOW_MAP, SMALL_MAP, SunMap};
use super::targets::Targets;
use super::uniforms::{Frame, Instance};
use crate::asset::Drawable;
use crate::gpu::{Gpu, GpuError, Readback, upload};
use crate::image::Image;
use crate::math::{Bounds, PI, Vec3, float};

/// Samples of a pixel.
pub(super) const SAMPLES: u32 = 4;

/// Linear colours of a clear day.
const SUN: Vec3 = Vec3::new(7.4, 6.75, 5.6);
const SKY: Vec3 = Vec3::new(0.62, 0.78, 1.05);
const FROM_GROUND: Vec3 = Vec3::new(0.40, 0.38, 0.24);
const ZENITH: Vec3 = Vec3::new(0.13, 0.30, 0.66);
const HORIZON: Vec3 = Vec3::new(0.62, 0.74, 0.86);

/// Draws scenes.
#[derive(Debug)]
pub struct Renderer {
    pub(super) gpu: Gpu,
    pub(super) pipelines: Pipelines,
    pub(super) models: Vec<Model>,
    /// What forests share; made for the first one.
    pub(super) woods: Option<Woods>,
    targets: Option<Targets>,
    frame: wgpu::Buffer,
    /// The shadow map, and a small one.
    sun_maps: [SunMap; 2],
    /// True if the next picture is wanted soon.
    hurried: bool,
    cast_group: wgpu::BindGroup,
    sampler: wgpu::Sampler,
    output: wgpu::TextureFormat,
}

impl Renderer {
    /// A renderer for pictures of this format.
    ///
    /// # Errors
    /// What the driver says of its pipelines.
    pub fn new(gpu: &Gpu, output: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let device = &gpu.device;
        let pipelines = Pipelines::new(device, SAMPLES, output);
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sun_maps =
            [SHADOW_MAP, SMALL_MAP].map(|edge| SunMap::new(device, &pipelines, &frame, edge));
        let cast_group = group(
            device,
            &pipelines.cast_frame,
            &[(0, frame.as_entire_binding())],
        );
        let linear = wgpu::FilterMode::Linear;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: linear,
            min_filter: linear,
            ..wgpu::SamplerDescriptor::default()
        });
        gpu.check()?;
        Ok(Self {
            gpu: gpu.clone(),
            pipelines,
            models: Vec::new(),
            woods: None,
            targets: None,
            frame,
            sun_maps,
            hurried: false,
            cast_group,
            sampler,
            output,
        })
    }

    /// Puts a tree on the device; the answer is its index in [`Group::model`].
    ///
    /// # Errors
    /// If the adapter cannot take it.
    pub fn add(&mut self, source: &Drawable<'_>) -> Result<usize, GpuError> {
        let model = self.maker().make(source, None)?;
        self.forget_casts();
        self.models.push(model);
        Ok(self.models.len() - 1)
    }

    /// Puts a tree in the place of another one, which stays if the adapter cannot take the new one; adds it if
    /// there is none at that index.
    ///
    /// # Errors
    /// If the adapter cannot take it.
    pub fn replace(&mut self, index: usize, source: &Drawable<'_>) -> Result<(), GpuError> {
        let model = self.maker().make(source, None)?;
        self.put(index, model);
        Ok(())
    }

    /// What makes models for this renderer on other threads.
    #[must_use]
    pub fn maker(&self) -> Maker {
        Maker {
            gpu: self.gpu.clone(),
            layouts: self.pipelines.layouts.clone(),
        }
    }

    /// Puts a model in the place of another one, or adds it if there is none at that index.
    pub fn put(&mut self, index: usize, model: Model) {
        self.forget_casts();
        match self.models.get_mut(index) {
            Some(old) => *old = model,
            None => self.models.push(model),
        }
    }

    /// Forgets all trees.
    pub fn clear(&mut self) {
        self.forget_casts();
        self.models.clear();
    }

    /// Shadow maps show trees that are there no more.
    fn forget_casts(&mut self) {
        for map in &mut self.sun_maps {
            map.cast = None;
        }
    }

    /// Whether pictures are wanted soon from now on: a single tree then has coarse shadows.
    pub fn hurry(&mut self, hurried: bool) {
        self.hurried = hurried;
    }

    /// The trees on the device.
    #[must_use]
    pub fn models(&self) -> &[Model] {
        &self.models
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// A picture of a scene: sRGB, with straight alpha.
    ///
    /// # Errors
    /// If the size is more than the adapter allows, or the device fails.
    pub fn picture(&mut self, scene: &Scene, size: [u32; 2]) -> Result<Image<[u8; 4]>, GpuError> {
        self.picture_with(scene, None, size)
    }

    pub(super) fn picture_with(
        &mut self,
        scene: &Scene,
        forest: Option<&mut Forest>,
        size: [u32; 2],
    ) -> Result<Image<[u8; 4]>, GpuError> {
        self.gpu.check_edge("a picture", size[0].max(size[1]))?;
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: extent(size[0].max(1), size[1].max(1), 1),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.output,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.frame(scene, forest, &view, size)?;
        let readback = Readback::record(&self.gpu, &mut encoder, &texture);
        self.gpu.queue.submit([encoder.finish()]);
        readback.wait(&self.gpu)
    }

    /// The commands that draw a scene into a picture of this size; to be submitted, each and in order: a shadow
    /// map that is as it was is not drawn again. Nothing is drawn into a
    /// picture without pixels, as a window without height has one.
    ///
    /// # Errors
    /// If the size is more than the adapter allows.
    pub fn draw(
        &mut self,
        scene: &Scene,
        output: &wgpu::TextureView,
        size: [u32; 2],
    ) -> Result<wgpu::CommandEncoder, GpuError> {
        self.frame(scene, None, output, size)
    }

    /// The commands that draw a scene, and a forest where there is one.
    pub(super) fn frame(
        &mut self,
        scene: &Scene,
        mut forest: Option<&mut Forest>,
        output: &wgpu::TextureView,
        size: [u32; 2],
    ) -> Result<wgpu::CommandEncoder, GpuError> {
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("frame"),
            });
        if size.contains(&0) {
            return Ok(encoder);
        }
        let inner = inner_size(size, scene.filter);
        let targets = match self.targets.take().filter(|t| t.size == inner) {
            Some(targets) => targets,
            None => Targets::new(&self.gpu, inner, SAMPLES)?,
        };
        let small = usize::from(self.hurried && forest.is_none());
        let mut uniforms = self.uniforms(scene, self.sun_maps[small].edge, inner);
        if let Some(forest) = &mut forest {
            Self::suit_forest(forest, scene, &mut uniforms);
            self.choose(&mut encoder, forest, scene, inner);
        }
        let forest = forest.as_deref();
        self.gpu
            .queue
            .write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniforms));
        let cast = Cast::of(scene, &uniforms);
        let is_known = forest.is_none() && self.sun_maps[small].cast.as_ref() == Some(&cast);
        let stale = scene.setting.shadow_map && !is_known;
        let drawn = self.drawn(scene);
        if stale {
            self.cast(&mut encoder, small, &drawn, forest);
        }
        self.backdrop(&mut encoder, &targets, scene, &drawn, forest);
        let sunlit = &self.sun_maps[small].frame_group;
        self.trees(&mut encoder, (&targets, sunlit), scene.view, &drawn, forest);
        self.present(&mut encoder, &targets, output);
        drop(drawn);
        if stale {
            self.sun_maps[small].cast = forest.is_none().then_some(cast);
        }
        self.targets = Some(targets);
        Ok(encoder)
    }

    /// Groups with their models, and their trees on the device; groups of what does not exist are left out.
    fn drawn<'s>(&'s self, scene: &'s Scene) -> Vec<Drawn<'s>> {
        let drawn = |group: &'s Group| {
            let model = self.models.get(group.model)?;
            let lod = model.lod(group.lod)?;
            let count = u32::try_from(group.trees.len()).ok().filter(|&n| n > 0)?;
            let mut trees = group.trees.clone();
            #[expect(clippy::cast_precision_loss, reason = "a handful of LODs")]
            let index = group.lod as f32;
            for tree in &mut trees {
                tree.marks[..2].copy_from_slice(&[index, lod.crisp]);
            }
            let instances = upload(
                &self.gpu,
                "trees",
                bytemuck::cast_slice(&trees),
                wgpu::BufferUsages::VERTEX,
            );
            Some(Drawn {
                model,
                lod,
                instances,
                count,
            })
        };
        scene.groups.iter().filter_map(drawn).collect()
    }

    fn uniforms(&self, scene: &Scene, map: u32, [width, height]: [u32; 2]) -> Frame {
        let (setting, camera) = (&scene.setting, &scene.camera);
        let [w, h] = [width, height].map(float);
        let projection = camera.view_projection(w / h);
        let sun = setting.sun.normalize_or(Vec3::Y);
        let bounds = self.bounds_of(&scene.groups);
        let (light, reach) = light_projection(&bounds, sun);
        let perspective = matches!(camera.lens, Lens::Perspective(_));
        let up = sun.y.max(0.0);
        // A low sun is redder, and the sky dims with it.
        let warm = Vec3::new(1.0, 0.72 + 0.28 * up.sqrt(), 0.42 + 0.58 * up.sqrt());
        let day = (0.25 + 0.75 * (up * 3.0).min(1.0)) * setting.sky_strength;
        let sunlight = SUN * warm * setting.sun_strength * (sun.y * 8.0).clamp(0.0, 1.0);
        let wind = scene.wind.direction.normalize_or(glam::Vec2::X);
        let unit = if setting.shadow_map {
            1.0 / float(map)
        } else {
            0.0
        };
        Frame {
            view_projection: projection.to_cols_array_2d(),
            inverse_view_projection: projection.inverse().to_cols_array_2d(),
            light_projection: light.to_cols_array_2d(),
            eye: camera
                .eye
                .extend(if perspective { 1.0 } else { 0.0 })
                .to_array(),
            forward: camera.forward().extend(setting.exposure).to_array(),
            sun: sun.extend(unit).to_array(),
            sun_light: sunlight.extend(setting.ground_shadows).to_array(),
            sky_light: (SKY * day).extend(setting.roundness).to_array(),
            ground_light: (FROM_GROUND * day).extend(setting.translucency).to_array(),
            zenith: (ZENITH * day).extend(0.0).to_array(),
            horizon: (HORIZON * day)
                .extend(bounds.size().length().max(1.0) * 12.0)
                .to_array(),
            ground: setting
                .ground
                .extend(if setting.backdrop { 1.0 } else { 0.0 })
                .to_array(),
            wind: [wind.x, wind.y, scene.wind.speed_m_s, scene.wind.gustiness],
            clock: [
                scene.time,
                float(SAMPLES),
                reach * 3.0 / float(map),
                AUXILIARY,
            ],
            viewport: [w, h, 1.0 / w, 1.0 / h],
            modes: [
                light_code(setting.light),
                view_code(scene.view),
                filter_code(scene.filter),
                flags(setting),
            ],
        }
    }

    /// Bounds of all trees of the scene.
    fn bounds_of(&self, groups: &[Group]) -> Bounds {
        let mut all = Bounds::EMPTY;
        for group in groups {
            let Some(model) = self.models.get(group.model) else {
                continue;
            };
            let radius = model
                .bounds
                .corners()
                .map(|c| Vec3::new(c.x, 0.0, c.z).length());
            let radius = radius.into_iter().fold(0.0, f32::max);
            let [low, high] = [model.bounds.min.y, model.bounds.max.y];
            for tree in &group.trees {
                let [x, y, z, size] = tree.place;
                let at = Vec3::new(x, y, z);
                all = all
                    .with_point(at + Vec3::new(-radius, low, -radius) * size)
                    .with_point(at + Vec3::new(radius, high, radius) * size);
            }
        }
        if all.is_empty() {
            return Bounds {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            };
        }
        all
    }

    fn cast(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: usize,
        drawn: &[Drawn<'_>],
        forest: Option<&Forest>,
    ) {
        let map = &self.sun_maps[map].view;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow map"),
            depth_stencil_attachment: Some(depth_attachment(map, 1.0)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.cast_group, &[]);
        for tree in drawn {
            pass.set_pipeline(&self.pipelines.bark_cast);
            tree.draw(&mut pass, tree.lod.bark.as_ref(), &tree.model.bark);
            pass.set_pipeline(&self.pipelines.foliage_cast);
            tree.draw(&mut pass, tree.lod.foliage.as_ref(), &tree.model.foliage);
        }
        if let Some(forest) = forest {
            self.cast_forest(&mut pass, forest);
        }
    }

    fn backdrop(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        scene: &Scene,
        drawn: &[Drawn<'_>],
        forest: Option<&Forest>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("ground shadows"),
            color_attachments: &[Some(colour_attachment(
                &targets.ground,
                None,
                wgpu::Color::WHITE,
            ))],
            ..wgpu::RenderPassDescriptor::default()
        });
        if scene.setting.backdrop {
            pass.set_pipeline(&self.pipelines.patches);
            pass.set_bind_group(0, &self.cast_group, &[]);
            for tree in drawn {
                pass.set_bind_group(1, &tree.model.ground_group, &[]);
                pass.set_vertex_buffer(0, tree.instances.slice(..));
                pass.draw(0..6, 0..tree.count);
            }
            if let Some(forest) = forest {
                self.shade_ground(&mut pass, forest);
            }
        }
        drop(pass);
        let ground = group(
            &self.gpu.device,
            &self.pipelines.ground_frame,
            &[
                (0, self.frame.as_entire_binding()),
                (4, wgpu::BindingResource::TextureView(&targets.ground)),
            ],
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("backdrop"),
            color_attachments: &[Some(colour_attachment(
                &targets.backdrop,
                None,
                wgpu::Color::TRANSPARENT,
            ))],
            ..wgpu::RenderPassDescriptor::default()
        });
        let plain = matches!(scene.view, ViewMode::Overdraw | ViewMode::Wire);
        if scene.setting.backdrop && !plain {
            pass.set_pipeline(&self.pipelines.backdrop);
            pass.set_bind_group(0, &ground, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    fn trees(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (targets, sunlit): (&Targets, &wgpu::BindGroup),
        view: ViewMode,
        drawn: &[Drawn<'_>],
        forest: Option<&Forest>,
    ) {
        let (target, resolve) = match &targets.samples {
            Some(samples) => (samples, Some(&targets.trees)),
            None => (&targets.trees, None),
        };
        let clear = match view {
            ViewMode::Overdraw | ViewMode::Wire => wgpu::Color::BLACK,
            _ => wgpu::Color::TRANSPARENT,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("trees"),
            color_attachments: &[Some(colour_attachment(target, resolve, clear))],
            depth_stencil_attachment: Some(depth_attachment(&targets.depth, 0.0)),
            ..wgpu::RenderPassDescriptor::default()
        });
        let (bark, foliage) = match view {
            ViewMode::Overdraw => (&self.pipelines.layers, &self.pipelines.layers),
            ViewMode::Wire => (&self.pipelines.wires, &self.pipelines.wires),
            _ => (&self.pipelines.bark, &self.pipelines.foliage),
        };
        pass.set_bind_group(0, sunlit, &[]);
        for tree in drawn {
            let edges = view == ViewMode::Wire;
            for (pipeline, part, material) in [
                (bark, &tree.lod.bark, &tree.model.bark),
                (foliage, &tree.lod.foliage, &tree.model.foliage),
            ] {
                pass.set_pipeline(pipeline);
                if edges {
                    tree.draw_edges(&mut pass, part.as_ref(), material);
                } else {
                    tree.draw(&mut pass, part.as_ref(), material);
                }
            }
        }
        if let Some(forest) = forest {
            self.draw_trees(&mut pass, forest, view);
        }
    }

    fn present(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        output: &wgpu::TextureView,
    ) {
        let pictures = group(
            &self.gpu.device,
            &self.pipelines.pictures,
            &[
                (0, wgpu::BindingResource::TextureView(&targets.trees)),
                (1, wgpu::BindingResource::TextureView(&targets.backdrop)),
                (2, wgpu::BindingResource::Sampler(&self.sampler)),
            ],
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(colour_attachment(
                output,
                None,
                wgpu::Color::TRANSPARENT,
            ))],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipelines.present);
        pass.set_bind_group(0, &self.cast_group, &[]);
        pass.set_bind_group(1, &pictures, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Scene {
    /// One tree at the origin.
    #[must_use]
    pub fn of_one(camera: super::camera::Camera, model: usize, lod: usize) -> Self {
        Self {
            camera,
            setting: Setting::default(),
            wind: CALM,
            time: 0.0,
            view: ViewMode::Lit,
            filter: Filter::None,
            groups: vec![Group {
                model,
                lod,
                trees: vec![Instance::at(Vec3::ZERO, 0.0, 1.0)],
            }],
        }
    }
}

/// Angle of view of a camera that is to show a tree as a photographer would, radians.
pub const PORTRAIT: f32 = 0.18 * PI;
