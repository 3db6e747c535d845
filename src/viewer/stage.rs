//! Which trees stand where, with which LOD: from settings and a camera to a scene.

use super::level::{self, Choice};
use super::settings::{Arrangement, Settings};
use super::subject::LodFacts;
use crate::math::{Bounds, Vec3, float};
use crate::render::forest::{ForestTree, Planting, plant};
use crate::render::{Camera, Group, Instance, Scene};

/// Trees that a view of a forest frames: those nearest to its middle.
const FRAMED: usize = 60;

/// Least triangles of a LOD that stands in for a finer one: those of fewer are not to be seen near.
const HURRIED: u64 = 1_500;

/// Distance between neighbours in a strip, in widths of the tree.
const STRIP_GAP: f32 = 1.06;

/// Distance between neighbours in a forest, in widths of the tree.
const FOREST_GAP: f32 = 1.1;

/// What was put into a scene, for a person to read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Trees of each LOD.
    pub trees: Vec<usize>,
    /// Triangles of all of them.
    pub triangles: u64,
    /// The LOD of the tree in the middle.
    pub lod: usize,
    /// Part of the picture's height that the tree in the middle fills.
    pub part: f32,
}

/// Trees and the LODs that they were shown with last.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    places: Vec<Instance>,
    forest: Vec<ForestTree>,
    last: Vec<Option<usize>>,
    made_for: Option<(Arrangement, usize, usize, f32)>,
}

/// What a stage must know of a tree.
#[derive(Clone, Copy, Debug)]
pub struct Cast<'a> {
    /// Its LODs.
    pub lods: &'a [LodFacts],
    /// Triangles of what stands in for the finest LOD while something moves, falling.
    pub stand_ins: &'a [u64],
    /// Its bounds, metres.
    pub bounds: Bounds,
}

impl Cast<'_> {
    /// The coarsest LOD that stands in for a finer one while something moves. What is made for that alone comes
    /// after the coarsest LOD.
    #[must_use]
    pub fn coarsest_in_a_hurry(&self) -> usize {
        if !self.stand_ins.is_empty() {
            return self.lods.len() + self.stand_ins.len() - 1;
        }
        let fine = |lod: &LodFacts| lod.triangles >= HURRIED;
        self.lods.iter().rposition(fine).unwrap_or(0)
    }

    /// Width of a circle about the trunk that holds it, metres.
    fn width(&self) -> f32 {
        let reach = self.bounds.corners().map(|c| libm::hypotf(c.x, c.z));
        // Corners stand out beyond a round crown by a third or so.
        reach.into_iter().fold(0.5, f32::max) * 1.5
    }
}

impl Stage {
    /// The scene that settings ask for, its LODs `coarser` than they would be where a person does not choose
    /// them.
    pub fn scene(
        &mut self,
        cast: &Cast<'_>,
        settings: &Settings,
        camera: Camera,
        coarser: usize,
    ) -> (Scene, Shown) {
        self.arrange(cast, settings);
        let count = cast.lods.len().max(1);
        let all = count + cast.stand_ins.len();
        let mut groups: Vec<Group> = (0..all)
            .map(|lod| Group {
                model: 0,
                lod,
                trees: Vec::new(),
            })
            .collect();
        let height = cast.bounds.size().y;
        let middle = Vec3::Y * (cast.bounds.centre().y);
        let limit = |lod: usize| cast.lods.get(lod).map_or(0.0, |l| l.screen_size);
        let floor = cast.coarsest_in_a_hurry();
        let mut shown = Shown::default();
        for (index, (tree, last)) in self.places.iter().zip(&mut self.last).enumerate() {
            let [x, y, z, size] = tree.place;
            let centre = Vec3::new(x, y, z) + middle * size;
            let part = height * size / camera.height_at(centre);
            let lod = match (settings.arrangement, settings.choice) {
                (Arrangement::Strip, _) => index,
                (_, Choice::Fixed(lod)) => lod.min(count - 1),
                (_, Choice::ByDistance) => {
                    let lod = level::by_size(limit, count, part, *last);
                    *last = Some(lod);
                    (lod + coarser).min(floor.max(lod))
                }
            };
            if index == 0 {
                (shown.lod, shown.part) = (lod, part);
            }
            groups[lod.min(all - 1)].trees.push(*tree);
        }
        shown.trees = groups.iter().map(|g| g.trees.len()).collect();
        let lods = cast.lods.iter().map(|lod| lod.triangles);
        let triangles = lods.chain(cast.stand_ins.iter().copied());
        let of_lod = |(triangles, &trees): (u64, &usize)| triangles * trees as u64;
        shown.triangles = triangles.zip(&shown.trees).map(of_lod).sum();
        shown.trees.truncate(count);
        groups.retain(|group| !group.trees.is_empty());
        let scene = Scene {
            camera,
            setting: settings.setting(),
            wind: settings.breeze.wind(),
            time: if settings.breeze.on {
                settings.breeze.time
            } else {
                0.0
            },
            view: settings.view,
            filter: settings.filter,
            groups,
        };
        (scene, shown)
    }

