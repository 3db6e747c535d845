//! What of a tree lies under the pointer: all its nodes as plain items, and the nearest of them along a line of
//! sight.
//!
//! Cost: an item is looked at by one ball first, some ten multiplications; only those near the line of sight by
//! their segments. 150,000 items take about a millisecond.

use crate::math::{Similarity, Vec3};
use crate::tree::{Kind, Link, Part, Prototype, Tree};
use crate::viewer::projection::{Projection, Ray};
use eframe::egui::Pos2;
use std::ops::Range;

/// Most items of one tree: beyond, the finest levels are left out.
pub(super) const MOST: u64 = 400_000;

/// Axes of levels of more nodes are taken coarser.
const FEW: u64 = 3000;

/// Points of the screen about a branch's axis within which it is met, however thin it is.
const REACH: f32 = 4.0;

/// One node of a tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Item {
    /// Its level in the tree.
    pub(super) level: usize,
    /// Its parent among the items; none for the first.
    pub(super) parent: Option<usize>,
    /// Which of its parent's links leads to it.
    pub(super) link: usize,
    /// Place on its parent, 0..=1 of its length.
    pub(super) at: f32,
    /// Length in the world, metres.
    pub(super) length: f32,
    /// Radius at the base in the world, metres; half the width of a leaf.
    pub(super) radius: f32,
    /// The spline that it was grown from, if it is a branch.
    pub(super) spline: Option<usize>,
    points: Range<usize>,
}

/// A point of an axis, and the radius there, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// In the world.
    pub(super) place: Vec3,
    /// Of the tube.
    pub(super) radius: f32,
}

/// All nodes of a tree, parents before what they carry.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Items {
    items: Vec<Item>,
    points: Vec<Point>,
    /// A ball about each item.
    balls: Vec<Point>,
}

/// An item that a line of sight meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// Its number.
    pub(super) item: usize,
    /// Metres along the line.
    pub(super) away: f32,
}

impl Items {
    /// The nodes of a tree, at most so many. `None` if `go_on` says no before they are all there.
    #[must_use]
    pub(super) fn of(tree: &Tree, most: u64, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let counts: Vec<u64> = tree.nodes().iter().map(|n| n.iter().sum()).collect();
        let taken = taken(tree, &counts, most);
        let mut items = Self::default();
        if taken.first() != Some(&true) {
            return Some(items);
        }
        let mut walk = Walk {
            tree,
            taken: &taken,
            counts: &counts,
            into: &mut items,
            go_on,
        };
        let first = Node {
            level: 0,
            prototype: &tree.levels.first()?.prototypes[0],
            parent: None,
            link: 0,
            at: 0.0,
            thickness: 1.0,
        };
        walk.node(&first, &Similarity::IDENTITY).then_some(items)
    }

    /// All items.
    #[must_use]
    pub(super) fn all(&self) -> &[Item] {
        &self.items
    }

    /// The axis of an item, from its base to its tip; a leaf is one point.
    #[must_use]
    pub(super) fn axis(&self, item: &Item) -> &[Point] {
        &self.points[item.points.clone()]
    }

    /// The links that lead from the tree's first node to an item.
    #[must_use]
    pub(super) fn way(&self, item: usize) -> Vec<usize> {
        let mut way = Vec::new();
        let mut at = self.items.get(item);
        while let Some((item, parent)) = at.and_then(|item| Some((item, item.parent?))) {
            way.push(item.link);
            at = self.items.get(parent);
        }
        way.reverse();
        way
    }

