//! The soft finger on a desk: the controller's core against a simulated plant, with reports.

pub mod campaign;
pub mod cli;
pub mod compare;
mod drawing;
pub mod eval;
pub mod identify;
pub mod mechanics;
pub mod methods;
pub mod metrics;
pub mod paper;
pub mod pareto;
pub mod plant;
pub mod progress;
pub mod report;
pub mod simulate;
pub mod trace;
