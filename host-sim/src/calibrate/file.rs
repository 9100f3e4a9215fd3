//! `calibration.toml`: coefficients on their way from a fit to a device.
//!
//! ```toml
//! schema = 1
//! source = "bench.csv"            # what they were fitted to
//!
//! [proximal]                      # or [middle], [distal]; [all] alone stands for all three
//! k_kpa = 0.0                     # 0..=60
//! c1_kpa = 13.8355                # 5..=40
//! c2_kpa = 0.33561                # 0..=2
//! k_ci95_kpa = [0.0, 1.3]         # 95 % confidence intervals; these and what follows may be left out
//! c1_ci95_kpa = [13.5, 14.1]
//! c2_ci95_kpa = [0.32, 0.35]
//! points = 50
//! residual_deg = 0.31             # root mean square, degrees of one segment
//! ```
//!
//! Coefficients are those of P(α) = k·α + c1·A(α) + c2·B(α) (docs/model.md). A segment that the file does not name keeps
//! what the device has. An unknown key is an error: a misspelt one must not pass for one that was left out.

use anyhow::{Context, Result, anyhow, ensure};
use model_core::actuation::PerSegment;
use model_core::units::{CoefficientError, Coefficients};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// Version of the format: raised whenever a key changes its name or meaning.
pub const SCHEMA: u32 = 1;

/// What every file begins with.
const HEAD: &str = "\
# Coefficients of P(alpha) = k*alpha + c1*A(alpha) + c2*B(alpha), P in kPa, for the soft finger's controller.
# Into a device: host-sim monitor --port auto --calibration FILE. Explained in docs/calibration.md.
";

/// One fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Bending stiffness, kPa per radian.
    pub k_kpa: f64,
    /// First Yeoh term, kPa.
    pub c1_kpa: f64,
    /// Second Yeoh term, kPa.
    pub c2_kpa: f64,
    /// 95 % confidence interval of k, kPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k_ci95_kpa: Option<[f64; 2]>,
    /// 95 % confidence interval of c1, kPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub c1_ci95_kpa: Option<[f64; 2]>,
    /// 95 % confidence interval of c2, kPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub c2_ci95_kpa: Option<[f64; 2]>,
    /// Points that were fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
    /// Root mean square of the points' distance from the curve, degrees of one segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_deg: Option<f64>,
}

impl Entry {
    /// Coefficients alone, k, c1 and c2 in kPa.
    #[must_use]
    pub const fn new([k_kpa, c1_kpa, c2_kpa]: [f64; 3]) -> Self {
        Self {
            k_kpa,
            c1_kpa,
            c2_kpa,
            k_ci95_kpa: None,
            c1_ci95_kpa: None,
            c2_ci95_kpa: None,
            points: None,
            residual_deg: None,
        }
    }

    /// As the device takes them, each rounded to 2^-24 kPa.
    ///
    /// # Errors
    /// Names the first coefficient outside its range, its value and the range.
    pub fn coefficients(&self) -> Result<Coefficients, String> {
        admitted([self.k_kpa, self.c1_kpa, self.c2_kpa])
    }
}

/// A whole file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the format, [`SCHEMA`].
    pub schema: u32,
    /// Name of the file that was fitted; empty when nobody knows.
    #[serde(default)]
    pub source: String,
    /// For all three segments; then there is no other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub all: Option<Entry>,
    /// For the proximal segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proximal: Option<Entry>,
    /// For the middle segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub middle: Option<Entry>,
    /// For the distal segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distal: Option<Entry>,
}

impl Calibration {
    /// One without any coefficients.
    #[must_use]
    pub fn new(source: &str) -> Self {
        Self { schema: SCHEMA, source: source.to_owned(), all: None, proximal: None, middle: None, distal: None }
    }

    /// What each segment is to have; nothing where it keeps what the device has.
    ///
    /// # Errors
    /// When a coefficient is outside what the device takes, there is none at all, or `[all]` is not alone.
    pub fn segments(&self) -> Result<PerSegment<Option<Coefficients>>> {
        ensure!(self.schema >= 1, "schema is 0: the first is 1");
        ensure!(
            self.schema <= SCHEMA,
            "schema {} is newer than {SCHEMA}, the newest that this program reads",
            self.schema
        );
        let taken = |name: &str, entry: Option<Entry>| -> Result<Option<Coefficients>> {
            entry.map(|entry| entry.coefficients().map_err(|why| anyhow!("[{name}]: {why}"))).transpose()
        };
        let each = [taken("proximal", self.proximal)?, taken("middle", self.middle)?, taken("distal", self.distal)?];
        let any = each.iter().any(Option::is_some);
        match taken("all", self.all)? {
            Some(_) if any => Err(anyhow!("[all] stands beside a single segment: keep [all], or one for each segment")),
            None if !any => Err(anyhow!("it has no coefficients: [all], [proximal], [middle] or [distal] is needed")),
            Some(all) => Ok([Some(all); 3]),
            None => Ok(each),
        }
    }
}

