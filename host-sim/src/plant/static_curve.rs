//! The finger's static curve P(alpha) as a table: what the plant solves every tick, without a sine in it.
//!
//! P(alpha) and not alpha(P) is tabulated, because it is smooth: alpha(P) has infinite slope at P = 0 when k = 0, and for
//! k > 0 a scale of its own there. The plant solves for alpha anyway, together with the chamber's volume.
//!
//! In each of 256 cells of equal width a polynomial of degree five takes pressure and slope from
//! [`crate::mechanics`] at both ends and in the middle. Over the finger's working range (150 kPa) it stays within 1e-9 kPa of
//! the function it stands for, and up to its end every pressure is crossed within 1e-7 degrees of the right bend
//! (`the_table_is_as_good_as_the_function`). Beyond the last cell the function itself answers.

use crate::mechanics::{angle_from_pressure_rad, pressure_and_slope};

/// Cells of the table. 256 of six coefficients are 12 KiB: they stay in a first-level cache.
const CELLS: usize = 256;

/// Pressure at the table's end, kPa: above the stall pressure of any pump for such a finger.
const END_KPA: f64 = 500.0;

/// From here on the numbers of f64 are whole: adding rounds, and leaves the cell in the low bits. A conversion with `as`
/// takes several times as long, because it saturates.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// Pressure (kPa) over bend (rad) of one segment.
#[derive(Clone, Debug)]
pub struct StaticCurve {
    coefficients_kpa: [f64; 3],
    /// Polynomials in the share of the cell, -1..1 from its start to its end, the constant first.
    cells: Box<[[f64; 6]; CELLS]>,
    width_rad: f64,
    cells_per_rad: f64,
}

impl StaticCurve {
    /// Tabulates the model for k, c1, c2 in kPa.
    #[must_use]
    pub fn new(coefficients_kpa: [f64; 3]) -> Self {
        let end_rad = angle_from_pressure_rad(&coefficients_kpa, END_KPA);
        let width_rad = end_rad / CELLS as f64;
        let half = 0.5 * width_rad;
        let at = |place: f64| {
            let (pressure, slope) = pressure_and_slope(&coefficients_kpa, place * width_rad);
            (pressure, slope * half)
        };
        let cells = Box::new(core::array::from_fn(|cell| {
            let cell = cell as f64;
            let ((p0, s0), (p1, s1), (p2, s2)) = (at(cell), at(cell + 0.5), at(cell + 1.0));
            // Even and odd part of p(t) about the middle: both ends give two conditions for two unknowns each.
            let (even, even_slope) = (0.5 * (p2 + p0) - p1, 0.5 * (s2 - s0));
            let (odd, odd_slope) = (0.5 * (p2 - p0) - s1, 0.5 * (s2 + s0) - s1);
            let c4 = 0.5 * even_slope - even;
            let c5 = 0.5 * (odd_slope - 3.0 * odd);
            [p1, s1, even - c4, odd - c5, c4, c5]
        }));
        Self { coefficients_kpa, cells, width_rad, cells_per_rad: 1.0 / width_rad }
    }

    /// The model's coefficients k, c1, c2, kPa.
    #[must_use]
    pub fn coefficients_kpa(&self) -> &[f64; 3] {
        &self.coefficients_kpa
    }

    /// Pressure (kPa) and its slope (kPa/rad) at a bend of 0 to 2 pi rad; infinite from pi on.
    #[must_use]
    pub fn pressure_and_slope(&self, alpha_rad: f64) -> (f64, f64) {
        let (pressure, slope, _) = self.pressure_and_slopes(alpha_rad);
        (pressure, slope)
    }

    /// The same from the table alone, without a branch: beyond its end the last cell's polynomial goes on, and its values mean
    /// nothing.
    #[inline]
    pub(super) fn pressure_and_slope_within(&self, alpha_rad: f64) -> (f64, f64) {
        let place = alpha_rad * self.cells_per_rad - 0.5;
        let shifted = place + WHOLE;
        let index = (shifted.to_bits() as u32 as usize).min(CELLS - 1);
        let [c0, c1, c2, c3, c4, c5] = self.cells[index];
        let t = 2.0 * (place - (shifted - WHOLE));
        let t2 = t * t;
        let pressure = (c0 + c1 * t) + t2 * ((c2 + c3 * t) + t2 * (c4 + c5 * t));
        let slope = (c1 + 2.0 * c2 * t) + t2 * ((3.0 * c3 + 4.0 * c4 * t) + t2 * (5.0 * c5));
        (pressure, slope * (2.0 * self.cells_per_rad))
    }

