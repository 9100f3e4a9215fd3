//! The air's way through the machine at one moment: manifold, three chambers, and what is open between them.

use super::pump::Delivery;
use super::valve::{Orifice, Quotients};

/// Air in the manifold and in each chamber, NL; or its change.
pub type Contents = [f64; 4];

/// Everything that decides the flows, but the contents.
#[derive(Clone, Copy, Debug)]
pub struct Network<'a> {
    /// Absolute pressure of the surroundings, kPa.
    pub atmosphere_kpa: f64,
    /// The pump.
    pub pump: Delivery,
    /// From the manifold to the surroundings.
    pub dump: Option<&'a Orifice>,
    /// From the manifold to each chamber.
    pub segments: [Option<&'a Orifice>; 3],
    /// From each chamber to the surroundings.
    pub leaks: [Option<&'a Orifice>; 3],
    /// Absolute pressure for each normal litre, in the manifold and in each chamber.
    pub kpa_per_nl: [f64; 4],
}

/// Flows at one moment, NL/s.
#[derive(Clone, Copy, Debug)]
pub struct Flows {
    /// From the pump into the manifold.
    pub pump: f64,
    /// From the manifold through the dump valve.
    pub dump: f64,
    /// From the manifold into each chamber.
    pub segments: [f64; 3],
    /// From each chamber through its leak.
    pub leaks: [f64; 3],
}

impl Flows {
    /// What they add to each content, NL/s.
    #[inline]
    #[must_use]
    pub fn rates(&self) -> Contents {
        let [a, b, c] = self.segments;
        let [x, y, z] = self.leaks;
        [self.pump - self.dump - (a + b + c), a - x, b - y, c - z]
    }
}

/// Slopes of the contents' rates over the contents, 1/s: air moves between manifold and chambers only, so all else is zero.
#[derive(Clone, Copy, Debug)]
pub struct Jacobian {
    /// The manifold's rate over its own content.
    pub manifold: f64,
    /// Each chamber's rate over its own content.
    pub chambers: [f64; 3],
    /// Each chamber's rate over the manifold's content.
    pub into_chambers: [f64; 3],
    /// The manifold's rate over each chamber's content.
    pub from_chambers: [f64; 3],
}

impl Jacobian {
    /// The rate at which the fastest volume settles by itself, 1/s.
    #[inline]
    #[must_use]
    pub fn fastest_per_s(&self) -> f64 {
        self.chambers.iter().fold(-self.manifold, |fastest, slope| fastest.max(-slope))
    }
}

impl Network<'_> {
    /// Absolute pressures, kPa.
    #[inline]
    #[must_use]
    pub fn absolute_kpa(&self, contents: &Contents) -> [f64; 4] {
        core::array::from_fn(|i| contents[i] * self.kpa_per_nl[i])
    }

    /// All flows.
    #[inline]
    #[must_use]
    pub fn flows(&self, contents: &Contents) -> Flows {
        let [manifold, chambers @ ..] = self.absolute_kpa(contents);
        let through = |way: Option<&Orifice>, from, to| way.map_or(0.0, |way| way.flow_nl_per_s(from, to));
        Flows {
            pump: self.pump.flow_and_slope(manifold - self.atmosphere_kpa).0,
            dump: through(self.dump, manifold, self.atmosphere_kpa),
            segments: core::array::from_fn(|i| through(self.segments[i], manifold, chambers[i])),
            leaks: core::array::from_fn(|i| through(self.leaks[i], chambers[i], self.atmosphere_kpa)),
        }
    }

    /// What the flows add to each content, NL/s.
    #[inline]
    #[must_use]
    pub fn rates(&self, contents: &Contents) -> Contents {
        self.flows(contents).rates()
    }

    /// The rates and their slopes.
    #[inline]
    #[must_use]
    pub fn rates_and_jacobian(&self, contents: &Contents) -> (Contents, Jacobian) {
        let [manifold, chambers @ ..] = self.absolute_kpa(contents);
        let [manifold_kpa_per_nl, chambers_kpa_per_nl @ ..] = self.kpa_per_nl;
        let (mut flow, mut slope) = self.pump.flow_and_slope(manifold - self.atmosphere_kpa);
        if let Some(dump) = self.dump {
            let (out, out_slope, _) = dump.flow_and_slopes(manifold, self.atmosphere_kpa);
            flow -= out;
            slope -= out_slope;
        }
        let mut rates = [0.0; 4];
        let mut jacobian =
            Jacobian { manifold: 0.0, chambers: [0.0; 3], into_chambers: [0.0; 3], from_chambers: [0.0; 3] };
        for i in 0..3 {
            if let Some(segment) = self.segments[i] {
                let (into, from_slope, to_slope) = segment.flow_and_slopes(manifold, chambers[i]);
                flow -= into;
                slope -= from_slope;
                rates[i + 1] = into;
                jacobian.into_chambers[i] = from_slope * manifold_kpa_per_nl;
                jacobian.chambers[i] = to_slope * chambers_kpa_per_nl[i];
                jacobian.from_chambers[i] = -to_slope * chambers_kpa_per_nl[i];
            }
            if let Some(leak) = self.leaks[i] {
                let (out, out_slope, _) = leak.flow_and_slopes(chambers[i], self.atmosphere_kpa);
                rates[i + 1] -= out;
                jacobian.chambers[i] -= out_slope * chambers_kpa_per_nl[i];
            }
        }
        rates[0] = flow;
        jacobian.manifold = slope * manifold_kpa_per_nl;
        (rates, jacobian)
    }

    /// What a step of the linearly implicit midpoint rule adds to each content, NL: `h (1 - h/2 J)^-1 f(y)`. None where a leak
    /// is open, which the arrow below leaves out, or where a volume settles so fast that the rule would swing.
    ///
    /// The matrix is [`Factored`]'s, and every slope is a quotient with its valve's own divisor: that cancels against
    /// the pivot's, so that a chamber costs one root and one division, one after the other.
    #[inline]
    #[must_use]
    pub fn midpoint_change(&self, contents: &Contents, seconds: f64) -> Option<Contents> {
        if self.leaks.iter().any(Option::is_some) {
            return None;
        }
        let [manifold, chambers @ ..] = self.absolute_kpa(contents);
        let [manifold_kpa_per_nl, chambers_kpa_per_nl @ ..] = self.kpa_per_nl;
        let weight_s = 0.5 * seconds;
        let manifold_weight = weight_s * manifold_kpa_per_nl;
        // A closed way is one without flow and slope.
        let closed = Quotients { divisor_kpa: 1.0, flow: 0.0, from_slope: 0.0, to_slope: 0.0 };
        let through = |way: Option<&Orifice>, from, to| way.map_or(closed, |way| way.quotients(from, to));
        let ways: [Quotients; 3] = core::array::from_fn(|i| through(self.segments[i], manifold, chambers[i]));
        let leaves: [f64; 3] = core::array::from_fn(|i| weight_s * ways[i].to_slope * chambers_kpa_per_nl[i]);
        let per_pivot: [f64; 3] = core::array::from_fn(|i| 1.0 / (ways[i].divisor_kpa + leaves[i]));
        // Flow into each chamber with the manifold as it is, and what a litre more in the manifold adds to it.
        let alone: [f64; 3] = core::array::from_fn(|i| ways[i].flow * per_pivot[i]);
        let follows: [f64; 3] = core::array::from_fn(|i| ways[i].from_slope * manifold_weight * per_pivot[i]);
        let (pump, pump_slope) = self.pump.flow_and_slope(manifold - self.atmosphere_kpa);
        let dump = through(self.dump, manifold, self.atmosphere_kpa);
        let per_dump = 1.0 / dump.divisor_kpa;
        let settles =
            manifold_weight * (dump.from_slope * per_dump - pump_slope) + ((follows[0] + follows[1]) + follows[2]);
        if settles > 1.0 || (0..3).any(|i| leaves[i] > ways[i].divisor_kpa) {
            return None;
        }
        let net = (pump - dump.flow * per_dump) - ((alone[0] + alone[1]) + alone[2]);
        let change = net / (1.0 + settles);
        let [a, b, c]: [f64; 3] = core::array::from_fn(|i| alone[i] + follows[i] * change);
        Some([change * seconds, a * seconds, b * seconds, c * seconds])
    }

    /// Whether nothing flows that could be measured: the pump rests, and no open way has more than 1e-9 kPa across it.
    #[inline]
    #[must_use]
    pub fn rests(&self, contents: &Contents) -> bool {
        const NOTHING_KPA: f64 = 1e-9;
        let [manifold, chambers @ ..] = self.absolute_kpa(contents);
        let still = |way: Option<&Orifice>, from: f64, to: f64| way.is_none() || (from - to).abs() <= NOTHING_KPA;
        self.pump.flow_and_slope(manifold - self.atmosphere_kpa).0 <= 0.0
            && still(self.dump, manifold, self.atmosphere_kpa)
            && (0..3).all(|i| {
                still(self.segments[i], manifold, chambers[i]) && still(self.leaks[i], chambers[i], self.atmosphere_kpa)
            })
    }
}