    /// Where the base of each tree of a strip stands.
    pub fn strip_places(&mut self, cast: &Cast<'_>, settings: &Settings) -> Vec<Vec3> {
        if settings.arrangement != Arrangement::Strip {
            return Vec::new();
        }
        self.arrange(cast, settings);
        let place = |tree: &Instance| Vec3::new(tree.place[0], tree.place[1], tree.place[2]);
        self.places.iter().map(place).collect()
    }

    /// The trees of a forest, whose LODs the renderer chooses; none in other arrangements.
    pub fn forest(&mut self, cast: &Cast<'_>, settings: &Settings) -> &[ForestTree] {
        self.arrange(cast, settings);
        &self.forest
    }

    /// Points that a camera is to frame, given those of one tree.
    pub fn frame(&mut self, cast: &Cast<'_>, settings: &Settings, hull: &[Vec3]) -> Vec<Vec3> {
        self.arrange(cast, settings);
        let wood = self.forest.iter().take(FRAMED);
        let bases = self.places.iter().map(|t| t.place);
        let bases = bases.chain(wood.map(|t| [t.place[0], t.place[1], t.place[2], t.size]));
        let all = bases
            .flat_map(|[x, y, z, size]| hull.iter().map(move |&p| Vec3::new(x, y, z) + p * size));
        all.collect()
    }

    /// Puts the trees where the arrangement has them, if they are not there yet.
    fn arrange(&mut self, cast: &Cast<'_>, settings: &Settings) {
        let width = cast.width();
        let arrangement = settings.arrangement;
        let wanted = (arrangement, cast.lods.len(), settings.trees, width);
        if self.made_for == Some(wanted) {
            return;
        }
        self.places = match arrangement {
            Arrangement::Single => vec![Instance::at(Vec3::ZERO, 0.0, 1.0)],
            Arrangement::Strip => strip(cast.lods.len(), width * STRIP_GAP),
            Arrangement::Forest => Vec::new(),
        };
        self.forest = match arrangement {
            Arrangement::Forest => forest(settings.trees, width * FOREST_GAP),
            _ => Vec::new(),
        };
        self.last = vec![None; self.places.len()];
        self.made_for = Some(wanted);
    }
}

/// Trees in a row, from the left to the right of a camera that looks along -Z.
fn strip(count: usize, gap: f32) -> Vec<Instance> {
    let tree = |index: usize| {
        let from_middle = float_of(index) - float_of(count.saturating_sub(1)) * 0.5;
        Instance::at(Vec3::X * (from_middle * gap), 0.0, 1.0)
    };
    (0..count).map(tree).collect()
}

/// Trees of a forest, about `gap` from one another, no two alike; those in its middle come first.
fn forest(count: usize, gap: f32) -> Vec<ForestTree> {
    let mut trees = plant(&Planting {
        trees: u32::try_from(count).unwrap_or(u32::MAX),
        spacing_m: gap,
        ..Planting::default()
    });
    let away = |tree: &ForestTree| libm::hypotf(tree.place[0], tree.place[2]);
    trees.sort_by(|a, b| away(a).total_cmp(&away(b)));
    trees
}

