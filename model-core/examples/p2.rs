use model_core::inverse::*; use model_core::units::*;
fn main(){ let c=Coefficients::from_f64_kpa(0.0,5.0,0.0).unwrap(); dbg(&c,0.387451171875); dbg(&c,0.35);}
