//! The soft finger on a desk: the controller's core against a simulated plant, with reports.
//!
//! The command line is `host-sim help`; as a library it runs and judges what a test asks for:
//!
//! ```
//! use host_sim::metrics::summarise;
//! use host_sim::simulate::{Program, Run};
//! use model_core::sequence::library;
//!
//! let reconfigure = library::find("reconfigure").expect("built in");
//! let trace = Run::new(Program::Sequence(reconfigure), 1).simulate(|_, _| ()).expect("the sequence is taken");
//! let summary = summarise(&trace);
//! assert!(summary.faults.is_empty());
//! let error_kpa = summary.segments[0].hold_mean_abs_error_kpa.expect("the proximal segment has been held");
//! assert!(error_kpa < 2.0, "{error_kpa}");
//! ```
//!
//! [`plant`] is the machine, [`simulate`] joins it to the core, [`trace`] is what happened, [`metrics`] what it was worth,
//! [`report`] shows it. The other modules are the command line's chores.

pub mod calibrate;
pub mod campaign;
pub mod cli;
pub mod compare;
mod drawing;
pub mod eval;
pub mod identify;
pub mod mechanics;
pub mod methods;
pub mod metrics;
pub mod monitor;
pub mod paper;
pub mod pareto;
pub mod plant;
pub mod progress;
pub mod report;
mod run;
pub mod simulate;
pub mod trace;
