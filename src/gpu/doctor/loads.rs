//! What loads cost.

use super::probe::Probe;
use crate::error::GpuError;
use crate::gpu::Context;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Numbers that are loaded, as in `shaders/kernel/loads.wesl`.
const TABLE: u32 = 4096;
/// Invocations of a workgroup there.
const WORKGROUP: u32 = 64;
/// Workgroups.
const WORKGROUPS: u32 = 256;
/// What a measurement lasts at least.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
/// Loads of a chain at most, well below what any driver lets a loop run.
const MOST: u32 = 1 << 15;

/// What a load costs, in nanoseconds per invocation with all cores at work, where each needs the one
/// before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loads {
    /// Where neighbouring invocations load at addresses of their own, as rays do that walk a
    /// hierarchy.
    pub own_nanoseconds: f64,
    /// Where all of a workgroup load at the same address.
    pub shared_nanoseconds: f64,
}

/// Runs the chains of `shaders/kernel/loads.wesl`.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub fn loads(context: &Context) -> Result<Loads, GpuError> {
    let outputs = (WORKGROUP * WORKGROUPS) as usize;
    let probe = Probe::new(context, "loads", TABLE as usize + 2, outputs)?;
    Ok(Loads {
        own_nanoseconds: nanoseconds_of_load(&probe, 1)?,
        shared_nanoseconds: nanoseconds_of_load(&probe, 0)?,
    })
}

/// Time of a load per invocation, with addresses that are `own` (1) or not (0): what twice as many
/// of them take longer.
fn nanoseconds_of_load(probe: &Probe<'_>, own: u32) -> Result<f64, GpuError> {
    let time = |loads: u32| -> Result<Duration, GpuError> {
        let numbers = (0..TABLE).map(|i| i.wrapping_mul(2_654_435_761).rotate_left(16));
        let inputs: Vec<u32> = [loads, own].into_iter().chain(numbers).collect();
        let start = Instant::now();
        probe.run(&inputs, [WORKGROUPS, 1])?;
        Ok(start.elapsed())
    };
    // The driver may compile at the first dispatch.
    time(1)?;
    let mut loads = 64;
    let mut shorter = time(loads)?;
    loop {
        let longer = time(2 * loads)?;
        if longer >= LONG_ENOUGH || 2 * loads >= MOST {
            let more_loads = f64::from(loads) * f64::from(WORKGROUP * WORKGROUPS);
            let more = longer.saturating_sub(shorter).as_secs_f64();
            return Ok(1e9 * more / more_loads);
        }
        (loads, shorter) = (2 * loads, longer);
    }
}
