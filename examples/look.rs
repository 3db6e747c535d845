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
    let species = match species::parse(&args[1], &text, &species::Beside(dir)) {
        Ok(s) => s,
        Err(e) => {
            eprintln!("{}", e.render(false));
            std::process::exit(1)
        }
    };
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
    std::fs::write(
        "/tmp/atlas.png",
        pleach::image::png::encode(&asset.foliage.albedo).unwrap(),
    )
    .unwrap();
    std::fs::write(
        "/tmp/shadow.png",
        pleach::image::png::encode(&asset.shadows.atlas().0).unwrap(),
    )
    .unwrap();
}
