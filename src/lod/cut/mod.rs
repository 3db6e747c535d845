//! The `cut` selector: a front through the hierarchy, node by node, by measured error per triangle.
//!
//! Level-wide steps leave budgets half used. Here each node has a menu: open, with its own branch in some
//! form and everything on it chosen for itself, or closed, as one of its level's sets of quads. A front
//! minimises the summed error under the budget.
//!
//! Method: Lagrangian relaxation. For a price per triangle, the best choice of a node depends on its
//! prototype and its scale alone (errors are areas, so they go with the scale squared), hence one table a
//! prototype serves all of its nodes: the law of sharing again. The price is bisected until the front fits;
//! what is left of the budget goes to single nodes, the largest gain per triangle first, and opens nodes that no
//! price opens (`spend`). So the result is near a corner of the convex hull of what fronts can reach; between two
//! far corners the optimum may err less, and prices in steps of 15 % pass over corners whose slopes hardly differ.
//!
//! Errors are sums over nodes: how nodes hide each other must be in the menu's numbers already.
//! Cost: `O(prices x links)` for the tables, `O(front)` for each of some forty walks, and some forty walks over a
//! sub-tree for each node that is tried open: 24 for each one opened, at most 64 times.

mod spend;

use crate::tree::{Kind, Tree};

/// One way to draw the nodes of a prototype.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Triangles of its quads, or of its own branch alone if it is open.
    pub triangles: u64,
    /// Error at scale 1, square metres of silhouette.
    pub error: f32,
    /// True if what grows on it is drawn by its own choices.
    pub open: bool,
}

/// What there is to choose from, by level and prototype. Leaf levels have no offers: they are drawn where
/// what carries them is open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Menu {
    /// At least one offer for each prototype that is not a leaf.
    pub offers: Vec<Vec<Vec<Offer>>>,
}

impl Offer {
    /// An offer that no front takes, to keep the places of the others.
    pub const BARRED: Self = Self {
        triangles: 1 << 40,
        error: f32::INFINITY,
        open: false,
    };
}

/// A front: for every node on it or inside it, from the root in the order of links, the index of its offer.
/// Nodes below a closed one and leaves are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Front {
    /// Indices into [`Menu::offers`].
    pub choices: Vec<u16>,
    /// Triangles of both materials.
    pub triangles: u64,
}

/// Prices in the tables: each is this many times the one before.
const PRICE_STEP: f32 = 1.15;

/// Number of prices: ten orders of magnitude.
const PRICES: usize = 164;

/// Halvings of the interval of prices.
const HALVINGS: usize = 44;

/// The tables of one tree, ready to answer for any budget.
#[derive(Clone, Debug)]
pub struct Cutter<'a> {
    tree: &'a Tree,
    menu: &'a Menu,
    /// Triangles of the leaves that hang on each prototype directly.
    leaves: Vec<Vec<u64>>,
    /// By level and prototype: error plus priced triangles of the best choice, by price.
    values: Vec<Vec<Vec<f32>>>,
    /// The lowest price.
    low: f32,
    /// True if the root must be open.
    open_root: bool,
}

impl<'a> Cutter<'a> {
    /// Builds the tables.
    #[must_use]
    pub fn new(tree: &'a Tree, menu: &'a Menu) -> Self {
        let highest = menu
            .offers
            .iter()
            .flatten()
            .flatten()
            .map(|o| o.error)
            .filter(|e| e.is_finite())
            .fold(1e-6, f32::max);
        let leaves = tree.levels.iter().map(|level| {
            let of = |p: &crate::tree::Prototype| {
                let cards = p.links.iter().filter(|l| is_leaf(tree, l.level as usize));
                cards
                    .map(|l| {
                        tree.prototype(l.level as usize, l.prototype as usize)
                            .part
                            .full_triangles()
                    })
                    .sum()
            };
            level.prototypes.iter().map(of).collect()
        });
        let mut cutter = Self {
            tree,
            menu,
            leaves: leaves.collect(),
            values: tree
                .levels
                .iter()
                .map(|l| vec![Vec::new(); l.prototypes.len()])
                .collect(),
            low: highest * 1e-8,
            open_root: false,
        };
        for level in (0..tree.levels.len()).rev() {
            if is_leaf(tree, level) {
                continue;
            }
            for prototype in 0..tree.levels[level].prototypes.len() {
                let mut price = cutter.low;
                let mut values = Vec::with_capacity(PRICES);
                for _ in 0..PRICES {
                    values.push(cutter.best(level, prototype, price).1);
                    price *= PRICE_STEP;
                }
                cutter.values[level][prototype] = values;
            }
        }
        cutter
    }

