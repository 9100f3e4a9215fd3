//! README.md and docs/*.md: links lead somewhere, commands are understood, what is named exists, excerpts are the files.

use host_sim::cli;
use model_core::sequence::library;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in the workspace").to_path_buf()
}

/// One document, taken apart.
#[derive(Default)]
struct Document {
    text: String,
    /// Where its links and pictures lead.
    links: Vec<String>,
    /// The anchors of its headings.
    anchors: BTreeSet<String>,
    /// What stands between backticks, and the lines of its code blocks.
    code: Vec<String>,
}

impl Document {
    fn parse(text: String) -> Self {
        let mut document = Self::default();
        let (mut heading, mut in_block) = (None, false);
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    document.links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    document.anchors.insert(anchor(&heading.take().unwrap_or_default()));
                }
                Event::Start(Tag::CodeBlock(_)) => in_block = true,
                Event::End(TagEnd::CodeBlock) => in_block = false,
                Event::Text(part) if in_block => document.code.extend(part.lines().map(str::to_owned)),
                Event::Text(part) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&part);
                    }
                }
                Event::Code(part) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&part);
                    }
                    document.code.push(part.into_string());
                }
                _ => {}
            }
        }
        document.text = text;
        document
    }
}

/// As GitHub makes it: lower case, spaces to hyphens, punctuation left out.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter));
    kept.map(|letter| if letter == ' ' { '-' } else { letter.to_ascii_lowercase() }).collect()
}

/// README.md and docs/*.md by their paths in the workspace.
fn documents() -> BTreeMap<PathBuf, Document> {
    let pages = std::fs::read_dir(root().join("docs")).expect("docs is there").flatten();
    let pages = pages.map(|entry| Path::new("docs").join(entry.file_name()));
    let pages = pages.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    let all: BTreeMap<_, _> = std::iter::once(PathBuf::from("README.md"))
        .chain(pages)
        .map(|path| {
            let text = std::fs::read_to_string(root().join(&path)).expect("text");
            (path, Document::parse(text))
        })
        .collect();
    assert!(all.len() > 15, "{}", all.len());
    all
}

/// `docs/../README.md` is `README.md`.
fn tidy(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for part in path.components() {
        if part.as_os_str() == ".." {
            tidy.pop();
        } else {
            tidy.push(part);
        }
    }
    tidy
}

/// Each line of code with the document that it is in.
fn code(documents: &BTreeMap<PathBuf, Document>) -> impl Iterator<Item = (&Path, &str)> {
    let lines = documents.iter().flat_map(|(path, document)| document.code.iter().map(move |line| (path, line)));
    lines.map(|(path, line)| (path.as_path(), line.as_str()))
}

/// The commands of a line: without comments, one for each part of a pipe.
fn commands(line: &str) -> impl Iterator<Item = Vec<&str>> {
    let line = line.split(" #").next().unwrap_or_default();
    // `\|` in a table's synopsis is an alternative.
    let parts = if line.contains('[') { vec![line] } else { line.split('|').collect() };
    parts.into_iter().map(|part| part.split_whitespace().collect::<Vec<_>>()).filter(|words| !words.is_empty())
}

/// host-sim's arguments in a command, if it is one of host-sim's.
fn arguments<'line>(words: &[&'line str]) -> Option<Vec<&'line str>> {
    match words {
        ["host-sim", rest @ ..] => Some(rest.to_vec()),
        ["cargo", "run", rest @ ..] => {
            let separator = rest.iter().position(|word| *word == "--")?;
            let (options, rest) = (&rest[..separator], &rest[separator + 1..]);
            let package = options.iter().position(|word| ["-p", "--package"].contains(word));
            package.is_none_or(|at| options.get(at + 1) == Some(&"host-sim")).then(|| rest.to_vec())
        }
        _ => None,
    }
}

/// A word that stands for another: `NAME`, `P,M,D`, `[--json]`, `...`.
fn stands_for_another(word: &str) -> bool {
    let capital = |letter: char| letter.is_uppercase() || letter.is_ascii_digit() || ",/.".contains(letter);
    let capitals = word.chars().any(char::is_uppercase) && word.chars().all(capital);
    capitals || word.contains(['[', ']', '<', '|', '\\', '$']) || word.contains("...")
}

