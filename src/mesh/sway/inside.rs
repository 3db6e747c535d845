//! What stands for a whole sub-tree sways as what it shows: samples of a prototype's leaves and wood with how
//! they sway, and the values at a stand-in's vertices that come nearest to them.
//!
//! Each piece of a template (a quad, a strip) is fitted by itself: least squares over the samples that lie on
//! it, the nearer the more they count, drawn a little toward the samples around each vertex so that corners
//! which show nothing stay sane. So the mean over a quad is the mean over its leaves, which the value at the
//! corners' own places is not.

use super::super::template::Template;
use super::Shared;
use crate::math::{Similarity, TAU, Vec3, float};
use crate::rng::unit_from_bits;
use crate::tree::{Part, flex};

/// How something sways with what is inside one prototype, at scale 1: its part of the way of the prototype's
/// own branch, metres by band of all branches further out, and those of the second and third band as a sum of
/// vectors turned by the phases of their limbs.
pub(super) type Way = [f32; 6];

/// Places in a [`Way`].
pub(super) const OWN: usize = 0;
pub(super) const BANDS: [usize; 3] = [1, 2, 3];
pub(super) const PHASOR: [usize; 2] = [4, 5];

/// A place inside a prototype, in its frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    at: Vec3,
    way: Way,
}

/// Samples of a prototype: so many, and so many more for each piece of what stands for it.
const SAMPLES: usize = 96;
const SAMPLES_A_PIECE: usize = 24;
const MOST_SAMPLES: usize = 1536;

/// Samples nearer to a piece than this part of its size count as if they lay on it.
const NEAR: f32 = 0.15;

/// Weight of the samples around a vertex against the fit.
const PRIOR: f64 = 0.03;

/// Pieces of more vertices are not fitted; their vertices take the mean of the samples around them.
const LARGEST_FIT: usize = 64;

/// The ways of a stand-in's vertices. Those at which `held` is true stay where they are.
pub(super) fn ways(
    shared: &Shared<'_>,
    seat: (usize, usize),
    template: &Template,
    held: impl Fn(Vec3) -> bool,
) -> Vec<Way> {
    let points: Vec<Vec3> = template
        .vertices
        .iter()
        .map(|v| v.axis + v.offset)
        .collect();
    let pieces = pieces(template);
    let wanted = (SAMPLES + SAMPLES_A_PIECE * pieces.len()).min(MOST_SAMPLES);
    let samples = samples(shared, seat, wanted);
    let mut ways: Vec<Way> = points.iter().map(|&p| around(&samples, p)).collect();
    for piece in &pieces {
        fit(&points, &samples, piece, &held, &mut ways);
    }
    for (way, &point) in ways.iter_mut().zip(&points) {
        if held(point) {
            *way = [0.0; 6];
        }
        for place in [OWN, BANDS[0], BANDS[1], BANDS[2]] {
            way[place] = way[place].max(0.0);
        }
    }
    ways
}

/// Samples spread evenly over the area of a prototype's leaves (and a little over its wood).
fn samples(shared: &Shared<'_>, seat: (usize, usize), count: usize) -> Vec<Sample> {
    let count = u32::try_from(count).unwrap_or(1);
    (0..count)
        .map(|i| sample(shared, seat, (f64::from(i) + 0.5) / f64::from(count)))
        .collect()
}

