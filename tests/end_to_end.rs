//! The program from script to pack, read back by readers that are not its writers.
#![expect(clippy::unwrap_used, reason = "in a test, a panic is the report")]

mod cli_common;

use cli_common::{
    SAPLING, assert_same, command, files, generate, manifest, names, nursery, pleach, utf8, whole,
};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A broadleaf, a column, a palm and a shrub of many stems: scripts that come with the program, and whose captures
/// fit the small atlas of these tests. CI makes packs of all species at full size and has them judged.
fn species() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
    let names = ["common_hazel", "lombardy_poplar", "olive", "palm"];
    let scripts = names.map(|name| folder.join(format!("{name}.ron")));
    scripts.to_vec()
}

fn olive() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("species/olive.ron")
}

/// The one folder in `out`.
fn only_pack(out: &Path) -> PathBuf {
    let names = names(out);
    assert_eq!(names.len(), 1, "{names:?}");
    out.join(&names[0])
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|n| n.as_f64().expect("a number")).collect()
}

#[test]
fn every_species_becomes_a_pack_that_other_readers_can_open() {
    for script in species() {
        let dir = tempfile::tempdir().unwrap();
        let run = generate(&script, dir.path(), &[]);
        assert_eq!(run.code, Some(0), "{}: {}", script.display(), run.err);
        assert_eq!(run.out, "", "stdout is for --json");
        let pack = only_pack(dir.path());
        assert_eq!(whole(&pack), Ok(()), "{}", script.display());
        let made = manifest(&pack);
        has_the_fields_of_the_contract(&made);
        let inspect = ["inspect", utf8(&script), "--json", "--texture-size", "256"];
        let inspected = pleach(&inspect).json();
        for key in ["captures", "plane_captures", "asked"] {
            assert_eq!(made[key], inspected[key], "{key}");
        }
        let slug = made["species"]["slug"].as_str().unwrap();
        let name = format!("{slug}-{}", made["seed"]);
        assert_eq!(pack.file_name().unwrap().to_str(), Some(name.as_str()));
        for (index, lod) in made["lods"].as_array().unwrap().iter().enumerate() {
            assert_eq!(lod["file"], format!("{slug}_LOD{index}.glb"));
            holds_a_lod(&pack, &made, lod);
        }
        every_png_decodes(&pack, &made);
        shadows_hold_their_codes(&pack, &made);
        assert_eq!(
            fs::read(pack.join("species.ron")).unwrap(),
            fs::read(&script).unwrap(),
            "the script exactly as used"
        );
        // With the files that it names beside it, a pack's script makes the pack again.
        let again = tempfile::tempdir().unwrap();
        generate(&pack.join("species.ron"), again.path(), &[]).ends(0, &[]);
        assert_same(&pack, &only_pack(again.path()));
    }
}

