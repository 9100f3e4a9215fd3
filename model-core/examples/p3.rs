use model_core::inverse::*; use model_core::units::*;
fn main(){ for (k,a,b) in [(0.0,5.0,0.0),(0.01,5.0,0.0),(60.0,5.0,0.0),(1.0,5.0,0.05),(0.0,6.0,0.01),(0.0,13.84,0.336)] { let c=Coefficients::from_f64_kpa(k,a,b).unwrap();
 let mut last=0; let mut n=0; let mut first=0; for bits in 1..=1000<<16 { let x=bend_from_pressure(&c,Pressure::from_bits(bits)).to_bits(); if x<last {n+=1; if first==0 {first=bits;}} last=x; }
 println!("{k} {a} {b} falls {n} first {}",first as f64/65536.0); } }
