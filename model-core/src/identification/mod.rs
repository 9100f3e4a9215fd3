//! Which k, c1 and c2 does each segment really have? Found on line from pressure and bend, offered, never taken silently.
//!
//! The model is linear in them: P = k·α + c1·A(α) + c2·B(α). A *point* is the mean of bend and pressure over a quarter of a
//! second, after the air and the setpoints have rested for half a second and the finger's lag is over, while one segment
//! alone is away from zero and the others have not been filled since all were vented: then the sensor's bend is that
//! segment's. Each point is a row of a weighted least-squares problem for how far the coefficients in use are off; its
//! weight is the inverse square of the slope dP/dα, so that residuals count in degrees, as in [`crate::calibration`].
//!
//! - Forgetting acts once for each new hold, and a hold gives at most `POINTS_A_HOLD` points: holding still for an hour
//!   wipes nothing out. It ends at a prior ([`least_squares`](self)), so nothing winds up.
//! - A point further off than the fit's own scatter explains is an outlier and left out, unless a third in a row says the
//!   same.
//! - The solution is the best within the admitted range (k 0..60, c1 5..40, c2 0..2 kPa).
//! - It is offered when the points cover `BANDS` bands of 8 degrees and fit.
//!
//! One row costs some 900 instructions and its solution up to 1,500: they are spread over ticks, at most about 200 in each.

mod least_squares;

use crate::actuation::PerSegment;
use crate::inverse::{pressure_from_bend, regressors};
use crate::units::{Bend, Coefficients, Pressure};
use fixed::types::I8F24;
use least_squares::{LeastSquares, Row, UNKNOWNS};

/// Ticks for which everything must have rested before a point: six times the finger's lag.
const REST_TICKS: u16 = 500;
/// Ticks of a point, a power of two.
const POINT_SHIFT: u32 = 8;
/// Ticks for which all setpoints must have been zero until every chamber counts as empty.
const EMPTY_TICKS: u16 = 1500;
/// Points of one hold at the most.
const POINTS_A_HOLD: u8 = 4;
/// A bend that differs by more than this from the last point's is another hold.
const NEW_HOLD: Bend = Bend::from_deg(5);
/// The bends that teach: below, 0.3 kPa are worth 0.5 degree and more.
const LEAST_BEND: Bend = Bend::from_deg(15);
const MOST_BEND: Bend = Bend::from_deg(130);
/// Bands of 8 degrees that the points must cover.
const BANDS: u32 = 4;
/// Holds after which the bands covered before no longer count twice over.
const HOLDS_AN_EPOCH: u8 = 16;
/// Outliers in a row that are left out.
const MOST_OUTLIERS: u8 = 2;
/// The largest mean square of the residual with which a solution is offered: 2 degrees, squared, 2⁻¹⁶.
const MOST_SCATTER: u32 = 4 << 16;
/// An outlier is off by more than 3 degrees, squared, 2⁻¹⁶, and by more than 6 times the scatter.
const OUTLIER_SQUARE: u64 = 9 << 16;
const OUTLIER_TIMES: u64 = 36;

/// From an unknown in 2⁻¹⁶ to its coefficient in 2⁻²⁴ kPa: c1·8, c2·128, k·2.
const SCALES: [u32; UNKNOWNS] = [5, 1, 7];

/// What the points of one segment say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identified {
    /// The coefficients that fit best within the admitted range; the ones in use while nothing is known.
    pub coefficients: Coefficients,
    /// Root mean square of what is left, as pressure.
    pub residual_pressure: Pressure,
    /// The same as bend.
    pub residual_bend: Bend,
    /// Points taken since the coefficients in use were.
    pub points: u16,
    /// The points reach far enough and fit well enough: the coefficients can be adopted.
    pub ready: bool,
}

/// One segment's fit.
#[derive(Clone, Debug)]
struct Fit {
    squares: LeastSquares,
    /// How far the coefficients in use are off, scaled, 2⁻¹⁶.
    off: [i32; UNKNOWNS],
    offer: Identified,
    last_bend: Bend,
    points_in_hold: u8,
    outliers: u8,
    /// Bands of 8 degrees with points, in this epoch and the last.
    bands: [u32; 2],
    holds: u8,
}

