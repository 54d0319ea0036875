//! Which lights a light sample can be of.

use super::tree::LightTree;
use crate::scene::LightSelection;
use crate::scene::alias_table::AliasTable;

/// How light sampling chooses among a scene's lights.
#[derive(Debug, Clone, PartialEq)]
pub enum Selection {
    /// Each sample is of one light, chosen at random.
    One(AliasTable),
    /// Each sample is of one light, chosen by what it may contribute to the surface.
    Tree(LightTree),
    /// Every light has samples of its own; those whose entry is `false` have none.
    All(Vec<bool>),
}

/// Most lights that all have shadow rays of their own where no selection is asked for.
const FEW: usize = 8;

/// What `asked` comes to where so many lights are sampled.
pub(super) fn selection_for(asked: LightSelection, lights: usize) -> LightSelection {
    match asked {
        LightSelection::Auto if lights <= FEW => LightSelection::All,
        LightSelection::Auto => LightSelection::Tree,
        LightSelection::Uniform
        | LightSelection::Power
        | LightSelection::Tree
        | LightSelection::All => asked,
    }
}

impl Selection {
    /// The selection for lights of these weights, which are finite and not negative; a light of
    /// weight 0 is never sampled. `None` when no weight is positive. A single light is chosen,
    /// however lights are selected.
    pub fn new(weights: &[f64], selection: LightSelection) -> Option<Self> {
        if selection != LightSelection::All || weights.len() == 1 {
            return AliasTable::new(weights).map(Self::One);
        }
        let sampled: Vec<bool> = weights.iter().map(|&w| w > 0.0).collect();
        sampled.contains(&true).then_some(Self::All(sampled))
    }

    /// Probability with which a sample is one of light `index`: with a tree averaged over
    /// surfaces, 1 where every light has its own.
    pub fn probability(&self, index: usize) -> f64 {
        match self {
            Self::One(table) => table.probability[index],
            Self::Tree(tree) => tree.mean_probability(index),
            Self::All(sampled) => f64::from(u8::from(sampled[index])),
        }
    }

    /// The table by which one light is chosen, where there is one.
    pub fn table(&self) -> Option<&AliasTable> {
        match self {
            Self::One(table) => Some(table),
            Self::Tree(_) | Self::All(_) => None,
        }
    }

    /// The tree by which one light is chosen, where there is one.
    pub fn tree(&self) -> Option<&LightTree> {
        match self {
            Self::Tree(tree) => Some(tree),
            Self::One(_) | Self::All(_) => None,
        }
    }
}
