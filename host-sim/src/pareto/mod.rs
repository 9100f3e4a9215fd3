//! Speed against error: each choice with what it costs and what it gives.

pub mod inverse;
pub mod plant;