impl Fit {
    const fn new(coefficients: Coefficients) -> Self {
        let offer = Identified {
            coefficients,
            residual_pressure: Pressure::ZERO,
            residual_bend: Bend::ZERO,
            points: 0,
            ready: false,
        };
        Self {
            squares: LeastSquares::new(),
            off: [0; UNKNOWNS],
            offer,
            last_bend: Bend::MIN,
            points_in_hold: 0,
            outliers: 0,
            bands: [0; 2],
            holds: 0,
        }
    }

    fn covered(&self) -> bool {
        let [now, before] = self.bands;
        (now | before).count_ones() >= BANDS
    }

    /// Whether a row is to be left out.
    fn is_outlier(&mut self, row: &Row) -> bool {
        let [scatter, _] = self.squares.mean_squares();
        let square = row.weighted_square(row.residual(&self.off));
        let limit = OUTLIER_SQUARE.max(u64::from(scatter) * OUTLIER_TIMES);
        let out = self.covered() && square > limit && self.outliers < MOST_OUTLIERS;
        self.outliers = if out { self.outliers.saturating_add(1) } else { 0 };
        out
    }

    /// Forgets when a hold is new.
    fn begin(&mut self, bend: Bend) {
        if (bend - self.last_bend).abs() > NEW_HOLD {
            (self.last_bend, self.points_in_hold) = (bend, 0);
            self.squares.forget();
            self.holds = self.holds.saturating_add(1);
            if self.holds >= HOLDS_AN_EPOCH {
                let [now, _] = self.bands;
                (self.holds, self.bands) = (0, [0, now]);
            }
        }
        self.points_in_hold = self.points_in_hold.saturating_add(1);
        let [now, _] = &mut self.bands;
        *now |= 1 << ((bend.to_bits() >> 19) & 31);
        self.offer.points = self.offer.points.saturating_add(1);
    }

    /// What is offered from now on.
    fn offer(&mut self, base: Coefficients, off: [i32; UNKNOWNS]) {
        self.off = off;
        let [c1, c2, k] = off;
        let moved = |from: I8F24, by: i32, scale: u32, [low, high]: [i32; 2]| {
            let bits = i64::from(from.to_bits()).saturating_add(i64::from(by) << scale);
            I8F24::from_bits(bits.min(i64::from(high)).max(i64::from(low)) as i32)
        };
        let [of_c1, of_c2, of_k] = SCALES;
        let [range_c1, range_c2, range_k] = Coefficients::RANGES;
        let found = Coefficients::new(
            moved(base.k(), k, of_k, range_k),
            moved(base.c1(), c1, of_c1, range_c1),
            moved(base.c2(), c2, of_c2, range_c2),
        );
        self.offer.coefficients = found.unwrap_or(base);
        let [scatter, pressure] = self.squares.mean_squares();
        // The root of 2⁻¹⁶ is in 2⁻⁸.
        let root = |square: u32| (square.isqrt() << 8) as i32;
        self.offer.residual_bend = Bend::from_bits(root(scatter));
        self.offer.residual_pressure = Pressure::from_bits(root(pressure));
        self.offer.ready = self.covered() && scatter <= MOST_SCATTER;
    }
}

/// What of a point is done in the next tick.
#[derive(Clone, Copy, Debug)]
enum Work {
    /// Nothing: a point is waited for.
    Idle,
    /// The row's regressors and its right-hand side.
    Regress,
    /// Its weight.
    Weigh(Row),
    /// Is it an outlier? Is its hold a new one?
    Judge(Row),
    /// One unknown's rotation.
    Rotate(Row, u8),
    /// The solution, after so many unknowns have been held at their bounds.
    Solve(LeastSquares, u8),
    /// One rotation of such a hold.
    Hold(LeastSquares, Row, u8, u8),
}

