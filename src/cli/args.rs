//! The arguments of every command.

use crate::batch::Shard;
use crate::pipeline::{Selection, Settings};
use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Grows trees from species scripts and flattens them into LOD packs under triangle budgets.
#[derive(Debug, Parser)]
#[command(name = "pleach", version, about, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Grow one tree and write its pack: LODs, textures, shadows, manifest.
    Generate(Generate),
    /// Make many trees from a job list.
    Batch(Batch),
    /// Report all faults of species scripts.
    Check(Check),
    /// Tell what a species script or a pack holds.
    Inspect(Inspect),
    /// Compare every LOD with the full tree, from views that nothing was fitted to.
    Evaluate(Evaluate),
    /// Measure trees as a forester would, beside what is known of real ones.
    Measure(Measure),
    /// Make a field guide: a page with a plate of pictures and the measures of each species.
    Guide(Guide),
    /// Turn another program's tree parameters into a species script.
    Import(Import),
    /// Draw a script's tree or a pack: a still, all LODs, a turntable, a contact sheet. Needs no window.
    Render(Render),
    /// Show a script's tree or a pack in a window; a script is grown again whenever it is saved.
    Preview(Preview),
    /// Make a species in a window: its parts, its script and its tree, side by side.
    Studio(Studio),
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Generate {
    /// Species script (RON).
    pub(crate) species: PathBuf,
    /// Seed; the script's own without.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) changes: Changes,
    /// Folder in which the pack's folder is made.
    #[arg(long, default_value = "packs")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) tree: Tree,
    #[command(flatten)]
    pub(crate) pack: Pack,
    /// Threads; all cores without. The pack's bytes do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print the manifest to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is changed in a script before its tree is grown; packs hold the changed script.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct Changes {
    /// Grow a named variation of the script; its name becomes part of the pack's.
    #[arg(long, value_name = "NAME")]
    pub(crate) variation: Option<String>,
    /// Set a field of the script: `age=0.4`, `habit=Forest`, `levels.trunk.length_m=3`. May be given again.
    #[arg(long, value_name = "FIELD=VALUE")]
    pub(crate) set: Vec<String>,
}

impl Changes {
    /// True if a pack, which holds a tree that is grown already, cannot do what is asked.
    pub(crate) fn any(&self) -> bool {
        self.variation.is_some() || !self.set.is_empty()
    }
}

/// What is made of a tree.
#[derive(Debug, ClapArgs)]
pub(crate) struct Tree {
    /// Triangle budgets, falling, one LOD each; `full` first for full detail: `full,10000,400,4`.
    #[arg(long, value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<String>>,
    #[command(flatten)]
    pub(crate) lods: Lods,
    /// Edge of the foliage atlas, texels: a power of two.
    #[arg(long, default_value_t = 1024)]
    pub(crate) texture_size: u32,
    /// What draws captures and shadows. `auto` is the CPU: its bytes are the same on every machine.
    #[arg(long, value_enum, default_value_t = Baker::Auto)]
    pub(crate) baker: Baker,
}

/// What draws captures and shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Baker {
    /// The CPU, without any driver: same script and seed, same bytes.
    Cpu,
    /// A graphics adapter or its software driver: same pack within a tolerance.
    Gpu,
    /// The CPU.
    Auto,
}

/// How LODs are made, whatever the script says.
#[derive(Clone, Copy, Debug, ClapArgs)]
pub(crate) struct Lods {
    /// How LODs are chosen under their budgets; as the script says without.
    #[arg(long, value_enum)]
    selector: Option<Selector>,
    /// Leave quads at their own size instead of scaling each LOD until it covers as much as full detail.
    #[arg(long)]
    no_calibrate: bool,
}

/// How LODs are chosen.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Selector {
    /// Node by node, unless level-wide steps look better.
    Cut,
    /// Level by level, as in the paper.
    Levels,
}

impl Lods {
    /// Puts what is asked for in the place of the script's word.
    pub(crate) fn apply(self, settings: &mut Settings) {
        settings.selection = self.selector.map(|selector| match selector {
            Selector::Cut => Selection::Cut,
            Selector::Levels => Selection::Levels,
        });
        settings.calibrate = self.no_calibrate.then_some(false);
    }
}

