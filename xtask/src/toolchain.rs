//! Which toolchain builds for the Cortex-M4 here.
//!
//! 1. The pinned toolchain has the target's library: plain cargo.
//! 2. rustup can add it: plain cargo afterwards.
//! 3. Debian's own rustc comes with the library's source, and builds it for the target; as root it is installed.
//! 4. Otherwise one line says what to install.

use crate::{command, run};
use anyhow::{Result, bail};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The target of the STM32F446RE: Cortex-M4 with FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// What the workspace's folder is called in the files built for it.
pub const WORKSPACE: &str = "finger";

/// What Debian packages the third route needs.
const PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];

/// What Debian packages the emulated board's engine is built with.
const EMULATOR_PACKAGES: [&str; 5] = ["cmake", "make", "gcc", "libc6-dev", "libclang-14-dev"];

/// What Debian package has the browser.
const BROWSER_PACKAGE: &str = "chromium";

/// A way to build for the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// The pinned toolchain.
    Rustup,
    /// Debian's rustc, building the core library from source.
    Debian,
}

impl fmt::Display for Route {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Rustup => "the pinned toolchain with rustup's target library",
            Self::Debian => "Debian's rustc with the core library from source",
        })
    }
}

/// What was found on this machine.
#[derive(Clone, Copy, Debug)]
struct Facts {
    target_library: bool,
    debian_rustc: bool,
    apt_as_root: bool,
}

/// What to do next.
#[derive(Debug, PartialEq, Eq)]
enum Decision {
    Use(Route),
    InstallFromDebian,
    GiveUp,
}

/// Pure, so that every case can be tested anywhere.
fn decide(facts: Facts) -> Decision {
    match facts {
        Facts { target_library: true, .. } => Decision::Use(Route::Rustup),
        Facts { debian_rustc: true, .. } => Decision::Use(Route::Debian),
        Facts { apt_as_root: true, .. } => Decision::InstallFromDebian,
        _ => Decision::GiveUp,
    }
}

/// Finds a route, installing what is missing where that can be done.
pub fn set_up() -> Result<Route> {
    if !target_library() {
        // Its failure is no error yet: Debian's packages may do.
        let added = command("rustup").args(["target", "add", TARGET]).output();
        if added.is_ok_and(|output| output.status.success()) && target_library() {
            return Ok(Route::Rustup);
        }
    }
    match decide(facts()) {
        Decision::Use(route) => Ok(route),
        Decision::InstallFromDebian => {
            install(&PACKAGES)?;
            match decide(facts()) {
                Decision::Use(route) => Ok(route),
                _ => bail!("Debian's packages {} are installed, but /usr/bin/rustc has no source", PACKAGES.join(", ")),
            }
        }
        Decision::GiveUp => bail!(
            "no library for {TARGET}: run `rustup target add {TARGET}`, or on Debian as root `apt-get install {}`",
            PACKAGES.join(" ")
        ),
    }
}

/// Finds what the emulated board's engine is built with, a C compiler, `CMake` and libclang, installing what is missing
/// where that can be done.
pub fn set_up_emulator() -> Result<()> {
    if runs("cmake") && runs("cc") && libclang() {
        return Ok(());
    }
    if !apt_as_root() {
        bail!(
            "the emulated board needs a C compiler, CMake and libclang: on Debian as root `apt-get install {}`",
            EMULATOR_PACKAGES.join(" ")
        );
    }
    install(&EMULATOR_PACKAGES)
}

