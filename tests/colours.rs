//! LODs are as light and as coloured as full detail, whatever they are made of.

mod common;

use common::scripts;
use pleach::asset::{AssetLod, TreeAsset};
use pleach::capture::{ALPHA_CUTOFF, Foliage, Occlusion, Textures, View, Visibility};
use pleach::image::{Image, Texel, mips};
use pleach::math::{Vec2, Vec3, float};
use pleach::measure::silhouette::seen_bounds;
use pleach::measure::views::{held_out_aerial, held_out_side};
use pleach::pipeline::{Settings, generate};
use pleach::report::Quiet;
use pleach::species::Beside;

const SUN: Vec3 = Vec3::new(3.1, 2.9, 2.55);
const SKY: Vec3 = Vec3::new(0.62, 0.74, 0.95);
const GROUND: Vec3 = Vec3::new(0.26, 0.24, 0.19);

/// Samples along the height of the tree.
const SAMPLES: f32 = 160.0;

/// A crown and the textures of all that is drawn.
struct Set<'a> {
    shade: Occlusion,
    textures: Textures<'a>,
    /// True to light it as a viewer that knows the textures alone.
    plain: bool,
}

impl Set<'_> {
    /// Linear light that comes from each sample of a LOD.
    fn light(&self, lod: &AssetLod, view: &View) -> Vec<Option<Vec3>> {
        let seen = Visibility::draw(&lod.mesh, self.textures, view);
        let sun = Vec3::new(0.75, 1.0, 0.45).normalize_or(Vec3::Y);
        let places = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
        let light = |(x, y)| {
            let seen = seen.surface(x, y, &lod.mesh, self.textures, view)?;
            let texel = seen.texel;
            let at = Vec2::new(float(x) + 0.5, float(y) + 0.5);
            let point = view.unproject(at, texel.depth);
            let [x, y, z] = texel.normal;
            let normal = view.right * x + view.up * y + view.toward() * z;
            let facing = normal.dot(sun);
            let lit = facing.max(0.0) + texel.translucency * (-facing).max(0.0);
            let known = seen.captured || self.plain;
            let open = if known { 1.0 } else { self.shade.open(point) };
            let around = GROUND.lerp(SKY, normal.y * 0.5 + 0.5) * (open * texel.occlusion);
            let sun = SUN * self.shade.transmittance(point, sun) * lit;
            Some(Vec3::from(texel.albedo) * (around + sun))
        };
        places.map(light).collect()
    }
}

fn opaque(mut bark: Image<Texel>) -> Image<Texel> {
    bark.texels_mut().iter_mut().for_each(|t| t.alpha = 1.0);
    bark
}

/// For each LOD its linear colour over full detail's, where both are seen, from held-out views.
fn colours(asset: &TreeAsset, plain: bool) -> Vec<Vec3> {
    let foliage = Foliage::of(asset.foliage.texels(), 5);
    let bark = mips::chain(opaque(asset.bark.texels()), 10, ALPHA_CUTOFF);
    let full = &asset.lods[0];
    let mut shade = Occlusion::of(&full.mesh);
    shade.refine(&full.mesh, 40);
    let set = Set {
        shade,
        textures: Textures {
            bark: &bark,
            foliage: &foliage,
            reliefs: &asset.reliefs,
        },
        plain,
    };
    let mut sums = vec![[Vec3::ZERO; 2]; asset.lods.len()];
    let views = held_out_side(16).into_iter().chain(held_out_aerial(8));
    for direction in views {
        let edge = full.mesh.bounds().size().y / SAMPLES;
        let view = direction.view(&seen_bounds(&full.mesh, &direction), edge);
        let reference = set.light(full, &view);
        for (lod, sums) in asset.lods.iter().zip(&mut sums) {
            let both = reference.iter().zip(set.light(lod, &view));
            for (full, seen) in both.filter_map(|(f, s)| Some(((*f)?, s?))) {
                sums[0] += seen;
                sums[1] += full;
            }
        }
    }
    sums.iter().map(|[seen, full]| *seen / *full).collect()
}

#[test]
fn every_lod_has_the_colour_of_full_detail() {
    for script in scripts() {
        let settings = Settings {
            full: true,
            budgets: Some(vec![10_640, 2000, 836, 248, 8]),
            ..Settings::default()
        };
        let asset = generate(
            &script.species,
            &settings,
            &Beside(script.folder.clone()),
            &Quiet,
        )
        .expect("a shipped script can be grown");
        assert!(asset.lods.len() >= 5, "{}", script.species.name);
        for tone in &asset.tones {
            assert!((0.2..=1.5).contains(&tone.shade), "{tone:?}");
            assert!(
                tone.tint.iter().all(|t| (0.75..=1.3).contains(t)),
                "{tone:?}"
            );
        }
        // A viewer that knows the textures alone sees geometry in the crown's mean shade; and two or four quads
        // show the same few pictures whatever the view, so that chance does not even out.
        for (plain, most, few) in [(false, 0.035, 0.06), (true, 0.06, 0.09)] {
            for (index, ratio) in colours(&asset, plain).into_iter().enumerate() {
                let most = if asset.lods[index].triangles.total() < 20 {
                    few
                } else {
                    most
                };
                let name = &script.species.name;
                eprintln!("{name}, LOD {index}, plain {plain}: {ratio:.3}");
                assert!(
                    (ratio - 1.0).abs().max_element() <= most,
                    "{name}, LOD {index}, plain {plain}: {ratio}"
                );
            }
        }
    }
}
