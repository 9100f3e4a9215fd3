//! Many runs with random plants, programs and faults, and what the supervisor made of them.
//!
//! docs/campaign.md has the method, every definition and the tables.

pub(crate) mod command;
pub mod draw;
pub mod drive;
pub mod judge;
pub mod kind;
mod picture;
pub mod replay;
pub mod shard;
pub mod shows;
mod table;
pub mod tally;
pub mod vent;

pub use picture::picture;
pub use table::{csv, markdown, text};

use draw::{Case, Filter};
use drive::Core;
use indicatif::ProgressBar;
use judge::{Outcome, Property};
use rayon::prelude::*;
use shard::{Campaign, Shard};
use std::panic::{AssertUnwindSafe, catch_unwind};
use tally::Tally;

/// One run with its judgement; a panic is one too.
#[must_use]
pub fn run_one<C: Core>(case: &Case) -> Outcome {
    let judged = catch_unwind(AssertUnwindSafe(|| drive::drive::<C>(case, |_| {})));
    judged.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
        let how = text.unwrap_or("without a message").to_owned();
        Outcome { violations: vec![(Property::Panic, how)], ..Outcome::default() }
    })
}

/// All runs of a shard, on all cores. What is kept does not grow with their number.
#[must_use]
pub fn run_all<C: Core>(campaign: &Campaign, shard: Shard, bar: &ProgressBar) -> Tally {
    let filter = campaign.filter();
    let count = shard.runs(campaign.runs);
    (0..count)
        .into_par_iter()
        .fold(Tally::new, |mut tally, place| {
            let case = Case::draw(campaign.seed, shard.index(place), &filter);
            tally.count(&case, &run_one::<C>(&case));
            bar.inc(1);
            tally
        })
        .reduce(Tally::new, |mut one, other| {
            one.add(&other);
            one
        })
}

impl Campaign {
    /// What may be drawn.
    ///
    /// # Panics
    /// Never: names are checked where a campaign is made.
    #[must_use]
    pub fn filter(&self) -> Filter {
        Filter {
            fault: self.fault.as_deref().and_then(|name| kind::Kind::find(name).ok()),
            program: self.sequence.as_deref().and_then(|name| draw::Choice::find(name).ok()),
        }
    }
}

#[cfg(test)]
mod tests;
