//! The functions that the emulator calls.
//!
//! For a method with the identifier `id` in `for_each_method!`:
//!
//! | Symbol | Arguments | Returns |
//! |---|---|---|
//! | `layout_id` | none | bytes of the state in r0, its alignment in r1 |
//! | `prepare_id` | state in r0; k, c1, c2 in r1-r3, 2⁻²⁴ kPa | 1, or 0 for coefficients that are not admitted |
//! | `bend_id` | state in r0; kPa in r1, s0 or d0 | degrees in r0, s0 or d0 |
//! | `pressure_id` | state in r0; degrees | kPa |
//!
//! Fixed-point numbers travel in core registers, floats in the FPU's (AAPCS, hard-float variant).

use core::hint::black_box;
use fixed::types::I8F24;
use model_core::force::finger_force;
use model_core::kinematics::{self, Chain, Point, micromath};
use model_core::methods::Method;
use model_core::units::{Bend, Coefficients, Length, Pressure};

/// The FPU's own square root. `core` has none yet, and inline assembly has no register class for an FPU of single
/// precision, so that it costs a call and a return: three instructions.
struct Root;

impl model_core::methods::SquareRoot for Root {
    fn sqrt(x: f32) -> f32 {
        square_root(x)
    }
}

/// x in s0, its root in s0.
#[unsafe(naked)]
extern "C" fn square_root(x: f32) -> f32 {
    core::arch::naked_asm!("vsqrt.f32 s0, s0", "bx lr")
}

/// An address that keeps its function in the ELF.
#[expect(dead_code, reason = "that it is there is its use")]
struct Kept(*const ());

// SAFETY: the address of a function, which nothing writes to.
unsafe impl Sync for Kept {}

macro_rules! export {
    ($($id:ident: $method:ty;)*) => {
        $(
            mod $id {
                #[allow(unused_imports, reason = "some methods are generic over what lies here")]
                use super::*;

                type M = $method;

                #[unsafe(export_name = concat!("layout_", stringify!($id)))]
                #[inline(never)]
                pub extern "C" fn layout() -> u64 {
                    (align_of::<M>() as u64) << 32 | size_of::<M>() as u64
                }

                #[unsafe(export_name = concat!("prepare_", stringify!($id)))]
                #[inline(never)]
                pub extern "C" fn prepare(state: *mut M, k: i32, c1: i32, c2: i32) -> u32 {
                    let [k, c1, c2] = [k, c1, c2].map(I8F24::from_bits);
                    let Ok(coefficients) = Coefficients::new(k, c1, c2) else { return 0 };
                    // SAFETY: the emulator passes room of this size and alignment that nothing else uses.
                    unsafe { state.write(M::prepare(&coefficients)) };
                    1
                }

                #[unsafe(export_name = concat!("bend_", stringify!($id)))]
                #[inline(never)]
                pub extern "C" fn bend(state: *const M, pressure: <M as Method>::Pressure) -> <M as Method>::Bend {
                    // SAFETY: the emulator passes a state that `prepare` has written.
                    unsafe { &*state }.bend_from_pressure(pressure)
                }

                #[unsafe(export_name = concat!("pressure_", stringify!($id)))]
                #[inline(never)]
                pub extern "C" fn pressure(state: *const M, bend: <M as Method>::Bend) -> <M as Method>::Pressure {
                    // SAFETY: as above.
                    unsafe { &*state }.pressure_from_bend(bend)
                }
            }
        )*

        static KEPT: &[Kept] = &[
            Kept(cossin as *const ()),
            Kept(fingertip as *const ()),
            Kept(fingertip_micromath as *const ()),
            Kept(bends as *const ()),
            Kept(force as *const ()),
            $(
                Kept($id::layout as *const ()),
                Kept($id::prepare as *const ()),
                Kept($id::bend as *const ()),
                Kept($id::pressure as *const ()),
            )*
        ];
    };
}

model_core::for_each_method!(export);

/// The reference for what a function costs that does as little as can be asked: idsp's sine and cosine by table and
/// one interpolation. Cosine in r0, sine in r1, 2⁻³¹ of full scale.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn cossin(phase: i32) -> u64 {
    let (cos, sin) = idsp::cossin(phase);
    pair(cos, sin)
}

/// In r0 and r1.
fn pair(one: i32, other: i32) -> u64 {
    u64::from(other.cast_unsigned()) << 32 | u64::from(one.cast_unsigned())
}

/// The fingertip of the paper's finger with these bends, 2⁻¹⁶ degrees: x in r0, y in r1, 2⁻¹⁶ mm.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn fingertip(proximal: i32, middle: i32, distal: i32) -> u64 {
    let bends = [proximal, middle, distal].map(Bend::from_bits);
    let Point { x, y } = kinematics::fingertip(&Chain::PAPER, &bends).point;
    pair(x.to_bits(), y.to_bits())
}

/// The same in f32: bits of x and y in mm.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn fingertip_micromath(proximal: i32, middle: i32, distal: i32) -> u64 {
    let bends = [proximal, middle, distal].map(Bend::from_bits);
    let tip = micromath::fingertip(&Chain::PAPER, &bends);
    pair(tip.x_mm.to_bits().cast_signed(), tip.y_mm.to_bits().cast_signed())
}

/// The bends that bring that fingertip to x and y, 2⁻¹⁶ mm, or nearest to it, from three bends of `from`: the proximal one in r0, the
/// others in r1 as middle + 3 distal, wrapped.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn bends(x: i32, y: i32, from: i32) -> u64 {
    let [x, y] = [x, y].map(Length::from_bits);
    let found = kinematics::bends(&Chain::PAPER, Point { x, y }, &[Bend::from_bits(from); 3]);
    let [proximal, middle, distal] = found.unwrap_or_else(|unreachable| unreachable.nearest).map(Bend::to_bits);
    pair(proximal, middle.wrapping_add(distal.wrapping_mul(3)))
}

/// The finger's driving force at these pressures, 2⁻¹⁶ kPa: its bits in r0.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn force(proximal: i32, middle: i32, distal: i32) -> u64 {
    pair(finger_force(&[proximal, middle, distal].map(Pressure::from_bits)).to_bits(), 0)
}

#[cortex_m_rt::entry]
fn main() -> ! {
    black_box(KEPT);
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
