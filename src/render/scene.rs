//! What a frame shows, as plain data.

use super::camera::Camera;
use super::uniforms::Instance;
use crate::math::{Vec2, Vec3};
use crate::wind::Wind;

/// Light, air and ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Toward the sun; need not be unit.
    pub sun: Vec3,
    /// Brightness of the sun, a factor; 1 is a clear day.
    pub sun_strength: f32,
    /// Brightness of the sky, a factor.
    pub sky_strength: f32,
    /// Factor on all light before tone mapping.
    pub exposure: f32,
    /// How light is worked out.
    pub light: LightMode,
    /// How far foliage normals bend to those of a round crown, 0..=1.
    pub roundness: f32,
    /// How much light passes leaves, a factor.
    pub translucency: f32,
    /// How dark baked shadows on the ground are, 0..=1.
    pub ground_shadows: f32,
    /// True to shade the trees by a shadow map; else their light volumes do it.
    pub shadow_map: bool,
    /// True to turn leaves to the sun in the shadow map (Candussi et al., section 2.1), which makes crowns
    /// denser in it than they are; false to leave them as they hang.
    pub leaves_face_sun: bool,
    /// Albedo of the ground, linear.
    pub ground: Vec3,
    /// False for trees alone, on nothing.
    pub backdrop: bool,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            sun: Vec3::new(0.62, 0.85, 0.55),
            sun_strength: 1.0,
            sky_strength: 1.0,
            exposure: 1.3,
            light: LightMode::Product,
            roundness: 0.45,
            translucency: 1.0,
            ground_shadows: 0.9,
            shadow_map: true,
            leaves_face_sun: false,
            ground: Vec3::new(0.06, 0.078, 0.027),
            backdrop: true,
        }
    }
}

/// How light is worked out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightMode {
    /// Sun, sky and light that passes leaves, each times what stands in its way.
    #[default]
    Product,
    /// The sum of vertex light, density, shadow map and occluder depth of Candussi et al., section 2.1.
    FourFactors,
}

/// What is shown of the trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewMode {
    /// The picture.
    #[default]
    Lit,
    /// A colour for each LOD.
    Lods,
    /// Normals in the world.
    Normals,
    /// Colour without light.
    Albedo,
    /// How many layers cover each pixel.
    Overdraw,
    /// Edges of triangles.
    Wire,
    /// A colour for each level: [`level_colour`].
    Levels,
}

/// Colours of the levels in [`ViewMode::Levels`], sRGB; deeper ones begin anew. Neighbours differ in hue and in
/// lightness. `LEVEL_COLOURS` of `tree.wgsl` holds the same, linear.
pub const LEVEL_COLOURS: [[u8; 3]; 8] = [
    [214, 126, 44],
    [86, 166, 232],
    [240, 216, 76],
    [158, 84, 196],
    [92, 190, 92],
    [216, 72, 78],
    [64, 196, 186],
    [238, 146, 190],
];

/// The colour of the level with a number in the script, from the trunk on; sRGB.
#[must_use]
pub const fn level_colour(level: usize) -> [u8; 3] {
    LEVEL_COLOURS[level % LEVEL_COLOURS.len()]
}

/// How trees are blended with their backdrop (Candussi et al., section 2.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// As drawn.
    #[default]
    None,
    /// A smaller auxiliary picture, enlarged by bilinear filtering.
    Bilinear,
    /// Each pixel's alpha is the mean of nine.
    Alpha,
    /// Both.
    Combined,
}

/// No wind; it would blow along +X.
pub const CALM: Wind = Wind {
    direction: Vec2::X,
    speed_m_s: 0.0,
    gustiness: 0.7,
};

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// From where it is seen.
    pub camera: Camera,
    /// Light, air and ground.
    pub setting: Setting,
    /// Wind.
    pub wind: Wind,
    /// Seconds.
    pub time: f32,
    /// What is shown of the trees.
    pub view: ViewMode,
    /// How trees are blended with their backdrop.
    pub filter: Filter,
    /// The trees, in groups of one model and LOD.
    pub groups: Vec<Group>,
}

/// Trees of one model that are drawn with the same LOD.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Index of the model.
    pub model: usize,
    /// Index of its LOD.
    pub lod: usize,
    /// Each tree.
    pub trees: Vec<Instance>,
}

impl Instance {
    /// A tree at a place on the ground, turned by `turn` radians, with nothing else changed.
    #[must_use]
    pub fn at(place: Vec3, turn: f32, size: f32) -> Self {
        let (sine, cosine) = libm::sincosf(turn);
        Self {
            place: place.extend(size).to_array(),
            turn: [cosine, sine, 0.0, 1.0],
            tint: [1.0; 4],
            marks: [0.0, 1.0, 0.0, 0.0],
        }
    }
}
