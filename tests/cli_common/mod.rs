//! Runs the real program as a user would, and looks at what it leaves on the disk.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use sha2::{Digest as _, Sha256};

/// A tree small enough to be made in a fraction of a second: 36 nodes, three LODs.
pub(crate) const SAPLING: &str = r#"// A sapling.
(
    format: 1,
    name: "Sapling",
    latin: "Arbor minima",
    seed: 3,
    bark: Smooth(),
    splines: [(name: "stem", points: [(0, 0, 0), (0.05, 1, 0.02), (0, 2, 0.1)])],
    leaves: [(name: "leaf", length_m: 0.3, width_m: 0.15)],
    levels: [
        Branch(name: "trunk", length_m: 2.0, radius_m: 0.05, splines: ["stem"], sides: 6),
        Branch(
            name: "limbs", links: 5, start: 0.3, down: 50, length_of_parent: 0.4,
            radius_of_parent: 0.4, splines: ["stem"], sides: 4,
        ),
        Leaves(name: "leaves", links: 6, start: 0.2, down: (at: 50, vary: 10), kinds: ["leaf"]),
    ],
    lod: (budgets: [400, 60, 4]),
)
"#;

/// How a run of the program ended.
#[derive(Debug)]
pub(crate) struct Run {
    /// Exit code; `None` after a signal.
    pub(crate) code: Option<i32>,
    /// Standard output.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) err: String,
}

impl Run {
    /// Asserts the exit code and that standard error holds all of `words`.
    #[track_caller]
    pub(crate) fn ends(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "stderr:\n{}", self.err);
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in:\n{}", self.err);
        }
    }

    /// Standard output as JSON; nothing else may be there.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e} in:\n{}", self.out))
    }
}

/// The program with its streams piped.
pub(crate) fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pleach"));
    command
        .args(args)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Runs the program with arguments.
pub(crate) fn pleach(args: &[&str]) -> Run {
    let output = command(args).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Run {
        code: output.status.code(),
        out: text(output.stdout),
        err: text(output.stderr),
    }
}

/// Runs `generate` on a script with a small atlas.
pub(crate) fn generate(script: &Path, out: &Path, more: &[&str]) -> Run {
    let mut args = vec![
        "generate",
        utf8(script),
        "--out",
        utf8(out),
        "--texture-size",
        "256",
    ];
    args.extend(more);
    pleach(&args)
}

/// A folder with `sapling.ron` in it.
pub(crate) fn nursery() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("temporary folder");
    let script = dir.path().join("sapling.ron");
    fs::write(&script, SAPLING).expect("write the script");
    (dir, script)
}

/// A path as text.
pub(crate) fn utf8(path: &Path) -> &str {
    path.to_str().expect("UTF-8 path")
}

/// All files below a folder by relative path with `/`.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in fs::read_dir(folder).expect("folder").flatten() {
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                walk(&entry.path(), &format!("{name}/"), found);
            } else {
                found.insert(name, fs::read(entry.path()).expect("file"));
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(folder, "", &mut found);
    found
}

/// Names in a folder, hidden ones too; none if there is no such folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The manifest of a pack.
#[track_caller]
pub(crate) fn manifest(pack: &Path) -> Value {
    let text = fs::read(pack.join("pack.json")).expect("pack.json");
    serde_json::from_slice(&text).expect("JSON")
}

/// Checks a pack against its manifest: each file's size and hash, and no file beside them.
pub(crate) fn whole(pack: &Path) -> Result<(), String> {
    let mut found = files(pack);
    let text = found.remove("pack.json").ok_or("no pack.json")?;
    let manifest: Value = serde_json::from_slice(&text).map_err(|e| e.to_string())?;
    let listed = manifest["files"].as_array().ok_or("no files")?;
    for entry in listed {
        let path = entry["path"].as_str().ok_or("no path")?;
        let bytes = found.remove(path).ok_or(format!("{path} is missing"))?;
        let hash: String = Sha256::digest(&bytes)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        if entry["bytes"] != bytes.len() || entry["sha256"] != hash {
            return Err(format!("{path} is not what the manifest says"));
        }
    }
    if found.is_empty() {
        Ok(())
    } else {
        Err(format!("not listed: {:?}", found.keys()))
    }
}

/// Asserts that two folders hold the same files with the same bytes.
#[track_caller]
pub(crate) fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert_eq!(
        a.keys().collect::<Vec<_>>(),
        b.keys().collect::<Vec<_>>(),
        "other files"
    );
    for (path, bytes) in &a {
        assert!(*bytes == b[path], "{path} differs");
    }
}
