//! Packs: the files that other programs load. Exporters here return bytes; only [`write()`] touches a disk.

mod gltf;
mod gltf_read;
mod manifest;
mod read;
mod write;

pub use manifest::{
    AskedEntry, CaptureEntry, FORMAT, FileEntry, LevelEntry, LodEntry, Manifest, VERSION, WindEntry,
};
pub use read::{PackContents, ReadError, read};
pub use write::{Replace, WriteError, check_place, read_manifest, sweep, verify, write};

use crate::asset::TreeAsset;
use crate::image::png;

/// How a pack is laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// True to put the textures inside each GLB as well, for use as a single file.
    pub embed: bool,
    /// True to add the foliage atlas' mips, which keep the coverage of its alpha.
    pub mips: bool,
    /// True to leave out how vertices sway in the wind: 8 bytes a vertex less.
    pub no_wind: bool,
}

/// One file of a pack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackFile {
    /// Path in the pack, with `/`.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// A pack could not be built from an asset.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// An image could not be encoded.
    #[error(transparent)]
    Png(#[from] png::EncodeError),
    /// A structure could not be written as JSON.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file that the script names is called as one of the pack's own.
    #[error(
        "the script names a file `{path}`, and a pack has a file of that name itself; rename it"
    )]
    NameTaken {
        /// Path.
        path: String,
    },
    /// A GLB would pass the format's 4 GiB.
    #[error("{file} would be larger than the 4 GiB that GLB allows")]
    TooLarge {
        /// File.
        file: String,
    },
}

/// Files of a pack that are written after those that a script names.
const RESERVED: [&str; 2] = ["preview.png", "pack.json"];

/// Folder name of a pack.
#[must_use]
pub fn folder_name(slug: &str, seed: u64) -> String {
    format!("{slug}-{seed}")
}

/// The textures of a pack by their role: path, bytes.
pub(crate) struct Textures {
    pub(crate) bark: [PackFile; 3],
    pub(crate) foliage: [PackFile; 3],
}

/// Builds all files of a pack, the manifest last. `script` is the species script exactly as used.
///
/// # Errors
/// If an image or a GLB cannot be encoded.
pub fn build(
    asset: &TreeAsset,
    script: &[u8],
    options: Options,
) -> Result<Vec<PackFile>, BuildError> {
    let (textures, extra) = textures(asset, options)?;
    let mut files = Vec::new();
    for (index, lod) in asset.lods.iter().enumerate() {
        let path = format!("{}_LOD{index}.glb", asset.slug);
        let name = format!("{}_LOD{index}", asset.slug);
        let bytes = gltf::glb(&name, &lod.mesh, &textures, options)?
            .ok_or_else(|| BuildError::TooLarge { file: path.clone() })?;
        files.push(PackFile { path, bytes });
    }
    files.extend(textures.bark);
    files.extend(textures.foliage);
    files.extend(extra);
    files.push(PackFile {
        path: "species.ron".to_owned(),
        bytes: script.to_vec(),
    });
    for (path, bytes) in &asset.sources {
        if files.iter().any(|f| f.path == *path) || RESERVED.contains(&path.as_str()) {
            return Err(BuildError::NameTaken { path: path.clone() });
        }
        files.push(PackFile {
            path: path.clone(),
            bytes: bytes.clone(),
        });
    }
    let preview = crate::preview::picture(&asset.drawable(), &crate::preview::Settings::default());
    files.push(PackFile {
        path: "preview.png".to_owned(),
        bytes: png::encode(&preview)?,
    });
    let manifest = Manifest::of(asset, &files, options);
    files.push(PackFile {
        path: "pack.json".to_owned(),
        bytes: manifest.to_json()?,
    });
    Ok(files)
}

/// Encodes all images in parallel; the result does not depend on how.
fn textures(asset: &TreeAsset, options: Options) -> Result<(Textures, Vec<PackFile>), BuildError> {
    use rayon::prelude::*;
    type Job<'a> = Box<dyn Fn() -> Result<Vec<u8>, png::EncodeError> + Send + Sync + 'a>;
    let opaque = asset.bark.albedo.map(|&[r, g, b, _]| [r, g, b]);
    let (shadow_atlas, _) = asset.shadows.atlas();
    let mut jobs: Vec<(String, Job<'_>)> = vec![
        (
            "foliage_albedo".to_owned(),
            Box::new(|| png::encode(&asset.foliage.albedo)),
        ),
        (
            "foliage_normal".to_owned(),
            Box::new(|| png::encode(&asset.foliage.normal)),
        ),
        (
            "foliage_orm".to_owned(),
            Box::new(|| png::encode(&asset.foliage.orm)),
        ),
        (
            "bark_albedo".to_owned(),
            Box::new(move || png::encode(&opaque)),
        ),
        (
            "bark_normal".to_owned(),
            Box::new(|| png::encode(&asset.bark.normal)),
        ),
        (
            "bark_orm".to_owned(),
            Box::new(|| png::encode(&asset.bark.orm)),
        ),
        (
            "foliage_extra".to_owned(),
            Box::new(|| png::encode(&asset.foliage.extra)),
        ),
        (
            "shadows".to_owned(),
            Box::new(move || png::encode(&shadow_atlas)),
        ),
    ];
    if options.mips {
        for (level, mip) in asset.foliage.albedo_mips().into_iter().enumerate() {
            let name = format!("mips/foliage_albedo.{}", level + 1);
            jobs.push((name, Box::new(move || png::encode(&mip))));
        }
    }
    let encoded: Result<Vec<PackFile>, BuildError> = jobs
        .par_iter()
        .map(|(name, job)| {
            Ok(PackFile {
                path: format!("textures/{name}.png"),
                bytes: job()?,
            })
        })
        .collect();
    let mut encoded = encoded?.into_iter();
    let mut next = || {
        encoded.next().unwrap_or(PackFile {
            path: String::new(),
            bytes: Vec::new(),
        })
    };
    let foliage = [next(), next(), next()];
    let bark = [next(), next(), next()];
    Ok((Textures { bark, foliage }, encoded.collect()))
}
