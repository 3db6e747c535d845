//! Leaf cards: one blade, or a sprig of several, with its stalk at the middle of the lower edge.
//!
//! Each texel takes a grid of samples. A sample is brought into the frame of each blade near it,
//! topmost first; the first blade that covers it is the one seen, and those passed over on the way
//! cast their shade on it. So the cost is samples times near blades, with no search for distances.

use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use rand::Rng;

use super::blade::Outline;
use super::sprig::{Card, PETIOLE_RADIUS, PlacedBlade, SHADE_REACH, Sprig, sprig};
use super::texels_from_rows;
use crate::image::{Image, Texel};
use crate::math::{Vec2, Vec3, lerp, smoothstep};
use crate::rng::{Key, Parameter};
use crate::species::schema::{Arrangement, LeafArt, LeafKind};

/// Samples a texel takes along each side.
const GRID: u8 = 4;
/// Free border on every side, texels: the border texel stays transparent in the next mip as well.
const BORDER_TEXELS: f32 = 1.5;
/// Slope of each half of a blade, up from its midrib, where the card itself is not folded.
const FOLD: f32 = 0.2;
/// Occlusion in the deepest shade of another blade.
const SHADE: f32 = 0.5;
/// Factors on the blade's colour where a vein is palest.
const VEIN_TINT: [f32; 3] = [1.75, 1.55, 1.45];

/// The picture of a leaf card, `width` by `height` texels; the stalk is at the middle of the lower
/// edge and the tip is up. The border texels are transparent.
///
/// `art` is what `kind.look` holds. Transparent texels carry the nearest leaf texel's values with
/// alpha 0, so that filtering brings in no foreign colour. Depth is 0. Any size is valid.
#[must_use]
pub fn leaf(kind: &LeafKind, art: &LeafArt, seed: u64, width: u32, height: u32) -> Image<Texel> {
    let painter = Painter::new(kind, art, seed, width, height);
    let texels = texels_from_rows(width, height, Texel::EMPTY, |x, y| {
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            Texel::EMPTY
        } else {
            painter.texel(x, y)
        }
    });
    let mut image = Image::from_texels(width, height, texels);
    fill_transparent(&mut image, art.colour);
    image
}

/// All that a texel's evaluation needs.
struct Painter<'a> {
    art: &'a LeafArt,
    outline: Outline,
    sprig: Sprig,
    card: Card,
    /// Size of a texel, card lengths.
    texel: Vec2,
    fold: f32,
    mottle: FastNoiseLite,
}

/// What is on top at one point of the card.
#[derive(Clone, Copy)]
enum Hit<'a> {
    /// A blade, with the place in its frame.
    Blade(&'a PlacedBlade, f32, f32),
    /// The twig, with the place across it.
    Twig(f32),
}

/// What one sample sees.
#[derive(Clone, Copy, Default)]
struct Sample {
    albedo: Vec3,
    normal: Vec3,
    occlusion: f32,
    roughness: f32,
    translucency: f32,
}

impl Sample {
    fn add(&mut self, other: &Self) {
        self.albedo += other.albedo;
        self.normal += other.normal;
        self.occlusion += other.occlusion;
        self.roughness += other.roughness;
        self.translucency += other.translucency;
    }
}