    /// Adds a node; `lod` is the geometry LOD of its axis.
    fn add(&mut self, node: &Node<'_>, place: &Similarity, lod: usize) {
        let first = self.points.len();
        let (length, radius) = match &node.prototype.part {
            Part::Stool => (0.0, 0.0),
            Part::Branch(branch) => {
                let rings = branch.rings.get(lod).or(branch.rings.first());
                for &ring in rings.into_iter().flatten() {
                    let sample = &branch.axis[usize::from(ring)];
                    self.points.push(Point {
                        place: place.point(sample.position),
                        radius: sample.radius * place.scale * node.thickness,
                    });
                }
                let size = place.scale;
                (branch.length * size, branch.radius * size * node.thickness)
            }
            Part::Leaf { length, width, .. } => {
                let (length, width) = (length * place.scale, width * place.scale);
                self.points.push(Point {
                    place: place.point(Vec3::Y * (length / place.scale * 0.5)),
                    radius: (length + width) * 0.25,
                });
                (length, width * 0.5)
            }
        };
        let spline = match &node.prototype.part {
            Part::Branch(branch) => Some(usize::from(branch.spline)),
            Part::Stool | Part::Leaf { .. } => None,
        };
        self.balls.push(ball(&self.points[first..]));
        self.items.push(Item {
            level: node.level,
            parent: node.parent,
            link: node.link,
            at: node.at,
            length,
            radius,
            spline,
            points: first..self.points.len(),
        });
    }
}

/// Which levels are taken: whole levels from the trunk outward, of those as deep the smaller ones first.
fn taken(tree: &Tree, counts: &[u64], most: u64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..tree.levels.len()).collect();
    order.sort_by_key(|&level| (tree.levels[level].depth, counts[level], level));
    let mut taken = vec![false; tree.levels.len()];
    let mut sum = 0_u64;
    for level in order {
        let fits = sum.saturating_add(counts[level]) <= most;
        taken[level] = fits && tree.levels[level].parent.is_none_or(|p| taken[p]);
        if taken[level] {
            sum += counts[level];
        }
    }
    taken
}

/// A node on the way through a tree.
struct Node<'a> {
    level: usize,
    prototype: &'a Prototype,
    parent: Option<usize>,
    link: usize,
    at: f32,
    thickness: f32,
}

struct Walk<'a> {
    tree: &'a Tree,
    taken: &'a [bool],
    counts: &'a [u64],
    into: &'a mut Items,
    go_on: &'a dyn Fn() -> bool,
}

impl Walk<'_> {
    /// Adds a node and all that hangs on it; false if it is to give up.
    fn node(&mut self, node: &Node<'_>, place: &Similarity) -> bool {
        let number = self.into.items.len();
        let lod = usize::from(self.counts[node.level] > FEW);
        self.into.add(node, place, lod);
        if self.tree.levels[node.level].kind != Kind::Leaf && !(self.go_on)() {
            return false;
        }
        let links = node.prototype.links.iter().enumerate();
        for (index, link) in links {
            let level = usize::from(link.level);
            if !self.taken[level] {
                continue;
            }
            let child = Node {
                level,
                prototype: self.tree.prototype(level, usize::from(link.prototype)),
                parent: Some(number),
                link: index,
                at: link.at,
                thickness: link.thickness,
            };
            if !self.node(&child, &self.tree.place(place, link)) {
                return false;
            }
        }
        true
    }
}

/// A ball that holds all of some balls.
fn ball(points: &[Point]) -> Point {
    let bounds = crate::math::Bounds::of_points(points.iter().map(|p| p.place));
    let place = bounds.centre();
    let reach = |p: &Point| p.place.distance(place) + p.radius;
    Point {
        place,
        radius: points.iter().map(reach).fold(-1.0, f32::max),
    }
}

