//! A sequence of one's own: a file from a template, and its line in the library.

use crate::root;
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::io::Write;
use std::path::Path;
use syn::visit::Visit;

/// A sequence that compiles; its tests compile it as it stands.
const TEMPLATE: &str = include_str!("template.rs");

/// Where the library lies in the workspace.
const LIBRARY: &str = "model-core/src/sequence/library";

/// The line above the files' own lines.
const HEADING: &str =
    "// Sequences with a file of their own, one line each; `cargo xtask new-sequence NAME` writes file and line.\n";

/// The longest name, as the core has it (`model_core::sequence::MAX_NAME_BYTES`). The core itself is no dependency: this
/// chore must run while a sequence in it does not compile.
const MAX_NAME_BYTES: usize = 24;

/// Writes the sequence's file and says what to do with it.
///
/// # Errors
/// When the name is refused, or a file cannot be read or written; then nothing has changed.
pub fn new_sequence(name: &str) -> Result<()> {
    let file = write(name, &root().join(LIBRARY))?;
    println!(
        "written: {LIBRARY}/{file}, and its lines in {LIBRARY}/mod.rs\n\
         next:\n  \
         edit {LIBRARY}/{file}\n  \
         cargo run --release -- run --sequence {name}             on the simulated finger\n  \
         cargo run --release -- run --sequence {name} --on elf    the firmware on the emulated board\n  \
         cargo run -p firmware --release                          flashes a board\n\
         docs/sequences.md walks through it"
    );
    Ok(())
}

/// Writes into the library in this folder; returns the new file's name.
fn write(name: &str, library: &Path) -> Result<String> {
    let module = module(name)?;
    let index = library.join("mod.rs");
    let text = fs::read_to_string(&index).with_context(|| format!("cannot read {}", index.display()))?;
    let file = format!("{module}.rs");
    let path = library.join(&file);
    let taken = names(library)?;
    ensure!(!taken.iter().any(|other| other == name), "the name {name:?} is taken: choose another");
    ensure!(!path.exists(), "{} exists already: remove it, or choose another name", path.display());
    let text = registered(&text, &module)?;
    let content = TEMPLATE.replace("new-sequence", name).replace("use model_core::", "use crate::");

    // The file first: the library does not compile without it, and compiles with one that it does not name.
    let mut created = fs::File::create_new(&path).with_context(|| format!("cannot create {}", path.display()))?;
    let written = created.write_all(content.as_bytes()).map_err(anyhow::Error::from).and_then(|()| {
        let mut renewed = tempfile::NamedTempFile::new_in(library)?;
        renewed.write_all(text.as_bytes())?;
        fs::set_permissions(renewed.path(), fs::metadata(&index)?.permissions())?;
        renewed.persist(&index)?;
        Ok(())
    });
    if let Err(error) = written {
        fs::remove_file(&path)?;
        return Err(error.context(format!("cannot write to {}: nothing has changed", library.display())));
    }
    Ok(file)
}

/// The name of the file's module; an error for what the core or the compiler would refuse.
fn module(name: &str) -> Result<String> {
    let word = |word: &str| !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit());
    ensure!(
        name.split('-').all(word),
        "{name:?} is no name for a sequence: take lower-case letters and digits with single hyphens between, as in pinch-slowly"
    );
    ensure!(
        name.len() <= MAX_NAME_BYTES,
        "{name:?} has {} characters, and the link to the device takes {MAX_NAME_BYTES}: shorten it",
        name.len()
    );
    let module = name.replace('-', "_");
    if syn::parse_str::<syn::Ident>(&module).is_err() {
        bail!("{name:?} is a word of Rust or begins with a digit, so its file cannot be named so: try sequence-{name}");
    }
    Ok(module)
}

/// The names that the library's files give to sequences.
fn names(library: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(library).with_context(|| format!("cannot read {}", library.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path)?;
            let file = syn::parse_file(&text)
                .with_context(|| format!("{} is no Rust that can be read: mend it first", path.display()))?;
            Names(&mut names).visit_file(&file);
        }
    }
    Ok(names)
}

