//! Where the world is seen on the screen, and what lies under a point of the screen.

use crate::math::Vec3;
use crate::render::{Camera, Lens};
use eframe::egui::{Pos2, Rect, Vec2, vec2};
use glam::Mat4;

/// A camera's view in a part of the window.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// The camera.
    pub camera: Camera,
    /// Where its picture stands.
    pub rect: Rect,
    clip: Mat4,
}

/// A line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins, metres.
    pub origin: Vec3,
    /// Unit vector along it.
    pub direction: Vec3,
}

impl Ray {
    /// The point after some metres.
    #[must_use]
    pub fn at(&self, metres: f32) -> Vec3 {
        self.origin + self.direction * metres
    }

    /// Where it meets a plane, if it does so ahead.
    #[must_use]
    pub fn meets(&self, point: Vec3, normal: Vec3) -> Option<Vec3> {
        let toward = self.direction.dot(normal);
        let metres = (point - self.origin).dot(normal) / toward;
        (metres.is_finite() && metres > 0.0).then(|| self.at(metres))
    }
}

impl Projection {
    /// The view of a camera whose picture fills `rect`.
    #[must_use]
    pub fn new(camera: Camera, rect: Rect) -> Self {
        let clip = camera.view_projection(rect.width() / rect.height().max(1.0));
        Self { camera, rect, clip }
    }

    /// Where a point of the world is seen, if it is before the camera; perhaps beyond the picture's edges.
    #[must_use]
    pub fn place(&self, point: Vec3) -> Option<Pos2> {
        if (point - self.camera.eye).dot(self.camera.forward()) <= 0.0 {
            return None;
        }
        let clip = self.clip.project_point3(point);
        let half = self.rect.size() * 0.5;
        let at = self.rect.center() + vec2(clip.x * half.x, -clip.y * half.y);
        (at.x.is_finite() && at.y.is_finite()).then_some(at)
    }

    /// Where a point of the world is seen, if it is in the picture.
    #[must_use]
    pub fn seen(&self, point: Vec3) -> Option<Pos2> {
        self.place(point).filter(|at| self.rect.contains(*at))
    }

    /// The line of sight through a point of the screen.
    #[must_use]
    pub fn ray(&self, at: Pos2) -> Ray {
        let half: Vec2 = self.rect.size() * 0.5;
        let from_middle = at - self.rect.center();
        // In halves of the picture's height.
        let (x, y) = (
            from_middle.x / half.y.max(0.5),
            -from_middle.y / half.y.max(0.5),
        );
        let ([right, up], forward) = (self.camera.sides(), self.camera.forward());
        match self.camera.lens {
            Lens::Perspective(angle) => {
                let tangent = libm::tanf(angle * 0.5);
                let direction = forward + (right * x + up * y) * tangent;
                Ray {
                    origin: self.camera.eye,
                    direction: direction.normalize_or(forward),
                }
            }
            Lens::Orthographic(size) => Ray {
                origin: self.camera.eye + (right * x + up * y) * size,
                direction: forward,
            },
        }
    }

    /// Metres that a point of the screen is wide at a point of the world.
    #[must_use]
    pub fn metres_a_point(&self, at: Vec3) -> f32 {
        let depth = (at - self.camera.eye).dot(self.camera.forward());
        self.metres_a_point_at(depth)
    }

    /// Metres that a point of the screen is wide so many metres before the camera.
    #[must_use]
    pub fn metres_a_point_at(&self, depth: f32) -> f32 {
        let height = match self.camera.lens {
            Lens::Perspective(angle) => 2.0 * depth.max(0.0) * libm::tanf(angle * 0.5),
            Lens::Orthographic(half) => 2.0 * half,
        };
        height / self.rect.height().max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    fn views() -> [Projection; 2] {
        let rect = Rect::from_min_size(pos2(100.0, 50.0), vec2(300.0, 200.0));
        [Lens::Perspective(0.8), Lens::Orthographic(5.0)].map(|lens| {
            let camera = Camera {
                eye: Vec3::new(0.0, 2.0, 10.0),
                target: Vec3::new(0.0, 2.0, 0.0),
                lens,
            };
            Projection::new(camera, rect)
        })
    }

    #[test]
    fn a_point_is_written_where_it_is_seen() {
        let view = views()[0];
        let middle = view.seen(view.camera.target).unwrap();
        assert!((middle - view.rect.center()).length() < 0.01);
        let low = view.seen(Vec3::new(1.0, 0.0, 0.0)).unwrap();
        assert!(low.x > middle.x && low.y > middle.y);
        assert_eq!(view.seen(Vec3::new(0.0, 2.0, 20.0)), None);
        assert_eq!(view.seen(Vec3::new(90.0, 0.0, 0.0)), None);
        assert!(view.place(Vec3::new(90.0, 0.0, 0.0)).is_some());
    }

    #[test]
    fn the_ray_through_where_a_point_is_seen_goes_through_the_point() {
        for view in views() {
            for point in [
                Vec3::new(0.0, 2.0, 0.0),
                Vec3::new(1.5, 0.5, 3.0),
                Vec3::new(-2.0, 3.5, -4.0),
            ] {
                let ray = view.ray(view.place(point).unwrap());
                let along = (point - ray.origin).dot(ray.direction);
                assert!(ray.at(along).distance(point) < 1e-3, "{point} {ray:?}");
                // One point of the screen aside is as wide as it is said to be.
                let wide = view.metres_a_point(point);
                let [right, _] = view.camera.sides();
                let aside = view.place(point + right * wide).unwrap();
                let way = aside - view.place(point).unwrap();
                assert!((way.length() - 1.0).abs() < 1e-2, "{way}");
            }
        }
    }

    #[test]
    fn a_ray_meets_only_what_is_ahead() {
        let ray = Ray {
            origin: Vec3::ZERO,
            direction: Vec3::Z,
        };
        let met = ray.meets(Vec3::new(5.0, 1.0, 3.0), Vec3::Z).unwrap();
        assert!(met.distance(Vec3::Z * 3.0) < 1e-6);
        assert_eq!(ray.meets(-Vec3::Z, Vec3::Z), None);
        assert_eq!(ray.meets(Vec3::X, Vec3::X), None);
    }
}
