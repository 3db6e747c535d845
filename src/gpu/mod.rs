//! The device: finding an adapter, with or without a screen, and what went wrong in words.
//!
//! All that this program needs of an adapter is in wgpu's default limits, which software Vulkan and OpenGL
//! drivers meet; what is beyond them is used where it is and done without where not.

mod picture;
pub mod shader;
mod upload;

pub use picture::{Readback, read_texture};
pub use upload::upload;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Features that are used where the adapter has them, and done without elsewhere.
pub(crate) const WELCOME: wgpu::Features = wgpu::Features::INDIRECT_FIRST_INSTANCE
    .union(wgpu::Features::TIMESTAMP_QUERY)
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// What to install where no adapter is found.
const HINT: &str = "install a driver: on Debian and Ubuntu `apt install mesa-vulkan-drivers` brings one that \
                    needs no graphics card";

/// Why something could not be drawn.
#[derive(Clone, Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver, or none that the environment allows.
    #[error("no graphics adapter: {reason}; {HINT}")]
    NoAdapter {
        /// What was looked for, and what each driver said.
        reason: String,
    },
    /// An adapter that lacks what all of ours need.
    #[error("the graphics adapter {adapter} cannot be used: {reason}")]
    Unfit {
        /// Its name.
        adapter: String,
        /// What it lacks.
        reason: String,
    },
    /// Larger than the adapter allows.
    #[error("{what} of {size} is more than the graphics adapter allows: {limit}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Its size.
        size: u64,
        /// The adapter's limit.
        limit: u64,
    },
    /// The adapter has no memory left.
    #[error("the graphics adapter has no memory left: {0}")]
    OutOfMemory(String),
    /// The driver gave up, or the card was taken away.
    #[error("the graphics adapter was lost: {0}; try again")]
    Lost(String),
    /// The driver refused a command: a fault of this program.
    #[error("the graphics driver refused a command, a fault of this program: {0}")]
    Refused(String),
}

impl GpuError {
    /// True if the machine is at fault and another try may help.
    #[must_use]
    pub fn is_worth_another_try(&self) -> bool {
        matches!(self, Self::Lost(_) | Self::OutOfMemory(_))
    }
}

/// A device with its queue, and the first error that it told.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// Name, driver, kind.
    pub info: wgpu::AdapterInfo,
    fault: Arc<Mutex<Option<GpuError>>>,
}

impl Gpu {
    /// Opens the best adapter that needs no screen. `WGPU_BACKEND` (`vulkan`, `gl`) and
    /// `WGPU_ADAPTER_NAME` (a part of its name) choose another.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] with what to install; [`GpuError::Unfit`].
    pub fn headless() -> Result<Self, GpuError> {
        pollster::block_on(Self::open())
    }

    async fn open() -> Result<Self, GpuError> {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        let instance = wgpu::Instance::new(descriptor);
        let adapter = match std::env::var("WGPU_ADAPTER_NAME") {
            Ok(name) => named(&instance, &name).await?,
            Err(_) => instance
                .request_adapter(&wgpu::RequestAdapterOptions {
                    power_preference: wgpu::PowerPreference::HighPerformance,
                    ..wgpu::RequestAdapterOptions::default()
                })
                .await
                .map_err(|e| GpuError::NoAdapter {
                    reason: e.to_string(),
                })?,
        };
        let unfit = |reason: String| GpuError::Unfit {
            adapter: adapter.get_info().name,
            reason,
        };
        let downlevel = adapter.get_downlevel_capabilities();
        if !downlevel
            .flags
            .contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::VERTEX_STORAGE)
        {
            return Err(unfit("it has no compute shaders".to_owned()));
        }
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("pleach"),
                required_features: adapter.features() & WELCOME,
                required_limits: adapter.limits(),
                ..wgpu::DeviceDescriptor::default()
            })
            .await
            .map_err(|e| unfit(e.to_string()))?;
        Ok(Self::from_parts(device, queue, adapter.get_info()))
    }

    /// A device that somebody else opened: a window's.
    #[must_use]
    pub fn from_parts(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let fault = Arc::new(Mutex::new(None));
        let told = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error| {
            first(&mut lock(&told), of(&error));
        }));
        let told = Arc::clone(&fault);
        device.set_device_lost_callback(move |_, message| {
            *lock(&told) = Some(GpuError::Lost(message));
        });
        Self {
            device,
            queue,
            info,
            fault,
        }
    }

    /// The first error since the last call, if any. That the device is lost is told at every call: whoever asks first must
    /// not be the only one to know.
    ///
    /// # Errors
    /// What the driver told of anything done with this device.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut fault = lock(&self.fault);
        match &*fault {
            Some(lost @ GpuError::Lost(_)) => Err(lost.clone()),
            _ => fault.take().map_or(Ok(()), Err),
        }
    }

    /// Does something with the device, and tells what the driver says of that alone, whatever other threads do
    /// meanwhile.
    ///
    /// # Errors
    /// That, or that the device is lost.
    pub fn apart<T>(&self, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        let filters = [
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Validation,
        ];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let mut result = work();
        // The last one that was opened is closed first.
        for scope in scopes.into_iter().rev() {
            if let Some(error) = pollster::block_on(scope.pop()) {
                result = Err(of(&error));
            }
        }
        if result.is_err() {
            // What a lost device says first is that it does not know its own buffers.
            let _ = self.device.poll(wgpu::PollType::Poll);
        }
        match &*lock(&self.fault) {
            Some(lost @ GpuError::Lost(_)) => Err(lost.clone()),
            _ => result,
        }
    }

    /// Waits for all that was submitted.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the device does not answer; see [`Gpu::check`].
    pub fn finish(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| GpuError::Lost(e.to_string()))?;
        self.check()
    }

    /// Refuses an edge that textures of this adapter cannot have.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn check_edge(&self, what: &'static str, edge: u32) -> Result<(), GpuError> {
        let limit = self.device.limits().max_texture_dimension_2d;
        if edge > limit {
            return Err(GpuError::TooLarge {
                what,
                size: u64::from(edge),
                limit: u64::from(limit),
            });
        }
        Ok(())
    }

    /// True if a processor does the work: no anisotropy there, which is a hundred times slower.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Name and driver in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let wgpu::AdapterInfo {
            name,
            driver,
            driver_info,
            backend,
            ..
        } = &self.info;
        format!("{name} ({backend:?}, {driver} {driver_info})")
    }
}

/// The adapter whose name holds `name`.
async fn named(instance: &wgpu::Instance, name: &str) -> Result<wgpu::Adapter, GpuError> {
    let adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    let wanted = name.to_lowercase();
    let found = names
        .iter()
        .position(|n| n.to_lowercase().contains(&wanted));
    found
        .and_then(|at| adapters.into_iter().nth(at))
        .ok_or_else(|| GpuError::NoAdapter {
            reason: format!("none is named like WGPU_ADAPTER_NAME={name}; there are {names:?}"),
        })
}

fn of(error: &wgpu::Error) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { source } => GpuError::OutOfMemory(source.to_string()),
        other => GpuError::Refused(other.to_string()),
    }
}

fn first(slot: &mut Option<GpuError>, error: GpuError) {
    slot.get_or_insert(error);
}

/// A poisoned lock still holds a whole value: writers only ever replace it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
