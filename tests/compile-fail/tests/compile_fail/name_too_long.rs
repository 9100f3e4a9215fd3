use model_core::sequence::{Sequence, Step};

const STEPS: &[Step] = &[Step::kpa([30, 0, 0]), Step::kpa([0; 3]).ramp_ms(1000)];
const BAD: Sequence = Sequence::new("one-joint-after-the-other", "25 bytes", STEPS, 1);

fn main() {
    println!("{}", BAD.name);
}
