//! Spending what a price leaves of a budget: on sub-trees that the next price draws otherwise, on richer forms of
//! single nodes, and on opening nodes that no price opens.

use super::{Cutter, Front, HALVINGS, Node};

/// Nodes are opened only for more than this part of the budget: one in so many.
const WORTH_SPENDING: u64 = 50;

/// How many closed nodes are tried for each that is opened; and how many are opened at most.
const TRIED: usize = 24;
const OPENED: usize = 64;

impl Cutter<'_> {
    /// Spends what is left of the budget on richer forms of single nodes, the largest gain per triangle first.
    pub(super) fn filled(&self, front: Front, budget: u64) -> Front {
        self.filled_from(Node::ROOT, front, budget)
    }

    /// The same for the front of a sub-tree.
    fn filled_from(&self, node: Node, mut front: Front, budget: u64) -> Front {
        loop {
            let mut left = budget - front.triangles;
            let mut changed = false;
            for step in self.steps(node, &front) {
                if step.cost <= left {
                    front.choices[step.at] = step.offer;
                    front.triangles += step.cost;
                    left -= step.cost;
                    changed = true;
                }
            }
            if !changed {
                return front;
            }
        }
    }

    /// Better closed offers for the front's closed nodes, the largest gain per triangle first, one a node;
    /// and finer branches for its open ones.
    fn steps(&self, node: Node, front: &Front) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        self.walk(node, &mut |node, at| {
            let offers = self.offers(node);
            let now = offers[usize::from(front.choices[at])];
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
                let rate = (now.error - offer.error) * node.scale * node.scale / cost as f32;
                // The cheapest step of a node first: the next ones follow in later rounds.
                if best.as_ref().is_none_or(|b| cost < b.cost) {
                    best = Some(Step {
                        at,
                        offer: index,
                        cost,
                        rate,
                    });
                }
            }
            steps.extend(best);
            now.open
        });
        steps.sort_by(|a, b| b.rate.total_cmp(&a.rate).then(a.at.cmp(&b.at)));
        steps
    }

    /// Opens closed nodes for what is left, while that is a good part of the budget: the one after which the summed
    /// error is least, with as much on it as fits.
    ///
    /// No price opens a node whose closed form is so good that the next corner of its hull is dear: a limb as sixteen
    /// clumps next to one of two thousand triangles. Between the two there are forms that err less than the first.
    ///
    /// `price` is that of the front.
    pub(super) fn opened(&self, mut front: Front, price: f32, budget: u64) -> Front {
        for _ in 0..OPENED {
            let left = budget - front.triangles;
            if left * WORTH_SPENDING <= budget {
                break;
            }
            let mut best: Option<(f32, Closed, Front)> = None;
            for closed in self.worst_closed(&front) {
                let Some(inside) = self.inside(closed.node, price, closed.triangles + left) else {
                    continue;
                };
                let inside = self.filled_from(closed.node, inside, closed.triangles + left);
                let gain = closed.error - self.error_from(closed.node, &inside);
                if gain > best.as_ref().map_or(0.0, |b| b.0) {
                    best = Some((gain, closed, inside));
                }
            }
            let Some((_, closed, inside)) = best else {
                break;
            };
            front.triangles = front.triangles - closed.triangles + inside.triangles;
            front.choices.splice(closed.at..=closed.at, inside.choices);
            front = self.filled(front, budget);
        }
        front
    }

    /// The closed nodes of a front that err most and can be opened, the worst first, one of those that are alike.
    fn worst_closed(&self, front: &Front) -> Vec<Closed> {
        let mut closed = Vec::new();
        self.walk(Node::ROOT, &mut |node, at| {
            let offers = self.offers(node);
            let now = offers[usize::from(front.choices[at])];
            if !now.open && offers.iter().any(|o| o.open && o.error.is_finite()) {
                closed.push(Closed {
                    node,
                    at,
                    triangles: now.triangles,
                    error: now.error * node.scale * node.scale,
                });
            }
            now.open
        });
        closed.sort_by(|a, b| b.error.total_cmp(&a.error).then(a.at.cmp(&b.at)));
        let like = |c: &Closed| {
            (
                c.node.level,
                c.node.prototype,
                c.node.scale.to_bits(),
                c.triangles,
            )
        };
        closed.dedup_by_key(|c| like(c));
        closed.truncate(TRIED);
        closed
    }

    /// The front of least error, at `price` or more, of a sub-tree whose node is open; `None` if none is within `budget`.
    fn inside(&self, node: Node, price: f32, budget: u64) -> Option<Front> {
        let at = |price| self.front_from(node, price, true);
        let mut best = Some(at(f32::INFINITY)).filter(|f| f.triangles <= budget)?;
        let (mut low, mut high) = (price, self.prices().1);
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            let front = at(middle);
            if front.triangles <= budget {
                high = middle;
                best = front;
            } else {
                low = middle;
            }
        }
        Some(best)
    }

    /// The front of the higher price, with the sub-trees that the lower price draws otherwise, as long as
    /// they fit, the largest gain per triangle first.
    pub(super) fn mixed(&self, front: &Front, prices: [f32; 2], budget: u64) -> Front {
        let mut swaps = Vec::new();
        self.compare(Node::ROOT, prices, &mut swaps);
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
        self.merge(Node::ROOT, prices, &mut taken.into_iter(), &mut mixed);
        mixed
    }

    /// How a low price and a high one draw a node.
    fn both(&self, node: Node, prices: [f32; 2]) -> [u16; 2] {
        prices.map(|price| self.choice(node, price, self.open_root && node.level == 0))
    }

    /// Where two prices choose differently, with what the change costs and gains.
    fn compare(&self, node: Node, prices: [f32; 2], swaps: &mut Vec<Step>) {
        let choices = self.both(node, prices);
        let [rich, poor] = choices;
        if rich != poor {
            let [a, b] = [0, 1].map(|at| {
                let mut front = Front::default();
                self.grow(node, choices[at], prices[at], &mut front);
                front.triangles
            });
            let cost = a.saturating_sub(b);
            #[expect(clippy::cast_precision_loss, reason = "a rate needs few digits")]
            let rate = 1.0 / cost.max(1) as f32 * node.scale * node.scale;
            swaps.push(Step {
                at: 0,
                offer: rich,
                cost: if a < b { u64::MAX } else { cost },
                rate,
            });
        } else if self.offers(node)[usize::from(rich)].open {
            for child in self.children(node.level, node.prototype) {
                self.compare(node.child(child), prices, swaps);
            }
        }
    }

    fn merge(
        &self,
        node: Node,
        prices: [f32; 2],
        taken: &mut dyn Iterator<Item = bool>,
        front: &mut Front,
    ) {
        let choices = self.both(node, prices);
        if choices[0] != choices[1] {
            let at = usize::from(taken.next() != Some(true));
            self.grow(node, choices[at], prices[at], front);
        } else if self.add(node, choices[0], front) {
            for child in self.children(node.level, node.prototype) {
                self.merge(node.child(child), prices, taken, front);
            }
        }
    }
}

/// A closed node of a front.
struct Closed {
    node: Node,
    /// Its place among the front's choices.
    at: usize,
    triangles: u64,
    /// In the tree's scale, square metres.
    error: f32,
}

/// A change of one node's offer.
struct Step {
    /// The node's place among the front's choices.
    at: usize,
    offer: u16,
    cost: u64,
    rate: f32,
}
