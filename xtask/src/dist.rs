//! The release: everything that somebody needs who flashes a board and was not there when it was built.
//!
//! The same sources and compiler give the same bytes, in whatever folder they lie.

use crate::toolchain::{self, Route, TARGET};
use crate::{command, firmware, image, root, run};
use anyhow::{Context, Result, ensure};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The release's files by name.
type Files = BTreeMap<String, Vec<u8>>;

const SUMS: &str = "SHA256SUMS";

/// What is copied as it is.
const COPIED: [(&str, &str); 4] = [
    ("LICENSE-APACHE", "LICENSE-APACHE"),
    ("LICENSE-MIT", "LICENSE-MIT"),
    ("CHANGELOG.md", "docs/CHANGELOG.md"),
    ("wiring.md", "docs/wiring.md"),
];

/// Builds the firmware and writes target/dist/finger-VERSION.
///
/// # Errors
/// When the firmware does not build or is over its limit of flash, or a file cannot be read or written; the last release
/// stays then.
pub fn dist() -> Result<()> {
    let (elf, route) = firmware::build()?;
    let files = release(&elf, route)?;
    let folder = write(&files)?;
    println!("built with {route}: {folder}", folder = folder.display());
    print!("{}", String::from_utf8_lossy(&files[SUMS]));
    Ok(())
}

/// Builds a copy of the sources, in another folder and from nothing, and compares it with what [`dist`] makes, byte by byte.
///
/// # Errors
/// As [`dist`], and when a file differs.
pub fn check() -> Result<()> {
    let (elf, route) = firmware::build()?;
    let one = release(&elf, route)?;
    let again = root().join("target").join("dist-again");
    if again.exists() {
        fs::remove_dir_all(&again)?;
    }
    let copy = again.join("sources");
    copy_sources(&root(), &copy)?;
    let (mut cargo, folder) = toolchain::cargo_build_of(route, &copy, &again.join("built"));
    run(cargo.args(["--quiet", "--locked", "--package", "firmware", "--bin", "firmware"]))?;
    let other = release(&fs::read(folder.join("firmware")).context("the second build left no firmware")?, route)?;
    fs::remove_dir_all(&again)?;
    let different: Vec<_> = one.keys().filter(|name| one.get(*name) != other.get(*name)).cloned().collect();
    ensure!(
        different.is_empty() && one.len() == other.len(),
        "a second build, in another folder, differs in {}: something depends on folder or time",
        different.join(", ")
    );
    println!("{} files, the same bytes from another folder", one.len());
    Ok(())
}

/// All files of the release with this firmware.
fn release(elf: &[u8], route: Route) -> Result<Files> {
    let sizes = image::sizes(elf)?;
    ensure!(
        sizes.flash_bytes <= firmware::FLASH_LIMIT,
        "flash: {} bytes, over the limit of {}",
        sizes.flash_bytes,
        firmware::FLASH_LIMIT
    );
    let flat = image::image(elf)?;
    let read = |file: &str| fs::read(root().join(file)).with_context(|| format!("cannot read {file}"));
    let measured: serde_json::Value = serde_json::from_slice(&read("docs/figures/firmware.json")?)?;
    let figures = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "revision": revision(),
        "target": TARGET,
        "compiler": toolchain::compiler(route)?,
        "flash_bytes": sizes.flash_bytes,
        "flash_limit_bytes": firmware::FLASH_LIMIT,
        "ram_bytes": sizes.ram_bytes,
        "ram_limit_bytes": firmware::RAM_LIMIT,
        "flash_start_address": flat.address,
        "image_bytes": flat.bytes.len(),
        "sections_bytes": sizes.sections.iter().cloned().collect::<BTreeMap<_, _>>(),
        // Of the committed baseline, which `cargo xtask test` holds the firmware to.
        "baseline_on_emulated_board": measured,
    });
    let mut files = Files::from([
        ("firmware.elf".into(), elf.to_vec()),
        ("firmware.hex".into(), image::hex(&flat)?.into_bytes()),
        ("firmware.bin".into(), flat.bytes),
        ("figures.json".into(), format!("{figures:#}\n").into_bytes()),
        ("licences.txt".into(), licences()?.into_bytes()),
    ]);
    for (name, from) in COPIED {
        files.insert(name.into(), read(from)?);
    }
    let sums = sums(&files);
    files.insert(SUMS.into(), sums.into_bytes());
    Ok(files)
}