/// The long options that a word of a synopsis names.
fn options(words: &[&str]) -> Vec<String> {
    let letters = |word: &str| word.trim_matches(|c: char| "[]\\|,".contains(c)).to_owned();
    words.iter().map(|word| letters(word)).filter_map(|word| word.strip_prefix("--").map(str::to_owned)).collect()
}

#[test]
fn every_link_leads_to_a_file_and_every_anchor_to_a_heading() {
    let documents = documents();
    let mut count = 0;
    for (path, document) in &documents {
        for link in document.links.iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').map_or((link.as_str(), None), |(file, at)| (file, Some(at)));
            let here = path.parent().expect("a file has a folder");
            let target = if file.is_empty() { path.clone() } else { tidy(&here.join(file)) };
            assert!(root().join(&target).exists(), "{}: {link} leads nowhere", path.display());
            if let Some(anchor) = anchor {
                let page = documents.get(&target).unwrap_or_else(|| panic!("{}: {link}", path.display()));
                assert!(page.anchors.contains(anchor), "{}: no heading for {link}", path.display());
            }
            count += 1;
        }
    }
    assert!(count > 80, "{count}");
}

#[test]
fn the_readme_leads_to_every_document() {
    let documents = documents();
    let readme = &documents[Path::new("README.md")];
    for path in documents.keys().filter(|path| *path != Path::new("README.md")) {
        let linked = readme.links.iter().any(|link| Path::new(link) == path);
        assert!(linked, "README.md does not link to {}", path.display());
    }
}

#[test]
fn every_command_of_host_sim_is_understood() {
    let documents = documents();
    let (mut whole, mut synopses) = (0, 0);
    for (path, line) in code(&documents) {
        for words in commands(line) {
            let Some(arguments) = arguments(&words) else { continue };
            let place = format!("{}: {line}", path.display());
            // A command without options may be a name only, as in "see `host-sim campaign`".
            let told_whole = words[0] == "cargo" || arguments.iter().any(|word| word.starts_with("--"));
            if told_whole && !arguments.iter().any(|word| stands_for_another(word)) {
                let parsed = cli::command().try_get_matches_from(std::iter::once("host-sim").chain(arguments));
                // Help is told to stdout, and no error.
                let refused = parsed.err().filter(clap::Error::use_stderr);
                assert!(refused.is_none(), "{place}\n{}", refused.map(|e| e.to_string()).unwrap_or_default());
                whole += 1;
                continue;
            }
            let mut command = cli::command();
            command.build();
            for word in arguments.iter().take_while(|word| !word.starts_with('-') && !stands_for_another(word)) {
                let found = command.find_subcommand(word).cloned();
                // A value, as in `eval angle-from-pressure`, is no subcommand.
                assert!(found.is_some() || command.get_name() != "host-sim", "{place}: no command {word}");
                command = found.unwrap_or(command);
            }
            let known: Vec<_> = command.get_arguments().filter_map(clap::Arg::get_long).collect();
            for option in options(&arguments) {
                assert!(known.contains(&option.as_str()), "{place}: no option --{option}");
            }
            synopses += 1;
        }
    }
    assert!(whole > 20 && synopses > 5, "{whole} {synopses}");
}

/// The chores of xtask as its command line has them.
fn chores() -> BTreeSet<String> {
    let source = std::fs::read_to_string(root().join("xtask/src/main.rs")).expect("xtask is there");
    let items = syn::parse_file(&source).expect("Rust").items;
    let chores = items.into_iter().find_map(|item| match item {
        syn::Item::Enum(chores) if chores.ident == "Chore" => Some(chores.variants),
        _ => None,
    });
    let kebab = |name: String| {
        name.char_indices().fold(String::new(), |kebab, (at, letter)| {
            let hyphen = if at > 0 && letter.is_uppercase() { "-" } else { "" };
            format!("{kebab}{hyphen}{}", letter.to_lowercase())
        })
    };
    chores.expect("the chores are there").into_iter().map(|chore| kebab(chore.ident.to_string())).collect()
}

