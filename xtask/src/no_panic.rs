//! The link-time proof that model-core cannot panic; `docs/testing.md` says what it proves.
//!
//! The program `no-panic` calls every public function of model-core. The linker keeps only what can be reached, so a
//! panic function in its symbol table is one that some call reaches; the relocations, kept in the ELF, say by whom.

use crate::{run, toolchain};
use addr2line::gimli;
use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol, RelocationTarget, SymbolKind};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};

/// What the program does not call, and why.
const EXCLUDED: &str = include_str!("../../tests/no-panic/excluded.toml");

/// The most ways to a panic that are written out.
const MOST_WRITTEN: usize = 20;

/// Checks model-core, then that the check finds the panic that was put there for it.
pub fn check() -> Result<()> {
    let panics = examine(&build(&[])?)?;
    if !panics.symbols.is_empty() {
        bail!("model-core can panic:\n{}", panics.written());
    }
    println!("no panic can be reached from any public function of model-core ({} functions linked)", panics.functions);
    for (name, reason) in toml::from_str::<BTreeMap<String, String>>(EXCLUDED)? {
        println!("  not called: {name}: {reason}");
    }
    let control = examine(&build(&["--features", "positive-control"])?)?;
    let found = control.ways.iter().any(|way| way.iter().any(|frame| frame.starts_with("positive_control")));
    ensure!(
        found,
        "the check is blind: it does not find the panic of no-panic's feature `positive-control`; it found:\n{}",
        control.written()
    );
    println!("positive control: the deliberate panic is found: {}", short(&control.symbols));
    Ok(())
}

/// The linked program.
fn build(features: &[&str]) -> Result<PathBuf> {
    let (mut cargo, folder) = toolchain::cargo_build(toolchain::set_up()?);
    run(cargo.args(["--quiet", "--package", "no-panic", "--bin", "no-panic"]).args(features))?;
    Ok(folder.join("no-panic"))
}

/// Which panic functions a program has, and how they are reached.
#[derive(Debug, Default)]
struct Panics {
    /// Functions in the program.
    functions: usize,
    symbols: BTreeSet<String>,
    /// For each call of one, what lies between it and a function under test, innermost first.
    ways: BTreeSet<Vec<String>>,
}

impl Panics {
    fn written(&self) -> String {
        let mut text = format!("panic functions in the program: {}\n", short(&self.symbols));
        for way in self.ways.iter().take(MOST_WRITTEN) {
            text += &format!("\n  {}\n", way.join("\n    in "));
        }
        if self.ways.len() > MOST_WRITTEN {
            text += &format!("\n  and {} more\n", self.ways.len() - MOST_WRITTEN);
        }
        text
    }
}

