//! The paper's equations in f64: as they are printed, and corrected. For readers; the controller uses none of them.
//!
//! The paper's text was not at hand. [`as_printed`] is **reconstructed** from three statements about the print: (2)
//! breaks incompressibility; (6) and (15) give dW/dλ = −2 C10 at λ = 1; (16) lacks a factor α. Transverse stretches
//! 1/λ, 1/λ beside λ are the simplest choice that gives the first two at once, and the third is taken literally. This
//! choice puts the zero of dW/dλ at 57.4 degrees; the zero reported for the print is near 56 degrees, and that
//! difference of about one degree is not explained here. [`corrected`] takes the uniaxial incompressible stretches.
//!
//! Not reproduced: that the corrected form gives 6 to 17 kPa with the geometry of one small cavity where the paper
//! applies 150 kPa. The cavity's wall and gas volume terms are not among the facts at hand.

/// dW/dλ of a Yeoh material, given I1 and dI1/dλ; in `MPa`.
fn yeoh_slope(i1: f64, i1_slope: f64) -> f64 {
    (crate::paper::C10_MPA + 2.0 * crate::paper::C20_MPA * (i1 - 3.0)) * i1_slope
}

/// The equations with the slips of the print, as reconstructed in the [module](self)'s text.
pub mod as_printed {
    /// (2): the three principal stretches.
    #[must_use]
    pub fn stretches(lambda: f64) -> [f64; 3] {
        [lambda, 1.0 / lambda, 1.0 / lambda]
    }

    /// (6), (15): dW/dλ in `MPa`.
    #[must_use]
    pub fn energy_slope(lambda: f64) -> f64 {
        super::yeoh_slope(lambda.powi(2) + 2.0 * lambda.powi(-2), 2.0 * lambda - 4.0 * lambda.powi(-3))
    }

    /// (16): dλ/dα, α in radians.
    #[must_use]
    pub fn stretch_slope(alpha: f64) -> f64 {
        (alpha.sin() - alpha.cos()) / alpha.sin().powi(2)
    }
}

/// The equations without the slips.
pub mod corrected {
    /// (2): the three principal stretches; their product is 1.
    #[must_use]
    pub fn stretches(lambda: f64) -> [f64; 3] {
        [lambda, lambda.sqrt().recip(), lambda.sqrt().recip()]
    }

    /// (6), (15): dW/dλ in `MPa`, with I1 = λ² + 2/λ.
    #[must_use]
    pub fn energy_slope(lambda: f64) -> f64 {
        super::yeoh_slope(lambda.powi(2) + 2.0 / lambda, 2.0 * lambda - 2.0 * lambda.powi(-2))
    }

    /// (13): λ = α / sin α, α in radians.
    #[must_use]
    pub fn stretch(alpha: f64) -> f64 {
        if alpha == 0.0 { 1.0 } else { alpha / alpha.sin() }
    }

    /// (16): dλ/dα, α in radians.
    #[must_use]
    pub fn stretch_slope(alpha: f64) -> f64 {
        (alpha.sin() - alpha * alpha.cos()) / alpha.sin().powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::C10_MPA;

    #[test]
    fn printed_stretches_change_the_volume() {
        for lambda in [1.1, 1.5, 2.0] {
            assert!((as_printed::stretches(lambda).iter().product::<f64>() - 1.0).abs() > 0.09, "{lambda}");
            assert!((corrected::stretches(lambda).iter().product::<f64>() - 1.0).abs() < 1e-12, "{lambda}");
        }
    }

    #[test]
    fn printed_energy_pushes_at_rest() {
        assert!((as_printed::energy_slope(1.0) + 2.0 * C10_MPA).abs() < 1e-12);
        assert!(corrected::energy_slope(1.0).abs() < 1e-12);
        let (mut low, mut high) = (1.0_f64, 90.0_f64);
        for _ in 0..50 {
            let middle = f64::midpoint(low, high);
            let below = as_printed::energy_slope(corrected::stretch(middle.to_radians())) < 0.0;
            if below { low = middle } else { high = middle }
        }
        println!("printed dW/dλ is zero at {low:.2} degrees");
        assert!((low - 57.41).abs() < 0.01, "{low}");
    }

    #[test]
    fn printed_stretch_slope_lacks_a_factor() {
        for alpha in [0.3_f64, 0.8, 1.3, 2.0] {
            let numeric = (corrected::stretch(alpha + 1e-5) - corrected::stretch(alpha - 1e-5)) / 2e-5;
            assert!((corrected::stretch_slope(alpha) - numeric).abs() < 1e-7, "{alpha}");
            assert!((as_printed::stretch_slope(alpha) - numeric).abs() > 0.05, "{alpha}");
        }
    }
}
