//! Leaf cards: one leaf or a spray of many, with the stalk at the middle of the lower edge.
//!
//! A blade is described once (`outline`, `margin`, `veins`) and becomes a map of signed distances,
//! veins and slopes (`blade`). A leaf is blades on a stalk (`compound`); a card is leaves on twigs
//! (`card`). A texel takes samples: what is topmost there is seen, and blades passed over on the way
//! cast their shade. Alpha, normal, roughness, translucency and colour (`colour`) all follow from the
//! one distance.

mod blade;
mod card;
mod colour;
mod compound;
mod distance;
mod fill;
mod margin;
mod outline;
mod place;
mod veins;

pub use colour::reflectance;

use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use rand::Rng;

use self::blade::{BladeMap, Place};
use self::card::Card;
use self::colour::{Palette, Spot};
use self::place::{Element, Paint, Pose, Shape};
use super::noise::Periodic;
use super::texels_from_rows;
use crate::image::{Image, Texel};
use crate::math::{Vec2, Vec3, float, lerp, smoothstep};
use crate::rng::{Key, Parameter};
use crate::species::schema::{
    Arrangement, Blade, Form, LeafArt, LeafKind, LeafState, Lobes, Veins,
};

/// Samples along each side of a texel that an outline crosses.
const GRID: u8 = 4;
/// Samples along each side of a texel within one blade.
const INNER: u8 = 2;
/// Free border on every side, texels: the border texel stays transparent in the next mip as well.
const BORDER_TEXELS: f32 = 1.5;
/// Slope of each half of a blade, up from its midrib, where the card itself is not folded.
const FOLD: f32 = 0.2;
/// Occlusion in the deepest shade of another blade.
const SHADE: f32 = 0.5;
/// Factors on the blade's colour where a vein is palest.
const VEIN_TINT: [f32; 3] = [1.75, 1.55, 1.45];
/// Edge of a tile of the card that keeps a list of what is on it, texels.
const TILE: u32 = 16;
/// Things that one texel looks at, topmost first.
const DEEPEST: usize = 24;

/// The picture of a leaf card, `width` by `height` texels; the stalk is at the middle of the lower
/// edge and the tip is up. The border texels are transparent.
///
/// `art` is what `kind.look` holds; `state` is the season, age and health to draw it in, usually
/// `art.state`. Transparent texels carry the nearest leaf texel's values with alpha 0, so that
/// filtering brings in no foreign colour. Depth is 0. Any size is valid.
#[must_use]
pub fn leaf(
    kind: &LeafKind,
    art: &LeafArt,
    state: LeafState,
    seed: u64,
    width: u32,
    height: u32,
) -> Image<Texel> {
    let painter = Painter::new(kind, art, state, seed, [width, height]);
    let texels = texels_from_rows(width, height, Texel::EMPTY, |x, y| {
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            Texel::EMPTY
        } else {
            painter.texel(x, y)
        }
    });
    let mut image = Image::from_texels(width, height, texels);
    fill::fill_transparent(&mut image, painter.palette.green().to_array());
    image
}

/// Leaves that [`leaf`] draws on a card, for a seed; a compound leaf is one.
#[must_use]
pub fn leaves_on(kind: &LeafKind, art: &LeafArt, seed: u64) -> u32 {
    let blades = |art: &LeafArt| {
        let painter = Painter::new(kind, art, art.state, seed, [64, 64]);
        let is_leaf = |element: &&Element| {
            element.paint == Paint::Leaf && matches!(element.shape, Shape::Blade(_))
        };
        painter.elements.iter().filter(is_leaf).count()
    };
    let one = LeafArt {
        arrangement: Arrangement::Single,
        spray: None,
        ..art.clone()
    };
    u32::try_from(blades(art) / blades(&one).max(1)).unwrap_or(u32::MAX)
}

/// The outline of one blade as a closed polygon, anticlockwise from the foot: the midrib runs along +x
/// from 0 (where the stalk joins) to about 1 (the tip), in parts of the blade's length.
#[must_use]
pub fn blade_outline(blade: &Blade) -> Vec<[f32; 2]> {
    let polygon = outline::polygon(blade);
    polygon.iter().map(|point| point.to_array()).collect()
}

/// All that a texel's evaluation needs.
struct Painter<'a> {
    art: &'a LeafArt,
    palette: Palette,
    maps: Vec<BladeMap>,
    /// Topmost first.
    elements: Vec<Element>,
    /// For each tile, row by row, the elements on it or whose shade may fall on it.
    tiles: Vec<Vec<u32>>,
    tiles_across: u32,
    half_width: f32,
    /// Size of a texel, card lengths.
    texel: Vec2,
    fold: f32,
    mottle: FastNoiseLite,
    spots: Periodic,
    holes: Periodic,
}

