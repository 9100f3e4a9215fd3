use model_core::sequence::{Sequence, Step};

const STEPS: &[Step] = &[Step::kpa([151, 0, 0]).ramp_ms(9000), Step::kpa([0; 3]).ramp_ms(9000)];
const BAD: Sequence = Sequence::new("bad", "151 kPa", STEPS, 1);

fn main() {
    println!("{}", BAD.name);
}
