//! FLIP: how different two pictures look when one flips between them.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A Difference Evaluator for
//! Alternating Images*, 2020; the form for pictures of low dynamic range.
//!
//! For people who have read it: each picture goes from bytes to linear light, to opponent colours (kept
//! here as ratios to white), through the blur of each channel's contrast sensitivity, to CIELAB with the
//! Hunt effect; beside that, edges and points are found in its lightness. Then the two pictures meet: the
//! distance of their colours, stretched to 0..=1, is raised to a power that falls from 1 to 0 as their
//! features differ.
//!
//! Changes versus the paper:
//! - Everything is separable: the blue-yellow blur, a sum of two Gaussians, is two blurs added.
//! - A Gaussian's taps below a ten-millionth of its middle are left out.
//! - Powers and cube roots are computed here, in forms that run on whole rows at once; the calls of a
//!   library would take most of the time.

use crate::image::Image;
use crate::math::{PI, byte_from_unit, float, floor_to_u32, lerp, linear_from_srgb};

/// What the paper takes as usual: 0.7 m from a screen of 0.7 m and 3840 pixels across.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// The visible difference of two pictures in sRGB, pixel by pixel: 0 (none) ..= 1 (the most).
///
/// `None` if the pictures differ in size. `pixels_per_degree` is how many pixels the viewer sees in one
/// degree, usually [`PIXELS_PER_DEGREE`]; it is clamped to 4..=400, and the usual stands in for NaN and
/// infinity. Past the edge of a picture its nearest pixel is repeated.
#[must_use]
pub fn flip(
    reference: &Image<[u8; 3]>,
    test: &Image<[u8; 3]>,
    pixels_per_degree: f32,
) -> Option<Image<f32>> {
    let (width, height) = (reference.width(), reference.height());
    if (width, height) != (test.width(), test.height()) {
        return None;
    }
    let eye = Eye::new(pixels_per_degree);
    let [mut a, mut b] = [reference, test].map(|image| View::new(image, &eye));
    let mut row = vec![0.0; a.stride()];
    let mut errors = Vec::with_capacity(reference.texels().len());
    for y in 0..height as usize {
        a.look_at_row(y);
        b.look_at_row(y);
        errors_of_row(&a, &b, &eye, &mut row);
        errors.extend_from_slice(&row[..width as usize]);
    }
    Some(Image::from_texels(width, height, errors))
}

/// Mean of the errors whose pixels are true in `mask` (row by row from the top); 0 if none is.
#[must_use]
pub fn masked_mean(errors: &Image<f32>, mask: &[bool]) -> f32 {
    let mut sum = 0.0_f64;
    let mut count = 0_u32;
    for (&error, &inside) in errors.texels().iter().zip(mask) {
        if inside {
            sum += f64::from(error);
            count += 1;
        }
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "rounding to f32 is what is wanted"
    )]
    let mean = (sum / f64::from(count.max(1))) as f32;
    mean
}

/// The errors in the colours of the map "magma": black at 0, violet, orange, pale yellow at 1.
#[must_use]
pub fn magma(errors: &Image<f32>) -> Image<[u8; 3]> {
    errors.map(|&error| {
        let place = error.clamp(0.0, 1.0) * 15.0;
        let cell = floor_to_u32(place).min(14);
        let [low, high] = [0, 1].map(|i| MAGMA[cell as usize + i]);
        core::array::from_fn(|i| {
            let byte = lerp(f32::from(low[i]), f32::from(high[i]), place - float(cell));
            byte_from_unit(byte / 255.0)
        })
    })
}

/// The map "magma" at 0, 1/15, 2/15, ... 1.
const MAGMA: [[u8; 3]; 16] = [
    [0x00, 0x00, 0x04],
    [0x0b, 0x07, 0x24],
    [0x20, 0x11, 0x4b],
    [0x3b, 0x0f, 0x70],
    [0x57, 0x15, 0x7e],
    [0x72, 0x1f, 0x81],
    [0x8c, 0x29, 0x81],
    [0xa8, 0x32, 0x7d],
    [0xc4, 0x3c, 0x75],
    [0xde, 0x49, 0x68],
    [0xf1, 0x60, 0x5d],
    [0xfa, 0x7f, 0x5e],
    [0xfe, 0x9f, 0x6d],
    [0xfe, 0xbf, 0x84],
    [0xfd, 0xde, 0x9f],
    [0xfc, 0xfd, 0xbf],
];

