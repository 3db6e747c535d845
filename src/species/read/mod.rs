//! A species from the tree of its script, with every fault that the script has.

mod art;
mod bark;
mod leaves;
mod levels;
mod lod;
mod shape;
mod splines;

use super::decode::{Fields, Report, Value};
use super::fault::{Fault, Faults, Source};
use super::fields::{self, MAX_NAME, MAX_NAMED};
use super::files::Files;
use super::schema::{FORMAT, Habit, SUMMER, Species, Stems, Variation};
use super::syntax::{self, Kind, Node};

/// Largest script, bytes.
const MAX_BYTES: usize = 8 << 20;

/// Reads a species script.
///
/// `file_name` is used in reports only; files that the script names are asked of `files`.
///
/// # Errors
/// All faults of the script and of the spline files that it names, in order.
pub fn parse(file_name: &str, source: &str, files: &dyn Files) -> Result<Species, Faults> {
    let sources = vec![Source::new(file_name, source)];
    if source.len() > MAX_BYTES {
        let length = source.len();
        let message = format!("the script has {length} bytes; at most {MAX_BYTES} are read");
        return Err(Faults::new(sources, vec![Fault::new(0..0, "", message)]));
    }
    let (root, faults) = syntax::parse(source);
    let Some(root) = root else {
        return Err(Faults::new(sources, faults));
    };
    let mut reader = Reader {
        files,
        sources,
        out: Report::new(faults),
        named: Vec::new(),
    };
    let species = species(&mut reader, &root);
    let faults = reader.out.into_faults();
    match species {
        Some(species) if faults.is_empty() => Ok(species),
        _ => Err(Faults::new(reader.sources, faults)),
    }
}

/// What reading a script needs besides the script.
struct Reader<'f> {
    files: &'f dyn Files,
    sources: Vec<Source>,
    out: Report,
    /// Files that the script names.
    named: Vec<String>,
}

impl Reader<'_> {
    /// Items of a list of named things.
    fn named_items<'n>(&mut self, list: &Value<'n>, expected: &str) -> Vec<Value<'n>> {
        let items = list.items(&mut self.out, expected);
        if items.len() > MAX_NAMED {
            let found = items.len();
            let message = format!("the list has {found} items; at most {MAX_NAMED} are allowed");
            self.out.push(list.fault(message));
            return Vec::new();
        }
        items
    }

    /// Remembers a file that the script names.
    fn note(&mut self, path: &str) {
        if !self.named.iter().any(|known| known == path) {
            self.named.push(path.to_owned());
        }
    }

    /// The path of an image that must be there.
    fn image(&mut self, fields: &Fields<'_>, name: &'static str) -> String {
        let Some((path, value)) = fields.path(&mut self.out, name) else {
            return String::new();
        };
        if let Err(reason) = self.files.exists(&path) {
            self.out.push(value.fault(reason));
        }
        self.note(&path);
        path
    }
}

fn species(reader: &mut Reader<'_>, node: &Node) -> Option<Species> {
    let root = Fields::open_plain(&mut reader.out, Value::new(node, ""), &fields::SPECIES);
    if !matches!(node.kind, Kind::Struct { .. }) {
        return None;
    }
    if let Some(fault) = foreign_format(&root) {
        // The rest of a script in another language would only be reported as nonsense.
        reader.out = Report::new(vec![fault]);
        return None;
    }
    let out = &mut reader.out;
    root.whole64(out, "format");
    let name = root.name(out);
    let latin = root.text(out, "latin");
    let slug = slug(out, &root, &name);
    let seed = root.whole64(out, "seed");
    let age = root.number(out, "age");
    let habit = habit(out, &root).unwrap_or_default();
    let season = root.read(out, "season", |out, value, _| art::season(out, value));
    let season = season.unwrap_or(SUMMER);
    let variations = variations(out, &root);
    let stems = root.get("stems").map(|value| stems(out, value));
    let bark = bark::bark(reader, &root);
    let (splines, spline_names) = splines::splines(reader, &root);
    let (leaves, leaf_names) = leaves::leaves(reader, &root, season);
    let known = levels::Known {
        splines: &spline_names,
        leaves: &leaf_names,
    };
    let out = &mut reader.out;
    let levels = levels::levels(out, &root, &known);
    let lod = root.read(out, "lod", |out, value, _| {
        Some(lod::lod(out, value, &levels))
    });
    Some(Species {
        name,
        latin,
        slug,
        seed,
        age,
        habit,
        season,
        variations,
        stems,
        levels: levels.levels,
        splines,
        leaves,
        bark,
        lod: lod?,
        files: std::mem::take(&mut reader.named),
    })
}

