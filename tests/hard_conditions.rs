//! What is left on the disk when the disk, the user or the system gets in the way.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "in a test, a panic is the report")]

mod cli_common;

use cli_common::{assert_same, command, files, generate, manifest, names, nursery, utf8, whole};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime};

const PACK: &str = "sapling-3";

/// A disk of its own, gone when dropped.
struct Disk(PathBuf);

impl Disk {
    /// Mounts an empty disk with the given options; `None`, with the reason printed, where that is not
    /// allowed.
    fn mount(at: &Path, options: &str) -> Option<Self> {
        fs::create_dir_all(at).unwrap();
        let output = Command::new("mount")
            .args(["-t", "tmpfs", "-o", options, "tmpfs", utf8(at)])
            .output();
        let reason = match output {
            Ok(output) if output.status.success() => return Some(Self(at.to_owned())),
            Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
            Err(error) => error.to_string(),
        };
        eprintln!("skipped: no disk can be mounted here: {}", reason.trim());
        None
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

/// Sends a signal to a process of ours.
fn signal(id: u32, signal: &str) {
    let sent = Command::new("kill")
        .args([signal, &id.to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// The temporary folders in `out`.
fn leftovers(out: &Path) -> Vec<String> {
    let mut names = names(out);
    names.retain(|name| name.ends_with(".tmp"));
    names
}

#[test]
fn a_full_disk_is_the_machines_fault_and_leaves_nothing() {
    let (dir, script) = nursery();
    let at = dir.path().join("disk");
    let Some(_disk) = Disk::mount(&at, "size=256k") else {
        return;
    };
    let run = generate(&script, &at, &[]);
    run.ends(75, &[utf8(&at), "cannot write", "free some space", "--out"]);
    assert_eq!(names(&at), [""; 0]);
    // A pack that was there stays as it was.
    fs::create_dir(at.join(PACK)).unwrap();
    let text = r#"{ "format": "pleach-pack", "version": 1 }"#;
    fs::write(at.join(PACK).join("pack.json"), text).unwrap();
    generate(&script, &at, &[]).ends(75, &[]);
    assert_eq!(names(&at), [PACK]);
    assert_eq!(files(&at.join(PACK)).len(), 1);
    let jobs = dir.path().join("jobs.ron");
    fs::write(
        &jobs,
        r#"(format: 1, texture_size: 256, jobs: [(species: "sapling.ron", seeds: Range(1, 2))])"#,
    )
    .unwrap();
    let run = cli_common::pleach(&["batch", utf8(&jobs), "--out", utf8(&at), "--json"]);
    run.ends(
        75,
        &["free some space", "0 made, 0 there already, 2 failed"],
    );
    assert!(
        run.json()
            .as_array()
            .unwrap()
            .iter()
            .all(|i| i["machine"] == true)
    );
    assert_eq!(names(&at), [PACK]);
}

#[test]
fn a_read_only_disk_is_the_machines_fault() {
    let (dir, script) = nursery();
    let at = dir.path().join("disk");
    let Some(_disk) = Disk::mount(&at, "ro") else {
        return;
    };
    for out in [at.clone(), at.join("packs")] {
        generate(&script, &out, &[]).ends(75, &[utf8(&out), "cannot write", "may write", "--out"]);
    }
    assert_eq!(names(&at), [""; 0]);
}

#[test]
fn a_file_where_the_folder_should_be_is_refused_before_any_work() {
    let (dir, script) = nursery();
    let file = dir.path().join("file");
    fs::write(&file, "mine").unwrap();
    for out in [file.clone(), file.join("packs/deep")] {
        let words = [utf8(&file), "is no folder", "choose another --out"];
        generate(&script, &out, &[]).ends(1, &words);
    }
    assert_eq!(fs::read(&file).unwrap(), b"mine");
}

#[test]
fn what_is_no_pack_is_never_replaced() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let place = out.join(PACK);
    fs::create_dir_all(&place).unwrap();
    let contents: [&[(&str, &str)]; 4] = [
        &[("thesis.txt", "years of work")],
        &[("pack.json", "{"), ("a", "b")],
        &[("pack.json", r#"{ "format": "other" }"#)],
        &[],
    ];
    for content in contents {
        for (name, text) in content {
            fs::write(place.join(name), text).unwrap();
        }
        for more in [&[][..], &["--force"]] {
            let words = [utf8(&place), "is in the way and is no pack", "--out"];
            generate(&script, &out, more).ends(1, &words);
        }
        let left = files(&place);
        assert_eq!(left.len(), content.len());
        for (name, text) in content {
            assert_eq!(left[*name], text.as_bytes());
            fs::remove_file(place.join(name)).unwrap();
        }
    }
    fs::remove_dir(&place).unwrap();
    fs::write(&place, "a file").unwrap();
    generate(&script, &out, &["--force"]).ends(1, &["is in the way"]);
    assert_eq!(fs::read(&place).unwrap(), b"a file");
    assert_eq!(names(&out), [PACK]);
}

#[test]
fn a_pack_of_another_version_is_replaced_only_by_force() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    generate(&script, &out, &[]).ends(0, &[]);
    let place = out.join(PACK);
    let made = files(&place);
    let mut other = manifest(&place);
    other["version"] = 99.into();
    fs::write(place.join("pack.json"), other.to_string()).unwrap();
    let before = files(&place);
    let words = [utf8(&place), "version 99", "writes version 1", "--force"];
    generate(&script, &out, &[]).ends(1, &words);
    assert!(files(&place) == before, "untouched");
    cli_common::pleach(&["inspect", utf8(&place)]).ends(1, &["version 99", "reads 1"]);
    generate(&script, &out, &["--force"]).ends(0, &[]);
    assert!(files(&place) == made, "as if nothing had been there");
    assert_eq!(names(&out), [PACK]);
}

#[test]
fn a_pack_is_replaced_whole() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    generate(&script, &out, &["--mips", "--budgets", "full,400,60,10,4"]).ends(0, &[]);
    let place = out.join(PACK);
    fs::write(place.join("stale.txt"), "of before").unwrap();
    fs::write(place.join("textures/stale.png"), "of before").unwrap();
    generate(&script, &out, &[]).ends(0, &[]);
    assert_eq!(whole(&place), Ok(()));
    let fresh = dir.path().join("fresh");
    generate(&script, &fresh, &[]).ends(0, &[]);
    assert_same(&place, &fresh.join(PACK));
    assert_eq!(names(&out), [PACK]);
}

#[test]
fn a_pack_is_as_readable_as_the_user_lets_new_folders_be() {
    use std::os::unix::fs::PermissionsExt as _;
    let (dir, script) = nursery();
    for (umask, folder, file) in [("022", 0o755, 0o644), ("027", 0o750, 0o640)] {
        let out = dir.path().join(umask);
        let program = env!("CARGO_BIN_EXE_pleach");
        let line = format!(
            "umask {umask} && exec '{program}' generate '{}' --out '{}' --texture-size 256",
            utf8(&script),
            utf8(&out)
        );
        let status = Command::new("sh")
            .args(["-c", &line])
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        let mode = |path: &str| {
            let path = out.join(PACK).join(path);
            fs::metadata(path).unwrap().permissions().mode() & 0o777
        };
        assert_eq!(
            (mode("."), mode("textures"), mode("pack.json")),
            (folder, folder, file)
        );
    }
}

/// Waits until `out` holds a temporary folder; false if the program ended before.
fn writing(out: &Path, child: &mut std::process::Child) -> bool {
    while leftovers(out).is_empty() {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    true
}

#[test]
fn a_kill_in_the_middle_of_writing_leaves_a_whole_pack_or_none() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let args = [
        "generate",
        utf8(&script),
        "--out",
        utf8(&out),
        "--texture-size",
        "256",
    ];
    let mut torn = 0;
    for round in 0..10_u64 {
        let mut child = command(&args).spawn().unwrap();
        // Every other round replaces a pack.
        if writing(&out, &mut child) {
            std::thread::sleep(Duration::from_micros(round * round * 120));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        torn += usize::from(!leftovers(&out).is_empty());
        let place = out.join(PACK);
        if place.exists() {
            assert_eq!(whole(&place), Ok(()), "round {round}");
            if round % 2 == 0 {
                fs::remove_dir_all(&place).unwrap();
            }
        }
        // What this round left must not hide the next round's folder.
        for (index, name) in leftovers(&out).into_iter().enumerate() {
            let aside = dir.path().join(format!("left-{round}-{index}"));
            fs::rename(out.join(name), aside).unwrap();
        }
    }
    assert!(torn > 0, "no round was quick enough");
    for entry in names(dir.path()).iter().filter(|n| n.starts_with("left-")) {
        let back = out.join(format!(".{PACK}.{entry}.tmp"));
        fs::rename(dir.path().join(entry), back).unwrap();
    }
    generate(&script, &out, &[]).ends(0, &[]);
    assert_eq!(whole(&out.join(PACK)), Ok(()));
}

/// Makes a folder look as if nothing had touched it for an hour.
fn age(folder: &Path) {
    let hour_ago = SystemTime::now() - Duration::from_secs(3600);
    fs::File::open(folder)
        .unwrap()
        .set_modified(hour_ago)
        .unwrap();
}

#[test]
fn leftovers_of_killed_runs_are_swept_and_those_of_living_ones_are_not() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let folder = |name: &str| {
        let folder = out.join(name);
        fs::create_dir_all(folder.join("textures")).unwrap();
        fs::write(folder.join("textures/half.png"), "half").unwrap();
        age(&folder);
        folder
    };
    folder(".sapling-3.dead01.tmp");
    folder(".sapling-3.dead02.old.tmp");
    let other = folder(".sapling-33.other1.tmp");
    let young = folder(".sapling-3.young1.tmp");
    fs::File::open(&young)
        .unwrap()
        .set_modified(SystemTime::now())
        .unwrap();
    let living = folder(".sapling-3.alive1.tmp");
    let lock = fs::File::open(&living).unwrap();
    if lock.try_lock().is_err() {
        eprintln!("skipped: folders cannot be locked here");
        return;
    }
    generate(&script, &out, &[]).ends(0, &[]);
    let mut left: Vec<PathBuf> = vec![other, living, young, out.join(PACK)];
    left.sort();
    let found: Vec<PathBuf> = names(&out).iter().map(|n| out.join(n)).collect();
    assert_eq!(found, left);
    // A batch sweeps for all of its packs.
    drop(lock);
    let jobs = dir.path().join("jobs.ron");
    let text =
        r#"(format: 1, texture_size: 256, jobs: [(species: "sapling.ron", seeds: List([3, 33]))])"#;
    fs::write(&jobs, text).unwrap();
    age(&out.join(".sapling-3.alive1.tmp"));
    cli_common::pleach(&["batch", utf8(&jobs), "--out", utf8(&out)]).ends(0, &[]);
    assert_eq!(names(&out), [".sapling-3.young1.tmp", PACK, "sapling-33"]);
}

#[test]
fn a_pack_that_a_kill_caught_on_its_way_out_comes_back() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    generate(&script, &out, &["--budgets", "400,4"]).ends(0, &[]);
    let aside = out.join(".sapling-3.dead01.old.tmp");
    fs::create_dir(&aside).unwrap();
    fs::rename(out.join(PACK), aside.join("pack")).unwrap();
    age(&aside);
    // The run fails after the sweep: the old pack is there all the same.
    let (text, leaf) = (
        fs::read_to_string(&script).unwrap(),
        dir.path().join("leaf.png"),
    );
    fs::write(&leaf, "no image").unwrap();
    let text = text.replace("width_m: 0.15", "width_m: 0.15, image: \"leaf.png\"");
    fs::write(&script, text).unwrap();
    generate(&script, &out, &[]).ends(1, &["leaf.png"]);
    assert_eq!(whole(&out.join(PACK)), Ok(()));
    assert_eq!(names(&out), [PACK]);
}

/// Waits until a process has its handler of SIGTERM, or for a while where the system does not tell.
fn catches_signals(id: u32) {
    let caught = || -> Option<bool> {
        let status = fs::read_to_string(format!("/proc/{id}/status")).ok()?;
        let mask = status.lines().find_map(|l| l.strip_prefix("SigCgt:"))?;
        let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
        Some(mask >> 14 & 1 == 1)
    };
    for _ in 0..1000 {
        match caught() {
            Some(true) => return,
            Some(false) => std::thread::sleep(Duration::from_millis(5)),
            None => return std::thread::sleep(Duration::from_millis(400)),
        }
    }
}

#[test]
fn interrupting_ends_with_130_and_leaves_nothing() {
    let (dir, _) = nursery();
    let olive = Path::new(env!("CARGO_MANIFEST_DIR")).join("species/olive.ron");
    for name in ["-INT", "-TERM"] {
        let out = dir.path().join(format!("packs{name}"));
        let args = ["generate", utf8(&olive), "--out", utf8(&out)];
        let child = command(&args).spawn().unwrap();
        catches_signals(child.id());
        // Into the middle of the work.
        std::thread::sleep(Duration::from_millis(200));
        let begun = Instant::now();
        signal(child.id(), name);
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{name}: {err}");
        assert!(
            err.contains("interrupted; nothing half-written is left"),
            "{err}"
        );
        assert!(output.stdout.is_empty());
        assert!(begun.elapsed() < Duration::from_secs(10), "slow to give up");
        assert!(!out.exists());
    }
}

#[test]
fn an_interrupted_batch_keeps_what_is_made_and_resumes() {
    let (dir, _) = nursery();
    let out = dir.path().join("packs");
    let jobs = dir.path().join("jobs.ron");
    let list =
        r#"(format: 1, texture_size: 256, jobs: [(species: "sapling.ron", seeds: Range(1, 8))])"#;
    fs::write(&jobs, list).unwrap();
    let args = [
        "batch",
        utf8(&jobs),
        "--out",
        utf8(&out),
        "--threads",
        "1",
        "--json",
        "--resume",
    ];
    let child = command(&args).spawn().unwrap();
    let begun = Instant::now();
    while !names(&out).iter().any(|name| name.starts_with("sapling")) {
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "nothing was made"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    signal(child.id(), "-TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let with = |told: &serde_json::Value, status: &str| -> Vec<String> {
        let items = told
            .as_array()
            .unwrap()
            .iter()
            .filter(|i| i["status"] == status);
        items
            .map(|i| i["pack"].as_str().unwrap().to_owned())
            .collect()
    };
    let made = with(&told, "made");
    assert!(!made.is_empty() && !with(&told, "cancelled").is_empty());
    assert_eq!(names(&out), made);
    for pack in &made {
        assert_eq!(whole(&out.join(pack)), Ok(()));
    }
    let again = cli_common::pleach(&args);
    again.ends(0, &[]);
    assert_eq!(with(&again.json(), "kept"), made);
    assert_eq!(names(&out).len(), 8);
}

#[test]
fn two_runs_of_one_pack_at_once_leave_one_whole_pack() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let args = [
        "generate",
        utf8(&script),
        "--out",
        utf8(&out),
        "--texture-size",
        "256",
    ];
    let runs: Vec<_> = (0..3).map(|_| command(&args).spawn().unwrap()).collect();
    let ends: Vec<_> = runs
        .into_iter()
        .map(|r| r.wait_with_output().unwrap())
        .collect();
    // One may lose the race for the place; it is then told to try again.
    for end in &ends {
        let err = String::from_utf8_lossy(&end.stderr);
        assert!(matches!(end.status.code(), Some(0 | 75)), "{err}");
    }
    assert!(ends.iter().any(|e| e.status.success()));
    assert_eq!(whole(&out.join(PACK)), Ok(()));
    assert_eq!(names(&out), [PACK]);
}
