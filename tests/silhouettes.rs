//! What each species looks like, as text and as a small picture. `UPDATE_GOLDENS=1 cargo test --test
//! silhouettes` writes what it finds to `tests/golden`, to be looked at before it is committed.

mod common;

use std::fs;
use std::path::PathBuf;

use common::{Script, scripts, stand_ins};
use pleach::capture::{Foliage, Textures, View, Visibility};
use pleach::image::{Image, Texel, png};
use pleach::lod::State;
use pleach::math::{Vec3, float, floor_to_u32};
use pleach::mesh::Flattener;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::Beside;
use pleach::{capture, preview, shadow};

/// Cells of a silhouette, across and down, and samples along each edge of a cell.
const CELLS: [u32; 2] = [48, 24];
const SAMPLES: u32 = 12;

/// Marks for cells from empty to covered.
const MARKS: &[u8] = b" .:+#";

/// Mean error of a picture's bytes that is taken for the same picture.
const MOST_ERROR: f64 = 2.0 / 255.0;

/// Largest picture that is kept, bytes.
const LARGEST_GOLDEN: usize = 16 << 10;

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name)
}

fn updating() -> bool {
    std::env::var_os("UPDATE_GOLDENS").is_some()
}

/// The full mesh of a tree from the front, leaf cards opaque, framed by its bounds.
fn silhouette(script: &Script) -> String {
    let tree = common::grown(&script.species, script.species.seed);
    let bark_height = script.species.bark.height_m();
    let form = stand_ins(&tree).form(
        &tree,
        &State::full(&tree),
        pleach::mesh::Coat::plain(bark_height),
    );
    let mesh = Flattener::new(&tree, &form).tree().expect("not too large");
    let bounds = mesh.bounds();
    let size = bounds.size();
    // Cells are twice as high as wide, as letters are.
    let half_height = (size.y * 0.5).max(size.x * 0.5 * 2.0 * float(CELLS[1]) / float(CELLS[0]));
    let view = View {
        centre: bounds.centre(),
        right: Vec3::X,
        up: Vec3::Y,
        half: [
            half_height * 0.5 * float(CELLS[0]) / float(CELLS[1]),
            half_height,
        ],
        width: CELLS[0] * SAMPLES,
        height: CELLS[1] * SAMPLES * 2,
    };
    let opaque = [Image::filled(
        1,
        1,
        Texel {
            alpha: 1.0,
            ..Texel::EMPTY
        },
    )];
    let textures = Textures {
        bark: &opaque,
        foliage: &Foliage::of(opaque[0].clone(), 1),
        reliefs: &[],
    };
    let seen = Visibility::draw(&mesh, textures, &view);
    let cell = |x: u32, y: u32| {
        let samples = (0..SAMPLES * 2).flat_map(|j| (0..SAMPLES).map(move |i| (i, j)));
        let covered = samples
            .filter(|&(i, j)| {
                let at = (x * SAMPLES + i, y * SAMPLES * 2 + j);
                seen.depth(at.0, at.1).is_some()
            })
            .count();
        let part = covered as f32 / float(SAMPLES * SAMPLES * 2);
        let mark = floor_to_u32((part * (MARKS.len() - 1) as f32).ceil());
        char::from(MARKS[mark as usize])
    };
    let mut text = format!(
        "{}: {:.2} m wide, {:.2} m high, {:.2} m deep\n",
        script.species.name, size.x, size.y, size.z
    );
    for y in 0..CELLS[1] {
        let row: String = (0..CELLS[0]).map(|x| cell(x, y)).collect();
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

#[test]
fn silhouettes_are_those_of_the_goldens() {
    let mut faults = Vec::new();
    for script in scripts() {
        let found = silhouette(&script);
        let path = golden(&format!("{}.txt", script.slug));
        if updating() {
            println!("{found}");
            fs::create_dir_all(golden("")).expect("a folder can be made");
            fs::write(&path, &found).expect("a golden can be written");
        }
        let expected = fs::read_to_string(&path).unwrap_or_default();
        if found != expected {
            faults.push(format!(
                "{}: expected\n{expected}\nfound\n{found}",
                path.display()
            ));
        }
    }
    assert!(
        faults.is_empty(),
        "{}\nif this is how they shall look: UPDATE_GOLDENS=1 cargo test --test silhouettes",
        faults.join("\n")
    );
}

#[test]
fn pictures_are_those_of_the_goldens() {
    let mut faults = Vec::new();
    for script in scripts() {
        let found = picture(&script);
        let path = golden(&format!("{}.png", script.slug));
        let new = path.with_extension("new.png");
        let bytes = small_png(&found);
        if updating() {
            assert!(bytes.len() <= LARGEST_GOLDEN, "{} bytes", bytes.len());
            fs::create_dir_all(golden("")).expect("a folder can be made");
            fs::write(&path, &bytes).expect("a golden can be written");
        }
        match fs::read(&path)
            .map_err(|error| error.to_string())
            .and_then(|golden| png::decode(&golden, 1 << 20))
        {
            Ok(golden) => {
                let error = mean_error(&found, &golden);
                if error > MOST_ERROR {
                    fs::write(&new, &bytes).expect("a picture can be written");
                    faults.push(format!(
                        "{}: mean error {error:.4}; see {}",
                        path.display(),
                        new.display()
                    ));
                } else {
                    // A picture of an earlier failure would mislead.
                    let _ = fs::remove_file(&new);
                }
            }
            Err(error) => {
                fs::write(&new, &bytes).expect("a picture can be written");
                faults.push(format!(
                    "{}: {error}; see {}",
                    path.display(),
                    new.display()
                ));
            }
        }
    }
    assert!(
        faults.is_empty(),
        "{}\nif this is how they shall look: UPDATE_GOLDENS=1 cargo test --test silhouettes",
        faults.join("\n")
    );
}

/// A PNG file as small as the encoder can make it: goldens stay in the repository for ever.
fn small_png(picture: &Image<[u8; 3]>) -> Vec<u8> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    use image::{ExtendedColorType, ImageEncoder as _};
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(
            bytemuck::cast_slice(picture.texels()),
            picture.width(),
            picture.height(),
            ExtendedColorType::Rgb8,
        )
        .expect("a picture can be encoded");
    bytes
}

/// A small picture of a species' first LOD.
fn picture(script: &Script) -> Image<[u8; 3]> {
    let settings = Settings {
        captures: capture::Settings {
            atlas_size: 512,
            ..capture::Settings::default()
        },
        bark_size: 128,
        shadows: shadow::Settings {
            size: 64,
            bands: 1,
            samples: 6,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    let images = Beside(script.folder.clone());
    let asset = pipeline::generate(&script.species, &settings, &images, &Quiet)
        .unwrap_or_else(|error| panic!("{}: {error}", script.slug));
    preview::picture(
        &asset.drawable(),
        &preview::Settings {
            size: [96, 120],
            ..preview::Settings::default()
        },
    )
}

/// Mean absolute difference of all channels, in parts of 255; all of it if the sizes differ.
fn mean_error(a: &Image<[u8; 3]>, b: &Image<[u8; 4]>) -> f64 {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return 1.0;
    }
    let sum: u64 = a
        .texels()
        .iter()
        .zip(b.texels())
        .flat_map(|(a, b)| (0..3).map(move |c| u64::from(a[c].abs_diff(b[c]))))
        .sum();
    sum as f64 / (a.texels().len() as f64 * 3.0 * 255.0)
}

#[test]
fn another_tree_is_told_from_the_golden_one() {
    let script = scripts().swap_remove(0);
    let mut other = scripts().swap_remove(0);
    other.species.seed += 1;
    assert_ne!(silhouette(&script), silhouette(&other));
    let golden = picture(&script).map(|&[r, g, b]| [r, g, b, 255]);
    let error = mean_error(&picture(&other), &golden);
    assert!(error > MOST_ERROR, "another seed differs by {error} only");
}