impl<'a> Painter<'a> {
    fn new(kind: &LeafKind, art: &'a LeafArt, seed: u64, width: u32, height: u32) -> Self {
        let aspect = (kind.width_m / kind.length_m).clamp(0.01, 100.0);
        let texel = Vec2::new(aspect / width.max(1) as f32, 1.0 / height.max(1) as f32);
        let card = Card {
            half_width: 0.5 * aspect,
            border: texel * BORDER_TEXELS,
        };
        let single = art.arrangement == Arrangement::Single;
        let half = if single {
            // Fills the card, whatever its shape; a little room is left for the midrib's bow.
            0.985 * (card.half_width - card.border.x).max(0.0)
                / (1.0 - 2.0 * card.border.y).max(0.1)
        } else {
            0.5 * art.blade.width
        };
        let outline = Outline::new(&art.blade, half);
        let mut draws = Key::of_seed(seed)
            .level("mottle")
            .stream(Parameter::Texture);
        let mut mottle = FastNoiseLite::with_seed((draws.next_u32() >> 1).cast_signed());
        mottle.set_noise_type(Some(NoiseType::OpenSimplex2));
        mottle.set_fractal_type(Some(FractalType::FBm));
        mottle.set_fractal_octaves(Some(3));
        mottle.set_frequency(Some(if single { 16.0 } else { 30.0 }));
        Self {
            art,
            sprig: sprig(art, &outline, &card, seed),
            outline,
            card,
            texel,
            fold: if single && kind.fold_deg != 0.0 {
                0.0
            } else {
                FOLD
            },
            mottle,
        }
    }

    fn texel(&self, x: u32, y: u32) -> Texel {
        let corner = Vec2::new(
            x as f32 * self.texel.x - self.card.half_width,
            1.0 - y as f32 * self.texel.y,
        );
        let centre = corner + self.texel * Vec2::new(0.5, -0.5);
        let reach = self.texel.max_element();
        let blades: Vec<usize> = (0..self.sprig.blades.len())
            .filter(|&i| self.sprig.blades[i].near(centre, reach))
            .collect();
        let on_twig = self.sprig.twig.filter(|_| centre.x.abs() < 0.06);
        if blades.is_empty() && on_twig.is_none() {
            return Texel::EMPTY;
        }
        let mottle = self.mottle.get_noise_2d(centre.x, centre.y);
        let mut sum = Sample::default();
        let (mut covered, mut shaded) = (0_u8, 0.0);
        for j in 0..GRID {
            for i in 0..GRID {
                let step = Vec2::new(f32::from(i) + 0.5, -f32::from(j) - 0.5) / f32::from(GRID);
                let Some((hit, shade)) = self.hit(corner + self.texel * step, &blades) else {
                    continue;
                };
                covered += 1;
                // Coverage needs every sample; colour is smooth enough for one in each row and
                // column, and where none of those hit, for the first that does.
                if (2 * i + j / 2 + j) % GRID == 1 || covered == 1 {
                    sum.add(&self.shaded(&hit, shade, mottle));
                    shaded += 1.0;
                }
            }
        }
        if covered == 0 {
            return Texel::EMPTY;
        }
        Texel {
            albedo: (sum.albedo / shaded).to_array(),
            alpha: f32::from(covered) / f32::from(GRID * GRID),
            normal: sum.normal.normalize_or(Vec3::Z).to_array(),
            occlusion: sum.occlusion / shaded,
            roughness: sum.roughness / shaded,
            translucency: sum.translucency / shaded,
            depth: 0.0,
        }
    }

    /// What is on top at a point of the card, if anything, and how much those above shade it (0
    /// not ..= 1 most); `near` are blades in order.
    fn hit(&self, point: Vec2, near: &[usize]) -> Option<(Hit<'_>, f32)> {
        let mut shade: f32 = 0.0;
        let mut twig = self.sprig.twig;
        for &index in near {
            if index >= self.sprig.above_twig
                && let Some(twig) = twig.take()
                && let Some(across) = twig.across(point, self.card.border.y)
            {
                return Some((Hit::Twig(across), shade));
            }
            let blade = &self.sprig.blades[index];
            let (u, v) = blade.local(point);
            let Some(away) = blade.outside(&self.outline, u, v) else {
                return Some((Hit::Blade(blade, u, v), shade));
            };
            shade = shade.max(1.0 - away / SHADE_REACH);
        }
        let across = twig?.across(point, self.card.border.y)?;
        Some((Hit::Twig(across), shade))
    }