/// The place at part `share` (0..1) of a prototype's area, in the order of its links.
fn sample(shared: &Shared<'_>, top: (usize, usize), mut share: f64) -> Sample {
    let tree = shared.tree;
    let (mut seat, mut thickness) = (top, None);
    let (mut place, mut way, mut phase) = (Similarity::IDENTITY, [0.0; 6], 0.0);
    loop {
        let prototype = tree.prototype(seat.0, seat.1);
        let (own, mut left) = (shared.own_area(seat), share * shared.areas[seat.0][seat.1]);
        let mut chosen = None;
        share = left / own.max(1e-12);
        if left >= own {
            left -= own;
            for (index, link) in prototype.links.iter().enumerate() {
                let area = shared.area_of(link);
                if area > 0.0 {
                    chosen = Some(index);
                    share = left / area;
                    if left < area {
                        break;
                    }
                    left -= area;
                }
            }
        }
        // Rounding may lead a hair past the last link.
        share = share.clamp(0.0, 1.0);
        let mut follow = |t: f32, phase: f32| {
            let bend = flex::bend(t);
            let Some(thickness) = thickness else {
                way[OWN] = if matches!(prototype.part, Part::Branch(_)) {
                    bend
                } else {
                    0.0
                };
                return;
            };
            let band = shared.bands[seat.0];
            let metres = bend * shared.tip_m(seat, place.scale, thickness);
            way[BANDS[band]] += metres;
            if band > 0 {
                let (sine, cosine) = libm::sincosf(TAU * phase);
                way[PHASOR[0]] += metres * cosine;
                way[PHASOR[1]] += metres * sine;
            }
        };
        let Some(index) = chosen else {
            let at = match &prototype.part {
                Part::Stool => Vec3::ZERO,
                Part::Leaf { length, .. } => Vec3::Y * (0.5 * length),
                Part::Branch(branch) => {
                    #[expect(clippy::cast_possible_truncation, reason = "a part of a length")]
                    let t = share as f32;
                    follow(t, phase);
                    branch.at(t).position
                }
            };
            let at = place.point(at);
            return Sample { at, way };
        };
        let link = &prototype.links[index];
        follow(link.at, phase);
        phase = shared.phase(seat, index, phase);
        // Turns of tropic levels are known only where a node stands in the world.
        place = if top.0 == 0 {
            tree.place(&place, link)
        } else {
            place.then_inner(&link.place)
        };
        seat = (link.level as usize, link.prototype as usize);
        thickness = Some(link.thickness);
    }
}

/// The mean of all samples, the nearer the more they count.
fn around(samples: &[Sample], point: Vec3) -> Way {
    let mut sum = [0.0; 6];
    let mut weights = 0.0;
    for sample in samples {
        let weight = 1.0 / (sample.at.distance_squared(point) + 1e-6);
        weights += weight;
        add(&mut sum, &sample.way, weight);
    }
    sum.map(|s| s / weights.max(1e-12))
}

fn add(sum: &mut Way, way: &Way, weight: f32) {
    for (sum, way) in sum.iter_mut().zip(way) {
        *sum += way * weight;
    }
}

/// Vertices and triangles that hang together.
struct Piece {
    vertices: Vec<usize>,
    /// Places in `vertices`.
    triangles: Vec<[usize; 3]>,
}

/// The pieces of a template, in the order of their first triangles.
fn pieces(template: &Template) -> Vec<Piece> {
    let mut owner: Vec<usize> = (0..template.vertices.len()).collect();
    let corners = |t: &[u32]| [t[0], t[1], t[2]].map(|i| i as usize);
    // Templates are small: sweeps until nothing changes are enough.
    loop {
        let mut changed = false;
        for [a, b, c] in template.indices.chunks_exact(3).map(corners) {
            let low = owner[a].min(owner[b]).min(owner[c]);
            for vertex in [a, b, c] {
                changed |= owner[vertex] != low;
                owner[vertex] = low;
            }
        }
        if !changed {
            break;
        }
    }
    let mut place = vec![usize::MAX; owner.len()];
    let mut pieces: Vec<Piece> = Vec::new();
    for (vertex, &first) in owner.iter().enumerate() {
        if vertex == first {
            place[first] = pieces.len();
            pieces.push(Piece {
                vertices: Vec::new(),
                triangles: Vec::new(),
            });
        }
        pieces[place[first]].vertices.push(vertex);
    }
    for triangle in template.indices.chunks_exact(3).map(corners) {
        let piece = &mut pieces[place[owner[triangle[0]]]];
        let inside = triangle.map(|v| piece.vertices.binary_search(&v).unwrap_or(0));
        piece.triangles.push(inside);
    }
    pieces
}

