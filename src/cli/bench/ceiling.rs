//! What a machine can compute at most: the cores' ceiling is measured, a GPU's is its data sheet's.

use super::machine::Machine;
use multiversion::multiversion;
use serde::Serialize;
use std::array;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Numbers of a chain, a whole number of vectors on every machine.
const LANES: usize = 16;
/// The best of so many measurements counts: others may use the cores as well.
const MEASUREMENTS: u32 = 10;
/// How long one takes at least.
const LONG_ENOUGH: Duration = Duration::from_millis(5);

/// Operations for an object pixel of an individual with so many point lights, plain ones and special
/// functions: counted in the shaders, `docs/PERFORMANCE.md`.
pub fn operations(lights: usize) -> [f64; 2] {
    let lights = lights as f64;
    [46.0 * lights + 82.0, 5.0 * lights + 4.0]
}

/// The same in `src/cpu/kernels/`, where plain operations make up special functions, and a multiply-add is
/// one.
fn native_operations(lights: usize) -> f64 {
    71.0 * lights as f64 + 68.0
}

/// Operations a second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ceiling {
    /// Plain ones; a multiply-add is one.
    pub plain: f64,
    /// Special functions, which a GPU computes beside the plain ones; null where they are made of
    /// these.
    pub special: Option<f64>,
}

impl Ceiling {
    /// Of what a machine computes with, as far as it is known.
    pub fn of(machine: &Machine) -> Option<Self> {
        let device = machine.device();
        match device.kind {
            "cpu" | "software" => Some(machine.within(cores)),
            // `docs/PERFORMANCE.md` reads their data sheets.
            _ => ["H200", "H100 80GB HBM3"]
                .iter()
                .any(|name| device.name.contains(name))
                .then_some(Self { plain: 33e12, special: Some(4e12) }),
        }
    }

    /// The least time for so many object pixels, of all individuals together, under point lights,
    /// seconds.
    pub fn floor(&self, lights: usize, pixels: f64) -> f64 {
        match self.special {
            Some(special) => {
                let [plain, functions] = operations(lights);
                pixels * (plain / self.plain).max(functions / special)
            }
            None => pixels * native_operations(lights) / self.plain,
        }
    }
}

/// Of the current pool's threads together.
fn cores() -> Ceiling {
    let plain = [few_chains, many_chains].map(best_rate).into_iter().fold(0.0, f64::max);
    Ceiling { plain, special: None }
}

/// Operations a second of a kernel that takes a number of rounds and tells its operations: the sum of
/// what each thread reaches at its best while all of them run.
fn best_rate(kernel: fn(u32) -> f64) -> f64 {
    let mut rounds = 1 << 10;
    while timed(kernel, rounds).0 < LONG_ENOUGH {
        rounds *= 2;
    }
    let mut best = vec![0.0f64; rayon::current_num_threads()];
    for _ in 0..MEASUREMENTS {
        let rates = rayon::broadcast(|_| timed(kernel, rounds)).into_iter();
        let rates = rates.map(|(time, operations)| operations / time.as_secs_f64());
        best.iter_mut().zip(rates).for_each(|(best, rate)| *best = best.max(rate));
    }
    best.into_iter().sum()
}

fn timed(kernel: fn(u32) -> f64, rounds: u32) -> (Duration, f64) {
    let start = Instant::now();
    let operations = kernel(rounds);
    (start.elapsed(), operations)
}

/// As many chains as fill the pipelines with vectors of half a chain, and fit in sixteen registers.
#[multiversion(targets = "simd")]
fn few_chains(rounds: u32) -> f64 {
    chains::<6>(rounds)
}

/// As many as that takes with vectors of a whole chain.
#[multiversion(targets = "simd")]
fn many_chains(rounds: u32) -> f64 {
    chains::<12>(rounds)
}

/// Multiply-adds of which each waits for the one before in its chain alone; how many they were.
#[inline(always)]
fn chains<const N: usize>(rounds: u32) -> f64 {
    let (factor, summand) = (black_box(0.999_f32), black_box(1e-3_f32));
    let mut sums: [[f32; LANES]; N] = array::from_fn(|i| [i as f32; LANES]);
    for _ in 0..rounds {
        for chain in &mut sums {
            for sum in chain {
                *sum = sum.mul_add(factor, summand);
            }
        }
    }
    black_box(sums);
    (N * LANES) as f64 * f64::from(rounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_is_the_work_at_the_ceiling() {
        let cores = Ceiling { plain: 1e9, special: None };
        assert_eq!(cores.floor(4, 1e9), 352.0);
        let gpu = Ceiling { plain: 1e9, special: Some(1e8) };
        assert_eq!(gpu.floor(1, 1e9), 128.0);
        assert_eq!(gpu.floor(4, 1e8), 26.6);
        let few = Ceiling { special: Some(1e6), ..gpu };
        assert_eq!(few.floor(1, 1e6), 9.0);
    }

    #[test]
    fn the_rates_of_all_threads_add_up() {
        /// An operation each microsecond, at most, on any thread.
        fn sleeper(rounds: u32) -> f64 {
            std::thread::sleep(Duration::from_micros(rounds.into()));
            rounds.into()
        }
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rate = pool(3).install(|| best_rate(sleeper));
        assert!((1.5e6..=3e6).contains(&rate), "{rate}");
        let one = pool(1).install(cores).plain;
        assert!(one > 1e6, "{one}");
        if std::thread::available_parallelism().unwrap().get() > 1 {
            let two = pool(2).install(cores).plain;
            assert!(two > 0.5 * one && two < 4.0 * one, "{two} by two, {one} by one");
        }
    }
}
