//! The firmware's figures, measured on its own ELF: `cargo xtask figures`.

use anyhow::{Result, ensure};
use emulated_board::bench::{STOP, SWITCH};
use emulated_board::time::MILLISECOND;
use emulated_board::{Bench, firmware_elf};
use model_core::actuation::{Actuation, Segment};
use model_core::protocol::{LinkCommand, SequenceName};
use model_core::sequence::library;
use std::time::Instant;

/// The most instructions that a control tick may take.
const TICK_LIMIT: u32 = 8000;
/// The longest that the interlock may take.
const LATENCY_LIMIT_US: f64 = 100.0;

/// Cycles of the core clock in a millisecond.
const CYCLES_PER_MS: f64 = 180_000.0;

fn main() -> Result<()> {
    let json = std::env::args().any(|argument| argument == "--json");
    let elf = firmware_elf()?;
    if std::env::args().any(|argument| argument == "--stack") {
        println!("{}", deepest_stack(&elf)?);
        return Ok(());
    }
    let (mut ticks, mut worst_tick, mut stack) = (Vec::new(), 0, 0);
    let (mut busiest, mut instructions, mut milliseconds) = (0, 0, 0_u64);
    let wall = Instant::now();
    for sequence in library::ALL {
        let mut bench = Bench::with_seed(&elf, 1)?;
        bench.ready()?;
        bench.start(sequence.name)?;
        for _ in 0..sequence.duration().0.min(30_000) {
            let before = bench.board.instructions();
            bench.run_ms(1)?;
            let done = bench.board.instructions() - before;
            (busiest, instructions) = (done.max(busiest), instructions + done);
        }
        milliseconds += bench.milliseconds();
        ticks.extend(bench.telemetry.iter().map(|told| f64::from(told.tick_cycles)));
        worst_tick = bench.telemetry.last().map_or(0, |told| told.worst_tick_cycles).max(worst_tick);
        stack = bench.board.stack_bytes().max(stack);
    }
    let real_time = milliseconds as f64 / 1000.0 / wall.elapsed().as_secs_f64();
    let mean_tick = ticks.iter().sum::<f64>() / ticks.len() as f64;
    let mean_load = instructions as f64 / milliseconds as f64 / CYCLES_PER_MS * 100.0;
    let worst_load = busiest as f64 / CYCLES_PER_MS * 100.0;
    let [stop, switch] = [latency_us(&elf, STOP)?, latency_us(&elf, SWITCH)?];
    if json {
        let report = serde_json::json!({
            "control_tick_instructions_mean": mean_tick,
            "control_tick_instructions_worst": worst_tick,
            "control_tick_instructions_limit": TICK_LIMIT,
            "cpu_load_mean_percent": mean_load,
            "cpu_load_worst_percent": worst_load,
            "emergency_stop_latency_us": stop,
            "over_pressure_switch_latency_us": switch,
            "interlock_latency_limit_us": LATENCY_LIMIT_US,
            "stack_bytes": stack,
            "virtual_seconds": milliseconds as f64 / 1000.0,
            "virtual_seconds_per_second": real_time,
        });
        println!("{report}");
    } else {
        println!(
            "{} sequences, {:.0} s of the board's time, a cycle an instruction",
            library::ALL.len(),
            milliseconds as f64 / 1000.0
        );
        println!("  control tick     {mean_tick:>8.0} instructions in the mean, {worst_tick} at the worst");
        println!("  load at 180 MHz  {mean_load:>8.2} % in the mean, {worst_load:.2} % in the busiest millisecond");
        println!("  emergency stop   {stop:>8.2} us at the worst until every coil rests");
        println!("  pressure switch  {switch:>8.2} us at the worst until every coil rests");
        println!("  stack            {stack:>8} bytes at the deepest");
        println!("  emulator         {real_time:>8.1} s of the board's time a second, plant included");
    }
    ensure!(worst_tick <= TICK_LIMIT, "control tick: {worst_tick} instructions, over the limit of {TICK_LIMIT}");
    ensure!(stop.max(switch) <= LATENCY_LIMIT_US, "interlock: slower than {LATENCY_LIMIT_US} us");
    Ok(())
}

/// Deepest stack, bytes, over a run with every kind of request in it.
fn deepest_stack(elf: &[u8]) -> Result<u32> {
    let mut bench = Bench::with_seed(elf, 1)?;
    bench.ready()?;
    let commands = [
        LinkCommand::Identify,
        LinkCommand::Calibrate { segment: Segment::Middle, k: 0, c1: 14 << 24, c2: 1 << 23 },
        LinkCommand::ZeroSensors,
        LinkCommand::Run(SequenceName::try_from("grasp")?),
    ];
    for command in commands {
        bench.ask(&command)?;
    }
    bench.run_ms(4000)?;
    bench.stop_pressed = true;
    bench.run_ms(100)?;
    Ok(bench.board.stack_bytes())
}

/// Longest time from the pin's edge until every coil rests, at forty moments of a tick, the pump running.
fn latency_us(elf: &[u8], pin: emulated_board::Pin) -> Result<f64> {
    let mut worst = 0.0_f64;
    let mut bench = Bench::with_seed(elf, 3)?;
    bench.ready()?;
    for moment in 0..40 {
        let ask = LinkCommand::Setpoints([60 << 16, 30 << 16, 60 << 16]);
        bench.take(&ask)?;
        bench.run_ms(60)?;
        let settle = bench.board.time() + moment * MILLISECOND / 40;
        bench.board.run_until(settle)?;
        ensure!(bench.actuation() != Actuation::SAFE, "nothing is driven");
        worst = worst.max(bench.rest_latency_us(pin)?);
        bench.run_ms(2000)?;
        bench.take(&LinkCommand::ClearFault)?;
    }
    Ok(worst)
}