/// What one tick shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation {
    /// Each chamber's setpoint.
    pub setpoints: PerSegment<Pressure>,
    /// Each chamber's estimated pressure.
    pub estimates: PerSegment<Pressure>,
    /// The finger's bend; none while its sensor fails.
    pub bend: Option<Bend>,
    /// Neither pump nor dump valve has moved air for a while.
    pub air_rests: bool,
}

/// See the module's text.
#[derive(Clone, Debug)]
pub(crate) struct Identification {
    fits: PerSegment<Fit>,
    /// Which chambers have not been filled since all were empty.
    untouched: PerSegment<bool>,
    vented_ticks: u16,
    setpoints: PerSegment<Pressure>,
    rested_ticks: u16,
    /// Sums of the point in the making: 2⁻¹⁶ degree, 2⁻¹⁶ kPa.
    bends: i64,
    pressures: i64,
    /// The point that is worked on, and whose it is.
    bend: Bend,
    pressure: Pressure,
    segment: u8,
    work: Work,
}

impl Identification {
    /// Nothing is known yet beyond the coefficients in use.
    pub(crate) const fn new(coefficients: PerSegment<Coefficients>) -> Self {
        let [proximal, middle, distal] = coefficients;
        Self {
            fits: [Fit::new(proximal), Fit::new(middle), Fit::new(distal)],
            untouched: [false; 3],
            vented_ticks: 0,
            setpoints: [Pressure::ZERO; 3],
            rested_ticks: 0,
            bends: 0,
            pressures: 0,
            bend: Bend::ZERO,
            pressure: Pressure::ZERO,
            segment: 0,
            work: Work::Idle,
        }
    }

    /// What the points of each segment say.
    pub(crate) fn identified(&self) -> PerSegment<Identified> {
        let [proximal, middle, distal] = &self.fits;
        [proximal.offer, middle.offer, distal.offer]
    }

    /// Starts over with one segment, whose coefficients in use are these now.
    pub(crate) fn restart(&mut self, segment: usize, coefficients: Coefficients) {
        if let Some(fit) = self.fits.get_mut(segment) {
            *fit = Fit::new(coefficients);
        }
        self.work = Work::Idle;
    }

    /// Looks at a tick. Some 60 instructions.
    pub(crate) fn observe(&mut self, seen: &Observation) {
        let alone = self.alone(&seen.setpoints);
        let same = seen.setpoints == self.setpoints;
        self.setpoints = seen.setpoints;
        let (Some(segment), Some(bend), true, true) = (alone, seen.bend, same, seen.air_rests) else {
            self.rested_ticks = 0;
            return;
        };
        self.rested_ticks = self.rested_ticks.saturating_add(1);
        if self.rested_ticks <= REST_TICKS {
            (self.bends, self.pressures) = (0, 0);
            return;
        }
        let pressure = seen.estimates.get(segment).copied().unwrap_or(Pressure::ZERO);
        self.bends = self.bends.saturating_add(i64::from(bend.to_bits()));
        self.pressures = self.pressures.saturating_add(i64::from(pressure.to_bits()));
        if self.rested_ticks < REST_TICKS + (1 << POINT_SHIFT) {
            return;
        }
        // The next point of this hold needs no further rest.
        self.rested_ticks = REST_TICKS;
        let mean = |sum: i64| (sum >> POINT_SHIFT) as i32;
        let (bend, pressure) = (Bend::from_bits(mean(self.bends)), Pressure::from_bits(mean(self.pressures)));
        (self.bends, self.pressures) = (0, 0);
        if matches!(self.work, Work::Idle) && (LEAST_BEND..=MOST_BEND).contains(&bend) {
            (self.bend, self.pressure) = (bend, pressure);
            (self.segment, self.work) = (segment as u8, Work::Regress);
        }
    }

