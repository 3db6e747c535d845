//! How a person moves the camera: around what is shown, or on foot.

use crate::math::{PI, TAU, Vec3};
use crate::render::{Camera, Lens, Orbit, PORTRAIT};

/// Height of a walker's eyes over the ground, metres.
pub const EYE: f32 = 1.7;

/// Metres from a walker's eyes to the point that it looks at; lenses see nothing nearer than a part of it.
const GAZE: f32 = 10.0;

/// Highest and lowest that a walker looks, radians from the horizon.
const STEEPEST: f32 = 1.5;

/// Metres a second of a brisk walk, at which walkers set out.
const BRISK: f32 = 2.0;

/// Slowest and fastest walk, metres a second.
const SPEEDS: [f32; 2] = [0.25, 64.0];

/// How much faster a walker is that hurries.
const HURRY: f32 = 4.0;

/// Longest step in seconds: a slow frame is no leap through the tree.
const LONGEST_STEP: f32 = 0.1;

/// How the camera is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stance {
    /// Around a point.
    #[default]
    Orbit,
    /// On the ground.
    Walk,
}

/// A person on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walker {
    /// Where it stands (x, z), metres.
    pub place: [f32; 2],
    /// Turn of its gaze about +Y, radians; 0 looks along -Z.
    pub turn: f32,
    /// Height of its gaze over the horizon, radians.
    pub pitch: f32,
    /// Metres a second.
    pub speed: f32,
}

impl Walker {
    fn gaze(&self) -> Vec3 {
        let (up, level) = libm::sincosf(self.pitch);
        let (side, front) = libm::sincosf(self.turn);
        Vec3::new(-side * level, up, -front * level)
    }

    fn camera(&self) -> Camera {
        let eye = Vec3::new(self.place[0], EYE, self.place[1]);
        Camera {
            eye,
            target: eye + self.gaze() * GAZE,
            lens: Lens::Perspective(PORTRAIT * 1.7),
        }
    }
}

/// Which way the keys of walking point: parts of the walker's speed ahead and to the right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steps {
    /// Ahead, -1..=1.
    pub ahead: f32,
    /// To the right, -1..=1.
    pub aside: f32,
    /// True to hurry.
    pub hurry: bool,
}

impl Steps {
    /// True if a key is down.
    #[must_use]
    pub fn any(self) -> bool {
        self.ahead != 0.0 || self.aside != 0.0
    }
}

/// The camera and how it is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// How the camera is held.
    pub stance: Stance,
    /// Around a point.
    pub orbit: Orbit,
    /// On the ground.
    pub walker: Walker,
}

impl Rig {
    /// A camera around points, seen from the front and a little from above.
    #[must_use]
    pub fn around(points: &[Vec3], aspect: f32) -> Self {
        let orbit = Orbit::around(points, 0.6, 0.09, PORTRAIT, aspect);
        Self {
            stance: Stance::Orbit,
            orbit,
            walker: Walker {
                place: [0.0, 0.0],
                turn: 0.0,
                pitch: 0.0,
                speed: BRISK,
            },
        }
    }

    /// The camera now.
    #[must_use]
    pub fn camera(&self) -> Camera {
        match self.stance {
            Stance::Orbit => self.orbit.camera(),
            Stance::Walk => self.walker.camera(),
        }
    }

    /// Shows all of some points, from the side that is looked from now.
    pub fn frame(&mut self, points: &[Vec3], aspect: f32) {
        let Orbit {
            azimuth, elevation, ..
        } = self.orbit;
        self.orbit = Orbit::around(points, azimuth, elevation, PORTRAIT, aspect);
        self.stance = Stance::Orbit;
    }

    /// Takes the camera in another way, from about where it is.
    pub fn hold(&mut self, stance: Stance) {
        if stance == self.stance {
            return;
        }
        match stance {
            Stance::Walk => {
                let camera = self.orbit.camera();
                let forward = camera.forward();
                self.walker.place = [camera.eye.x, camera.eye.z];
                self.walker.turn = libm::atan2f(-forward.x, -forward.z);
                // Up to what was looked at, from eyes that are lower now.
                let away = camera.target - camera.eye.with_y(EYE);
                let level = libm::hypotf(away.x, away.z).max(0.1);
                self.walker.pitch = libm::atan2f(away.y, level).clamp(-STEEPEST, STEEPEST);
            }
            Stance::Orbit => self.orbit.azimuth = self.walker.turn,
        }
        self.stance = stance;
    }

    /// Turns by parts of the picture's height dragged to the right and down.
    pub fn turn(&mut self, right: f32, down: f32) {
        match self.stance {
            Stance::Orbit => self.orbit.drag(right, down),
            Stance::Walk => {
                let walker = &mut self.walker;
                walker.turn = libm::fmodf(walker.turn + right * PI * 0.5, TAU);
                walker.pitch = (walker.pitch + down * PI * 0.5).clamp(-STEEPEST, STEEPEST);
            }
        }
    }

    /// Shifts by parts of the picture's height dragged to the right and down.
    pub fn pan(&mut self, right: f32, down: f32) {
        match self.stance {
            Stance::Orbit => self.orbit.pan(right, down),
            Stance::Walk => self.go(-right * GAZE, down * GAZE),
        }
    }

