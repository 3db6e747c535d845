//! Linear algebra (re-exported from `glam`, in its scalar, libm-backed form) and the few maps that
//! every stage shares. Angles are radians; degrees exist only in scripts and on screen.

pub use core::f32::consts::{PI, TAU};
pub use glam::{Mat3, Quat, Vec2, Vec3};

/// A rigid turn, a uniform scale and a shift: what places one node's frame in another's.
///
/// `point' = translation + rotation * (scale * point)`. Uniform scale is what keeps a sub-tree
/// identical to its cousins, and so lets them share one texture (Koniaris et al., section IV.C).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Unit quaternion.
    pub rotation: Quat,
    /// Metres.
    pub translation: Vec3,
    /// Positive factor.
    pub scale: f32,
}

impl Similarity {
    /// Leaves every point where it is.
    pub const IDENTITY: Self = Self {
        rotation: Quat::IDENTITY,
        translation: Vec3::ZERO,
        scale: 1.0,
    };

    /// `self` after `inner`: takes a point from the frame of `inner`'s input to that of `self`'s output.
    #[must_use]
    pub fn then_inner(&self, inner: &Self) -> Self {
        Self {
            rotation: (self.rotation * inner.rotation).normalize(),
            translation: self.point(inner.translation),
            scale: self.scale * inner.scale,
        }
    }

    /// The similarity that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        let scale = 1.0 / self.scale;
        Self {
            rotation,
            translation: rotation * (self.translation * -scale),
            scale,
        }
    }

    /// Maps a point.
    #[must_use]
    pub fn point(&self, point: Vec3) -> Vec3 {
        self.translation + self.rotation * (point * self.scale)
    }

    /// Maps a displacement (turned and scaled, not shifted).
    #[must_use]
    pub fn vector(&self, vector: Vec3) -> Vec3 {
        self.rotation * (vector * self.scale)
    }
}

/// An axis-aligned box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner, metres.
    pub min: Vec3,
    /// Largest corner, metres.
    pub max: Vec3,
}

impl Bounds {
    /// Holds nothing; the neutral element of [`Bounds::union`].
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |bounds, point| bounds.with_point(point))
    }

    /// Grown to hold `point`.
    #[must_use]
    pub fn with_point(&self, point: Vec3) -> Self {
        Self {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// Grown to hold `other`.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// True if it holds no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// Edge lengths, metres; zero when empty.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Middle point; the origin when empty.
    #[must_use]
    pub fn centre(&self) -> Vec3 {
        if self.is_empty() {
            Vec3::ZERO
        } else {
            (self.min + self.max) * 0.5
        }
    }

    /// Its eight corners.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        core::array::from_fn(|i| {
            let pick = |bit: usize, low: f32, high: f32| if i & bit == 0 { low } else { high };
            Vec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            )
        })
    }
}

/// Hermite ramp: 0 at or below `low`, 1 at or above `high`, flat at both ends.
#[must_use]
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Straight blend from `a` (at 0) to `b` (at 1).
#[must_use]
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// The shortest turn that takes +Y to the unit vector `direction`.
#[must_use]
pub fn rotation_from_y(direction: Vec3) -> Quat {
    Quat::from_rotation_arc(Vec3::Y, direction)
}

/// Linear light (0..=1) from an sRGB byte (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb(byte: u8) -> f32 {
    linear_from_unit_srgb(f32::from(byte) / 255.0)
}

fn linear_from_unit_srgb(x: f32) -> f32 {
    if x <= 0.04045 {
        x / 12.92
    } else {
        libm::powf((x + 0.055) / 1.055, 2.4)
    }
}

/// The sRGB byte of a linear value; clamps to 0..=1, and takes NaN as 0.
///
/// Exact: the smallest linear value of each byte is looked up, not approximated.
#[must_use]
pub fn srgb_from_linear(x: f32) -> u8 {
    let steps = &*SRGB_STEPS;
    let cell = floor_to_u32(x.clamp(0.0, 1.0) * SRGB_CELLS) as usize;
    let mut byte = steps.first[cell];
    while byte < u8::MAX && x >= steps.from[usize::from(byte) + 1] {
        byte += 1;
    }
    byte
}

/// Cells of the table that leads to the right byte; fine enough for at most a few steps after it.
const SRGB_CELLS: f32 = 4096.0;

/// Where each sRGB byte begins on the linear scale.
struct SrgbSteps {
    /// The smallest linear value that rounds to each byte.
    from: [f32; 256],
    /// The byte at the start of each cell.
    first: Vec<u8>,
}