#[test]
fn every_chore_that_is_named_exists_and_every_chore_is_told_of() {
    let (documents, chores) = (documents(), chores());
    let mut told = BTreeSet::new();
    for (path, line) in code(&documents) {
        for words in commands(line) {
            if let ["cargo", "xtask", chore, ..] = words.as_slice()
                && !stands_for_another(chore)
            {
                assert!(chores.contains(*chore) || *chore == "help", "{}: {line}", path.display());
                told.insert((*chore).to_owned());
            }
        }
    }
    let untold: Vec<_> = chores.difference(&told).collect();
    assert!(untold.is_empty(), "docs/contributing.md does not tell of {untold:?}");
}

#[test]
fn every_sequence_that_is_named_exists() {
    let documents = documents();
    let mut made = BTreeSet::new();
    let mut named = Vec::new();
    for (path, line) in code(&documents) {
        let words: Vec<_> = line.split(' ').collect();
        for pair in words.windows(2) {
            match *pair {
                ["new-sequence", name] => _ = made.insert(name.trim_end_matches('`')),
                ["--sequence", name] if !stands_for_another(name) => named.push((path, name)),
                _ => {}
            }
        }
    }
    assert!(named.len() > 4, "{}", named.len());
    for (path, name) in named {
        let known = library::find(name).is_some() || made.contains(name);
        assert!(known, "{}: no sequence is named {name}", path.display());
    }
}

#[test]
fn every_test_program_that_is_named_exists() {
    let documents = documents();
    let mut count = 0;
    for (path, line) in code(&documents) {
        let words: Vec<_> = line.split_whitespace().collect();
        let after = |names: [&str; 2]| {
            let at = words.iter().position(|word| names.contains(word))?;
            words.get(at + 1).copied()
        };
        let (Some(package), Some(test)) = (after(["-p", "--package"]), after(["--test", "--test"])) else { continue };
        let folder = if package == "finger-tests" { Path::new("tests").into() } else { crate_folder(package) };
        let file = root().join(folder).join("tests").join(format!("{test}.rs"));
        assert!(file.exists(), "{}: {line}", path.display());
        count += 1;
    }
    assert!(count > 5, "{count}");
}

fn crate_folder(package: &str) -> PathBuf {
    let nested = Path::new("tests").join(package);
    if root().join(&nested).exists() { nested } else { package.into() }
}

#[test]
fn excerpts_are_what_the_files_say() {
    let mut count = 0;
    for (path, document) in &documents() {
        for rest in document.text.split("<!-- BEGIN ").skip(1) {
            let (name, rest) = rest.split_once(" -->").expect("a marker ends");
            if !name.contains('/') {
                continue;
            }
            let end = format!("<!-- END {name} -->");
            let (shown, _) = rest.split_once(&end).unwrap_or_else(|| panic!("{}: no {end}", path.display()));
            let shown = shown.trim().split_once('\n').and_then(|(_, code)| code.rsplit_once("\n```"));
            let file = std::fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(
                shown.map(|(code, _)| code),
                Some(file.trim_end()),
                "{} shows another {name}: run cargo xtask excerpts",
                path.display()
            );
            count += 1;
        }
    }
    assert!(count >= 3, "{count}");
}

#[test]
fn no_path_of_one_machine_is_in_a_document() {
    for (path, document) in &documents() {
        for start in ["/home/", "/root/", "/tmp/", "/work/", "/usr/", "/Users/", "C:\\"] {
            assert!(!document.text.contains(start), "{}: {start}", path.display());
        }
    }
}

#[test]
fn anchors_are_those_of_github() {
    assert_eq!(anchor("2. The emulated board"), "2-the-emulated-board");
    assert_eq!(
        anchor("What IEC 62304 would ask for beyond this project"),
        "what-iec-62304-would-ask-for-beyond-this-project"
    );
}
