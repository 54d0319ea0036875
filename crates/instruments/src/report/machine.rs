//! The machine that was measured.

use direkt::low_level::gpu::AdapterFacts;
use serde::Serialize;

/// Adapter, driver and processor.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    /// Adapter and driver.
    pub adapter: AdapterFacts,
    /// The processor's name, where the system tells it.
    pub cpu: Option<String>,
    /// Threads that run at once.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Version of direkt.
    pub direkt: &'static str,
}

impl Machine {
    /// This machine, with the adapter that renders.
    pub fn this(adapter: &AdapterFacts) -> Self {
        Self {
            adapter: adapter.clone(),
            cpu: cpu(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            direkt: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// The first processor's name by `/proc/cpuinfo`.
fn cpu() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