// --- the metric's numbers ---

// Contrast sensitivities are Gaussians over the frequency; these are the paper's `b`, squared degrees.
const ACHROMATIC: f32 = 0.0047;
const RED_GREEN: f32 = 0.0053;
const BLUE_YELLOW: [f32; 2] = [0.04, 0.025];
/// The paper's `a` of the two of blue-yellow; a channel with a single Gaussian needs none.
const BLUE_YELLOW_HEIGHTS: [f32; 2] = [34.1, 13.5];
/// Natural logarithm of ten million, where the taps of a Gaussian cease to matter.
const NEGLIGIBLE: f32 = 16.1;

/// The paper's `q_c`.
const COLOUR_POWER: f32 = 0.7;
/// The paper's `p_c`: the part of the largest colour distance ...
const KNEE: f32 = 0.4;
/// ... that is stretched over this part of the errors, `p_t`.
const KNEE_ERROR: f32 = 0.95;
/// The paper's `w`, degrees.
const FEATURE_WIDTH: f32 = 0.082;

/// CIE XYZ under D65 from linear sRGB (IEC 61966-2-1), each row as a ratio to that of white.
const RATIOS_FROM_RGB: [[f32; 3]; 3] = [
    [0.433_887_33, 0.376_224, 0.189_888_64],
    [0.212_639, 0.715_168_65, 0.072_192_32],
    [0.017_750_04, 0.109_447_62, 0.872_802_3],
];
/// The inverse of [`RATIOS_FROM_RGB`].
const RGB_FROM_RATIOS: [[f32; 3]; 3] = [
    [3.080_399, -1.537_383_2, -0.543_015_9],
    [-0.921_223_34, 1.875_967_5, 0.045_255_86],
    [0.052_873_94, -0.203_976_96, 1.151_103],
];

/// What pictures are looked at with: the filters for one viewer, and what need be found once only.
///
/// A filter is an odd number of taps around its middle.
struct Eye {
    achromatic: Vec<f32>,
    red_green: Vec<f32>,
    blue_yellow: [Vec<f32>; 2],
    /// The same, each with its share in the sum of the two.
    blue_yellow_shared: [Vec<f32>; 2],
    smooth: Vec<f32>,
    /// First derivative, which answers to edges.
    slope: Vec<f32>,
    /// Second derivative, which answers to points and lines.
    bend: Vec<f32>,
    /// Linear light of each sRGB byte.
    light: Vec<f32>,
    /// Power of the largest colour distance.
    farthest: f32,
    /// Half the taps of the longest filter.
    reach: usize,
}

impl Eye {
    fn new(pixels_per_degree: f32) -> Self {
        let scale = if pixels_per_degree.is_finite() {
            pixels_per_degree.clamp(4.0, 400.0)
        } else {
            PIXELS_PER_DEGREE
        };
        let deviation = 0.5 * FEATURE_WIDTH * scale;
        let detector = |weight: fn(f32) -> f32| {
            taps((3.0 * deviation).ceil(), |x| {
                let x = x / deviation;
                weight(x) * libm::expf(-0.5 * x * x)
            })
        };
        // A Gaussian enters with `a * sqrt(pi / b)`, and gathers as much as `b` over the plane.
        let parts: [f32; 2] =
            core::array::from_fn(|i| BLUE_YELLOW_HEIGHTS[i] * BLUE_YELLOW[i].sqrt());
        let blue_yellow = BLUE_YELLOW.map(|breadth| blur(breadth, scale));
        let shared = |i: usize| {
            let share = parts[i] / (parts[0] + parts[1]);
            blue_yellow[i].iter().map(|tap| tap * share).collect()
        };
        let mut eye = Self {
            achromatic: blur(ACHROMATIC, scale),
            red_green: blur(RED_GREEN, scale),
            blue_yellow_shared: [shared(0), shared(1)],
            blue_yellow,
            smooth: detector(|_| 1.0),
            slope: detector(|x| x),
            bend: detector(|x| x * x - 1.0),
            light: (0..=u8::MAX).map(linear_from_srgb).collect(),
            farthest: farthest_colours(),
            reach: 0,
        };
        let reaches = eye.along_rows().map(|(_, taps)| taps.len() / 2);
        eye.reach = reaches.into_iter().fold(0, usize::max);
        eye
    }