/// How packs are laid out.
#[derive(Clone, Copy, Debug, ClapArgs)]
pub(crate) struct Pack {
    /// Put the textures inside each GLB as well, so that it works as a single file.
    #[arg(long)]
    pub(crate) embed: bool,
    /// Add mips of the foliage atlas that keep the coverage of its alpha.
    #[arg(long)]
    pub(crate) mips: bool,
    /// Leave out how vertices sway in the wind.
    #[arg(long)]
    pub(crate) no_wind: bool,
    /// Replace packs that another version wrote.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Batch {
    /// Job list (RON).
    pub(crate) jobs: PathBuf,
    /// Folder in which the packs' folders are made.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Trees made at a time; as many as cores without.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Only a part of the list: I/N takes every N-th tree, beginning with the I-th.
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Leave alone packs that are whole already.
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) lods: Lods,
    #[command(flatten)]
    pub(crate) pack: Pack,
    /// Print what became of every tree to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Check {
    /// Species scripts.
    #[arg(required = true)]
    pub(crate) species: Vec<PathBuf>,
    /// Print the faults to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Inspect {
    /// Species script or pack folder.
    pub(crate) path: PathBuf,
    /// Seed, for a script; its own without.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) changes: Changes,
    /// Triangle budgets, for a script.
    #[arg(long, value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<String>>,
    #[command(flatten)]
    pub(crate) lods: Lods,
    /// Edge of the foliage atlas, texels, for a script: LODs are measured with the leaves that it shows.
    #[arg(long, default_value_t = 1024)]
    pub(crate) texture_size: u32,
    /// Print to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Evaluate {
    /// Species script or pack folder.
    #[arg(value_name = "SPECIES|PACK")]
    pub(crate) path: PathBuf,
    /// Seed, for a script; its own without.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) changes: Changes,
    /// Triangle budgets, for a script; `full` first to judge full detail too.
    #[arg(long, value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<String>>,
    /// Edge of the foliage atlas, texels, for a script: a power of two; 1024 without.
    #[arg(long)]
    pub(crate) texture_size: Option<u32>,
    /// Views from the side; half as many are added from above.
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) views: u16,
    /// Threads; all cores without. The figures do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Compare with mesh simplifiers too; leaves left out by chance always are.
    #[arg(long)]
    pub(crate) rivals: bool,
    /// Write a report with pictures, one HTML file.
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Exit with 1 if a LOD's covered area is off by more than this part (0.05 is 5 %) at the size at which it
    /// is shown, or if a LOD loses to a rival.
    #[arg(long, value_name = "PART")]
    pub(crate) fail_above: Option<f32>,
    /// Print all figures to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Measure {
    /// Species script (RON). What is known of real trees is found by its `latin` name.
    pub(crate) species: PathBuf,
    #[command(flatten)]
    pub(crate) changes: Changes,
    /// Trees to grow: seeds 1 to N.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub(crate) seeds: u16,
    /// Threads; all cores without. The figures do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print all figures, and each tree's, to stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Guide {
    /// Species scripts, in the order of the page; links expect them beside it.
    #[arg(required = true)]
    pub(crate) species: Vec<PathBuf>,
    /// Page to write (Markdown); plates go into a folder `plates` beside it.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Trees of each species to measure: seeds 1 to N.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub(crate) seeds: u16,
    /// Threads; all cores without. The guide does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Import {
    #[command(subcommand)]
    pub(crate) from: Source,
}

/// Whose parameters are turned into a script.
#[derive(Debug, Subcommand)]
pub(crate) enum Source {
    /// Weber and Penn's model (SIGGRAPH 95), in the XML form of the program Arbaro.
    WeberPenn(WeberPenn),
}