fn has_the_fields_of_the_contract(made: &Value) {
    assert_eq!(made["format"], "pleach-pack");
    assert_eq!(made["version"], 1);
    assert!(made["generator"].as_str().unwrap().starts_with("pleach "));
    assert_eq!((&made["units"], &made["up"]), (&"m".into(), &"+Y".into()));
    assert!(made["seed"].is_u64() && made["warnings"].is_array());
    assert!(made["captures"].is_u64() && made["plane_captures"].is_u64());
    assert!(made["asked"]["budgets"].is_array() && made["asked"]["selector"] == "cut");
    assert_eq!(made["asked"]["calibrate"], true);
    for key in ["name", "latin", "slug"] {
        assert!(made["species"][key].is_string(), "species.{key}");
    }
    for level in made["levels"].as_array().unwrap() {
        assert!(level["name"].is_string() && level["kind"].is_string());
        assert!(level["prototypes"].as_u64() >= Some(1) && level["nodes"].as_u64() >= Some(1));
    }
    let (min, max) = (
        numbers(&made["bounds"]["min"]),
        numbers(&made["bounds"]["max"]),
    );
    assert!((0..3).all(|axis| min[axis] < max[axis]));
    let lods = made["lods"].as_array().unwrap();
    assert!(!lods.is_empty());
    for pair in lods.windows(2) {
        let falls = |key: &str| pair[0][key].as_f64() > pair[1][key].as_f64();
        assert!(falls("triangles") && falls("screen_size"), "{pair:?}");
        assert!(pair[0]["error_m"].as_f64() <= pair[1]["error_m"].as_f64());
    }
    for lod in lods {
        assert!(lod["state"].is_string());
        let within = |key: &str, low: f64, high: f64| {
            let number = lod[key].as_f64().unwrap();
            assert!((low..=high).contains(&number), "{key} {number}");
        };
        within("silhouette_iou", 0.01, 1.0);
        within("coverage", 0.2, 3.0);
        within("scale", 0.75, 1.3);
        let parts = ["branches_triangles", "foliage_triangles"].map(|k| lod[k].as_u64().unwrap());
        assert_eq!(lod["triangles"], parts[0] + parts[1]);
        if let Some(budget) = lod["budget"].as_u64() {
            assert!(lod["triangles"].as_u64().unwrap() <= budget, "{lod}");
        }
    }
}

/// Opens a GLB with its textures by the `gltf` crate and holds it against the manifest.
fn holds_a_lod(pack: &Path, made: &Value, lod: &Value) {
    let (document, buffers, images) =
        gltf::import(pack.join(lod["file"].as_str().unwrap())).expect("a glTF file");
    assert_eq!(document.meshes().len(), 1);
    let mesh = document.meshes().next().unwrap();
    let mut by_material = [0, 0];
    for primitive in mesh.primitives() {
        let material = primitive.material();
        let foliage = match material.name() {
            Some("bark") => false,
            Some("foliage") => true,
            other => panic!("material {other:?}"),
        };
        let (mode, cutoff) = (material.alpha_mode(), material.alpha_cutoff());
        if foliage {
            assert_eq!((mode, cutoff), (gltf::material::AlphaMode::Mask, Some(0.5)));
        } else {
            assert_eq!(mode, gltf::material::AlphaMode::Opaque);
        }
        assert_eq!(material.double_sided(), foliage);
        let surface = &made["textures"][if foliage { "foliage" } else { "bark" }];
        let albedo = material.pbr_metallic_roughness().base_color_texture();
        let albedo = &images[albedo.expect("albedo").texture().source().index()];
        assert_eq!(
            surface["size"],
            serde_json::json!([albedo.width, albedo.height])
        );
        assert!(material.normal_texture().is_some());
        let count = triangles_in_bounds(&primitive, &buffers, made);
        assert_eq!(
            by_material[usize::from(foliage)],
            0,
            "one primitive a material"
        );
        by_material[usize::from(foliage)] = count;
    }
    assert_eq!(lod["branches_triangles"], by_material[0]);
    assert_eq!(lod["foliage_triangles"], by_material[1]);
}

/// Triangles of a primitive after looking at every vertex and index.
fn triangles_in_bounds(
    primitive: &gltf::Primitive<'_>,
    buffers: &[gltf::buffer::Data],
    made: &Value,
) -> usize {
    assert_eq!(primitive.mode(), gltf::mesh::Mode::Triangles);
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
    let (min, max) = (
        numbers(&made["bounds"]["min"]),
        numbers(&made["bounds"]["max"]),
    );
    let slack = 1e-5;
    for position in &positions {
        for axis in 0..3 {
            let value = f64::from(position[axis]);
            let range = min[axis] - slack..=max[axis] + slack;
            assert!(range.contains(&value), "{position:?} outside {range:?}");
        }
    }
    let unit = |v: [f32; 3]| {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        (length - 1.0).abs() < 1e-3
    };
    assert!(reader.read_normals().expect("normals").all(unit));
    let tangents = reader.read_tangents().expect("tangents");
    assert!(
        tangents
            .clone()
            .all(|t| unit([t[0], t[1], t[2]]) && t[3].abs() == 1.0)
    );
    assert_eq!(tangents.len(), positions.len());
    let mut uvs = reader.read_tex_coords(0).expect("uvs").into_f32();
    assert!(uvs.all(|uv| uv.iter().all(|c| c.is_finite())));
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    assert!(indices.iter().all(|&i| (i as usize) < positions.len()));
    assert!(indices.len().is_multiple_of(3));
    indices.len() / 3
}

