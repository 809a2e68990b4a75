//! Files mutated at random: a reader gives what it reads or a message, never a panic, in bounded memory and time.
//!
//! 2 000 files per reader; so many as MICROSLIP_MUTATIONS says where it is set.

#[path = "memory.rs"]
mod memory;

use memory::most_memory_kb;
use std::path::Path;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Files of a reader in an ordinary run.
const MUTATIONS: u64 = 2_000;
/// Time for one file at most.
const LONGEST: Duration = Duration::from_secs(5);
/// Memory of the whole test process at most (kB): several hundred small files in threads beside each other.
const MOST_MEMORY_KB: u64 = 1_500_000;

/// What is written into files: what readers must not trust.
const WORDS: [&[u8]; 18] = [
    b"NaN",
    b"inf",
    b"-1",
    b"0",
    b"99999999999999999999",
    b"5001",
    b"65536",
    b"1e999",
    b"1D+400",
    b"-",
    b" ",
    b"\n",
    b",",
    b"*",
    b"\xff",
    b"\xc3\xbc",
    b"\0",
    b"4294967296",
];

/// The bytes with one to four mutations.
fn mutated(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.random_range(1..=4) {
        let n = bytes.len().max(1);
        let at = random.random_range(0..n).min(bytes.len());
        let end = (at + random.random_range(1..=40)).min(bytes.len());
        match random.random_range(0..7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes.truncate(at),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            4 if at < bytes.len() => {
                bytes[at] = b"0123456789.-+EeDd \n,*"[random.random_range(0..21)]
            }
            5 => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                bytes.splice(at..end, word.iter().copied());
            }
            _ => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                bytes.splice(at..at, word.iter().copied());
            }
        }
    }
    bytes
}

/// Reads mutations of a file; `read` says whether it is taken.
pub(crate) fn survive(read: fn(&Path) -> bool, name: &str, bytes: &[u8]) {
    let many = std::env::var("MICROSLIP_MUTATIONS").ok();
    let many = many.and_then(|text| text.parse().ok()).unwrap_or(MUTATIONS);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    assert!(read(&path), "{name}: whole");
    let mut random = ChaCha8Rng::seed_from_u64(22);
    let (mut refused, mut longest) = (0, Duration::ZERO);
    for _ in 0..many {
        std::fs::write(&path, mutated(bytes, &mut random)).unwrap();
        let began = Instant::now();
        refused += u64::from(!read(&path));
        longest = longest.max(began.elapsed());
    }
    let memory_kb = most_memory_kb();
    println!("{name}: {refused} of {many} refused, the longest took {longest:?}, {memory_kb} kB");
    assert!(
        refused > many / 4,
        "{name}: only {refused} of {many} refused"
    );
    assert!(refused < many, "{name}: every one refused");
    assert!(longest < LONGEST, "{name}: {longest:?}");
    assert!(memory_kb < MOST_MEMORY_KB, "{name}: {memory_kb} kB");
}
