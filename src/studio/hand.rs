//! The pointer on the tree: tells what is under it, selects its level by a click, and shows the level that is
//! selected, with handles that change it.

use super::app::Order;
use super::bearer;
use super::bending::Bending;
use super::bringing::Outside;
use super::document::Document;
use super::form::Change;
use super::grips::Held;
use super::growing::Grown;
use super::marks;
use super::outline::{self, Page, Section};
use super::picking::{self, Hit, Item, Items};
use crate::render::Camera;
use crate::species::syntax::Node;
use crate::tree::{Kind, Tree};
use crate::viewer::loader::Loader;
use crate::viewer::projection::Projection;
use eframe::egui::{self, Pos2, Rect, Response, Ui, vec2};
use std::sync::{Arc, Weak};

/// The most nodes of which one is chosen to bear the handles.
const CANDIDATES: usize = 4000;

/// Length on the screen beyond which a longer node is no better for handles, points.
const LONG: f32 = 140.0;

/// Height of the switch in the corner with the room around it, of a note above that, and the note's width, points.
const ROW: f32 = 42.0;
const NOTE: f32 = 68.0;
const WIDTH: f32 = 340.0;

/// A tree's nodes.
#[derive(Debug)]
struct Nodes {
    tree: Tree,
    items: Items,
}

/// The node that bears the handles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    /// Its level in the tree.
    pub(super) level: usize,
    /// The links that lead to it.
    pub(super) way: Vec<usize>,
}

/// What the pointer knows.
#[derive(Debug)]
pub(super) struct Hand {
    /// True to show the level that is selected.
    is_shown: bool,
    loader: Loader<Nodes>,
    nodes: Option<Arc<Nodes>>,
    /// The tree that was looked at last, and whether the nodes are its.
    looked: Option<(Weak<Grown>, bool)>,
    /// What was under the pointer, and from where it was seen.
    over: Option<(Pos2, Camera, Option<Hit>)>,
    pub(super) chosen: Option<Chosen>,
    pub(super) held: Option<Held>,
    pub(super) bending: Bending,
}

/// What is to bear handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bears {
    /// A node of a level.
    Level(usize),
    /// A branch that was grown from a spline.
    Spline(usize),
}

impl Bears {
    fn is_item(self, item: &Item) -> bool {
        match self {
            Self::Level(level) => item.level == level,
            Self::Spline(spline) => item.spline == Some(spline),
        }
    }

    fn is_chosen(self, tree: &Tree, chosen: &Chosen) -> bool {
        let node = bearer::node(tree, &chosen.way).filter(|node| node.level == chosen.level);
        node.is_some_and(|node| match self {
            Self::Level(level) => node.level == level,
            Self::Spline(spline) => node
                .branch()
                .is_some_and(|b| usize::from(b.spline) == spline),
        })
    }
}

/// What the pointer moves over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene<'a> {
    pub(super) view: Projection,
    pub(super) response: &'a Response,
    pub(super) shown: &'a Arc<Grown>,
    pub(super) document: &'a Document,
    pub(super) pages: &'a [Page],
    pub(super) selected: &'a str,
}

/// The level that is selected: where its struct stands in the script, and its number in the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level<'a> {
    pub(super) path: &'a str,
    pub(super) node: &'a Node,
    pub(super) index: usize,
}

/// The spline that is selected: where its struct stands in the script, and its number there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spline<'a> {
    pub(super) path: &'a str,
    pub(super) name: &'a str,
    pub(super) node: &'a Node,
    pub(super) index: usize,
}

impl<'a> Scene<'a> {
    pub(super) fn tree(&self) -> Option<&'a Tree> {
        self.shown.subject.asset().map(|asset| &asset.tree)
    }

    fn level(&self) -> Option<Level<'a>> {
        let page = self.pages.iter().find(|p| p.path == self.selected)?;
        let root = self.document.reading().root.as_ref()?;
        let levels = &self.tree()?.levels;
        let named = |l: &crate::tree::TreeLevel| l.kind != Kind::Stool && l.name == page.title;
        (page.section == Section::Levels).then_some(())?;
        Some(Level {
            path: &page.path,
            node: outline::at(root, &page.path)?,
            index: levels.iter().position(named)?,
        })
    }

    fn spline(&self) -> Option<Spline<'a>> {
        let page = self.pages.iter().find(|p| p.path == self.selected)?;
        let root = self.document.reading().root.as_ref()?;
        (page.section == Section::Splines).then_some(())?;
        Some(Spline {
            path: &page.path,
            name: &page.title,
            node: outline::at(root, &page.path)?,
            index: outline::number(&page.path)?,
        })
    }

    /// True if the tree is the one that the text says.
    pub(super) fn is_up_to_date(&self) -> bool {
        self.shown.text == self.document.text()
    }
}

