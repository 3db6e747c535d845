//! The shaders, as text: a module is a list of files under `shaders/`, joined.
//!
//! Files that other files build upon hold functions and structs only, so that they can be ported one by one.

/// One shader module: its name and the files that it is joined from.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Name in error messages.
    pub name: &'static str,
    /// Texts, in order.
    pub files: &'static [&'static str],
}

const FRAME: &str = include_str!("../../shaders/frame.wgsl");
const WIND: &str = include_str!("../../shaders/wind.wgsl");
const LIGHT: &str = include_str!("../../shaders/light.wgsl");
const TREE: &str = include_str!("../../shaders/tree.wgsl");
const GROUND: &str = include_str!("../../shaders/ground.wgsl");
const FOREST: &str = include_str!("../../shaders/forest.wgsl");
const FOREST_TREES: &str = include_str!("../../shaders/forest_trees.wgsl");
const FOREST_GROUND: &str = include_str!("../../shaders/forest_ground.wgsl");
const CULL: &str = include_str!("../../shaders/cull.wgsl");
const PRESENT: &str = include_str!("../../shaders/present.wgsl");
const SHOW: &str = include_str!("../../shaders/show.wgsl");
const CAPTURE: &str = include_str!("../../shaders/capture.wgsl");
const CAPTURE_SEEN: &str = include_str!("../../shaders/capture_seen.wgsl");
const CAPTURE_TEXELS: &str = include_str!("../../shaders/capture_texels.wgsl");
const CAPTURE_LIGHT: &str = include_str!("../../shaders/capture_light.wgsl");
const SHADOW_BAKE: &str = include_str!("../../shaders/shadow_bake.wgsl");

/// Trees: colour, depth for the shadow map, and the views that show how they are made.
pub const TREES: Source = Source {
    name: "trees",
    files: &[FRAME, LIGHT, WIND, TREE],
};

/// Sky, ground, and the baked shadows on it.
pub const GROUNDS: Source = Source {
    name: "ground",
    files: &[FRAME, LIGHT, WIND, GROUND],
};

/// From linear light to the screen, with the filters.
pub const PRESENTS: Source = Source {
    name: "present",
    files: &[FRAME, PRESENT],
};

/// A finished picture in a window.
pub const SHOWS: Source = Source {
    name: "show",
    files: &[SHOW],
};

/// Trees of a forest.
pub const FORESTS: Source = Source {
    name: "forest",
    files: &[FRAME, LIGHT, WIND, TREE, FOREST, FOREST_TREES],
};

/// Baked shadows of a forest.
pub const FOREST_GROUNDS: Source = Source {
    name: "ground of a forest",
    files: &[FRAME, LIGHT, WIND, GROUND, FOREST, FOREST_GROUND],
};

/// Which trees of a forest are drawn.
pub const CULLS: Source = Source {
    name: "cull",
    files: &[CULL],
};

/// Captures: the surface that each sample sees.
pub const CAPTURES_SEEN: Source = Source {
    name: "captures, what is seen",
    files: &[CAPTURE, CAPTURE_SEEN],
};

/// Captures: from samples to texels.
pub const CAPTURES_TEXELS: Source = Source {
    name: "captures, texels",
    files: &[CAPTURE, CAPTURE_TEXELS],
};

/// Captures: light inside crowns.
pub const CAPTURES_LIGHT: Source = Source {
    name: "captures, light",
    files: &[CAPTURE, CAPTURE_LIGHT],
};

/// Soft ground shadows.
pub const SHADOWS: Source = Source {
    name: "baked shadows",
    files: &[SHADOW_BAKE],
};

/// All modules.
pub const ALL: [Source; 11] = [
    TREES,
    GROUNDS,
    PRESENTS,
    SHOWS,
    FORESTS,
    FOREST_GROUNDS,
    CULLS,
    CAPTURES_SEEN,
    CAPTURES_TEXELS,
    CAPTURES_LIGHT,
    SHADOWS,
];

impl Source {
    /// The whole text.
    #[must_use]
    pub fn text(&self) -> String {
        self.files.join("\n")
    }

    /// The module on a device.
    #[must_use]
    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.text().into()),
        })
    }
}
