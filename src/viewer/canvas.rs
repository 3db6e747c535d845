//! A tree on the window's device, and the picture of it that the window shows.

use super::show::{Paintable, Showing};
use crate::gpu::{Gpu, GpuError};
use crate::image::Image;
use crate::math::{Vec3, float, round_to_u32};
use crate::render::forest::{Forest, ForestError, ForestTree};
use crate::render::{Maker, Model, Renderer, Scene};
use eframe::egui::Color32;
use eframe::egui_wgpu::RenderState;
use std::time::Instant;

/// What a window is shown: bytes that are encoded already.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A renderer on the window's device.
#[derive(Debug)]
pub(super) struct Canvas {
    renderer: Renderer,
    showing: Showing,
    /// By [`Side`].
    sheets: [Sheet; 2],
    /// A forest on the device, and the trees that it was made of.
    forest: Option<(Vec<ForestTree>, Forest)>,
}

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// What is to be seen.
    Main,
    /// What it is compared with.
    Finest,
}

/// A picture, and what it shows, so that nothing is drawn twice.
#[derive(Debug, Default)]
struct Sheet {
    picture: Option<Picture>,
    drawn: Option<(Scene, Woods, [u32; 2])>,
    /// True if a finer tree has come than the one that it shows; a picture that is wanted soon need not show it.
    is_rough: bool,
}

/// How the trees of a forest are to be drawn, and whether soon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Woods {
    /// Their LOD; by distance if `None`.
    pub(super) lod: Option<u32>,
    /// How much coarser than measured to be needed.
    pub(super) coarser: usize,
    /// Seconds that a switch of LODs takes.
    pub(super) fade: f32,
    /// Seconds since the frame before.
    pub(super) seconds: f32,
    /// True if the picture is wanted soon.
    pub(super) hurried: bool,
}

#[derive(Debug)]
struct Picture {
    view: wgpu::TextureView,
    paintable: Paintable,
    size: [u32; 2],
}

impl Woods {
    /// True if the same trees are drawn with the same LODs, not later but better.
    fn is_as(&self, other: &Self) -> bool {
        let is_as_good = other.hurried || !self.hurried;
        (self.lod, self.coarser) == (other.lod, other.coarser) && is_as_good
    }
}

impl Canvas {
    /// A canvas without a tree.
    ///
    /// # Errors
    /// What the driver says.
    pub(super) fn new(state: &RenderState) -> Result<Self, GpuError> {
        let info = state.adapter.get_info();
        let gpu = Gpu::from_parts(state.device.clone(), state.queue.clone(), info);
        Ok(Self {
            renderer: Renderer::new(&gpu, FORMAT)?,
            showing: Showing::new(state),
            sheets: [Sheet::default(), Sheet::default()],
            forest: None,
        })
    }

    /// Name and driver of the adapter.
    #[must_use]
    pub(super) fn describe(&self) -> String {
        self.renderer.gpu().describe()
    }

    /// What makes models for this canvas on other threads.
    pub(super) fn maker(&self) -> Maker {
        self.renderer.maker()
    }

    /// Shows this tree from now on. If it is what is shown, only finer, it is shown once there is time.
    pub(super) fn put(&mut self, model: Model, is_finer: bool) {
        self.renderer.put(0, model);
        if is_finer {
            self.sheets
                .iter_mut()
                .for_each(|sheet| sheet.is_rough = true);
            self.forest = None;
        } else {
            self.forget();
        }
    }

    /// A colour as the window is to be cleared with.
    pub(super) fn background(&self, colour: Color32) -> [f32; 4] {
        self.showing.background(colour)
    }

    /// True if a processor draws.
    pub(super) fn is_software(&self) -> bool {
        self.renderer.gpu().is_software()
    }

    /// How many LODs the tree has that is shown, and the triangles of what it is drawn with in a hurry.
    pub(super) fn finest(&self) -> Option<(usize, u64)> {
        let model = self.renderer.models().first()?;
        let lod = model.stand_ins.first().or(model.lods.first())?;
        Some((model.lods.len(), lod.triangles))
    }

    /// True if the tree that is shown stands in for a finer one.
    pub(super) fn is_rough(&self) -> bool {
        let model = self.renderer.models().first();
        model.is_some_and(|m| m.is_rough)
    }

    /// True if there is something to stand in for the tree.
    pub(super) fn is_sketch(&self) -> bool {
        let model = self.renderer.models().first();
        model.is_some_and(|m| !m.stand_ins.is_empty())
    }

    /// Everything is to be drawn anew.
    fn forget(&mut self) {
        for sheet in &mut self.sheets {
            sheet.drawn = None;
        }
        self.forest = None;
    }

    /// Gives the memory of a picture back that is not wanted any more.
    pub(super) fn let_go(&mut self, side: Side) {
        self.sheets[side as usize] = Sheet::default();
    }

    /// Outermost points of the tree, metres.
    #[must_use]
    pub(super) fn hull(&self) -> &[Vec3] {
        self.renderer.models().first().map_or(&[], |m| &m.hull)
    }