    /// The filters that run along rows, each with the opponent channel that it reads.
    fn along_rows(&self) -> [(usize, &[f32]); 7] {
        [
            (0, &self.achromatic),
            (1, &self.red_green),
            (2, &self.blue_yellow[0]),
            (2, &self.blue_yellow[1]),
            (0, &self.smooth),
            (0, &self.slope),
            (0, &self.bend),
        ]
    }
}

/// Samples `weight` at `-radius..=radius`; the positive taps are made to sum to 1, negative ones to -1.
fn taps(radius: f32, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    let count = 2 * floor_to_u32(radius) + 1;
    let taps: Vec<f32> = (0..count).map(|i| weight(float(i) - radius)).collect();
    let above: f32 = taps.iter().map(|tap| tap.max(0.0)).sum();
    let below: f32 = taps.iter().map(|tap| (-tap).max(0.0)).sum();
    taps.iter()
        .map(|&tap| match tap {
            tap if tap > 0.0 => tap / above,
            tap if tap < 0.0 => tap / below,
            _ => 0.0,
        })
        .collect()
}

/// A Gaussian of a contrast sensitivity, carried from frequencies to distances.
fn blur(breadth: f32, pixels_per_degree: f32) -> Vec<f32> {
    // All filters end with the broadest, at three of its standard deviations, or where they vanish.
    let end = 3.0 * (BLUE_YELLOW[0] * 0.5).sqrt() / PI * pixels_per_degree;
    let visible = (NEGLIGIBLE * breadth).sqrt() / PI * pixels_per_degree;
    taps(end.min(visible).ceil(), |x| {
        let degrees = x / pixels_per_degree;
        libm::expf(-PI * PI / breadth * degrees * degrees)
    })
}

/// Power of the colour distance from green to blue, the largest there is.
fn farthest_colours() -> f32 {
    let [green, blue] =
        [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| lab_from_opponent(opponent_from_rgb(rgb)));
    let distance = (green[0] - blue[0]).abs() + length(green[1] - blue[1], green[2] - blue[2]);
    power(distance, COLOUR_POWER)
}

// --- one picture ---

/// Pixels that a filter works on at once.
const BLOCK: usize = 16;

/// One picture, looked at row by row from the top.
struct View<'a> {
    image: &'a Image<[u8; 3]>,
    eye: &'a Eye,
    /// Rows filtered along so far.
    filtered: usize,
    /// The last rows filtered along, in the order of [`Eye::along_rows`]: as many as the filters reach
    /// over, the place of each its number modulo that, each padded to whole blocks.
    planes: [Vec<f32>; 7],
    /// Opponent channels of one row, widened by the filters' reach at both ends.
    channels: [Vec<f32>; 3],
    /// Lightness and the two axes of colour, in the row looked at.
    lab: [Vec<f32>; 3],
    /// How much of an edge there is.
    edges: Vec<f32>,
    /// How much of a point or a line there is.
    points: Vec<f32>,
    spare: Vec<f32>,
}

impl<'a> View<'a> {
    fn new(image: &'a Image<[u8; 3]>, eye: &'a Eye) -> Self {
        let stride = (image.width() as usize).next_multiple_of(BLOCK);
        let rows = |count: usize| vec![0.0; stride * count];
        Self {
            image,
            eye,
            filtered: 0,
            planes: core::array::from_fn(|_| rows(2 * eye.reach + 1)),
            channels: core::array::from_fn(|_| vec![0.0; stride + 2 * eye.reach]),
            lab: core::array::from_fn(|_| rows(1)),
            edges: rows(1),
            points: rows(1),
            spare: rows(1),
        }
    }

    /// Length of a row with its padding.
    fn stride(&self) -> usize {
        self.spare.len()
    }

    /// Finds colours and features of row `y`, which is the first or the one after the last looked at.
    fn look_at_row(&mut self, y: usize) {
        let height = self.image.height() as usize;
        while self.filtered < height.min(y + self.eye.reach + 1) {
            self.filter_along_next_row();
        }
        let eye = self.eye;
        let column = Column {
            y,
            last: height - 1,
            depth: 2 * eye.reach + 1,
        };
        let [light, red_green, wide, narrow, smooth, slope, bend] = &self.planes;
        let (lab, spare) = (&mut self.lab, &mut self.spare);
        column.filter(light, &eye.achromatic, &mut lab[0]);
        column.filter(red_green, &eye.red_green, &mut lab[1]);
        column.filter(wide, &eye.blue_yellow_shared[0], &mut lab[2]);
        column.filter(narrow, &eye.blue_yellow_shared[1], spare);
        for (sum, part) in lab[2].iter_mut().zip(&*spare) {
            *sum += part;
        }
        lab_row_from_opponent(lab);
        column.filter(slope, &eye.smooth, &mut self.edges);
        column.filter(smooth, &eye.slope, spare);
        lengths(&mut self.edges, spare);
        column.filter(bend, &eye.smooth, &mut self.points);
        column.filter(smooth, &eye.bend, spare);
        lengths(&mut self.points, spare);
    }

