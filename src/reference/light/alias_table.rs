//! Choice from a discrete distribution, by the same integers as on the GPU.

use crate::reference::core::math::multiply_high;
use crate::reference::core::pdf::PdfDiscrete;
use crate::scene::alias_table::AliasTable;

/// The chosen index and the probability with which it is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// The index.
    pub index: u32,
    /// Its probability.
    pub probability: PdfDiscrete,
}

/// Which entry of a table of `count` entries the random word `u` falls on.
pub fn alias_entry(u: u32, count: u32) -> u32 {
    multiply_high(u, count)
}

/// Decides between the entry that `u` falls on and its alias.
pub fn alias_choice(u: u32, table: &AliasTable) -> Choice {
    let count = table.entries.len() as u32;
    let index = alias_entry(u, count);
    let entry = table.entries[index as usize];
    let keep = u.wrapping_mul(count) < entry.threshold;
    let index = if keep { index } else { entry.alias };
    Choice {
        index,
        probability: PdfDiscrete(table.probability[index as usize]),
    }
}