/// A format other than ours, said in so many words. There is no older one to migrate from yet.
fn foreign_format(root: &Fields<'_>) -> Option<Fault> {
    let value = root.get("format")?;
    let Kind::Number(text) = &value.node.kind else {
        return None;
    };
    match text.parse::<u32>() {
        Ok(format) if format > FORMAT => {
            let message = format!(
                "this script is in format {format}; this version of pleach reads up to {FORMAT}"
            );
            Some(value.fault(message).help("use a newer version of pleach"))
        }
        Ok(0) => {
            let message = format!("there is no format 0; formats begin at 1, and {FORMAT} is read");
            Some(value.fault(message))
        }
        _ => None,
    }
}

/// What may name files.
const SLUG_HELP: &str = "a-z, 0-9 and `-` (not first or last), at most 100 characters";

fn is_slug_char(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'
}

fn is_slug(text: &str) -> bool {
    let ends = text.starts_with('-') || text.ends_with('-');
    !text.is_empty() && !ends && text.len() <= MAX_NAME && text.chars().all(is_slug_char)
}

/// The given slug, or one made from the name.
fn slug(out: &mut Report, root: &Fields<'_>, name: &str) -> String {
    if let Some(value) = root.get("slug") {
        let slug = root.text(out, "slug");
        if !is_slug(&slug) && matches!(value.node.kind, Kind::Text(_)) {
            let message = format!("`{slug}` cannot be a slug: it names files");
            let fault = value.fault(message);
            out.push(fault.help(SLUG_HELP));
        }
        return slug;
    }
    let mut slug = String::new();
    for c in name.to_lowercase().chars() {
        if is_slug_char(c) && c != '-' {
            slug.push(c);
        } else if !slug.is_empty() && !slug.ends_with('-') {
            slug.push('-');
        }
    }
    let slug = slug.trim_end_matches('-').to_owned();
    if slug.is_empty()
        && !name.trim().is_empty()
        && let Some(value) = root.get("name")
    {
        let fault = value.fault(format!("no file name can be made from `{name}`"));
        out.push(fault.help("give a `slug` of a-z, 0-9 and `-`"));
    }
    slug
}

fn habit(out: &mut Report, fields: &Fields<'_>) -> Option<Habit> {
    let name = fields.read(out, "habit", |out, value, _| {
        value.one_of(out, fields::HABITS)
    })?;
    Some(match name {
        "Forest" => Habit::Forest,
        _ => Habit::Open,
    })
}

/// Named variations; they become parts of file names.
fn variations(out: &mut Report, root: &Fields<'_>) -> Vec<Variation> {
    let mut found: Vec<Variation> = Vec::new();
    let Some(list) = root.get("variations") else {
        return found;
    };
    let items = list.items(out, "a list of variations");
    if items.len() > MAX_NAMED {
        let message = format!(
            "the list has {} items; at most {MAX_NAMED} are allowed",
            items.len()
        );
        out.push(list.fault(message));
        return found;
    }
    for item in items {
        let fields = Fields::open_plain(out, item, &fields::VARIATION);
        let name = fields.text(out, "name");
        if let Some(value) = fields.get("name") {
            if !is_slug(&name) && matches!(value.node.kind, Kind::Text(_)) {
                let fault = value.fault(format!(
                    "`{name}` cannot name a variation: it becomes part of file names"
                ));
                out.push(fault.help(SLUG_HELP));
            } else if found.iter().any(|known| known.name == name) {
                out.push(value.fault(format!("there is another variation named `{name}`")));
            }
        }
        found.push(Variation {
            name,
            seed: fields.whole64(out, "seed"),
            age: fields.has("age").then(|| fields.number(out, "age")),
            habit: habit(out, &fields),
            season: fields
                .get("season")
                .and_then(|value| art::season(out, &value)),
        });
    }
    found
}

fn stems(out: &mut Report, value: Value<'_>) -> Stems {
    let fields = Fields::open_plain(out, value, &fields::STEMS);
    Stems {
        count: fields.whole(out, "count"),
        spread_m: fields.number(out, "spread_m"),
        lean: fields.param(out, "lean"),
        scale: fields.param(out, "scale"),
    }
}

#[cfg(test)]
mod tests;
