//! What the workgroups of a dispatch do.

use super::progress::Class;
use crate::gpu::layout::{RowTask, TILE_PIXELS};
use crate::lattice;
use std::ops::Range;

/// Workgroups of one dispatch at most (WebGPU's default limit).
const MAX_WORKGROUPS: usize = 65_535;

/// What a workgroup does, and how much that is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Task {
    pub task: RowTask,
    /// Samples per pixel.
    pub samples: u32,
}

/// The tasks that bring the pixels of each class to a position in their open block, `classes` and
/// `positions`; `rows` are a region's rows of each class, and `first_sample` is the index of the
/// first sample of all.
///
/// A driver in software hands each of its threads a contiguous part of a dispatch: if that were a
/// contiguous part of the image or a few classes, some threads would have the dear ones, and the
/// others would wait for them. Hardware hands them out one by one: those that last longest are first
/// there, so that none is left alone at the end.
pub(super) fn tasks(
    rows: &[Range<u32>],
    (classes, positions): (&[Class], &[u32]),
    first_sample: u64,
    software: bool,
) -> Vec<Task> {
    let classes = rows.iter().zip(classes).zip(positions);
    let sorted = classes.flat_map(|((rows, class), &target_position)| {
        let block_start = first_sample + class.merged;
        let samples = target_position - class.position;
        let rows = if samples > 0 { rows.clone() } else { 0..0 };
        rows.map(move |row| Task {
            task: RowTask {
                block_start: [block_start as u32, (block_start >> 32) as u32],
                row,
                target_position,
            },
            samples,
        })
    });
    let mut sorted: Vec<_> = sorted.collect();
    if software {
        let count = sorted.len();
        let stride = lattice::coprime(count as u32) as usize;
        (0..count).map(|i| sorted[i * stride % count]).collect()
    } else {
        sorted.sort_by_key(|task| std::cmp::Reverse(task.samples));
        sorted
    }
}

/// Samples of all pixels.
pub(super) fn pixel_samples(tasks: &[Task]) -> u64 {
    let samples = tasks.iter().map(|task| u64::from(task.samples));
    samples.sum::<u64>() * u64::from(TILE_PIXELS)
}

/// How many of `tasks`, the first ones, are one dispatch of about `budget` pixel-samples: fewer
/// where those that follow would be left with less than this one.
pub(super) fn of_one_dispatch(tasks: &[Task], budget: u64) -> usize {
    let total = pixel_samples(tasks);
    let dispatches = total.div_ceil(budget).max(1);
    let wanted = total / dispatches;
    let mut before = 0;
    let first = tasks.iter().take_while(|task| {
        let is_first = before == 0;
        before += u64::from(task.samples * TILE_PIXELS);
        is_first || before <= wanted
    });
    first.count().min(MAX_WORKGROUPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class(merged: u64, position: u32) -> Class {
        Class { merged, position }
    }

    /// Classes with few and many rows and samples; one has what it should.
    fn example(software: bool) -> Vec<Task> {
        let rows = [0..2000, 2000..2900, 2900..2900, 2900..3600, 3600..4096];
        let classes = [
            class(0, 0),
            class(0, 1),
            class(0, 8),
            class(256, 40),
            class(1 << 33, 128),
        ];
        tasks(&rows, (&classes, &[2, 4, 9, 40, 256]), 7, software)
    }

    #[test]
    fn every_row_that_is_behind_is_taken_once() {
        for software in [false, true] {
            let mut rows: Vec<_> = example(software).iter().map(|t| t.task.row).collect();
            rows.sort_unstable();
            let behind = (0..2900).chain(3600..4096);
            assert_eq!(rows, Vec::from_iter(behind), "{software}");
        }
        let nothing_to_do = [class(0, 5), class(256, 0)];
        assert!(tasks(&[0..3, 3..4], (&nothing_to_do, &[5, 0]), 0, true).is_empty());
    }

    #[test]
    fn rows_go_on_from_where_their_class_stands() {
        let last = example(false)[0];
        assert_eq!(last.samples, 128);
        assert_eq!(last.task.target_position, 256);
        assert_eq!(last.task.block_start, [7, 2]);
    }

    /// Each of two threads gets about as many samples, and as many of every eighth of the image,
    /// whichever tasks a dispatch has.
    #[test]
    fn halves_of_a_dispatch_are_alike() {
        const HALF: usize = 200;
        let tasks = example(true);
        for first in (0..tasks.len() - 2 * HALF).step_by(HALF) {
            let halves = [&tasks[first..][..HALF], &tasks[first + HALF..][..HALF]];
            let [a, b] = halves.map(|half| pixel_samples(half) as f64);
            assert!((a / b).ln().abs() < 0.15, "from {first}: {a} and {b}");
            let eighths = halves.map(|half| {
                let mut count = [0_i32; 8];
                for task in half {
                    count[task.task.row as usize * 8 / 4096] += 1;
                }
                count
            });
            let alike = eighths[0].iter().zip(eighths[1]);
            let alike = alike.map(|(a, b)| (a - b).abs());
            assert!(alike.max() <= Some(4), "from {first}: {eighths:?}");
        }
    }

    #[test]
    fn dispatches_are_of_like_length() {
        let all = example(true);
        let total = pixel_samples(&all);
        let mut left = &all[..];
        let mut lengths = Vec::new();
        while !left.is_empty() {
            let count = of_one_dispatch(left, total * 2 / 5);
            lengths.push(pixel_samples(&left[..count]) as f64 / total as f64);
            left = &left[count..];
        }
        assert_eq!(lengths.len(), 3, "{lengths:?}");
        let alike = |length: &f64| (length - 1.0 / 3.0).abs() < 0.01;
        assert!(lengths.iter().all(alike), "{lengths:?}");
        assert_eq!(of_one_dispatch(&all, 1), 1, "one at the least");
    }
}
