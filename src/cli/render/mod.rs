//! `pleach render`: pictures without a window.

mod animation;
mod painter;
#[cfg(feature = "gpu")]
mod wood;

use self::painter::{Brush, Shot};
use super::args::{self, Painter, Render, What};
use super::progress::Bar;
use super::{End, Failure};
use crate::asset::{Drawable, TreeAsset};
use crate::image::{Image, png};
use crate::pack::{self, PackContents, ReadError};
use crate::pipeline::{self, Settings};
use crate::preview::sheets;
use std::path::Path;

pub(crate) fn run(args: &Render) -> Result<End, Failure> {
    check(args)?;
    let trees: Result<Vec<Subject>, Failure> =
        args.paths.iter().map(|p| Subject::of(args, p)).collect();
    let trees = trees?;
    match args.what {
        What::Atlas => save(args, &sheets::on_white(trees[0].drawable().foliage))?,
        What::Rose => save(args, &sheets::rose(trees[0].drawable().shadows))?,
        What::Still | What::Strip | What::Sheet | What::Turntable | What::Sway => {
            draw(args, &trees, &mut painter::brush(args)?)?;
        }
        What::Forest => {
            let drawables: Vec<Drawable<'_>> = trees.iter().map(Subject::drawable).collect();
            save(args, &painter::brush(args)?.forest(&drawables, args)?)?;
        }
    }
    Ok(End::Done)
}

/// Faults of the command line that would otherwise be found after the work.
fn check(args: &Render) -> Result<(), Failure> {
    if args.paths.len() > 1 && !matches!(args.what, What::Sheet | What::Forest) {
        return Err(Failure::usage(format!(
            "{} trees were given; write one, or ask for a contact sheet or a wood with --what sheet or --what forest",
            args.paths.len()
        )));
    }
    let folder = match args.out.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Failure::usage(format!(
            "--out: there is no folder {}",
            folder.display()
        )));
    }
    if args.out.is_dir() {
        return Err(Failure::usage(format!(
            "--out: {} is a folder; write the name of a picture",
            args.out.display()
        )));
    }
    animation::check(args)?;
    if args.out.exists() && !args.force {
        return Err(Failure::usage(format!(
            "{} is there already; --force replaces it",
            args.out.display()
        )));
    }
    Ok(())
}

/// What is drawn: a tree just grown, or a pack.
enum Subject {
    Asset(Box<TreeAsset>),
    Pack(Box<PackContents>),
}

impl Subject {
    fn of(args: &Render, path: &Path) -> Result<Self, Failure> {
        if path.is_dir() {
            if args.seed.is_some() || args.budgets.is_some() || args.changes.any() {
                return Err(Failure::usage(format!(
                    "{} is a pack, which has its own seed and budgets; leave out --seed, --budgets, --variation and --set, or draw \
                     its script",
                    path.display()
                )));
            }
            let contents = pack::read(path).map_err(|error| match error {
                ReadError::Io { .. } => Failure::machine(error),
                _ => Failure::input(error),
            })?;
            return Ok(Self::Pack(Box::new(contents)));
        }
        let (full, budgets) = args::budgets(args.budgets.as_deref()).map_err(Failure::usage)?;
        let settings = Settings {
            seed: args.seed,
            full: full || args.lod.is_none(),
            budgets,
            ..Settings::default()
        };
        let script = super::read_script(path, &args.changes)?;
        let bar = Bar::alone(&script.species.name);
        let asset = pipeline::generate(&script.species, &settings, &script.files, &bar)
            .map_err(|error| super::generate::failure(path, &error))?;
        Ok(Self::Asset(Box::new(asset)))
    }

    fn drawable(&self) -> Drawable<'_> {
        match self {
            Self::Asset(asset) => asset.drawable(),
            Self::Pack(pack) => pack.drawable(),
        }
    }

    /// The LOD asked for, the finest without.
    fn lod(&self, args: &Render) -> Result<usize, Failure> {
        let (wanted, count) = (args.lod.unwrap_or(0), self.drawable().lods.len());
        if wanted < count {
            return Ok(wanted);
        }
        Err(Failure::usage(format!(
            "--lod {wanted}: the tree has LODs 0 to {}",
            count - 1
        )))
    }
}

fn draw(args: &Render, trees: &[Subject], brush: &mut Brush) -> Result<(), Failure> {
    let first = &trees[0];
    match args.what {
        What::Strip => {
            let lods = 0..first.drawable().lods.len();
            let pictures: Result<Vec<_>, Failure> = lods
                .map(|lod| brush.paint(&first.drawable(), &Shot::of(args, lod)))
                .collect();
            save(args, &rows(&pictures?, usize::MAX))
        }
        What::Sheet => {
            let pictures: Result<Vec<_>, Failure> = trees
                .iter()
                .map(|tree| {
                    let shot = Shot::of(args, tree.lod(args)?);
                    let picture = brush.paint(&tree.drawable(), &shot);
                    brush.forget();
                    picture
                })
                .collect();
            save(args, &rows(&pictures?, columns(trees.len())))
        }
        What::Turntable | What::Sway => {
            let lod = first.lod(args)?;
            let drawable = first.drawable();
            let mut frame = |index: u16| {
                let mut shot = Shot::of(args, lod);
                let part = f32::from(index) / f32::from(args.frames);
                shot.time += part * f32::from(animation::TURN_MS) * 1e-3;
                if args.what == What::Turntable {
                    shot.camera[0] += part * 360.0;
                }
                brush.paint(&drawable, &shot)
            };
            animation::write(args, &mut frame)
        }
        _ => {
            let shot = Shot::of(args, first.lod(args)?);
            save(args, &brush.paint(&first.drawable(), &shot)?)
        }
    }
}

/// Columns of a contact sheet: as wide as high, or a little wider.
fn columns(count: usize) -> usize {
    (1..=count).find(|c| c * c >= count).unwrap_or(1)
}

/// Pictures of one size, in rows.
fn rows(pictures: &[Image<[u8; 4]>], columns: usize) -> Image<[u8; 4]> {
    let (width, height) = (pictures[0].width(), pictures[0].height());
    let columns = columns.min(pictures.len());
    let (across, down) = (columns, pictures.len().div_ceil(columns));
    let size = |n: usize, edge: u32| u32::try_from(n).unwrap_or(1) * edge;
    let mut sheet = Image::filled(size(across, width), size(down, height), [0; 4]);
    for (index, picture) in pictures.iter().enumerate() {
        let (x0, y0) = (size(index % columns, width), size(index / columns, height));
        for y in 0..height {
            for x in 0..width {
                *sheet.at_mut(x0 + x, y0 + y) = *picture.at(x, y);
            }
        }
    }
    sheet
}

/// Writes a picture whole or not at all.
fn save(args: &Render, picture: &Image<[u8; 4]>) -> Result<(), Failure> {
    let bytes = png::encode(picture).map_err(Failure::input)?;
    super::write(&args.out, &bytes)
}

/// True if the GPU is asked for by name.
fn insists(args: &Render) -> bool {
    args.renderer == Painter::Gpu
}