fn every_png_decodes(pack: &Path, made: &Value) {
    for entry in made["files"].as_array().unwrap() {
        let path = entry["path"].as_str().unwrap();
        if path.ends_with(".png") {
            let image = image::open(pack.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
            assert!(image.width() > 0 && image.height() > 0);
        }
    }
    for (role, keys) in [
        ("bark", &["albedo", "normal", "orm"][..]),
        ("foliage", &["albedo", "normal", "orm", "extra"]),
    ] {
        let surface = &made["textures"][role];
        for key in keys {
            let path = surface[key].as_str().unwrap();
            let (width, height) = image::image_dimensions(pack.join(path)).unwrap();
            assert_eq!(
                surface["size"],
                serde_json::json!([width, height]),
                "{path}"
            );
        }
    }
}

fn shadows_hold_their_codes(pack: &Path, made: &Value) {
    let shadows = &made["shadows"];
    let atlas = image::open(pack.join(shadows["file"].as_str().unwrap())).unwrap();
    let atlas = atlas.as_luma8().expect("8-bit grey").clone();
    let maps = shadows["maps"].as_array().unwrap();
    assert_eq!(maps.len(), 9);
    for (index, map) in maps.iter().enumerate() {
        let rect: Vec<u32> = serde_json::from_value(map["rect"].clone()).unwrap();
        let [x, y, width, height] = rect[..] else {
            panic!("{rect:?}")
        };
        assert!(x + width <= atlas.width() && y + height <= atlas.height());
        let code: Vec<u8> = (0..4).map(|i| atlas.get_pixel(x + i, y).0[0]).collect();
        let decoded = [[code[0], code[1]], [code[2], code[3]]].map(u16::from_le_bytes);
        assert_eq!(map["trunk_base"], serde_json::json!(decoded));
        assert!(u32::from(decoded[0]) < width && u32::from(decoded[1]) < height);
        // The texel of the trunk base covers the origin of the ground.
        let ground = numbers(&map["ground_rect_m"]);
        for axis in 0..2 {
            let texel = (ground[axis + 2] - ground[axis]) / f64::from(rect[axis + 2]);
            let at = ground[axis] + (f64::from(decoded[axis]) + 0.5) * texel;
            assert!(at.abs() <= texel * 0.51, "map {index}: {at} m of {texel}");
        }
        let direction = numbers(&map["direction"]);
        let height = if index == 0 { 1.0 } else { 0.5_f64.sqrt() };
        assert!((direction[1] - height).abs() < 1e-5, "{direction:?}");
        let dark =
            (4..width).any(|i| (0..rect[3]).any(|j| atlas.get_pixel(x + i, y + j).0[0] > 127));
        assert!(dark, "map {index} is empty");
    }
}

#[test]
fn a_tree_of_n_levels_and_k_branch_types_has_twice_n_less_one_plus_k_captures() {
    let (dir, script) = nursery();
    // Three levels, two branch types: one spline, but two tapers and thicknesses.
    let sapling = generate(&script, dir.path(), &["--json"]).json();
    assert_eq!(sapling["pack"]["captures"], (3 - 1 + 2) * 2);
    // The olive has seven and six.
    let olive = pleach(&["inspect", utf8(&olive()), "--json"]).json();
    assert_eq!(olive["captures"], (7 - 1 + 6) * 2);
}

#[test]
fn the_same_script_and_seed_give_the_same_bytes_whatever_the_threads_and_run() {
    let (dir, sapling) = nursery();
    let out = |name: &str| dir.path().join(name);
    for (script, pack) in [(olive(), "olive-5"), (sapling.clone(), "sapling-5")] {
        for threads in ["1", "2"] {
            generate(
                &script,
                &out(threads),
                &["--threads", threads, "--seed", "5"],
            )
            .ends(0, &[]);
        }
        assert_same(&out("1").join(pack), &out("2").join(pack));
    }
    let pack = out("1").join("sapling-5");
    generate(&sapling, &out("again"), &["--seed", "5"]).ends(0, &[]);
    assert_same(&pack, &out("again").join("sapling-5"));
    // The pack's own script makes the pack again.
    generate(&pack.join("species.ron"), &out("own"), &["--seed", "5"]).ends(0, &[]);
    assert_same(&pack, &out("own").join("sapling-5"));
    generate(&sapling, &out("own"), &["--seed", "6"]).ends(0, &[]);
    let (five, six) = (files(&pack), files(&out("own").join("sapling-6")));
    assert!(
        five["sapling_LOD0.glb"] != six["sapling_LOD0.glb"],
        "the seed matters"
    );
    assert!(five["species.ron"] == six["species.ron"]);
}

#[test]
fn embedded_files_open_alone_and_plain_ones_need_their_textures() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    generate(&script, &out, &["--embed"]).ends(0, &[]);
    let pack = out.join("sapling-3");
    assert_eq!(whole(&pack), Ok(()));
    let alone = dir.path().join("alone.glb");
    for lod in 0..3 {
        fs::copy(pack.join(format!("sapling_LOD{lod}.glb")), &alone).unwrap();
        let (document, _, images) = gltf::import(&alone).expect("opens without its textures");
        assert_eq!(images.len(), document.images().len());
        assert!(!images.is_empty() && images.iter().all(|i| i.width >= 256));
    }
    generate(&script, &out, &[]).ends(0, &[]);
    fs::copy(pack.join("sapling_LOD0.glb"), &alone).unwrap();
    assert!(gltf::import(&alone).is_err(), "textures are shared files");
}

