//! A program for the Cortex-M4 that calls every public function of model-core, and nothing else.
//!
//! It is linked, never run: `cargo xtask no-panic` looks in its ELF for the standard library's panic functions. The
//! linker keeps only what can be reached, so that none of them being there shows that no call into model-core can
//! panic. `docs/testing.md` says what this proves and what it does not.
//!
//! ```text
//! cargo xtask no-panic                                     builds it, looks, and tries the positive control
//! cargo test -p finger-tests --test public_functions       it calls everything that model-core offers
//! ```
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]
// A group of calls that nobody calls would prove nothing.
#![deny(dead_code)]

#[cfg(target_os = "none")]
mod calls;
#[cfg(target_os = "none")]
mod derived;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    calls::all();
    derived::all();
    #[cfg(feature = "positive-control")]
    calls::positive_control();
    loop {
        core::hint::spin_loop();
    }
}

/// Where every panic ends: the linked program has this symbol, `rust_begin_unwind`, only when something reaches it.
#[cfg(target_os = "none")]
#[panic_handler]
#[inline(never)]
fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// On a host there is nothing to do.
#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!(
        "error: this program is for the Cortex-M4 and is linked, not run: `cargo xtask no-panic` builds it and checks \
         that no panic can be reached"
    );
    std::process::ExitCode::FAILURE
}
