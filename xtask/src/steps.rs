//! Chores of several steps, each announced and timed.

use crate::{
    board_figures, campaign, command, compare, excerpts, firmware, markers, no_panic, paper, pareto, plant, root, run,
    toolchain,
};
use anyhow::{Context, Result, bail, ensure};
use std::ffi::OsString;
use std::fs;
use std::time::Instant;

/// One step: what it is, and how it is done.
type Step = (&'static str, fn() -> Result<()>);

/// Announces, does and times one after the other, up to the first that fails; `done` is said at the end.
fn all(steps: &[Step], done: &str) -> Result<()> {
    let mut times = Vec::new();
    for (index, (name, step)) in steps.iter().enumerate() {
        println!("== {}/{} {name}", index + 1, steps.len());
        let start = Instant::now();
        step().with_context(|| format!("step '{name}' failed"))?;
        let line = format!("  {name:<30}{:>7.1} s", start.elapsed().as_secs_f64());
        println!("{line}");
        times.push(line);
    }
    println!("== {done}\n{}", times.join("\n"));
    Ok(())
}

/// Renews every figure and picture that the documents show, but the exhaustive run's.
pub fn docs() -> Result<()> {
    let steps: [Step; 9] = [
        ("ways to compute the model", || pareto::pareto(false, true)),
        ("the plant's integrators", || plant::plant(true)),
        ("regulators", compare::compare),
        ("the paper's tables", paper::paper),
        ("firmware", || board_figures::figures(false, true)),
        ("the campaign's result", || campaign::campaign(false)),
        ("pictures", pictures),
        ("fault table", faults),
        ("excerpts", excerpts::excerpts),
    ];
    all(&steps, "all renewed")
}

/// All packages but what has no tests: what only a Cortex-M4 runs.
const TESTED: [&str; 5] = ["--workspace", "--exclude", "counted", "--exclude", "no-panic"];

/// Everything that must hold before a change is accepted.
pub fn test() -> Result<()> {
    let steps: [Step; 10] = [
        ("toolchains", || {
            toolchain::set_up_emulator()?;
            // A machine may have no browser, and no way to one: then what needs it is left out, aloud.
            toolchain::set_up_browser().unwrap_or_else(|why| println!("left out: {why:#}"));
            toolchain::set_up().map(|route| println!("{route}"))
        }),
        ("format", || cargo(&["fmt", "--all", "--check"])),
        ("lints", || cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])),
        ("firmware", || {
            firmware::build()?;
            pareto::build()
        }),
        // In one go, so that what they share is built once; alone: `cargo test`, and `cargo test -p` of the others.
        ("tests, host and emulated board", || {
            let without: &[&str] = if toolchain::has_browser() { &[] } else { &["--exclude", "browser"] };
            cargo(&[&["test"][..], &TESTED, without].concat())
        }),
        ("documentation", || {
            run(command("cargo").args(["doc", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-D warnings"))
        }),
        ("no panic path", no_panic::check),
        ("figures against the baselines", || at_once([pareto::gate, plant::gate, board_figures::gate])),
        ("simulator's main job", simulator),
        ("the same on the ELF", || {
            let run = ["run", "--release", "--quiet", "--", "run", "--on", "elf", "--out", "target/xtask-run-elf"];
            cargo(&run)
        }),
    ];
    all(&steps, "all passed")
}

/// Does all at the same time, for each takes one core; the first error in their order counts.
fn at_once(gates: [fn() -> Result<()>; 3]) -> Result<()> {
    std::thread::scope(|scope| {
        let running = gates.map(|gate| scope.spawn(gate));
        running.map(|gate| gate.join().unwrap_or_else(|_| bail!("a gate panicked"))).into_iter().collect()
    })
}

/// The HTML report in a headless Chromium.
pub fn browser() -> Result<()> {
    toolchain::set_up_browser()?;
    cargo(&["test", "--package", "browser"])
}

/// Runs cargo in the workspace.
pub fn cargo(arguments: &[&str]) -> Result<()> {
    run(command("cargo").args(arguments))
}

/// Visits every input of the fixed-point functions, optimised but with every check on.
pub fn exhaustive(arguments: &[OsString]) -> Result<()> {
    let mut cargo = command("cargo");
    cargo.args(["run", "--quiet", "--profile", "exhaustive", "--package", "finger-tests", "--bin", "exhaustive", "--"]);
    run(cargo.args(arguments))
}

/// The README's first command, twice: it works, and the same seed gives the same bytes.
fn simulator() -> Result<()> {
    let folders = ["target/xtask-run-1", "target/xtask-run-2"].map(|folder| root().join(folder));
    for folder in &folders {
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
        let mut cargo = command("cargo");
        cargo.args(["run", "--release", "--quiet", "--", "run", "--seed", "1", "--out"]).arg(folder);
        run(&mut cargo)?;
    }
    let [one, other] = &folders;
    let mut files = 0;
    for entry in fs::read_dir(one)? {
        let name = entry?.file_name();
        let same = fs::read(one.join(&name))? == fs::read(other.join(&name)).unwrap_or_default();
        ensure!(same, "{} differs between two runs with the same seed", name.display());
        files += 1;
    }
    ensure!(files > 0, "the run left no files");
    println!("{files} files, the same bytes twice");
    Ok(())
}

/// Puts the fault table of the code into docs/faults.md.
pub fn faults() -> Result<()> {
    let mut cargo = command("cargo");
    let output = cargo.args(["run", "--quiet", "--package", "finger-tests", "--bin", "faults"]).output()?;
    ensure!(output.status.success(), "the fault table cannot be printed: {}", String::from_utf8_lossy(&output.stderr));
    markers::replace("docs/faults.md", "faults", &String::from_utf8(output.stdout)?)
}

/// Copies pictures of a run and of a calibration to docs/images.
pub fn pictures() -> Result<()> {
    let same = |name: &'static str| (name, name);
    pictures_of(&["run", "--seed", "1"], &["finger.svg", "pressures.svg", "actuation.svg"].map(same))?;
    let calibration = [("fit.svg", "calibration-fit.svg"), ("residuals.svg", "calibration-residuals.svg")];
    pictures_of(&["calibrate", "tests/data/bend-ten-repeats.csv"], &calibration)
}

/// Starts host-sim and copies what it drew: the picture's name there, and here.
fn pictures_of(arguments: &[&str], names: &[(&str, &str)]) -> Result<()> {
    let folder = root().join("target/pictures");
    let mut cargo = command("cargo");
    run(cargo.args(["run", "--release", "--quiet", "--"]).args(arguments).arg("--out").arg(&folder))?;
    let images = root().join("docs/images");
    fs::create_dir_all(&images)?;
    for (from, to) in names {
        fs::copy(folder.join(from), images.join(to)).with_context(|| format!("host-sim left no {from}"))?;
        println!("docs/images/{to}");
    }
    // The same run on the monitor's dashboard, in the middle of its hold.
    let mut cargo = command("cargo");
    let monitor = ["run", "--release", "--quiet", "--", "monitor", "--at", "6.5", "--replay"];
    run(cargo.args(monitor).arg(folder.join("samples.csv")).arg("--snapshot").arg(images.join("monitor.svg")))?;
    println!("docs/images/monitor.svg");
    Ok(())
}