fn short(symbols: &BTreeSet<String>) -> String {
    symbols.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// Whether a function is one that a panic goes through: the panic handler, and what the standard library keeps for
/// a failed index, unwrap, slice, copy, borrow or arithmetic. `name` is demangled.
fn is_panic(name: &str) -> bool {
    let library = ["core::", "alloc::", "std::"].iter().any(|library| name.starts_with(library));
    name.contains("rust_begin_unwind")
        || library && name.split("::").any(|part| part.contains("panic") || part.contains("fail"))
}

/// Readable, and without generic arguments longer than a type's name.
fn demangled(name: &str) -> String {
    let mut name = format!("{:#}", rustc_demangle::demangle(name));
    while let Some((start, end)) = longest_arguments(&name) {
        name.replace_range(start..end, "..");
    }
    name
}

/// Where the first outermost `<...>` after a name has more than sixty characters, without the brackets.
fn longest_arguments(name: &str) -> Option<(usize, usize)> {
    let (mut depth, mut start) = (0, 0);
    for (at, character) in name.char_indices().skip(1) {
        match character {
            '<' => {
                start = if depth == 0 { at + 1 } else { start };
                depth += 1;
            }
            // Not the arrow of a function's type.
            '>' if depth > 0 && !name[..at].ends_with('-') => {
                depth -= 1;
                if depth == 0 && at - start > 60 {
                    return Some((start, at));
                }
            }
            _ => {}
        }
    }
    None
}

/// A reference from one function to another.
struct Reference {
    from: u64,
    /// Where in the caller.
    at: u64,
}

/// Functions by address, and who refers to each.
struct Graph {
    functions: BTreeMap<u64, (u64, String)>,
    callers: BTreeMap<u64, Vec<Reference>>,
}

impl Graph {
    fn read(elf: &[u8]) -> Result<Self> {
        let file = object::File::parse(elf).context("no ELF")?;
        let mut functions = BTreeMap::new();
        for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && !symbol.is_undefined()) {
            let name = demangled(symbol.name()?);
            // Thumb code has an odd address as a symbol. `$t` and `$d` mark code and data and name nothing.
            if !name.starts_with('$') {
                functions.insert(symbol.address() & !1, (symbol.size(), name));
            }
        }
        let mut graph = Self { functions, callers: BTreeMap::new() };
        let mut relocations = 0;
        for section in file.sections() {
            for (at, relocation) in section.relocations() {
                relocations += 1;
                let RelocationTarget::Symbol(index) = relocation.target() else { continue };
                let to = file.symbol_by_index(index)?.address() & !1;
                if let Some(from) = graph.function_at(at)
                    && graph.functions.contains_key(&to)
                {
                    graph.callers.entry(to).or_default().push(Reference { from, at });
                }
            }
        }
        ensure!(relocations > 0, "the program was linked without --emit-relocs: nobody can say who calls whom");
        ensure!(!graph.functions.is_empty(), "the program has no symbol table");
        Ok(graph)
    }

    /// The function that holds an address.
    fn function_at(&self, address: u64) -> Option<u64> {
        let (&start, &(size, _)) = self.functions.range(..=address).next_back()?;
        (address < start + size).then_some(start)
    }

    fn name(&self, function: u64) -> &str {
        self.functions.get(&function).map_or("?", |(_, name)| name)
    }

    fn callers(&self, function: u64) -> &[Reference] {
        self.callers.get(&function).map_or(&[], Vec::as_slice)
    }

    /// The shortest chain of call sites from a reference up to a function of the program itself.
    fn way_up(&self, first: &Reference) -> Vec<u64> {
        let mut seen = BTreeSet::from([first.from]);
        let mut queue = VecDeque::from([(first.from, vec![first.at])]);
        let mut way = vec![first.at];
        while let Some((function, sites)) = queue.pop_front() {
            way.clone_from(&sites);
            if self.name(function).starts_with("no_panic::") {
                break;
            }
            for caller in self.callers(function) {
                if seen.insert(caller.from) {
                    let mut longer = sites.clone();
                    longer.push(caller.at);
                    queue.push_back((caller.from, longer));
                }
            }
        }
        way
    }
}

/// The line tables of a program.
type Lines<'a> = addr2line::Context<gimli::EndianSlice<'a, gimli::LittleEndian>>;

/// Looks for panic functions in a linked program.
fn examine(program: &Path) -> Result<Panics> {
    let elf = fs::read(program).with_context(|| format!("the build left no {}", program.display()))?;
    let graph = Graph::read(&elf)?;
    let file = object::File::parse(elf.as_slice())?;
    let section = |id: gimli::SectionId| {
        let data = file.section_by_name(id.name()).and_then(|section| section.data().ok());
        Ok::<_, gimli::Error>(gimli::EndianSlice::new(data.unwrap_or_default(), gimli::LittleEndian))
    };
    let lines = Lines::from_dwarf(gimli::Dwarf::load(section)?)?;
    let mut panics = Panics { functions: graph.functions.len(), ..Panics::default() };
    for (&function, (_, name)) in graph.functions.iter().filter(|(_, (_, name))| is_panic(name)) {
        panics.symbols.insert(name.clone());
        for reference in graph.callers(function).iter().filter(|reference| !is_panic(graph.name(reference.from))) {
            let mut way = vec![name.clone()];
            for site in graph.way_up(reference) {
                way.extend(frames(&lines, site)?);
            }
            panics.ways.insert(way);
        }
    }
    Ok(panics)
}

/// The functions that an address belongs to, inlined ones first, each with its line.
fn frames(lines: &Lines<'_>, address: u64) -> Result<Vec<String>> {
    let mut iterator = lines.find_frames(address).skip_all_loads()?;
    let mut frames = Vec::new();
    while let Some(frame) = iterator.next()? {
        let name = frame.function.as_ref().and_then(|name| name.raw_name().ok()).map(|name| demangled(&name));
        let place = frame.location.and_then(|place| Some(format!(" ({}:{})", near(place.file?), place.line?)));
        frames.push(format!("{}{}", name.as_deref().unwrap_or("?"), place.unwrap_or_default()));
    }
    Ok(frames)
}