/// Whether a program is there: it tells its version.
fn runs(program: &str) -> bool {
    command(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Whether there is a Chromium where the tests of the report look for it.
pub fn has_browser() -> bool {
    let named = std::env::var("CHROME").is_ok_and(|program| runs(&program));
    named || ["google-chrome-stable", "chromium", "chromium-browser"].into_iter().any(runs)
}

/// Finds Chromium, in which the report is tested, installing it where that can be done.
///
/// # Errors
/// When there is none, and none can be installed.
pub fn set_up_browser() -> Result<()> {
    if has_browser() {
        return Ok(());
    }
    if !apt_as_root() {
        bail!(
            "the report is tested in Chromium, which is not here: on Debian as root `apt-get install {BROWSER_PACKAGE}`, or name a \
             Chromium in the variable CHROME"
        );
    }
    install(&[BROWSER_PACKAGE])
}

/// Where bindgen would find it: named by the user, or in Debian's folders.
fn libclang() -> bool {
    let holds = |folder: PathBuf| {
        let mut entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.any(|entry| entry.file_name().to_string_lossy().starts_with("libclang"))
    };
    let versions = std::fs::read_dir("/usr/lib").into_iter().flatten().flatten().map(|entry| entry.path());
    let mut llvm = versions.filter(|path| path.to_string_lossy().contains("/llvm-")).map(|path| path.join("lib"));
    std::env::var_os("LIBCLANG_PATH").is_some_and(|path| holds(path.into())) || llvm.any(holds)
}

fn install(packages: &[&str]) -> Result<()> {
    println!("installing {} (Debian)", packages.join(", "));
    run(command("apt-get").args(["update", "-qq"]))?;
    run(command("apt-get")
        .args(["install", "-qq", "-y", "--no-install-recommends"])
        .args(packages)
        .env("DEBIAN_FRONTEND", "noninteractive"))
}

fn apt_as_root() -> bool {
    Path::new("/usr/bin/apt-get").exists() && is_root()
}

fn facts() -> Facts {
    Facts { target_library: target_library(), debian_rustc: debian_rustc(), apt_as_root: apt_as_root() }
}

/// Whether the pinned toolchain has the target's library. rustup's own list is no proof: it names what the toolchain
/// file asks for.
fn target_library() -> bool {
    let Some(sysroot) = sysroot("rustc") else { return false };
    sysroot.join("lib/rustlib").join(TARGET).join("lib").is_dir()
}

fn debian_rustc() -> bool {
    let tools = ["/usr/bin/rustc", "/usr/bin/cargo"].iter().all(|tool| Path::new(tool).exists());
    let source = sysroot("/usr/bin/rustc").map(|root| root.join("lib/rustlib/src/rust/library/core"));
    tools && source.is_some_and(|path| path.exists())
}

fn sysroot(rustc: &str) -> Option<PathBuf> {
    let output = command(rustc).args(["--print", "sysroot"]).output().ok()?;
    output.status.success().then(|| PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()))
}

fn is_root() -> bool {
    let id = command("id").arg("-u").output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

/// A `cargo build` for the target, and where it puts its files.
pub fn cargo_build(route: Route) -> (Command, PathBuf) {
    // A folder of its own: two compilers' files do not mix.
    cargo_build_of(route, &crate::root(), &crate::root().join("target").join("thumb"))
}

/// The same of the sources in `root`, into `folder`. The files do not depend on where either lies.
pub fn cargo_build_of(route: Route, root: &Path, folder: &Path) -> (Command, PathBuf) {
    let mut cargo = match route {
        Route::Rustup => command("cargo"),
        Route::Debian => {
            let mut cargo = command("/usr/bin/cargo");
            // rustup's variables would take the build back to its own compiler.
            for name in ["RUSTUP_TOOLCHAIN", "RUSTC_WRAPPER", "RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS"] {
                cargo.env_remove(name);
            }
            let mut path = vec![PathBuf::from("/usr/bin")];
            // The link step asks for `rust-lld`: rustup's copy, or Debian's lld under its own name.
            let lld = sysroot("rustc").map(|root| root.join("lib/rustlib/x86_64-unknown-linux-gnu/bin"));
            match lld.filter(|folder| folder.join("rust-lld").exists()) {
                Some(folder) => path.push(folder),
                None => {
                    cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld");
                }
            }
            path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
            if let Ok(path) = std::env::join_paths(path) {
                cargo.env("PATH", path);
            }
            cargo.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
            cargo
        }
    };
    cargo.current_dir(root);
    cargo.args(["build", "--release", "--target", TARGET, "--target-dir"]).arg(folder);
    // Debug information and panics name source files.
    let flags = remapped(root, folder).map(|(from, to)| format!("--remap-path-prefix={}={to}", from.display()));
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}"));
    if route == Route::Debian {
        cargo.arg("-Zbuild-std=core,alloc");
    }
    // Without it nothing is logged.
    cargo.env("DEFMT_LOG", std::env::var("DEFMT_LOG").unwrap_or_else(|_| "info".into()));
    (cargo, folder.join(TARGET).join("release"))
}

/// The compiler's version, as it says it.
pub fn compiler(route: Route) -> Result<String> {
    let rustc = match route {
        Route::Rustup => "rustc",
        Route::Debian => "/usr/bin/rustc",
    };
    let output = command(rustc).arg("--version").output()?;
    anyhow::ensure!(output.status.success(), "{rustc} does not say its version");
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Folders that differ from one machine to the next, and what the firmware's files have instead.
fn remapped(root: &Path, folder: &Path) -> [(PathBuf, &'static str); 3] {
    let home = |name: &str, default: &str| {
        let user = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(default));
        std::env::var_os(name).map(PathBuf::from).or_else(user)
    };
    let registry = home("CARGO_HOME", ".cargo").unwrap_or_else(|| "/nowhere".into());
    // The last that fits counts: the build's folder, with what build scripts have written, mostly lies in the workspace.
    [(registry, "cargo"), (root.to_path_buf(), WORKSPACE), (folder.to_path_buf(), "target")]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_route_wins() {
        for bits in 0..8_u8 {
            let [target_library, debian_rustc, apt_as_root] = [1, 2, 4].map(|bit| bits & bit != 0);
            let expected = if target_library {
                Decision::Use(Route::Rustup)
            } else if debian_rustc {
                Decision::Use(Route::Debian)
            } else if apt_as_root {
                Decision::InstallFromDebian
            } else {
                Decision::GiveUp
            };
            assert_eq!(decide(Facts { target_library, debian_rustc, apt_as_root }), expected);
        }
    }

    #[test]
    fn no_folder_of_this_machine_stays_in_what_is_built() {
        for route in [Route::Rustup, Route::Debian] {
            let (cargo, _) = cargo_build_of(route, Path::new("/a clone"), Path::new("/a clone/target/thumb"));
            assert_eq!(cargo.get_current_dir(), Some(Path::new("/a clone")));
            let flags =
                cargo.get_envs().find(|(name, _)| *name == "CARGO_ENCODED_RUSTFLAGS").and_then(|(_, value)| value);
            let flags = flags.expect("set").to_string_lossy().into_owned();
            let flags: Vec<_> = flags.split('\u{1f}').collect();
            let [registry, root, folder] = flags.as_slice() else { panic!("{flags:?}") };
            assert!(registry.starts_with("--remap-path-prefix=") && registry.ends_with("=cargo"), "{registry}");
            assert_eq!(*root, "--remap-path-prefix=/a clone=finger");
            // After the workspace's, because it lies within.
            assert_eq!(*folder, "--remap-path-prefix=/a clone/target/thumb=target");
        }
    }

    #[test]
    fn only_debians_compiler_builds_the_library() {
        let arguments = |route| -> Vec<String> {
            cargo_build(route).0.get_args().map(|argument| argument.to_string_lossy().into_owned()).collect()
        };
        assert!(arguments(Route::Debian).iter().any(|argument| argument.starts_with("-Zbuild-std")));
        assert!(!arguments(Route::Rustup).iter().any(|argument| argument.starts_with("-Z")));
    }
}
