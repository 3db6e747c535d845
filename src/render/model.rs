//! Trees on the device: meshes, textures, baked shadows, and the volume that holds their light.

use super::hull::hull;
use super::part::Part;
use super::uniforms;
use crate::asset::{Drawable, Surface};
use crate::capture::Occlusion;
use crate::gpu::{Gpu, GpuError, upload};
use crate::image::Image;
use crate::math::{Bounds, Vec3, byte_from_unit, float, floor_to_u32, smoothstep};
use crate::mesh::Mesh;
use crate::mesh::card::Relief;
use crate::shadow::{self, ShadowMap};
use rayon::prelude::*;
use wgpu::util::DeviceExt as _;

/// A tree on the device.
#[derive(Clone, Debug)]
pub struct Model {
    /// LODs from the finest to the coarsest.
    pub lods: Vec<Lod>,
    /// What stands in for the finest LOD while something moves, from the finest to the coarsest; a sketch has some.
    pub stand_ins: Vec<Lod>,
    /// True if its finest LOD is itself one of those.
    pub is_rough: bool,
    /// Bounds of the finest LOD, metres: those of coarse ones reach out further.
    pub bounds: Bounds,
    /// The finest LOD's outermost points in directions all around, metres: what a camera is to show.
    pub hull: Vec<Vec3>,
    /// Height of the middle of a sphere about the trunk's axis that holds all LODs, and its radius, metres.
    pub(super) sphere: [f32; 2],
    /// Radius of the ground that its baked shadows cover, metres.
    pub(super) ground_reach: f32,
    uniform: uniforms::Model,
    pub(super) group: wgpu::BindGroup,
    pub(super) ground_group: wgpu::BindGroup,
    pub(super) bark: wgpu::BindGroup,
    pub(super) foliage: wgpu::BindGroup,
}

/// One LOD on the device.
#[derive(Clone, Debug)]
pub struct Lod {
    /// Part of the picture's height up to which it may be shown.
    pub screen_size: f32,
    /// Triangles of both materials.
    pub triangles: u64,
    /// How far a shadow map may shade it, 0..=1.
    pub crisp: f32,
    pub(super) bark: Option<Part>,
    pub(super) foliage: Option<Part>,
}

/// The textures of a model on the device.
#[derive(Clone, Debug)]
pub struct Textures {
    bark: wgpu::BindGroup,
    foliage: wgpu::BindGroup,
}

/// Layouts of the bind groups that models are bound by.
#[derive(Clone, Debug)]
pub(super) struct Layouts {
    pub(super) model: wgpu::BindGroupLayout,
    pub(super) ground: wgpu::BindGroupLayout,
    pub(super) material: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        use super::binding::{layout, sampler, texture, uniform};
        use wgpu::TextureViewDimension::{D2, D2Array, D3};
        Self {
            model: layout(
                device,
                "model",
                &[
                    (0, uniform()),
                    (1, sampler()),
                    (2, texture(D3)),
                    (3, texture(D3)),
                    (4, texture(D3)),
                ],
            ),
            ground: layout(
                device,
                "model on the ground",
                &[(0, uniform()), (1, sampler()), (5, texture(D2Array))],
            ),
            material: layout(
                device,
                "material",
                &[
                    (0, texture(D2)),
                    (1, texture(D2)),
                    (2, texture(D2)),
                    (3, texture(D2)),
                    (4, sampler()),
                ],
            ),
        }
    }
}

