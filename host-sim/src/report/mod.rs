//! What a run leaves on the disk: a table, pictures, a page, and the figures as JSON.

pub mod chart;
pub(crate) mod command;
pub mod csv;
pub mod finger;
pub mod html;
mod interactive;
pub mod plots;
pub mod record;
pub mod recording;

use crate::metrics::Summary;
use crate::plant::PlantParameters;
use crate::trace::Trace;
use anyhow::{Context, Result};
use record::Record;
use std::fs;
use std::path::{Path, PathBuf};

/// The most frames in the picture of the finger.
const FRAMES: usize = 6;

/// A folder that has been found writable.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes the folder and writes a file to it, so that a long run does not end in vain.
    ///
    /// # Errors
    /// Names the folder when it cannot be made or written to.
    pub fn prepare(path: &Path) -> Result<Self> {
        let probe = path.join(".writable");
        let named = || format!("cannot write to the folder {}: choose another with --out", path.display());
        fs::create_dir_all(path).with_context(named)?;
        fs::write(&probe, "").with_context(named)?;
        fs::remove_file(&probe).with_context(named)?;
        Ok(Self(path.to_path_buf()))
    }

    /// Removes a file of an earlier report that this one does not have.
    pub(crate) fn remove(&self, name: &str) -> Result<()> {
        let path = self.0.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", path.display()))
            }
            _ => Ok(()),
        }
    }

    /// Writes all files or none: a failure leaves an older report as it was.
    pub(crate) fn write(&self, files: &[(&str, &str)]) -> Result<Vec<PathBuf>> {
        // Goes with all that is still in it.
        let drafts = tempfile::tempdir_in(&self.0).with_context(|| format!("cannot write to {}", self.0.display()))?;
        for (name, contents) in files {
            let path = self.0.join(name);
            anyhow::ensure!(!path.is_dir(), "a folder is where {} should go", path.display());
            fs::write(drafts.path().join(name), contents)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        let place = |(name, _): &(&str, &str)| {
            let path = self.0.join(name);
            fs::rename(drafts.path().join(name), &path).with_context(|| format!("cannot write {}", path.display()))?;
            Ok(path)
        };
        files.iter().map(place).collect()
    }
}

/// What a report tells of: a simulated run, or a recording.
#[derive(Clone, Debug)]
pub struct Content<'a> {
    /// What the run is called.
    pub name: &'a str,
    /// A line on it and where it comes from.
    pub description: String,
    /// The run itself.
    pub records: &'a [Record],
    /// Its figures.
    pub summary: &'a Summary,
    /// Parameters of the simulated finger; nothing of a real one.
    pub parameters: Option<&'a PlantParameters>,
    /// What to know of the data.
    pub notes: Vec<String>,
}

/// Writes a simulated run's report and its table; returns the files, the page first.
///
/// # Errors
/// When a picture cannot be drawn or a file not be written.
pub fn write(folder: &Folder, trace: &Trace, summary: &Summary, parameters: &PlantParameters) -> Result<Vec<PathBuf>> {
    let records: Vec<Record> = trace.samples.iter().map(Record::from).collect();
    let content = Content {
        name: &trace.name,
        description: format!(
            "{}. Simulated finger, seed {}, {:.1} s.",
            trace.description, trace.seed, summary.duration_s
        ),
        records: &records,
        summary,
        parameters: Some(parameters),
        notes: Vec::new(),
    };
    write_content(folder, &content, &[("samples.csv", &csv::table(trace)?)])
}

/// Writes a report with other files beside it; returns all, the page first.
///
/// # Errors
/// When a picture cannot be drawn or a file not be written.
pub fn write_content(folder: &Folder, content: &Content<'_>, more: &[(&str, &str)]) -> Result<Vec<PathBuf>> {
    let bends_known = content.records.iter().any(|record| chart::bend_deg(record, 0).is_finite());
    let pictures = html::Pictures {
        finger: bends_known.then(|| finger::filmstrip(content.summary, FRAMES)),
        pressures: plots::pressures(content.records)?,
        actuation: plots::actuation(content.records)?,
        bends: plots::bends(content.records)?,
    };
    let page = html::page(content, &pictures)?;
    let json = serde_json::to_string_pretty(content.summary)? + "\n";
    let mut files = vec![("report.html", page.as_str())];
    files.extend_from_slice(more);
    files.extend(pictures.finger.as_deref().map(|finger| ("finger.svg", finger)));
    files.extend([
        ("pressures.svg", pictures.pressures.as_str()),
        ("actuation.svg", &pictures.actuation),
        ("bends.svg", &pictures.bends),
        ("summary.json", &json),
    ]);
    folder.write(&files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::summarise;
    use crate::simulate::{Program, Run};
    use model_core::units::Pressure;

    fn report(seed: u64) -> Vec<(String, String)> {
        let run = Run::new(Program::Setpoints([30, 0, 0].map(Pressure::from_kpa)), seed);
        let trace = run.simulate(|_, _| {}).expect("taken");
        let place = tempfile::tempdir().expect("a folder");
        let folder = Folder::prepare(place.path()).expect("writable");
        let files = write(&folder, &trace, &summarise(&trace), &run.parameters).expect("written");
        let name = |path: &Path| path.file_name().expect("a file").to_string_lossy().into_owned();
        assert_eq!(fs::read_dir(place.path()).expect("lists").count(), files.len(), "no drafts are left");
        files.iter().map(|path| (name(path), fs::read_to_string(path).expect("reads"))).collect()
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
        assert_eq!(report(5), report(5));
        assert_ne!(report(5), report(6));
    }

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        let files = report(1);
        let (_, page) = files.iter().find(|(name, _)| name == "report.html").expect("there");
        let banner = include_str!("vendor/uplot/uPlot.iife.min.js").lines().next().expect("a banner");
        let outside = page.replace("http://www.w3.org/2000/svg", "").replace(banner, "");
        for word in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!outside.contains(word), "{word}");
        }
    }

    #[test]
    fn the_table_reads_back() {
        let files = report(1);
        let (_, table) = files.iter().find(|(name, _)| name == "samples.csv").expect("there");
        let recording = csv::read(table.as_bytes()).expect("a recording");
        assert!(!recording.torn && recording.bad_lines == 0, "{:?}", recording.first_bad);
        let rows = &recording.records;
        assert_eq!(rows.len(), rows.last().map_or(0, |row| row.time_ms as usize + 1));
    }

    #[test]
    fn a_report_that_cannot_be_finished_leaves_the_old_one_alone() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = Folder::prepare(place.path()).expect("writable");
        folder.write(&[("one", "old")]).expect("written");
        fs::create_dir(place.path().join("two")).expect("in the way");
        assert!(folder.write(&[("one", "new"), ("two", "new")]).is_err());
        assert_eq!(fs::read_to_string(place.path().join("one")).expect("there"), "old");
        assert_eq!(fs::read_dir(place.path()).expect("lists").count(), 2, "no drafts are left");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let error = Folder::prepare(&file.path().join("below")).expect_err("a file has no folders in it");
        assert!(format!("{error:#}").contains("below"), "{error:#}");
    }
}
