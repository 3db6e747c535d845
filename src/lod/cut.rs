//! The `cut` selector: a front through the hierarchy, node by node, by measured error per triangle.
//!
//! Level-wide steps leave budgets half used. Here each node has a menu: open, with its own branch in some
//! form and everything on it chosen for itself, or closed, as one of its level's sets of quads. A front
//! minimises the summed error under the budget.
//!
//! Method: Lagrangian relaxation. For a price per triangle, the best choice of a node depends on its
//! prototype and its scale alone (errors are areas, so they go with the scale squared), hence one table a
//! prototype serves all of its nodes: the law of sharing again. The price is bisected until the front fits;
//! what is left of the budget goes to single nodes, the largest gain per triangle first. So the result is
//! near a corner of the convex hull of what fronts can reach; between two far corners the optimum may err
//! less, and prices in steps of 15 % pass over corners whose slopes hardly differ.
//!
//! Errors are sums over nodes: how nodes hide each other must be in the menu's numbers already.
//! Cost: `O(prices x links)` for the tables and `O(front)` for each of some forty walks.

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
        let mut sum = 0.0;
        self.walk(0, 0, 1.0, &mut |level, prototype, scale, node| {
            let choice = usize::from(front.choices[node]);
            let offer = &self.menu.offers[level][prototype][choice];
            sum += offer.error * scale * scale;
            offer.open
        });
        sum
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
        let (mut low, mut high) = (self.low * 1e-3, self.low * 1e12);
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
            self.mixed(&front, low, high, budget)
        };
        Some(self.filled(front, budget))
    }

    /// Spends what is left of the budget on richer forms of single nodes, the largest gain per triangle first.
    fn filled(&self, mut front: Front, budget: u64) -> Front {
        loop {
            let steps = self.steps(&front);
            let mut changed = false;
            let mut choices = front.choices.clone();
            let mut left = budget - front.triangles;
            for step in &steps {
                if step.cost <= left {
                    choices[step.node] = step.offer;
                    left -= step.cost;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
            front = Front {
                choices,
                triangles: budget - left,
            };
        }
        front
    }

    /// Better closed offers for the front's closed nodes, the largest gain per triangle first, one a node;
    /// and finer branches for its open ones.
    fn steps(&self, front: &Front) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        self.walk(0, 0, 1.0, &mut |level, prototype, scale, node| {
            let choice = front.choices[node];
            let offers = &self.menu.offers[level][prototype];
            let now = offers[choice as usize];
            let mut best: Option<Step> = None;
            for (index, offer) in (0_u16..).zip(offers) {
                let better = offer.open == now.open
                    && offer.triangles > now.triangles
                    && offer.error < now.error;
                if !better {
                    continue;
                }
                let cost = offer.triangles - now.triangles;
                #[expect(clippy::cast_precision_loss, reason = "a rate needs few digits")]
                let rate = (now.error - offer.error) * scale * scale / cost as f32;
                // The cheapest step of a node first: the next ones follow in later rounds.
                if best.as_ref().is_none_or(|b| cost < b.cost) {
                    best = Some(Step {
                        node,
                        offer: index,
                        cost,
                        rate,
                    });
                }
            }
            steps.extend(best);
            now.open
        });
        steps.sort_by(|a, b| b.rate.total_cmp(&a.rate).then(a.node.cmp(&b.node)));
        steps
    }

    /// Visits the nodes of a front in its order; `visit` tells whether a node is open.
    fn walk(
        &self,
        level: usize,
        prototype: usize,
        scale: f32,
        visit: &mut dyn FnMut(usize, usize, f32, usize) -> bool,
    ) {
        let mut node = 0;
        self.walk_from(level, prototype, scale, &mut node, visit);
    }

    fn walk_from(
        &self,
        level: usize,
        prototype: usize,
        scale: f32,
        node: &mut usize,
        visit: &mut dyn FnMut(usize, usize, f32, usize) -> bool,
    ) {
        let open = visit(level, prototype, scale, *node);
        *node += 1;
        if open {
            for (level, prototype, inner) in self.children(level, prototype) {
                self.walk_from(level, prototype, scale * inner, node, visit);
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
        let mut front = Front::default();
        self.grow(0, 0, 1.0, price, &mut front);
        front
    }

    fn grow(&self, level: usize, prototype: usize, scale: f32, price: f32, front: &mut Front) {
        let choice = self.choice(level, prototype, scale, price);
        let offer = self.menu.offers[level][prototype][choice as usize];
        front.choices.push(choice);
        front.triangles += offer.triangles;
        if offer.open {
            front.triangles += self.leaves[level][prototype];
            for (level, prototype, inner) in self.children(level, prototype) {
                self.grow(level, prototype, scale * inner, price, front);
            }
        }
    }

    fn choice(&self, level: usize, prototype: usize, scale: f32, price: f32) -> u16 {
        let offers = &self.menu.offers[level][prototype];
        let must_open = self.open_root && level == 0 && offers.iter().any(|o| o.open);
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
        self.best_of(level, prototype, price / (scale * scale), must_open)
            .0
    }

    /// The front of the higher price, with the sub-trees that the lower price draws otherwise, as long as
    /// they fit, the largest gain per triangle first.
    fn mixed(&self, front: &Front, low: f32, high: f32, budget: u64) -> Front {
        let mut swaps = Vec::new();
        self.compare(Node::ROOT, low, high, &mut swaps);
        let mut order: Vec<usize> = (0..swaps.len()).collect();
        order.sort_by(|&a, &b| swaps[b].rate.total_cmp(&swaps[a].rate).then(a.cmp(&b)));
        let mut taken = vec![false; swaps.len()];
        let mut left = budget - front.triangles;
        for swap in order {
            if swaps[swap].cost <= left {
                left -= swaps[swap].cost;
                taken[swap] = true;
            }
        }
        let mut mixed = Front::default();
        let mut next = 0;
        self.merge(Node::ROOT, low, high, &taken, &mut next, &mut mixed);
        mixed
    }

    /// Where two prices choose differently, with what the change costs and gains.
    fn compare(&self, node: Node, low: f32, high: f32, swaps: &mut Vec<Step>) {
        let [rich, poor] =
            [low, high].map(|p| self.choice(node.level, node.prototype, node.scale, p));
        let offers = &self.menu.offers[node.level][node.prototype];
        if rich != poor {
            let [a, b] = [low, high].map(|price| {
                let mut front = Front::default();
                self.grow(node.level, node.prototype, node.scale, price, &mut front);
                front.triangles
            });
            let cost = a.saturating_sub(b);
            #[expect(clippy::cast_precision_loss, reason = "a rate needs few digits")]
            let rate = 1.0 / cost.max(1) as f32 * node.scale * node.scale;
            swaps.push(Step {
                node: 0,
                offer: rich,
                cost: if a < b { u64::MAX } else { cost },
                rate,
            });
        } else if offers[rich as usize].open {
            for child in self.children(node.level, node.prototype) {
                self.compare(node.child(child), low, high, swaps);
            }
        }
    }

    fn merge(
        &self,
        node: Node,
        low: f32,
        high: f32,
        taken: &[bool],
        next: &mut usize,
        front: &mut Front,
    ) {
        let [rich, poor] =
            [low, high].map(|p| self.choice(node.level, node.prototype, node.scale, p));
        if rich != poor {
            let price = if taken[*next] { low } else { high };
            *next += 1;
            self.grow(node.level, node.prototype, node.scale, price, front);
            return;
        }
        let offer = self.menu.offers[node.level][node.prototype][rich as usize];
        front.choices.push(rich);
        front.triangles += offer.triangles;
        if offer.open {
            front.triangles += self.leaves[node.level][node.prototype];
            for child in self.children(node.level, node.prototype) {
                self.merge(node.child(child), low, high, taken, next, front);
            }
        }
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

/// A change of one node's offer.
struct Step {
    node: usize,
    offer: u16,
    cost: u64,
    rate: f32,
}

fn is_leaf(tree: &Tree, level: usize) -> bool {
    tree.levels[level].kind == Kind::Leaf
}
