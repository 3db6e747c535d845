//! Packs back from their files: the meshes and textures that other programs get, to be judged or drawn.
//!
//! What a pack does not hold cannot be read: the relief of the bark, and the tree itself. The tree grows again from the
//! script and the seed.

use super::manifest::{ShadowMapEntry, ShadowsEntry, SurfaceEntry};
use super::{LodEntry, Manifest, gltf_read, read_manifest, verify};
use crate::asset::{Drawable, Surface};
use crate::image::Image;
use crate::image::png::PngTexel;
use crate::mesh::Mesh;
use crate::mesh::card::Relief;
use crate::shadow::{self, ShadowMap, Shadows};
use crate::wind::Rig;
use image::ImageDecoder as _;
use image::codecs::png::PngDecoder;
use std::fs;
use std::io::{self, Cursor};
use std::path::{Component, Path, PathBuf};

/// A pack as it lies on the disk.
#[derive(Clone, Debug)]
pub struct PackContents {
    /// Where the pack lies. The files that the script names lie here as they lay beside the script, so
    /// [`crate::species::Beside`] of this folder finds them.
    pub folder: PathBuf,
    /// What the pack says of itself.
    pub manifest: Manifest,
    /// The species script exactly as used. With [`Manifest::seed`] and the files in the folder, the same
    /// program grows the same tree from it.
    pub script: String,
    /// Meshes in the order of [`Manifest::lods`], at least one. All numbers are finite, every index has its
    /// vertex, and the triangles are as many as the manifest says.
    pub lods: Vec<Mesh>,
    /// The foliage atlas, exactly as it was before it was written. Read from the texture files, also where
    /// the GLBs hold copies of them.
    pub foliage: Surface,
    /// Captures in the atlas with their real sizes; none in packs that do not tell.
    pub reliefs: Vec<Relief>,
    /// The bark. Its files hold neither alpha nor extra channels, so alpha and coverage are 255,
    /// translucency is 0 and the depth offset is 128, none.
    pub bark: Surface,
    /// Nine soft ground shadows.
    pub shadows: Shadows,
}

impl PackContents {
    /// What the tree is drawn from.
    #[must_use]
    pub fn drawable(&self) -> Drawable<'_> {
        let sizes = self.manifest.lods.iter().map(|l| l.screen_size);
        Drawable {
            lods: self.lods.iter().zip(sizes).collect(),
            foliage: &self.foliage,
            bark: &self.bark,
            reliefs: &self.reliefs,
            shadows: &self.shadows,
            wind: self
                .manifest
                .wind
                .as_ref()
                .map(Rig::from)
                .unwrap_or_default(),
        }
    }
}

/// Why a pack could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// No pack, or no pack of this version.
    #[error("{0}")]
    Manifest(String),
    /// A file is missing or not the one that was written.
    #[error("{0}")]
    Changed(String),
    /// The machine failed.
    #[error("cannot read {path}: {source}")]
    Io {
        /// File.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file is not as this program writes it.
    #[error("{path}: {reason}")]
    File {
        /// File.
        path: PathBuf,
        /// What was expected.
        reason: String,
    },
}

/// The extra channels of bark: no light passes, no depth offset, covered.
const BARK_EXTRA: [u8; 3] = [0, 128, 255];

/// Textures of more texels are refused: 8192 x 8192.
const TEXEL_LIMIT: u64 = 1 << 26;

/// Reads a pack, after holding every file of it against its size and hash in the manifest.
///
/// # Errors
/// See [`ReadError`]; each names the file, and what was expected of it.
pub fn read(folder: &Path) -> Result<PackContents, ReadError> {
    let manifest = read_manifest(folder).map_err(ReadError::Manifest)?;
    let pack = Pack {
        folder,
        manifest: &manifest,
    };
    pack.stays_in_its_folder()?;
    verify(folder, &manifest).map_err(ReadError::Changed)?;
    let script = String::from_utf8(pack.bytes("species.ron")?)
        .map_err(|_| pack.fault("species.ron", "expected text in UTF-8"))?;
    let lods: Result<Vec<Mesh>, ReadError> = manifest.lods.iter().map(|l| pack.lod(l)).collect();
    let lods = lods?;
    if lods.is_empty() {
        return Err(pack.fault("pack.json", "expected at least one LOD"));
    }
    Ok(PackContents {
        folder: folder.to_owned(),
        script,
        lods,
        foliage: pack.foliage(&manifest.textures.foliage)?,
        reliefs: pack.reliefs(&manifest.textures.foliage)?,
        bark: pack.bark(&manifest.textures.bark)?,
        shadows: pack.shadows(&manifest.shadows)?,
        manifest,
    })
}