#[derive(Debug, ClapArgs)]
pub(crate) struct WeberPenn {
    /// Parameters: XML of the form `<arbaro><species name='...'><param name='...' value='...'/>`.
    pub(crate) file: PathBuf,
    /// Script to write; to stdout without.
    #[arg(long, value_name = "SPECIES.ron")]
    pub(crate) out: Option<PathBuf>,
    /// Replace a script that is there.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Render {
    /// Species scripts or pack folders; several for a contact sheet or a forest.
    #[arg(value_name = "SPECIES|PACK", required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Picture to write: PNG; for a turntable an animated PNG, GIF (`.gif`), or numbered PNGs (`turn-%d.png`).
    #[arg(long, short)]
    pub(crate) out: PathBuf,
    /// What to draw.
    #[arg(long, value_enum, default_value_t = What::Still)]
    pub(crate) what: What,
    /// Size of the picture, or of each tree's part of it, pixels; 800x900 without, 1280x720 for a forest.
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Trees of a forest.
    #[arg(long, default_value_t = 5_929, value_parser = clap::value_parser!(u32).range(1..=MOST_TREES))]
    pub(crate) trees: u32,
    /// Which LOD, 0 the finest; full detail without, for a script.
    #[arg(long)]
    pub(crate) lod: Option<usize>,
    /// Seed, for a script; its own without.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) changes: Changes,
    /// Triangle budgets, for a script.
    #[arg(long, value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<String>>,
    /// Where the camera stands: degrees about the tree and above the horizon; in a forest, where from the middle
    /// it stands and from how high up a hill it looks, 0 for a person's height.
    #[arg(long, default_value = "35,5", value_name = "TURN,HEIGHT", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) camera: [f32; 2],
    /// Where the sun stands: degrees about the tree and above the horizon.
    #[arg(long, default_value = "80,48", value_name = "TURN,HEIGHT", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) sun: [f32; 2],
    /// Wind: metres a second, and the degrees about the tree whither it blows (0 is +Z).
    #[arg(long, default_value = "0,90", value_name = "SPEED,TURN", value_parser = wind)]
    pub(crate) wind: [f32; 2],
    /// Time in the wind, seconds.
    #[arg(long, default_value_t = 0.0, value_parser = seconds)]
    pub(crate) time: f32,
    /// Pictures of a turntable or of trees in the wind.
    #[arg(long, default_value_t = 36, value_parser = clap::value_parser!(u16).range(2..=720))]
    pub(crate) frames: u16,
    /// Leave out sky and ground.
    #[arg(long)]
    pub(crate) transparent: bool,
    /// How light is worked out.
    #[arg(long, value_enum, default_value_t = Light::Product)]
    pub(crate) light: Light,
    /// What is shown of the trees.
    #[arg(long, value_enum, default_value_t = Show::Lit)]
    pub(crate) view: Show,
    /// How trees are blended with their backdrop.
    #[arg(long, value_enum, default_value_t = Blend::None)]
    pub(crate) filter: Blend,
    /// What draws: `auto` is the GPU (or its software driver) where there is one, else the CPU rasteriser.
    #[arg(long, value_enum, default_value_t = Painter::Auto)]
    pub(crate) renderer: Painter,
    /// Replace a picture that is there.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Preview {
    /// Species script or pack folder.
    #[arg(value_name = "SPECIES|PACK")]
    pub(crate) path: PathBuf,
    /// Seed, for a script; its own without.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Triangle budgets, for a script; without, full detail and the script's own.
    #[arg(long, value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<String>>,
    #[command(flatten)]
    pub(crate) lods: Lods,
    /// Edge of the foliage atlas, texels, for a script: a power of two.
    #[arg(long, default_value_t = 1024)]
    pub(crate) texture_size: u32,
    /// Size of the window, such as 1280x800.
    #[arg(long, default_value = "1280x800", value_parser = size)]
    pub(crate) size: [u32; 2],
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Studio {
    /// Species script; a small tree to begin with if left out.
    pub(crate) species: Option<PathBuf>,
    /// Folder in which packs are made; that of the last export without, or `packs`.
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// What draws captures and shadows while a tree is edited; what is exported is always the CPU's, the same bytes
    /// on every machine.
    #[arg(long, value_enum, default_value_t = SketchBaker::Auto)]
    pub(crate) baker: SketchBaker,
    /// Size of the window, such as 1280x720.
    #[arg(long, default_value = "1440x900", value_parser = size)]
    pub(crate) size: [u32; 2],
}

/// What draws captures and shadows while a tree is edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SketchBaker {
    /// The graphics card if there is one, else the CPU.
    Auto,
    /// The CPU.
    Cpu,
    /// A graphics adapter, be it a software driver.
    Gpu,
}

/// What `pleach render` draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum What {
    /// One LOD.
    Still,
    /// All LODs side by side, the finest on the left.
    Strip,
    /// One LOD from all around.
    Turntable,
    /// One LOD for four seconds in the wind.
    Sway,
    /// Each tree, side by side in rows.
    Sheet,
    /// The foliage atlas on white.
    Atlas,
    /// The nine baked shadows: the vertical light's in the middle, the others around it.
    Rose,
    /// A wood of all trees given; `--trees` says how many.
    Forest,
}

impl Render {
    /// Pixels of the picture, or of each tree's part of it.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(match self.what {
            What::Forest => [1280, 720],
            _ => [800, 900],
        })
    }
}

/// How light is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Light {
    /// Sun, sky and light through leaves, each with what stands in its way.
    Product,
    /// The sum of four factors of Candussi et al.
    FourFactors,
}

/// What is shown of the trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Show {
    /// The picture.
    Lit,
    /// A colour for each LOD.
    Lods,
    /// A colour for each level of branches and leaves; grey for a pack, whose files do not tell levels.
    Levels,
    /// Normals.
    Normals,
    /// Colour without light.
    Albedo,
    /// Layers over each pixel.
    Overdraw,
    /// Edges of triangles.
    Wire,
}

