//! Calibration and zeros survive the loss of power, at whatever flash operation it comes.

use emulated_board::{Bench, Halt, firmware_elf};
use model_core::actuation::Segment;
use model_core::protocol::{LinkCommand, Report};

const OLD: [i32; 3] = [1 << 24, 12 << 24, 1 << 22];
const NEW: [i32; 3] = [3 << 24, 15 << 24, 1 << 23];

fn calibrate([k, c1, c2]: [i32; 3]) -> LinkCommand {
    LinkCommand::Calibrate { segment: Segment::Middle, k, c1, c2 }
}

fn coefficients(bench: &mut Bench) -> [i32; 3] {
    match bench.ask(&LinkCommand::Identify).expect("answers") {
        Report::Identity(identity) => identity.coefficients[Segment::Middle as usize],
        other => panic!("{other:?}"),
    }
}

/// What the flash holds after `saves` calibrations, the last with [`OLD`].
fn flash_after(elf: &[u8], saves: i32) -> Vec<u8> {
    let mut bench = Bench::with_seed(elf, 1).expect("starts");
    bench.ready().expect("passes its self test");
    for left in (0..saves).rev() {
        bench.take(&calibrate([OLD[0] + left, OLD[1], OLD[2]])).expect("taken");
    }
    bench.board.settings().to_vec()
}

#[test]
fn a_power_cut_at_every_flash_operation_leaves_the_old_settings_or_the_new() {
    let elf = firmware_elf().expect("built");
    // One record before; and a sector full of them, so that the next one has to erase the other.
    for (saves, erases) in [(1, false), (2048, true)] {
        let before = flash_after(&elf, saves);
        let mut operation = 1;
        let mut kept = [0, 0];
        loop {
            let mut bench = Bench::with_settings(&elf, 1, before.clone()).expect("starts");
            bench.ready().expect("passes its self test");
            assert_eq!(coefficients(&mut bench), OLD);
            bench.board.cut_power_at(bench.board.flash_operations() + operation);
            bench.request(calibrate(NEW));
            // Erasing takes a second.
            let cut = (0..1100).find_map(|_| bench.step().expect("goes on"));
            let after = bench.board.settings().to_vec();
            let mut again = Bench::with_settings(&elf, 1, after).expect("starts");
            again.run_ms(20).expect("runs");
            let found = coefficients(&mut again);
            assert!([OLD, NEW].contains(&found), "operation {operation}: {found:?}");
            let Some(halt) = cut else {
                // Past the last operation: all of it was written.
                assert_eq!(found, NEW);
                break;
            };
            assert_eq!(halt, Halt::PowerCut);
            kept[usize::from(found == NEW)] += 1;
            operation += 1;
        }
        // A record is sixteen words.
        assert_eq!(operation - 1, 16 + u32::from(erases), "operations of one save");
        println!("{saves} records before: {} cuts left the old settings, {} the new", kept[0], kept[1]);
    }
}
