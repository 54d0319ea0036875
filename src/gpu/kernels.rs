//! Kernels that are used more than once.

use super::context::Context;
use super::kernel::{Entry, SceneKernel};
use super::shader::Config;
use crate::effects::Effects;
use crate::error::GpuError;

/// Kernels that one device has compiled: those of the device that was last asked for.
#[derive(Debug, Default)]
pub struct Kernels {
    device: u64,
    known: Vec<SceneKernel>,
}

impl Kernels {
    /// The kernel of `entry` for `effects`: one that is known, or else compiled now.
    ///
    /// # Errors
    /// The shader does not link, or the driver refuses it.
    pub fn get(
        &mut self,
        context: &Context,
        entry: &Entry<'_>,
        effects: &Effects,
        config: Config,
    ) -> Result<SceneKernel, GpuError> {
        let wgsl = SceneKernel::link(entry, effects, config)?;
        if self.device != context.id {
            self.known.clear();
            self.device = context.id;
        }
        if let Some(known) = self.known.iter().find(|kernel| kernel.wgsl() == wgsl) {
            return Ok(known.clone());
        }
        let kernel = SceneKernel::compile(context, entry, (effects, config), wgsl)?;
        self.known.push(kernel.clone());
        Ok(kernel)
    }
}
