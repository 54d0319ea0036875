//! CacheBuster of kernels that are compiled anew.

use std::time::SystemTime;

/// Numbers that no kernel is likely to have been compiled with before: drivers keep on disk what
/// they compile. See [`Session::compiled_anew`](super::Session::compiled_anew).
#[derive(Debug)]
pub struct CacheBuster(u32);

impl CacheBuster {
    /// Those of this moment.
    pub fn now() -> Self {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let nanoseconds = now.map_or(0, |since| since.as_nanos() as u64);
        // Fibonacci hashing (Knuth 1998, §6.4).
        Self((nanoseconds.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32)
    }

    /// The next, never 0.
    pub fn draw(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(1).max(1);
        self.0
    }
}
