use model_core::sequence::{Sequence, Step};

const STEPS: &[Step] = &[Step::kpa([30; 3]).ramp_ms(1000), Step::kpa([0; 3]).ramp_ms(9000)];
const BAD: Sequence = Sequence::new("bad", "Never run", STEPS, 0);

fn main() {
    println!("{}", BAD.name);
}
