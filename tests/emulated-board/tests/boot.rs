//! The firmware starts on the emulated board.

use emulated_board::{Board, firmware_elf};

#[test]
fn starts_and_logs_the_same_twice() {
    let elf = firmware_elf().expect("built");
    let start = || {
        let mut board = Board::new(&elf).expect("an ELF for this board");
        board.run_ms(100).expect("runs");
        (board.log_lines(), board.instructions(), board.stack_bytes())
    };
    let first = start();
    assert!(first.0.iter().any(|line| line.contains("started by power")), "{first:?}");
    assert!(first.1 > 10_000 && first.2 > 100, "{first:?}");
    assert_eq!(first, start());
}