/// A folder with the manifest that was found in it.
struct Pack<'a> {
    folder: &'a Path,
    manifest: &'a Manifest,
}

impl Pack<'_> {
    fn fault(&self, path: &str, reason: impl Into<String>) -> ReadError {
        ReadError::File {
            path: self.folder.join(path),
            reason: reason.into(),
        }
    }

    /// Nothing vouches for the manifest itself, and it must not send its reader elsewhere.
    fn stays_in_its_folder(&self) -> Result<(), ReadError> {
        let leaves = |path: &str| {
            let mut parts = Path::new(path).components();
            path.is_empty() || !parts.all(|part| matches!(part, Component::Normal(_)))
        };
        match self.manifest.files.iter().find(|f| leaves(&f.path)) {
            Some(file) => {
                let reason = format!("expected paths in the pack's folder, found {:?}", file.path);
                Err(self.fault("pack.json", reason))
            }
            None => Ok(()),
        }
    }

    /// A file of the pack; only one with a hash, so that what is read is what was verified.
    fn bytes(&self, path: &str) -> Result<Vec<u8>, ReadError> {
        if !self.manifest.files.iter().any(|f| f.path == path) {
            let reason = format!("expected {path:?} in the list of files");
            return Err(self.fault("pack.json", reason));
        }
        let path = self.folder.join(path);
        fs::read(&path).map_err(|source| ReadError::Io { path, source })
    }

    fn lod(&self, entry: &LodEntry) -> Result<Mesh, ReadError> {
        let mesh = gltf_read::mesh(&self.bytes(&entry.file)?)
            .map_err(|reason| self.fault(&entry.file, reason))?;
        let expected = [entry.branches_triangles, entry.foliage_triangles];
        let found = [mesh.bark.triangles(), mesh.foliage.triangles()];
        if found != expected || entry.triangles != mesh.triangles() {
            let [bark, foliage] = expected;
            let reason = format!(
                "expected {} triangles as in pack.json ({bark} of bark, {foliage} of foliage), found {} \
                 ({} and {})",
                entry.triangles,
                mesh.triangles(),
                found[0],
                found[1]
            );
            return Err(self.fault(&entry.file, reason));
        }
        Ok(mesh)
    }

    fn foliage(&self, entry: &SurfaceEntry) -> Result<Surface, ReadError> {
        let extra = entry.extra.as_ref().ok_or_else(|| {
            self.fault(
                "pack.json",
                "expected foliage textures with an `extra` file",
            )
        })?;
        Ok(Surface {
            albedo: self.image(&entry.albedo, entry.size)?,
            normal: self.image(&entry.normal, entry.size)?,
            orm: self.image(&entry.orm, entry.size)?,
            extra: self.image(extra, entry.size)?,
        })
    }

    fn reliefs(&self, entry: &SurfaceEntry) -> Result<Vec<Relief>, ReadError> {
        let captures = entry.captures.iter();
        captures
            .map(|capture| {
                let [u0, v0, u1, v1] = capture.uv;
                let lies_inside =
                    0.0 <= u0 && u0 < u1 && u1 <= 1.0 && 0.0 <= v0 && v0 < v1 && v1 <= 1.0;
                if lies_inside && capture.longer_m > 0.0 && capture.longer_m.is_finite() {
                    return Ok(Relief::from(capture));
                }
                let reason = format!(
                    "expected captures inside the atlas and of some size, found {capture:?}"
                );
                Err(self.fault("pack.json", reason))
            })
            .collect()
    }

    fn bark(&self, entry: &SurfaceEntry) -> Result<Surface, ReadError> {
        if entry.extra.is_some() {
            let reason = "expected bark textures without an `extra` file";
            return Err(self.fault("pack.json", reason));
        }
        let opaque: Image<[u8; 3]> = self.image(&entry.albedo, entry.size)?;
        Ok(Surface {
            albedo: opaque.map(|&[r, g, b]| [r, g, b, u8::MAX]),
            normal: self.image(&entry.normal, entry.size)?,
            orm: self.image(&entry.orm, entry.size)?,
            extra: opaque.map(|_| BARK_EXTRA),
        })
    }

    fn shadows(&self, entry: &ShadowsEntry) -> Result<Shadows, ReadError> {
        if entry.maps.len() != shadow::COUNT {
            let found = entry.maps.len();
            let reason = format!("expected {} shadow maps, found {found}", shadow::COUNT);
            return Err(self.fault("pack.json", reason));
        }
        // The maps lie in one picture: it is as large as they reach.
        let reach = |of: usize| {
            let ends = entry
                .maps
                .iter()
                .map(|m| m.rect[of].saturating_add(m.rect[of + 2]));
            ends.max().unwrap_or(0)
        };
        let all: Image<u8> = self.image(&entry.file, [reach(0), reach(1)])?;
        let map = |m: &ShadowMapEntry| {
            let [x, y, width, height] = m.rect;
            ShadowMap {
                direction: m.direction.into(),
                image: all.part(x, y, width, height),
                ground_rect_m: m.ground_rect_m,
                trunk_base: m.trunk_base,
            }
        };
        Ok(Shadows {
            maps: entry.maps.iter().map(map).collect(),
        })
    }

    fn image<P: PngTexel>(&self, path: &str, size: [u32; 2]) -> Result<Image<P>, ReadError> {
        image(&self.bytes(path)?, size).map_err(|reason| self.fault(path, reason))
    }
}

