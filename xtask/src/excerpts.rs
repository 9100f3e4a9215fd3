//! Source files shown in documents: what lies between `<!-- BEGIN path -->` and `<!-- END path -->` is that file.
//!
//! `tests/tests/docs.rs` fails when a document shows something else than the file.

use crate::{markers, root};
use anyhow::{Context, Result};
use std::fs;

/// Renews every excerpt in docs/*.md.
///
/// # Errors
/// When a document or a file that it names cannot be read or written.
pub fn excerpts() -> Result<()> {
    for entry in fs::read_dir(root().join("docs")).context("cannot read docs")? {
        let path = entry?.path();
        if path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let document = format!("docs/{}", path.file_name().unwrap_or_default().display());
        let text = fs::read_to_string(root().join(&document)).with_context(|| format!("cannot read {document}"))?;
        for path in paths(&text) {
            let content = fs::read_to_string(root().join(path)).with_context(|| format!("{document} shows {path}"))?;
            markers::replace(&document, path, &fenced(path, &content))?;
            println!("{document}: {path}");
        }
    }
    Ok(())
}

/// The files that a document shows.
fn paths(document: &str) -> Vec<&str> {
    let begins = document.split("<!-- BEGIN ").skip(1).filter_map(|rest| rest.split_once(" -->"));
    begins.map(|(name, _)| name).filter(|name| name.contains('/')).collect()
}

/// The file as a code block.
fn fenced(path: &str, content: &str) -> String {
    let language = match path.rsplit_once('.') {
        Some((_, "rs")) => "rust",
        Some((_, "py")) => "python",
        Some((_, "json")) => "json",
        _ => "text",
    };
    format!("```{language}\n{}\n```", content.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_markers_with_a_path_are_excerpts() {
        let text = "<!-- BEGIN table -->\n<!-- END table -->\n<!-- BEGIN a/b.rs -->\n<!-- END a/b.rs -->\n";
        assert_eq!(paths(text), ["a/b.rs"]);
        assert_eq!(fenced("a/b.rs", "fn main() {}\n\n"), "```rust\nfn main() {}\n```");
        assert_eq!(fenced("a/b.stderr", "error\n"), "```text\nerror\n```");
    }
}
