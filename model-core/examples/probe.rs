use model_core::inverse::*; use model_core::units::*; use model_core::methods::{FixedNewton,Method};
fn main(){
 let cal=[(0.0,13.84,0.336),(35.3,7.24,0.831),(0.0,5.0,0.0),(60.0,40.0,2.0),(0.0,40.0,0.0),(0.0,5.0,2.0),(60.0,5.0,0.0),(0.01,5.0,0.0),(60.0,5.0,2.0),(1.0,5.0,0.05),(60.0,40.0,0.0),(0.0,40.0,2.0)];
 for (k,a,b) in cal { let c=Coefficients::from_f64_kpa(k,a,b).unwrap(); let f=FixedNewton::prepare(&c);
  let mut w=[0i32;3]; let mut at=[0i32;3]; let mut fall=0u32; let mut last=i32::MIN; let mut fat=0;
  let mut n=0i64;
  let step=std::env::args().nth(1).map_or(37,|s|s.parse::<i32>().unwrap());
  let mut bits=1; while bits<=1000<<16 { let x=bend_from_pressure(&c,Pressure::from_bits(bits)).to_bits(); let y=f.bend_from_pressure(Pressure::from_bits(bits)).to_bits();
    if x<last {fall+=1; if fat==0 {fat=bits;}} last=x; let e=(x-y).abs(); let z=if bits<(12<<16){0}else if bits<=150<<16 {1} else {2}; if e>w[z]{w[z]=e;at[z]=bits;} n+=1;
    bits+= if bits<70000 {1} else {step}; }
  print!("{k} {a} {b}: bend LSB {:?} at {:?} falls {fall} {:.4}",w,at.map(|b| b as f64/65536.),fat as f64/65536.);
  let mut w=[0i64;3]; let mut at=[0i32;3]; let mut fall=0u32; let mut last=i32::MIN; let mut fat=0;
  let mut bits=1; while bits<=170<<16 { let x=pressure_from_bend(&c,Bend::from_bits(bits)).to_bits(); let y=f.pressure_from_bend(Bend::from_bits(bits)).to_bits();
    if x<last {fall+=1; fat=bits;} last=x; let e=(x as i64-y as i64).abs(); let z=if bits<(8<<16){0}else if y<=150<<16 {1} else {2}; if e>w[z]{w[z]=e;at[z]=bits;} 
    bits+= if bits<70000||step==1 {1} else {7}; }
  println!("\n   pressure LSB {:?} at {:?} falls {fall} {:.4}",w,at.map(|b| b as f64/65536.),fat as f64/65536.); let _=n;
 }
}