impl Model {
    /// Puts a tree on the device.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if a mesh or a texture is more than the adapter takes.
    pub(super) fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        source: &Drawable<'_>,
        (textures, cells): (Option<Textures>, u32),
    ) -> Result<Self, GpuError> {
        gpu.check_edge("a foliage atlas", source.foliage.albedo.width())?;
        gpu.check_edge("a bark texture", source.bark.albedo.width())?;
        let lods: Result<Vec<Lod>, GpuError> = source
            .lods
            .iter()
            .map(|&(mesh, screen_size)| Lod::new(gpu, (mesh, source.reliefs), screen_size))
            .collect();
        let bounds = source
            .lods
            .iter()
            .fold(Bounds::EMPTY, |all, (mesh, _)| all.union(&mesh.bounds()));
        let volume = Volume::of(shade(source), &bounds, cells);
        let finest = shade(source).bounds();
        let numbers = uniform(source, &volume);
        let uniform = on_device(gpu, &numbers);
        let smooth = sampler(gpu, wgpu::AddressMode::ClampToEdge);
        let [a, b, c] = volume.views(gpu);
        let view = wgpu::BindingResource::TextureView;
        let group = super::binding::group(
            &gpu.device,
            &layouts.model,
            &[
                (0, uniform.as_entire_binding()),
                (1, wgpu::BindingResource::Sampler(&smooth)),
                (2, view(&a)),
                (3, view(&b)),
                (4, view(&c)),
            ],
        );
        let ground_group = ground(gpu, layouts, &uniform, &source.shadows.maps);
        let repeat = sampler(gpu, wgpu::AddressMode::Repeat);
        let textures = textures.unwrap_or_else(|| Textures {
            bark: material(gpu, layouts, source.bark, &repeat),
            foliage: material(gpu, layouts, source.foliage, &smooth),
        });
        Ok(Self {
            lods: lods?,
            stand_ins: Vec::new(),
            is_rough: false,
            bounds: finest,
            hull: hull(shade(source)),
            sphere: sphere(source, &bounds),
            ground_reach: ground_reach(&source.shadows.maps),
            uniform: numbers,
            group,
            ground_group,
            bark: textures.bark,
            foliage: textures.foliage,
        })
    }

    /// The same tree with other baked shadows on the ground.
    pub(super) fn shaded(&self, gpu: &Gpu, layouts: &Layouts, maps: &[ShadowMap]) -> Self {
        let mut shaded = self.clone();
        shaded.uniform.shadow_rects = shadow_rects(maps);
        let uniform = on_device(gpu, &shaded.uniform);
        shaded.ground_group = ground(gpu, layouts, &uniform, maps);
        shaded.ground_reach = ground_reach(maps);
        shaded
    }

    /// The LOD with an index: what stands in for the finest one comes after the coarsest.
    pub(super) fn lod(&self, index: usize) -> Option<&Lod> {
        self.lods.iter().chain(&self.stand_ins).nth(index)
    }

    /// Its textures, for another model that has the same.
    #[must_use]
    pub fn textures(&self) -> Textures {
        Textures {
            bark: self.bark.clone(),
            foliage: self.foliage.clone(),
        }
    }
}

impl Lod {
    /// A mesh, and the captures that its quads show.
    pub(super) fn new(
        gpu: &Gpu,
        (mesh, reliefs): (&Mesh, &[Relief]),
        screen_size: f32,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            screen_size,
            triangles: mesh.triangles(),
            crisp: crisp(mesh),
            bark: Part::new(gpu, &mesh.bark, &[])?,
            foliage: Part::new(gpu, &mesh.foliage, reliefs)?,
        })
    }
}

/// How much larger than at rest a tree may be in the wind.
const WIND_ROOM: f32 = 1.1;

/// Height of the middle of a sphere about the trunk's axis that holds all LODs, and its radius.
fn sphere(source: &Drawable<'_>, bounds: &Bounds) -> [f32; 2] {
    let middle = bounds.centre().y;
    let centre = Vec3::new(0.0, middle, 0.0);
    let radius = source
        .lods
        .iter()
        .flat_map(|(mesh, _)| [&mesh.bark, &mesh.foliage])
        .flat_map(|p| &p.vertices)
        .map(|v| Vec3::from(v.position).distance(centre))
        .fold(0.0, f32::max);
    [middle, radius * WIND_ROOM]
}

/// Radius of the ground that baked shadows cover.
fn ground_reach(shadows: &[ShadowMap]) -> f32 {
    let corner = |map: &ShadowMap| {
        let [x0, z0, x1, z1] = map.ground_rect_m;
        libm::hypotf(x0.abs().max(x1.abs()), z0.abs().max(z1.abs()))
    };
    shadows.iter().map(corner).fold(0.0, f32::max)
}