/// Decodes a PNG of exactly this size and these channels; nothing is converted.
fn image<P: PngTexel>(png: &[u8], [width, height]: [u32; 2]) -> Result<Image<P>, String> {
    let broken = |e: image::ImageError| format!("expected a PNG: {e}");
    let texels = u64::from(width) * u64::from(height);
    if texels > TEXEL_LIMIT {
        return Err(format!(
            "expected at most {TEXEL_LIMIT} texels, and pack.json says {width} x {height}"
        ));
    }
    let decoder =
        PngDecoder::with_limits(Cursor::new(png), image::Limits::default()).map_err(broken)?;
    let found = (
        decoder.dimensions(),
        image::ExtendedColorType::from(decoder.color_type()),
    );
    if found != ((width, height), P::COLOUR) {
        let ((x, y), colour) = found;
        return Err(format!(
            "expected {width} x {height} texels of {:?} as in pack.json, found {x} x {y} of {colour:?}",
            P::COLOUR
        ));
    }
    let mut image = Image::filled(width, height, P::zeroed());
    decoder
        .read_image(bytemuck::cast_slice_mut(image.texels_mut()))
        .map_err(broken)?;
    Ok(image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::png::encode;
    use proptest::prelude::*;

    fn picture() -> Image<[u8; 3]> {
        let mut image = Image::filled(9, 5, [1, 2, 3]);
        *image.at_mut(8, 4) = [250, 128, 0];
        image
    }

    #[test]
    fn only_a_picture_of_the_size_and_channels_that_were_written_is_read() {
        let picture = picture();
        let png = encode(&picture).unwrap();
        assert_eq!(image(&png, [9, 5]), Ok(picture));
        for (fault, word) in [
            (image::<[u8; 3]>(&png, [5, 9]).err(), "5 x 9"),
            (image::<[u8; 4]>(&png, [9, 5]).err(), "Rgba8"),
            (image::<u8>(&png, [9, 5]).err(), "L8"),
            (image::<[u8; 3]>(&png, [u32::MAX; 2]).err(), "at most"),
            (image::<[u8; 3]>(b"GIF89a", [9, 5]).err(), "PNG"),
        ] {
            let fault = fault.expect(word);
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..Default::default() })]

        #[test]
        fn damaged_pictures_are_refused_or_read_at_the_size_asked_for(
            length in any::<prop::sample::Index>(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        ) {
            let mut png = encode(&picture()).unwrap();
            for (place, byte) in damage {
                let place = place.index(png.len());
                png[place] = byte;
            }
            png.truncate(length.index(2 * png.len()));
            if let Ok(image) = image::<[u8; 3]>(&png, [9, 5]) {
                prop_assert_eq!((image.width(), image.height()), (9, 5));
            }
        }
    }
}
