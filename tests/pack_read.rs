//! Packs read back by the library: exactly what was made, or a word about what is wrong.

use std::fs;
use std::path::Path;

use pleach::asset::TreeAsset;
use pleach::mesh::{Mesh, Primitive, Vertex, WHITE};
use pleach::pack::{self, Manifest, Options, ReadError, Replace};
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::{self, Beside};
use pleach::tree::{self, Limits};
use pleach::wind::Rig;
use pleach::{capture, shadow};
use sha2::{Digest as _, Sha256};

/// A small tree whose trunk stands in a file beside the script.
const SCRIPT: &str = r#"(
    format: 1,
    name: "Sapling",
    seed: 3,
    bark: Ridged(),
    splines: [
        (name: "stem", file: "stem.spline"),
        (name: "limb", points: [(0, 0, 0), (0.05, 1, 0.02), (0, 2, 0.1)]),
    ],
    leaves: [(name: "leaf", length_m: 0.3, width_m: 0.15)],
    levels: [
        Branch(name: "trunk", length_m: 2.0, radius_m: 0.05, splines: ["stem"], sides: 6),
        Branch(
            name: "limbs", links: 5, start: 0.3, down: 50, length_of_parent: 0.4,
            radius_of_parent: 0.4, splines: ["limb"], sides: 4,
        ),
        Leaves(name: "leaves", links: 6, start: 0.2, down: (at: 50, vary: 10), kinds: ["leaf"]),
    ],
    lod: (budgets: [400, 60, 4]),
)
"#;

const NAME: &str = "sapling-11";

