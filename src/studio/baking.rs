//! Who makes the captures and the shadows of sketches: a graphics card where there is one, else the processor.
//!
//! It bakes on a device of its own: the window's tells its faults to whoever asks first. Whole trees are the processor's, as packs are: what is exported has the same bytes on any machine.

use crate::capture::BakeError;
use crate::gpu::Gpu;
use crate::gpu_bake::Baker;
use crate::pipeline::{Bakers, GenerateError};

/// Who makes the captures and the shadows of sketches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SketchBaker {
    /// A graphics card if there is one: a software driver is no faster than we are.
    #[default]
    Auto,
    /// The processor.
    Cpu,
    /// The adapter, be it a software driver.
    Gpu,
}

/// What bakes, made when it is first needed.
#[derive(Debug, Default)]
pub(super) struct Baking {
    choice: SketchBaker,
    /// None until it is needed, where no device can be had, and after one was lost.
    baker: Option<Baker>,
    has_none: bool,
}

impl Baking {
    pub(super) fn new(choice: SketchBaker) -> Self {
        Self {
            choice,
            ..Self::default()
        }
    }

    /// Bakes something; once more with the processor if the adapter fails. `is_software` says what the window draws with.
    pub(super) fn bake<T>(
        &mut self,
        is_software: bool,
        mut bake: impl FnMut(Bakers<'_>) -> Result<T, GenerateError>,
    ) -> Result<T, GenerateError> {
        let Some(baker) = self.baker(is_software) else {
            return bake(Bakers::CPU);
        };
        let made = bake(Bakers {
            captures: baker,
            shadows: baker,
        });
        match made {
            Err(
                error @ (GenerateError::Machine(_) | GenerateError::Bake(BakeError::Machine(_))),
            ) => {
                if error.is_passing() {
                    // A lost device stays lost; the next tree gets another.
                    self.baker = None;
                }
                bake(Bakers::CPU)
            }
            made => made,
        }
    }

    fn baker(&mut self, is_software: bool) -> Option<&Baker> {
        let is_wanted = match self.choice {
            SketchBaker::Auto => !is_software,
            SketchBaker::Cpu => false,
            SketchBaker::Gpu => true,
        };
        if is_wanted && !self.has_none && self.baker.is_none() {
            self.baker = Gpu::headless().and_then(|gpu| Baker::new(&gpu)).ok();
            self.has_none = self.baker.is_none();
        }
        self.baker.as_ref()
    }
}