/// `(1 - weight J)`, factored.
#[derive(Clone, Copy, Debug)]
pub struct Factored {
    per_manifold: f64,
    per_chambers: [f64; 3],
    into_chambers: [f64; 3],
    from_chambers: [f64; 3],
}

impl Factored {
    /// Eliminates the chambers, then the manifold: the matrix is an arrow, nothing fills in. Its diagonal is at least 1 and
    /// its columns are dominated by it (air that leaves one volume arrives in one other), so no pivot can be small.
    #[inline]
    #[must_use]
    pub fn new(jacobian: &Jacobian, weight_s: f64) -> Self {
        let per_chambers = jacobian.chambers.map(|slope| 1.0 / (1.0 - weight_s * slope));
        let into_chambers: [f64; 3] = core::array::from_fn(|i| weight_s * jacobian.into_chambers[i] * per_chambers[i]);
        let from_chambers = jacobian.from_chambers.map(|slope| weight_s * slope);
        let [a, b, c]: [f64; 3] = core::array::from_fn(|i| from_chambers[i] * into_chambers[i]);
        let per_manifold = 1.0 / (1.0 - weight_s * jacobian.manifold - (a + b + c));
        Self { per_manifold, per_chambers, into_chambers, from_chambers }
    }

    /// Solves for a right-hand side.
    #[inline]
    #[must_use]
    pub fn solve(&self, right: &Contents) -> Contents {
        let [manifold, chambers @ ..] = *right;
        let alone: [f64; 3] = core::array::from_fn(|i| chambers[i] * self.per_chambers[i]);
        let [a, b, c]: [f64; 3] = core::array::from_fn(|i| self.from_chambers[i] * alone[i]);
        let manifold = (manifold + (a + b + c)) * self.per_manifold;
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| alone[i] + self.into_chambers[i] * manifold);
        [manifold, x, y, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::parameters::{OrificeParameters, PumpParameters};
    use crate::plant::pump::Pump;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn slopes_are_the_derivatives_and_the_arrow_is_solved(
            absolute_kpa in prop::array::uniform4(60.0..300.0_f64),
            right in prop::array::uniform4(-1.0..1.0_f64),
            weight_s in 1e-5..0.1_f64,
            open in prop::array::uniform7(prop::bool::ANY),
        ) {
            let orifice = Orifice::new(&OrificeParameters::default());
            let mut pump = Pump::new(&PumpParameters::default(), 0, 0.0);
            pump.step(true, None);
            let way = |index: usize| open[index].then_some(&orifice);
            let network = Network {
                atmosphere_kpa: 101.325,
                pump: pump.delivery(0.5),
                dump: way(0),
                segments: [way(1), way(2), way(3)],
                leaks: [way(4), way(5), way(6)],
                kpa_per_nl: [20_000.0, 14_000.0, 12_000.0, 11_000.0],
            };
            let contents: Contents = core::array::from_fn(|i| absolute_kpa[i] / network.kpa_per_nl[i]);
            let (rates, jacobian) = network.rates_and_jacobian(&contents);
            let plain = network.rates(&contents);
            for i in 0..4 {
                prop_assert!((rates[i] - plain[i]).abs() < 1e-15);
            }
            // The whole matrix, row by row.
            let mut matrix = [[0.0; 4]; 4];
            matrix[0][0] = jacobian.manifold;
            for i in 0..3 {
                matrix[0][i + 1] = jacobian.from_chambers[i];
                matrix[i + 1][0] = jacobian.into_chambers[i];
                matrix[i + 1][i + 1] = jacobian.chambers[i];
            }
            // A difference across an edge of the law is no derivative.
            let step = 1e-9;
            for column in 0..4 {
                let moved = |sign: f64| {
                    let mut contents = contents;
                    contents[column] += sign * step;
                    network.rates(&contents)
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                for row in 0..4 {
                    let (left, right) = ((up[row] - plain[row]) / step, (plain[row] - down[row]) / step);
                    prop_assume!((left - right).abs() < 1e-3 * (1.0 + left.abs()));
                    let slope = matrix[row][column];
                    prop_assert!((0.5 * (left + right) - slope).abs() < 1e-3 * (1.0 + slope.abs()), "{} {}", row, column);
                }
            }
            let solution = Factored::new(&jacobian, weight_s).solve(&right);
            if let Some(change) = network.midpoint_change(&contents, 1e-3) {
                // The same by the whole matrix, and what leaves one volume arrives in another.
                let expected = Factored::new(&jacobian, 5e-4).solve(&rates);
                for row in 0..4 {
                    prop_assert!((change[row] - 1e-3 * expected[row]).abs() < 1e-15, "{:?} {:?}", change, expected);
                }
            }
            for row in 0..4 {
                let product: f64 = (0..4).map(|column| matrix[row][column] * solution[column]).sum();
                prop_assert!((solution[row] - weight_s * product - right[row]).abs() < 1e-10);
            }
        }
    }
}