/// A thing that a texel may show.
#[derive(Clone, Copy, Default)]
struct Near {
    index: u32,
    /// Shade that falls on it from things beside the texel, 0..=1.
    shade: f32,
    /// True if there is a hole in it near the texel.
    eaten: bool,
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

    fn texel(&self, count: f32, alpha: f32) -> Texel {
        Texel {
            albedo: (self.albedo / count)
                .clamp(Vec3::ZERO, Vec3::ONE)
                .to_array(),
            alpha,
            normal: self.normal.normalize_or(Vec3::Z).to_array(),
            occlusion: self.occlusion / count,
            roughness: (self.roughness / count).clamp(0.0, 1.0),
            translucency: (self.translucency / count).clamp(0.0, 1.0),
            depth: 0.0,
        }
    }
}

impl<'a> Painter<'a> {
    fn new(
        kind: &LeafKind,
        art: &'a LeafArt,
        state: LeafState,
        seed: u64,
        [width, height]: [u32; 2],
    ) -> Self {
        let aspect = (kind.width_m / kind.length_m).clamp(0.01, 100.0);
        let texel = Vec2::new(aspect / width.max(1) as f32, 1.0 / height.max(1) as f32);
        let card = Card {
            half_width: 0.5 * aspect,
            border: texel * BORDER_TEXELS,
        };
        let lone = art.arrangement == Arrangement::Single && art.form == Form::Simple;
        let (mut maps, single) = if lone {
            let (map, pose) = filling(art, &card, seed, height);
            (vec![map], Some(pose))
        } else {
            let texels = float(height) * longest_blade(art);
            (vec![BladeMap::new(&art.blade, texels)], None)
        };
        if let Some(flowers) = art.flowers {
            maps.push(BladeMap::new(&PETAL, float(height) * 0.5 * flowers.size));
        }
        let elements = card::elements(art, &maps, &card, single, seed);
        let key = Key::of_seed(seed).level("mottle");
        let mut draws = key.stream(Parameter::Texture);
        let mut mottle = FastNoiseLite::with_seed((draws.next_u32() >> 1).cast_signed());
        mottle.set_noise_type(Some(NoiseType::OpenSimplex2));
        mottle.set_fractal_type(Some(FractalType::FBm));
        mottle.set_fractal_octaves(Some(3));
        mottle.set_frequency(Some(if lone { 16.0 } else { 30.0 }));
        let palmate = matches!(art.blade.lobes, Lobes::Palmate { .. })
            || matches!(art.blade.veins, Veins::Palmate { .. });
        let folded = lone && (kind.fold_deg != 0.0 || palmate);
        let mut painter = Self {
            art,
            palette: Palette::new(art, state),
            maps,
            elements,
            tiles: Vec::new(),
            tiles_across: width.div_ceil(TILE),
            half_width: card.half_width,
            texel,
            fold: if folded || palmate { 0.0 } else { FOLD },
            mottle,
            spots: Periodic::new(draws.next_u32(), [9, 9]),
            holes: Periodic::new(draws.next_u32(), [5, 5]),
        };
        painter.tiles = painter.tiled(height.div_ceil(TILE));
        painter
    }

    /// Lists of what is on each tile, topmost first.
    fn tiled(&self, tiles_down: u32) -> Vec<Vec<u32>> {
        let mut tiles = vec![Vec::new(); self.tiles_across as usize * tiles_down as usize];
        let size = self.texel * TILE as f32;
        for (index, element) in (0_u32..).zip(&self.elements) {
            let pad = Vec2::splat(element.shade_reach()) + self.texel;
            let (low, high) = (element.low - pad, element.high + pad);
            let tile = |at: f32, size: f32, count: u32| {
                crate::math::floor_to_u32((at / size).max(0.0)).min(count.saturating_sub(1))
            };
            let columns = tile(low.x + self.half_width, size.x, self.tiles_across)
                ..=tile(high.x + self.half_width, size.x, self.tiles_across);
            let rows =
                tile(1.0 - high.y, size.y, tiles_down)..=tile(1.0 - low.y, size.y, tiles_down);
            for row in rows {
                for column in columns.clone() {
                    let middle = Vec2::new(
                        (float(column) + 0.5) * size.x - self.half_width,
                        1.0 - (float(row) + 0.5) * size.y,
                    );
                    // A blade seen aslant is a little nearer than its map says.
                    let near = 1.25 * (0.5 * size.length() + pad.length());
                    if element.outside(&self.maps, middle) > near {
                        continue;
                    }
                    let place = row as usize * self.tiles_across as usize + column as usize;
                    if let Some(list) = tiles.get_mut(place) {
                        list.push(index);
                    }
                }
            }
        }
        tiles
    }

