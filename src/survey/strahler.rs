//! Orders of branches counted inward from the tips (Horton 1945, Strahler 1952).
//!
//! A tip has order 1. Where two or more branches of the highest order meet, a branch of the next order goes
//! on; else the highest order goes on. The number of branches of each order falls about evenly on a
//! logarithmic scale; by how much is the bifurcation ratio.
//!
//! Worked out on the graph: every node of a prototype has the same orders below it.

use crate::tree::{Part, Prototype, Tree};

/// Branches that leave nearer to each other than this part of the length leave at one fork: a pair, a whorl.
const SAME_PLACE: f32 = 1e-4;

/// What is left of a branch beyond its last fork must be this part of its length to be a tip of its own.
const TIP: f32 = 0.004;

/// Branches of each order, the tips (order 1) first; empty without branches.
#[must_use]
pub fn counts(tree: &Tree) -> Vec<u64> {
    let mut below: Vec<Vec<Stream>> = tree
        .levels
        .iter()
        .map(|l| vec![Stream::default(); l.prototypes.len()])
        .collect();
    // Parents come first, so the way back meets every child before its parents.
    for level in (0..tree.levels.len()).rev() {
        for (index, prototype) in tree.levels[level].prototypes.iter().enumerate() {
            below[level][index] = of_prototype(prototype, &below);
        }
    }
    below
        .first()
        .and_then(|level| level.first())
        .map(|stream| stream.counts.clone())
        .unwrap_or_default()
}

/// How the numbers of branches fall from order to order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Times fewer branches of the next order.
    pub ratio: f32,
    /// R^2 of the straight line; `None` below three orders, where any line is straight.
    pub r2: Option<f32>,
}

/// The least-squares line through the logarithms of the numbers; `None` below two orders.
#[must_use]
#[expect(
    clippy::cast_precision_loss,
    reason = "a logarithm needs no more digits"
)]
#[expect(clippy::cast_possible_truncation, reason = "a ratio to seven digits")]
pub fn bifurcation(counts: &[u64]) -> Option<Fit> {
    if counts.len() < 2 || counts.contains(&0) {
        return None;
    }
    let n = counts.len() as f64;
    let logs: Vec<f64> = counts.iter().map(|&c| libm::log(c as f64)).collect();
    let mean_x = (n - 1.0) * 0.5;
    let mean_y = logs.iter().sum::<f64>() / n;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in logs.iter().enumerate() {
        let (dx, dy) = (x as f64 - mean_x, y - mean_y);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    let r2 = (counts.len() > 2 && yy > 0.0).then(|| (xy * xy / (xx * yy)) as f32);
    Some(Fit {
        ratio: libm::exp(-xy / xx) as f32,
        r2,
    })
}

/// A sub-tree's order at its base (0 if it has no branch), and its branches by order.
#[derive(Clone, Debug, Default)]
struct Stream {
    order: usize,
    counts: Vec<u64>,
}

impl Stream {
    /// Goes on past a fork at which `orders` join.
    fn join(&mut self, orders: &[usize]) {
        let all = || orders.iter().copied().chain([self.order]);
        let highest = all().max().unwrap_or(0);
        let meet = all().filter(|&o| o == highest && o > 0).count();
        if meet >= 2 {
            self.begin(highest + 1);
        } else {
            self.order = highest;
        }
    }

    /// A branch of this order begins.
    fn begin(&mut self, order: usize) {
        self.order = order;
        if self.counts.len() < order {
            self.counts.resize(order, 0);
        }
        let count = &mut self.counts[order - 1];
        *count = count.saturating_add(1);
    }

    fn add(&mut self, counts: &[u64]) {
        if self.counts.len() < counts.len() {
            self.counts.resize(counts.len(), 0);
        }
        for (sum, count) in self.counts.iter_mut().zip(counts) {
            *sum = sum.saturating_add(*count);
        }
    }
}

fn of_prototype(prototype: &Prototype, below: &[Vec<Stream>]) -> Stream {
    let mut stream = Stream::default();
    if matches!(prototype.part, Part::Leaf { .. }) {
        return stream;
    }
    let mut children: Vec<(f32, &Stream)> = prototype
        .links
        .iter()
        .map(|link| {
            // All stems of a stool meet at one place.
            let is_stool = matches!(prototype.part, Part::Stool);
            let at = if is_stool { 0.0 } else { link.at };
            (
                at,
                &below[usize::from(link.level)][usize::from(link.prototype)],
            )
        })
        .filter(|(_, child)| child.order > 0)
        .collect();
    children.sort_by(|a, b| b.0.total_cmp(&a.0));
    let has_tip = match (&prototype.part, children.first()) {
        (Part::Branch(_), Some((at, _))) => 1.0 - at > TIP,
        (Part::Branch(_), None) => true,
        _ => false,
    };
    if has_tip {
        stream.begin(1);
    }
    let mut rest = &children[..];
    while let Some(&(place, _)) = rest.first() {
        let fork = rest.partition_point(|(at, _)| place - at < SAME_PLACE);
        let (here, inward) = rest.split_at(fork);
        here.iter().for_each(|(_, child)| stream.add(&child.counts));
        let orders: Vec<usize> = here.iter().map(|(_, child)| child.order).collect();
        stream.join(&orders);
        rest = inward;
    }
    stream
}
