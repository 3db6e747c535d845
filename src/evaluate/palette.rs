//! Pictures of at most 256 colours: a third of the bytes of full ones, and to the eye the same.
//!
//! Heckbert, *Color Image Quantization for Frame Buffer Display*, 1982 (median cut).
//!
//! Changes versus the paper: the box that is cut next is the one whose colours are spread the most, counted by
//! pixels, and it is cut at their mean; the commonest colour, a picture's background, is kept as it is.

use crate::image::Image;

/// Colours of a palette at most: an index is a byte.
const MOST: usize = 256;

/// A colour and how many pixels have it.
type Counted = ([u8; 3], u64);

/// Some pictures' colours, made few.
///
/// One palette serves pictures that are compared, so that what is equal in them stays equal.
pub(super) struct Palette {
    colours: Vec<[u8; 3]>,
    /// Every colour of the pictures with its place in `colours`, sorted.
    places: Vec<([u8; 3], u8)>,
}

impl Palette {
    /// The palette of some pictures; exact if they have no more than 256 colours.
    pub(super) fn of(images: &[&Image<[u8; 3]>]) -> Self {
        let mut colours = counted(images);
        let mut boxes = Vec::new();
        let commonest = (0..colours.len()).rev().max_by_key(|&at| colours[at].1);
        if let Some(at) = commonest {
            boxes.push(Cell::of(vec![colours.remove(at)]));
        }
        if !colours.is_empty() {
            boxes.push(Cell::of(colours));
        }
        while boxes.len() < MOST {
            let widest = (0..boxes.len()).rev().max_by_key(|&at| boxes[at].spread);
            let Some(at) = widest.filter(|&at| boxes[at].spread > 0) else {
                break;
            };
            let [low, high] = boxes.swap_remove(at).cut();
            boxes.extend([low, high]);
        }
        let mut places: Vec<([u8; 3], u8)> = Vec::new();
        for (place, cell) in (0_u8..=255).zip(&boxes) {
            places.extend(cell.colours.iter().map(|(colour, _)| (*colour, place)));
        }
        places.sort_unstable();
        Self {
            colours: boxes.iter().map(Cell::mean).collect(),
            places,
        }
    }

    /// A picture as a PNG with this palette; no bytes if it has no pixels. A colour that was in none of the
    /// palette's pictures becomes that of its neighbour in order.
    pub(super) fn png(&self, image: &Image<[u8; 3]>) -> Vec<u8> {
        let place = |colour: &[u8; 3]| {
            let at = self.places.partition_point(|(c, _)| c < colour);
            self.places
                .get(at)
                .or(self.places.last())
                .map_or(0, |p| p.1)
        };
        let indices: Vec<u8> = image.texels().iter().map(place).collect();
        self.encoded(image.width(), image.height(), &indices)
            .unwrap_or_default()
    }

    fn encoded(
        &self,
        width: u32,
        height: u32,
        indices: &[u8],
    ) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(self.colours.as_flattened());
        encoder.set_compression(png::Compression::High);
        // Neighbouring places of a palette are no neighbouring colours.
        encoder.set_filter(png::Filter::NoFilter);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(indices)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// All colours of some pictures, sorted, with their pixels.
fn counted(images: &[&Image<[u8; 3]>]) -> Vec<Counted> {
    let mut all: Vec<[u8; 3]> = images.iter().flat_map(|i| i.texels()).copied().collect();
    all.sort_unstable();
    let equal = all.chunk_by(|a, b| a == b);
    equal.map(|c| (c[0], c.len() as u64)).collect()
}

/// Colours that are to become one.
struct Cell {
    colours: Vec<Counted>,
    /// The channel along which they are spread the most.
    channel: usize,
    /// How much: squared distances from the mean, by pixels.
    spread: u64,
}

impl Cell {
    /// At least one colour.
    fn of(colours: Vec<Counted>) -> Self {
        let spreads: [u64; 3] = core::array::from_fn(|channel| spread(&colours, channel));
        let channel = (0..3)
            .rev()
            .max_by_key(|&channel| spreads[channel])
            .unwrap_or(0);
        Self {
            channel,
            spread: spreads[channel],
            colours,
        }
    }

