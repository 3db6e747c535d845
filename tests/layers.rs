//! The order of modules: each uses only those before it. The list here is the documentation.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules in layers, the base first: a module may use those of the layers before its own. Those of
/// one layer know nothing of each other.
const LAYERS: &[(&str, &[&str])] = &[
    (
        "base: algebra, draws by key, warnings, whole files",
        &["math", "rng", "report", "disk"],
    ),
    ("where the wind takes what sways", &["wind"]),
    ("scripts and what they say", &["species"]),
    ("curves", &["spline"]),
    ("prototypes and links; pixels", &["tree", "image"]),
    (
        "procedural bark and leaves; geometry; states and budgets",
        &["texture", "mesh", "lod"],
    ),
    (
        "flat stand-ins: states to geometry; ground shadows",
        &["impostor", "shadow"],
    ),
    (
        "render to texture; the finished tree",
        &["capture", "asset"],
    ),
    (
        "pictures compared; the graphics adapter",
        &["measure", "gpu"],
    ),
    (
        "the list of stages; pictures, drawn by a processor or an adapter",
        &["pipeline", "preview", "render", "gpu_bake"],
    ),
    ("files", &["pack"]),
    ("LODs judged", &["evaluate"]),
    ("trees measured as in a forest", &["survey"]),
    ("a page of many species", &["guide"]),
    ("other programs' parameters", &["import"]),
    ("many trees", &["batch"]),
    ("a window on a tree", &["viewer"]),
    ("a window in which a species is made", &["studio"]),
    ("faces", &["cli"]),
    ("the program and the crate", &["main", "lib"]),
];

/// One use of a module by another.
#[derive(Debug)]
struct Use {
    from: String,
    to: String,
    place: String,
}

#[test]
fn a_module_uses_only_those_above_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&root, &mut files);
    files.sort();
    assert!(files.len() > 30, "only {} source files found", files.len());
    let mut faults = Vec::new();
    let mut uses = 0;
    for file in &files {
        let inside = file.strip_prefix(&root).expect("a file of src");
        let from = module_of(inside);
        if layer(&from).is_none() {
            faults.push(format!(
                "src/{}: module `{from}` has no place in the list of layers in tests/layers.rs",
                inside.display()
            ));
            continue;
        }
        let text = fs::read_to_string(file).expect("a source file can be read");
        for used in uses_in(&text, &from, &format!("src/{}", inside.display())) {
            uses += 1;
            faults.extend(fault(&used));
        }
    }
    assert!(uses > 100, "only {uses} uses found: the scan is broken");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_scan_sees_every_way_to_name_a_module() {
    let text = "use crate::mesh::Mesh;\nuse crate::{lod::State, math as m,\n    tree};\n\
                fn f() -> crate::image::Png {}\n// crate::pack in a comment\nuse pleach::asset::A;\n";
    let found: Vec<(String, String)> = uses_in(text, "mesh", "x.rs")
        .into_iter()
        .map(|u| (u.to, u.place))
        .collect();
    let expected = [
        ("lod", "x.rs:2"),
        ("math", "x.rs:2"),
        ("tree", "x.rs:2"),
        ("image", "x.rs:4"),
        ("asset", "x.rs:6"),
    ]
    .map(|(to, place)| (to.to_owned(), place.to_owned()));
    assert_eq!(found, expected, "a module's use of itself does not count");
    let planted = Use {
        from: "lod".to_owned(),
        to: "mesh".to_owned(),
        place: "src/lod/mod.rs:3".to_owned(),
    };
    let message = fault(&planted).expect("states know no geometry");
    assert!(
        message.contains("src/lod/mod.rs:3") && message.contains("math, rng, report"),
        "{message}"
    );
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src can be listed") {
        let path = entry.expect("an entry of src").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

/// The module at the top of the tree that a file belongs to.
fn module_of(inside: &Path) -> String {
    let first = inside.iter().next().expect("a file has a name");
    let first = first.to_string_lossy();
    first.strip_suffix(".rs").unwrap_or(&first).to_owned()
}

fn layer(module: &str) -> Option<usize> {
    LAYERS
        .iter()
        .position(|(_, modules)| modules.contains(&module))
}

fn fault(used: &Use) -> Option<String> {
    let from = layer(&used.from)?;
    if layer(&used.to).is_some_and(|to| to < from) {
        return None;
    }
    let allowed: Vec<&str> = LAYERS[..from]
        .iter()
        .flat_map(|(_, modules)| modules.iter().copied())
        .collect();
    Some(format!(
        "{}: `{}` must not use `{}`; it may use {}",
        used.place,
        used.from,
        used.to,
        if allowed.is_empty() {
            "nothing".to_owned()
        } else {
            allowed.join(", ")
        }
    ))
}

/// All modules of the crate that a text names, in order, without comments and without `from` itself.
fn uses_in(text: &str, from: &str, file: &str) -> Vec<Use> {
    let code: Vec<&str> = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect();
    let mut uses = Vec::new();
    for (number, line) in code.iter().enumerate() {
        for path in ["crate::", "pleach::"] {
            for (at, _) in line.match_indices(path) {
                let before = line[..at].chars().next_back();
                if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                    continue;
                }
                let rest = [&line[at + path.len()..], &code[number + 1..].join("\n")].join("\n");
                let place = format!("{file}:{}", number + 1);
                uses.extend(
                    names(&rest)
                        .into_iter()
                        .filter(|to| to != from)
                        .map(|to| Use {
                            from: from.to_owned(),
                            to,
                            place: place.clone(),
                        }),
                );
            }
        }
    }
    uses
}

/// The first name of a path, or those of a group in braces. Names of the crate's own items are modules
/// here: nothing else stands at its top.
fn names(path: &str) -> Vec<String> {
    let name = |text: &str| -> String {
        let text = text.trim_start();
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let mut names = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            ',' if depth == 0 => {
                names.push(name(&group[start..at]));
                start = at + 1;
            }
            '}' if depth == 0 => {
                names.push(name(&group[start..at]));
                break;
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    names.retain(|n| !n.is_empty());
    names
}
