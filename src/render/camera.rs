//! Cameras: where one stands, and how a person moves it.

use crate::math::{Bounds, PI, TAU, Vec3};
use glam::{Mat4, Vec4};

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: Vec3,
    /// What it looks at, metres.
    pub target: Vec3,
    /// How it sees.
    pub lens: Lens,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// With this vertical angle of view, radians.
    Perspective(f32),
    /// Without perspective: metres from the middle of the picture to its upper edge.
    Orthographic(f32),
}

/// Nearest distance that a perspective camera sees, as a part of the way to its target.
const NEAR: f32 = 0.002;

/// How much farther than needed a camera stands, so that there is some air around what it shows.
const AIR: f32 = 1.08;

impl Camera {
    /// Unit vector along which it looks.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    /// Unit vectors to the right and up in the picture.
    #[must_use]
    pub fn sides(&self) -> [Vec3; 2] {
        let forward = self.forward();
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        [right, right.cross(forward)]
    }

    /// World to clip space; depth is reversed, 1 near and 0 far. `aspect` is width over height.
    #[must_use]
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        let [right, up] = self.sides();
        let back = -self.forward();
        let row = |v: Vec3| v.extend(-v.dot(self.eye));
        let view = Mat4::from_cols(row(right), row(up), row(back), Vec4::W).transpose();
        let away = self.eye.distance(self.target).max(1e-3);
        let projection = match self.lens {
            Lens::Perspective(angle) => {
                let (sine, cosine) = libm::sincosf(angle * 0.5);
                let focal = cosine / sine.max(1e-4);
                // Infinitely far: depth is near / distance.
                Mat4::from_cols(
                    Vec4::new(focal / aspect, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, focal, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, 0.0, -1.0),
                    Vec4::new(0.0, 0.0, away * NEAR, 0.0),
                )
            }
            Lens::Orthographic(half) => {
                let (near, far) = (-away * 4.0, away * 8.0);
                let depth = 1.0 / (far - near);
                Mat4::from_cols(
                    Vec4::new(1.0 / (half * aspect), 0.0, 0.0, 0.0),
                    Vec4::new(0.0, 1.0 / half, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, depth, 0.0),
                    Vec4::new(0.0, 0.0, far * depth, 1.0),
                )
            }
        };
        projection * view
    }

    /// Height of the picture at a point, metres: what a tree's height is to be divided by.
    #[must_use]
    pub fn height_at(&self, point: Vec3) -> f32 {
        match self.lens {
            Lens::Perspective(angle) => {
                let distance = (point - self.eye).length().max(1e-3);
                2.0 * distance * libm::tanf(angle * 0.5)
            }
            Lens::Orthographic(half) => 2.0 * half,
        }
    }
}

/// A camera that circles a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// What it looks at, metres.
    pub target: Vec3,
    /// Metres from it.
    pub distance: f32,
    /// Turn about the tree, radians; 0 looks along -Z.
    pub azimuth: f32,
    /// Height above the horizon, radians.
    pub elevation: f32,
    /// How it sees; an orthographic lens keeps its own size.
    pub lens: Lens,
}

impl Orbit {
    /// A perspective camera from which points just fill a picture of this aspect (width over height).
    #[must_use]
    pub fn around(points: &[Vec3], azimuth: f32, elevation: f32, angle: f32, aspect: f32) -> Self {
        let bounds = Bounds::of_points(points.iter().copied());
        let target = if bounds.is_empty() {
            Vec3::ZERO
        } else {
            bounds.centre()
        };
        let mut orbit = Self {
            target,
            distance: 1.0,
            azimuth,
            elevation,
            lens: Lens::Perspective(angle),
        };
        // Each point must lie within the picture: its distance sideways tells how far the camera must be.
        let camera = orbit.camera();
        let ([right, up], forward) = (camera.sides(), camera.forward());
        let tangent = libm::tanf(angle * 0.5);
        let needed = |point: &Vec3| {
            let p = *point - target;
            let wide = p.dot(right).abs() / (tangent * aspect);
            let high = p.dot(up).abs() / tangent;
            wide.max(high) - p.dot(forward)
        };
        orbit.distance = points.iter().map(needed).fold(0.1, f32::max) * AIR;
        orbit
    }