#[test]
fn mips_halve_down_to_one_texel() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    generate(&script, &out, &["--mips"]).ends(0, &[]);
    let pack = out.join("sapling-3");
    assert_eq!(whole(&pack), Ok(()));
    let made = manifest(&pack);
    let mips = made["textures"]["foliage"]["mips"].as_array().unwrap();
    let sizes: Vec<(u32, u32)> = mips
        .iter()
        .map(|path| image::image_dimensions(pack.join(path.as_str().unwrap())).unwrap())
        .collect();
    let halves: Vec<(u32, u32)> = (0..8).map(|i| (128 >> i, 128 >> i)).collect();
    assert_eq!(sizes, halves);
}

#[test]
fn budgets_of_the_command_line_replace_those_of_the_script() {
    let (dir, script) = nursery();
    let run = generate(&script, dir.path(), &["--budgets", "full,100,4", "--json"]);
    run.ends(0, &[]);
    let lods = run.json()["pack"]["lods"].clone();
    let budgets: Vec<&Value> = lods
        .as_array()
        .unwrap()
        .iter()
        .map(|l| &l["budget"])
        .collect();
    assert_eq!(budgets, [&Value::Null, &100.into(), &4.into()]);
    // Full detail is what `inspect` counts.
    let inspected = pleach(&["inspect", utf8(&script), "--json"]).json();
    assert_eq!(lods[0]["triangles"], inspected["full_triangles"]);
    assert_eq!(lods[2]["triangles"], 4);
    // A budget that no form is left for is told, and gets no file.
    let run = generate(&script, dir.path(), &["--budgets", "full,5,4", "--json"]);
    run.ends(0, &["warning: budget of 4 triangles"]);
    assert_eq!(run.json()["pack"]["lods"].as_array().unwrap().len(), 2);
    assert_eq!(run.json()["pack"]["warnings"].as_array().unwrap().len(), 1);
}

