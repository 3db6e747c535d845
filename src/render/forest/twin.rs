//! The passes of `shaders/cull.wgsl` on a processor: the same numbers, the same lists, in the same order.
//!
//! Tests hold the two together. It is also what draws a forest tree by tree, as before there were indirect draws,
//! and what says how long the choice takes without a GPU.

use super::ForestTree;
use super::plan::{Cull, GROUP, Kind, Plan, index};
use rayon::prelude::*;

const NO_BIN: u32 = 255;
const FADED: u32 = 255;

/// Trees that one task works on: whole groups, and enough of them to be worth a task.
const TASK: usize = GROUP as usize * 32;

/// Trees by bin.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    /// Trees of all bins: 23 bits of index, 9 of fade; see [`Entry`].
    pub entries: Vec<u32>,
    /// For each bin, where it begins; and where the last one ends.
    pub starts: Vec<u32>,
}

/// A tree in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Index of the tree.
    pub tree: u32,
    /// How far it has faded in, 0..=255; out, -255..=-1, with the part -x of 255 left.
    pub fade: i32,
}

impl Lists {
    /// The trees of a bin.
    #[must_use]
    pub fn bin(&self, bin: usize) -> &[u32] {
        match self.starts[bin..] {
            [from, to, ..] => &self.entries[from as usize..to as usize],
            _ => &[],
        }
    }

    /// The trees of a bin, one by one.
    pub fn trees(&self, bin: usize) -> impl Iterator<Item = Entry> {
        self.bin(bin).iter().map(|&entry| Entry::of(entry))
    }
}

impl Entry {
    #[expect(clippy::cast_possible_wrap, reason = "nine bits")]
    fn of(packed: u32) -> Self {
        let code = (packed >> 23) as i32;
        Self {
            tree: packed & 0x7f_ffff,
            fade: if code > 255 { code - 256 } else { code - 255 },
        }
    }
}

/// What the twin remembers of each tree, and its scratch memory.
#[derive(Clone, Debug, Default)]
pub struct Twin {
    states: Vec<u32>,
    choices: Vec<u32>,
    lists: Lists,
}

impl Twin {
    /// For so many trees, none of which was seen yet.
    #[must_use]
    pub fn new(trees: usize) -> Self {
        Self {
            states: vec![0; trees],
            choices: vec![0; trees],
            lists: Lists::default(),
        }
    }

    /// The lists of the frame chosen last.
    #[must_use]
    pub fn lists(&self) -> &Lists {
        &self.lists
    }

    /// The lists of a frame.
    pub fn choose(&mut self, plan: &Plan, trees: &[ForestTree], cull: &Cull) -> &Lists {
        let bins = plan.bins.len();
        let kinds = &plan.kinds;
        let tasks = trees
            .par_chunks(TASK)
            .zip(self.states.par_chunks_mut(TASK))
            .zip(self.choices.par_chunks_mut(TASK))
            .enumerate();
        let tallies: Vec<[u32; 256]> = tasks
            .map(|(task, ((trees, states), choices))| {
                let mut tally = [0; 256];
                let first = index(task * TASK);
                for (at, (tree, (state, choice))) in
                    (first..).zip(trees.iter().zip(states.iter_mut().zip(choices)))
                {
                    *choice = choice_of(at, tree, state, kinds, cull);
                    if *choice != u32::MAX {
                        for bin in choice.to_le_bytes() {
                            tally[usize::from(bin)] += 1;
                        }
                    }
                }
                tally
            })
            .collect();
        self.scatter(bins, &tallies);
        &self.lists
    }

    /// Each tree to its places: each task writes parts of the list that are its own.
    fn scatter(&mut self, bins: usize, tallies: &[[u32; 256]]) {
        let Lists { entries, starts } = &mut self.lists;
        starts.clear();
        let mut end = 0;
        for bin in 0..bins {
            starts.push(end);
            end += tallies.iter().map(|t| t[bin]).sum::<u32>();
        }
        starts.push(end);
        entries.resize(end as usize, 0);
        let mut parts: Vec<Vec<&mut [u32]>> =
            tallies.iter().map(|_| Vec::with_capacity(bins)).collect();
        let mut rest = entries.as_mut_slice();
        for bin in 0..bins {
            for (part, tally) in parts.iter_mut().zip(tallies) {
                let (own, others) = rest.split_at_mut(tally[bin] as usize);
                part.push(own);
                rest = others;
            }
        }
        let tasks = parts
            .into_par_iter()
            .zip(self.states.par_chunks(TASK))
            .zip(self.choices.par_chunks(TASK));
        tasks
            .enumerate()
            .for_each(|(task, ((mut part, states), choices))| {
                let mut filled = [0_usize; 256];
                for (at, (&state, &choice)) in
                    (index(task * TASK)..).zip(states.iter().zip(choices))
                {
                    if choice == u32::MAX {
                        continue;
                    }
                    let fade = state >> 16;
                    let codes = [256 + fade, fade, 511, 511];
                    for (bin, code) in choice.to_le_bytes().map(usize::from).into_iter().zip(codes)
                    {
                        if bin < bins {
                            part[bin][filled[bin]] = at | (code << 23);
                            filled[bin] += 1;
                        }
                    }
                }
            });
    }
}

