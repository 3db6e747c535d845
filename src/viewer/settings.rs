//! All that a person sets in the window, as plain data.

use super::level::Choice;
use crate::math::Vec3;
use crate::render::{Filter, LightMode, Setting, ViewMode};
use crate::wind::Wind;

/// What stands in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// One tree.
    #[default]
    Single,
    /// Each LOD once, side by side, the finest on the left.
    Strip,
    /// Many.
    Forest,
}

/// Where the sun stands, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Turn about the tree, 0..=360; 0 is +Z, 90 is +X.
    pub azimuth: f32,
    /// Height over the horizon, 2..=90.
    pub elevation: f32,
}

/// Lowest sun: lower ones cast shadows without end.
pub const LOWEST_SUN: f32 = 2.0;

impl Default for Sun {
    fn default() -> Self {
        Self {
            azimuth: 48.0,
            elevation: 46.0,
        }
    }
}

impl Sun {
    /// Unit vector toward it.
    #[must_use]
    pub fn toward(self) -> Vec3 {
        let (side, front) = libm::sincosf(self.azimuth.to_radians());
        let (up, level) = libm::sincosf(self.elevation.to_radians());
        Vec3::new(side * level, up, front * level)
    }

    /// Moves it by parts of the picture's height dragged to the right and up, for a camera that looks along
    /// `forward`: a drag to the right takes the sun to the right.
    pub fn drag(&mut self, right: f32, up: f32, forward: Vec3) {
        // A sun behind the picture goes to the right by the turn that takes one before it to the left.
        let ahead = self.toward().dot(forward) > 0.0;
        let turn = if ahead { -right } else { right };
        self.azimuth = libm::fmodf(self.azimuth + turn * 180.0 + 360.0, 360.0);
        self.elevation = (self.elevation + up * 90.0).clamp(LOWEST_SUN, 90.0);
    }
}

/// Wind, and the clock by which it blows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breeze {
    /// True if it blows.
    pub on: bool,
    /// False holds the clock.
    pub playing: bool,
    /// Seconds.
    pub time: f32,
    /// Where it blows to, degrees about +Y as the sun's.
    pub direction: f32,
    /// Metres a second.
    pub speed: f32,
    /// 0 is steady, 1 comes in gusts.
    pub gustiness: f32,
}

impl Default for Breeze {
    fn default() -> Self {
        Self {
            on: false,
            playing: true,
            time: 0.0,
            direction: 70.0,
            speed: Wind::default().speed_m_s,
            gustiness: Wind::default().gustiness,
        }
    }
}

impl Breeze {
    /// True if trees move by it from frame to frame.
    #[must_use]
    pub fn moves(self) -> bool {
        self.on && self.playing && self.speed > 0.0
    }

    /// As a scene has it.
    #[must_use]
    pub fn wind(self) -> Wind {
        let (x, z) = libm::sincosf(self.direction.to_radians());
        Wind {
            direction: glam::Vec2::new(x, z),
            speed_m_s: if self.on { self.speed } else { 0.0 },
            gustiness: self.gustiness,
        }
    }
}

/// All of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What stands in the picture.
    pub arrangement: Arrangement,
    /// How LODs are chosen.
    pub choice: Choice,
    /// Where the line between the finest LOD of one tree and the chosen one stands, as a part of the picture's
    /// width; none if only the chosen one is shown.
    pub compare: Option<f32>,
    /// What is shown of the trees.
    pub view: ViewMode,
    /// How trees are blended with their backdrop.
    pub filter: Filter,
    /// How light is worked out.
    pub light: LightMode,
    /// The sun.
    pub sun: Sun,
    /// The wind.
    pub breeze: Breeze,
    /// True to show a person beside the tree.
    pub person: bool,
    /// True to turn about the tree.
    pub turntable: bool,
    /// Trees in the forest.
    pub trees: usize,
    /// True to lower the resolution while something moves, if it would be slow otherwise.
    pub adapt: bool,
    /// True to show what keys and mouse do.
    pub help: bool,
    /// True to show the panel.
    pub panel: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            arrangement: Arrangement::Single,
            choice: Choice::ByDistance,
            compare: None,
            view: ViewMode::Lit,
            filter: Filter::None,
            light: LightMode::Product,
            sun: Sun::default(),
            breeze: Breeze::default(),
            person: false,
            turntable: false,
            trees: 400,
            adapt: true,
            help: false,
            panel: true,
        }
    }
}

/// Views in the order in which a key goes through them, with their names.
pub const VIEWS: [(ViewMode, &str); 7] = [
    (ViewMode::Lit, "Lit"),
    (ViewMode::Lods, "LOD colours"),
    (ViewMode::Levels, "Level colours"),
    (ViewMode::Wire, "Wireframe"),
    (ViewMode::Overdraw, "Overdraw"),
    (ViewMode::Normals, "Normals"),
    (ViewMode::Albedo, "Albedo"),
];

impl Settings {
    /// Light and ground as a scene has them.
    #[must_use]
    pub fn setting(&self) -> Setting {
        Setting {
            sun: self.sun.toward(),
            light: self.light,
            ..Setting::default()
        }
    }

    /// Goes on to the next view.
    pub fn next_view(&mut self) {
        let now = VIEWS.iter().position(|&(view, _)| view == self.view);
        self.view = VIEWS[now.map_or(0, |at| (at + 1) % VIEWS.len())].0;
    }

    /// Shows this arrangement, or one tree if it is shown already.
    pub fn toggle(&mut self, arrangement: Arrangement) {
        self.arrangement = if self.arrangement == arrangement {
            Arrangement::Single
        } else {
            arrangement
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_takes_the_sun_to_the_right_of_the_picture_on_both_sides_of_the_camera() {
        // Looking along -Z, the right of the picture is +X.
        let forward = Vec3::NEG_Z;
        for azimuth in [0.0, 180.0, 20.0, 160.0] {
            let mut sun = Sun {
                azimuth,
                elevation: 30.0,
            };
            let before = sun.toward().x;
            sun.drag(0.05, 0.0, forward);
            assert!(sun.toward().x > before, "{azimuth}");
        }
    }

    #[test]
    fn no_drag_takes_the_sun_below_the_horizon_or_out_of_the_circle() {
        let mut sun = Sun::default();
        for _ in 0..30 {
            sun.drag(0.7, -0.4, Vec3::NEG_Z);
            assert!(sun.toward().y > 0.0 && (0.0..360.0).contains(&sun.azimuth));
        }
        for _ in 0..30 {
            sun.drag(-0.7, 0.4, Vec3::NEG_Z);
            assert!(sun.elevation <= 90.0 && (0.0..360.0).contains(&sun.azimuth));
        }
    }

    #[test]
    fn the_key_of_views_goes_through_all_and_comes_back() {
        let mut settings = Settings::default();
        let mut seen = Vec::new();
        for _ in VIEWS {
            settings.next_view();
            assert!(!seen.contains(&settings.view));
            seen.push(settings.view);
        }
        assert_eq!(settings.view, ViewMode::Lit);
    }

    #[test]
    fn wind_that_is_off_is_still() {
        let mut breeze = Breeze::default();
        assert_eq!(breeze.wind().speed_m_s, 0.0);
        assert!(!breeze.moves());
        breeze.on = true;
        assert!(breeze.moves() && breeze.wind().speed_m_s > 0.0);
        breeze.playing = false;
        assert!(!breeze.moves() && breeze.wind().speed_m_s > 0.0);
    }
}
