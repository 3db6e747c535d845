//! GLBs that are sound, damaged, or not ours.

use super::super::gltf::glb;
use super::super::{Options, PackFile, Textures};
use super::*;
use proptest::prelude::*;
use serde_json::{Value, json};

/// A fan of triangles with a different number in each place of each vertex.
fn fan(vertices: u16, tinted: bool) -> Primitive {
    let number = |vertex: u16, place: usize| f32::from(vertex) + place as f32 / 16.0;
    Primitive {
        vertices: (0..vertices)
            .map(|v| Vertex {
                position: core::array::from_fn(|i| number(v, i)),
                normal: core::array::from_fn(|i| number(v, 3 + i)),
                tangent: core::array::from_fn(|i| number(v, 6 + i)),
                uv: core::array::from_fn(|i| number(v, 10 + i)),
                tint: if tinted {
                    [v.to_le_bytes()[0], 1, 2, 255]
                } else {
                    WHITE
                },
            })
            .collect(),
        indices: (2..u32::from(vertices))
            .flat_map(|v| [0, v - 1, v])
            .collect(),
        sway: (0..vertices)
            .map(|v| Sway {
                wind: [v, v + 1, v / 256, 7].map(|n| n.to_le_bytes()[0]),
                leaf: [-128, -1, 0, 127],
            })
            .collect(),
        ..Primitive::default()
    }
}

fn two() -> Mesh {
    Mesh {
        bark: fan(5, true),
        foliage: fan(4, false),
    }
}

fn written(mesh: &Mesh, embed: bool) -> Vec<u8> {
    let files = |stem: &str| {
        ["albedo", "normal", "orm"].map(|role| PackFile {
            path: format!("textures/{stem}_{role}.png"),
            bytes: vec![7; 5],
        })
    };
    let textures = Textures {
        bark: files("bark"),
        foliage: files("foliage"),
    };
    let options = Options {
        embed,
        ..Options::default()
    };
    glb("test", mesh, &textures, options).unwrap().unwrap()
}

