//! Counting on the emulated core: what it counts, what it refuses, and what the flash figures are made of.

use emulated_board::counted::{Arguments, Counted, Trace, counted_elf};
use emulated_board::footprint::Footprint;
use emulated_board::pareto::{Cost, costs, passed, prepare, room};
use model_core::calibration::DEFAULT;
use model_core::methods::{Method, Quantity};

/// `f32-newton-native`'s square root on the host.
type Root = model_core::methods::StdRoot;

/// A function of the ELF with arguments.
type Call = (String, Arguments);

macro_rules! all_methods {
    ($($id:ident: $method:ty;)*) => {
        /// Calls of every method, prepared, in both directions.
        fn calls(counted: &mut Counted) -> Vec<Call> {
            let mut calls = vec![("cossin".to_owned(), Arguments { core: [1 << 20, 0, 0, 0], float: 0 })];
            $(calls.extend(calls_of::<$method>(stringify!($id), counted));)*
            calls
        }

        /// Identifier, bend, pressure.
        fn against_the_host(counted: &mut Counted) -> Vec<(&'static str, [Cost; 2])> {
            vec![$((stringify!($id), costs::<$method>(stringify!($id), counted).expect("runs").0)),*]
        }
    };
}

model_core::for_each_method!(all_methods);

fn loaded() -> Counted {
    Counted::new(&counted_elf().expect("built")).expect("an ELF for this core")
}

fn calls_of<M: Method>(id: &str, counted: &mut Counted) -> Vec<Call> {
    let state = room(id, counted).expect("room").0;
    prepare(id, counted, state, &DEFAULT).expect("runs");
    let pressures = [0.0, 1.0 / 65_536.0, 0.0625, 77.125, 150.0, 1000.0, 2000.0, -1.0].map(M::Pressure::from_f64);
    let bends = [0.0, 1.0 / 65_536.0, 1.5, 71.0, 112.0, 170.0, 200.0].map(M::Bend::from_f64);
    let bend = pressures.into_iter().map(|pressure| (format!("bend_{id}"), passed(state, pressure)));
    bend.chain(bends.into_iter().map(|bend| (format!("pressure_{id}"), passed(state, bend)))).collect()
}

/// The instructions of a trace by a way of its own: where one that cannot branch is not followed by its neighbour, the
/// trace has a gap, of instructions that an IT block skipped or that the engine did not tell of.
fn count(counted: &Counted, trace: &Trace) -> u64 {
    let halfword = |address| counted.halfword(address).expect("flash");
    let length = |address| if halfword(address) >> 11 >= 0b11101 { 4 } else { 2 };
    let branches = |address| {
        let (first, second) = (halfword(address), halfword(address + 2));
        match first >> 11 {
            // B with condition, B, BX and BLX, CBZ and CBNZ, POP with the PC.
            0b11010..=0b11100 => true,
            0b01000 => first & 0xFF00 == 0x4700,
            0b10110 | 0b10111 => first & 0xF500 == 0xB100 || first & 0xFF00 == 0xBD00,
            // B.W and BL; LDM with the PC; LDR to the PC; TBB and TBH.
            0b11110 => second & 0x8000 != 0,
            0b11101 => first & 0xFE50 == 0xE810 && second & 0x8000 != 0 || first & 0xFFF0 == 0xE8D0,
            0b11111 => first & 0xFF70 == 0xF850 && second >> 12 == 0xF,
            _ => false,
        }
    };
    let mut sum = trace.instructions.len() as u64;
    for pair in trace.instructions.windows(2).filter(|pair| !branches(pair[0])) {
        let mut at = pair[0] + length(pair[0]);
        while at != pair[1] {
            assert!(at < pair[1], "from {:#010x} to {:#010x}", pair[0], pair[1]);
            at += length(at);
            sum += 1;
        }
    }
    sum
}

#[test]
fn blocks_count_what_single_steps_count_and_all_of_it_is_in_the_footprint() {
    let footprint = Footprint::new(&counted_elf().expect("built")).expect("linked with relocations");
    let mut counted = loaded();
    for (symbol, arguments) in calls(&mut counted) {
        let function = counted.function(&symbol).expect("exported");
        let quick = counted.call(function, &arguments).expect("runs");
        let again = counted.call(function, &arguments).expect("runs");
        let trace = counted.trace(function, &arguments).expect("runs");
        assert_eq!(quick.instructions, count(&counted, &trace), "{symbol}: {arguments:?}");
        assert_eq!(quick, again, "{symbol}: {arguments:?}");
        let touched = trace.instructions.iter().chain(&trace.reads).copied();
        let outside = footprint.first_outside(&symbol, touched).expect("a function");
        assert_eq!(outside, None, "{symbol}: {arguments:?}");
    }
}

#[test]
fn core_and_host_agree_to_the_last_bit() {
    let mut counted = loaded();
    for (id, costs) in against_the_host(&mut counted) {
        for cost in costs {
            assert!(cost.calls > 4000, "{id}");
            assert_eq!(cost.differ, 0, "{id}: {:?}", cost.first_difference);
        }
    }
}

#[test]
fn trouble_is_named() {
    let mut counted = loaded();
    let state = room("fixed_newton", &mut counted).expect("room").0;
    prepare("fixed_newton", &mut counted, state, &DEFAULT).expect("runs");
    let bend = counted.function("bend_fixed_newton").expect("exported");
    // A state where there is no memory.
    let call = counted.call(bend, &Arguments { core: [0x4000_0000, 65_536, 0, 0], float: 0 });
    let message = call.expect_err("nothing is there").to_string();
    assert!(message.contains("0x40000000") && message.contains("READ"), "{message}");
    // The core is none the worse for it.
    counted.call(bend, &Arguments { core: [state, 65_536, 0, 0], float: 0 }).expect("runs");
    // `HardFault_` loops for ever.
    counted.set_limit(1_000_000);
    let stuck = counted.function("HardFault_").expect("cortex-m-rt's");
    let message = counted.call(stuck, &Arguments::default()).expect_err("never returns").to_string();
    assert!(message.contains("no return"), "{message}");
    assert!(counted.function("bend_nothing").is_err());
    assert!(counted.room(1 << 20, 4).is_err());
    // c1 below 5 kPa.
    let refuses = counted.function("prepare_fixed_newton").expect("exported");
    let outcome = counted.call(refuses, &Arguments { core: [state, 0, 1 << 24, 0], float: 0 }).expect("runs");
    assert_eq!(outcome.core[0], 0);
}