    /// The same with the second derivative, kPa/rad^2; beyond the table that is taken as zero.
    #[inline]
    pub(super) fn pressure_and_slopes(&self, alpha_rad: f64) -> (f64, f64, f64) {
        let place = alpha_rad * self.cells_per_rad - 0.5;
        let shifted = place + WHOLE;
        let index = shifted.to_bits() as u32 as usize;
        let Some([c0, c1, c2, c3, c4, c5]) = self.cells.get(index) else {
            let (pressure, slope) = pressure_and_slope(&self.coefficients_kpa, alpha_rad);
            return (pressure, slope, 0.0);
        };
        let t = 2.0 * (place - (shifted - WHOLE));
        let t2 = t * t;
        let per_rad = 2.0 * self.cells_per_rad;
        // Pairs of powers: half as long a chain of products that wait for each other as Horner's.
        let pressure = (c0 + c1 * t) + t2 * ((c2 + c3 * t) + t2 * (c4 + c5 * t));
        let slope = (c1 + 2.0 * c2 * t) + t2 * ((3.0 * c3 + 4.0 * c4 * t) + t2 * (5.0 * c5));
        let bend = (2.0 * c2 + 6.0 * c3 * t) + t2 * (12.0 * c4 + 20.0 * c5 * t);
        (pressure, slope * per_rad, bend * per_rad * per_rad)
    }

    /// Bend at the table's end, rad.
    #[must_use]
    pub fn end_rad(&self) -> f64 {
        self.width_rad * CELLS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_as_good_as_the_function() {
        // The finger, the bare chamber, and the corners of what the controller admits.
        let sets = [[0.0, 13.84, 0.336], [35.3, 7.24, 0.831], [0.0, 5.0, 0.0], [60.0, 40.0, 2.0], [1e-3, 5.0, 2.0]];
        for coefficients in sets {
            let curve = StaticCurve::new(coefficients);
            let (mut worst_kpa, mut worst_deg) = (0.0_f64, 0.0_f64);
            // 37 is no divisor of the cells' number: the points fall everywhere within them.
            for step in 1..CELLS * 37 {
                let alpha = curve.end_rad() * (step as f64 + 0.123) / (CELLS * 37) as f64;
                let (pressure, slope) = curve.pressure_and_slope(alpha);
                let (exact, exact_slope) = pressure_and_slope(&coefficients, alpha);
                let error = (pressure - exact).abs();
                assert!(exact > 150.0 || error < 1e-9, "{coefficients:?} at {alpha}: {error:e} kPa");
                assert!((slope / exact_slope - 1.0).abs() < 1e-6, "{coefficients:?} at {alpha}: {slope} {exact_slope}");
                worst_kpa = worst_kpa.max(error);
                worst_deg = worst_deg.max((error / exact_slope).to_degrees());
            }
            println!("{coefficients:?}: {worst_kpa:.1e} kPa, {worst_deg:.1e} degrees");
            assert!(worst_deg < 1e-7, "{coefficients:?}: {worst_deg:e} degrees");
        }
    }

    #[test]
    fn beyond_the_table_the_function_answers() {
        let curve = StaticCurve::new([0.0, 13.84, 0.336]);
        for alpha in [curve.end_rad() + 1e-9, 2.6, 3.1] {
            assert_eq!(curve.pressure_and_slope(alpha), pressure_and_slope(&[0.0, 13.84, 0.336], alpha));
        }
        assert!(curve.pressure_and_slope(4.0).0.is_infinite());
    }

    #[test]
    fn it_never_falls() {
        let curve = StaticCurve::new([0.0, 13.84, 0.336]);
        let mut last = -1e-300;
        for step in 0..20_000 {
            let (pressure, slope) = curve.pressure_and_slope(curve.end_rad() * f64::from(step) / 20_000.0);
            assert!(pressure >= last && slope >= 0.0, "{step}: {pressure} after {last}, slope {slope}");
            last = pressure - 1e-12;
        }
    }
}