    /// The segment that alone is away from zero, if the others are known to be empty.
    fn alone(&mut self, setpoints: &PerSegment<Pressure>) -> Option<usize> {
        if *setpoints == [Pressure::ZERO; 3] {
            self.vented_ticks = self.vented_ticks.saturating_add(1);
            if self.vented_ticks >= EMPTY_TICKS {
                self.untouched = [true; 3];
            }
            return None;
        }
        self.vented_ticks = 0;
        for (untouched, &setpoint) in self.untouched.iter_mut().zip(setpoints) {
            *untouched &= setpoint == Pressure::ZERO;
        }
        match self.untouched {
            [false, true, true] => Some(0),
            [true, false, true] => Some(1),
            [true, true, false] => Some(2),
            _ => None,
        }
    }

    /// One tick's share of the work on a point.
    pub(crate) fn work(&mut self, coefficients: &PerSegment<Coefficients>) {
        let segment = usize::from(self.segment);
        let (Some(fit), Some(&base)) = (self.fits.get_mut(segment), coefficients.get(segment)) else { return };
        self.work = match self.work {
            Work::Idle => return,
            Work::Regress => {
                if fit.points_in_hold >= POINTS_A_HOLD && (self.bend - fit.last_bend).abs() <= NEW_HOLD {
                    Work::Idle
                } else {
                    let missing = self.pressure - pressure_from_bend(&base, self.bend);
                    Work::Weigh(Row::new(regressors(self.bend), missing.to_bits(), 0))
                }
            }
            Work::Weigh(row) => {
                let at = |by: i16| pressure_from_bend(&base, self.bend + Bend::from_deg(by));
                Work::Judge(Row::new(row.x, row.y, weight(at(1) - at(-1))))
            }
            Work::Judge(row) if fit.is_outlier(&row) => Work::Idle,
            Work::Judge(row) => {
                fit.begin(self.bend);
                Work::Rotate(row, 0)
            }
            Work::Rotate(mut row, unknown) => {
                fit.squares.rotate(&mut row, usize::from(unknown));
                if usize::from(unknown) + 1 < UNKNOWNS {
                    Work::Rotate(row, unknown + 1)
                } else {
                    fit.squares.count(&row);
                    Work::Solve(fit.squares, 0)
                }
            }
            Work::Solve(squares, held) => match squares.solve(&bounds(base)) {
                (_, Some((unknown, value))) if usize::from(held) < UNKNOWNS => {
                    // With the first one held, the second may be free again.
                    let mut squares = if unknown == 0 { fit.squares } else { squares };
                    match squares.hold(unknown, value) {
                        Some(row) => Work::Hold(squares, row, unknown as u8 + 1, held + 1),
                        None => Work::Idle,
                    }
                }
                (off, _) => {
                    fit.offer(base, off);
                    Work::Idle
                }
            },
            Work::Hold(mut squares, mut row, unknown, held) => {
                squares.rotate(&mut row, usize::from(unknown));
                if usize::from(unknown) + 1 < UNKNOWNS {
                    Work::Hold(squares, row, unknown + 1, held)
                } else {
                    Work::Solve(squares, held)
                }
            }
        };
    }
}

/// The inverse square of a slope (2⁻²⁴ square degrees per square kPa) from the pressure of two degrees; the slope counts
/// as 0.5 kPa per degree at least.
fn weight(two_degrees: Pressure) -> u32 {
    let slope = (two_degrees.to_bits() >> 10).clamp(1 << 6, 0xFFFF) as u32;
    // 4 / slope², the slope in 2⁻⁶.
    ((1_u32 << 31).checked_div(slope.saturating_mul(slope)).unwrap_or(0)) << 7
}

/// How far each unknown may be off, so that its coefficient stays in the admitted range.
fn bounds(base: Coefficients) -> [[i32; 2]; UNKNOWNS] {
    let [c1, c2, k] = [base.c1(), base.c2(), base.k()].map(I8F24::to_bits);
    let [of_c1, of_c2, of_k] = SCALES;
    let [range_c1, range_c2, range_k] = Coefficients::RANGES;
    [(c1, of_c1, range_c1), (c2, of_c2, range_c2), (k, of_k, range_k)]
        .map(|(from, scale, range)| range.map(|end| end.saturating_sub(from) >> scale))
}

#[cfg(test)]
mod tests;