    /// Goes nearer by a factor below 1, farther by one above.
    pub fn zoom(&mut self, factor: f32) {
        match self.stance {
            Stance::Orbit => self.orbit.zoom(factor),
            Stance::Walk => self.go(0.0, (1.0 - factor) * GAZE),
        }
    }

    /// Walks for some seconds; takes the camera on foot if it is not.
    pub fn walk(&mut self, steps: Steps, seconds: f32) {
        if !steps.any() {
            return;
        }
        self.hold(Stance::Walk);
        let pace = self.walker.speed * if steps.hurry { HURRY } else { 1.0 };
        let long = libm::hypotf(steps.ahead, steps.aside).max(1.0);
        let way = pace * seconds.clamp(0.0, LONGEST_STEP) / long;
        self.go(steps.aside * way, steps.ahead * way);
    }

    /// Walks faster by a factor from now on.
    pub fn hasten(&mut self, factor: f32) {
        let speed = &mut self.walker.speed;
        *speed = (*speed * factor).clamp(SPEEDS[0], SPEEDS[1]);
    }

    /// Metres on the ground, to the right and ahead of where the walker looks.
    fn go(&mut self, right: f32, ahead: f32) {
        let walker = &mut self.walker;
        let (side, front) = libm::sincosf(walker.turn);
        walker.place[0] += right * front - ahead * side;
        walker.place[1] += -right * side - ahead * front;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig() -> Rig {
        let points = [Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 8.0, 3.0)];
        Rig::around(&points, 1.5)
    }

    const AHEAD: Steps = Steps {
        ahead: 1.0,
        aside: 0.0,
        hurry: false,
    };

    #[test]
    fn a_walker_sets_out_where_the_camera_stood_and_looks_at_what_it_showed() {
        let mut rig = rig();
        let before = rig.camera();
        rig.hold(Stance::Walk);
        let after = rig.camera();
        assert!((after.eye.x - before.eye.x).abs() < 1e-4);
        assert!((after.eye.z - before.eye.z).abs() < 1e-4);
        assert_eq!(after.eye.y, EYE);
        let toward = (before.target - after.eye).normalize_or(Vec3::Y);
        assert!(after.forward().dot(toward) > 0.9999);
    }

    #[test]
    fn walking_ahead_comes_nearer_and_never_leaves_the_ground() {
        let mut rig = rig();
        let far = rig.camera().eye.with_y(0.0).length();
        for _ in 0..20 {
            rig.walk(AHEAD, 0.1);
            assert_eq!(rig.camera().eye.y, EYE);
        }
        let near = rig.camera().eye.with_y(0.0).length();
        // Two seconds at two metres a second.
        assert!((far - near - 4.0).abs() < 0.01, "{far} {near}");
    }

    #[test]
    fn walking_aside_goes_to_the_right_of_the_picture() {
        let mut rig = rig();
        rig.hold(Stance::Walk);
        let before = rig.camera();
        let steps = Steps {
            aside: 1.0,
            ..Steps::default()
        };
        rig.walk(steps, 0.1);
        let way = rig.camera().eye - before.eye;
        assert!(way.dot(before.sides()[0]) > 0.19, "{way}");
    }

    #[test]
    fn a_slow_frame_is_no_leap_and_two_keys_are_not_faster_than_one() {
        let mut rig = rig();
        rig.hold(Stance::Walk);
        let before = rig.camera().eye;
        let steps = Steps {
            ahead: 1.0,
            aside: 1.0,
            hurry: false,
        };
        rig.walk(steps, 30.0);
        let way = rig.camera().eye.distance(before);
        assert!((way - BRISK * LONGEST_STEP).abs() < 1e-3, "{way}");
        rig.walk(
            Steps {
                hurry: true,
                ..AHEAD
            },
            0.1,
        );
        assert!(rig.camera().eye.distance(before) > 3.0 * way);
    }

    #[test]
    fn no_pitch_turns_a_walker_upside_down() {
        let mut rig = rig();
        rig.hold(Stance::Walk);
        for _ in 0..50 {
            rig.turn(0.3, 0.5);
            assert!(rig.camera().sides()[1].y > 0.0);
        }
    }

    #[test]
    fn framing_keeps_the_side_that_is_looked_from() {
        let mut rig = rig();
        rig.turn(0.2, 0.1);
        let before = rig.camera().forward();
        rig.zoom(0.2);
        rig.frame(
            &[Vec3::new(-30.0, 0.0, -3.0), Vec3::new(30.0, 8.0, 3.0)],
            1.5,
        );
        assert!(rig.camera().forward().dot(before) > 0.9999);
        assert!(rig.orbit.distance > 40.0);
    }

    #[test]
    fn the_speed_of_a_walker_has_bounds() {
        let mut rig = rig();
        for _ in 0..40 {
            rig.hasten(2.0);
        }
        assert_eq!(rig.walker.speed, SPEEDS[1]);
        for _ in 0..40 {
            rig.hasten(0.5);
        }
        assert_eq!(rig.walker.speed, SPEEDS[0]);
    }
}
