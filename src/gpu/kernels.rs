//! Kernels that are used more than once.

use super::context::Context;
use super::kernel::{KernelDescriptor, SceneKernel};
use super::shader::KernelConstants;
use crate::effects::Effects;
use crate::error::GpuError;
use std::sync::{Mutex, PoisonError};

/// Cache of the kernels that one device has compiled.
#[derive(Debug, Default)]
pub(super) struct Kernels(Mutex<Vec<SceneKernel>>);

impl Context {
    /// The kernel of `descriptor` for `effects`: compiled at the first call, kept as long as the
    /// device.
    ///
    /// # Errors
    /// The shader does not link, or the driver refuses it.
    pub fn kernel(
        &self,
        descriptor: &KernelDescriptor<'_>,
        effects: &Effects,
        constants: &KernelConstants,
    ) -> Result<SceneKernel, GpuError> {
        let wgsl = SceneKernel::link(descriptor, effects, constants)?;
        let cached = || {
            self.kernels
                .0
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(known) = cached().iter().find(|kernel| kernel.wgsl() == wgsl) {
            return Ok(known.clone());
        }
        let kernel = SceneKernel::compile(self, descriptor, (effects, constants), wgsl)?;
        cached().push(kernel.clone());
        Ok(kernel)
    }
}
