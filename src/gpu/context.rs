//! The adapter and the device.

use super::gpu_scene::{BINDINGS_OF_SPLIT, GpuScenes};
use super::kernels::Kernels;
use crate::accel::flatten::MAX_PRIMITIVES;
use crate::accel::parts::{PARTS, PRIMITIVE_WORDS, Split, WORD_BYTES};
use crate::error::GpuError;
use crate::scene::load::Capacity;
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};

/// What is known of an adapter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AdapterFacts {
    /// The adapter's name.
    pub name: String,
    /// Driver and version.
    pub driver: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// Whether it is a CPU pretending to be a GPU.
    pub software: bool,
}

impl AdapterFacts {
    pub(crate) fn of(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            backend: info.backend.to_string(),
            software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

/// An open device.
#[derive(Debug)]
pub struct Context {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What is known of the adapter.
    pub adapter: AdapterFacts,
    /// The limits that the device was opened with: all that the adapter has.
    pub limits: wgpu::Limits,
    pub(super) kernels: Kernels,
    pub(super) scenes: GpuScenes,
    troubles: Arc<Mutex<Troubles>>,
}

/// What went wrong outside any call that could have said so.
#[derive(Debug, Default)]
struct Troubles {
    /// Why the device was lost.
    lost: Option<String>,
    /// The first error that no call asked for.
    uncaptured: Option<String>,
}

/// The adapters of this machine: fast ones first, software last.
pub fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    found.sort_by_key(|a| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    found
}

impl Context {
    /// Opens the first adapter whose name or driver contains `wanted` (any case), or the best one.
    ///
    /// # Errors
    /// There is no adapter, none with that name, or its device cannot be opened.
    pub fn new(wanted: Option<&str>) -> Result<Self, GpuError> {
        let all = adapters();
        if all.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        let adapter =
            match wanted {
                None => &all[0],
                Some(wanted) => all.iter().find(|a| matches(a, wanted)).ok_or_else(|| {
                    GpuError::NoSuchAdapter {
                        wanted: wanted.to_owned(),
                        available: all.iter().map(|a| a.get_info().name).collect(),
                    }
                })?,
            };
        Self::open(adapter)
    }

    /// Opens `adapter` with all the limits that it has.
    ///
    /// # Errors
    /// The device cannot be opened.
    pub fn open(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        Self::open_with(adapter, adapter.limits())
    }

    /// Opens `adapter` with `limits`.
    ///
    /// # Errors
    /// The device cannot be opened, or the adapter has less.
    pub fn open_with(adapter: &wgpu::Adapter, limits: wgpu::Limits) -> Result<Self, GpuError> {
        let facts = AdapterFacts::of(&adapter.get_info());
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("direkt"),
            required_limits: limits.clone(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                GpuError::Device {
                    adapter: facts.name.clone(),
                    message: e.to_string(),
                }
            })?;
        let troubles = Arc::<Mutex<Troubles>>::default();
        let (of_loss, of_error) = (Arc::clone(&troubles), Arc::clone(&troubles));
        device.set_device_lost_callback(move |reason, message| {
            locked(&of_loss).lost = Some(format!("{message} ({reason:?})"));
        });
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            locked(&of_error)
                .uncaptured
                .get_or_insert_with(|| error.to_string());
        }));
        Ok(Self {
            device,
            queue,
            adapter: facts,
            limits,
            kernels: Kernels::default(),
            scenes: GpuScenes::default(),
            troubles,
        })
    }

    /// The caller's device. The caller has to watch for its loss, and for errors that no call
    /// reports.
    pub fn of_device(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            adapter: AdapterFacts::of(&device.adapter_info()),
            limits: device.limits(),
            kernels: Kernels::default(),
            scenes: GpuScenes::default(),
            troubles: Arc::default(),
        }
    }

    /// Most triangles that a scene may have on this adapter.
    pub fn capacity(&self) -> Capacity {
        let limits = &self.limits;
        let binding = limits.max_storage_buffer_binding_size;
        let words = binding.min(limits.max_buffer_size) / WORD_BYTES as u64;
        let whole = words / PRIMITIVE_WORDS as u64;
        let split = if limits.max_storage_buffers_per_shader_stage >= BINDINGS_OF_SPLIT {
            let part = 1 << words.max(1).ilog2();
            (PARTS * Split::of_words(part).primitives) as u64
        } else {
            0
        };
        Capacity {
            triangles: whole.max(split).min(MAX_PRIMITIVES),
            reason: format!(
                "which is what {} takes, or another --adapter",
                self.adapter.name
            ),
        }
    }

    /// Runs `work` and turns what the driver reports meanwhile into an error.
    ///
    /// # Errors
    /// wgpu reported a validation error, an internal one, or that memory ran out; or the device is
    /// lost.
    pub fn checked<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let scopes = [
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Validation,
        ]
        .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop());
            first = first.or(error);
        }
        match first {
            Some(wgpu::Error::OutOfMemory { source }) => {
                Err(out_of_memory(&self.adapter.name, &*source))
            }
            Some(error) => Err(self.driver_error(error.to_string())),
            None => match self.trouble() {
                Some(trouble) => Err(trouble),
                None => Ok(result),
            },
        }
    }

    /// What went wrong outside any call.
    fn trouble(&self) -> Option<GpuError> {
        let troubles = locked(&self.troubles);
        let message = troubles
            .lost
            .as_ref()
            .or(troubles.uncaptured.as_ref())?
            .clone();
        drop(troubles);
        Some(self.driver_error(message))
    }

    /// Waits until the device has done everything that was submitted.
    ///
    /// # Errors
    /// The device was lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|e| self.driver_error(format!("waiting failed: {e}")))
    }

    /// Reads a buffer that was created with `MAP_READ`, and hands its bytes to `read`.
    ///
    /// # Errors
    /// The buffer cannot be mapped.
    pub fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        self.read_first(buffer, buffer.size(), read)
    }

    /// The same with the first `bytes` of the buffer.
    ///
    /// # Errors
    /// The buffer cannot be mapped.
    pub fn read_first<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver lives until it has received, below.
            let _ = sender.send(result);
        });
        self.wait()?;
        let mapped = receiver
            .recv()
            .map_err(|e| self.driver_error(format!("mapping was dropped: {e}")))?;
        mapped.map_err(|e| self.driver_error(format!("mapping failed: {e}")))?;
        let view = buffer
            .get_mapped_range(..bytes)
            .map_err(|e| self.driver_error(format!("mapping failed: {e}")))?;
        let out = read(&view);
        drop(view);
        buffer.unmap();
        Ok(out)
    }

    /// An error that names this adapter, and says so where the device is lost.
    pub fn driver_error(&self, message: impl Into<String>) -> GpuError {
        let adapter = self.adapter.name.clone();
        match locked(&self.troubles).lost.clone() {
            Some(message) => GpuError::Lost { adapter, message },
            None => GpuError::Driver {
                adapter,
                message: message.into(),
            },
        }
    }
}

