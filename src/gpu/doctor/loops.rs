//! Whether loops run to their end.

use super::probe::probe;
use crate::error::GpuError;
use crate::gpu::Context;
use serde::Serialize;

/// Loops that a driver may end early: Mesa's lavapipe before version 23 ends all loops of an
/// invocation after 65,535 iterations in total and says nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LoopBudget {
    /// What each test loop did.
    pub canaries: Vec<LoopCanary>,
}

/// One test loop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LoopCanary {
    /// How it is nested.
    pub shape: &'static str,
    /// Iterations of the innermost body that were asked for.
    pub expected: u32,
    /// Iterations that ran.
    pub ran: u32,
}

impl LoopBudget {
    /// Whether every loop ran to its end.
    pub fn is_unlimited(&self) -> bool {
        self.canaries.iter().all(|c| c.ran == c.expected)
    }
}

/// Runs the test loops of `shaders/kernel/loop_canary.wesl`.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub fn loop_budget(context: &Context) -> Result<LoopBudget, GpuError> {
    const EXPECTED: [(&str, u32); 2] = [("70,000", 70_000), ("200 × 1,000", 200_000)];
    let ran = probe(context, "loop_canary", &[], 4, [EXPECTED.len() as u32, 1])?;
    let canaries = EXPECTED
        .iter()
        .zip(ran)
        .map(|(&(shape, expected), ran)| LoopCanary {
            shape,
            expected,
            ran,
        });
    Ok(LoopBudget {
        canaries: canaries.collect(),
    })
}
