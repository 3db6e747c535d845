//! What is known of the LODs of the last whole tree, and the threads that find it out: small pictures at once, and
//! figures once the tree has been at rest for a while. The next edit stops both.

use super::growing::Grown;
use crate::asset::TreeAsset;
use crate::evaluate::{self, Evaluation};
use crate::image::Image;
use crate::image::atlas::Rect;
use crate::math::{float, round_to_u32};
use crate::preview;
use crate::report::Progress;
use crate::viewer::Subject;
use crate::viewer::loader::{Loader, Stage};
use eframe::egui::{ColorImage, TextureHandle, TextureOptions, Ui};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a whole tree must have been at rest before it is measured.
const REST: Duration = Duration::from_secs(1);

/// Height of the small pictures, pixels, and the narrowest and widest of them.
const HEIGHT: f32 = 96.0;
const WIDTHS: [f32; 2] = [56.0, 140.0];

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Protocol {
    /// Few and small pictures.
    Quick,
    /// All that `pleach evaluate` does.
    Full,
}

impl Protocol {
    fn settings(self) -> evaluate::Settings {
        match self {
            Self::Quick => evaluate::Settings::quick(),
            Self::Full => evaluate::Settings::default(),
        }
    }

    /// What is looked at.
    pub(super) fn words(self) -> String {
        let settings = self.settings();
        let views = settings.side_views + settings.aerial_views;
        let (most, least) = (settings.heights.iter().max(), settings.heights.iter().min());
        let [most, least] = [most, least].map(|height| height.copied().unwrap_or_default());
        let name = match self {
            Self::Quick => "quick",
            Self::Full => "in full",
        };
        format!("{name}: {views} views at {most} to {least} px")
    }
}

/// Figures of the LODs of one tree.
#[derive(Debug)]
pub(super) struct Figures {
    /// The tree's number.
    pub(super) of: u64,
    pub(super) protocol: Protocol,
    /// The LODs come first among its models, in their order.
    pub(super) evaluation: Evaluation,
}

/// Small pictures of the LODs of one tree.
#[derive(Debug)]
struct Drawn {
    of: u64,
    pictures: Vec<Image<[u8; 3]>>,
    /// By LOD, the part of the atlas that it shows.
    atlas: Vec<f32>,
}

/// Such pictures on the window's device.
#[derive(Default)]
pub(super) struct Strip {
    of: u64,
    pub(super) textures: Vec<TextureHandle>,
    /// By LOD, the part of the atlas that it shows.
    pub(super) atlas: Vec<f32>,
}

/// What is known, and who finds it out.
pub(super) struct Judging {
    painter: Loader<Drawn>,
    judge: Loader<Figures>,
    pub(super) strip: Strip,
    /// Number of the tree whose pictures were asked for.
    painting: Option<u64>,
    /// The same of figures, with how much was asked for.
    asked: Option<(u64, Protocol)>,
    /// The tree that is at rest, and since when.
    calm: Option<(u64, Instant)>,
}

impl Judging {
    /// Starts the threads; `wake` is called from them when there is something to be shown.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(super) fn start(wake: impl Fn() + Clone + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {
            painter: Loader::start("paint", wake.clone())?,
            judge: Loader::start("judge", wake)?,
            strip: Strip::default(),
            painting: None,
            asked: None,
            calm: None,
        })
    }

    /// Lets go of what is being done.
    pub(super) fn stop(&mut self) {
        if self.painter.stage().is_some() {
            self.painter.stop();
            self.painting = None;
        }
        self.stop_measuring();
        self.calm = None;
    }

    /// Lets go of what is being measured; it is begun again when it is asked for.
    pub(super) fn stop_measuring(&mut self) {
        if self.judge.stage().is_some() {
            self.judge.stop();
            self.asked = None;
        }
    }

    /// Takes in what the threads have done, and sets them to work on a tree that is the one that the text says.
    pub(super) fn attend(&mut self, ui: &Ui, (number, tree): (u64, &Arc<Grown>), is_current: bool) {
        self.judge.poll();
        if self.painter.poll().good
            && let Some(drawn) = self.painter.good()
        {
            self.strip = Strip::of(drawn, ui);
        }
        if !is_current {
            self.calm = None;
            return;
        }
        if self.painting != Some(number) {
            self.painting = Some(number);
            let tree = Arc::clone(tree);
            self.painter
                .ask(Box::new(move |progress| draw(number, &tree, progress)));
        }
        if self.asked.is_some_and(|(of, _)| of == number) || self.has_figures_of(number) {
            return;
        }
        let now = Instant::now();
        let since = match self.calm {
            Some((of, since)) if of == number => since,
            _ => self.calm.insert((number, now)).1,
        };
        let left = REST.saturating_sub(now - since);
        if left.is_zero() {
            self.measure((number, tree), Protocol::Quick);
        } else {
            ui.ctx().request_repaint_after(left);
        }
    }

    /// Measures a tree.
    pub(super) fn measure(&mut self, (number, tree): (u64, &Arc<Grown>), protocol: Protocol) {
        self.asked = Some((number, protocol));
        let tree = Arc::clone(tree);
        self.judge.ask(Box::new(move |progress| {
            let asset = asset(&tree)?;
            progress.begin("full detail", 0);
            let full = evaluate::reference(asset).map_err(|e| e.to_string())?;
            let subject = evaluate::Subject::of_grown(asset, &full);
            let evaluation = evaluate::evaluate(&subject, &protocol.settings(), progress);
            Ok(Figures {
                of: number,
                protocol,
                evaluation: evaluation.map_err(|e| e.to_string())?,
            })
        }));
    }

    /// The newest figures.
    pub(super) fn figures(&self) -> Option<&Figures> {
        self.judge.good().map(|figures| &**figures)
    }

    /// True if the tree of this number is measured.
    pub(super) fn has_figures_of(&self, number: u64) -> bool {
        self.figures().is_some_and(|figures| figures.of == number)
    }

    /// True if the pictures are those of the tree of this number.
    pub(super) fn has_pictures_of(&self, number: u64) -> bool {
        self.strip.of == number
    }

    /// How far measuring is, and how much is asked for.
    pub(super) fn measuring(&self) -> Option<(Protocol, Stage)> {
        let (_, protocol) = self.asked?;
        Some((protocol, self.judge.stage()?))
    }

    /// Why there are no figures.
    pub(super) fn fault(&self) -> Option<&str> {
        self.judge.fault()
    }
}