/// k, c1, c2 in kPa as the device takes them.
///
/// # Errors
/// Names the first coefficient outside its range, its value and the range.
pub fn admitted([k, c1, c2]: [f64; 3]) -> Result<Coefficients, String> {
    Coefficients::from_f64_kpa(k, c1, c2).map_err(|error| match error {
        CoefficientError::K => format!("K = {k} is outside 0..=60 kPa: check the fit"),
        CoefficientError::C1 => format!("C1 = {c1} is outside 5..=40 kPa: check the fit"),
        CoefficientError::C2 => format!("C2 = {c2} is outside 0..=2 kPa: check the fit"),
    })
}

/// Reads a file's text. All its coefficients can be loaded: [`Calibration::segments`] gives them.
///
/// # Errors
/// One line: what is wrong, in which line or segment, and the limit.
pub fn parse(text: &str) -> Result<Calibration> {
    let calibration: Calibration = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        let message = error.message().lines().map(str::trim).collect::<Vec<_>>().join(" ");
        anyhow!("line {line}: {message}")
    })?;
    calibration.segments()?;
    Ok(calibration)
}

/// Reads a file.
///
/// # Errors
/// As [`parse`], with the file's name before it.
pub fn read(path: &Path) -> Result<Calibration> {
    let named = || format!("no calibration in {}", path.display());
    let text = fs::read_to_string(path).with_context(named)?;
    parse(&text).with_context(named)
}

/// The file's text.
///
/// # Errors
/// When [`read`] would not take it back.
pub fn write(calibration: &Calibration) -> Result<String> {
    calibration.segments()?;
    Ok(format!("{HEAD}{}", toml::to_string(calibration)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Calibration {
        let proximal = Entry {
            k_ci95_kpa: Some([0.0, 1.25]),
            c1_ci95_kpa: Some([13.5, 14.125]),
            c2_ci95_kpa: Some([0.25, 0.375]),
            points: Some(50),
            residual_deg: Some(0.3),
            ..Entry::new([0.0, 13.835_501, 0.335_61])
        };
        Calibration {
            proximal: Some(proximal),
            distal: Some(Entry::new([35.3, 7.24, 0.831])),
            ..Calibration::new("a.csv")
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        let text = write(&full()).expect("written");
        assert_eq!(parse(&text).expect("read"), full(), "{text}");
        let [proximal, middle, distal] = full().segments().expect("admitted");
        assert_eq!(proximal, admitted([0.0, 13.835_501, 0.335_61]).ok());
        assert_eq!(middle, None);
        assert_eq!(distal, admitted([35.3, 7.24, 0.831]).ok());
        let all = Calibration { all: Some(Entry::new([0.0, 13.0, 0.5])), ..Calibration::new("") };
        assert_eq!(all.segments().expect("admitted"), [admitted([0.0, 13.0, 0.5]).ok(); 3]);
    }

    #[test]
    fn the_formats_own_example_is_one() {
        let example: String = include_str!("file.rs")
            .lines()
            .skip_while(|line| !line.contains("```toml"))
            .skip(1)
            .take_while(|line| !line.contains("```"))
            .map(|line| line.trim_start_matches("//!").to_owned() + "\n")
            .collect();
        let read = parse(&example).expect("read");
        assert_eq!(read.proximal.and_then(|entry| entry.points), Some(50));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place_and_limit() {
        let head = "schema = 1\n";
        let good = "k_kpa = 0\nc1_kpa = 13\nc2_kpa = 0.3\n";
        for (text, named) in [
            (String::new(), vec!["schema"]),
            (head.to_owned(), vec!["no coefficients", "[all]"]),
            (format!("schema = 9\n[all]\n{good}"), vec!["schema 9", "newer than 1"]),
            (format!("schema = 0\n[all]\n{good}"), vec!["schema is 0"]),
            (format!("{head}[all]\n{good}[distal]\n{good}"), vec!["[all]", "single segment"]),
            (format!("{head}[thumb]\n{good}"), vec!["line 2", "thumb"]),
            (format!("{head}[all]\n{good}k_kap = 3\n"), vec!["line 6", "k_kap"]),
            (format!("{head}[all]\nk_kpa = 0\nc1_kpa = 13\n"), vec!["line 2", "c2_kpa"]),
            (format!("{head}[all]\nk_kpa = 61\nc1_kpa = 13\nc2_kpa = 0.3\n"), vec!["[all]", "K = 61", "0..=60"]),
            (
                format!("{head}[middle]\nk_kpa = 0\nc1_kpa = nan\nc2_kpa = 0.3\n"),
                vec!["[middle]", "C1 = NaN", "5..=40"],
            ),
            (format!("{head}[distal]\nk_kpa = 0\nc1_kpa = 9\nc2_kpa = -0.1\n"), vec!["[distal]", "C2 = -0.1", "0..=2"]),
            (format!("{head}[all]\nk_kpa = zero\n"), vec!["line 3"]),
        ] {
            let error = format!("{:#}", parse(&text).expect_err(&text));
            assert!(named.iter().all(|part| error.contains(part)), "{text}: {error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        let error = format!("{:#}", read(Path::new("no-such.toml")).expect_err("is not there"));
        assert!(error.contains("no-such.toml"), "{error}");
    }

    #[test]
    fn what_cannot_be_loaded_is_not_written() {
        let outside = Calibration { all: Some(Entry::new([0.0, 4.0, 0.3])), ..Calibration::new("") };
        assert!(write(&outside).is_err());
    }
}