/// Collects the first argument of each `Sequence::new`.
struct Names<'names>(&'names mut Vec<String>);

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_expr_call(&mut self, call: &'ast syn::ExprCall) {
        if let (syn::Expr::Path(function), Some(syn::Expr::Lit(first))) = (&*call.func, call.args.first()) {
            let mut segments = function.path.segments.iter().rev().map(|segment| segment.ident.to_string());
            let called = [segments.next(), segments.next()];
            if let (["new", "Sequence"], syn::Lit::Str(name)) =
                (called.each_ref().map(|part| part.as_deref().unwrap_or_default()), &first.lit)
            {
                self.0.push(name.value());
            }
        }
        syn::visit::visit_expr_call(self, call);
    }
}

/// The library's text with the module's line, in order, and its sequence at the end of `ALL`.
fn registered(text: &str, module: &str) -> Result<String> {
    let (before, after) =
        text.split_once(HEADING).with_context(|| format!("{LIBRARY}/mod.rs lacks the line {HEADING:?}"))?;
    let mut lines: Vec<String> = after.lines().take_while(|line| !line.is_empty()).map(str::to_owned).collect();
    let rest = &after[lines.iter().map(|line| line.len() + 1).sum()..];
    lines.push(format!("mod {module};"));
    lines.sort();

    let opening = "pub static ALL: [&Sequence; ";
    let (head, list) = rest.split_once(opening).with_context(|| format!("{LIBRARY}/mod.rs lacks `{opening}`"))?;
    let (count, list) = list.split_once("] = [").context("ALL's length is not followed by its list")?;
    let count: usize = count.parse().context("ALL's length is no number")?;
    let (list, tail) = list.split_once("\n];").context("ALL's list does not end")?;
    Ok(format!(
        "{before}{HEADING}{}\n{head}{opening}{}] = [{list}\n    &{module}::SEQUENCE,\n];{tail}",
        lines.join("\n"),
        count + 1
    ))
}