/// A path without what differs from machine to machine: from the workspace, the registry's folder or the library's on.
fn near(file: &str) -> &str {
    let inside = Path::new(file).strip_prefix(toolchain::WORKSPACE).ok().and_then(Path::to_str);
    let after = |mark: &str| file.split_once(mark).map(|(_, rest)| rest);
    let registry = after("/registry/src/").and_then(|rest| rest.split_once('/')).map(|(_, rest)| rest);
    inside.or(registry).or_else(|| after("/library/")).unwrap_or(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::write::{Object as Writer, Relocation, StandardSection, Symbol, SymbolSection};
    use object::{RelocationFlags, SymbolFlags, SymbolScope};

    #[test]
    fn the_librarys_panics_are_known_in_both_manglings() {
        for symbol in [
            "_RNvCs7ldSeZOOJos_7___rustc17rust_begin_unwind",
            "rust_begin_unwind",
            "_RNvNtCs7ldSeZOOJos_4core9panicking18panic_bounds_check",
            "_ZN4core9panicking18panic_bounds_check17h0123456789abcdefE",
            "_RINvNtCs7ldSeZOOJos_4core9panicking13assert_failedjjEB4_",
            "_RNvNtNtCs7ldSeZOOJos_4core5slice5index16slice_index_fail",
            "_ZN4core5slice5index26slice_start_index_len_fail17h0123456789abcdefE",
            "_RNvNtCs7ldSeZOOJos_4core6option13unwrap_failed",
            "_RNvNtCs7ldSeZOOJos_4core6option13expect_failed",
            "_ZN4core6result13unwrap_failed17h0123456789abcdefE",
            "_ZN4core4cell22panic_already_borrowed17h0123456789abcdefE",
            "_ZN4core9panicking11panic_const23panic_const_div_by_zero17h0123456789abcdefE",
            "_ZN4core5slice29_$LT$impl$u20$$u5b$T$u5d$$GT$15copy_from_slice17len_mismatch_fail17h0123456789abcdefE",
        ] {
            assert!(is_panic(&demangled(symbol)), "{symbol}: {}", demangled(symbol));
        }
    }

    #[test]
    fn other_functions_are_no_panics() {
        for symbol in [
            "_ZN8no_panic5calls6frames17h1dff21b583f51608E",
            "_ZN10model_core10self_test8SelfTest4step17h0123456789abcdefE",
            "_RNvNtCs7ldSeZOOJos_4core3str9from_utf8",
            "__aeabi_memcpy",
            "Reset",
        ] {
            assert!(!is_panic(&demangled(symbol)), "{symbol}: {}", demangled(symbol));
        }
    }

    #[test]
    fn long_generic_arguments_are_left_out() {
        let long = "x".repeat(61);
        let mut name = format!("<a::B as C>::clamp<{long}>::d<u8>");
        if let Some((start, end)) = longest_arguments(&name) {
            name.replace_range(start..end, "..");
        }
        assert_eq!(name, "<a::B as C>::clamp<..>::d<u8>");
        assert_eq!(longest_arguments(&name), None);
    }

    /// `main` calls `middle` calls `panic_fmt`: 16 bytes each, one reference in each.
    fn program(with_relocations: bool) -> Vec<u8> {
        let mut writer = Writer::new(object::BinaryFormat::Elf, object::Architecture::Arm, object::Endianness::Little);
        let text = writer.section_id(StandardSection::Text);
        writer.append_section_data(text, &[0; 48], 4);
        let names = [
            "_ZN8no_panic5calls6frames17h1dff21b583f51608E",
            "_ZN10model_core6middle17h0123456789abcdefE",
            "_ZN4core9panicking9panic_fmt17h0123456789abcdefE",
        ];
        let symbols = names.map(|name| {
            let index = names.iter().position(|other| *other == name).expect("one of them") as u64;
            writer.add_symbol(Symbol {
                name: name.as_bytes().to_vec(),
                // Thumb.
                value: 16 * index + 1,
                size: 16,
                kind: SymbolKind::Text,
                scope: SymbolScope::Compilation,
                weak: false,
                section: SymbolSection::Section(text),
                flags: SymbolFlags::None,
            })
        });
        for (offset, symbol) in [(4, symbols[1]), (24, symbols[2])].into_iter().filter(|_| with_relocations) {
            let flags = RelocationFlags::Elf { r_type: object::elf::R_ARM_THM_PC22 };
            writer.add_relocation(text, Relocation { offset, symbol, addend: 0, flags }).expect("adds");
        }
        writer.write().expect("writes")
    }

    #[test]
    fn a_panic_is_followed_up_to_the_program() {
        let graph = Graph::read(&program(true)).expect("reads");
        assert!(is_panic(graph.name(32)));
        let [reference] = graph.callers(32) else { panic!("one call of the panic") };
        assert_eq!(graph.name(reference.from), "model_core::middle");
        assert_eq!(graph.way_up(reference), [24, 4]);
    }

    #[test]
    fn a_program_without_relocations_or_symbols_is_refused() {
        let error = Graph::read(&program(false)).err().expect("refused").to_string();
        assert!(error.contains("--emit-relocs"), "{error}");
        assert!(Graph::read(b"no ELF").is_err());
    }
}