/// The item nearest to the eye among those within a few points of the pointer.
#[must_use]
pub(super) fn pick(items: &Items, view: &Projection, pointer: Pos2) -> Option<Hit> {
    let ray = view.ray(pointer);
    let forward = view.camera.forward();
    // Depth goes with the way along the line of sight.
    let slope = ray.direction.dot(forward);
    let start = (ray.origin - view.camera.eye).dot(forward);
    let reach = |away: f32| view.metres_a_point_at(start + away * slope) * REACH;
    let mut best: Option<Hit> = None;
    for (item, ball) in items.balls.iter().enumerate() {
        let to = ball.place - ray.origin;
        let away = to.dot(ray.direction);
        let wide = ball.radius + reach(away + ball.radius);
        let hidden = best.is_some_and(|best| away - wide > best.away);
        let aside = to.length_squared() - away * away;
        if ball.radius < 0.0 || away + ball.radius < 0.0 || hidden || aside > wide * wide {
            continue;
        }
        let axis = items.axis(&items.items[item]);
        let hit = met(&ray, axis, &reach);
        if let Some(away) = hit.filter(|away| best.is_none_or(|best| *away < best.away)) {
            best = Some(Hit { item, away });
        }
    }
    best
}

/// How far along a line of sight it meets a tube, or a ball if that has one point.
fn met(ray: &Ray, axis: &[Point], reach: &dyn Fn(f32) -> f32) -> Option<f32> {
    let one = |point: &Point| {
        let to = point.place - ray.origin;
        let away = to.dot(ray.direction);
        let aside = (to.length_squared() - away * away).max(0.0).sqrt();
        let within = away > 0.0 && aside <= point.radius.max(reach(away));
        within.then_some(away - point.radius)
    };
    match axis {
        [point] => one(point),
        _ => {
            let pairs = axis.windows(2);
            let hits = pairs.filter_map(|pair| one(&nearest(ray, pair[0], pair[1])));
            hits.min_by(f32::total_cmp)
        }
    }
}

/// The point of a segment that is nearest to a line of sight.
fn nearest(ray: &Ray, from: Point, to: Point) -> Point {
    let (along, start) = (to.place - from.place, from.place - ray.origin);
    // Both without their parts along the line: what remains is seen from its end.
    let flat = along - ray.direction * along.dot(ray.direction);
    let off = start - ray.direction * start.dot(ray.direction);
    let length = flat.length_squared();
    let part = if length > 1e-12 {
        (-off.dot(flat) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    Point {
        place: from.place + along * part,
        radius: from.radius + (to.radius - from.radius) * part,
    }
}

/// The frame of the node that a way of links leads to, with that of its parent and the link between them.
#[must_use]
pub(super) fn placed<'a>(tree: &'a Tree, way: &[usize]) -> Option<Placed<'a>> {
    let mut place = Similarity::IDENTITY;
    let mut prototype = tree.levels.first()?.prototypes.first()?;
    let mut last = None;
    let mut level = 0;
    for &index in way {
        let link = prototype.links.get(index)?;
        last = Some(Placed {
            parent: place,
            on: prototype,
            parent_level: level,
            link,
            place: tree.place(&place, link),
        });
        level = usize::from(link.level);
        prototype = tree.prototype(level, usize::from(link.prototype));
        place = last.as_ref()?.place;
    }
    last
}