#[cfg(test)]
mod template;

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::sequence::{self, Sequence, SequenceError, Step};
    use std::collections::BTreeMap;

    const REST: &[Step] = &[Step::kpa([0; 3]).ramp_ms(1000)];

    /// A copy of the library.
    fn library() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for entry in fs::read_dir(root().join(LIBRARY)).expect("the library is there").flatten() {
            fs::copy(entry.path(), folder.path().join(entry.file_name())).expect("copies");
        }
        folder
    }

    fn files(folder: &Path) -> BTreeMap<String, String> {
        let entries = fs::read_dir(folder).expect("reads").flatten();
        entries
            .map(|entry| {
                (entry.file_name().to_string_lossy().into_owned(), fs::read_to_string(entry.path()).expect("text"))
            })
            .collect()
    }

    #[test]
    fn the_template_is_a_sequence_with_everything_that_it_explains() {
        assert_eq!(template::SEQUENCE.name, "new-sequence");
        assert!(template::SEQUENCE.steps().len() >= 3);
        assert_eq!(MAX_NAME_BYTES, sequence::MAX_NAME_BYTES);
        let limits = [
            format!("0 to {} kPa", sequence::MAX_PRESSURE.to_bits() >> 16),
            format!("0 to {} degrees", sequence::MAX_BEND.to_bits() >> 16),
            format!("{} kPa or {} degrees a second", sequence::MAX_KPA_PER_S, sequence::MAX_DEG_PER_S),
            format!("{} kPa or {} degrees. The last", sequence::MAX_STEP_KPA, sequence::MAX_STEP_DEG),
        ];
        let prose = TEMPLATE.replace("\n/// ", " ");
        for limit in limits {
            assert!(prose.contains(&limit), "{limit}");
        }
    }

    #[test]
    fn files_and_lines_are_written_in_order_and_formatted() {
        let folder = library();
        let before = files(folder.path()).len();
        for name in ["pinch-slowly", "abc", "three-2-one"] {
            let file = write(name, folder.path()).expect("written");
            let text = fs::read_to_string(folder.path().join(&file)).expect("there");
            assert!(text.contains(&format!("Sequence::new(\"{name}\"")), "{text}");
            assert!(text.contains("use crate::sequence::{Sequence, Step};") && !text.contains("model_core"), "{text}");
        }
        let written = files(folder.path());
        assert_eq!(written.len(), before + 3);
        let index = &written["mod.rs"];
        let modules: Vec<_> = index.lines().filter(|line| line.starts_with("mod ") && line.ends_with(';')).collect();
        assert!(modules.is_sorted() && modules.len() >= 3, "{modules:?}");
        assert!(index.contains("    &pinch_slowly::SEQUENCE,\n    &abc::SEQUENCE,\n    &three_2_one::SEQUENCE,\n];"));
        let list = syn::parse_file(index).expect("Rust").items.into_iter().find_map(|item| match item {
            syn::Item::Static(all) if all.ident == "ALL" => Some(all),
            _ => None,
        });
        let list = list.expect("ALL is there");
        let (syn::Type::Array(kind), syn::Expr::Array(values)) = (*list.ty, *list.expr) else { panic!("an array") };
        let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(length), .. }) = kind.len else { panic!("a number") };
        assert_eq!(length.base10_parse::<usize>().expect("a number"), values.elems.len());
        let formatted = std::process::Command::new("rustfmt")
            .args(["--check", "--edition", "2024", "--config-path"])
            .arg(root().join("rustfmt.toml"))
            .arg(folder.path().join("mod.rs"))
            .output()
            .expect("rustfmt is there");
        assert!(formatted.status.success(), "{}", String::from_utf8_lossy(&formatted.stdout));
    }

    #[test]
    fn what_is_refused_is_named_and_leaves_everything_as_it_was() {
        let folder = library();
        let long = "a".repeat(MAX_NAME_BYTES + 1);
        write("mine", folder.path()).expect("written");
        fs::write(folder.path().join("left_over.rs"), "// of another time\n").expect("writes");
        let before = files(folder.path());
        for (name, what) in [
            ("Pinch", "lower-case"),
            ("", "lower-case"),
            ("two words", "lower-case"),
            ("a--b", "lower-case"),
            ("-a", "lower-case"),
            ("../escape", "lower-case"),
            (long.as_str(), "25 characters"),
            ("grasp", "taken"),
            ("calibrate", "taken"),
            ("mine", "taken"),
            ("left-over", "exists already"),
            ("move", "a word of Rust"),
            ("3-points", "begins with a digit"),
        ] {
            let error = format!("{:#}", write(name, folder.path()).expect_err(name));
            assert!(error.contains(what) && !error.contains('\n'), "{name}: {error}");
            assert_eq!(files(folder.path()), before, "{name}");
        }
    }

    #[test]
    fn a_library_that_cannot_be_written_to_stays_whole() {
        let folder = library();
        let index = folder.path().join("mod.rs");
        let text = fs::read_to_string(&index).expect("there");
        for broken in [text.replace(HEADING, ""), text.replace("pub static ALL", "pub static EVERYTHING"), text + "}"] {
            fs::write(&index, &broken).expect("writes");
            let before = files(folder.path());
            assert!(write("mine", folder.path()).is_err());
            assert_eq!(files(folder.path()), before);
        }
    }

    #[test]
    fn every_accepted_name_is_one_of_the_cores() {
        for name in ["a", "pinch-slowly", "a1-2", "Bad", "", "a-", "-a", "a--b", "a_b", "gr\u{fc}n", &"b".repeat(24)] {
            let name: &'static str = name.to_owned().leak();
            let core = Sequence::check(name, "", REST, 1);
            assert_eq!(module(name).is_ok(), core.is_ok(), "{name}");
            assert!(core.is_ok() || core == Err(SequenceError::Name));
        }
    }
}
