//! What the exhaustive run found, as one struct from which the table, the JSON and the page are made.

use super::tally::{BIN_ENDS_LSB, Tally};
use super::{LSB, Subject};
use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

const BEGIN: &str = "<!-- BEGIN exhaustive -->";
const END: &str = "<!-- END exhaustive -->";

/// A bin of the histogram of absolute errors.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Bin {
    /// Upper end in LSB of the result (2⁻¹⁶ degree or kPa); none for the last.
    pub up_to_lsb: Option<f64>,
    /// Results whose error is larger than the bin before admits, and not larger than this one's end.
    pub results: u64,
}

/// One function at one calibration. LSB is 2⁻¹⁶ of the unit.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Outcome {
    /// Such as `inverse::bend_from_pressure`.
    pub function: String,
    /// k, c1, c2.
    pub calibration_kpa: [f64; 3],
    /// kPa or deg.
    pub input_unit: String,
    /// deg or kPa.
    pub result_unit: String,
    /// Inputs visited.
    pub inputs: u64,
    /// Those of them in the domain, where the errors are taken.
    pub domain_inputs: u64,
    /// The largest absolute error in the domain.
    pub worst_error_lsb: f64,
    /// Where it is.
    pub worst_input_bits: i32,
    /// The largest absolute error for pressures of 0..150 kPa.
    pub worst_working_error_lsb: f64,
    /// Root of the mean squared error in the domain.
    pub rms_error_lsb: f64,
    /// Results in the domain by the size of their error.
    pub histogram: Vec<Bin>,
    /// Falls, panics, errors over the bound, wrong values outside the domain.
    pub failures: u64,
    /// The first few of them.
    pub first_failures: Vec<String>,
    /// Time it took.
    pub seconds: f64,
}

impl Outcome {
    /// From what was counted.
    #[must_use]
    pub fn new(subject: &Subject, tally: &Tally, seconds: f64) -> Self {
        let bins = BIN_ENDS_LSB.iter().zip(tally.histogram);
        Self {
            function: subject.name.to_owned(),
            calibration_kpa: subject.calibration_kpa,
            input_unit: subject.direction.input_unit().to_owned(),
            result_unit: subject.direction.result_unit().to_owned(),
            inputs: tally.inputs,
            domain_inputs: tally.domain_inputs,
            worst_error_lsb: tally.worst.error / LSB,
            worst_input_bits: tally.worst.input_bits,
            worst_working_error_lsb: tally.worst_working.error / LSB,
            rms_error_lsb: (tally.squares / tally.domain_inputs.max(1) as f64).sqrt() / LSB,
            histogram: bins.map(|(&end, results)| Bin { up_to_lsb: end.is_finite().then_some(end), results }).collect(),
            failures: tally.failures,
            first_failures: tally.described.clone(),
            seconds,
        }
    }

    /// One line for the error output, with the first few failures; empty when there are none.
    #[must_use]
    pub fn complaint(&self) -> String {
        if self.failures == 0 {
            return String::new();
        }
        let [k, c1, c2] = self.calibration_kpa;
        let first = self.first_failures.join("; ");
        format!("{} at (k, c1, c2) = ({k}, {c1}, {c2}) kPa: {} failures: {first}", self.function, self.failures)
    }
}

/// The results as two tables in Markdown: errors, and their distribution.
#[must_use]
pub fn markdown(outcomes: &[Outcome]) -> String {
    let mut text = String::from(
        "| Function | k, c1, c2 (kPa) | Inputs | Worst error, domain | at | Worst error, 0..150 kPa | rms, domain | Failures | Time, s |\n\
         |---|---|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for outcome in outcomes {
        let unit = &outcome.result_unit;
        text += &format!(
            "| `{}` | {} | {} | {:.3e} {unit} | {:.5} {} | {:.3e} {unit} | {:.2e} {unit} | {} | {:.0} |\n",
            outcome.function,
            outcome.calibration_kpa.map(|kpa| format!("{kpa:.4}")).join(", "),
            grouped(outcome.inputs),
            outcome.worst_error_lsb * LSB,
            f64::from(outcome.worst_input_bits) * LSB,
            outcome.input_unit,
            outcome.worst_working_error_lsb * LSB,
            outcome.rms_error_lsb * LSB,
            outcome.failures,
            outcome.seconds,
        );
    }
    text += "\nResults in the domain by the size of their error, in LSB (2⁻¹⁶ degree or kPa), all calibrations together:\n\n";
    let names: Vec<_> = outcomes.iter().map(|outcome| &outcome.function).fold(Vec::new(), |mut names, name| {
        if !names.contains(&name) {
            names.push(name);
        }
        names
    });
    text += &format!(
        "| Error up to | {} |\n|---|{}\n",
        names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" | "),
        "---:|".repeat(names.len())
    );
    for (index, end) in BIN_ENDS_LSB.iter().enumerate() {
        let counts = names.iter().map(|name| {
            let of_name = outcomes.iter().filter(|outcome| outcome.function == **name);
            grouped(of_name.map(|outcome| outcome.histogram[index].results).sum())
        });
        let end = if end.is_finite() { format!("{end}") } else { "more".to_owned() };
        text += &format!("| {end} | {} |\n", counts.collect::<Vec<_>>().join(" | "));
    }
    text
}

/// `page` with everything between the two markers replaced by the tables.
///
/// # Errors
/// When a marker is missing.
pub fn placed(page: &str, outcomes: &[Outcome]) -> Result<String> {
    let (before, rest) = page.split_once(BEGIN).with_context(|| format!("the page has no line {BEGIN}"))?;
    let (_, after) = rest.split_once(END).with_context(|| format!("the page has no line {END} after {BEGIN}"))?;
    ensure!(!after.contains(BEGIN), "the page has more than one line {BEGIN}");
    Ok(format!("{before}{BEGIN}\n\n{}\n{END}{after}", markdown(outcomes)))
}

/// With a comma between thousands.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.char_indices() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::run::visit_some;
    use super::super::subjects;
    use super::*;
    use model_core::calibration::DEFAULT;

    fn outcomes() -> Vec<Outcome> {
        subjects(&DEFAULT).iter().map(|subject| visit_some(subject, &[-1, 0, 1, 1 << 22])).collect()
    }

    #[test]
    fn tables_land_between_the_markers_and_nowhere_else() {
        let page = format!("before\n{BEGIN}\nold\n{END}\nafter\n");
        let new = placed(&page, &outcomes()).unwrap();
        assert!(new.starts_with(&format!("before\n{BEGIN}\n")) && new.ends_with(&format!("{END}\nafter\n")));
        assert!(!new.contains("old") && new.contains("`inverse::bend_from_pressure`"));
        assert_eq!(placed(&new, &outcomes()).unwrap().lines().count(), new.lines().count());
        assert!(placed("no markers", &outcomes()).is_err());
        assert!(placed(&format!("{END}{BEGIN}"), &outcomes()).is_err());
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!([0, 999, 1000, 4_294_967_296].map(grouped), ["0", "999", "1,000", "4,294,967,296"]);
    }

    #[test]
    fn the_histogram_counts_the_domain() {
        for outcome in outcomes() {
            assert_eq!((outcome.inputs, outcome.domain_inputs), (4, 3));
            assert_eq!(outcome.histogram.iter().map(|bin| bin.results).sum::<u64>(), 3);
            assert_eq!(outcome.complaint(), "");
        }
    }
}