#[test]
fn the_olive_keeps_full_detail_and_budgets_in_one_chain() {
    let dir = tempfile::tempdir().unwrap();
    let run = generate(&olive(), dir.path(), &["--budgets", "full,500,4", "--json"]);
    run.ends(0, &[]);
    let pack = only_pack(dir.path());
    assert_eq!(whole(&pack), Ok(()));
    let made = manifest(&pack);
    assert!(run.json()["pack"] == made, "the manifest, number by number");
    assert_eq!(run.json()["folder"], utf8(&pack));
    assert_eq!(made["lods"].as_array().unwrap().len(), 3);
    for lod in made["lods"].as_array().unwrap() {
        holds_a_lod(&pack, &made, lod);
    }
}

#[test]
fn text_for_people_on_a_pipe_is_free_of_bars_and_colours() {
    let (dir, script) = nursery();
    let bad = dir.path().join("bad.ron");
    fs::write(&bad, SAPLING.replace("links: 5", "lnks: 5")).unwrap();
    let runs = [
        generate(&script, dir.path(), &[]),
        generate(&bad, dir.path(), &[]),
        pleach(&["check", utf8(&bad)]),
        pleach(&["inspect", utf8(&script)]),
    ];
    for run in runs {
        let fine = |c: char| c == '\n' || !c.is_control();
        assert!(run.err.chars().all(fine), "{:?}", run.err);
        assert!(!run.err.is_empty() && run.out.is_empty());
    }
}

#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let (dir, script) = nursery();
    let mut child = command(&["inspect", utf8(&script), "--json"])
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    drop(dir);
}

#[test]
fn inspect_tells_of_scripts_and_packs_and_finds_damage() {
    let (dir, script) = nursery();
    generate(&script, dir.path(), &[]).ends(0, &[]);
    let pack = dir.path().join("sapling-3");
    let inspect = ["inspect", utf8(&script), "--json", "--texture-size", "256"];
    let of_script = pleach(&inspect);
    of_script.ends(0, &["Sapling", "limbs", "LOD2", "Error is", "1080 lines"]);
    let of_pack = pleach(&["inspect", utf8(&pack), "--json"]);
    of_pack.ends(0, &["Sapling", "limbs", "LOD2", "textures/shadows.png"]);
    let script_text = of_script.err.clone();
    let (of_script, of_pack) = (of_script.json(), of_pack.json());
    assert!(of_pack == manifest(&pack), "the manifest, number by number");
    for key in ["captures", "seed"] {
        assert_eq!(of_script[key], of_pack[key], "{key}");
    }
    assert_eq!(of_script["levels"], of_pack["levels"]);
    // Each LOD of the script is as in the pack, and tells two things more.
    let mut lods = of_script["lods"].clone();
    for lod in lods.as_array_mut().unwrap() {
        let lod = lod.as_object_mut().unwrap();
        let number = |value: Option<Value>| value.and_then(|v| v.as_f64()).unwrap();
        let (used, pixels) = (lod.remove("budget_used"), lod.remove("pixels_of_1080"));
        let triangles = number(lod.get("triangles").cloned());
        let budget = number(lod.get("budget").cloned());
        assert!((number(used) - triangles / budget).abs() < 1e-6);
        let size = number(lod.get("screen_size").cloned());
        assert!((number(pixels) - size * 1080.0).abs() < 1e-3);
    }
    assert_eq!(lods, of_pack["lods"], "what is told is what is made");
    let told = |err: &str| {
        let table = err.split_once("\nLOD").unwrap_or_default().1;
        table.split("\n\n").next().unwrap_or_default().to_owned()
    };
    let pack_text = pleach(&["inspect", utf8(&pack)]).err;
    assert_eq!(told(&script_text), told(&pack_text));
    let file = pack.join("textures/bark_orm.png");
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&file, bytes).unwrap();
    pleach(&["inspect", utf8(&pack)]).ends(1, &["bark_orm.png", "not what the manifest says"]);
    fs::remove_file(&file).unwrap();
    pleach(&["inspect", utf8(&pack)]).ends(1, &["bark_orm.png"]);
    pleach(&["inspect", utf8(&dir.path().join("none"))]).ends(1, &["none"]);
    pleach(&["inspect", utf8(dir.path())]).ends(1, &["pack.json"]);
}

