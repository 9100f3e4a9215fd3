//! Speed against error: each choice with what it costs and what it gives.

pub(crate) mod command;
pub mod inverse;
pub mod plant;
