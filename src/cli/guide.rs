//! `pleach guide`.

use super::args::Guide;
use super::progress::Bar;
use super::{End, Failure};
use crate::guide::{self, Entry, Paint};
use crate::pipeline::{self, Settings};
use crate::survey::{self, SurveyError, reference};
use crate::tree::Limits;
use std::path::Path;

/// Folder of the plates, beside the page.
const PLATES: &str = "plates";

/// Quality of the plates, 1..=100.
const QUALITY: u8 = 82;

pub(crate) fn run(args: &Guide) -> Result<End, Failure> {
    super::use_threads(args.threads.map(usize::from))?;
    let folder = folder_of(&args.out)?;
    let plates = folder.join(PLATES);
    std::fs::create_dir_all(&plates)
        .map_err(|e| Failure::machine(format!("cannot make {}: {e}", plates.display())))?;
    let mut entries = Vec::new();
    for path in &args.species {
        if super::interrupted() {
            return Err(Failure::usage("interrupted"));
        }
        entries.push(entry(args, folder, path)?);
    }
    let command = format!(
        "pleach guide {} --out {}",
        match &args.species[..] {
            [one] => name_of(one),
            _ => "*.ron".to_owned(),
        },
        name_of(&args.out)
    );
    super::write(&args.out, guide::page(&entries, &command).as_bytes())?;
    Ok(End::Done)
}

fn folder_of(page: &Path) -> Result<&Path, Failure> {
    let folder = match page.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if page.is_dir() || !folder.is_dir() {
        return Err(Failure::usage(format!(
            "--out: {} cannot be written; expected the name of a page in a folder that is there",
            page.display()
        )));
    }
    Ok(folder)
}

/// Grows, measures and draws one species, and writes its plate.
fn entry(args: &Guide, folder: &Path, path: &Path) -> Result<Entry, Failure> {
    let script = super::read_script(path, &super::args::Changes::default())?;
    let species = &script.species;
    let bar = Bar::alone(&species.name);
    let settings = Settings {
        full: true,
        ..Settings::default()
    };
    let tree = pipeline::generate(species, &settings, &script.files, &bar)
        .map_err(|error| super::generate::failure(path, &error))?;
    let foliage = survey::foliage(species, &script.files).map_err(Failure::input)?;
    let seeds: Vec<u64> = (1..=u64::from(args.seeds)).collect();
    let trees =
        survey::survey(species, &foliage, &seeds, &Limits::default(), &bar).map_err(|error| {
            match error {
                SurveyError::Grow { .. } => Failure::input(format!("{}: {error}", path.display())),
                SurveyError::Cancelled(_) => Failure::machine(error),
            }
        })?;
    drop(bar);
    let reference = reference::of_latin(&species.latin);
    let lines = survey::lines(&trees, reference);
    let plate = format!("{PLATES}/{}.jpg", species.slug);
    super::write(&folder.join(&plate), &jpeg(&guide::plate(species, &tree))?)?;
    let known = (lines, args.seeds, reference.map_or("", |r| &r.sources));
    Ok(Entry::of(species, &tree, known, [&name_of(path), &plate]))
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

fn jpeg(picture: &Paint) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    ::image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(
            bytemuck::cast_slice(picture.texels()),
            picture.width(),
            picture.height(),
            ::image::ExtendedColorType::Rgb8,
        )
        .map_err(Failure::machine)?;
    Ok(bytes)
}
