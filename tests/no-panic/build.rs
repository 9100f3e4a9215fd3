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
    let root = Path::new(&manifest).ancestors().nth(2).expect("the crate lies two folders down in the workspace");
    println!("cargo:rustc-link-search={}", root.display());
    // The relocations stay in the ELF, because the check reads from them who calls whom.
    for argument in ["--nmagic", "--emit-relocs", "-Tlink.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
