//! How fine the picture may be while something moves, and how long frames took.
//!
//! A software driver draws a large tree in half a second. So while something moves, the picture gets as many
//! pixels as are drawn in time, and coarser LODs if pixels alone do not help; at rest it is drawn once in full.

use std::collections::{BTreeMap, VecDeque};

/// Seconds that drawing may take while something moves: with what the window itself needs, some 0.03, at least 10
/// frames a second.
pub const GOAL: f32 = 0.055;

/// Parts of the window's pixels along an edge, from the finest.
const FACTORS: [f32; 6] = [1.0, 0.75, 0.5, 0.375, 0.3, 0.25];

/// The step of half the pixels along an edge.
const HALF: usize = 2;

/// What a picture with the next LOD takes of the time, and the power of its edge that a picture's time goes by,
/// until they are known. Both as measured with the olive on software Vulkan.
const NEXT_LOD: f32 = 0.65;
const EDGE_POWER: f32 = 1.25;

/// A finer picture must be predicted to take less than this part of the goal, and the present one is kept up
/// to this multiple of it, so that the picture does not change from frame to frame.
const SURE: f32 = 0.8;
const ENDURED: f32 = 1.2;

/// Where a picture takes less than this part of the goal, more pixels are tried.
const PLENTY: f32 = 0.4;

/// Seconds without motion after which the picture is drawn in full.
pub const REST: f64 = 0.25;

/// Seconds for which a person waits at rest, once.
const BORNE: f32 = 2.5;

/// Frames whose times are kept.
pub const KEPT: usize = 120;

/// How fine a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Part of the window's pixels along an edge.
    pub factor: f32,
    /// LODs coarser than they would be.
    pub coarser: usize,
}

impl Quality {
    /// All pixels, and LODs as they are.
    pub const FULL: Self = Self {
        factor: 1.0,
        coarser: 0,
    };
}

/// Step of a factor, and how much coarser LODs are.
type Key = (usize, usize);

fn quality_of((coarser, step): Key) -> Quality {
    Quality {
        factor: FACTORS[step],
        coarser,
    }
}

/// Learns how long pictures take.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    known: BTreeMap<Key, f32>,
    now: Key,
}

impl Pace {
    /// How fine the next picture may be. LODs may get from `least` to `most` coarser.
    ///
    /// A picture at rest that is finer than that already stays.
    pub fn quality(
        &mut self,
        moving: bool,
        (least, most): (usize, usize),
        drawn: Quality,
    ) -> Quality {
        if self.known.is_empty() {
            // A first look, by which the rest is judged: a forest may take a quarter of a minute in full.
            self.now = (if moving { most } else { least }, FACTORS.len() - 1);
            return quality_of(self.now);
        }
        if !moving {
            let resting = self.at_rest(least);
            let finer = drawn.coarser == least && drawn.factor > resting.factor;
            return if finer { drawn } else { resting };
        }
        self.now.0 = self.now.0.clamp(least, most);
        let (coarser, step) = self.now;
        if self
            .known
            .get(&self.now)
            .is_some_and(|&known| known < GOAL * PLENTY)
        {
            // What more pixels took was measured in harder times.
            self.known.retain(|&(c, s), _| c != coarser || s >= step);
        }
        if self.predicted(self.now) > GOAL * ENDURED || self.now.1 > 0 || self.now.0 > 0 {
            self.now = self.best(least, most);
        }
        quality_of(self.now)
    }

    /// The finest, without LODs coarser than they must be, for which a person waits.
    fn at_rest(&self, least: usize) -> Quality {
        let steps = 0..FACTORS.len();
        let borne = |step: &usize| self.predicted((least, *step)) <= BORNE;
        quality_of((least, steps.clone().find(borne).unwrap_or(steps.end - 1)))
    }