#[test]
fn a_pack_of_an_older_version_is_told_of_without_what_was_not_measured() {
    let (dir, script) = nursery();
    generate(&script, dir.path(), &[]).ends(0, &[]);
    let pack = dir.path().join("sapling-3");
    let mut made = manifest(&pack);
    for key in ["plane_captures", "asked"] {
        made.as_object_mut().unwrap().remove(key).unwrap();
    }
    for lod in made["lods"].as_array_mut().unwrap() {
        for key in ["scale", "silhouette_iou", "coverage"] {
            lod.as_object_mut().unwrap().remove(key).unwrap();
        }
    }
    fs::write(pack.join("pack.json"), made.to_string()).unwrap();
    let run = pleach(&["inspect", utf8(&pack), "--json"]);
    run.ends(0, &["Sapling", "1.000"]);
    let read = run.json();
    assert_eq!(read["plane_captures"], 0);
    assert_eq!(read["lods"][1]["scale"], 1.0);
    assert!(read["lods"][1]["coverage"].is_null() && read["asked"].is_null());
}

#[test]
fn flags_of_the_lod_chain_override_the_script() {
    let (dir, script) = nursery();
    let made = |flags: &[&str]| {
        let run = generate(&script, dir.path(), &[&["--json"], flags].concat());
        run.ends(0, &[]);
        run.json()["pack"].clone()
    };
    let is_cut = |lod: &Value| lod["state"].as_str().unwrap().starts_with("cut;");
    let is_scaled = |lod: &Value| lod["scale"] != 1.0;
    let any =
        |pack: &Value, of: &dyn Fn(&Value) -> bool| pack["lods"].as_array().unwrap().iter().any(of);
    let plain = made(&[]);
    assert!(any(&plain, &is_cut) && any(&plain, &is_scaled), "{plain}");
    let levels = made(&["--selector", "levels", "--no-calibrate"]);
    assert!(!any(&levels, &is_cut) && !any(&levels, &is_scaled));
    assert_eq!(levels["asked"]["selector"], "levels");
    assert_eq!(levels["asked"]["calibrate"], false);
    // The script's word counts where there is no flag, and the flag's where there is.
    let text = fs::read_to_string(&script).unwrap();
    let own = "4], selector: Levels, calibrate: false)";
    fs::write(&script, text.replace("4])", own)).unwrap();
    assert_eq!(made(&[])["lods"], levels["lods"]);
    let cut = made(&["--selector", "cut"]);
    assert!(any(&cut, &is_cut) && !any(&cut, &is_scaled));
    let inspect = ["inspect", utf8(&script), "--json", "--texture-size", "256"];
    let told = pleach(&[&inspect[..], &["--selector", "cut"]].concat()).json();
    assert_eq!(told["asked"], cut["asked"]);
}

