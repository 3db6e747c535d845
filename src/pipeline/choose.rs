//! Choosing LODs: candidates before there are textures, the better of them once there are.
//!
//! For each budget there are two candidates: a level-wide state and a front cut through the hierarchy. Both
//! are scaled so that they cover as much as full detail, both are measured, and the better silhouette wins.
//! So a cut is never worse than the level-wide steps of the paper.

use super::GenerateError;
use crate::asset::AssetLod;
use crate::capture::{Plan, PlaneSet, Subject};
use crate::impostor::cross_quad::CrossQuads;
use crate::impostor::planes::strips;
use crate::lod::cut::{Cutter, Front, Offer};
use crate::lod::{Counts, Form, ScreenSizes, Selector, State, Triangles};
use crate::math::Similarity;
use crate::measure::menu::{Forms, Look};
use crate::measure::silhouette::Cutouts;
use crate::measure::yardstick::{Verdict, Yardstick};
use crate::mesh::{Coat, Dress, Flattener, Mesh, Swayer, TooLarge, Wardrobe, card, front};
use crate::report::{Cancelled, Progress, Warning};
use crate::species::schema::Lod;
use crate::tree::{Kind, Tree};

/// How LODs are chosen under their budgets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// Node by node, unless level-wide steps look better.
    #[default]
    Cut,
    /// Level by level, as in the paper.
    Levels,
}

/// Smallest and largest scale of a LOD's quads: beyond them leaves would look like balloons.
const LOD_SCALES: [f32; 2] = [0.75, 1.3];

/// What one budget may become.
pub(super) struct Draft {
    budget: Option<u64>,
    candidates: Vec<Candidate>,
}

/// One way to meet a budget.
enum Candidate {
    Levels(State, Triangles),
    Cut(Front),
}

/// Drafts of a whole chain.
pub(super) struct Drafts {
    pub(super) drafts: Vec<Draft>,
    pub(super) warnings: Vec<Warning>,
}

/// Drafts a LOD for each budget. `forms` is missing where a tree is too large to be measured.
pub(super) fn draft(
    tree: &Tree,
    lod: &Lod,
    forms: Option<&Forms>,
    (budgets, with_full): (&[u64], bool),
) -> Drafts {
    let selector = Selector::new(tree, lod);
    let cutters = forms.map(|f| {
        let free = Cutter::new(tree, &f.menu);
        let open = free.with_open_root();
        [free, open]
    });
    let counts = Counts::of(tree, lod.tolerances.len());
    let full = State::full(tree);
    let full = (full.clone(), counts.triangles(tree, &full));
    let mut drafts = Vec::new();
    let mut warnings = Vec::new();
    if with_full {
        drafts.push(Draft {
            budget: None,
            candidates: vec![Candidate::Levels(full.0.clone(), full.1)],
        });
    }
    let mut before = full.1.total();
    let mut state = full.clone();
    for &budget in budgets {
        // A simpler form than one that fits already would only look worse.
        if drafts.last().is_some_and(|d| d.budget.is_some()) && before <= budget {
            warnings.push(Warning::BudgetMet {
                budget,
                triangles: before,
            });
            continue;
        }
        let mut candidates = Vec::new();
        if drafts.is_empty() && full.1.total() <= budget {
            candidates.push(Candidate::Levels(full.0.clone(), full.1));
        } else {
            let cap = budget.min(before.saturating_sub(1));
            if let Some(found) = selector.select(&state, cap) {
                state = found.clone();
                candidates.push(Candidate::Levels(found.0.clone(), found.1));
            }
            if let Some((cutters, forms)) = cutters.as_ref().zip(forms)
                && let Some(cut) = best_cut(cutters, cap)
            {
                let error = cutters[0].error(&cut);
                // Where the cut is better by far, the level-wide state need not be drawn to see it.
                candidates.retain(|c| match c {
                    Candidate::Levels(state, _) => forms.error_of(state) < error * CLEARLY,
                    Candidate::Cut(_) => true,
                });
                candidates.push(Candidate::Cut(cut));
            }
        }
        let most = candidates.iter().map(Candidate::triangles).max();
        match most {
            Some(most) => {
                before = most;
                drafts.push(Draft {
                    budget: Some(budget),
                    candidates,
                });
            }
            None => {
                let smallest = selector.smallest_triangles();
                warnings.push(if smallest > budget {
                    Warning::BudgetBelowSmallest { budget, smallest }
                } else {
                    Warning::BudgetWithoutLod { budget }
                });
            }
        }
    }
    Drafts { drafts, warnings }
}

