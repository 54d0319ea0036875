//! What is done with direkt's renders: estimators compared at equal time, the GPU held against the
//! reference, what a scene calls for and what that costs, the experiments of a lecture; and the
//! plots and reports of all these.
//!
//! It needs neither a window nor a command line.

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod compare;
pub mod cost;
pub mod drawing;
pub mod explain;
pub mod lab;
pub mod report;
