//! Fuzzing of everything that reads what a stranger may have written.
//!
//! Shared by `examples/fuzz`, which runs millions of inputs, and the tests, which run a few
//! thousand.

mod json;
mod mutate;
mod numbers;
pub mod random;
mod readers;
mod seeds;
pub mod sound;

use random::Random;
pub use readers::{Reader, Workplace};

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Most inputs that are kept to be damaged further.
const MAX_POOL: usize = 512;

/// Inputs of a reader, one after the other; those that bring up a new message are damaged further.
#[derive(Debug)]
pub struct Inputs {
    reader: Reader,
    random: Random,
    pool: Vec<Vec<u8>>,
    /// So many of them, the first ones, are valid.
    valid: usize,
    messages: HashSet<String>,
}

impl Inputs {
    /// The inputs of a seed.
    pub fn new(reader: Reader, seed: u64) -> Self {
        let pool = reader.seeds();
        Self {
            reader,
            random: Random::new(seed),
            valid: pool.len(),
            pool,
            messages: HashSet::new(),
        }
    }

    /// The next input.
    pub fn next(&mut self) -> Vec<u8> {
        // Every second one comes from a valid input: what has been damaged often is refused early.
        let end = if self.random.below(2) == 0 {
            self.valid
        } else {
            self.pool.len()
        };
        let chosen = self.random.below(end);
        self.reader.mutated(&mut self.random, chosen, &self.pool)
    }

    /// Takes note of how `input` was refused.
    pub fn refused(&mut self, input: &[u8], message: &str) {
        if self.messages.insert(kind(message)) && self.pool.len() < MAX_POOL {
            self.pool.push(input.to_vec());
        }
    }

    /// Kinds of messages so far.
    pub fn kinds(&self) -> usize {
        self.messages.len()
    }
}

/// The words of a message that its reader wrote, without those of the input: they tell which check
/// it comes from.
pub fn kind(message: &str) -> String {
    let mut quoted = false;
    let mut kept = String::new();
    for word in message.split_whitespace().take(20) {
        let quotes = word.matches(['`', '"', '\'']).count();
        let plain = word.trim_end_matches([':', ';', ',', '.']);
        if !quoted && quotes == 0 && plain.bytes().all(|b| b.is_ascii_lowercase()) {
            kept.push_str(plain);
            kept.push(' ');
        }
        quoted ^= quotes % 2 == 1;
    }
    kept
}

/// Reads one input: the message with which it is refused, or `None` for a scene. `Err` says what is
/// wrong with the reader, a panic among it.
pub fn execute(place: &Workplace, input: &[u8]) -> Result<Option<String>, String> {
    place
        .put(input)
        .map_err(|e| format!("the input cannot be written: {e}"))?;
    guarded(|| place.read(input))
}

/// What `read` returns; a panic is an error.
pub fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
        Err(format!("panicked: {}", text.unwrap_or("without a message")))
    })
}