/// How far a shadow map may shade a mesh: wholly where its cards are small against the tree, not at all where
/// a few quads stand for all of it and would cast their shadows on one another.
fn crisp(mesh: &Mesh) -> f32 {
    let vertices = &mesh.foliage.vertices;
    let corner = |i: u32| Vec3::from(vertices[i as usize].position);
    let (mut area, mut edges) = (0.0, 0.0);
    for &[a, b, c] in mesh.foliage.indices.as_chunks::<3>().0 {
        let [a, b, c] = [a, b, c].map(corner);
        let own = (b - a).cross(c - a).length();
        area += own;
        edges += own * own.sqrt();
    }
    if area == 0.0 {
        return 1.0;
    }
    let size = mesh.bounds().size().max_element();
    1.0 - smoothstep(0.12, 0.4, edges / area / size)
}

/// The mesh whose leaves shade one another: the finest.
fn shade<'a>(source: &Drawable<'a>) -> &'a Mesh {
    source.lods[0].0
}

fn uniform(source: &Drawable<'_>, volume: &Volume) -> uniforms::Model {
    let foliage = &shade(source).foliage.vertices;
    let crown = Bounds::of_points(foliage.iter().map(|v| Vec3::from(v.position)));
    let crown = if crown.is_empty() {
        shade(source).bounds()
    } else {
        crown
    };
    uniforms::Model {
        centre: crown
            .centre()
            .extend(crown.size().length() * 0.5)
            .to_array(),
        extent: (crown.size() * 0.5)
            .max(Vec3::splat(1e-3))
            .extend(0.0)
            .to_array(),
        volume_origin: volume.bounds.min.extend(0.0).to_array(),
        volume_scale: (1.0 / volume.bounds.size()).extend(0.0).to_array(),
        shadow_rects: shadow_rects(&source.shadows.maps),
        rig: source.wind,
    }
}

/// The ground that each shadow covers; the lit ground of a tree without shadows is anywhere.
fn shadow_rects(maps: &[ShadowMap]) -> [[f32; 4]; shadow::COUNT] {
    let mut rects = [[0.0, 0.0, 1.0, 1.0]; shadow::COUNT];
    for (rect, map) in rects.iter_mut().zip(maps) {
        *rect = map.ground_rect_m;
    }
    rects
}

fn on_device(gpu: &Gpu, numbers: &uniforms::Model) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM;
    upload(gpu, "model", bytemuck::bytes_of(numbers), usage)
}

/// What shades the ground.
fn ground(
    gpu: &Gpu,
    layouts: &Layouts,
    uniform: &wgpu::Buffer,
    maps: &[ShadowMap],
) -> wgpu::BindGroup {
    let smooth = sampler(gpu, wgpu::AddressMode::ClampToEdge);
    let shadows = shadow_view(gpu, maps);
    super::binding::group(
        &gpu.device,
        &layouts.ground,
        &[
            (0, uniform.as_entire_binding()),
            (1, wgpu::BindingResource::Sampler(&smooth)),
            (5, wgpu::BindingResource::TextureView(&shadows)),
        ],
    )
}

/// The light that reaches each cell of a tree's bounds: from all of the sky, and from each of the nine lights.
struct Volume {
    bounds: Bounds,
    size: [u32; 3],
    /// By cell: the sky, then the nine lights, then two that are not used.
    light: Vec<[u8; 12]>,
}

impl Volume {
    fn of(mesh: &Mesh, bounds: &Bounds, cells: u32) -> Self {
        let cell = (bounds.size().max_element() / float(cells)).max(1e-4);
        let bounds = Bounds {
            min: bounds.min - cell,
            max: bounds.max + cell,
        };
        let size = bounds
            .size()
            .to_array()
            .map(|edge| (floor_to_u32(edge / cell) + 1).min(2 * cells));
        let mut occlusion = Occlusion::of(mesh);
        occlusion.refine(mesh, cells);
        let step = bounds.size() / Vec3::from(size.map(float));
        let lights: [Vec3; shadow::COUNT] = core::array::from_fn(shadow::direction);
        let [nx, ny, nz] = size;
        let light = (0..nx * ny * nz)
            .into_par_iter()
            .map(|i| {
                let at = [i % nx, i / nx % ny, i / (nx * ny)].map(float);
                let point = bounds.min + (Vec3::from(at) + 0.5) * step;
                let mut cell = [0; 12];
                cell[0] = byte_from_unit(occlusion.open(point));
                for (byte, &light) in cell[1..].iter_mut().zip(&lights) {
                    *byte = byte_from_unit(occlusion.transmittance(point, light));
                }
                cell
            })
            .collect();
        Self {
            bounds,
            size,
            light,
        }
    }