    fn texel(&self, x: u32, y: u32) -> Texel {
        let tile = (y / TILE) as usize * self.tiles_across as usize + (x / TILE) as usize;
        let list = &self.tiles[tile];
        if list.is_empty() {
            return Texel::EMPTY;
        }
        let corner = Vec2::new(
            x as f32 * self.texel.x - self.half_width,
            1.0 - y as f32 * self.texel.y,
        );
        let centre = corner + self.texel * Vec2::new(0.5, -0.5);
        // Beyond this from an outline no sample of the texel is on the other side.
        let reach = 0.75 * self.texel.length();
        let mut near = [Near::default(); DEEPEST];
        let (mut count, mut solid, mut shade) = (0, false, 0.0_f32);
        for &index in list {
            let element = &self.elements[index as usize];
            let pad = Vec2::splat(element.shade_reach() + reach);
            if (centre.cmplt(element.low - pad) | centre.cmpgt(element.high + pad)).any() {
                continue;
            }
            let outside = element.outside(&self.maps, centre);
            if outside > reach {
                shade = shade.max(1.0 - outside / element.shade_reach().max(1e-6));
                continue;
            }
            let eaten = self.eaten(element, centre, reach);
            near[count] = Near {
                index,
                shade,
                eaten,
            };
            count += 1;
            solid = outside < -reach && !eaten;
            if solid || count == DEEPEST {
                break;
            }
        }
        let near = &near[..count];
        if near.is_empty() {
            return Texel::EMPTY;
        }
        let mottle = self.mottle.get_noise_2d(centre.x, centre.y);
        if solid && count == 1 {
            self.within(corner, near[0], mottle)
        } else {
            self.crossed(corner, near, mottle)
        }
    }

    /// A texel wholly within one thing.
    fn within(&self, corner: Vec2, near: Near, mottle: f32) -> Texel {
        let element = &self.elements[near.index as usize];
        let mut sum = Sample::default();
        for j in 0..INNER {
            for i in 0..INNER {
                let step = Vec2::new(f32::from(i) + 0.5, -f32::from(j) - 0.5) / f32::from(INNER);
                sum.add(&self.shaded(element, corner + self.texel * step, near.shade, mottle));
            }
        }
        sum.texel(f32::from(INNER * INNER), 1.0)
    }

    /// A texel that outlines cross.
    fn crossed(&self, corner: Vec2, near: &[Near], mottle: f32) -> Texel {
        let mut sum = Sample::default();
        let (mut covered, mut shaded) = (0_u8, 0.0);
        for j in 0..GRID {
            for i in 0..GRID {
                let step = Vec2::new(f32::from(i) + 0.5, -f32::from(j) - 0.5) / f32::from(GRID);
                let point = corner + self.texel * step;
                let Some((element, shade)) = self.hit(point, near) else {
                    continue;
                };
                covered += 1;
                // Coverage needs every sample; colour is smooth enough for one in each row and
                // column, and where none of those hit, for the first that does.
                if (2 * i + j / 2 + j) % GRID == 1 || covered == 1 {
                    sum.add(&self.shaded(element, point, shade, mottle));
                    shaded += 1.0;
                }
            }
        }
        if covered == 0 {
            return Texel::EMPTY;
        }
        sum.texel(shaded, f32::from(covered) / f32::from(GRID * GRID))
    }

    /// What is on top at a point, and how much it is shaded (0 not ..= 1 most).
    fn hit(&self, point: Vec2, near: &[Near]) -> Option<(&Element, f32)> {
        let mut own: f32 = 0.0;
        for near in near {
            let element = &self.elements[near.index as usize];
            let outside = element.outside(&self.maps, point);
            if outside < 0.0 && !(near.eaten && self.eaten(element, point, 0.0)) {
                return Some((element, near.shade.max(own)));
            }
            own = own.max(1.0 - outside.max(0.0) / element.shade_reach().max(1e-6));
        }
        None
    }

