//! The fuzz targets' bodies on their seeds, on what they have found, and on bytes by chance. `make fuzz` is the
//! search for more.

#[path = "../fuzz/src/lib.rs"]
mod targets;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(target);
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = entries.collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

#[test]
fn seeds_are_read_or_refused() {
    for (name, target) in targets::TARGETS {
        let seeds = seeds(name);
        assert!(!seeds.is_empty(), "{name}");
        for seed in seeds {
            target(&seed);
        }
    }
}

/// Each seed with some bytes changed, cut or put in, and for the structured target any bytes.
#[test]
fn bytes_by_chance_are_read_or_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let rounds = std::env::var("KLIEG_FUZZ_ROUNDS").map_or(40, |rounds| rounds.parse().unwrap());
    for (name, target) in targets::TARGETS {
        let seeds = seeds(name);
        for _ in 0..rounds {
            let mut bytes = seeds[rng.random_range(0..seeds.len())].clone();
            if name == "scene" {
                bytes = (0..rng.random_range(8..120)).map(|_| rng.random()).collect();
            }
            for _ in 0..rng.random_range(1..8) {
                let at = rng.random_range(0..=bytes.len());
                match rng.random_range(0..4) {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes.insert(at, rng.random()),
                    _ if at < bytes.len() => bytes[at] = rng.random(),
                    _ => {}
                }
            }
            target(&bytes);
        }
    }
}