    /// The finest that is quick enough.
    fn best(&self, least: usize, most: usize) -> Key {
        for coarser in least..=most {
            // Below half the pixels along an edge, a coarser LOD is the smaller loss; above, it is the larger one.
            let first = if coarser == least { 0 } else { HALF };
            let end = if coarser == least && most > least {
                HALF + 1
            } else {
                FACTORS.len()
            };
            for step in first..end {
                let key = (coarser, step);
                let allowed = if key < self.now { SURE } else { ENDURED };
                if self.predicted(key) <= GOAL * allowed {
                    return key;
                }
            }
        }
        (most, FACTORS.len() - 1)
    }

    /// Seconds that a picture will take; what nothing is known of is tried.
    fn predicted(&self, key @ (coarser, step): Key) -> f32 {
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let alike = self.known.range((coarser, 0)..(coarser + 1, 0));
        let nearest = alike.min_by_key(|((_, s), _)| s.abs_diff(step));
        let Some((&(_, other), &seconds)) = nearest else {
            return self.predicted_by_others((coarser, step));
        };
        seconds * libm::powf(FACTORS[step] / FACTORS[other], EDGE_POWER)
    }

    /// The same where nothing is known of any picture with these LODs.
    fn predicted_by_others(&self, (coarser, step): Key) -> f32 {
        let below = self.known.keys().rev().find(|(c, _)| *c < coarser);
        let above = self.known.keys().find(|(c, _)| *c > coarser);
        match (below, above) {
            (Some(&(other, _)), _) => {
                (other..coarser).fold(self.predicted((other, step)), |s, _| s * NEXT_LOD)
            }
            (None, Some(&(other, _))) => {
                (coarser..other).fold(self.predicted((other, step)), |s, _| s / NEXT_LOD)
            }
            (None, None) => 0.0,
        }
    }

    /// Takes in how long a picture took.
    pub fn observe(&mut self, quality: Quality, seconds: f32) {
        let step = FACTORS.iter().position(|&f| f <= quality.factor);
        let key = (quality.coarser, step.unwrap_or(FACTORS.len() - 1));
        let Some(&before) = self.known.get(&key) else {
            self.known.insert(key, seconds);
            return;
        };
        // Going nearer makes all pictures slower. But a picture may also have been slow by itself, as when a driver
        // compiled for it: so the others follow by the root of the change.
        let change = (0.5 + 0.5 * seconds / before.max(1e-4)).clamp(0.25, 4.0);
        let others = libm::sqrtf(change);
        for (known, seconds) in &mut self.known {
            *seconds *= if *known == key { change } else { others };
        }
    }

    /// Forgets all: other things are drawn now.
    pub fn forget(&mut self) {
        self.known.clear();
    }
}

/// Times of the last frames, seconds.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    times: VecDeque<f32>,
    drawn: u64,
}

impl Frames {
    /// Adds a frame.
    pub fn add(&mut self, seconds: f32) {
        if self.times.len() == KEPT {
            self.times.pop_front();
        }
        self.times.push_back(seconds);
        self.drawn += 1;
    }

    /// Frames drawn since the beginning.
    #[must_use]
    pub fn drawn(&self) -> u64 {
        self.drawn
    }

