//! Counting on the emulated core: what it counts, what it refuses, and what the flash figures are made of.

use emulated_board::counted::{Arguments, Counted, Function, Trace, counted_elf};
use emulated_board::footprint::Footprint;
use emulated_board::pareto::{Cost, Direction, cost};

const DEFAULT: [u32; 3] = [0, 13 << 24, 1 << 22];

fn prepared() -> (Counted, u32) {
    let mut counted = Counted::new(&counted_elf().expect("built")).expect("an ELF for this core");
    let layout = counted.function("layout_fixed_newton").expect("exported");
    let [bytes, alignment] = counted.call(layout, &Arguments::default()).expect("runs").core;
    let state = counted.room(bytes, alignment).expect("room");
    let prepare = counted.function("prepare_fixed_newton").expect("exported");
    let [k, c1, c2] = DEFAULT;
    let admitted = counted.call(prepare, &Arguments { core: [state, k, c1, c2], float: 0 }).expect("runs");
    assert_eq!(admitted.core[0], 1);
    (counted, state)
}

/// Every function of the ELF that is called here, with an argument for r1.
fn calls(counted: &Counted) -> Vec<(&'static str, Function, u32)> {
    let pressures = [0, 1, 2, 100, 65_536, 5_000_000, 9_830_400, 65_536_000, u32::MAX];
    let bends = [0, 1, 70_000, 3_000_000, 11_141_120];
    let with = |symbol, values: &[u32]| {
        let function = counted.function(symbol).expect("exported");
        values.iter().map(move |&value| (symbol, function, value)).collect::<Vec<_>>()
    };
    [with("bend_fixed_newton", &pressures), with("pressure_fixed_newton", &bends), with("cossin", &[0, 1 << 20])]
        .concat()
}

/// How many instructions IT blocks have skipped: the emulator's single steps leave them out.
fn skipped(counted: &Counted, trace: &Trace) -> u64 {
    let halfword = |address| counted.halfword(address).expect("flash");
    let mut skipped = 0;
    for (index, &address) in trace.instructions.iter().enumerate() {
        // IT: 1011 1111, condition, mask; the mask's lowest one says how many instructions follow, 1 to 4.
        let mask = halfword(address) & 0xF;
        if halfword(address) & 0xFF00 != 0xBF00 || mask == 0 {
            continue;
        }
        let (mut at, mut done) = (address + 2, trace.instructions[index + 1..].iter().peekable());
        for _ in 0..4 - mask.trailing_zeros() {
            if done.next_if(|&&next| next == at).is_none() {
                skipped += 1;
            }
            at += if halfword(at) >> 11 >= 0b11101 { 4 } else { 2 };
        }
    }
    skipped
}

#[test]
fn blocks_count_what_single_steps_count() {
    let (mut counted, state) = prepared();
    for (symbol, function, value) in calls(&counted) {
        let arguments = Arguments { core: [state, value, 0, 0], float: 0 };
        let quick = counted.call(function, &arguments).expect("runs");
        let again = counted.call(function, &arguments).expect("runs");
        let trace = counted.trace(function, &arguments).expect("runs");
        let skipped = skipped(&counted, &trace);
        assert_eq!(quick.instructions, trace.instructions.len() as u64 + skipped, "{symbol} of {value}");
        assert_eq!(quick, again, "{symbol} of {value}");
    }
}

#[test]
fn whatever_runs_and_is_read_is_in_the_footprint() {
    let footprint = Footprint::new(&counted_elf().expect("built")).expect("linked with relocations");
    let (mut counted, state) = prepared();
    for (symbol, function, value) in calls(&counted) {
        let trace = counted.trace(function, &Arguments { core: [state, value, 0, 0], float: 0 }).expect("runs");
        for address in trace.instructions.iter().chain(&trace.reads) {
            assert!(footprint.covers(symbol, *address).expect("a function"), "{symbol} of {value}: {address:#010x}");
        }
    }
}

macro_rules! all_methods {
    ($($id:ident: $method:ty;)*) => {
        /// Identifier, direction, calls, calls that differ from the host, the first of these.
        fn against_the_host(counted: &mut Counted) -> Vec<(&'static str, Direction, Cost)> {
            let mut found = Vec::new();
            for direction in Direction::BOTH {
                $(found.push((stringify!($id), direction, cost::<$method>(stringify!($id), direction, counted).expect("runs").0));)*
            }
            found
        }
    };
}

model_core::for_each_method!(all_methods);

#[test]
fn core_and_host_agree_to_the_last_bit() {
    let mut counted = Counted::new(&counted_elf().expect("built")).expect("an ELF for this core");
    for (id, direction, cost) in against_the_host(&mut counted) {
        assert!(cost.calls > 4000, "{id}");
        assert_eq!(cost.differ, 0, "{id} {}: {:?}", direction.name(), cost.first_difference);
    }
}

#[test]
fn trouble_is_named() {
    let (mut counted, state) = prepared();
    let bend = counted.function("bend_fixed_newton").expect("exported");
    // A state where there is no memory.
    let call = counted.call(bend, &Arguments { core: [0x4000_0000, 65_536, 0, 0], float: 0 });
    let message = call.expect_err("nothing is there").to_string();
    assert!(message.contains("0x40000000") && message.contains("READ"), "{message}");
    // The core is none the worse for it.
    counted.call(bend, &Arguments { core: [state, 65_536, 0, 0], float: 0 }).expect("runs");
    // `HardFault_` loops for ever.
    let stuck = counted.function("HardFault_").expect("cortex-m-rt's");
    let message = counted.call(stuck, &Arguments::default()).expect_err("never returns").to_string();
    assert!(message.contains("no return"), "{message}");
    assert!(counted.function("bend_nothing").is_err());
    assert!(counted.room(1 << 20, 4).is_err());
}