    fn shaded(&self, hit: &Hit<'_>, shade: f32, mottle: f32) -> Sample {
        match *hit {
            Hit::Twig(across) => self.on_twig(across, shade, mottle),
            Hit::Blade(blade, u, v) if u < 0.0 => self.on_petiole(blade, v, shade),
            Hit::Blade(blade, u, v) => self.on_blade(blade, u, v, shade, mottle),
        }
    }

    fn on_twig(&self, across: f32, shade: f32, mottle: f32) -> Sample {
        let colour = Vec3::from_array(self.art.stalk_colour) * (1.0 + 0.25 * mottle);
        Sample {
            albedo: colour.clamp(Vec3::ZERO, Vec3::ONE),
            normal: round_normal(across),
            occlusion: lerp(1.0, SHADE, shade * shade),
            roughness: 0.8,
            translucency: 0.0,
        }
    }

    fn on_petiole(&self, blade: &PlacedBlade, v: f32, shade: f32) -> Sample {
        let colour = Vec3::from_array(self.art.colour) * Vec3::from_array(VEIN_TINT);
        let slope = blade.card_slope(Vec2::new(0.0, -v / PETIOLE_RADIUS));
        Sample {
            albedo: colour
                .lerp(Vec3::from_array(self.art.stalk_colour), 0.5)
                .clamp(Vec3::ZERO, Vec3::ONE),
            normal: Vec3::new(-slope.x, -slope.y, 1.0).normalize_or(Vec3::Z),
            occlusion: 0.85 * lerp(1.0, SHADE, shade * shade),
            roughness: 0.7,
            translucency: 0.0,
        }
    }

    fn on_blade(&self, blade: &PlacedBlade, u: f32, v: f32, shade: f32, mottle: f32) -> Sample {
        let shaded = lerp(1.0, SHADE, shade * shade);
        let surface = self.outline.surface(u, v, self.fold, blade.shift);
        let mut colour = Vec3::from_array(self.art.colour) * Vec3::from_array(blade.tint);
        colour *= (1.0 + 0.14 * mottle) * lerp(0.92, 1.08, surface.margin);
        let back = if blade.underside { 1.0 } else { 0.0 };
        // Undersides are paler and greyer: hairs and air under the skin.
        let grey = Vec3::splat(colour.dot(Vec3::new(0.3, 0.6, 0.1)));
        colour = colour.lerp(grey, 0.35 * back) * (1.0 + 0.4 * back);
        let vein_tint = Vec3::ONE.lerp(Vec3::from_array(VEIN_TINT), 0.75 * surface.vein);
        let inner = 1.0 - smoothstep(0.0, 0.3, u);
        let sides = if self.sprig.twig.is_some() {
            0.22
        } else {
            0.06
        };
        let slope = blade.card_slope(surface.slope);
        Sample {
            albedo: (colour * vein_tint).clamp(Vec3::ZERO, Vec3::ONE),
            normal: Vec3::new(-slope.x, -slope.y, 1.0).normalize_or(Vec3::Z),
            occlusion: shaded * (1.0 - sides * inner),
            roughness: (lerp(0.85, 0.3, self.art.gloss) + 0.08 * surface.vein + 0.12 * back)
                .clamp(0.0, 1.0),
            translucency: (self.art.translucency * (1.0 - 0.6 * surface.vein)).clamp(0.0, 1.0),
        }
    }
}

/// The normal of an upright round stalk, from the place across it, -1..=1.
fn round_normal(across: f32) -> Vec3 {
    let x = across.clamp(-0.95, 0.95);
    Vec3::new(x, 0.0, (1.0 - x * x).sqrt()).normalize_or(Vec3::Z)
}

