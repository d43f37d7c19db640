//! Instructions a call of the evaluators on a Cortex-M4F. Counts of an emulator, the same everywhere: no time.

use asperity_needs::absent;
use asperity_tests::code;

use crate::emulator::{self, Firmware};
/// Most instructions of a call: law, tier, what (see `firmware-sim/src/bin/counts.rs`).
const MOST: [(&str, usize); 13] = [
    // directions made of ready components; a C compiler makes 161 of the same formula
    ("ggx fast ars+unit", 161),
    ("ggx fast sample", 400),
    ("ggx-ms fast ars+unit", 250),
    ("normals fast ars", 200),
    ("normals fast sample", 400),
    ("table-u8 fast ars", 250),
    ("table-u8 fast eval", 250),
    ("table-u8 fast sample", 400),
    ("table-u16 fast ars", 250),
    ("table-u16 fast eval", 250),
    ("table-u16 fast sample", 400),
    ("table-f32 fast ars", 250),
    ("table-f32 fast sample", 400),
];

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn a_call_takes_a_few_hundred_instructions() {
    let said = match Firmware::Counts.path().and_then(|elf| emulator::run(&elf)) {
        Ok(said) => said,
        Err(remedy) => return absent(&remedy),
    };
    println!("{said}");
    for (what, most) in MOST {
        let most = code::limit(most);
        let start = format!("count {what} ");
        let count = said.lines().find_map(|line| line.strip_prefix(&start)).unwrap();
        let count: usize = count.parse().unwrap();
        // one that does nothing is no evaluator
        assert!((50..=most).contains(&count), "{what}: {count} instructions, at most {most}");
    }
}