/// A front that errs up to this factor more is taken if it spends more of the budget: errors are sums over
/// nodes, and those of whole trees as a few quads are flattered by what silhouettes do not show.
const SPEND: f32 = 1.12;

/// A level-wide state that errs more than this many times a cut is no rival for it.
const CLEARLY: f32 = 1.15;

/// The better of the free front and the one whose root is open.
fn best_cut([free, open]: &[Cutter<'_>; 2], cap: u64) -> Option<Front> {
    let closed = free.cut(cap);
    let opened = open.cut(cap);
    match (closed, opened) {
        (Some(closed), Some(opened)) => {
            let spends = opened.triangles > closed.triangles;
            let fair = open.error(&opened) <= free.error(&closed) * SPEND;
            Some(if spends && fair { opened } else { closed })
        }
        (closed, opened) => closed.or(opened),
    }
}

impl Candidate {
    fn triangles(&self) -> u64 {
        match self {
            Self::Levels(_, triangles) => triangles.total(),
            Self::Cut(front) => front.triangles,
        }
    }
}

/// The sets of planes that drafts use, in the order in which they are captured, and for each offer of the menu
/// its place among them.
pub(super) struct Used {
    places: Vec<Vec<Vec<Option<usize>>>>,
}

/// Adds to a plan what the drafts use: sets of planes, turns of crossed quads, and which captures nothing shows.
pub(super) fn extend(plan: &mut Plan, tree: &Tree, forms: Option<&Forms>, drafts: &Drafts) -> Used {
    let mut shown = vec![false; plan.subjects.len()];
    let mut used: Vec<Vec<Vec<bool>>> = forms.map_or_else(Vec::new, |forms| {
        let rows = forms.looks.iter();
        rows.map(|l| l.iter().map(|p| vec![false; p.len()]).collect())
            .collect()
    });
    for candidate in drafts.drafts.iter().flat_map(|d| &d.candidates) {
        match candidate {
            Candidate::Levels(state, _) => mark_state(plan, tree, state, &mut shown),
            Candidate::Cut(front) => {
                visit(tree, forms, front, &mut |(level, prototype), _, choice| {
                    used[level][prototype][choice] = true;
                });
            }
        }
    }
    let mut places: Vec<Vec<Vec<Option<usize>>>> = used
        .iter()
        .map(|l| l.iter().map(|p| vec![None; p.len()]).collect())
        .collect();
    if let Some(forms) = forms {
        plan.turns.clone_from(&forms.turns);
        for (level, prototypes) in forms.looks.iter().enumerate() {
            for (prototype, looks) in prototypes.iter().enumerate() {
                for (index, look) in looks.iter().enumerate() {
                    if !used[level][prototype][index] {
                        continue;
                    }
                    match look {
                        Look::Planes(set) => {
                            let wanted = PlaneSet {
                                level,
                                prototype,
                                planes: set.planes.clone(),
                                straightened: !set.strips.is_empty(),
                            };
                            // Strips that are cut differently share their pictures.
                            let known = plan.sets.iter().position(|s| *s == wanted);
                            let place = known.unwrap_or(plan.sets.len());
                            places[level][prototype][index] = Some(place);
                            if known.is_none() {
                                plan.sets.push(wanted);
                            }
                        }
                        Look::Cross(_) => {
                            if let Some(subject) = plan.combined(level, prototype) {
                                shown[subject] = true;
                            }
                        }
                        Look::Quads => {
                            if let Some((subject, _)) = plan.branch_types[level][prototype] {
                                shown[subject] = true;
                            }
                        }
                        Look::Geometry(_) | Look::Bare => {}
                    }
                }
            }
        }
    }
    plan.small = shown.iter().map(|s| !s).collect();
    Used { places }
}

fn mark_state(plan: &Plan, tree: &Tree, state: &State, shown: &mut [bool]) {
    for (index, subject) in plan.subjects.iter().enumerate() {
        let (Subject::Combined { level, .. } | Subject::Branch { level, .. }) = *subject;
        let wanted = match subject {
            Subject::Combined { .. } => Form::Collapsed,
            Subject::Branch { .. } => Form::Quads,
        };
        shown[index] |= state.forms[level] == wanted;
    }
    // A branch type may be shown by other levels than the one that it was captured from.
    for (level, types) in plan.branch_types.iter().enumerate() {
        if state.forms[level] == Form::Quads && tree.levels[level].kind == Kind::Branch {
            for (subject, _) in types.iter().flatten() {
                shown[*subject] = true;
            }
        }
    }
}

/// Visits the nodes of a front in its order, with the place of each in the tree's scale and its choice.
fn visit(
    tree: &Tree,
    forms: Option<&Forms>,
    front: &Front,
    see: &mut dyn FnMut((usize, usize), f32, usize),
) {
    fn node(
        tree: &Tree,
        forms: &Forms,
        (level, prototype): (usize, usize),
        choices: &mut dyn Iterator<Item = u16>,
        see: &mut dyn FnMut((usize, usize), f32, usize),
    ) {
        let Some(choice) = choices.next() else {
            return;
        };
        let choice = usize::from(choice);
        see((level, prototype), 1.0, choice);
        if forms.menu.offers[level][prototype][choice].open {
            for link in &tree.prototype(level, prototype).links {
                let seat = (link.level as usize, link.prototype as usize);
                if tree.levels[seat.0].kind != Kind::Leaf {
                    node(tree, forms, seat, choices, see);
                }
            }
        }
    }
    if let Some(forms) = forms {
        node(tree, forms, (0, 0), &mut front.choices.iter().copied(), see);
    }
}

/// All that turns drafts into LODs once the atlas is there.
pub(super) struct Fitting<'a> {
    pub(super) tree: &'a Tree,
    pub(super) forms: Option<&'a Forms>,
    pub(super) used: &'a Used,
    pub(super) quads: &'a CrossQuads,
    pub(super) swayer: &'a Swayer<'a>,
    pub(super) coat: Coat,
    pub(super) calibrate: bool,
    pub(super) selection: Selection,
    pub(super) progress: &'a dyn Progress,
}

