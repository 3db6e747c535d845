//! The models that are compared with the full tree: its LODs, and rivals at the triangles of each.

use super::picture::Skin;
use super::run::go_on;
use super::{Model, Settings, Subject, rivals};
use crate::measure::silhouette::Cutouts;
use crate::measure::yardstick::Yardstick;
use crate::mesh::Mesh;
use crate::report::{Cancelled, Progress};
use std::borrow::Cow;

/// A model with what is drawn of it; its scores are still missing.
pub(super) struct Entrant<'a> {
    pub(super) model: Model,
    pub(super) mesh: Cow<'a, Mesh>,
    /// True if it wears the LODs' textures and not the full tree's.
    pub(super) is_lod: bool,
}

/// Name of the rival that everything is compared with.
const RANDOM: &str = "random";

/// Smallest scale of the random rival's leaves, and how far its largest may pass that which keeps their area.
const LEAF_SCALES: [f32; 2] = [0.5, 1.25];

/// The LODs from the finest to the coarsest, then the rivals in the same order.
pub(super) fn all<'a>(
    subject: &Subject<'a>,
    settings: &Settings,
    skin: &Skin,
    progress: &dyn Progress,
) -> Result<Vec<Entrant<'a>>, Cancelled> {
    let mut entrants: Vec<Entrant<'a>> = subject
        .lods
        .iter()
        .enumerate()
        .map(|(index, lod)| Entrant {
            model: Model {
                error_m: Some(lod.error_m),
                screen_size: Some(lod.screen_size),
                ..unmeasured(format!("LOD{index}"), lod.budget, lod.mesh, lod.state)
            },
            mesh: Cow::Borrowed(lod.mesh),
            is_lod: true,
        })
        .collect();
    if settings.only_lods {
        return Ok(entrants);
    }
    // Full detail has no rival: nobody simplifies to nothing less.
    let budgets: Vec<(u64, u64)> = subject
        .lods
        .iter()
        .filter_map(|lod| Some((lod.budget?, lod.mesh.triangles())))
        .collect();
    progress.begin("rivals", budgets.len() as u64);
    let cutouts = &skin.cutouts;
    let yardstick = Yardstick::while_ok(subject.full, cutouts, || go_on(progress))?;
    for (budget, triangles) in budgets {
        let (mesh, words) = random(subject, triangles, (&yardstick, cutouts), progress)?;
        entrants.push(rival(RANDOM, &words, budget, mesh));
        if settings.rivals {
            entrants.extend(others(subject.full, budget, triangles));
        }
        progress.step();
    }
    Ok(entrants)
}

/// Leaves and branches left out by chance, the leaves scaled until they cover as much as all did.
fn random(
    subject: &Subject<'_>,
    triangles: u64,
    (yardstick, cutouts): (&Yardstick, &Cutouts),
    progress: &dyn Progress,
) -> Result<(Mesh, String), Cancelled> {
    let kept = rivals::random(subject.full, triangles, subject.seed, 1.0);
    // All of what was kept is kept again, so that only its leaves' size changes.
    let at = |scale: f32| rivals::random(&kept, kept.triangles(), subject.seed, scale);
    let largest = rivals::leaf_scale(rivals::leaves(&kept), rivals::leaves(subject.full));
    let [low, high] = LEAF_SCALES;
    let mesh_at = |scale: f32| go_on(progress).map(|()| at(scale));
    let scale = yardstick.scale(cutouts, [low, largest * high], mesh_at)?;
    let words = format!("leaves and branches left out by chance; leaves {scale:.2} times as large");
    Ok((at(scale), words))
}

#[cfg(feature = "rivals")]
fn others(full: &Mesh, budget: u64, triangles: u64) -> Vec<Entrant<'static>> {
    let entrant = |r: rivals::Rival| rival(r.name, r.settings, budget, r.mesh);
    rivals::all(full, triangles)
        .into_iter()
        .map(entrant)
        .collect()
}

#[cfg(not(feature = "rivals"))]
fn others(_full: &Mesh, _budget: u64, _triangles: u64) -> Vec<Entrant<'static>> {
    Vec::new()
}

fn rival(name: &str, settings: &str, budget: u64, mesh: Mesh) -> Entrant<'static> {
    Entrant {
        model: Model {
            rival: true,
            ..unmeasured(name.to_owned(), Some(budget), &mesh, settings)
        },
        mesh: Cow::Owned(mesh),
        is_lod: false,
    }
}

fn unmeasured(label: String, budget: Option<u64>, mesh: &Mesh, state: &str) -> Model {
    Model {
        label,
        rival: false,
        budget,
        triangles: mesh.triangles(),
        layers: 0.0,
        error_m: None,
        screen_size: None,
        state: state.to_owned(),
        scores: Vec::new(),
        pop: None,
        flicker: None,
        loses_to: Vec::new(),
        undecided: Vec::new(),
    }
}