fn asset(tree: &Grown) -> Result<&TreeAsset, String> {
    let asset = tree.subject.asset();
    asset.ok_or_else(|| "there is no tree to look at".to_owned())
}

fn draw(of: u64, tree: &Grown, progress: &dyn Progress) -> Result<Drawn, String> {
    let asset = asset(tree)?;
    let settings = preview::Settings {
        size: [width(&tree.subject), HEIGHT].map(round_to_u32),
        ..preview::Settings::default()
    };
    let pictures = preview::pictures(&asset.drawable(), &settings, progress);
    Ok(Drawn {
        of,
        pictures: pictures.map_err(|e| e.to_string())?,
        atlas: atlas(asset),
    })
}

/// Width of a small picture: as much as the tree is wide.
fn width(tree: &Subject) -> f32 {
    let size = tree.bounds.size();
    let [least, most] = WIDTHS;
    (HEIGHT * size.x.max(size.z) / size.y.max(1e-3)).clamp(least, most)
}

/// By LOD, the part of the foliage atlas that it shows.
fn atlas(asset: &TreeAsset) -> Vec<f32> {
    let (width, height) = (asset.foliage.albedo.width(), asset.foliage.albedo.height());
    let part = |lod: &crate::asset::AssetLod| {
        let foliage = &lod.mesh.foliage;
        let shown = asset.rects.iter().filter(|rect| {
            let mut triangles = foliage.indices.chunks_exact(3);
            triangles.any(|corners| {
                let middle = |axis: usize| {
                    let at = corners
                        .iter()
                        .map(|&i| foliage.vertices[i as usize].uv[axis]);
                    at.sum::<f32>() / 3.0
                };
                holds(rect, [middle(0) * float(width), middle(1) * float(height)])
            })
        });
        let texels: f32 = shown.map(|r| float(r.width) * float(r.height)).sum();
        texels / (float(width) * float(height)).max(1.0)
    };
    asset.lods.iter().map(part).collect()
}

fn holds(rect: &Rect, [x, y]: [f32; 2]) -> bool {
    let [left, top] = [rect.x, rect.y].map(float);
    let [right, bottom] = [rect.x + rect.width, rect.y + rect.height].map(float);
    (left..right).contains(&x) && (top..bottom).contains(&y)
}

impl Strip {
    fn of(drawn: &Drawn, ui: &Ui) -> Self {
        let texture = |(lod, picture): (usize, &Image<[u8; 3]>)| {
            let size = [picture.width(), picture.height()].map(|edge| edge as usize);
            let image = ColorImage::from_rgb(size, bytemuck::cast_slice(picture.texels()));
            let name = format!("LOD{lod}");
            ui.ctx().load_texture(name, image, TextureOptions::LINEAR)
        };
        Self {
            of: drawn.of,
            textures: drawn.pictures.iter().enumerate().map(texture).collect(),
            atlas: drawn.atlas.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{self, Settings};
    use crate::report::Quiet;
    use crate::species::{self, NoFiles};
    use crate::studio::templates::BLANK;

    #[test]
    fn a_tree_is_looked_at_as_the_program_does_without_a_second_tree() {
        let species = species::parse("blank", BLANK, &NoFiles).unwrap();
        let grow =
            |settings: &Settings| pipeline::generate(&species, settings, &NoFiles, &Quiet).unwrap();
        let asset = grow(&Settings::default());
        let full = evaluate::reference(&asset).unwrap();
        // What `pleach evaluate` compares with.
        let with_reference = evaluate::with_reference(&species, &Settings::default()).unwrap();
        let whole = grow(&with_reference);
        let theirs = &whole.lods[0].mesh;
        let places = |mesh: &crate::mesh::Mesh| -> Vec<([f32; 3], [f32; 2])> {
            let all = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
            all.map(|v| (v.position, v.uv)).collect()
        };
        assert!(places(&full) == places(theirs), "they are the same tree");
        let settings = evaluate::Settings {
            side_views: 1,
            aerial_views: 1,
            heights: vec![32],
            ..evaluate::Settings::quick()
        };
        let figures = |subject| {
            let evaluation = evaluate::evaluate(&subject, &settings, &Quiet).unwrap();
            let models = evaluation.models.into_iter();
            models.map(|m| (m.label, m.scores)).collect::<Vec<_>>()
        };
        let ours = figures(evaluate::Subject::of_grown(&asset, &full));
        assert_eq!(ours.len(), asset.lods.len());
        let theirs = figures(evaluate::Subject::of_asset(&whole, false));
        assert_eq!(ours, theirs);
        let small = preview::Settings {
            size: [20, 24],
            ..preview::Settings::default()
        };
        let pictures = preview::pictures(&asset.drawable(), &small, &Quiet).unwrap();
        for (lod, picture) in pictures.iter().enumerate() {
            let alone = preview::Settings { lod, ..small };
            assert_eq!(*picture, preview::picture(&asset.drawable(), &alone));
        }
        let parts = atlas(&asset);
        assert!(parts.iter().all(|&p| p > 0.0 && p < 1.0), "{parts:?}");
    }
}
