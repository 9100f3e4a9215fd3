//! Writes the seeds into the corpora: `cargo run -p finger-fuzz --bin seeds`. What fuzzing found stays beside them.

use finger_fuzz::seeds;
use std::path::Path;

fn main() -> std::io::Result<()> {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/__fuzz__");
    for (name, seeds) in [("frames", seeds::frames()), ("messages", seeds::messages()), ("sessions", seeds::sessions())]
    {
        let folder = corpora.join(name).join("corpus");
        std::fs::create_dir_all(&folder)?;
        for (file, bytes) in seeds {
            std::fs::write(folder.join(file), bytes)?;
        }
    }
    Ok(())
}