/// The GLB with its JSON changed.
fn changed(glb: &[u8], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (json, bytes) = chunks(glb).unwrap();
    let mut json: Value = serde_json::from_slice(json).unwrap();
    change(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    let word = |length: usize| u32::try_from(length).unwrap().to_le_bytes();
    glb.extend(word(28 + text.len() + bytes.len()));
    glb.extend(word(text.len()));
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend(word(bytes.len()));
    glb.extend(b"BIN\0");
    glb.extend(bytes);
    glb
}

/// What every mesh that was read promises.
fn sound(mesh: &Mesh) -> bool {
    [&mesh.bark, &mesh.foliage].iter().all(|p| {
        let finite = |v: &Vertex| {
            let floats = v
                .position
                .iter()
                .chain(&v.normal)
                .chain(&v.tangent)
                .chain(&v.uv);
            floats.copied().all(f32::is_finite)
        };
        p.vertices.iter().all(finite)
            && p.indices.len().is_multiple_of(3)
            && p.indices.iter().all(|&i| (i as usize) < p.vertices.len())
    })
}

#[test]
fn what_was_written_is_read_whatever_its_parts_and_the_width_of_its_indices() {
    let none = Primitive::default();
    for (bark, foliage) in [
        (fan(5, true), fan(4, false)),
        (fan(5, true), none.clone()),
        (none.clone(), fan(4, false)),
        (none.clone(), none),
        (fan(65_534, true), fan(65_535, false)),
    ] {
        let mesh = Mesh { bark, foliage };
        for embed in [false, true] {
            assert!(super::mesh(&written(&mesh, embed)) == Ok(mesh.clone()));
        }
        let mut still = mesh.clone();
        still.bark.sway.clear();
        still.foliage.sway.clear();
        assert!(super::mesh(&written(&still, false)) == Ok(still));
    }
}

#[test]
fn every_part_of_a_glb_is_too_short() {
    let glb = written(&two(), true);
    for length in 0..glb.len() {
        assert!(mesh(&glb[..length]).is_err(), "the first {length} bytes");
    }
    let longer = [glb, vec![0; 4]].concat();
    assert!(mesh(&longer).unwrap_err().contains("bytes"));
}

#[test]
fn a_glb_that_says_more_than_ours_is_refused_by_name() {
    let glb = written(&two(), false);
    type Change = fn(&mut Value);
    let changes: [(&str, Change); 15] = [
        ("translation", |v| {
            v["nodes"][0]["translation"] = json!([0, 1, 0]);
        }),
        ("extensionsRequired", |v| {
            v["extensionsRequired"] = json!(["X"]);
        }),
        ("sparse", |v| {
            v["accessors"][0]["sparse"] = json!({ "count": 1 });
        }),
        ("normalized", |v| {
            v["accessors"][3]["normalized"] = json!(true);
        }),
        ("targets", |v| {
            v["meshes"][0]["primitives"][0]["targets"] = json!([]);
        }),
        ("COLOR_0", |v| {
            v["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0);
        }),
        ("baseColorFactor", |v| {
            let factor = json!([1, 0, 0, 1]);
            v["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = factor;
        }),
        ("one scene", |v| v["nodes"] = json!([])),
        ("masked at 0.5", |v| {
            v["materials"][1]["alphaCutoff"] = json!(0.4);
        }),
        ("mode 5", |v| {
            v["meshes"][0]["primitives"][0]["mode"] = 5.into();
        }),
        ("one primitive of bark", |v| {
            v["meshes"][0]["primitives"][1]["material"] = 0.into();
        }),
        ("_WIND as VEC4 of normalized", |v| {
            v["accessors"][5]["normalized"] = json!(false);
        }),
        ("_WIND_LEAF as VEC4", |v| {
            v["accessors"][6]["byteOffset"] = json!(0);
        }),
        ("both _WIND and _WIND_LEAF", |v| {
            let attributes = &mut v["meshes"][0]["primitives"][0]["attributes"];
            attributes.as_object_mut().unwrap().remove("_WIND");
        }),
        ("NORMAL", |v| {
            v["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 0.into();
        }),
    ];
    for (word, change) in changes {
        let fault = mesh(&changed(&glb, change)).expect_err(word);
        assert!(fault.contains(word), "{word}: {fault}");
    }
    assert!(mesh(&changed(&glb, |_| ())).is_ok());
}

/// Every number of a document, in turn.
fn numbers(value: &mut Value, visit: &mut impl FnMut(&mut Value)) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(|v| numbers(v, visit)),
        Value::Object(map) => map.values_mut().for_each(|v| numbers(v, visit)),
        Value::Number(_) => visit(value),
        _ => {}
    }
}

#[test]
fn no_number_of_the_json_leads_out_of_the_file() {
    let glb = written(&two(), true);
    let mut count = 0;
    changed(&glb, |json| numbers(json, &mut |_| count += 1));
    assert!(count > 80, "only {count} numbers found");
    let wild = [
        json!(0),
        json!(1),
        json!(3),
        json!(-1),
        json!(u32::MAX),
        json!(u64::MAX),
        json!(u64::MAX / 52 + 1),
        json!(1e300),
    ];
    for place in 0..count {
        for value in &wild {
            let mut at = 0;
            let bytes = changed(&glb, |json| {
                numbers(json, &mut |number| {
                    if at == place {
                        *number = value.clone();
                    }
                    at += 1;
                });
            });
            assert!(mesh(&bytes).is_ok_and(|m| sound(&m)) || mesh(&bytes).is_err());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn damaged_bytes_are_refused_or_read_as_a_sound_mesh(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut glb = written(&two(), false);
        for (place, byte) in damage {
            let place = place.index(glb.len());
            glb[place] = byte;
        }
        if let Ok(mesh) = mesh(&glb) {
            prop_assert!(sound(&mesh));
        }
    }
}
