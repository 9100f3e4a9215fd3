use model_core::sequence::{Sequence, Step};

const STEPS: &[Step] = &[Step::kpa([150; 3]).ramp_ms(1499), Step::kpa([0; 3]).ramp_ms(9000)];
const BAD: Sequence = Sequence::new("bad", "More than 100 kPa/s", STEPS, 1);

fn main() {
    println!("{}", BAD.name);
}
