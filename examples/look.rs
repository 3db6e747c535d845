//! Draws a species at each LOD beside each other: `cargo run --release --example look -- SPECIES.ron OUT.png`.

use pleach::preview;
use pleach::report::Quiet;
use pleach::{pipeline, species};

struct NoImages;
impl pipeline::ImageFiles for NoImages {
    fn read(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(path).map_err(|e| e.to_string())
    }
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).expect("script");
    let dir = std::path::Path::new(&args[1])
        .parent()
        .expect("dir")
        .to_owned();
    let mut species = match species::parse(&args[1], &text, &species::Beside(dir)) {
        Ok(s) => s,
        Err(e) => {
            eprintln!("{}", e.render(false));
            std::process::exit(1)
        }
    };
    if let Ok(v) = std::env::var("SEED") { species.seed = v.parse().unwrap(); }
    if std::env::var("SEEDS").is_ok() {
        let mut ps = Vec::new();
        for seed in 1..=12u64 {
            species.seed = seed;
            let st = pipeline::Settings { full: true, ..Default::default() };
            let asset = pipeline::generate(&species, &st, &NoImages, &Quiet).expect("asset");
            eprintln!("seed {seed} {:?}", asset.lods[0].mesh.bounds().size());
            ps.push(preview::side_by_side(&[preview::picture(&asset, &preview::Settings { size: [260, 400], elevation: 0.08, ..Default::default() }), preview::picture(&asset, &preview::Settings { size: [260, 400], azimuth: 2.2, elevation: 0.08, ..Default::default() })]));
        }
        let p = preview::side_by_side(&ps);
        std::fs::write(&args[2], pleach::image::png::encode(&p).unwrap()).unwrap();
        return;
    }
    let t = std::time::Instant::now();
    let settings = pipeline::Settings {
        full: args.len() > 3,
        ..Default::default()
    };
    let asset = pipeline::generate(&species, &settings, &NoImages, &Quiet).expect("asset");
    eprintln!("generate {:?} captures {}", t.elapsed(), asset.captures);
    for l in pleach::asset::level_summaries(&asset.tree) {
        eprintln!("{l:?}");
    }
    for l in &asset.lods {
        eprintln!(
            "{:?} {} {:?} err {} screen {} bounds {:?}",
            l.budget,
            l.state,
            l.triangles,
            l.error_m,
            l.screen_size,
            l.mesh.bounds().size()
        );
        pleach::mesh::check::mesh(&l.mesh).expect("mesh");
        assert_eq!(l.mesh.triangles(), l.triangles.total());
    }
    pleach::mesh::check::junctions(&asset.tree).expect("junctions");
    for w in &asset.warnings {
        eprintln!("warning: {w}");
    }
    let t = std::time::Instant::now();
    let p = preview::strip(&asset, &preview::Settings::default());
    eprintln!("strip {:?}", t.elapsed());
    std::fs::write(&args[2], pleach::image::png::encode(&p).unwrap()).unwrap();
    let views: Vec<_> = [0.6f32, 2.2].iter().map(|&a| preview::picture(&asset, &preview::Settings { size: if std::env::var("SIZE").is_ok() { [2400, 3000] } else { [900, 1100] }, azimuth: a, elevation: 0.08, ..Default::default() })).collect();
    std::fs::write(args[2].replace(".png", "_big.png"), pleach::image::png::encode(&preview::side_by_side(&views)).unwrap()).unwrap();
    let b = &asset.lods[0].mesh.bark.vertices;
    for h in [0.05f32, 0.5, 1.3] {
        let ring: Vec<_> = b.iter().filter(|v| (v.position[1] - h).abs() < 0.15 && v.position[0].hypot(v.position[2]) < 2.0).collect();
        let n = ring.len().max(1) as f32;
        let c = ring.iter().fold([0.0f32; 2], |a, v| [a[0] + v.position[0] / n, a[1] + v.position[2] / n]);
        let r = ring.iter().map(|v| (v.position[0] - c[0]).hypot(v.position[2] - c[1])).sum::<f32>() / n;
        eprintln!("at {h} m: {} verts, mean diameter {}", ring.len(), 2.0 * r);
    }
    eprintln!("foliage low {} bounds {:?}", asset.lods[0].mesh.foliage.vertices.iter().map(|v| v.position[1]).fold(f32::MAX, f32::min), asset.lods[0].mesh.bounds());
    std::fs::write(
        args[2].replace(".png","_atlas.png"),
        pleach::image::png::encode(&asset.foliage.albedo).unwrap(),
    )
    .unwrap();
    std::fs::write(
        "/tmp/shadow.png",
        pleach::image::png::encode(&asset.shadows.atlas().0).unwrap(),
    )
    .unwrap();
}
