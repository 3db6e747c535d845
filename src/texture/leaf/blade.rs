//! One blade as a map: signed distance to the outline, veins, and the slopes of the surface.
//!
//! Made once for all copies of the blade on a card. Frame as in [`super::outline`]; slopes are height
//! over way.

use super::distance::{Grid, Segment};
use super::outline::polygon;
use super::veins::veins;
use crate::math::{Vec2, floor_to_u32, lerp, smoothstep};
use crate::species::schema::{Blade, Veins};
use crate::texture::noise::Periodic;

/// Cells along a blade: enough to be sharp, few enough to be made in a blink.
const FEWEST: f32 = 40.0;
const MOST: f32 = 600.0;
/// Cells that even the slimmest blade is wide.
const ACROSS: f32 = 10.0;
/// Border about the blade in which distances are known, in blade lengths.
pub(super) const PAD: f32 = 0.1;
/// Cells of the finest veins along a blade.
const NET: u32 = 55;
/// Fewest cells along a blade that show them.
const NET_FROM: f32 = 350.0;

/// How far in the margin begins to roll down, in half widths.
const ROLL: f32 = 0.5;

/// What is known of one place of the blade.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Distance to the outline, blade lengths; negative inside.
    pub(super) outside: f32,
    /// 0 between veins ..= 1 on a main vein.
    pub(super) vein: f32,
    /// Slope of the surface along the midrib and across it.
    pub(super) slope: Vec2,
}

impl Place {
    fn mix(self, other: Self, t: f32) -> Self {
        Self {
            outside: lerp(self.outside, other.outside, t),
            vein: lerp(self.vein, other.vein, t),
            slope: self.slope.lerp(other.slope, t),
        }
    }
}

/// A blade, ready to be looked up.
pub(super) struct BladeMap {
    grid: Grid,
    places: Vec<Place>,
    /// Points of the outline, fewer than it has: to measure copies with.
    pub(super) rim: Vec<Vec2>,
    /// Extent of the outline.
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// Half the width, blade lengths.
    pub(super) half: f32,
}

impl BladeMap {
    /// The map of a blade that is `texels` long on the card.
    pub(super) fn new(blade: &Blade, texels: f32) -> Self {
        Self::of_polygon(blade, &polygon(blade), texels)
    }

    /// The same for a blade whose outline is at hand; `blade.width` must be that of the outline.
    pub(super) fn of_polygon(blade: &Blade, polygon: &[Vec2], texels: f32) -> Self {
        let low = polygon.iter().copied().fold(Vec2::INFINITY, Vec2::min);
        let high = polygon.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
        let cells = texels
            .clamp(FEWEST, MOST)
            .max(ACROSS / (high.y - low.y).max(1e-3));
        let cell = 1.0 / cells.min(2.0 * MOST);
        let pad = Vec2::splat(PAD);
        let grid = Grid::new(low - pad, high + pad, cell);
        let outside = distances(&grid, polygon);
        let depth = |point: Vec2| -bilinear(&grid, &outside, point);
        let veins = veins(blade, &depth);
        let half = 0.5 * (high.y - low.y).min(2.0);
        let mut places = surface(blade, &grid, &outside, &veins, half);
        for (place, outside) in places.iter_mut().zip(outside) {
            place.outside = outside;
        }
        Self {
            grid,
            places,
            rim: polygon
                .iter()
                .copied()
                .step_by(polygon.len() / 40 + 1)
                .collect(),
            low,
            high,
            half,
        }
    }

    /// What is at a place; far outside only a lower bound of the distance is known.
    pub(super) fn at(&self, u: f32, v: f32) -> Place {
        let (index, t) = cell_of(&self.grid, Vec2::new(u, v));
        let row = |index: usize| self.places[index].mix(self.places[index + 1], t.x);
        row(index).mix(row(index + self.grid.width), t.y)
    }

    /// Distance to the outline only.
    pub(super) fn outside(&self, u: f32, v: f32) -> f32 {
        let (index, t) = cell_of(&self.grid, Vec2::new(u, v));
        let row = |index: usize| {
            lerp(
                self.places[index].outside,
                self.places[index + 1].outside,
                t.x,
            )
        };
        lerp(row(index), row(index + self.grid.width), t.y)
    }
}

/// The cell below a point, clamped to the grid, and the way to the next.
fn cell_of(grid: &Grid, point: Vec2) -> (usize, Vec2) {
    let at = (point - grid.low) / grid.cell;
    let clamp = |x: f32, count: usize| x.clamp(0.0, count as f32 - 1.001);
    let at = Vec2::new(clamp(at.x, grid.width), clamp(at.y, grid.height));
    let (i, j) = (floor_to_u32(at.x) as usize, floor_to_u32(at.y) as usize);
    (j * grid.width + i, at - Vec2::new(i as f32, j as f32))
}

fn bilinear(grid: &Grid, values: &[f32], point: Vec2) -> f32 {
    let (index, t) = cell_of(grid, point);
    let row = |index: usize| lerp(values[index], values[index + 1], t.x);
    lerp(row(index), row(index + grid.width), t.y)
}

/// Signed distance to a polygon at every cell.
fn distances(grid: &Grid, polygon: &[Vec2]) -> Vec<f32> {
    let segments: Vec<Segment> = (0..polygon.len())
        .map(|i| Segment {
            from: polygon[i],
            to: polygon[(i + 1) % polygon.len()],
            radius: [0.0; 2],
        })
        .collect();
    let nearest = grid.nearest(&segments);
    let inside = grid.inside(polygon);
    nearest
        .iter()
        .zip(inside)
        .map(|(&(_, square), inside)| {
            let distance = square.sqrt().min(4.0);
            if inside { -distance } else { distance }
        })
        .collect()
}