static SRGB_STEPS: std::sync::LazyLock<SrgbSteps> = std::sync::LazyLock::new(|| {
    let from: [f32; 256] = core::array::from_fn(|byte| match byte {
        0 => 0.0,
        #[expect(clippy::cast_precision_loss, reason = "a byte")]
        byte => linear_from_unit_srgb((byte as f32 - 0.5) / 255.0),
    });
    let mut byte = 0_u8;
    let first = (0..=floor_to_u32(SRGB_CELLS))
        .map(|cell| {
            let start = float(cell) / SRGB_CELLS;
            while byte < u8::MAX && start >= from[usize::from(byte) + 1] {
                byte += 1;
            }
            byte
        })
        .collect();
    SrgbSteps { from, first }
});

/// 0..=255 from 0..=1, rounded; clamps, and takes NaN as 0.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "clamped to 0..=255.5 just before"
)]
#[expect(clippy::cast_sign_loss, reason = "clamped to be non-negative")]
pub fn byte_from_unit(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Whole number at or below a non-negative `x`; saturates, and takes NaN as 0.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "saturation is what is wanted"
)]
#[expect(clippy::cast_sign_loss, reason = "negative values are taken as 0")]
pub fn floor_to_u32(x: f32) -> u32 {
    x as u32
}

/// Whole number nearest to a non-negative `x`; saturates.
#[must_use]
pub fn round_to_u32(x: f32) -> u32 {
    floor_to_u32(x + 0.5)
}

/// A count as a float; exact up to 2^24, which no count of texels, cells or corners here passes.
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "documented")]
pub fn float(count: u32) -> f32 {
    count as f32
}

/// Eigenvalues of a symmetric matrix, rising, and their unit eigenvectors, by Jacobi rotations.
///
/// The matrix may be indefinite; only its upper triangle is read.
#[must_use]
#[expect(
    clippy::needless_range_loop,
    reason = "rows and columns of one matrix, by index as in the books"
)]
pub fn symmetric_eigenvectors(matrix: Mat3) -> ([f32; 3], [Vec3; 3]) {
    let column = |i: usize| matrix.col(i).to_array().map(f64::from);
    let mut a = [column(0), column(1), column(2)];
    for i in 0..3 {
        for j in 0..i {
            a[j][i] = a[i][j];
        }
    }
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f64]];
    // Converges quadratically: a handful of sweeps reach the last bit.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a[p][q];
            if off == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * off);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
            }
            for row in &mut v {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    #[expect(
        clippy::cast_possible_truncation,
        reason = "worked out in doubles, kept as floats like all else"
    )]
    let vector =
        |i: usize| Vec3::new(v[0][i] as f32, v[1][i] as f32, v[2][i] as f32).normalize_or(Vec3::X);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "worked out in doubles, kept as floats like all else"
    )]
    let value = |i: usize| a[i][i] as f32;
    (order.map(value), order.map(vector))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_and_its_inverse_cancel() {
        let place = Similarity {
            rotation: Quat::from_rotation_x(0.7) * Quat::from_rotation_y(2.0),
            translation: Vec3::new(1.0, -2.0, 3.0),
            scale: 0.3,
        };
        let point = Vec3::new(0.4, 5.0, -0.6);
        assert!((place.inverse().point(place.point(point)) - point).length() < 1e-5);
        let both = place.then_inner(&place.inverse());
        assert!((both.point(point) - point).length() < 1e-5);
    }

    #[test]
    fn srgb_bytes_survive_the_way_to_linear_and_back() {
        for byte in 0..=255 {
            assert_eq!(srgb_from_linear(linear_from_srgb(byte)), byte);
        }
    }

    #[test]
    fn eigenvectors_solve_definite_and_indefinite_matrices() {
        for matrix in [
            Mat3::from_cols(
                Vec3::new(2.0, 1.0, 0.0),
                Vec3::new(1.0, -3.0, 0.5),
                Vec3::new(0.0, 0.5, 1.0),
            ),
            Mat3::from_cols(
                Vec3::new(5.0, 2.0, 1.0),
                Vec3::new(2.0, 4.0, -1.0),
                Vec3::new(1.0, -1.0, 6.0),
            ),
            Mat3::IDENTITY,
            Mat3::ZERO,
        ] {
            let (values, vectors) = symmetric_eigenvectors(matrix);
            assert!(values[0] <= values[1] && values[1] <= values[2]);
            for (value, vector) in values.iter().zip(vectors) {
                let miss = (matrix * vector - vector * *value).length();
                assert!(miss < 1e-5, "{matrix}: {vector} misses by {miss}");
            }
        }
    }
}