    fn filter_along_next_row(&mut self) {
        let (eye, stride) = (self.eye, self.stride());
        let width = self.image.width() as usize;
        let pixels = &self.image.texels()[self.filtered * width..][..width];
        widen_row(pixels, eye, &mut self.channels);
        let place = self.filtered % (2 * eye.reach + 1);
        for (plane, (channel, taps)) in self.planes.iter_mut().zip(eye.along_rows()) {
            let source = &self.channels[channel][eye.reach - taps.len() / 2..];
            filter_row(source, taps, &mut plane[place * stride..][..stride]);
        }
        self.filtered += 1;
    }
}

/// Opponent channels of a row of pixels, with its end pixels repeated past the ends.
fn widen_row(pixels: &[[u8; 3]], eye: &Eye, channels: &mut [Vec<f32>; 3]) {
    let (start, end) = (eye.reach, eye.reach + pixels.len());
    for (i, pixel) in (start..end).zip(pixels) {
        let rgb = pixel.map(|byte| eye.light[usize::from(byte)]);
        for (channel, value) in channels.iter_mut().zip(opponent_from_rgb(rgb)) {
            channel[i] = value;
        }
    }
    for channel in channels {
        let (first, last) = (channel[start], channel[end - 1]);
        channel[..start].fill(first);
        channel[end..].fill(last);
    }
}

/// `out[i]` = the taps times `source[i..]`.
fn filter_row(source: &[f32], taps: &[f32], out: &mut [f32]) {
    for (i, out) in out.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
        let mut sum = [0.0; BLOCK];
        for (tap, from) in taps.iter().zip(source[i * BLOCK..].array_windows()) {
            add_scaled(&mut sum, *tap, from);
        }
        *out = sum;
    }
}

/// Which row to filter down the columns, in planes that hold the last `depth` rows up to row `last`.
#[derive(Clone, Copy)]
struct Column {
    y: usize,
    last: usize,
    depth: usize,
}

impl Column {
    fn filter(self, plane: &[f32], taps: &[f32], out: &mut [f32]) {
        let stride = out.len();
        let rows = (0..taps.len()).map(|k| {
            let row = (self.y + k).saturating_sub(taps.len() / 2).min(self.last);
            row % self.depth * stride
        });
        let starts: Vec<usize> = rows.collect();
        for (i, out) in out.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
            let mut sum = [0.0; BLOCK];
            for (tap, start) in taps.iter().zip(&starts) {
                if let Some(from) = plane[start + i * BLOCK..].first_chunk() {
                    add_scaled(&mut sum, *tap, from);
                }
            }
            *out = sum;
        }
    }
}

#[inline]
fn add_scaled(sum: &mut [f32; BLOCK], factor: f32, from: &[f32; BLOCK]) {
    for (sum, from) in sum.iter_mut().zip(from) {
        *sum += factor * from;
    }
}

/// Lengths of the vectors (x, y), over the x.
fn lengths(x: &mut [f32], y: &[f32]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x = length(*x, *y);
    }
}

fn lab_row_from_opponent([a, b, c]: &mut [Vec<f32>; 3]) {
    for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
        [*a, *b, *c] = lab_from_opponent([*a, *b, *c]);
    }
}

// --- two pictures ---

fn errors_of_row(a: &View, b: &View, eye: &Eye, errors: &mut [f32]) {
    for (error, (a, b)) in errors.iter_mut().zip(a.lab[0].iter().zip(&b.lab[0])) {
        *error = (a - b).abs();
    }
    let reds = a.lab[1].iter().zip(&b.lab[1]);
    let yellows = a.lab[2].iter().zip(&b.lab[2]);
    for ((error, red), yellow) in errors.iter_mut().zip(reds).zip(yellows) {
        *error += length(red.0 - red.1, yellow.0 - yellow.1);
    }
    let edges = a.edges.iter().zip(&b.edges);
    let points = a.points.iter().zip(&b.points);
    for ((error, edge), point) in errors.iter_mut().zip(edges).zip(points) {
        let feature = (edge.0 - edge.1).abs().max((point.0 - point.1).abs());
        *error = joined_error(*error, feature, eye.farthest);
    }
}