/// In the form that `sha256sum --check` reads.
fn sums(files: &Files) -> String {
    let line = |(name, content): (&String, &Vec<u8>)| {
        let hex = hmac_sha256::Hash::hash(content).iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
        format!("{hex}  {name}\n")
    };
    files.iter().map(line).collect()
}

/// The commit, with a mark when files have changed since; "unknown" without git.
fn revision() -> String {
    let git = command("git").args(["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]).output();
    let text = git.ok().filter(|output| output.status.success()).map(|output| output.stdout);
    text.map_or_else(|| "unknown".into(), |text| String::from_utf8_lossy(&text).trim().to_owned())
}

/// Name, version and licence of each crate whose code is in the firmware.
fn licences() -> Result<String> {
    let mut cargo = command("cargo");
    cargo.args(["tree", "--locked", "--package", "firmware", "--target", TARGET, "--edges", "normal,no-proc-macro"]);
    let output = cargo.args(["--prefix", "none", "--no-dedupe", "--format", "{p}\t{l}"]).output()?;
    ensure!(output.status.success(), "cargo tree: {}", String::from_utf8_lossy(&output.stderr));
    licence_list(&String::from_utf8(output.stdout)?)
}

fn licence_list(tree: &str) -> Result<String> {
    let mut lines = BTreeSet::new();
    for line in tree.lines() {
        let (package, licence) = line.split_once('\t').with_context(|| format!("cargo tree says {line:?}"))?;
        // A path in parentheses follows the version of our own crates.
        let package = package.split(" (").next().unwrap_or(package);
        ensure!(!licence.is_empty(), "{package} names no licence: look into its sources, and ask its authors");
        lines.insert(format!("{package}: {licence}\n"));
    }
    Ok(lines.into_iter().collect())
}

/// Writes the files to target/dist/finger-VERSION, in the place of what was there; returns the folder.
fn write(files: &Files) -> Result<PathBuf> {
    let parent = root().join("target").join("dist");
    fs::create_dir_all(&parent)?;
    let name = format!("finger-{}", env!("CARGO_PKG_VERSION"));
    replace(&parent, &name, files).with_context(|| format!("cannot write target/dist/{name}"))?;
    Ok(PathBuf::from("target/dist").join(name))
}

/// A folder of this name with these files and no others; up to the last moment the old one is there.
fn replace(parent: &Path, name: &str, files: &Files) -> Result<()> {
    let new = tempfile::Builder::new().prefix(".new-").tempdir_in(parent)?;
    for (file, content) in files {
        fs::write(new.path().join(file), content)?;
    }
    #[cfg(unix)]
    fs::set_permissions(new.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
    let folder = parent.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::rename(new.keep(), &folder)?;
    Ok(())
}

/// What cargo needs to build the firmware.
fn copy_sources(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if entry.file_type()?.is_dir() {
            if !["target", ".git", "docs"].iter().any(|left_out| name == *left_out) {
                copy_sources(&entry.path(), &to.join(name))?;
            }
        } else {
            fs::copy(entry.path(), to.join(name))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF with one section, as a programmer would get it.
    fn elf() -> Vec<u8> {
        use object::elf;
        use object::write::elf::{FileHeader, ProgramHeader, SectionHeader, Writer};
        let mut buffer = Vec::new();
        let mut writer = Writer::new(object::Endianness::Little, false, &mut buffer);
        let code = [1_u8, 2, 3, 4];
        writer.reserve_file_header();
        writer.reserve_program_headers(1);
        let at = writer.reserve(code.len(), 4);
        let name = writer.add_section_name(b".text");
        writer.reserve_section_index();
        writer.reserve_shstrtab_section_index();
        writer.reserve_shstrtab();
        writer.reserve_section_headers();
        writer
            .write_file_header(&FileHeader {
                os_abi: 0,
                abi_version: 0,
                e_type: elf::ET_EXEC,
                e_machine: elf::EM_ARM,
                e_entry: 0x0800_0000,
                e_flags: 0,
            })
            .expect("header");
        writer.write_align_program_headers();
        writer.write_program_header(&ProgramHeader {
            p_type: elf::PT_LOAD,
            p_flags: elf::PF_R,
            p_offset: at as u64,
            p_vaddr: 0x0800_0000,
            p_paddr: 0x0800_0000,
            p_filesz: code.len() as u64,
            p_memsz: code.len() as u64,
            p_align: 4,
        });
        writer.pad_until(at);
        writer.write(&code);
        writer.write_shstrtab();
        writer.write_null_section_header();
        writer.write_section_header(&SectionHeader {
            name: Some(name),
            sh_type: elf::SHT_PROGBITS,
            sh_flags: u64::from(elf::SHF_ALLOC),
            sh_addr: 0x0800_0000,
            sh_offset: at as u64,
            sh_size: code.len() as u64,
            sh_link: 0,
            sh_info: 0,
            sh_addralign: 4,
            sh_entsize: 0,
        });
        writer.write_shstrtab_section_header();
        buffer
    }

    #[test]
    fn two_releases_of_one_firmware_are_the_same_bytes_and_their_sums_are_right() {
        let release = || release(&elf(), Route::Rustup).expect("a release");
        let files = release();
        assert_eq!(release(), files);
        assert_eq!(files["firmware.bin"], [1, 2, 3, 4]);
        let figures: serde_json::Value = serde_json::from_slice(&files["figures.json"]).expect("JSON");
        assert_eq!((figures["flash_bytes"].as_u64(), figures["image_bytes"].as_u64()), (Some(4), Some(4)));
        // SHA-256 of the four bytes, from `printf '\1\2\3\4' | sha256sum`.
        let sums = String::from_utf8(files[SUMS].clone()).expect("text");
        assert!(
            sums.contains("9f64a747e1b97f131fabb6b447296c9b6f0201e79fb3c5356e6c77e89b6a806a  firmware.bin\n"),
            "{sums}"
        );
        let named: Vec<_> = sums.lines().filter_map(|line| line.split_once("  ")).map(|(_, name)| name).collect();
        let all: Vec<_> = files.keys().filter(|name| *name != SUMS).collect();
        assert_eq!(named, all);
    }

    #[test]
    fn nothing_of_this_machine_is_in_the_texts() {
        let files = release(&elf(), Route::Rustup).expect("a release");
        for name in ["figures.json", "licences.txt", SUMS] {
            let text = String::from_utf8(files[name].clone()).expect("text");
            assert!(!text.contains(&root().display().to_string()), "{name}");
        }
        let licences = String::from_utf8(files["licences.txt"].clone()).expect("text");
        let names = ["firmware v", "model-core v", "embassy-stm32 v", "postcard v", "fixed v"];
        assert!(names.iter().all(|name| licences.contains(name)), "{licences}");
        assert!(!licences.contains("GPL"), "{licences}");
    }

    #[test]
    fn a_crate_without_licence_stops_the_release() {
        let list = licence_list("b v2.0.0\tMIT\na v1.0.0 (somewhere)\tISC\nb v2.0.0\tMIT\n").expect("a list");
        assert_eq!(list, "a v1.0.0: ISC\nb v2.0.0: MIT\n");
        let error = licence_list("a v1.0.0\t\n").expect_err("refused").to_string();
        assert!(error.contains("a v1.0.0"), "{error}");
    }

    #[test]
    fn a_release_takes_the_place_of_the_last_one_as_a_whole() {
        let parent = tempfile::tempdir().expect("a folder");
        let files = |names: &[&str]| -> Files { names.iter().map(|name| ((*name).to_owned(), vec![1])).collect() };
        for names in [["a", "b"], ["b", "c"]] {
            replace(parent.path(), "finger", &files(&names)).expect("written");
            let entries = fs::read_dir(parent.path().join("finger")).expect("there").flatten();
            let mut there: Vec<_> = entries.map(|entry| entry.file_name()).collect();
            there.sort();
            assert_eq!(there, names);
            assert_eq!(fs::read_dir(parent.path()).expect("there").count(), 1, "nothing else is left");
        }
    }

    #[test]
    fn copied_sources_are_all_but_what_is_built() {
        let (from, to) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        for file in ["Cargo.toml", ".cargo/config.toml", "firmware/src/main.rs", "target/x", ".git/y", "docs/z"] {
            let path = from.path().join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("creates");
            fs::write(path, file).expect("writes");
        }
        copy_sources(from.path(), to.path()).expect("copies");
        for (file, copied) in [
            ("Cargo.toml", true),
            (".cargo/config.toml", true),
            ("firmware/src/main.rs", true),
            ("target/x", false),
            (".git/y", false),
            ("docs/z", false),
        ] {
            assert_eq!(to.path().join(file).exists(), copied, "{file}");
        }
    }
}