/// Gives transparent texels the values of a near leaf texel (two sweeps of nearest-source
/// propagation, after Danielsson 1980), keeping alpha 0; `colour` if there is no leaf at all.
fn fill_transparent(image: &mut Image<Texel>, colour: [f32; 3]) {
    let (width, height) = (image.width(), image.height());
    let mut sources: Vec<Option<(u32, u32)>> = Vec::with_capacity(image.texels().len());
    for y in 0..height {
        for x in 0..width {
            sources.push((image.at(x, y).alpha > 0.0).then_some((x, y)));
        }
    }
    let forward = [(-1, 0), (-1, -1), (0, -1), (1, -1)];
    let backward = forward.map(|(dx, dy): (i32, i32)| (-dx, -dy));
    for y in 0..height {
        for x in 0..width {
            adopt(&mut sources, (width, height), (x, y), &forward);
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            adopt(&mut sources, (width, height), (x, y), &backward);
        }
    }
    for (index, source) in sources.into_iter().enumerate() {
        if image.texels()[index].alpha > 0.0 {
            continue;
        }
        let near = source.map_or(
            Texel {
                albedo: colour,
                ..Texel::EMPTY
            },
            |(x, y)| *image.at(x, y),
        );
        image.texels_mut()[index] = Texel { alpha: 0.0, ..near };
    }
}