/// Makes the tree from another seed than the script's, and its pack in `dir`.
fn made(dir: &Path, options: Options) -> TreeAsset {
    fs::write(dir.join("stem.spline"), "0 0 0\n0.1 1 0\n0 2 0.2\n").expect("written");
    let files = Beside(dir.to_owned());
    let species = species::parse("sapling.ron", SCRIPT, &files)
        .unwrap_or_else(|faults| panic!("{}", faults.render(false)));
    let settings = Settings {
        seed: Some(11),
        full: true,
        captures: capture::Settings {
            atlas_size: 256,
            ..capture::Settings::default()
        },
        bark_size: 64,
        shadows: shadow::Settings {
            size: 32,
            bands: 1,
            samples: 4,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    let asset = pipeline::generate(&species, &settings, &files, &Quiet).expect("a small tree");
    let files = pack::build(&asset, SCRIPT.as_bytes(), options).expect("a small pack");
    pack::write(dir, NAME, &files, Replace::OwnPacks).expect("written");
    asset
}

#[test]
fn a_pack_is_read_back_exactly_as_it_was_made() {
    for embed in [false, true] {
        let dir = tempfile::tempdir().expect("a folder");
        let asset = made(
            dir.path(),
            Options {
                embed,
                mips: embed,
                no_wind: false,
            },
        );
        let pack = pack::read(&dir.path().join(NAME)).expect("a sound pack");
        assert_eq!(pack.manifest.seed, 11);
        assert_eq!(pack.script, SCRIPT);
        assert_eq!(pack.lods.len(), 4, "full detail and three budgets");
        for (read, lod) in pack.lods.iter().zip(&asset.lods) {
            let mut mesh = lod.mesh.clone();
            for primitive in [&mut mesh.bark, &mut mesh.foliage] {
                assert_eq!(primitive.levels.len(), primitive.vertices.len());
                primitive.levels.clear();
            }
            assert!(*read == mesh, "all but the levels");
        }
        assert!(pack.foliage.albedo == asset.foliage.albedo);
        assert!(pack.foliage.normal == asset.foliage.normal);
        assert!(pack.foliage.orm == asset.foliage.orm);
        assert!(pack.foliage.extra == asset.foliage.extra);
        assert!(!asset.reliefs.is_empty());
        assert_eq!(pack.reliefs, asset.reliefs);
        assert!(
            pack.bark.albedo == asset.bark.albedo,
            "drawn bark is opaque"
        );
        assert!(pack.bark.normal == asset.bark.normal);
        assert!(pack.bark.orm == asset.bark.orm);
        assert!(pack.bark.extra == asset.bark.albedo.map(|_| [0, 128, 255]));
    }
}

#[test]
fn a_pack_tells_how_to_read_its_wind_data_or_has_none() {
    for no_wind in [false, true] {
        let dir = tempfile::tempdir().expect("a folder");
        let options = Options {
            no_wind,
            ..Options::default()
        };
        let asset = made(dir.path(), options);
        let pack = pack::read(&dir.path().join(NAME)).expect("a sound pack");
        let rig = pack.manifest.wind.as_ref().map(Rig::from);
        assert_eq!(rig, (!no_wind).then_some(asset.wind));
        for lod in &pack.lods {
            assert_eq!(
                lod.bark.sway.is_empty(),
                no_wind || lod.bark.vertices.is_empty()
            );
            assert_eq!(lod.foliage.sway.is_empty(), no_wind);
        }
    }
}

#[test]
fn a_pack_of_days_before_it_told_of_captures_is_read() {
    let dir = tempfile::tempdir().expect("a folder");
    made(dir.path(), Options::default());
    let folder = dir.path().join(NAME);
    with_manifest(&folder, |m| m.textures.foliage.captures.clear());
    let text = fs::read_to_string(folder.join("pack.json")).expect("read");
    assert!(!text.contains("longer_m"));
    assert!(pack::read(&folder).expect("sound").reliefs.is_empty());
}

#[test]
fn the_full_tree_grows_again_from_a_pack_alone() {
    let dir = tempfile::tempdir().expect("a folder");
    let asset = made(dir.path(), Options::default());
    fs::remove_file(dir.path().join("stem.spline")).expect("removed");
    let pack = pack::read(&dir.path().join(NAME)).expect("a sound pack");
    let species = species::parse("species.ron", &pack.script, &Beside(pack.folder))
        .unwrap_or_else(|faults| panic!("{}", faults.render(false)));
    let tree = tree::grow(&species, pack.manifest.seed, &Limits::default()).expect("it grew");
    assert!(tree == asset.tree);
}

#[test]
fn the_gltf_crate_reads_the_same_meshes() {
    let dir = tempfile::tempdir().expect("a folder");
    made(dir.path(), Options::default());
    let pack = pack::read(&dir.path().join(NAME)).expect("a sound pack");
    for (lod, mesh) in pack.manifest.lods.iter().zip(&pack.lods) {
        // That crate gives no attributes that it does not know.
        let mut mesh = mesh.clone();
        mesh.bark.sway.clear();
        mesh.foliage.sway.clear();
        assert!(
            mesh == by_gltf(&pack.folder.join(&lod.file)),
            "{}",
            lod.file
        );
    }
}

fn by_gltf(path: &Path) -> Mesh {
    let (document, buffers, _) = gltf::import(path).expect("a glTF file");
    let mut mesh = Mesh::default();
    for primitive in document.meshes().next().expect("a mesh").primitives() {
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let normals = reader.read_normals().expect("normals");
        let tangents = reader.read_tangents().expect("tangents");
        let uvs = reader.read_tex_coords(0).expect("uvs").into_f32();
        let mut tints = reader.read_colors(0).map(|c| c.into_rgba_u8());
        let vertices = reader
            .read_positions()
            .expect("positions")
            .zip(normals.zip(tangents.zip(uvs)))
            .map(|(position, (normal, (tangent, uv)))| Vertex {
                position,
                normal,
                tangent,
                uv,
                tint: tints.as_mut().map_or(WHITE, |t| t.next().expect("a tint")),
            });
        let read = Primitive {
            vertices: vertices.collect(),
            indices: reader.read_indices().expect("indices").into_u32().collect(),
            ..Primitive::default()
        };
        match primitive.material().name() {
            Some("bark") => mesh.bark = read,
            Some("foliage") => mesh.foliage = read,
            other => panic!("material {other:?}"),
        }
    }
    mesh
}

/// Changes the manifest of the pack in `dir`.
fn with_manifest(pack: &Path, change: impl FnOnce(&mut Manifest)) {
    let mut manifest = pack::read_manifest(pack).expect("a manifest");
    change(&mut manifest);
    let text = serde_json::to_vec(&manifest).expect("JSON");
    fs::write(pack.join("pack.json"), text).expect("written");
}

/// Replaces a file, and its size and hash in the manifest, as one who means to deceive would.
fn forge(pack: &Path, path: &str, bytes: &[u8]) {
    fs::write(pack.join(path), bytes).expect("written");
    with_manifest(pack, |manifest| {
        let entry = manifest.files.iter_mut().find(|f| f.path == path);
        let entry = entry.expect("a file of the pack");
        entry.bytes = bytes.len() as u64;
        entry.sha256 = Sha256::digest(bytes)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
    });
}

#[test]
fn a_pack_that_is_not_as_it_was_made_is_refused_with_its_reason() {
    type Change = fn(&Path);
    let cases: &[(&[&str], Change)] = &[
        (&["cannot read", "pack.json"], |pack| {
            fs::remove_file(pack.join("pack.json")).expect("removed");
        }),
        (&["version 9", "reads 1"], |pack| {
            with_manifest(pack, |m| m.version = 9);
        }),
        (
            &["sapling_LOD1.glb", "not what the manifest says"],
            |pack| {
                let path = pack.join("sapling_LOD1.glb");
                let mut bytes = fs::read(&path).expect("read");
                *bytes.last_mut().expect("a byte") ^= 1;
                fs::write(path, bytes).expect("written");
            },
        ),
        (&["cannot read", "preview.png"], |pack| {
            fs::remove_file(pack.join("preview.png")).expect("removed");
        }),
        (&["pack.json", "../stem.spline"], |pack| {
            with_manifest(pack, |m| m.files[0].path = "../stem.spline".to_owned());
        }),
        (&["pack.json", "\"/etc/hosts\""], |pack| {
            with_manifest(pack, |m| m.files[0].path = "/etc/hosts".to_owned());
        }),
        (&["pack.json", "../a.glb", "list of files"], |pack| {
            with_manifest(pack, |m| m.lods[0].file = "../a.glb".to_owned());
        }),
        (&["pack.json", "at least one LOD"], |pack| {
            with_manifest(pack, |m| m.lods.clear());
        }),
        (&["sapling_LOD2.glb", "triangles as in pack.json"], |pack| {
            with_manifest(pack, |m| m.lods[2].foliage_triangles += 2);
        }),
        (&["sapling_LOD3.glb", "expected a GLB"], |pack| {
            forge(pack, "sapling_LOD3.glb", b"solid tree");
        }),
        (&["species.ron", "UTF-8"], |pack| {
            forge(pack, "species.ron", b"(name: \"\xff\")");
        }),
        (&["bark_normal.png", "PNG"], |pack| {
            forge(pack, "textures/bark_normal.png", b"");
        }),
        (&["foliage_orm.png", "256 x 256", "64 x 64"], |pack| {
            let bark = fs::read(pack.join("textures/bark_orm.png")).expect("read");
            forge(pack, "textures/foliage_orm.png", &bark);
        }),
        (&["foliage_albedo.png", "Rgba8", "Rgb8"], |pack| {
            let normal = fs::read(pack.join("textures/foliage_normal.png")).expect("read");
            forge(pack, "textures/foliage_albedo.png", &normal);
        }),
        (&["pack.json", "`extra`"], |pack| {
            with_manifest(pack, |m| m.textures.foliage.extra = None);
        }),
        (&["pack.json", "captures inside the atlas", "1.5"], |pack| {
            with_manifest(pack, |m| m.textures.foliage.captures[0].uv[2] = 1.5);
        }),
        (&["pack.json", "of some size", "longer_m: 0.0"], |pack| {
            with_manifest(pack, |m| m.textures.foliage.captures[0].longer_m = 0.0);
        }),
    ];
    let dir = tempfile::tempdir().expect("a folder");
    made(dir.path(), Options::default());
    let sound = dir.path().join(NAME);
    for (number, (words, change)) in cases.iter().enumerate() {
        let pack = dir.path().join(number.to_string());
        copy(&sound, &pack);
        assert!(pack::read(&pack).is_ok());
        change(&pack);
        let fault = pack::read(&pack).expect_err(words[0]).to_string();
        for word in *words {
            assert!(fault.contains(word), "no `{word}` in: {fault}");
        }
    }
    let missing = pack::read(&dir.path().join("no-such-pack"));
    assert!(matches!(missing, Err(ReadError::Manifest(_))));
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("copied");
        }
    }
}