    fn views(&self, gpu: &Gpu) -> [wgpu::TextureView; 3] {
        core::array::from_fn(|part| {
            let bytes: Vec<u8> = self
                .light
                .iter()
                .flat_map(|cell| &cell[part * 4..part * 4 + 4])
                .copied()
                .collect();
            let texture = gpu.device.create_texture_with_data(
                &gpu.queue,
                &wgpu::TextureDescriptor {
                    label: Some("light volume"),
                    size: wgpu::Extent3d {
                        width: self.size[0],
                        height: self.size[1],
                        depth_or_array_layers: self.size[2],
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D3,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING,
                    view_formats: &[],
                },
                wgpu::util::TextureDataOrder::LayerMajor,
                &bytes,
            );
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        })
    }
}

fn sampler(gpu: &Gpu, address: wgpu::AddressMode) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("surface"),
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: wgpu::AddressMode::ClampToEdge,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        anisotropy_clamp: if gpu.is_software() { 1 } else { 8 },
        ..wgpu::SamplerDescriptor::default()
    })
}

/// Four textures with the mips that other programs make of them.
fn material(
    gpu: &Gpu,
    layouts: &Layouts,
    surface: &Surface,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let levels = surface.albedo.width().max(1).ilog2() as usize;
    let chain = surface.mips(levels.clamp(1, 10));
    let wide = |[r, g, b]: &[u8; 3]| [*r, *g, *b, 255];
    let views = [
        image_view(gpu, &chain, true, |s| s.albedo.clone()),
        image_view(gpu, &chain, false, |s| s.normal.map(wide)),
        image_view(gpu, &chain, false, |s| s.orm.map(wide)),
        image_view(gpu, &chain, false, |s| s.extra.map(wide)),
    ];
    let [albedo, normal, orm, extra] = &views;
    let view = wgpu::BindingResource::TextureView;
    super::binding::group(
        &gpu.device,
        &layouts.material,
        &[
            (0, view(albedo)),
            (1, view(normal)),
            (2, view(orm)),
            (3, view(extra)),
            (4, wgpu::BindingResource::Sampler(sampler)),
        ],
    )
}

fn image_view(
    gpu: &Gpu,
    chain: &[Surface],
    is_colour: bool,
    part: impl Fn(&Surface) -> Image<[u8; 4]>,
) -> wgpu::TextureView {
    let images: Vec<Image<[u8; 4]>> = chain.iter().map(part).collect();
    let bytes: Vec<u8> = images
        .iter()
        .flat_map(|image| bytemuck::cast_slice(image.texels()))
        .copied()
        .collect();
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("surface"),
            size: extent(images[0].width(), images[0].height(), 1),
            mip_level_count: u32::try_from(images.len()).unwrap_or(1),
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: if is_colour {
                wgpu::TextureFormat::Rgba8UnormSrgb
            } else {
                wgpu::TextureFormat::Rgba8Unorm
            },
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &bytes,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The nine shadows as layers, without the code in their first texels.
fn shadow_view(gpu: &Gpu, shadows: &[ShadowMap]) -> wgpu::TextureView {
    let images: Vec<Image<u8>> = shadows.iter().map(ShadowMap::image_without_code).collect();
    let (width, height) = images
        .first()
        .map_or((1, 1), |image| (image.width(), image.height()));
    let mut bytes: Vec<u8> = images.iter().flat_map(Image::texels).copied().collect();
    bytes.resize(width as usize * height as usize * shadow::COUNT, 0);
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("baked shadows"),
            size: extent(width, height, u32::try_from(shadow::COUNT).unwrap_or(1)),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &bytes,
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

pub(super) fn extent(width: u32, height: u32, layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: layers,
    }
}