    /// The camera now; never below the ground.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let (sine, cosine) = libm::sincosf(self.elevation);
        let (side, front) = libm::sincosf(self.azimuth);
        let out = Vec3::new(side * cosine, sine, front * cosine);
        let mut eye = self.target + out * self.distance;
        eye.y = eye.y.max(0.02 * self.distance);
        Camera {
            eye,
            target: self.target,
            lens: self.lens,
        }
    }

    /// Turns by parts of the picture dragged to the right and down.
    pub fn drag(&mut self, right: f32, down: f32) {
        self.azimuth = libm::fmodf(self.azimuth - right * PI, TAU);
        self.elevation = (self.elevation + down * PI * 0.75).clamp(-0.1, 1.55);
    }

    /// Shifts what it looks at, by parts of the picture's height dragged to the right and down.
    pub fn pan(&mut self, right: f32, down: f32) {
        let camera = self.camera();
        let [x, y] = camera.sides();
        let height = camera.height_at(self.target);
        self.target += (y * down - x * right) * height;
        self.target.y = self.target.y.max(0.0);
    }

    /// Goes nearer by a factor below 1, farther by one above.
    pub fn zoom(&mut self, factor: f32) {
        self.distance = (self.distance * factor).clamp(0.01, 1e5);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(lens: Lens) -> Camera {
        Camera {
            eye: Vec3::new(3.0, 2.0, 10.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            lens,
        }
    }

    #[test]
    fn the_target_is_in_the_middle_and_nearer_points_have_more_depth() {
        for lens in [Lens::Perspective(0.8), Lens::Orthographic(3.0)] {
            let camera = camera(lens);
            let clip = camera.view_projection(1.5);
            let at = |p: Vec3| clip.project_point3(p);
            let middle = at(camera.target);
            assert!(middle.x.abs() < 1e-5 && middle.y.abs() < 1e-5, "{middle}");
            let near = at(camera.eye + camera.forward() * 5.0);
            assert!(near.z > middle.z && middle.z > 0.0 && near.z < 1.0);
            let [right, up] = camera.sides();
            assert!(at(camera.target + right).x > 0.0);
            assert!(at(camera.target + up).y > 0.0);
        }
    }

    #[test]
    fn a_point_at_the_upper_edge_stands_half_a_picture_above_the_middle() {
        for lens in [Lens::Perspective(0.8), Lens::Orthographic(3.0)] {
            let camera = camera(lens);
            let [_, up] = camera.sides();
            let half = camera.height_at(camera.target) * 0.5;
            let top = camera
                .view_projection(1.0)
                .project_point3(camera.target + up * half);
            assert!((top.y - 1.0).abs() < 1e-4, "{lens:?}: {top}");
        }
    }

    #[test]
    fn an_orbit_around_bounds_shows_all_corners_and_wastes_little() {
        let bounds = Bounds {
            min: Vec3::new(-2.0, 0.0, -3.0),
            max: Vec3::new(2.0, 8.0, 3.0),
        };
        for azimuth in [0.0, 0.7, 2.0, 4.0] {
            for aspect in [0.5, 1.0, 2.0] {
                let orbit = Orbit::around(&bounds.corners(), azimuth, 0.2, 0.6, aspect);
                let clip = orbit.camera().view_projection(aspect);
                let corners = bounds.corners().map(|c| clip.project_point3(c));
                let reach = |p: Vec3| p.x.abs().max(p.y.abs());
                let farthest = corners.map(reach).into_iter().fold(0.0, f32::max);
                assert!(
                    (0.85..=1.0).contains(&farthest),
                    "{azimuth} {aspect}: {farthest}"
                );
            }
        }
    }

    #[test]
    fn no_dragging_takes_the_camera_below_the_ground() {
        let bounds = Bounds {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        };
        let mut orbit = Orbit::around(&bounds.corners(), 0.0, 0.2, 0.6, 1.0);
        for _ in 0..50 {
            orbit.drag(0.3, -0.4);
            orbit.pan(0.1, -0.3);
            assert!(orbit.camera().eye.y > 0.0 && orbit.camera().eye.is_finite());
        }
    }
}