fn float_of(index: usize) -> f32 {
    float(u32::try_from(index).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Lens;

    fn lods() -> Vec<LodFacts> {
        [(100_000, 3.0), (10_000, 0.5), (400, 0.1), (8, 0.02)]
            .map(|(triangles, screen_size)| LodFacts {
                budget: None,
                triangles,
                error_m: 0.1,
                screen_size,
            })
            .to_vec()
    }

    const BOUNDS: Bounds = Bounds {
        min: Vec3::new(-2.0, 0.0, -2.0),
        max: Vec3::new(2.0, 6.0, 2.0),
    };

    fn camera(away: f32) -> Camera {
        Camera {
            eye: Vec3::new(0.0, 2.0, away),
            target: Vec3::new(0.0, 3.0, 0.0),
            lens: Lens::Perspective(0.6),
        }
    }

    fn shown(stage: &mut Stage, settings: &Settings, away: f32, coarser: usize) -> Shown {
        let lods = lods();
        let cast = Cast {
            lods: &lods,
            stand_ins: &[],
            bounds: BOUNDS,
        };
        stage.scene(&cast, settings, camera(away), coarser).1
    }

    #[test]
    fn a_tree_going_away_is_shown_with_fewer_triangles_and_less_of_the_picture() {
        let (mut stage, settings) = (Stage::default(), Settings::default());
        let mut before = shown(&mut stage, &settings, 8.0, 0);
        assert_eq!(before.lod, 0);
        for away in [16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0] {
            let now = shown(&mut stage, &settings, away, 0);
            assert!(now.triangles <= before.triangles && now.part < before.part);
            before = now;
        }
        assert_eq!((before.lod, before.triangles), (3, 8));
    }

    #[test]
    fn a_lod_chosen_by_hand_stays_whatever_the_distance_and_the_hurry() {
        let mut stage = Stage::default();
        let settings = Settings {
            choice: Choice::Fixed(2),
            ..Settings::default()
        };
        for (away, coarser) in [(8.0, 0), (8.0, 1), (500.0, 0)] {
            assert_eq!(shown(&mut stage, &settings, away, coarser).lod, 2);
        }
        // One that the tree does not have is its coarsest.
        let settings = Settings {
            choice: Choice::Fixed(8),
            ..settings
        };
        assert_eq!(shown(&mut stage, &settings, 8.0, 0).lod, 3);
    }

    #[test]
    fn hurry_makes_lods_coarser_and_does_not_last() {
        let (mut stage, settings) = (Stage::default(), Settings::default());
        assert_eq!(shown(&mut stage, &settings, 8.0, 1).lod, 1);
        // LODs of a few hundred triangles are for far trees only, and stay there.
        assert_eq!(shown(&mut stage, &settings, 8.0, 9).lod, 1);
        assert_eq!(shown(&mut stage, &settings, 8.0, 0).lod, 0);
        assert_eq!(shown(&mut stage, &settings, 900.0, 9).lod, 3);
    }

    #[test]
    fn a_sketch_is_stood_in_for_in_a_hurry_alone() {
        let (mut stage, settings) = (Stage::default(), Settings::default());
        let lods = &lods()[..1];
        let cast = Cast {
            lods,
            stand_ins: &[20_000, 5_000],
            bounds: BOUNDS,
        };
        assert_eq!(cast.coarsest_in_a_hurry(), 2);
        let mut triangles = |away, coarser| {
            let (scene, shown) = stage.scene(&cast, &settings, camera(away), coarser);
            (scene.groups[0].lod, shown.triangles)
        };
        assert_eq!(triangles(8.0, 0), (0, 100_000));
        assert_eq!(triangles(8.0, 1), (1, 20_000));
        assert_eq!(triangles(8.0, 7), (2, 5_000));
        assert_eq!(triangles(5_000.0, 0), (0, 100_000));
    }

    #[test]
    fn a_strip_has_every_lod_once_from_left_to_right() {
        let settings = Settings {
            arrangement: Arrangement::Strip,
            ..Settings::default()
        };
        let lods = lods();
        let cast = Cast {
            lods: &lods,
            stand_ins: &[],
            bounds: BOUNDS,
        };
        let mut stage = Stage::default();
        let (scene, shown) = stage.scene(&cast, &settings, camera(30.0), 0);
        assert_eq!(shown.trees, [1, 1, 1, 1]);
        let xs: Vec<f32> = scene.groups.iter().map(|g| g.trees[0].place[0]).collect();
        assert!(xs.is_sorted(), "{xs:?}");
        assert!(xs[1] - xs[0] > 4.0, "trees of a strip overlap: {xs:?}");
        let places = stage.strip_places(&cast, &settings);
        assert_eq!(places.iter().map(|p| p.x).collect::<Vec<_>>(), xs);
    }

    #[test]
    fn a_forest_has_all_its_trees_those_in_its_middle_first_and_none_in_a_strip() {
        let settings = Settings {
            arrangement: Arrangement::Forest,
            ..Settings::default()
        };
        let lods = lods();
        let cast = Cast {
            lods: &lods,
            stand_ins: &[],
            bounds: BOUNDS,
        };
        let mut stage = Stage::default();
        let away: Vec<f32> = stage
            .forest(&cast, &settings)
            .iter()
            .map(|tree| libm::hypotf(tree.place[0], tree.place[2]))
            .collect();
        assert_eq!(away.len(), settings.trees);
        assert!(away.is_sorted() && away[0] < 10.0, "{}", away[0]);
        let framed = stage.frame(&cast, &settings, &[Vec3::ZERO]);
        assert_eq!(framed.len(), FRAMED);
        let (scene, _) = stage.scene(&cast, &settings, camera(30.0), 0);
        assert!(scene.groups.is_empty(), "the renderer draws the forest");
        let strip = Settings {
            arrangement: Arrangement::Strip,
            ..settings
        };
        assert!(stage.forest(&cast, &strip).is_empty());
    }
}
