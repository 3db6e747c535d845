//! Scan conversion: which pixel centres a triangle covers.
//!
//! Half-space test with the top-left rule, so that a pixel centre on an edge shared by two triangles
//! belongs to exactly one of them. Used by the captures, the preview and the shadows.

use crate::math::{Vec2, floor_to_u32};

/// Part of an image: columns `x0..x1` and rows `y0..y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clip {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Column past the last.
    pub x1: u32,
    /// Row past the last.
    pub y1: u32,
}

/// Calls `visit(x, y, [b0, b1, b2])` for every pixel centre inside the triangle and the clip.
///
/// `corners` are in pixels (centre of the first pixel at 0.5, 0.5; y down), of either winding. The
/// weights `b` sum to one and are the corners' shares at the centre. Degenerate triangles, and
/// triangles with a NaN corner, cover nothing.
#[inline]
pub fn triangle(corners: [Vec2; 3], clip: Clip, mut visit: impl FnMut(u32, u32, [f32; 3])) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    if area.is_nan() || area.abs() <= 1e-12 {
        return;
    }
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    // First and one past the last pixel whose centre can be inside.
    let x0 = floor_to_u32(low.x - 0.5).max(clip.x0);
    let y0 = floor_to_u32(low.y - 0.5).max(clip.y0);
    let x1 = floor_to_u32(high.x + 0.5).min(clip.x1);
    let y1 = floor_to_u32(high.y + 0.5).min(clip.y1);
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    let flip = if area < 0.0 { -1.0 } else { 1.0 };
    let inverse = 1.0 / area.abs();
    let edges = [
        Edge::new(b, c, flip),
        Edge::new(c, a, flip),
        Edge::new(a, b, flip),
    ];
    for y in y0..y1 {
        #[expect(
            clippy::cast_precision_loss,
            reason = "pixel coordinates are far below 2^24"
        )]
        let py = y as f32 + 0.5;
        // Solve each edge for x on this row, so that the inner loop visits covered pixels only.
        let mut enter = x0;
        let mut leave = x1;
        for edge in &edges {
            edge.narrow(py, &mut enter, &mut leave);
        }
        for x in enter..leave {
            #[expect(
                clippy::cast_precision_loss,
                reason = "pixel coordinates are far below 2^24"
            )]
            let px = x as f32 + 0.5;
            let w = [
                edges[0].at(px, py),
                edges[1].at(px, py),
                edges[2].at(px, py),
            ];
            if (0..3).all(|i| w[i] > 0.0 || (w[i] == 0.0 && edges[i].owns_zero)) {
                visit(x, y, w.map(|w| w * inverse));
            }
        }
    }
}

/// A directed edge as `w(p) = dx * (p.y - y) - dy * (p.x - x)`, positive inside.
struct Edge {
    x: f32,
    y: f32,
    dx: f32,
    dy: f32,
    owns_zero: bool,
}

impl Edge {
    #[inline]
    fn new(from: Vec2, to: Vec2, flip: f32) -> Self {
        let dx = (to.x - from.x) * flip;
        let dy = (to.y - from.y) * flip;
        // Rounding must be the same from both sides of a shared edge: anchor it at one fixed end.
        let anchor = if (from.x, from.y) < (to.x, to.y) {
            from
        } else {
            to
        };
        Self {
            x: anchor.x,
            y: anchor.y,
            dx,
            dy,
            owns_zero: dy < 0.0 || (dy == 0.0 && dx > 0.0),
        }
    }

    #[inline]
    fn at(&self, px: f32, py: f32) -> f32 {
        self.dx * (py - self.y) - self.dy * (px - self.x)
    }

    /// Drops columns that are outside for certain; keeps a column of slack on each side, because
    /// the division rounds and the exact test is made per pixel.
    #[inline]
    fn narrow(&self, py: f32, enter: &mut u32, leave: &mut u32) {
        if self.dy == 0.0 {
            return;
        }
        let cross = self.x + self.dx * (py - self.y) / self.dy - 0.5;
        if self.dy > 0.0 {
            *leave = (*leave).min(floor_to_u32(cross + 3.0));
        } else {
            *enter = (*enter).max(floor_to_u32(cross - 1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIP: Clip = Clip {
        x0: 0,
        y0: 0,
        x1: 16,
        y1: 16,
    };

    fn cover(corners: [(f32, f32); 3], hits: &mut [u32; 256]) {
        triangle(corners.map(|(x, y)| Vec2::new(x, y)), CLIP, |x, y, b| {
            assert!((b[0] + b[1] + b[2] - 1.0).abs() < 1e-4, "{b:?}");
            hits[(y * 16 + x) as usize] += 1;
        });
    }

    #[test]
    fn two_triangles_of_a_quad_share_no_pixel_and_leave_none_out() {
        for (width, height) in [(4.0, 4.0), (7.5, 3.5), (11.25, 9.75)] {
            let mut hits = [0; 256];
            let (a, b, c, d) = (
                (2.5, 2.5),
                (2.5 + width, 2.5),
                (2.5 + width, 2.5 + height),
                (2.5, 2.5 + height),
            );
            cover([a, b, c], &mut hits);
            cover([d, c, a], &mut hits);
            let expected = (0..16_u8)
                .flat_map(|y| (0..16_u8).map(move |x| (x, y)))
                .map(|(x, y)| {
                    let inside = |p: u8, size: f32| {
                        let p = f32::from(p) + 0.5;
                        p >= 2.5 && p < 2.5 + size
                    };
                    u32::from(inside(x, width) && inside(y, height))
                });
            assert_eq!(hits.to_vec(), expected.collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_fan_covers_its_inside_once() {
        let mut hits = [0; 256];
        let rim: Vec<(f32, f32)> = (0..7)
            .map(|i| {
                let angle = i as f32 * crate::math::TAU / 7.0;
                (8.0 + 6.3 * libm::cosf(angle), 8.0 + 6.3 * libm::sinf(angle))
            })
            .collect();
        for i in 0..7 {
            cover([(8.0, 8.0), rim[i], rim[(i + 1) % 7]], &mut hits);
        }
        assert!(hits.iter().all(|&h| h <= 1));
        assert!(hits.iter().sum::<u32>() > 90);
    }

    #[test]
    fn degenerate_and_broken_triangles_cover_nothing() {
        let mut hits = [0; 256];
        cover([(1.0, 1.0), (5.0, 5.0), (9.0, 9.0)], &mut hits);
        cover([(f32::NAN, 1.0), (5.0, 5.0), (9.0, 2.0)], &mut hits);
        cover([(-9.0, -9.0), (-5.0, -5.0), (-9.0, -2.0)], &mut hits);
        assert_eq!(hits.iter().sum::<u32>(), 0);
    }
}
