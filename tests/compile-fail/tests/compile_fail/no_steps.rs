use model_core::sequence::{Sequence, Step};

const STEPS: &[Step] = &[];
const BAD: Sequence = Sequence::new("bad", "Nothing to do", STEPS, 1);

fn main() {
    println!("{}", BAD.name);
}