/// How trees are blended with their backdrop (Candussi et al.).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Blend {
    /// As drawn.
    None,
    /// Enlarged from a slightly smaller picture.
    Bilinear,
    /// Alpha is the mean of nine pixels'.
    Alpha,
    /// Both.
    Combined,
}

/// What draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Painter {
    /// The GPU if there is one.
    Auto,
    /// The GPU, or an error that says what to install.
    Gpu,
    /// The rasteriser that needs no driver.
    Cpu,
}

/// Most trees of a forest; as `render::forest` has it.
const MOST_TREES: i64 = 1 << 22;

/// Largest edge of a picture.
const LARGEST_PICTURE: u32 = 16_384;

/// Reads `800x900`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']);
    let numbers = parts.and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    match numbers {
        Some(size) if size.iter().all(|n| (1..=LARGEST_PICTURE).contains(n)) => Ok(size),
        _ => Err(format!(
            "expected pixels such as 800x900, each from 1 to {LARGEST_PICTURE}"
        )),
    }
}

/// Reads `35,5`.
fn angles(text: &str) -> Result<[f32; 2], String> {
    let parts = text.split_once(',');
    let numbers = parts.and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    match numbers {
        Some([turn, height]) if f32::is_finite(turn) && (-90.0..=90.0).contains(&height) => {
            Ok([turn, height])
        }
        _ => Err("expected degrees such as 35,5, the second from -90 to 90".to_owned()),
    }
}

/// Reads `8,90` or `8`.
fn wind(text: &str) -> Result<[f32; 2], String> {
    let (speed, turn) = text.split_once(',').unwrap_or((text, "90"));
    match (speed.trim().parse(), turn.trim().parse()) {
        (Ok(speed), Ok(turn)) if (0.0..=100.0).contains(&speed) && f32::is_finite(turn) => {
            Ok([speed, turn])
        }
        _ => Err("expected metres a second from 0 to 100 and degrees, such as 8,90".to_owned()),
    }
}

/// Reads seconds; waves lose their precision after some hours.
fn seconds(text: &str) -> Result<f32, String> {
    match text.trim().parse() {
        Ok(time) if (0.0..=10_000.0).contains(&time) => Ok(time),
        _ => Err("expected seconds from 0 to 10000".to_owned()),
    }
}

/// Budgets as asked for on a command line: whether full detail leads, and the numbers.
pub(crate) type Budgets = (bool, Option<Vec<u64>>);

/// Reads a list such as `full,10000,400,4`.
pub(crate) fn budgets(words: Option<&[String]>) -> Result<Budgets, String> {
    let Some(words) = words else {
        return Ok((false, None));
    };
    let mut full = false;
    let mut numbers = Vec::new();
    for (index, word) in words.iter().enumerate() {
        let word = word.trim();
        if word == "full" && index == 0 {
            full = true;
        } else {
            let number = word.parse().map_err(|_| {
                format!("`{word}` is no triangle budget; write whole numbers, with `full` first if wanted")
            })?;
            numbers.push(number);
        }
    }
    crate::batch::check_budgets(&numbers)?;
    Ok((full, Some(numbers)))
}

/// Largest edge of an atlas: 64 million texels.
const LARGEST_TEXTURE: u32 = 8192;

/// Smallest edge of an atlas that holds anything.
const SMALLEST_TEXTURE: u32 = 64;

/// Checks an atlas edge.
pub(crate) fn texture_size(size: u32) -> Result<u32, String> {
    if size.is_power_of_two() && (SMALLEST_TEXTURE..=LARGEST_TEXTURE).contains(&size) {
        return Ok(size);
    }
    let texels = u64::from(size) * u64::from(size);
    Err(format!(
        "a texture size of {size} would be an atlas of {texels} texels; write a power of two from \
         {SMALLEST_TEXTURE} to {LARGEST_TEXTURE} (at most {} texels)",
        u64::from(LARGEST_TEXTURE) * u64::from(LARGEST_TEXTURE)
    ))
}

impl Pack {
    pub(crate) fn options(self) -> crate::pack::Options {
        crate::pack::Options {
            embed: self.embed,
            mips: self.mips,
            no_wind: self.no_wind,
        }
    }

    pub(crate) fn replace(self) -> crate::pack::Replace {
        if self.force {
            crate::pack::Replace::AnyPack
        } else {
            crate::pack::Replace::OwnPacks
        }
    }
}