#[test]
fn a_script_is_changed_on_the_command_line_and_its_pack_tells_how() {
    let (dir, script) = nursery();
    let text = fs::read_to_string(&script).unwrap();
    let varied = "variations: [(name: \"pole\", seed: 9, age: 0.5, habit: Forest)],\n    levels";
    fs::write(&script, text.replacen("levels", varied, 1)).unwrap();
    generate(&script, dir.path(), &["--variation", "pole"]).ends(0, &[]);
    let pack = dir.path().join("sapling-pole-9");
    let own = fs::read_to_string(pack.join("species.ron")).unwrap();
    assert!(
        own.contains("age: 0.5") && own.contains("habit: Forest"),
        "{own}"
    );
    // The pack's own script makes it again, without a word on the command line.
    let again = dir.path().join("again");
    generate(&pack.join("species.ron"), &again, &[]).ends(0, &[]);
    assert_same(&pack, &again.join("sapling-pole-9"));
    let plain = |more: &[&str]| {
        let run = generate(
            &script,
            dir.path(),
            &[&["--json", "--force"], more].concat(),
        );
        run.ends(0, &[]);
        run.json()["pack"].clone()
    };
    let height = |pack: &Value| pack["bounds"]["max"][1].as_f64().unwrap();
    let young = plain(&["--set", "age=0.2", "--set", "slug=\"young\""]);
    assert!(
        height(&young) < 0.6 * height(&plain(&[])),
        "{}",
        height(&young)
    );
    for (more, words) in [
        (["--variation", "pool"], ["no such variation", "pole"]),
        (["--set", "age"], ["FIELD=VALUE", "age=0.4"]),
        (["--set", "age=(("], ["no value", "(("]),
    ] {
        generate(&script, dir.path(), &more).ends(2, &words);
    }
    generate(&script, dir.path(), &["--set", "agr=1"]).ends(1, &["unknown field `agr`", "`age`"]);
    generate(&script, dir.path(), &["--set", "age=9"]).ends(1, &["out of range", "0.05 to 1.5"]);
}

#[test]
fn check_tells_every_fault_of_every_script_at_its_place() {
    let (dir, script) = nursery();
    let bad = dir.path().join("bad.ron");
    let text = SAPLING
        .replace("links: 5", "lnks: 5")
        .replace("seed: 3", "seed: -3");
    fs::write(&bad, text).unwrap();
    pleach(&["check", utf8(&script)]).ends(0, &["Sapling is fine (36 nodes)"]);
    let run = pleach(&["check", utf8(&script), utf8(&bad), "--json"]);
    let seed = format!("{}:6:11", bad.display());
    let links = format!("{}:13:28", bad.display());
    run.ends(
        1,
        &[
            "Sapling is fine",
            &seed,
            &links,
            "did you mean `links`?",
            "1 of 2",
        ],
    );
    let json = run.json();
    assert_eq!(json[0]["faults"].as_array().unwrap().len(), 0);
    let faults = json[1]["faults"].as_array().unwrap();
    assert_eq!(faults.len(), 2);
    for fault in faults {
        assert!(fault["line"].is_u64() && fault["column"].is_u64());
        assert!(fault["path"].is_string() && fault["message"].is_string());
    }
    // `generate` says the same, and makes nothing.
    let out = dir.path().join("packs");
    generate(&bad, &out, &[]).ends(1, &[&seed, &links, "2 faults; nothing was made"]);
    assert!(!out.exists());
    pleach(&["check", utf8(&dir.path().join("none.ron"))]).ends(1, &["none.ron"]);
}

#[test]
fn command_lines_at_fault_end_with_two_and_the_reason() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    for (args, words) in [
        (&["--nonsense"][..], &["--nonsense"][..]),
        (&["--budgets", "0"], &["a budget of 0", "has 4"]),
        (&["--budgets", "400,3"], &["a budget of 3", "has 4"]),
        (
            &["--budgets", "4,400"],
            &["must fall", "4 is followed by 400"],
        ),
        (&["--budgets", "40,40"], &["must fall"]),
        (&["--budgets", "400,full"], &["`full` first"]),
        (&["--budgets", "many"], &["`many` is no triangle budget"]),
        (
            &["--texture-size", "100"],
            &["100", "10000 texels", "power of two"],
        ),
        (
            &["--texture-size", "16384"],
            &["268435456 texels", "67108864"],
        ),
        (&["--texture-size", "0"], &["power of two"]),
        (&["--threads", "0"], &["--threads"]),
        (&["--seed=-1"], &["--seed"]),
        #[cfg(not(feature = "gpu"))]
        (&["--baker", "gpu"], &["no GPU backend", "--features gpu"]),
        (&["--baker", "oven"], &["cpu"]),
        (&["--selector", "cuts"], &["cut", "levels"]),
    ] {
        let mut all = vec!["generate", utf8(&script), "--out", utf8(&out)];
        all.extend(args);
        let run = pleach(&all);
        run.ends(2, words);
        assert_eq!(run.out, "");
    }
    assert!(!out.exists(), "nothing was begun");
    pleach(&[]).ends(2, &["Usage"]);
    pleach(&["prune"]).ends(2, &["prune"]);
    pleach(&["check"]).ends(2, &["SPECIES"]);
    pleach(&["inspect", utf8(&script), "--budgets", "2"]).ends(2, &["has 4"]);
    let help = pleach(&["--help"]);
    assert_eq!(help.code, Some(0));
    assert!(
        ["generate", "batch", "check", "inspect"]
            .iter()
            .all(|c| help.out.contains(c))
    );
}