/// A number in 0..1 for each tree (Jarzynski and Olano 2020, pcg).
fn own_number(tree: u32) -> f32 {
    let state = tree.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    crate::rng::unit_from_bits((word >> 22) ^ word)
}

fn coarsest(kind: &Kind, tree: f32, picture: f32) -> u32 {
    let mut lod = 0;
    for (i, &switch) in (0..kind.bins[1]).zip(&kind.switches).skip(1) {
        if tree * switch <= picture {
            lod = i;
        }
    }
    lod
}

fn is_inside(cull: &Cull, [x, y, z]: [f32; 3], radius: f32) -> bool {
    cull.planes
        .iter()
        .all(|p| p[0] * x + p[1] * y + p[2] * z + p[3] >= -radius)
}

fn next_state(state: u32, tree: u32, kind: &Kind, height: f32, away: f32, cull: &Cull) -> u32 {
    let whole = FADED << 16;
    if cull.orders[0] > 0 {
        return cull.orders[0].min(kind.bins[1]) | whole;
    }
    let own = height * (1.0 + cull.sight[3] * own_number(tree));
    let picture = cull.sight[0] * away + cull.sight[1];
    let finest = coarsest(kind, own * own, picture);
    if state & 255 == 0 {
        return (finest + 1) | whole;
    }
    let now = (state & 255) - 1;
    let fade = ((state >> 16) + cull.counts[3]).min(FADED);
    if state >> 16 < FADED && fade < FADED {
        return (state & 0xffff) | (fade << 16);
    }
    let margin = coarsest(kind, own * own * cull.sight[2], picture);
    let next = if now > finest {
        finest
    } else {
        now.max(margin)
    };
    if next == now {
        return (now + 1) | whole;
    }
    (next + 1) | (now << 8) | (cull.counts[3].min(FADED) << 16)
}

fn choice_of(index: u32, tree: &ForestTree, state: &mut u32, kinds: &[Kind], cull: &Cull) -> u32 {
    let kind = &kinds[tree.model as usize];
    let [x, y, z] = tree.place;
    let [rise, radius, height, reach] = kind.shape.map(|x| x * tree.size);
    let middle = [x, y + rise, z];
    let d = [0, 1, 2].map(|i| middle[i] - cull.eye[i]);
    let away = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let seen = is_inside(cull, middle, radius);
    let across = (x - cull.shade[0]).abs().max((z - cull.shade[1]).abs());
    let casts = across <= cull.shade[2] + radius && cull.shade[2] > 0.0;
    let mut chosen = [NO_BIN; 4];
    let mut next = 0;
    if seen || casts {
        next = next_state(*state, index, kind, height, away, cull);
        let lod = (next & 255) - 1;
        if seen {
            chosen[0] = kind.bins[0] + lod;
            if next >> 16 < FADED {
                chosen[1] = kind.bins[0] + ((next >> 8) & 255);
            }
        }
        if casts && (kind.bins[3] >> lod) & 1 == 1 {
            chosen[2] = kind.casts[0] + (kind.bins[3] & ((1 << lod) - 1)).count_ones();
        }
    }
    let reach = reach * f32::from_bits(cull.orders[1]);
    let flat = reach * reach * cull.eye[3];
    let ground = cull.sight[0] * away + cull.sight[1];
    let is_large = flat >= cull.shade[3] * ground * away && cull.shade[3] > 0.0;
    if is_large && is_inside(cull, tree.place, reach) {
        chosen[3] = kind.bins[2];
    }
    *state = next;
    chosen[0] | (chosen[1] << 8) | (chosen[2] << 16) | (chosen[3] << 24)
}