/// The error from the distance of colours and the difference of features.
#[inline]
fn joined_error(distance: f32, feature: f32, farthest: f32) -> f32 {
    let distance = power(distance, COLOUR_POWER);
    let knee = KNEE * farthest;
    let near = distance * (KNEE_ERROR / knee);
    let far = KNEE_ERROR + (distance - knee) * ((1.0 - KNEE_ERROR) / (farthest - knee));
    let colour = if distance < knee { near } else { far };
    let feature = (feature * core::f32::consts::FRAC_1_SQRT_2).sqrt();
    power(colour.min(1.0), (1.0 - feature).max(0.0))
}

// --- colours ---

/// The paper's `YCxCz` without its fixed factors and offset: light, and how red and blue differ from it.
#[inline]
fn opponent_from_rgb(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = product(&RATIOS_FROM_RGB, rgb);
    [y, x - y, y - z]
}

/// CIELAB with the Hunt effect: the darker, the nearer to grey. Colours that no screen shows are clamped.
#[inline]
fn lab_from_opponent([light, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let ratios = [light + red_green, light, light - blue_yellow];
    let rgb = product(&RGB_FROM_RATIOS, ratios).map(|x| x.clamp(0.0, 1.0));
    let [x, y, z] = product(&RATIOS_FROM_RGB, rgb).map(|ratio| {
        // Below the cube of 6/29 the root is replaced by its tangent.
        let root = cube_root(ratio.max(0.008));
        if ratio > 216.0 / 24389.0 {
            root
        } else {
            ratio * (841.0 / 108.0) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

#[inline]
fn product(matrix: &[[f32; 3]; 3], [a, b, c]: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * a + row[1] * b + row[2] * c)
}

// --- arithmetic ---

#[inline]
fn length(x: f32, y: f32) -> f32 {
    (x * x + y * y).sqrt()
}

/// Cube root of a positive number that is not subnormal, to the last bit or two.
#[inline]
fn cube_root(x: f32) -> f32 {
    // A number's bits are nearly its logarithm, so a third of them, counted from those of 1, is near
    // the root. Each of Halley's steps triples the right digits.
    const TWO_THIRDS_OF_ONE: u32 = 1.0_f32.to_bits() / 3 * 2;
    let mut root = f32::from_bits(x.to_bits() / 3 + TWO_THIRDS_OF_ONE);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    root
}

/// `x` to a power of 0..=1, to six digits, for `x` in 0..=1000; 0 to any power is 0.
#[inline]
fn power(x: f32, exponent: f32) -> f32 {
    let raised = exp2(exponent * log2(x.max(1e-30)));
    if x > 0.0 { raised } else { 0.0 }
}

/// Logarithm of a positive number that is not subnormal.
#[inline]
fn log2(x: f32) -> f32 {
    // x = 2^whole * part, the part between the roots of 1/2 and 2.
    let offset = x
        .to_bits()
        .wrapping_sub(core::f32::consts::FRAC_1_SQRT_2.to_bits());
    let whole = offset.cast_signed() >> 23;
    let part = f32::from_bits(x.to_bits().wrapping_sub((whole << 23).cast_unsigned()));
    let s = (part - 1.0) / (part + 1.0);
    let s2 = s * s;
    let series = 1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0))));
    whole as f32 + 2.0 * core::f32::consts::LOG2_E * s * series
}

/// Two to a power of -120..=120.
#[inline]
fn exp2(x: f32) -> f32 {
    // Adding this number rounds to whole ones and leaves them in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    let shifted = x + ROUND;
    let whole = shifted.to_bits() << 23;
    let t = (x - (shifted - ROUND)) * core::f32::consts::LN_2;
    let series = 1.0 + t * (1.0 / 5.0) * (1.0 + t * (1.0 / 6.0));
    let series = 1.0 + t * (1.0 / 3.0) * (1.0 + t * (1.0 / 4.0) * series);
    let series = 1.0 + t * (1.0 + t * (1.0 / 2.0) * series);
    f32::from_bits(series.to_bits().wrapping_add(whole))
}

#[cfg(test)]
mod tests;