    /// The largest size in pixels, of the same shape, that the adapter allows; 0 only where there is no area.
    #[must_use]
    pub(super) fn fitting(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let limit = self.renderer.gpu().device.limits().max_texture_dimension_2d;
        let longest = width.max(height);
        if longest <= limit {
            return [width, height];
        }
        let shrunk = |edge: u32| match edge {
            0 => 0,
            _ => round_to_u32(float(edge) * (float(limit) / float(longest))).clamp(1, limit),
        };
        [shrunk(width), shrunk(height)]
    }

    /// Draws a scene, and the trees of a forest, into one of the pictures, unless that shows it already; says how
    /// many seconds it took.
    ///
    /// # Errors
    /// If the device fails, or the forest is too large for it.
    pub(super) fn draw(
        &mut self,
        side: Side,
        scene: &Scene,
        (trees, woods): (&[ForestTree], Woods),
        size: [u32; 2],
    ) -> Result<Option<f32>, ForestError> {
        let same = |(drawn, drawn_woods, drawn_size): &(Scene, Woods, [u32; 2])| {
            drawn == scene && *drawn_size == size && drawn_woods.is_as(&woods)
        };
        let planted = trees.is_empty() || self.forest.as_ref().is_some_and(|(t, _)| t == trees);
        let drawn = self.sheets[side as usize].drawn.as_ref();
        let is_good = !self.sheets[side as usize].is_rough || woods.hurried;
        if size.contains(&0) || planted && is_good && drawn.is_some_and(same) {
            return Ok(None);
        }
        let begun = Instant::now();
        let view = self.target(side, size);
        self.plant(trees, woods)?;
        self.renderer.hurry(woods.hurried);
        let encoder = match &mut self.forest {
            Some((_, forest)) => self.renderer.draw_forest(forest, scene, &view, size),
            None => self.renderer.draw(scene, &view, size),
        };
        self.renderer.gpu().queue.submit([encoder?.finish()]);
        // To be told how long it took, and so that no more than one frame waits to be drawn: the answer to a
        // drag would lag behind.
        self.renderer.gpu().finish()?;
        let sheet = &mut self.sheets[side as usize];
        (sheet.drawn, sheet.is_rough) = (Some((scene.clone(), woods, size)), false);
        Ok(Some(begun.elapsed().as_secs_f32()))
    }

    /// Trees of each LOD that the forest drawn last showed, and their triangles.
    pub(super) fn counts(&self) -> Option<(Vec<usize>, u64)> {
        let (_, forest) = self.forest.as_ref()?;
        let lists = forest.lists(self.renderer.gpu()).ok()?;
        let counts = forest.counts(&lists, self.renderer.models());
        Some((counts.by_lod, counts.triangles))
    }

    /// Puts a forest of these trees on the device, if another one is there.
    fn plant(&mut self, trees: &[ForestTree], woods: Woods) -> Result<(), ForestError> {
        if trees.is_empty() {
            self.forest = None;
            return Ok(());
        }
        if self.forest.as_ref().is_none_or(|(t, _)| t != trees) {
            let forest = self.renderer.forest(trees)?;
            self.forest = Some((trees.to_vec(), forest));
        }
        if let Some((_, forest)) = &mut self.forest {
            forest.settings.lod = woods.lod;
            forest.settings.detail = (0..woods.coarser).fold(1.0, |detail, _| detail * 0.5);
            forest.settings.fade_seconds = woods.fade;
            forest.settings.frame_seconds = woods.seconds;
        }
        Ok(())
    }

    /// What was drawn last.
    #[must_use]
    pub(super) fn picture(&self, side: Side) -> Option<&Paintable> {
        let sheet = &self.sheets[side as usize];
        sheet.drawn.as_ref()?;
        Some(&sheet.picture.as_ref()?.paintable)
    }

    /// A scene as a picture to keep.
    ///
    /// # Errors
    /// If the size is more than the adapter allows, or the device fails.
    pub(super) fn still(
        &mut self,
        scene: &Scene,
        (trees, woods): (&[ForestTree], Woods),
        size: [u32; 2],
    ) -> Result<Image<[u8; 4]>, ForestError> {
        self.plant(trees, woods)?;
        self.renderer.hurry(false);
        let picture = match &mut self.forest {
            Some((_, forest)) => self.renderer.picture_of_forest(forest, scene, size),
            None => self.renderer.picture(scene, size),
        };
        Ok(picture?)
    }

    /// What the driver told of anything done since the last call, also by the window itself.
    ///
    /// # Errors
    /// That.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        self.renderer.gpu().check()
    }

    /// Takes the device away.
    pub(super) fn destroy_device(&self) {
        self.renderer.gpu().device.destroy();
    }

    /// The picture, in this size.
    fn target(&mut self, side: Side, size: [u32; 2]) -> wgpu::TextureView {
        let sheet = &mut self.sheets[side as usize];
        if let Some(picture) = sheet.picture.as_ref().filter(|p| p.size == size) {
            return picture.view.clone();
        }
        let device = &self.renderer.gpu().device;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("view"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        sheet.picture = Some(Picture {
            view: view.clone(),
            paintable: self.showing.of(device, &view),
            size,
        });
        view
    }
}