/// Fits the ways of a piece's vertices.
fn fit(
    points: &[Vec3],
    samples: &[Sample],
    piece: &Piece,
    held: &impl Fn(Vec3) -> bool,
    ways: &mut [Way],
) {
    let count = piece.vertices.len();
    if count > LARGEST_FIT || piece.triangles.is_empty() {
        return;
    }
    let corners: Vec<Vec3> = piece.vertices.iter().map(|&v| points[v]).collect();
    let bounds = crate::math::Bounds::of_points(corners.iter().copied());
    let near = (bounds.size().length() * NEAR).max(1e-4);
    let mut matrix = vec![vec![0.0_f64; count + 6]; count];
    let mut weights = 0.0;
    for sample in samples {
        let (on, shares, distance_squared) = nearest(&corners, &piece.triangles, sample.at);
        let weight = f64::from(1.0 / (near * near + distance_squared));
        weights += weight;
        for (&row, &a) in on.iter().zip(&shares) {
            for (&column, &b) in on.iter().zip(&shares) {
                matrix[row][column] += weight * f64::from(a * b);
            }
            for (place, &value) in sample.way.iter().enumerate() {
                matrix[row][count + place] += weight * f64::from(a * value);
            }
        }
    }
    let count_f = f64::from(float(u32::try_from(count).unwrap_or(1)));
    let prior = PRIOR * weights / count_f;
    for (row, &vertex) in piece.vertices.iter().enumerate() {
        if held(points[vertex]) {
            matrix[row].fill(0.0);
            matrix[row][row] = 1.0;
            continue;
        }
        matrix[row][row] += prior;
        for place in 0..6 {
            matrix[row][count + place] += prior * f64::from(ways[vertex][place]);
        }
    }
    let solution = solve(matrix);
    for (row, &vertex) in solution.iter().zip(&piece.vertices) {
        ways[vertex] = *row;
    }
}

/// The nearest triangle: its corners, their shares of the point nearest to `point` (to a good approximation),
/// and that point's squared distance.
fn nearest(corners: &[Vec3], triangles: &[[usize; 3]], point: Vec3) -> ([usize; 3], [f32; 3], f32) {
    let mut best = (triangles[0], [1.0, 0.0, 0.0], f32::INFINITY);
    for &triangle in triangles {
        let [a, b, c] = triangle.map(|i| corners[i]);
        let (u, v, w) = (b - a, c - a, point - a);
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let determinant = (uu * vv - uv * uv).max(1e-20);
        let s = (vv * u.dot(w) - uv * v.dot(w)) / determinant;
        let t = (uu * v.dot(w) - uv * u.dot(w)) / determinant;
        let shares = [1.0 - s - t, s, t].map(|x| x.max(0.0));
        let whole: f32 = shares.iter().sum::<f32>().max(1e-6);
        let shares = shares.map(|x| x / whole);
        let away = point.distance_squared(a * shares[0] + b * shares[1] + c * shares[2]);
        if away < best.2 {
            best = (triangle, shares, away);
        }
    }
    best
}

/// Gauss's elimination with pivots, six right-hand sides at a time.
fn solve(mut rows: Vec<Vec<f64>>) -> Vec<Way> {
    let count = rows.len();
    for column in 0..count {
        let pivot = (column..count)
            .max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))
            .unwrap_or(column);
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let top = &above[column];
        for row in below {
            let factor = row[column] / top[column];
            for (value, over) in row.iter_mut().zip(top).skip(column) {
                *value -= factor * over;
            }
        }
    }
    let mut solution = vec![[0.0_f64; 6]; count];
    for row in (0..count).rev() {
        for place in 0..6 {
            let known = rows[row][row + 1..count].iter().zip(&solution[row + 1..]);
            let known: f64 = known.map(|(factor, other)| factor * other[place]).sum();
            solution[row][place] = (rows[row][count + place] - known) / rows[row][row];
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "ways are floats")]
    let way = |row: &[f64; 6]| row.map(|x| x as f32);
    solution.iter().map(way).collect()
}