    /// True where an insect has been, or within `reach` of there.
    fn eaten(&self, element: &Element, point: Vec2, reach: f32) -> bool {
        if self.palette.ill <= 0.25 {
            return false;
        }
        let (Shape::Blade(pose), Paint::Leaf) = (&element.shape, element.paint) else {
            return false;
        };
        let local = pose.local(point);
        let hole = self
            .holes
            .cell(local.x + pose.shift, local.y + 2.3 * pose.shift);
        let reach = reach / pose.length * float(self.holes.cells()[0]);
        let ragged = 0.14 * self.spots.at(3.0 * local.x + pose.shift, 3.0 * local.y);
        hole.id < 0.5 * self.palette.ill && hole.centre < 0.12 + 0.4 * hole.id + ragged + reach
    }

    fn shaded(&self, element: &Element, point: Vec2, shade: f32, mottle: f32) -> Sample {
        let shaded = lerp(1.0, SHADE, shade * shade);
        match &element.shape {
            Shape::Stem(stem) => {
                let (_, across) = stem.outside(point);
                let along = (stem.to - stem.from).normalize_or(Vec2::Y);
                self.on_stem(element.paint, along, across, shaded, mottle)
            }
            Shape::Blade(pose) if element.paint == Paint::Petal => {
                self.on_petal(pose, point, shaded)
            }
            Shape::Blade(pose) => self.on_blade(pose, point, shaded, mottle),
        }
    }

    fn on_stem(&self, paint: Paint, along: Vec2, across: f32, shaded: f32, mottle: f32) -> Sample {
        let wood = Vec3::from_array(self.art.stalk_colour) * (1.0 + 0.25 * mottle);
        // Stalks turn last, as veins do.
        let (tissue, _) = self.palette.at(&Spot {
            along: 0.0,
            edge: 0.0,
            vein: 1.0,
            noise: mottle,
            haste: 0.0,
            blight: 0.0,
        });
        let green = tissue * Vec3::from_array(VEIN_TINT);
        let (albedo, roughness) = match paint {
            Paint::Wood => (wood, 0.8),
            Paint::Eye => (Vec3::new(0.42, 0.24, 0.05), 0.8),
            _ => (green.lerp(wood, 0.5), 0.7),
        };
        // The normal of a round rod.
        let x = across.clamp(-0.95, 0.95);
        let right = -along.perp();
        Sample {
            albedo,
            normal: Vec3::new(right.x * x, right.y * x, (1.0 - x * x).sqrt()).normalize_or(Vec3::Z),
            occlusion: 0.9 * shaded,
            roughness,
            translucency: 0.0,
        }
    }

    fn on_petal(&self, pose: &Pose, point: Vec2, shaded: f32) -> Sample {
        let local = pose.local(point);
        let place = self.maps[pose.map].at(local.x, local.y);
        let colour = self
            .art
            .flowers
            .map_or(Vec3::ONE, |f| Vec3::from_array(f.colour));
        let slope = pose.card_slope(place.slope * 0.6);
        // Deeper in colour toward the middle of the flower.
        let deep = 1.0 - smoothstep(0.0, 0.6, local.x);
        let tint = Vec3::from_array(pose.tint);
        Sample {
            albedo: colour * tint * Vec3::ONE.lerp(Vec3::new(0.95, 0.6, 0.7), 0.7 * deep),
            normal: Vec3::new(-slope.x, -slope.y, 1.0).normalize_or(Vec3::Z),
            occlusion: shaded * lerp(1.0, 0.8, deep),
            roughness: 0.6,
            translucency: 0.5,
        }
    }

    fn on_blade(&self, pose: &Pose, point: Vec2, shaded: f32, mottle: f32) -> Sample {
        let local = pose.local(point);
        let map = &self.maps[pose.map];
        let Place {
            outside,
            vein,
            mut slope,
        } = map.at(local.x, local.y);
        let rib = (0.14 * map.half).min(0.012);
        slope.y += self.fold * local.y / (local.y * local.y + rib * rib).sqrt();
        let edge = (1.0 + outside / (0.7 * map.half).max(1e-3)).clamp(0.0, 1.0);
        let (colour, through) = self.palette.at(&Spot {
            along: local.x.clamp(0.0, 1.0),
            edge,
            vein,
            noise: mottle,
            haste: pose.haste,
            blight: self.blight(pose, local),
        });
        let mut colour = colour * Vec3::from_array(pose.tint);
        colour *= (1.0 + 0.14 * mottle) * lerp(0.92, 1.08, edge);
        let back = if pose.underside { 1.0 } else { 0.0 };
        // Undersides are paler and greyer: hairs and air under the skin.
        let grey = Vec3::splat(colour.dot(Vec3::new(0.3, 0.6, 0.1)));
        colour = colour.lerp(grey, 0.35 * back) * (1.0 + 0.4 * back);
        let vein_tint = Vec3::ONE.lerp(Vec3::from_array(VEIN_TINT), 0.75 * vein);
        let inner = 1.0 - smoothstep(0.0, 0.3, local.x);
        let sides = if self.elements.len() > 2 { 0.22 } else { 0.06 };
        let slope = pose.card_slope(slope);
        Sample {
            albedo: colour * vein_tint,
            normal: Vec3::new(-slope.x, -slope.y, 1.0).normalize_or(Vec3::Z),
            occlusion: shaded * (1.0 - sides * inner),
            roughness: lerp(0.85, 0.3, self.art.gloss) + 0.08 * vein + 0.12 * back,
            translucency: through * (1.0 - 0.6 * vein),
        }
    }

