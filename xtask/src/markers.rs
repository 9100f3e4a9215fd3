//! Parts of committed documents that a chore writes: what lies between `<!-- BEGIN name -->` and `<!-- END name -->`.

use crate::root;
use anyhow::{Context, Result, bail, ensure};
use std::fs;

/// Puts `content` between the markers of a file; the path is relative to the workspace.
///
/// # Errors
/// When the file cannot be read or written, or [`replaced`] refuses it.
pub fn replace(file: &str, name: &str, content: &str) -> Result<()> {
    let path = root().join(file);
    let text = fs::read_to_string(&path).with_context(|| format!("cannot read {file}"))?;
    let text = replaced(&text, name, content).with_context(|| format!("cannot renew {file}"))?;
    fs::write(path, text).with_context(|| format!("cannot write {file}"))
}

/// The text with `content`, on lines of its own, between the markers.
///
/// # Errors
/// When a marker is missing, comes twice, or the end comes first.
pub fn replaced(text: &str, name: &str, content: &str) -> Result<String> {
    let (before, _, after) = split(text, name)?;
    ensure!(!content.contains("<!-- "), "the new part has markers of its own");
    Ok(format!("{before}\n{}\n{after}", content.trim_matches('\n')))
}

/// What lies between the markers, without the line ends beside them.
///
/// # Errors
/// As [`replaced`].
#[cfg(test)]
pub fn content<'text>(text: &'text str, name: &str) -> Result<&'text str> {
    split(text, name).map(|(_, content, _)| content.trim_matches('\n'))
}

/// The text up to the first marker's end, between the markers, and from the last one on.
fn split<'text>(text: &'text str, name: &str) -> Result<(&'text str, &'text str, &'text str)> {
    let [begin, end] = ["BEGIN", "END"].map(|word| format!("<!-- {word} {name} -->"));
    for marker in [&begin, &end] {
        match text.matches(marker).count() {
            1 => {}
            0 => bail!("the marker {marker} is missing: add it where the part belongs"),
            count => bail!("the marker {marker} is there {count} times: leave one"),
        }
    }
    let start = text.find(&begin).context("just counted")? + begin.len();
    let stop = text.find(&end).context("just counted")?;
    ensure!(start <= stop, "{end} comes before {begin}");
    Ok((&text[..start], &text[start..stop], &text[stop..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a\n<!-- BEGIN x -->\nold\n<!-- END x -->\nb\n";

    #[test]
    fn only_the_part_between_changes_and_twice_is_once() {
        let once = replaced(TEXT, "x", "new\nlines\n").expect("both markers");
        assert_eq!(once, "a\n<!-- BEGIN x -->\nnew\nlines\n<!-- END x -->\nb\n");
        assert_eq!(replaced(&once, "x", "new\nlines\n").expect("both markers"), once);
        assert_eq!(content(&once, "x").expect("both markers"), "new\nlines");
    }

    #[test]
    fn markers_that_are_missing_doubled_or_swapped_are_named() {
        let refused = |text: &str, name: &str| replaced(text, name, "new").expect_err("refused").to_string();
        assert!(refused(TEXT, "y").contains("<!-- BEGIN y -->"));
        assert!(refused("<!-- BEGIN x -->", "x").contains("<!-- END x -->"));
        assert!(refused(&TEXT.repeat(2), "x").contains("2 times"));
        assert!(refused("<!-- END x --> <!-- BEGIN x -->", "x").contains("before"));
    }
}
