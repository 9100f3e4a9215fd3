//! Where Newton's method in floats starts: the model at every 8 degrees, in a variable in which it is smooth.
//!
//! For α → 0 the model is P = k α + 4 c1 α², so that with s = √(k² + 16 c1 P) − k the bend is s / (8 c1): s is to the bend
//! what √P is to it for k = 0, for every k. Between nodes α is interpolated linearly in s, and no end is special.

/// Intervals: 170 / 8, rounded up.
const INTERVALS: usize = 22;
/// Degrees from node to node.
const SPACING_DEG: f64 = 8.0;

/// s at every 8 degrees and at 170.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<Float>([Float; INTERVALS + 1]);

macro_rules! nodes {
    ($float:ty) => {
        impl Nodes<$float> {
            /// From s as a function of the bend in degrees.
            pub fn new(s_of: impl Fn(f64) -> f64) -> Self {
                let mut nodes = [0.0; INTERVALS + 1];
                for (index, node) in nodes.iter_mut().enumerate() {
                    *node = s_of((index as f64 * SPACING_DEG).min(super::BEND_LIMIT_DEG)) as $float;
                }
                Self(nodes)
            }

            /// The bend in degrees at s, to about a hundredth of itself.
            pub fn start_deg(&self, s: $float) -> $float {
                // The node below: the last one cannot be it.
                let below = self.0.partition_point(|&node| node <= s).clamp(1, INTERVALS) - 1;
                let (Some(&low), Some(&high)) = (self.0.get(below), self.0.get(below + 1)) else { return 0.0 };
                // The last interval ends after 2 degrees.
                let width = if below + 1 == INTERVALS { 2.0 } else { SPACING_DEG as $float };
                below as $float * SPACING_DEG as $float + width * (s - low) / (high - low)
            }
        }
    };
}

nodes!(f32);
nodes!(f64);