impl Hand {
    /// Nothing is known yet; `wake` is called when there is something to show.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(super) fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {
            is_shown: true,
            loader: Loader::start("nodes", wake)?,
            nodes: None,
            looked: None,
            over: None,
            chosen: None,
            held: None,
            bending: Bending::default(),
        })
    }

    /// One frame over the picture of one tree.
    pub(super) fn ui(&mut self, ui: &mut Ui, scene: &Scene<'_>, orders: &mut Vec<Order>) {
        let level = scene.level();
        let spline = scene.spline();
        let shows = self.is_shown && (level.is_some() || spline.is_some());
        let wanted = scene.response.contains_pointer() || shows;
        self.look(ui, scene, wanted);
        if self.nodes_of(scene).is_some() {
            self.hover(ui, scene);
            self.click(scene, orders);
        }
        if let Some(level) = level.filter(|_| self.is_shown) {
            if let Some(nodes) = self.nodes_of(scene) {
                let bearer = self.bearer(&nodes, level.index);
                marks::level(ui, &scene.view, &nodes.items, (level.index, bearer));
                self.choose(&nodes, &scene.view, Bears::Level(level.index));
            }
            self.handles(ui, scene, level, orders);
            self.crown(ui, scene, level, orders);
        } else {
            self.held = None;
        }
        if let Some(spline) = spline.filter(|_| self.is_shown) {
            if let Some(nodes) = self.nodes_of(scene) {
                self.choose(&nodes, &scene.view, Bears::Spline(spline.index));
            }
            self.bend(ui, scene, spline, orders);
            outside(ui, scene, spline, orders);
        } else {
            self.bending = Bending::default();
        }
        self.row(ui, scene.view.rect);
    }

    /// The nodes, if they are those of the tree that is shown.
    fn nodes_of(&mut self, scene: &Scene<'_>) -> Option<Arc<Nodes>> {
        let shown = Arc::as_ptr(scene.shown);
        let known = self
            .looked
            .as_ref()
            .filter(|(tree, _)| tree.as_ptr() == shown);
        let same = match known {
            Some((_, same)) => *same,
            None => {
                // A sketch and the whole tree of one script are the same tree.
                let nodes = self.nodes.as_ref().map(|nodes| &nodes.tree);
                let same = nodes.is_some() && nodes == scene.tree();
                self.looked = Some((Arc::downgrade(scene.shown), same));
                self.over = None;
                same
            }
        };
        self.nodes.clone().filter(|_| same)
    }

    /// Takes in the nodes, and has those of another tree gathered once it has come to rest.
    fn look(&mut self, ui: &Ui, scene: &Scene<'_>, wanted: bool) {
        if self.loader.poll().good {
            self.nodes = self.loader.good().cloned();
            self.looked = None;
        }
        let rests = scene.is_up_to_date() && !ui.input(|i| i.pointer.any_down());
        let asked = self.loader.stage().is_some();
        if !wanted || !rests || asked || self.nodes_of(scene).is_some() {
            return;
        }
        let shown = Arc::clone(scene.shown);
        self.loader.ask(Box::new(move |progress| {
            let tree = &shown.subject.asset().ok_or("it was not grown here")?.tree;
            let go_on = || !progress.cancelled();
            let items = Items::of(tree, picking::MOST, &go_on).ok_or("overtaken")?;
            Ok(Nodes {
                tree: tree.clone(),
                items,
            })
        }));
    }

    /// What is under a point of the screen.
    fn at(&mut self, scene: &Scene<'_>, pointer: Pos2) -> Option<Hit> {
        let nodes = self.nodes_of(scene)?;
        let camera = scene.view.camera;
        if let Some((at, from, hit)) = self.over
            && at == pointer
            && from == camera
        {
            return hit;
        }
        let hit = picking::pick(&nodes.items, &scene.view, pointer);
        self.over = Some((pointer, camera, hit));
        hit
    }

    fn hover(&mut self, ui: &Ui, scene: &Scene<'_>) {
        let response = scene.response;
        if !response.hovered() || ui.input(|i| i.pointer.any_down()) {
            return;
        }
        let hit = response.hover_pos().and_then(|at| self.at(scene, at));
        let (Some(hit), Some(nodes)) = (hit, self.nodes_of(scene)) else {
            return;
        };
        let item = &nodes.items.all()[hit.item];
        marks::outline(ui, &scene.view, nodes.items.axis(item));
        let [name, size, on] = told(&nodes.tree, item);
        response.clone().on_hover_ui_at_pointer(|ui| {
            ui.strong(name);
            ui.label(size);
            if !on.is_empty() {
                ui.weak(on);
            }
        });
    }

    /// A click selects the level of what is under it.
    fn click(&mut self, scene: &Scene<'_>, orders: &mut Vec<Order>) {
        let response = scene.response;
        let at = response
            .interact_pointer_pos()
            .filter(|_| response.clicked());
        let hit = at.and_then(|at| self.at(scene, at));
        let (Some(hit), Some(nodes)) = (hit, self.nodes_of(scene)) else {
            return;
        };
        let level = nodes.items.all()[hit.item].level;
        let name = &nodes.tree.levels[level].name;
        let mut levels = scene.pages.iter().filter(|p| p.section == Section::Levels);
        if let Some(page) = levels.find(|p| p.title == *name) {
            self.chosen = Some(Chosen {
                level,
                way: nodes.items.way(hit.item),
            });
            orders.push(Order::Select(page.path.clone()));
        }
    }

    /// Chooses the node that bears the handles, if none is.
    fn choose(&mut self, nodes: &Nodes, view: &Projection, bears: Bears) {
        let there = |chosen: &Chosen| bears.is_chosen(&nodes.tree, chosen);
        if !self.chosen.as_ref().is_some_and(there) {
            let item = best(&nodes.items, view, bears);
            self.chosen = item.map(|item| Chosen {
                level: nodes.items.all()[item].level,
                way: nodes.items.way(item),
            });
        }
    }

    /// The item that bears the handles.
    fn bearer(&self, nodes: &Nodes, level: usize) -> Option<usize> {
        let chosen = self.chosen.as_ref().filter(|c| c.level == level)?;
        let mut items = nodes.items.all().iter().enumerate();
        items
            .find(|(index, item)| {
                item.level == level
                    && Some(&item.link) == chosen.way.last()
                    && nodes.items.way(*index) == chosen.way
            })
            .map(|(index, _)| index)
    }

    /// The switch in the corner of the picture.
    fn row(&mut self, ui: &mut Ui, rect: Rect) {
        let size = vec2(190.0, 26.0).min(rect.size());
        let place = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -size.y - 8.0), size);
        let builder = egui::UiBuilder::new()
            .id_salt("shown level")
            .max_rect(place);
        let mut ui = ui.new_child(builder);
        let fill = ui.visuals().panel_fill.gamma_multiply(0.85);
        let frame = egui::Frame::new().fill(fill).corner_radius(4.0);
        frame.inner_margin(vec2(6.0, 3.0)).show(&mut ui, |ui| {
            ui.checkbox(&mut self.is_shown, "show the selected level")
                .on_hover_text("Its branches as lines, and handles that change it");
        });
    }

    /// Ends what is held, and its gesture.
    pub(super) fn rest(&mut self, orders: &mut Vec<Order>) {
        orders.push(Order::Change(Change::Rest));
        if let Some(held) = &mut self.held {
            held.following.is_released = true;
        }
    }
}