/// A number in 0..1 from a path's hash.
pub(super) fn unit_of(path: u32) -> f32 {
    unit_from_bits(path.wrapping_mul(0x9e37_79b1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::template::TemplateVertex;

    fn square() -> Template {
        let vertex = |x: f32, y: f32| TemplateVertex {
            axis: Vec3::new(x, y, 0.0),
            offset: Vec3::ZERO,
            normal: Vec3::Z,
            tangent: Vec3::X,
            uv: [0.0; 2],
            tint: crate::mesh::WHITE,
        };
        Template {
            vertices: vec![
                vertex(-1.0, 0.0),
                vertex(1.0, 0.0),
                vertex(-1.0, 2.0),
                vertex(1.0, 2.0),
            ],
            indices: vec![0, 1, 3, 0, 3, 2],
            ..Template::default()
        }
    }

    /// Leaves in a ball inside the square, which none of them touches.
    fn ball() -> Vec<Sample> {
        let grid =
            (0..9_u8).flat_map(|i| (0..9_u8).flat_map(move |j| (0..3_u8).map(move |k| [i, j, k])));
        grid.map(|n| n.map(f32::from))
            .map(|[i, j, k]| Vec3::new(i / 4.0 - 1.0, j / 4.0, k / 4.0 - 0.25))
            .filter(|p| p.distance(Vec3::Y) < 0.9)
            .map(|at| Sample {
                at,
                way: [
                    0.0,
                    0.3 + 0.1 * at.x + 0.2 * at.y,
                    at.y * at.y,
                    0.0,
                    0.0,
                    0.0,
                ],
            })
            .collect()
    }

    #[test]
    fn the_mean_over_a_quad_is_that_of_its_leaves() {
        let (template, samples) = (square(), ball());
        let points: Vec<Vec3> = template.vertices.iter().map(|v| v.axis).collect();
        let mut ways: Vec<Way> = points.iter().map(|&p| around(&samples, p)).collect();
        let pieces = pieces(&template);
        assert_eq!(pieces.len(), 1);
        fit(&points, &samples, &pieces[0], &|p| p.y < -1.0, &mut ways);
        let mut sums = [Vec3::ZERO; 2];
        for sample in &samples {
            let (on, shares, _) = nearest(&points, &pieces[0].triangles, sample.at);
            for (band, sum) in sums.iter_mut().enumerate() {
                let shown: f32 = on
                    .iter()
                    .zip(shares)
                    .map(|(&v, s)| ways[v][band + 1] * s)
                    .sum();
                *sum += Vec3::new(shown, sample.way[band + 1], 1.0);
                let miss = (shown - sample.way[band + 1]).abs();
                assert!(band > 0 || miss < 0.04, "what is straight stays so: {miss}");
            }
        }
        for sum in sums {
            assert!(
                (sum.x / sum.y - 1.0).abs() < 0.02,
                "{} for {}",
                sum.x,
                sum.y
            );
        }
    }

    #[test]
    fn a_held_vertex_is_a_zero_of_the_fit() {
        let (template, samples) = (square(), ball());
        let points: Vec<Vec3> = template.vertices.iter().map(|v| v.axis).collect();
        let mut ways: Vec<Way> = points.iter().map(|&p| around(&samples, p)).collect();
        fit(
            &points,
            &samples,
            &pieces(&template)[0],
            &|p| p.y < 0.1,
            &mut ways,
        );
        let held = ways[0].iter().chain(&ways[1]);
        assert!(held.clone().all(|w| w.abs() < 1e-6), "{ways:?}");
        assert!(ways[3][1] > 0.5, "the rest makes up for it: {}", ways[3][1]);
    }
}
