//! Linker arguments for the board; none on the host.

use std::env;
use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=../../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // memory.x lies at the workspace's root, which is not where the linker runs.
    let manifest = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let root = Path::new(&manifest).ancestors().nth(2).expect("the crate lies in tests/ of the workspace");
    println!("cargo:rustc-link-search={}", root.display());
    // The relocations say who reaches what.
    for argument in ["--nmagic", "-Tlink.x", "--emit-relocs"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