/// Says in the picture why a spline's points have no handles.
fn outside(ui: &mut Ui, scene: &Scene<'_>, spline: Spline<'_>, orders: &mut Vec<Order>) {
    let Ok(species) = &scene.document.reading().species else {
        return;
    };
    let Some(outside) = Outside::of(spline.path, spline.node, species) else {
        return;
    };
    let rect = scene.view.rect;
    let place = Rect::from_min_max(
        rect.left_bottom() + vec2(8.0, -ROW - NOTE),
        rect.right_bottom() + vec2(-8.0, -ROW),
    );
    let builder = egui::UiBuilder::new().id_salt("outside").max_rect(place);
    let mut ui = ui.new_child(builder);
    let fill = ui.visuals().panel_fill.gamma_multiply(0.85);
    let frame = egui::Frame::new().fill(fill).corner_radius(4.0);
    let shown = frame.inner_margin(vec2(6.0, 4.0)).show(&mut ui, |ui| {
        ui.set_max_width(WIDTH);
        outside.ui(ui, scene.document.text())
    });
    orders.extend(shown.inner.map(Order::Change));
}

/// The node that handles are best put on: in the middle of its parent, and seen long in the picture.
fn best(items: &Items, view: &Projection, bears: Bears) -> Option<usize> {
    let of_level = || {
        items
            .all()
            .iter()
            .enumerate()
            .filter(|(_, item)| bears.is_item(item))
    };
    let places = of_level().map(|(_, item)| item.at);
    let (low, high) = places.fold((1.0_f32, 0.0_f32), |(l, h), at| (l.min(at), h.max(at)));
    let middle = (low + high) * 0.5;
    let score = |item: &Item| {
        let axis = items.axis(item);
        let (first, last) = (axis.first()?.place, axis.last()?.place);
        let (from, to) = (view.seen(first)?, view.seen(last)?);
        let long = match axis.len() {
            1 => item.length / view.metres_a_point(first).max(1e-6),
            _ => from.distance(to),
        };
        let off = (item.at - middle).abs() / (high - low).max(0.01);
        let depth = (first - view.camera.eye).dot(view.camera.forward());
        // Of those as good, the nearest.
        Some(
            long.min(LONG) / LONG
                - off
                - depth / (view.camera.eye.distance(view.camera.target) * 4.0),
        )
    };
    let step = of_level().count().div_ceil(CANDIDATES).max(1);
    let scored = of_level().step_by(step);
    let scored = scored.filter_map(|(index, item)| Some((index, score(item)?)));
    scored
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Name, size and parent of an item, in words.
fn told(tree: &Tree, item: &Item) -> [String; 3] {
    let level = &tree.levels[item.level];
    let parent = level.parent.map(|parent| &tree.levels[parent]);
    let parent = parent.filter(|parent| parent.kind != Kind::Stool);
    let on = parent.map_or_else(String::new, |parent| format!("on {}", parent.name));
    let long = metres(item.length);
    let size = match level.kind {
        Kind::Leaf => format!("{long} long, {} wide", metres(item.radius * 2.0)),
        Kind::Branch | Kind::Stool => format!("{long} long, radius {}", metres(item.radius)),
    };
    [level.name.clone(), size, on]
}

/// A length as a person says it: with two or three digits.
pub(super) fn metres(metres: f32) -> String {
    match metres {
        m if m >= 10.0 => format!("{m:.1} m"),
        m if m >= 1.0 => format!("{m:.2} m"),
        m if m >= 0.1 => format!("{:.0} cm", m * 100.0),
        m if m >= 0.01 => format!("{:.1} cm", m * 100.0),
        m => format!("{:.1} mm", m * 1000.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::render::Lens;
    use crate::species::{self, NoFiles};
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits, grow};
    use eframe::egui::pos2;

    #[test]
    fn lengths_are_told_in_the_unit_that_fits_them() {
        for (length, words) in [
            (12.34, "12.3 m"),
            (2.7, "2.70 m"),
            (0.27, "27 cm"),
            (0.041, "4.1 cm"),
            (0.0042, "4.2 mm"),
        ] {
            assert_eq!(metres(length), words);
        }
    }

    #[test]
    fn handles_stand_on_a_node_in_the_middle_that_is_seen_from_the_side() {
        let species = species::parse("blank", BLANK, &NoFiles).unwrap();
        let tree = grow(&species, 1, &Limits::default()).unwrap();
        let items = Items::of(&tree, picking::MOST, &|| true).unwrap();
        for eye in [Vec3::new(0.0, 3.0, 22.0), Vec3::new(16.0, 6.0, -14.0)] {
            let camera = Camera {
                eye,
                target: Vec3::Y * 3.0,
                lens: Lens::Perspective(0.5),
            };
            let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(600.0, 600.0));
            let view = Projection::new(camera, rect);
            let item = best(&items, &view, Bears::Level(1)).unwrap();
            let item = &items.all()[item];
            assert!((item.at - 0.65).abs() < 0.25, "{}", item.at);
            let axis = items.axis(item);
            let along = (axis[axis.len() - 1].place - axis[0].place).normalize_or(Vec3::Y);
            assert!(along.dot(view.camera.forward()).abs() < 0.75);
            let [name, size, on] = told(&tree, item);
            assert_eq!((&*name, &*on), ("limbs", "on trunk"));
            assert!(size.contains("m long, radius "), "{size}");
        }
        assert_eq!(best(&items, &views_nothing(), Bears::Level(1)), None);
    }

    fn views_nothing() -> Projection {
        let camera = Camera {
            eye: Vec3::new(0.0, 3.0, 22.0),
            target: Vec3::new(0.0, 3.0, 90.0),
            lens: Lens::Perspective(0.5),
        };
        Projection::new(
            camera,
            Rect::from_min_size(pos2(0.0, 0.0), vec2(600.0, 600.0)),
        )
    }
}
