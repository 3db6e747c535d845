//! What each panel looks like, in both themes, against pictures that were looked at.

use super::{Outcome, PATIENCE, Window, click, judged, on, until};
use crate::common::gpu::{mean_flip, root};
use eframe::egui::{Theme, pos2};
use egui_kittest::kittest::Queryable as _;
use pleach::image::{Image, png};
use pleach::studio::{Studio, templates};
use std::fs;
use std::time::{Duration, Instant};

/// Most bytes of a picture that is compared with.
const MOST_BYTES: u64 = 48 << 10;

/// Left, upper, right and lower edges of what is compared.
type Part = [u32; 4];

/// The parts on the left; the right column above the script, below its tabs' height; and the script.
const LEFT: Part = [10, 34, 190, 420];
const UPPER: Part = [858, 34, 1270, 438];
/// What of the view's panel does not tell how long frames take.
const ABOVE_TIMES: Part = [858, 34, 1270, 210];
const LOWER: Part = [858, 440, 1270, 710];

/// A panel: its name, how to come there, and where it is.
type Panel = (&'static str, fn(&mut Window) -> Outcome, Part);

const PANELS: &[Panel] = &[
    ("parts", |window| select(window, "limbs"), LEFT),
    ("level", |window| select(window, "limbs"), UPPER),
    ("spline", |window| select(window, "limb"), UPPER),
    ("leaf", |window| select(window, "shoot"), UPPER),
    ("seeds", seeds, UPPER),
    ("lods", lods, UPPER),
    ("atlas", |window| tab(window, "Atlas"), UPPER),
    ("shadows", |window| tab(window, "Shadows"), UPPER),
    ("view", |window| tab(window, "View"), ABOVE_TIMES),
    ("script", |window| select(window, "limbs"), LOWER),
];

pub(super) fn panels() -> Outcome {
    let mut window = on(templates::BLANK);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let mut unlike = Vec::new();
    for (theme, name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        window.ctx.set_theme(theme);
        for (panel, show, part) in PANELS {
            show(&mut window)?;
            // No part of it looks different under the mouse.
            window.hover_at(pos2(520.0, 80.0));
            window.run_steps(6);
            unlike.extend(compared(&mut window, &format!("{panel}-{name}"), *part)?);
        }
    }
    if unlike.is_empty() {
        return Ok(());
    }
    let unlike = unlike.join("\n");
    Err(format!("{unlike}\nif they are right, run again with UPDATE_GOLDENS=1").into())
}

/// Shows the page of a part.
fn select(window: &mut Window, part: &str) -> Outcome {
    tab(window, "Fields")?;
    click(window, part);
    Ok(())
}

fn tab(window: &mut Window, name: &str) -> Outcome {
    let tabs: Vec<_> = window.get_all_by_label(name).collect();
    let last = tabs.last().ok_or("no such tab")?;
    last.click();
    drop(tabs);
    window.run_steps(4);
    Ok(())
}

fn seeds(window: &mut Window) -> Outcome {
    tab(window, "Seeds")?;
    until(window, "sixteen trees", Studio::has_all_seeds)
}

/// The LODs with their figures and pictures.
fn lods(window: &mut Window) -> Outcome {
    tab(window, "LODs")?;
    judged(window)?;
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(2).min(PATIENCE) {
        std::thread::sleep(Duration::from_millis(50));
        window.step();
    }
    Ok(())
}

/// A picture of half the size, which tells as well whether anything has moved.
fn halved(picture: &Image<[u8; 4]>) -> Image<[u8; 4]> {
    let (width, height) = (picture.width() / 2, picture.height() / 2);
    let pixel = |x: u32, y: u32| {
        let four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| picture.at(2 * x + i, 2 * y + j));
        core::array::from_fn(|k| {
            let sum: u16 = four.iter().map(|p| u16::from(p[k])).sum();
            u8::try_from(sum / 4).unwrap_or(u8::MAX)
        })
    };
    let rows = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y)));
    Image::from_texels(width, height, rows.collect())
}

/// Says so if a part of the window is not as it was.
fn compared(
    window: &mut Window,
    name: &str,
    [left, top, right, bottom]: Part,
) -> Result<Option<String>, libtest_mimic::Failed> {
    let seen = window.render()?;
    let pixels = seen.pixels().map(|pixel| pixel.0).collect();
    let seen = Image::from_texels(seen.width(), seen.height(), pixels);
    let seen = halved(&seen.part(left, top, right - left, bottom - top));
    let path = root().join(format!("tests/golden/studio/{name}.png"));
    if std::env::var_os("UPDATE_GOLDENS").is_some() {
        fs::write(&path, png::encode(&seen).map_err(|e| e.to_string())?)?;
    }
    let bytes = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Ok(Some(format!("{name}: {} bytes", bytes.len())));
    }
    let error = mean_flip(&png::decode(&bytes, 1 << 20)?, &seen);
    if error <= 0.02 {
        return Ok(None);
    }
    let other = root().join(format!("target/studio-{name}.png"));
    fs::write(&other, png::encode(&seen).map_err(|e| e.to_string())?)?;
    let (other, path) = (other.display(), path.display());
    Ok(Some(format!(
        "{name}: mean FLIP {error:.4} from {path}; it is in {other}"
    )))
}
