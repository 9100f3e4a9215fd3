//! All methods side by side: `cargo xtask pareto`.

use anyhow::{Result, ensure};
use emulated_board::pareto::{Direction, Figures, FunctionCost, cossin, four_digits, functions, measure};
use emulated_board::{Counted, Footprint, counted_elf};
use host_sim::pareto::inverse::{Report, measure as measure_on_host};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

/// `f32-newton-native`'s square root on the host.
type Root = model_core::methods::StdRoot;

macro_rules! measure_all {
    ($($id:ident: $method:ty;)*) => {
        const METHODS: usize = [$(stringify!($id)),*].len();

        fn all(counted: &mut Counted, footprint: &Footprint, host: &Report, bar: &ProgressBar) -> Result<Vec<Figures>> {
            let mut figures = Vec::new();
            $(
                bar.set_message(stringify!($id));
                figures.extend(measure::<$method>(stringify!($id), counted, footprint, host)?);
                bar.inc(1);
            )*
            Ok(figures)
        }
    };
}

model_core::for_each_method!(measure_all);

fn main() -> Result<()> {
    let json = std::env::args().any(|argument| argument == "--json");
    let elf = counted_elf()?;
    let (mut counted, footprint) = (Counted::new(&elf)?, Footprint::new(&elf)?);
    let host = measure_on_host();
    let bar = ProgressBar::new(METHODS as u64);
    bar.set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")?);
    let figures = all(&mut counted, &footprint, &host, &bar)?;
    let cossin = cossin(&mut counted)?;
    let functions = functions(&mut counted, &footprint)?;
    bar.finish_and_clear();
    if json {
        let reference = json!({
            "function": "idsp::cossin",
            "max_error_full_scale": four_digits(cossin.max_error_full_scale),
            "max_error_own_scale": four_digits(cossin.max_error_own_scale),
            "instructions_cortex_m4_mean": (cossin.instructions_mean * 10.0).round() / 10.0,
            "instructions_cortex_m4_worst": cossin.instructions_worst,
            "flash_code_bytes": footprint.of("cossin")?.code,
            "flash_table_bytes": footprint.of("cossin")?.tables,
        });
        let methods: Vec<_> = figures.iter().map(Figures::to_json).collect();
        let references: Vec<_> = [reference].into_iter().chain(functions.iter().map(FunctionCost::to_json)).collect();
        println!("{}", serde_json::to_string_pretty(&json!({ "methods": methods, "references": references }))?);
    } else {
        for direction in Direction::BOTH {
            table(direction, &figures);
        }
        println!(
            "idsp::cossin: {:.1} instructions in the mean, {} at the worst, worst error {:.1e} of 2^31, {:.1e} of its \
             own amplitude",
            cossin.instructions_mean,
            cossin.instructions_worst,
            cossin.max_error_full_scale,
            cossin.max_error_own_scale
        );
        for FunctionCost { function, calls, instructions_mean, instructions_worst, flash, .. } in &functions {
            println!(
                "{function}: {instructions_mean:.1} instructions in the mean, {instructions_worst} at the worst of {calls} \
                 calls, {} bytes of code and {} of tables",
                flash.code, flash.tables
            );
        }
    }
    for figure in &figures {
        if let Some(first) = &figure.cost.first_difference {
            let (method, direction) = (figure.method, figure.direction.name());
            eprintln!("{method} {direction}: {} of {} differ, first {first}", figure.cost.differ, figure.cost.calls);
        }
    }
    let fixed_differ = figures.iter().any(|figure| figure.representation == "fixed" && figure.cost.differ > 0);
    let functions_differ = functions.iter().any(|function| function.differ > 0);
    ensure!(
        !fixed_differ && !functions_differ && cossin.differ == 0,
        "fixed-point results differ between the emulated core and the host"
    );
    Ok(())
}

fn table(direction: Direction, figures: &[Figures]) {
    let unit = match direction {
        Direction::Bend => "degrees",
        Direction::Pressure => "kPa",
    };
    println!(
        "{}: errors in {unit}, time on the host over f64-newton's, instructions on the Cortex-M4, bytes",
        direction.name()
    );
    println!(
        "  {:<24}{:>10}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}{:>10}{:>7}{:>7}{:>6}",
        "method",
        "0-150 kPa",
        "any cal.",
        "domain",
        "any cal.",
        "host",
        "mean",
        "worst",
        "beyond",
        "prepare",
        "code",
        "tables",
        "RAM"
    );
    for figure in figures.iter().filter(|figure| figure.direction == direction) {
        let Figures { host, cost, flash, .. } = figure;
        println!(
            "  {:<24}{:>10.2e}{:>10.2e}{:>10.2e}{:>10.2e}{:>8.2}{:>8.0}{:>8}{:>8}{:>10}{:>7}{:>7}{:>6}",
            figure.method,
            host.errors.max_working,
            host.worst_errors.max_working,
            host.errors.max,
            host.worst_errors.max,
            host.host_time_ratio,
            cost.mean,
            cost.worst_working,
            cost.worst,
            cost.prepare_worst,
            flash.code,
            flash.tables,
            figure.ram_bytes
        );
    }
}