/// Takes over the source of a neighbour if it is nearer than the texel's own.
fn adopt(
    sources: &mut [Option<(u32, u32)>],
    (width, height): (u32, u32),
    (x, y): (u32, u32),
    steps: &[(i32, i32)],
) {
    let index = |x: u32, y: u32| y as usize * width as usize + x as usize;
    let distance = |(sx, sy): (u32, u32)| {
        let (dx, dy) = (u64::from(sx.abs_diff(x)), u64::from(sy.abs_diff(y)));
        dx * dx + dy * dy
    };
    let own = index(x, y);
    let mut best = sources[own].map_or(u64::MAX, distance);
    for &(dx, dy) in steps {
        let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if nx >= width || ny >= height || best == 0 {
            continue;
        }
        if let Some(source) = sources[index(nx, ny)]
            && distance(source) < best
        {
            best = distance(source);
            sources[own] = Some(source);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::schema::{Blade, LeafLook};

    const COLOUR: [f32; 3] = [0.06, 0.12, 0.03];

    fn art(arrangement: Arrangement) -> LeafArt {
        LeafArt {
            arrangement,
            blade: Blade {
                width: 0.25,
                widest: 0.5,
                sharpness: 0.5,
                teeth: 0,
                tooth_depth: 0.0,
                veins: 6,
            },
            colour: COLOUR,
            colour_vary: 0.1,
            stalk_colour: [0.15, 0.12, 0.08],
            gloss: 0.4,
            translucency: 0.5,
        }
    }

    fn card(arrangement: Arrangement, seed: u64, width: u32, height: u32) -> Image<Texel> {
        let art = art(arrangement);
        let kind = LeafKind {
            name: String::from("leaf"),
            length_m: 0.12,
            width_m: 0.08,
            fold_deg: 0.0,
            look: LeafLook::Drawn(art.clone()),
        };
        leaf(&kind, &art, seed, width, height)
    }

    const OPPOSITE: Arrangement = Arrangement::Opposite {
        pairs: 3,
        angle_deg: 50.0,
        blade: 0.4,
    };
    const ALTERNATE: Arrangement = Arrangement::Alternate {
        count: 4,
        angle_deg: 60.0,
        blade: 0.4,
    };

    #[test]
    fn the_border_is_transparent_and_the_stalk_is_at_the_foot() {
        for arrangement in [Arrangement::Single, OPPOSITE, ALTERNATE] {
            let card = card(arrangement, 2, 64, 96);
            for i in 0..64 {
                assert_eq!(card.at(i, 0).alpha + card.at(i, 95).alpha, 0.0);
            }
            for i in 0..96 {
                assert_eq!(card.at(0, i).alpha + card.at(63, i).alpha, 0.0);
            }
            assert!(card.at(31, 93).alpha + card.at(32, 93).alpha > 0.3);
        }
    }

    #[test]
    fn an_elliptic_blade_covers_the_area_of_an_ellipse() {
        let card = card(Arrangement::Single, 4, 192, 288);
        let covered: f32 = card.texels().iter().map(|texel| texel.alpha).sum();
        let share = covered / (192.0 * 288.0);
        let ellipse = crate::math::PI / 4.0;
        assert!((0.94..=1.0).contains(&(share / ellipse)), "{share}");
    }

    #[test]
    fn normals_are_unit_and_hidden_texels_have_leaf_colours() {
        for arrangement in [Arrangement::Single, OPPOSITE, ALTERNATE] {
            for texel in card(arrangement, 2, 48, 72).texels() {
                let [x, y, z] = texel.normal;
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-4 && z > 0.0);
                assert!((0.03..0.3).contains(&texel.albedo[1]), "{texel:?}");
                assert!((0.0..=1.0).contains(&texel.occlusion));
                assert!((0.0..=0.5).contains(&texel.translucency));
            }
        }
    }

    #[test]
    fn blades_of_a_sprig_do_not_shade_as_one_flat_card() {
        let dense = Arrangement::Opposite {
            pairs: 6,
            angle_deg: 40.0,
            blade: 0.45,
        };
        let card = card(dense, 2, 64, 96);
        let seen = || card.texels().iter().filter(|texel| texel.alpha > 0.9);
        let count = seen().count() as f32;
        let mean: f32 = seen().map(|texel| texel.normal[0]).sum::<f32>() / count;
        let spread: f32 = seen().map(|texel| (texel.normal[0] - mean).abs()).sum();
        assert!(spread / count > 0.1, "{}", spread / count);
        assert!(seen().any(|texel| texel.occlusion < 0.75));
    }

    #[test]
    fn the_seed_alone_decides_whatever_the_threads() {
        let draw = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| card(ALTERNATE, seed, 32, 48))
        };
        assert_eq!(draw(1, 8), draw(3, 8));
        assert_ne!(draw(1, 8), draw(1, 9));
    }

    #[test]
    fn degenerate_cards_are_drawn_without_fault() {
        for size in 0..5 {
            assert_eq!(
                card(OPPOSITE, 1, size, size).texels().len(),
                (size * size) as usize
            );
        }
        let none = Arrangement::Alternate {
            count: 0,
            angle_deg: 400.0,
            blade: 9.0,
        };
        assert!(
            card(none, 1, 16, 16)
                .texels()
                .iter()
                .all(|texel| texel.alpha <= 1.0)
        );
    }

    #[test]
    fn a_sprig_has_this_silhouette() {
        let card = card(OPPOSITE, 2, 24, 24);
        let rows: Vec<String> = card
            .texels()
            .chunks(24)
            .map(|row| {
                let sign = |alpha: f32| match alpha {
                    0.5.. => '#',
                    0.15.. => '+',
                    _ => '.',
                };
                row.iter().map(|texel| sign(texel.alpha)).collect()
            })
            .collect();
        let expected: [&str; 24] = [
            "........................",
            "...........++...........",
            "...........##+..........",
            "...........###..........",
            "..........+###..........",
            "..........+###.....+....",
            "...++.....+###...+##....",
            "...###....+###..+###....",
            "....###+...###.####+....",
            "....+####..##.####+.....",
            "......####.++####+......",
            "..+....+###+####....+#+.",
            ".+###.....++##....####..",
            "..+####+...+....#####...",
            "....#####+.+..+#####....",
            "......#####+.####+..##+.",
            ".+##+....+##+#++.+####..",
            "..+####....+...+#####...",
            "...+#####..+..#####+....",
            ".....+#####++####+......",
            ".........+++#++.........",
            "...........++...........",
            "........................",
            "........................",
        ];
        assert_eq!(rows, expected, "{}", rows.join("\n"));
    }
}
