//! Every shader is valid, and its structs lie in memory as ours do; no GPU is needed to see it.

#![cfg(feature = "gpu")]

use core::mem::{offset_of, size_of};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use pleach::gpu::shader::{self, Source};
use pleach::gpu_bake::layout;
use pleach::math::linear_from_srgb;
use pleach::render::LEVEL_COLOURS;
use pleach::render::forest::{Cull, ForestTree, Kind};
use pleach::render::uniforms::{Frame, Model};
use pleach::shadow;

fn parsed(source: &Source) -> naga::Module {
    let text = source.text();
    match naga::front::wgsl::parse_str(&text) {
        Ok(module) => module,
        Err(e) => panic!("{}: {}", source.name, e.emit_to_string(&text)),
    }
}

#[test]
fn every_shader_is_valid() {
    for source in &shader::ALL {
        let module = parsed(source);
        let mut validator =
            Validator::new(ValidationFlags::all(), Capabilities::MULTISAMPLED_SHADING);
        if let Err(e) = validator.validate(&module) {
            panic!("{}: {}", source.name, e.emit_to_string(&source.text()));
        }
        assert!(!module.entry_points.is_empty(), "{}", source.name);
    }
}

/// Offsets of a struct's members by name, and its size.
fn layout_of(source: &Source, name: &str) -> (Vec<(String, u32)>, u32) {
    let module = parsed(source);
    let found = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, found)) = found else {
        panic!("{} has no struct {name}", source.name);
    };
    let naga::TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is no struct");
    };
    let member = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset);
    (members.iter().map(member).collect(), *span)
}

macro_rules! members {
    ($type:ty: $($name:ident)*) => {
        (
            vec![$((stringify!($name).to_owned(), u32::try_from(offset_of!($type, $name)).unwrap())),*],
            u32::try_from(size_of::<$type>()).unwrap(),
        )
    };
}

#[test]
fn structs_lie_in_memory_as_the_shaders_read_them() {
    let frame = members!(Frame: view_projection inverse_view_projection light_projection eye forward
        sun sun_light sky_light ground_light zenith horizon ground wind clock viewport modes);
    let of_frames = |s: &&Source| s.text().contains("struct Frame {");
    let frames: Vec<&Source> = shader::ALL.iter().filter(of_frames).collect();
    assert!(frames.len() >= 5);
    for source in frames {
        assert_eq!(layout_of(source, "Frame"), frame, "{}", source.name);
    }
    let model = members!(Model: centre extent volume_origin volume_scale shadow_rects rig);
    for source in [
        &shader::TREES,
        &shader::GROUNDS,
        &shader::FORESTS,
        &shader::FOREST_GROUNDS,
    ] {
        assert_eq!(layout_of(source, "Model"), model, "{}", source.name);
    }
    let cull = members!(Cull: planes eye sight shade counts orders);
    assert_eq!(layout_of(&shader::CULLS, "Cull"), cull);
    let kind = members!(Kind: shape bins casts switches);
    assert_eq!(layout_of(&shader::CULLS, "Kind"), kind);
    let (members, size) = members!(ForestTree: place size turn look model crowded);
    for source in [&shader::CULLS, &shader::FORESTS, &shader::FOREST_GROUNDS] {
        let (read, span) = layout_of(source, "Planted");
        let offsets = |members: &[(String, u32)]| members.iter().map(|m| m.1).collect::<Vec<_>>();
        assert_eq!(
            (offsets(&read), span),
            (offsets(&members), size),
            "{}",
            source.name
        );
    }
}

/// The numbers of a constant that is an array of vectors.
fn table(source: &Source, name: &str) -> Vec<f32> {
    fn gather(module: &naga::Module, at: naga::Handle<naga::Expression>, into: &mut Vec<f32>) {
        match &module.global_expressions[at] {
            naga::Expression::Compose { components, .. } => {
                components.iter().for_each(|c| gather(module, *c, into));
            }
            naga::Expression::Literal(naga::Literal::F32(number)) => into.push(*number),
            other => panic!("{other:?}"),
        }
    }
    let module = parsed(source);
    let mut constants = module.constants.iter();
    let found = constants.find(|(_, constant)| constant.name.as_deref() == Some(name));
    let (_, constant) = found.unwrap_or_else(|| panic!("{} has no {name}", source.name));
    let mut numbers = Vec::new();
    gather(&module, constant.init, &mut numbers);
    numbers
}

#[test]
fn levels_have_the_colours_that_programs_name() {
    let linear = LEVEL_COLOURS.iter().flatten();
    let linear: Vec<f32> = linear.map(|&byte| linear_from_srgb(byte)).collect();
    for source in [&shader::TREES, &shader::FORESTS] {
        let found = table(source, "LEVEL_COLOURS");
        assert_eq!(found.len(), linear.len());
        for (found, wanted) in found.iter().zip(&linear) {
            assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
        }
    }
}

#[test]
fn structs_of_baking_lie_in_memory_as_the_shaders_read_them() {
    let shot = members!(layout::Shot: right up toward centre half depth samples place corner cell size column);
    let sheet = members!(layout::Sheet: size supersample longest bark foliage);
    for source in [
        &shader::CAPTURES_LIGHT,
        &shader::CAPTURES_SEEN,
        &shader::CAPTURES_TEXELS,
    ] {
        assert_eq!(layout_of(source, "Shot"), shot, "{}", source.name);
        assert_eq!(layout_of(source, "Sheet"), sheet, "{}", source.name);
    }
    let job = members!(layout::Job: size row bark leaves samples first a_light groups coverage mips masks);
    assert_eq!(layout_of(&shader::SHADOWS, "Job"), job);
    let projection = members!(layout::Projection: origin lean a_metre along across share number);
    assert_eq!(layout_of(&shader::SHADOWS, "Projection"), projection);
    let leaf = members!(shadow::Leaf: corners uv uv_area last_level key);
    assert_eq!(layout_of(&shader::SHADOWS, "Leaf"), leaf);
}