#[test]
fn inputs_at_fault_end_with_one_and_name_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let out = at("packs");
    generate(&at("none.ron"), &out, &[]).ends(1, &["none.ron", "cannot read"]);
    generate(dir.path(), &out, &[]).ends(1, &[utf8(dir.path())]);
    fs::write(at("latin1.ron"), b"(name: \"Ch\xeane\")").unwrap();
    generate(&at("latin1.ron"), &out, &[]).ends(1, &["latin1.ron", "byte 10"]);
    fs::write(at("empty.ron"), "").unwrap();
    generate(&at("empty.ron"), &out, &[]).ends(1, &["empty.ron:1:1"]);
    // A thousand limbs with two hundred thousand leaves each.
    let many = SAPLING
        .replace(
            "links: 6, start: 0.2",
            "links: 5000, children: 40, start: 0.2",
        )
        .replace("links: 5, start: 0.3", "links: 1000, start: 0.3");
    fs::write(at("many.ron"), many).unwrap();
    generate(&at("many.ron"), &out, &[]).ends(1, &["many.ron", "`leaves`", "200001001 nodes"]);
    pleach(&["check", utf8(&at("many.ron"))]).ends(1, &["`leaves`", "200001001 nodes"]);
    let script = olive();
    let small = [
        "generate",
        utf8(&script),
        "--out",
        utf8(&out),
        "--texture-size",
        "64",
    ];
    pleach(&small).ends(1, &["olive.ron", "64 x 64", "raise --texture-size"]);
    assert!(!out.exists());
}

#[test]
fn image_files_of_no_use_are_named() {
    let (dir, script) = nursery();
    let out = dir.path().join("packs");
    let text = SAPLING.replace("width_m: 0.15", "width_m: 0.15, image: \"leaf.png\"");
    fs::write(&script, text).unwrap();
    let both = |words: &[&str]| {
        generate(&script, &out, &[]).ends(1, words);
        pleach(&["check", utf8(&script)]).ends(1, words);
    };
    both(&["leaf.png", "no such file", ":9:"]);
    let leaf = dir.path().join("leaf.png");
    fs::write(&leaf, "GIF89a, or so").unwrap();
    both(&["leaf.png"]);
    fs::write(&leaf, "").unwrap();
    both(&["leaf.png"]);
    let picture = image::RgbaImage::from_fn(32, 64, |x, y| {
        image::Rgba([60, 120, if x > y { 40 } else { 90 }, 255])
    });
    picture.save(&leaf).unwrap();
    let bytes = fs::read(&leaf).unwrap();
    for length in [20, bytes.len() / 2, bytes.len() - 20] {
        fs::write(&leaf, &bytes[..length]).unwrap();
        both(&["leaf.png"]);
    }
    assert!(!out.exists());
    fs::write(&leaf, &bytes).unwrap();
    pleach(&["check", utf8(&script)]).ends(0, &[]);
    generate(&script, &out, &[]).ends(0, &[]);
    assert_eq!(whole(&out.join("sapling-3")), Ok(()));
}