/// A node on its parent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<'a> {
    /// Frame of the parent.
    pub(super) parent: Similarity,
    /// The parent.
    pub(super) on: &'a Prototype,
    /// Level of the parent.
    pub(super) parent_level: usize,
    /// What leads to the node.
    pub(super) link: &'a Link,
    /// Frame of the node.
    pub(super) place: Similarity,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Lens};
    use crate::species::{self, NoFiles};
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits, grow};
    use eframe::egui::{Rect, pos2, vec2};

    fn tree(script: &str) -> Tree {
        let species = species::parse("blank", script, &NoFiles).unwrap();
        grow(&species, 1, &Limits::default()).unwrap()
    }

    fn items(tree: &Tree) -> Items {
        Items::of(tree, MOST, &|| true).unwrap()
    }

    fn view() -> Projection {
        let camera = Camera {
            eye: Vec3::new(0.0, 2.0, 20.0),
            target: Vec3::new(0.0, 3.0, 0.0),
            lens: Lens::Perspective(0.6),
        };
        let rect = Rect::from_min_size(pos2(40.0, 20.0), vec2(640.0, 480.0));
        Projection::new(camera, rect)
    }

    fn named(tree: &Tree, items: &Items, hit: Option<Hit>) -> Option<String> {
        hit.map(|hit| tree.levels[items.all()[hit.item].level].name.clone())
    }

    #[test]
    fn the_trunk_is_under_a_pointer_at_its_middle_and_nothing_is_in_the_sky() {
        let (tree, view) = (tree(BLANK), view());
        let items = items(&tree);
        // Limbs begin at a third of the height.
        let low = items.axis(&items.all()[0])[0].place + Vec3::Y * 0.8;
        let at = view.place(low).unwrap();
        let hit = pick(&items, &view, at);
        assert_eq!(named(&tree, &items, hit).as_deref(), Some("trunk"));
        let away = hit.unwrap().away;
        assert!((away - 20.0).abs() < 1.0, "{away}");
        // A thin branch is met a little beside it, not farther off.
        for (aside, met) in [(3.0, true), (60.0, false)] {
            let at = at + vec2(aside, 0.0);
            assert_eq!(pick(&items, &view, at).is_some(), met, "{aside}");
        }
        assert_eq!(pick(&items, &view, view.rect.left_top()), None);
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind_it() {
        let (tree, view) = (tree(BLANK), view());
        let mut items = items(&tree);
        let low = items.axis(&items.all()[0])[0].place + Vec3::Y * 0.8;
        let at = view.place(low).unwrap();
        let leaf = items
            .items
            .iter()
            .position(|i| tree.levels[i.level].kind == Kind::Leaf)
            .unwrap();
        let (point, ray) = (items.items[leaf].points.start, view.ray(at));
        for (away, name) in [(5.0, "leaves"), (30.0, "trunk")] {
            items.points[point].place = ray.at(away);
            items.balls[leaf] = ball(&items.points[point..=point]);
            let hit = pick(&items, &view, at);
            assert_eq!(named(&tree, &items, hit).as_deref(), Some(name));
        }
    }

    #[test]
    fn items_are_the_nodes_of_the_tree_and_their_ways_lead_to_them() {
        let tree = tree(BLANK);
        let items = items(&tree);
        let nodes: u64 = tree.nodes().iter().flatten().sum();
        assert_eq!(items.all().len() as u64, nodes);
        let leaf = items.all().len() - 1;
        let way = items.way(leaf);
        let node = placed(&tree, &way).unwrap();
        assert_eq!(way.len(), 2);
        assert_eq!(tree.levels[node.parent_level].name, "limbs");
        let middle = items.axis(&items.all()[leaf])[0].place;
        let half = items.all()[leaf].length * 0.5;
        assert!((node.place.point(Vec3::ZERO).distance(middle) - half).abs() < 1e-3);
        assert!(placed(&tree, &[]).is_none() && placed(&tree, &[900]).is_none());
    }

    #[test]
    fn stems_of_a_stool_are_items_and_the_stool_is_not_met() {
        let script = BLANK.replace("    splines:", "    stems: (count: 3),\n    splines:");
        let (tree, view) = (tree(&script), view());
        let items = items(&tree);
        assert_eq!(tree.levels[items.all()[0].level].kind, Kind::Stool);
        let stem = items.axis(&items.all()[1])[0].place + Vec3::Y * 0.2;
        let hit = pick(&items, &view, view.place(stem).unwrap());
        assert_eq!(named(&tree, &items, hit).as_deref(), Some("trunk"));
    }

    #[test]
    fn the_finest_levels_are_left_out_of_trees_that_are_too_large() {
        let tree = tree(BLANK);
        let all = tree.nodes().iter().flatten().sum::<u64>();
        let few = Items::of(&tree, all - 1, &|| true).unwrap();
        assert_eq!(few.all().len(), 19);
        assert!(Items::of(&tree, 0, &|| true).unwrap().all().is_empty());
        assert_eq!(Items::of(&tree, MOST, &|| false), None);
    }
}
