//! Turntables and trees in the wind: an animated PNG, a GIF, or a sequence of PNGs.

use super::super::Failure;
use super::super::args::{Render, What};
use crate::image::{Image, png};
use std::path::{Path, PathBuf};

/// Milliseconds that a turntable takes for one turn, and that a tree is seen in the wind.
pub(super) const TURN_MS: u16 = 4000;

/// How frames are put together, by the name of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Gif,
    Sequence,
}

fn kind(path: &Path) -> Option<Kind> {
    let name = path.file_name()?.to_str()?;
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "png" if name.contains("%d") => Some(Kind::Sequence),
        "png" | "apng" => Some(Kind::Png),
        "gif" => Some(Kind::Gif),
        _ => None,
    }
}

/// Refuses names that say no format of ours.
pub(super) fn check(args: &Render) -> Result<(), Failure> {
    let found = kind(&args.out);
    let fits = match args.what {
        What::Turntable | What::Sway => found.is_some(),
        _ => found == Some(Kind::Png),
    };
    if fits {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "--out: {} names no format; expected a name that ends in .png{}",
        args.out.display(),
        match args.what {
            What::Turntable | What::Sway => ", .gif, or %d.png for numbered pictures",
            _ => "",
        }
    )))
}

/// Draws all frames and writes them.
pub(super) fn write(
    args: &Render,
    frame: &mut dyn FnMut(u16) -> Result<Image<[u8; 4]>, Failure>,
) -> Result<(), Failure> {
    let mut frames = Vec::new();
    for index in 0..args.frames {
        if super::super::interrupted() {
            return Err(Failure::usage("interrupted"));
        }
        let picture = frame(index)?;
        if kind(&args.out) == Some(Kind::Sequence) {
            let bytes = png::encode(&picture).map_err(Failure::input)?;
            super::super::write(&numbered(&args.out, index), &bytes)?;
        } else {
            frames.push(picture);
        }
    }
    let bytes = match kind(&args.out) {
        Some(Kind::Gif) => gif(&frames)?,
        Some(Kind::Png) => apng(&frames)?,
        Some(Kind::Sequence) | None => return Ok(()),
    };
    super::super::write(&args.out, &bytes)
}

/// `turn-%d.png` with a number of three digits.
fn numbered(path: &Path, index: u16) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(name.replace("%d", &format!("{index:03}")))
}

/// Milliseconds of one of so many frames.
fn delay(frames: usize) -> u16 {
    let frames = u32::try_from(frames).unwrap_or(1).max(1);
    u16::try_from((u32::from(TURN_MS) / frames).max(20)).unwrap_or(u16::MAX)
}

fn apng(frames: &[Image<[u8; 4]>]) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let count = u32::try_from(frames.len()).unwrap_or(u32::MAX);
    let mut write = || -> Result<(), ::png::EncodingError> {
        let first = &frames[0];
        let mut encoder = ::png::Encoder::new(&mut bytes, first.width(), first.height());
        encoder.set_color(::png::ColorType::Rgba);
        encoder.set_depth(::png::BitDepth::Eight);
        encoder.set_animated(count, 0)?;
        encoder.set_frame_delay(delay(frames.len()), 1000)?;
        let mut writer = encoder.write_header()?;
        for frame in frames {
            writer.write_image_data(bytemuck::cast_slice(frame.texels()))?;
        }
        writer.finish()
    };
    write().map_err(Failure::input)?;
    Ok(bytes)
}

fn gif(frames: &[Image<[u8; 4]>]) -> Result<Vec<u8>, Failure> {
    use ::image::codecs::gif::{GifEncoder, Repeat};
    let mut bytes = Vec::new();
    let wait = ::image::Delay::from_numer_denom_ms(u32::from(delay(frames.len())), 1);
    let mut write = || -> Result<(), ::image::ImageError> {
        let mut encoder = GifEncoder::new_with_speed(&mut bytes, 10);
        encoder.set_repeat(Repeat::Infinite)?;
        for frame in frames {
            let data = bytemuck::cast_slice(frame.texels()).to_vec();
            if let Some(image) = ::image::RgbaImage::from_raw(frame.width(), frame.height(), data) {
                encoder.encode_frame(::image::Frame::from_parts(image, 0, 0, wait))?;
            }
        }
        Ok(())
    };
    write().map_err(Failure::input)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Vec<Image<[u8; 4]>> {
        (0..3)
            .map(|i| Image::filled(4, 5, [80 * i, 10, 20, 255]))
            .collect()
    }

    #[test]
    fn the_name_says_the_format() {
        for (name, expected) in [
            ("a.png", Some(Kind::Png)),
            ("a/b.GIF", Some(Kind::Gif)),
            ("turn-%d.png", Some(Kind::Sequence)),
            ("a.jpg", None),
            ("a", None),
        ] {
            assert_eq!(kind(Path::new(name)), expected, "{name}");
        }
        assert_eq!(numbered(Path::new("x/t%d.png"), 7), Path::new("x/t007.png"));
    }

    #[test]
    fn an_animated_png_holds_all_frames_as_they_were() {
        use ::image::AnimationDecoder as _;
        let bytes = apng(&frames()).unwrap();
        let decoder = ::image::codecs::png::PngDecoder::new(std::io::Cursor::new(bytes)).unwrap();
        let read = decoder
            .apng()
            .unwrap()
            .into_frames()
            .collect_frames()
            .unwrap();
        assert_eq!(read.len(), 3);
        for (frame, expected) in read.iter().zip(frames()) {
            assert_eq!(
                frame.buffer().as_raw().as_slice(),
                bytemuck::cast_slice::<_, u8>(expected.texels())
            );
        }
    }

    #[test]
    fn a_gif_holds_all_frames() {
        use ::image::AnimationDecoder as _;
        let bytes = gif(&frames()).unwrap();
        let decoder = ::image::codecs::gif::GifDecoder::new(std::io::Cursor::new(bytes)).unwrap();
        let read = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), 3);
        assert_eq!(read[2].buffer().dimensions(), (4, 5));
    }
}
