//! The graphics adapter as the second backend of captures and of ground shadows: for feedback at once while a
//! tree is being made.
//!
//! Captures: all shots of a pass lie side by side on one sheet of samples. One render pass lights the grids of leaf
//! density, one keeps the nearest surface of each sample in eight bytes, one averages them to texels and shades
//! those, and one copy brings them back. Shadows: threads mark the texels of some triangles in the bit masks of some
//! samples, which a second pass sums: no rasteriser is as quick with triangles of a few texels.
//!
//! Where there is a choice, it is what a software driver does fast: it has no time to lose, and a card does not
//! mind. Such a driver reads storage buffers one thread after the other, textures and uniforms all at once.
//!
//! What comes out is equal to what the processor draws within a tolerance (`tests/gpu_bake.rs`), and may differ
//! from adapter to adapter. So the bytes of packs come from the processor unless asked otherwise, and the
//! manifest says it where they do not.

mod captures;
mod develop;
mod group;
pub mod layout;
mod passes;
mod shadows;
mod sheet;
mod upload;

use crate::capture::{self, Pass, Picture};
use crate::gpu::{Gpu, GpuError};
use crate::report::{MachineFault, Progress};
use crate::shadow::{self, Work};
use core::ops::AddAssign;
use std::sync::{Mutex, PoisonError};

/// Draws captures and shadows on an adapter.
#[derive(Debug)]
pub struct Baker {
    gpu: Gpu,
    captures: passes::Pipelines,
    shadows: shadows::Pipelines,
    tally: Mutex<Tally>,
    /// What the last captures were drawn into: an edit is followed by the next, and a driver takes its time to get so
    /// much memory.
    targets: Mutex<Option<passes::Targets>>,
}

/// What was asked of the adapter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Batches of commands handed over.
    pub submits: u64,
    /// Render and compute passes.
    pub passes: u64,
    /// Draws and dispatches in them.
    pub calls: u64,
    /// Bytes sent to the adapter.
    pub bytes_up: u64,
    /// Bytes read back.
    pub bytes_back: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.submits += other.submits;
        self.passes += other.passes;
        self.calls += other.calls;
        self.bytes_up += other.bytes_up;
        self.bytes_back += other.bytes_back;
    }
}

impl Baker {
    /// Compiles what an adapter needs.
    ///
    /// # Errors
    /// If the driver refuses a shader.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let baker = Self {
            gpu: gpu.clone(),
            captures: passes::Pipelines::new(&gpu.device),
            shadows: shadows::Pipelines::new(gpu),
            tally: Mutex::default(),
            targets: Mutex::default(),
        };
        gpu.check()?;
        Ok(baker)
    }

    /// The adapter.
    #[must_use]
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What was asked of the adapter since the last call.
    #[must_use]
    pub fn take_tally(&self) -> Tally {
        let mut tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
        core::mem::take(&mut *tally)
    }

    fn count(&self, more: Tally) {
        let mut tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
        *tally += more;
    }

    /// The targets of earlier captures, unless another thread draws into them.
    fn kept_targets(&self) -> Option<passes::Targets> {
        let mut kept = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        kept.take()
    }

    /// Keeps targets for the next captures, if they are not unusually large.
    fn keep(&self, targets: Option<passes::Targets>) {
        let mut kept = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(targets) = targets.filter(passes::Targets::is_usual) {
            *kept = Some(targets);
        }
    }
}

impl capture::Backend for Baker {
    fn draw(
        &self,
        pass: &Pass<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Picture>>, capture::BakeError> {
        captures::draw(self, pass, progress)
    }

    fn inexact(&self) -> Option<String> {
        Some(self.gpu.describe())
    }
}

impl shadow::Backend for Baker {
    fn sums(
        &self,
        work: &Work<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<u16>>, shadow::BakeError> {
        shadows::sums(self, work, progress)
    }

    fn inexact(&self) -> Option<String> {
        Some(self.gpu.describe())
    }
}

impl From<GpuError> for MachineFault {
    fn from(error: GpuError) -> Self {
        Self {
            passing: error.is_worth_another_try(),
            reason: error.to_string(),
        }
    }
}
