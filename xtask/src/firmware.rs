//! Builds the firmware and says how much of the chip it takes.

use crate::{elf, image, root, run, toolchain};
use anyhow::{Context, Result, ensure};
use std::fs;

/// The most flash that the firmware may take.
pub const FLASH_LIMIT: u64 = 96 * 1024;
/// The most RAM that it may take, variables and stack.
pub const RAM_LIMIT: u64 = 24 * 1024;

/// Builds and writes the images; returns the ELF and how it was built.
pub fn build() -> Result<(Vec<u8>, toolchain::Route)> {
    let route = toolchain::set_up()?;
    let (mut cargo, folder) = toolchain::cargo_build(route);
    run(cargo.args(["--quiet", "--package", "firmware", "--bin", "firmware"]))?;
    let elf = fs::read(folder.join("firmware")).context("the build left no firmware")?;
    let flat = image::image(&elf)?;
    let out = root().join("target").join("firmware");
    fs::create_dir_all(&out)?;
    fs::write(out.join("firmware.elf"), &elf)?;
    fs::write(out.join("firmware.bin"), &flat.bytes)?;
    fs::write(out.join("firmware.hex"), image::hex(&flat)?)?;
    Ok((elf, route))
}

/// Builds, prints the sizes, and fails when they are over their limits.
pub fn build_and_report(json: bool) -> Result<()> {
    let (bytes, route) = build()?;
    let sizes = image::sizes(&bytes)?;
    let stack = elf::stack_bytes()?;
    if json {
        let report = serde_json::json!({
            "flash_bytes": sizes.flash_bytes,
            "flash_limit_bytes": FLASH_LIMIT,
            "ram_bytes": sizes.ram_bytes,
            "ram_limit_bytes": RAM_LIMIT,
            "stack_bytes": stack,
            "toolchain": route.to_string(),
        });
        println!("{report}");
    } else {
        println!("built with {route}: target/firmware/firmware.elf, .bin, .hex");
        for (name, bytes) in &sizes.sections {
            println!("  {name:<16}{bytes:>9} bytes");
        }
        println!("  {:<16}{:>9} bytes of {FLASH_LIMIT}", "flash", sizes.flash_bytes);
        println!("  {:<16}{:>9} bytes of {RAM_LIMIT}", "RAM", sizes.ram_bytes);
        println!("  {:<16}{stack:>9} bytes at the deepest on the emulated board, of the same limit", "stack");
    }
    ensure!(
        sizes.ram_bytes + stack <= RAM_LIMIT,
        "RAM with stack: {} bytes, over the limit of {RAM_LIMIT}",
        sizes.ram_bytes + stack
    );
    ensure!(sizes.flash_bytes <= FLASH_LIMIT, "flash: {} bytes, over the limit of {FLASH_LIMIT}", sizes.flash_bytes);
    Ok(())
}
