//! The file that a session is recorded to: a new one, every row handed to the operating system as it comes.

use crate::report::csv::RecordWriter;
use crate::report::record::Record;
use std::fs::{File, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use time::OffsetDateTime;

/// See the module's page.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    writer: RecordWriter<File>,
    rows: u64,
    trouble: Option<String>,
}

impl Recorder {
    /// Begins a new file, or `finger-DATE-TIME.csv` (UTC) in the folder one is in.
    ///
    /// # Errors
    /// When there is such a file already, or it cannot be made: names it.
    pub fn create(path: Option<&Path>) -> Result<Self, String> {
        let path = path.map_or_else(|| dated(OffsetDateTime::now_utc()), Path::to_path_buf);
        let file = OpenOptions::new().write(true).create_new(true).open(&path).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => format!(
                "{} is there already, and no recording is overwritten: choose another name with --record",
                path.display()
            ),
            _ => format!("cannot record to {}: {error}: choose another name with --record", path.display()),
        })?;
        let writer =
            RecordWriter::new(file, 1).map_err(|error| format!("cannot record to {}: {error}", path.display()))?;
        Ok(Self { path, writer, rows: 0, trouble: None })
    }

    /// Adds a row. One that cannot be written is kept, and tried again with the next.
    pub fn take(&mut self, row: &Record) {
        self.trouble = self.writer.write(row).err().as_ref().map(ToString::to_string);
        self.rows += 1;
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Rows so far.
    #[must_use]
    pub const fn rows(&self) -> u64 {
        self.rows
    }

    /// Why the last row is not in the file yet.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

fn dated(now: OffsetDateTime) -> PathBuf {
    let (date, time) = (now.date(), now.time());
    let day = format!("{:04}{:02}{:02}", date.year(), u8::from(date.month()), date.day());
    format!("finger-{day}-{:02}{:02}{:02}.csv", time.hour(), time.minute(), time.second()).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::csv;
    use crate::report::record::Source;

    #[test]
    fn a_file_that_is_there_is_left_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("one.csv");
        std::fs::write(&path, "precious").expect("written");
        let error = Recorder::create(Some(&path)).expect_err("there already");
        assert!(error.contains("one.csv") && error.contains("--record"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).expect("there"), "precious");
        let error = Recorder::create(Some(&folder.path().join("no/such/folder.csv"))).expect_err("no folder");
        assert!(error.contains("no/such/folder.csv"), "{error}");
    }

    #[test]
    fn every_row_is_in_the_file_before_the_next_comes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("one.csv");
        let mut recorder = Recorder::create(Some(&path)).expect("new");
        for index in 0..5 {
            recorder.take(&Record::unknown(Source::Device, 10 * index));
            let read = csv::read(&std::fs::read(&path).expect("there")).expect("a recording");
            assert_eq!((read.records.len() as u32, read.torn), (index + 1, false));
        }
        assert_eq!((recorder.rows(), recorder.trouble()), (5, None));
    }

    #[test]
    fn the_name_is_the_date_and_time() {
        let then = OffsetDateTime::from_unix_timestamp(1_798_704_306).expect("in range");
        assert_eq!(dated(then), Path::new("finger-20261231-080506.csv"));
    }
}