/// Veins and slopes at every cell.
fn surface(
    blade: &Blade,
    grid: &Grid,
    outside: &[f32],
    veins: &[Segment],
    half: f32,
) -> Vec<Place> {
    let nearest = grid.nearest(veins);
    // The blade bulges between veins by a part of their distance.
    let bulge = match blade.veins {
        Veins::Parallel { .. } => 0.1,
        Veins::Midrib => 0.0,
        _ => 0.15,
    };
    let net = (1.0 / grid.cell > NET_FROM && !matches!(blade.veins, Veins::Parallel { .. }))
        .then(|| Periodic::new(77, [NET, NET]));
    let mut heights = vec![0.0_f32; outside.len()];
    let mut places = vec![Place::default(); outside.len()];
    for j in 0..grid.height {
        for i in 0..grid.width {
            let cell = j * grid.width + i;
            if outside[cell] > 3.0 * grid.cell {
                continue;
            }
            let point = grid.point(i, j);
            let (number, square) = nearest[cell];
            let mut vein = 0.0;
            let mut height = 0.0;
            if let Some(segment) = veins.get(number as usize) {
                let (_, way) = segment.nearest(point);
                let radius = lerp(segment.radius[0], segment.radius[1], way).max(1e-5);
                let distance = square.sqrt();
                let x = distance / radius;
                let bell = 1.0 / ((1.0 + x * x) * (1.0 + x * x));
                let strength = smoothstep(0.0, 0.006, radius).max(0.45);
                vein = bell * strength;
                // A groove with the blade rising away from it.
                let rise = distance / (1.0 + 9.0 * distance / half.max(1e-3));
                height = bulge * rise - 0.22 * radius * bell;
            }
            if let Some(net) = &net {
                let cells = net.cell(point.x, point.y);
                let line = 1.0 - smoothstep(0.0, 0.13, cells.border);
                vein = vein.max(0.16 * line);
                height -= 0.0002 * line;
            }
            // The margin rolls down.
            let margin = (1.0 + outside[cell] / (ROLL * half).max(1e-3)).clamp(0.0, 1.2);
            height -= 0.1 * ROLL * half * margin * margin * margin;
            heights[cell] = height;
            places[cell].vein = vein;
        }
    }
    for j in 1..grid.height.saturating_sub(1) {
        for i in 1..grid.width - 1 {
            let cell = j * grid.width + i;
            if outside[cell] > 2.0 * grid.cell {
                continue;
            }
            let along = heights[cell + 1] - heights[cell - 1];
            let across = heights[cell + grid.width] - heights[cell - grid.width];
            let u = grid.point(i, j).x;
            let bow = Vec2::new(0.12 - 0.4 * u * u.abs(), 0.0);
            places[cell].slope = Vec2::new(along, across) / (2.0 * grid.cell) + bow;
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::schema::Lobes;

    /// Area by the shoelace formula, blade lengths squared.
    fn area(polygon: &[Vec2]) -> f32 {
        let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
        0.5 * pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f32>()
    }

    #[test]
    fn an_elliptic_blade_has_the_area_of_an_ellipse() {
        let blade = Blade {
            width: 0.4,
            widest: 0.5,
            sharpness: 0.5,
            ..Blade::default()
        };
        let ratio = area(&polygon(&blade)) / (crate::math::PI / 4.0 * 0.4);
        assert!((0.99..1.01).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_blade_is_widest_where_its_description_says() {
        let blade = Blade {
            width: 0.4,
            widest: 0.3,
            ..Blade::default()
        };
        let polygon = polygon(&blade);
        let widest = polygon.iter().max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        assert!((widest.x - 0.3).abs() < 0.01 && (widest.y - 0.2).abs() < 1e-3);
        let map = BladeMap::new(&blade, 200.0);
        assert!(map.outside(0.3, 0.19) < 0.0 && map.outside(0.3, -0.21) > 0.0);
        assert!(map.outside(-0.02, 0.0) > 0.0 && map.outside(0.98, 0.0) < 0.0);
    }

    #[test]
    fn every_lobe_of_a_palmate_blade_is_there_and_both_halves_are_alike() {
        for count in [3, 5, 7, 9] {
            let blade = Blade {
                width: 1.0,
                widest: 0.6,
                sharpness: 0.9,
                lobes: Lobes::Palmate {
                    count,
                    spread_deg: 200.0,
                    depth: 0.6,
                    outer: 0.7,
                },
                ..Blade::default()
            };
            let outline = polygon(&blade);
            let radius: Vec<f32> = outline.iter().map(|p| p.length()).collect();
            let peaks = (0..radius.len())
                .filter(|&i| {
                    let at = |step: usize| radius[(i + radius.len() + step - 6) % radius.len()];
                    radius[i] > 0.4 && (0..=12).all(|step| at(step) <= radius[i])
                })
                .count();
            assert_eq!(peaks, count as usize);
            for point in &outline {
                let mirrored = Vec2::new(point.x, -point.y);
                let near = outline.iter().map(|p| p.distance(mirrored));
                assert!(near.fold(1.0, f32::min) < 1e-4);
            }
        }
    }
}