    /// The same tables for fronts whose root is open: where the whole tree as a few quads is so good that no
    /// front of middling size has a smaller error, they spend the budget nevertheless.
    #[must_use]
    pub fn with_open_root(&self) -> Self {
        Self {
            open_root: true,
            ..self.clone()
        }
    }

    /// The summed error of a front, square metres.
    #[must_use]
    pub fn error(&self, front: &Front) -> f32 {
        self.error_from(Node::ROOT, front)
    }

    /// The summed error of the front of a sub-tree, in the tree's scale.
    fn error_from(&self, node: Node, front: &Front) -> f32 {
        let mut sum = 0.0;
        self.walk(node, &mut |node, at| {
            let offer = self.offers(node)[usize::from(front.choices[at])];
            sum += offer.error * node.scale * node.scale;
            offer.open
        });
        sum
    }

    /// What a node may be.
    fn offers(&self, node: Node) -> &'a [Offer] {
        &self.menu.offers[node.level][node.prototype]
    }

    /// The front of least summed error within `budget`; `None` if even the smallest form is above it.
    #[must_use]
    pub fn cut(&self, budget: u64) -> Option<Front> {
        let cheap = self.front(f32::INFINITY);
        if cheap.triangles > budget {
            return None;
        }
        let rich = self.front(0.0);
        if rich.triangles <= budget {
            return Some(rich);
        }
        // Between a price that is too low and one that is not.
        let (mut low, mut high) = self.prices();
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            if self.front(middle).triangles <= budget {
                high = middle;
            } else {
                low = middle;
            }
        }
        let front = self.front(high);
        let front = if front.triangles > budget {
            cheap
        } else {
            self.mixed(&front, [low, high], budget)
        };
        Some(self.opened(self.filled(front, budget), high, budget))
    }

    /// A price so low that the best of everything is taken, and one so high that the cheapest is.
    fn prices(&self) -> (f32, f32) {
        (self.low * 1e-3, self.low * 1e12)
    }

    /// Visits the nodes of a front from one on, in its order, with the place of each among the front's choices;
    /// `visit` tells whether a node is open.
    fn walk(&self, node: Node, visit: &mut dyn FnMut(Node, usize) -> bool) {
        self.walk_from(node, &mut 0, visit);
    }

    fn walk_from(&self, node: Node, at: &mut usize, visit: &mut dyn FnMut(Node, usize) -> bool) {
        let open = visit(node, *at);
        *at += 1;
        if open {
            for child in self.children(node.level, node.prototype) {
                self.walk_from(node.child(child), at, visit);
            }
        }
    }

    fn children(
        &self,
        level: usize,
        prototype: usize,
    ) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
        let links = &self.tree.prototype(level, prototype).links;
        links
            .iter()
            .filter(|l| !is_leaf(self.tree, l.level as usize))
            .map(|l| (l.level as usize, l.prototype as usize, l.place.scale))
    }

    /// The best offer at a price and its value, for a node of scale 1.
    fn best(&self, level: usize, prototype: usize, price: f32) -> (u16, f32) {
        self.best_of(level, prototype, price, false)
    }

    fn best_of(&self, level: usize, prototype: usize, price: f32, must_open: bool) -> (u16, f32) {
        let open_value = |offers: &[Offer]| -> f32 {
            if offers.iter().any(|o| o.open) {
                self.children(level, prototype)
                    .map(|(l, p, scale)| scale * scale * self.value(l, p, price / (scale * scale)))
                    .sum::<f32>()
            } else {
                0.0
            }
        };
        let offers = &self.menu.offers[level][prototype];
        let below = open_value(offers);
        let leaves = self.leaves[level][prototype];
        let mut best = (0, f32::INFINITY);
        for (index, offer) in (0_u16..).zip(offers).filter(|(_, o)| o.open || !must_open) {
            #[expect(clippy::cast_precision_loss, reason = "a price needs few digits")]
            let value = if offer.open {
                offer.error + price * (offer.triangles + leaves) as f32 + below
            } else {
                offer.error + price * offer.triangles as f32
            };
            if value < best.1 {
                best = (index, value);
            }
        }
        best
    }

    /// Value of a prototype's best choice at a price, between the table's entries.
    fn value(&self, level: usize, prototype: usize, price: f32) -> f32 {
        let values = &self.values[level][prototype];
        let at = libm::logf((price / self.low).max(1e-12)) / libm::logf(PRICE_STEP);
        let last = values.len() - 1;
        if at <= 0.0 {
            return values[0];
        }
        let index = crate::math::floor_to_u32(at) as usize;
        if index >= last {
            // Beyond the table only triangles count.
            let top = self.low * libm::powf(PRICE_STEP, crate::math::float(163));
            return values[last] * (price / top).max(1.0);
        }
        let part = at - at.floor();
        values[index] + (values[index + 1] - values[index]) * part
    }

    /// The front at a price; an infinite price asks for the fewest triangles, zero for the least error.
    fn front(&self, price: f32) -> Front {
        self.front_from(Node::ROOT, price, self.open_root)
    }

    /// The same of a sub-tree, whose node must be open if it can be.
    fn front_from(&self, node: Node, price: f32, must_open: bool) -> Front {
        let mut front = Front::default();
        let choice = self.choice(node, price, must_open);
        self.grow(node, choice, price, &mut front);
        front
    }

    /// Adds a node, drawn in some way, to a front, and what grows on it as the price has it.
    fn grow(&self, node: Node, choice: u16, price: f32, front: &mut Front) {
        if self.add(node, choice, front) {
            for child in self.children(node.level, node.prototype) {
                let child = node.child(child);
                let choice = self.choice(child, price, false);
                self.grow(child, choice, price, front);
            }
        }
    }

    /// Adds a node alone to a front, with its leaves; true if it is open.
    fn add(&self, node: Node, choice: u16, front: &mut Front) -> bool {
        let offer = self.offers(node)[usize::from(choice)];
        front.choices.push(choice);
        front.triangles += offer.triangles;
        if offer.open {
            front.triangles += self.leaves[node.level][node.prototype];
        }
        offer.open
    }

    /// How a node is drawn at a price.
    fn choice(&self, node: Node, price: f32, must_open: bool) -> u16 {
        let offers = self.offers(node);
        let must_open = must_open && offers.iter().any(|o| o.open);
        if price == f32::INFINITY {
            // Closed nodes are never more than what they stand for, by construction of the menu.
            let least = (0_u16..)
                .zip(offers)
                .filter(|(_, o)| o.error.is_finite())
                .min_by_key(|(_, o)| (o.open != must_open, o.triangles));
            return least.map_or(0, |(i, _)| i);
        }
        if price == 0.0 {
            let best = (0_u16..)
                .zip(offers)
                .min_by(|(_, a), (_, b)| b.open.cmp(&a.open).then(a.error.total_cmp(&b.error)));
            return best.map_or(0, |(i, _)| i);
        }
        let price = price / (node.scale * node.scale);
        self.best_of(node.level, node.prototype, price, must_open).0
    }
}

/// A node with its scale in the tree.
#[derive(Clone, Copy)]
struct Node {
    level: usize,
    prototype: usize,
    scale: f32,
}

impl Node {
    const ROOT: Self = Self {
        level: 0,
        prototype: 0,
        scale: 1.0,
    };

    fn child(self, (level, prototype, scale): (usize, usize, f32)) -> Self {
        Self {
            level,
            prototype,
            scale: self.scale * scale,
        }
    }
}

fn is_leaf(tree: &Tree, level: usize) -> bool {
    tree.levels[level].kind == Kind::Leaf
}