impl Fitting<'_> {
    /// Fails once the work should be given up.
    pub(super) fn go_on(&self) -> Result<(), Cancelled> {
        if self.progress.cancelled() {
            return Err(Cancelled);
        }
        Ok(())
    }

    /// Turns drafts into LODs: scaled, measured, the better candidate of each budget.
    pub(super) fn lods(
        &self,
        drafts: &[Draft],
        yardstick: &Yardstick,
        cutouts: &Cutouts,
        height: f32,
    ) -> Result<Vec<AssetLod>, GenerateError> {
        let mut lods: Vec<AssetLod> = Vec::new();
        let mut sizes = ScreenSizes::new(height);
        for draft in drafts {
            self.go_on()?;
            self.progress.step();
            let before = lods.last().map_or(u64::MAX, |l| l.triangles.total());
            let mut best: Option<(f32, Verdict, Mesh, &Candidate)> = None;
            let spare: Vec<Candidate>;
            let mut candidates = &draft.candidates[..];
            if candidates.iter().all(|c| c.triangles() >= before) {
                // The LOD before turned out smaller than planned.
                let cap = draft
                    .budget
                    .unwrap_or(u64::MAX)
                    .min(before.saturating_sub(1));
                spare = self.cut_again(cap).into_iter().collect();
                candidates = &spare;
            }
            for candidate in candidates {
                if self.selection == Selection::Levels
                    && matches!(candidate, Candidate::Cut(_))
                    && candidates.len() > 1
                {
                    continue;
                }
                if candidate.triangles() >= before {
                    continue;
                }
                let scales = if self.calibrate && self.has_quads(candidate) {
                    LOD_SCALES
                } else {
                    [1.0, 1.0]
                };
                let mesh_at = |scale: f32| {
                    self.go_on()?;
                    Ok::<Mesh, GenerateError>(self.mesh(candidate, scale)?)
                };
                let fit = yardstick.fit(cutouts, scales, mesh_at)?;
                let (scale, verdict, mesh) = (fit.scale, fit.verdict, fit.mesh);
                if best.as_ref().is_none_or(|b| verdict.iou > b.1.iou) {
                    best = Some((scale, verdict, mesh, candidate));
                }
            }
            let Some((scale, verdict, mut mesh, candidate)) = best else {
                continue;
            };
            self.sway(candidate, scale, &mut mesh);
            let (error_m, screen_size) = sizes.next(verdict.error_m);
            lods.push(AssetLod {
                budget: draft.budget,
                state: self.describe(candidate),
                triangles: Triangles {
                    branches: mesh.bark.triangles(),
                    foliage: mesh.foliage.triangles(),
                },
                error_m,
                screen_size,
                scale,
                iou: verdict.iou,
                coverage: verdict.coverage,
                mesh,
            });
        }
        Ok(lods)
    }

    /// A front of the forms that were captured.
    fn cut_again(&self, cap: u64) -> Option<Candidate> {
        let forms = self.forms?;
        let mut menu = forms.menu.clone();
        for (level, prototypes) in menu.offers.iter_mut().enumerate() {
            for (prototype, offers) in prototypes.iter_mut().enumerate() {
                for (index, offer) in offers.iter_mut().enumerate() {
                    let is_set = matches!(forms.looks[level][prototype][index], Look::Planes(_));
                    if is_set && self.used.places[level][prototype][index].is_none() {
                        *offer = Offer::BARRED;
                    }
                }
            }
        }
        Cutter::new(self.tree, &menu).cut(cap).map(Candidate::Cut)
    }

    /// True if something is drawn by quads whose scale matters.
    fn has_quads(&self, candidate: &Candidate) -> bool {
        match candidate {
            Candidate::Levels(state, _) => state.forms.contains(&Form::Collapsed),
            Candidate::Cut(front) => {
                let mut any = false;
                visit(self.tree, self.forms, front, &mut |(l, p), _, choice| {
                    any |= self
                        .forms
                        .is_some_and(|f| !f.menu.offers[l][p][choice].open);
                });
                any
            }
        }
    }

    fn mesh(&self, candidate: &Candidate, scale: f32) -> Result<Mesh, TooLarge> {
        match (candidate, self.forms) {
            (Candidate::Levels(state, _), _) => {
                let form = self.quads.scaled_form(self.tree, state, self.coat, scale);
                Flattener::new(self.tree, &form).tree()
            }
            (Candidate::Cut(cut), Some(forms)) => {
                front(self.tree, &self.wardrobe(forms, scale), &cut.choices)
            }
            (Candidate::Cut(_), None) => Ok(Mesh::default()),
        }
    }

    /// Adds to a candidate's mesh how it sways.
    fn sway(&self, candidate: &Candidate, scale: f32, mesh: &mut Mesh) {
        match (candidate, self.forms) {
            (Candidate::Levels(state, _), _) => {
                let form = self.quads.scaled_form(self.tree, state, self.coat, scale);
                self.swayer.form(&form, mesh);
            }
            (Candidate::Cut(cut), Some(forms)) => {
                self.swayer
                    .front(&self.wardrobe(forms, scale), &cut.choices, mesh);
            }
            (Candidate::Cut(_), None) => {}
        }
    }

    /// Templates for all offers of the menu.
    fn wardrobe(&self, forms: &Forms, scale: f32) -> Wardrobe {
        let offers = self.tree.levels.iter().enumerate().map(|(level, shared)| {
            let prototypes = shared.prototypes.iter().enumerate();
            prototypes
                .map(|(prototype, node)| {
                    if shared.kind == Kind::Leaf {
                        return vec![Dress {
                            template: self.quads.geometry(&node.part, 0, self.coat),
                            open: false,
                        }];
                    }
                    let looks = forms.looks[level][prototype].iter().enumerate();
                    looks
                        .map(|(index, look)| self.dress((level, prototype), index, look, scale))
                        .collect()
                })
                .collect()
        });
        Wardrobe {
            offers: offers.collect(),
        }
    }

    fn dress(
        &self,
        (level, prototype): (usize, usize),
        index: usize,
        look: &Look,
        scale: f32,
    ) -> Dress {
        let part = &self.tree.prototype(level, prototype).part;
        let quads = self.quads;
        let template = match look {
            Look::Bare => None,
            Look::Geometry(lod) => quads.geometry(part, usize::from(*lod), self.coat),
            Look::Quads => quads.branches[level][prototype].map(|q| card::quads(&q)),
            Look::Cross(own) => quads.combined[level][prototype]
                .map(|q| card::quads(&q.map(|q| q.scaled_on(level, own * scale)))),
            Look::Planes(set) => self.used.places[level][prototype][index].map(|place| {
                if !set.strips.is_empty() {
                    let uvs: Vec<card::UvRect> =
                        quads.sets[place].iter().map(|q| q.pane.uv).collect();
                    let scales: Vec<f32> = set.scales.iter().map(|own| own * scale).collect();
                    return strips::template(&set.strips, &uvs, &scales);
                }
                let scaled: Vec<card::Quad> = quads.sets[place]
                    .iter()
                    .zip(&set.scales)
                    .map(|(q, own)| q.scaled_on(level, own * scale))
                    .collect();
                card::quads(&scaled)
            }),
        };
        Dress {
            template,
            open: matches!(look, Look::Bare | Look::Geometry(_) | Look::Quads),
        }
    }

    /// A short text: for each level, how many nodes are drawn in which form.
    fn describe(&self, candidate: &Candidate) -> String {
        let front = match candidate {
            Candidate::Levels(state, _) => return state.describe(self.tree),
            Candidate::Cut(front) => front,
        };
        let Some(forms) = self.forms else {
            return String::new();
        };
        // By level, names in the order of the menu with how often they are drawn.
        let mut counts: Vec<Vec<(String, u64)>> = vec![Vec::new(); self.tree.levels.len()];
        visit(self.tree, self.forms, front, &mut |(l, p), _, choice| {
            let name = name(&forms.looks[l][p][choice]);
            match counts[l].iter_mut().find(|(n, _)| *n == name) {
                Some((_, count)) => *count += 1,
                None => counts[l].push((name, 1)),
            }
        });
        let levels = self.tree.levels.iter().zip(&mut counts);
        let words = levels
            .filter(|(_, c)| !c.is_empty())
            .map(|(level, counts)| {
                counts.sort();
                let forms: Vec<String> = counts
                    .iter()
                    .map(|(name, count)| format!("{count} {name}"))
                    .collect();
                format!("{}: {}", level.name, forms.join(", "))
            });
        format!("cut; {}", words.collect::<Vec<_>>().join("; "))
    }
}

fn name(look: &Look) -> String {
    match look {
        Look::Geometry(lod) => format!("spline{lod}"),
        Look::Quads => "quads".to_owned(),
        Look::Bare => "leaves only".to_owned(),
        Look::Cross(_) => "cross-quads".to_owned(),
        Look::Planes(set) => set.name.clone(),
    }
}

/// The whole tree in its finest form of at most `limit` triangles: what LODs are measured against.
pub(super) fn reference(
    tree: &Tree,
    lod: &Lod,
    quads: &CrossQuads,
    coat: Coat,
    limit: u64,
) -> Result<Mesh, TooLarge> {
    let selector = Selector::new(tree, lod);
    let state = if selector.full_triangles() <= limit {
        State::full(tree)
    } else {
        let chain = selector.chain(&[limit], false);
        let first = chain.lods.first();
        first.map_or_else(|| State::full(tree), |l| l.state.clone())
    };
    let form = quads.form(tree, &state, coat);
    let mut mesh = Mesh::default();
    Flattener::new(tree, &form).write(0, 0, &Similarity::IDENTITY, 1.0, &mut mesh)?;
    Ok(mesh)
}