    /// From the oldest to the newest.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.times.iter().copied()
    }

    /// The newest.
    #[must_use]
    pub fn last(&self) -> Option<f32> {
        self.times.back().copied()
    }

    /// The slowest.
    #[must_use]
    pub fn slowest(&self) -> f32 {
        self.times().fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine on which a picture takes `fixed` seconds, halved with each coarser LOD, and `pixels` seconds
    /// for a whole picture's pixels.
    fn settled(fixed: f32, pixels: f32, most: usize) -> (Quality, f32, usize) {
        let mut pace = Pace::default();
        let cost = |q: Quality| {
            let halved = (0..q.coarser).fold(fixed, |seconds, _| seconds * 0.5);
            halved + pixels * q.factor * q.factor
        };
        pace.observe(Quality::FULL, cost(Quality::FULL));
        let mut quality = Quality::FULL;
        let mut changes = 0;
        for frame in 0..60 {
            let next = pace.quality(true, (0, most), Quality::FULL);
            changes += usize::from(frame > 20 && next != quality);
            quality = next;
            pace.observe(quality, cost(quality));
        }
        assert_eq!(pace.quality(false, (0, most), Quality::FULL), Quality::FULL);
        (quality, cost(quality), changes)
    }

    #[test]
    fn a_quick_machine_draws_in_full() {
        assert_eq!(settled(0.005, 0.005, 3), (Quality::FULL, 0.01, 0));
    }

    #[test]
    fn a_slow_machine_comes_to_rest_within_the_goal() {
        for (fixed, pixels) in [
            (0.01, 0.3),
            (0.1, 0.5),
            (0.4, 0.1),
            (0.05, 0.02),
            (0.03, 0.12),
        ] {
            let (quality, seconds, changes) = settled(fixed, pixels, 4);
            assert!(
                seconds <= GOAL * ENDURED,
                "{fixed} {pixels}: {quality:?} {seconds}"
            );
            assert!(
                seconds > GOAL * 0.1,
                "{fixed} {pixels}: {quality:?} is wasteful"
            );
            assert_eq!(changes, 0, "{fixed} {pixels}: {quality:?}");
        }
    }

    #[test]
    fn a_picture_that_nobody_would_wait_for_is_not_drawn_even_at_rest() {
        let mut pace = Pace::default();
        let first = pace.quality(false, (0, 2), Quality::FULL);
        assert_eq!(
            (first.factor, first.coarser),
            (FACTORS[FACTORS.len() - 1], 0)
        );
        pace.observe(first, 1.2);
        // A quarter of a minute in full.
        let resting = pace.quality(false, (0, 2), first);
        assert!(resting.factor < 0.5, "{resting:?}");
        pace.forget();
        pace.observe(first, 0.002);
        assert_eq!(pace.quality(false, (0, 2), first), Quality::FULL);
        // What is there already stays, though it took long.
        pace.observe(Quality::FULL, 9.0);
        assert_eq!(pace.quality(false, (0, 2), Quality::FULL), Quality::FULL);
    }

    #[test]
    fn lods_chosen_by_hand_stay_and_pixels_give_way() {
        let (quality, _, _) = settled(0.2, 0.5, 0);
        assert_eq!(quality.coarser, 0);
        assert_eq!(quality.factor, FACTORS[FACTORS.len() - 1]);
    }

    #[test]
    fn what_gets_quicker_gets_finer() {
        let mut pace = Pace::default();
        for _ in 0..20 {
            let quality = pace.quality(true, (0, 0), Quality::FULL);
            pace.observe(quality, 0.4 * quality.factor * quality.factor);
        }
        assert!(pace.quality(true, (0, 0), Quality::FULL).factor < 0.5);
        for _ in 0..60 {
            let quality = pace.quality(true, (0, 0), Quality::FULL);
            pace.observe(quality, 0.025 * quality.factor * quality.factor);
        }
        assert_eq!(pace.quality(true, (0, 0), Quality::FULL).factor, 1.0);
    }

    #[test]
    fn a_first_picture_for_which_a_driver_compiled_is_forgotten() {
        let mut pace = Pace::default();
        let (coarse, fine) = ((0.25, 1), (0.5, 0));
        let quality = |(factor, coarser)| Quality { factor, coarser };
        pace.observe(quality(coarse), 0.64);
        pace.observe(quality(fine), 0.33);
        let mut slow = 0;
        for frame in 0..200 {
            let next = pace.quality(true, (0, 1), Quality::FULL);
            let seconds = if next == quality(coarse) { 0.06 } else { 0.27 };
            slow += usize::from(frame >= 20 && seconds > GOAL * ENDURED);
            pace.observe(next, seconds);
        }
        assert!(slow <= 5, "{slow} of 180 frames");
    }

    #[test]
    fn the_last_frames_are_kept() {
        let mut frames = Frames::default();
        for i in 0..KEPT + 5 {
            frames.add(i as f32);
        }
        assert_eq!(frames.times().len(), KEPT);
        assert_eq!(frames.times().next(), Some(5.0));
        assert_eq!((frames.last(), frames.slowest()), (Some(124.0), 124.0));
    }
}