    /// How much of a brown spot is at a place of a blade.
    fn blight(&self, pose: &Pose, local: Vec2) -> f32 {
        if self.palette.ill <= 0.0 {
            return 0.0;
        }
        let spot = self
            .spots
            .cell(local.x + 1.7 * pose.shift, local.y + pose.shift);
        let size = 0.15 + 0.3 * spot.id;
        if spot.id < 0.75 * self.palette.ill {
            1.0 - smoothstep(0.7 * size, size, spot.centre)
        } else {
            0.0
        }
    }
}

/// A petal of a cherry: broad, notched.
const PETAL: Blade = Blade {
    width: 0.92,
    widest: 0.62,
    sharpness: 0.6,
    base: 0.0,
    tip: -0.35,
    oblique: 0.0,
    auricles: 0.0,
    lobes: Lobes::None,
    margin: crate::species::schema::Margin {
        kind: crate::species::schema::MarginKind::Entire,
        teeth: 0,
        depth: 0.0,
    },
    veins: Veins::Parallel { count: 3 },
};

/// One blade from the lower border to the upper one that fills the card, whatever its shape.
fn filling(art: &LeafArt, card: &Card, seed: u64, height: u32) -> (BladeMap, Pose) {
    let key = Key::of_seed(seed).level("leaf");
    // A little room is left for the midrib's bow.
    let half = 0.985 * (card.half_width - card.border.x).max(0.0);
    let room = (1.0 - 2.0 * card.border.y).max(0.1);
    let mut blade = art.blade;
    blade.width = (2.0 * half / room).max(1e-3);
    let mut polygon = outline::polygon(&blade);
    let low = polygon.iter().fold(0.0, |low: f32, point| low.min(point.x));
    let high = polygon
        .iter()
        .fold(0.1, |high: f32, point| high.max(point.x));
    let wide = polygon
        .iter()
        .fold(1e-4, |wide: f32, point| wide.max(point.y.abs()));
    // The stalk is as long as is asked for, and at least as a heart's base hangs down.
    let petiole = art.petiole.unwrap_or(0.0).max(-low);
    let length = room / (petiole + high);
    let squeeze = half / (wide * length);
    for point in &mut polygon {
        point.y *= squeeze;
    }
    let pose = Pose {
        map: 0,
        base: Vec2::new(0.0, card.border.y + petiole * length),
        along: Vec2::Y,
        length,
        // The bow takes little of the width, which the outline already leaves free.
        bow: key.signed(Parameter::Texture) * 0.015 * half,
        narrow: 1.0,
        tilt: Vec2::ZERO,
        tint: [1.0; 3],
        underside: false,
        haste: 0.0,
        shift: key.with(1).unit(Parameter::Texture),
    };
    blade.width *= squeeze;
    (
        BladeMap::of_polygon(&blade, &polygon, float(height) * length),
        pose,
    )
}

/// Length of the longest blade, card lengths.
fn longest_blade(art: &LeafArt) -> f32 {
    let leaf = match art.arrangement {
        Arrangement::Single => 1.0,
        Arrangement::Opposite { blade, .. }
        | Arrangement::Alternate { blade, .. }
        | Arrangement::Brush { blade, .. }
        | Arrangement::Tufts { blade, .. }
        | Arrangement::Scales { blade, .. } => blade,
    };
    leaf * match art.form {
        Form::Simple | Form::Palmate { .. } => 1.0,
        Form::Pinnate { leaflet, .. } => leaflet,
        Form::Bipinnate { pinna, leaflet, .. } => pinna * leaflet,
    }
}

#[cfg(test)]
mod tests;
