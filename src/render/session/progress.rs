//! How far the pixels of a render have come.

use crate::gpu::layout::BLOCK_SAMPLES;
use crate::render::adaptive::{Allocation, CLASSES, FIRST};
use crate::render::scouts;
use std::sync::Arc;

/// Pixels that have the same number of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Class {
    /// Samples per pixel in merged blocks.
    pub merged: u64,
    /// Position in the open block that every pixel has reached.
    pub position: u32,
}

impl Class {
    /// Samples per pixel.
    pub(crate) fn samples(self) -> u64 {
        self.merged + u64::from(self.position)
    }

    /// The position in its open block that brings it to `target` samples per pixel, or nearer to
    /// it.
    pub(crate) fn position_towards(self, target: u64) -> u32 {
        let of_block = target.max(self.samples()) - self.merged;
        of_block.min(u64::from(BLOCK_SAMPLES)) as u32
    }

    /// Its block has been merged: the next one begins.
    pub(crate) fn open_block(&mut self) {
        (self.merged, self.position) = (self.samples(), 0);
    }

    /// Whether its block has to be merged before it goes on.
    pub(crate) fn is_full(self) -> bool {
        self.position == BLOCK_SAMPLES
    }
}

/// How far the pixels have come: all of them alike, or by the classes of an allocation.
#[derive(Debug, Clone)]
pub(super) struct Progress {
    pub classes: Vec<Class>,
    pub allocation: Option<Arc<Allocation>>,
    /// Shadow rays per camera ray, with light selection `all` per light; `None` until pixels have
    /// been asked.
    pub shadow_rays: Option<u32>,
    /// Index of the first sample before any are shared out.
    first: u64,
    /// The level of the allocation that the classes have or are brought to.
    level: u32,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            classes: vec![Class::default()],
            allocation: None,
            shadow_rays: None,
            first: 0,
            level: 0,
        }
    }
}

impl Progress {
    /// None yet, of an image with `shadow_rays`.
    pub(crate) fn with_shadow_rays(shadow_rays: Option<u32>) -> Self {
        Self {
            shadow_rays,
            ..Self::default()
        }
    }

    /// None yet, of scouts, which are a class of their own.
    pub(crate) fn of_scouts() -> Self {
        Self {
            classes: vec![Class::default(); 2],
            first: scouts::FIRST,
            ..Self::default()
        }
    }

    /// Samples per pixel of the best image there is, on average where they differ.
    pub(crate) fn samples(&self) -> u64 {
        match &self.allocation {
            None => self.classes[0].samples(),
            Some(allocation) if self.shows_pilot() => allocation.pilot(),
            Some(allocation) => allocation.mean(self.of_classes()),
        }
    }

    /// Samples per pixel of each class.
    fn of_classes(&self) -> impl Iterator<Item = u64> + Clone {
        self.classes.iter().map(|class| class.samples())
    }

    /// Positions of the classes in their open blocks.
    pub(crate) fn positions(&self) -> impl Iterator<Item = u32> {
        self.classes.iter().map(|class| class.position)
    }

    /// Every pixel has reached its class's position of `positions`.
    pub(crate) fn reach(&mut self, positions: &[u32]) {
        for (class, position) in self.classes.iter_mut().zip(positions) {
            class.position = *position;
        }
    }

    /// Whether the pilot's image is still the best there is.
    pub(crate) fn shows_pilot(&self) -> bool {
        let allocation = self.allocation.as_ref();
        allocation.is_some_and(|allocation| !allocation.replaces_pilot(self.of_classes()))
    }

    /// Index of the first sample: after the pilot, where there was one.
    pub(crate) fn first_sample(&self) -> u64 {
        self.allocation.as_ref().map_or(self.first, |_| FIRST)
    }

    /// Class of the pixel `index`.
    pub(crate) fn class_of(&self, index: usize) -> usize {
        let allocation = self.allocation.as_ref();
        allocation.map_or(0, |allocation| allocation.class(index))
    }

    /// From now on pixels take samples as `allocation` says, from the first on.
    pub(crate) fn share_out(&mut self, allocation: Allocation) {
        self.classes = vec![Class::default(); CLASSES];
        self.allocation = Some(Arc::new(allocation));
        self.level = 0;
    }

    /// Samples that the pixels of each class should have after `samples` more per pixel; at most to
    /// the end of the open block where all have the same.
    pub(crate) fn targets(&mut self, samples: u64) -> Vec<u64> {
        let Some(allocation) = &self.allocation else {
            let class = self.classes[0];
            let most = class.merged + u64::from(BLOCK_SAMPLES);
            return vec![(class.samples() + samples).min(most)];
        };
        let mean = allocation.mean(self.of_classes()) + samples;
        if allocation.is_even() {
            let classes = 0..self.classes.len();
            return classes
                .map(|class| if allocation.has(class) { mean } else { 0 })
                .collect();
        }
        self.level = allocation.level_of(mean, self.level);
        let targets = self.classes.iter().enumerate();
        let targets = targets.map(|(number, class)| {
            if allocation.has(number) {
                allocation.target(self.level, number)
            } else {
                class.samples()
            }
        });
        targets.collect()
    }
}
