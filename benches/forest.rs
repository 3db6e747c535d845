//! The choice of a forest's trees and LODs on a processor: the twin of `shaders/cull.wgsl`.
//!
//! Two models with chains of five LODs, seen from the middle of the wood over most of it, and from its rim over all
//! of it. The camera turns a little at each call, so that trees come, go and fade as in use.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use pleach::math::Vec3;
use pleach::render::forest::{Plan, Planting, Settings, Stature, Twin, View, plant};
use pleach::render::{Camera, Lens};

fn main() {
    divan::main();
}

fn stature(height: f32) -> Stature {
    let sizes = [1.0, 0.45, 0.2, 0.08, 0.03];
    Stature {
        sphere: [height * 0.5, height * 0.6],
        height,
        ground: height * 1.2,
        lods: sizes.map(|size| (size, size)).to_vec(),
    }
}

#[divan::bench(args = [5_929, 100_000, 1_000_000], consts = [0, 1])]
fn choose<const FROM_THE_RIM: usize>(bencher: Bencher, trees: u32) {
    let plan = Plan::of(&[stature(8.0), stature(14.0)]).expect("few LODs");
    let planting = Planting {
        trees,
        shares: vec![1.0, 1.0],
        ..Planting::default()
    };
    let trees = plant(&planting);
    let settings = Settings::default();
    let mut twin = Twin::new(trees.len());
    let mut turn = 0.0_f32;
    bencher
        .counter(ItemsCount::new(trees.len()))
        .bench_local(|| {
            turn += 0.01;
            let (sine, cosine) = libm::sincosf(if FROM_THE_RIM == 1 { turn * 0.1 } else { turn });
            let away = planting.half_edge_m() * FROM_THE_RIM as f32;
            let eye = Vec3::new(0.0, 20.0, -away);
            let camera = Camera {
                eye,
                target: eye + Vec3::new(sine, -0.05, cosine) * 100.0,
                lens: Lens::Perspective(1.0),
            };
            let cull = plan.frame(
                trees.len(),
                &View {
                    camera: &camera,
                    size: [1024, 768],
                    settings: &settings,
                    shade: [eye.x, eye.z, settings.shade_m],
                    stretch: 1.0,
                },
            );
            black_box(twin.choose(&plan, &trees, &cull).entries.len())
        });
}