    /// Two cells, each with a colour at least: those up to the mean, and those past it.
    fn cut(self) -> [Self; 2] {
        let (sum, pixels) = sum(&self.colours, self.channel);
        let is_low = |c: &Counted| u64::from(c.0[self.channel]) * pixels <= sum;
        let (low, high) = self.colours.into_iter().partition(is_low);
        [low, high].map(Self::of)
    }

    fn mean(&self) -> [u8; 3] {
        core::array::from_fn(|channel| {
            let (sum, pixels) = sum(&self.colours, channel);
            u8::try_from((sum + pixels / 2) / pixels.max(1)).unwrap_or(u8::MAX)
        })
    }
}

/// A channel summed over all pixels, and the pixels.
fn sum(colours: &[Counted], channel: usize) -> (u64, u64) {
    colours.iter().fold((0, 0), |(sum, pixels), (colour, n)| {
        (sum + u64::from(colour[channel]) * n, pixels + n)
    })
}

fn spread(colours: &[Counted], channel: usize) -> u64 {
    let (total, pixels) = sum(colours, channel);
    let squares: u64 = colours
        .iter()
        .map(|(colour, n)| u64::from(colour[channel]) * u64::from(colour[channel]) * n)
        .sum();
    // Sum of squares less squared sum by count; never below 0, and rounding down by less than 1.
    let of_mean = u128::from(total) * u128::from(total) / u128::from(pixels.max(1));
    squares.saturating_sub(u64::try_from(of_mean).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::png::decode;

    fn noise(count: u32) -> Image<[u8; 3]> {
        let texel = |i: u32| {
            let [a, b, c, _] = i.wrapping_mul(2_654_435_761).to_le_bytes();
            [a, b, c]
        };
        Image::from_texels(count, 1, (0..count).map(texel).collect())
    }

    fn seen(png: &[u8]) -> Vec<[u8; 3]> {
        let image = decode(png, 1 << 20).unwrap();
        let texels = image.texels().iter();
        texels.map(|&[r, g, b, _]| [r, g, b]).collect()
    }

    #[test]
    fn few_colours_come_back_as_they_were() {
        for image in [
            noise(256),
            noise(1),
            Image::filled(7, 3, [128, 130, 131]),
            Image::from_texels(2, 1, vec![[7, 7, 7], [7, 7, 8]]),
        ] {
            let palette = Palette::of(&[&image]);
            assert_eq!(seen(&palette.png(&image)), image.texels());
        }
        let nothing: Image<[u8; 3]> = Image::filled(0, 0, [0; 3]);
        assert!(Palette::of(&[&nothing]).png(&nothing).is_empty());
    }

    #[test]
    fn many_colours_become_near_ones_and_the_background_stays() {
        let background = [119, 120, 121];
        let mut image = noise(40_000);
        let texels = image.texels_mut();
        texels[..3_000].fill(background);
        let palette = Palette::of(&[&image]);
        assert_eq!(palette.colours.len(), MOST);
        let after = seen(&palette.png(&image));
        let mut squares = 0_u64;
        for (a, b) in image.texels().iter().zip(&after) {
            let apart = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)));
            squares += apart.map(|d| d * d).sum::<u64>();
            assert!(*a != background || *b == background);
        }
        // 256 cells of a cube whose edge is 256 have edges of about 40, so a mean square of 3 * 40^2 / 12.
        assert!(squares / 40_000 < 600, "{}", squares / 40_000);
    }

    #[test]
    fn what_is_equal_in_two_pictures_stays_equal() {
        let (a, b) = (noise(3_000), noise(5_000));
        let palette = Palette::of(&[&a, &b]);
        let (a, b) = (seen(&palette.png(&a)), seen(&palette.png(&b)));
        assert_eq!(a, b[..3_000]);
    }
}