fn out_of_memory(adapter: &str, source: &dyn std::error::Error) -> GpuError {
    // wgpu's own words say no more than the variant; what led to it does.
    let causes = std::iter::successors(Some(source), |e| e.source());
    let causes: Vec<_> = causes.map(ToString::to_string).collect();
    GpuError::OutOfMemory {
        adapter: adapter.to_owned(),
        message: causes.join(": "),
    }
}

fn locked(troubles: &Mutex<Troubles>) -> std::sync::MutexGuard<'_, Troubles> {
    troubles.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether `wanted` is a part of the adapter's name or driver, in any case.
pub fn matches(adapter: &wgpu::Adapter, wanted: &str) -> bool {
    let facts = AdapterFacts::of(&adapter.get_info());
    let wanted = wanted.to_lowercase();
    [&facts.name, &facts.driver]
        .iter()
        .any(|s| s.to_lowercase().contains(&wanted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_out_of_memory_names_the_adapter_and_a_way_out() {
        let source = std::io::Error::other("buffer `direct.pixels`: 64 MiB");
        let error = out_of_memory("Some GPU", &source).to_string();
        assert!(error.starts_with("Some GPU: out of memory: buffer `direct.pixels`"));
        assert!(error.contains("a smaller image or scene"), "{error}");
    }
}
