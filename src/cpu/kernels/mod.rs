//! The inner loops of the native evaluator, compiled for several vector instruction sets, of which the
//! machine's best is chosen at run time. All of them give the same bits: every sum is taken in
//! [`LANES`] parts in a fixed order.

mod shade;
mod statistics;

pub use shade::shade;
pub use statistics::{histogram, interior_gradient, moments, tapped_gradient};

use super::compact::Lanes;
use bytemuck::{Pod, Zeroable};

/// A picture's pixels, group by group.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub struct Tile(Lanes);

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// What every kernel makes of the same input, as bits.
    #[derive(Debug, PartialEq)]
    struct Outcome {
        picture: Vec<u32>,
        sums: [u64; 4],
    }

    struct Input {
        groups: Vec<Group>,
        rig: Vec<LightRecord>,
        taps: Vec<Taps>,
    }

    const LEN: usize = 5 * LANES;

    impl Input {
        fn new() -> Self {
            let mut random = ChaCha8Rng::seed_from_u64(11);
            let mut number = |low: f32, high: f32| random.random_range(low..high);
            let mut group = || {
                let mut lanes = |low, high| -> Lanes { std::array::from_fn(|_| number(low, high)) };
                Group {
                    position: [lanes(-1.0, 1.0), lanes(-1.0, 1.0), lanes(-1.0, 1.0)],
                    normal: [lanes(-0.6, 0.6), lanes(-0.6, 0.6), lanes(0.1, 0.8)],
                    to_viewer: [lanes(-0.1, 0.1), lanes(-0.1, 0.1), lanes(0.9, 1.0)],
                    facing: lanes(0.0, 1.0),
                    diffuse: lanes(0.0, 1.0),
                    specular: lanes(0.0, 2.0),
                    exponent: lanes(0.5, 2048.0),
                    unlit: lanes(0.0, 0.1),
                }
            };
            let groups = (0..LEN / LANES).map(|_| group()).collect();
            let light = |k: u16| LightRecord {
                position: [number(-2.0, 2.0), number(-2.0, 2.0), number(1.0, 3.0)],
                radius2: f32::from(k % 3) * 2.0,
                diffuse: number(0.0, 0.2),
                specular: number(0.0, 0.1),
                padding: [0.0; 2],
            };
            let rig = (0..9).map(light).collect();
            let tap = |_| std::array::from_fn(|_| number(0.0, LEN as f32) as u32);
            Self { groups, rig, taps: (0..LANES).map(tap).collect() }
        }

        #[inline(always)]
        fn outcome(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            shade_block(&self.groups, &self.rig, &mut tiles);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            let (sum, squares) = moments_in_lanes(&picture[3..]);
            let [above, here, below] = [0, 21, 42].map(|at| &picture[at..at + 38]);
            let inner = run_gradient(above, here, below);
            let outer = taps_gradient(picture, &self.taps, 1.0 / 0.06, 1.0);
            Outcome {
                picture: picture.iter().map(|i| i.to_bits()).collect(),
                sums: [sum, squares, inner, outer].map(f64::to_bits),
            }
        }

        /// By the version that is chosen for this machine.
        fn dispatched(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            let stride = tiles.len();
            shade(&self.groups, &self.rig, self.rig.len(), &mut tiles, stride);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            let (sum, squares) = moments(&picture[3..]);
            let inner =
                interior_gradient(picture, &[Run { above: 0, here: 21, below: 42, len: 36 }]);
            let outer = tapped_gradient(picture, &self.taps, 1.0 / 0.06, 1.0);
            Outcome {
                picture: picture.iter().map(|i| i.to_bits()).collect(),
                sums: [sum, squares, inner, outer].map(f64::to_bits),
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn avx2(input: &Input) -> Outcome {
        input.outcome()
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx,avx2,fma,avx512f,avx512bw,avx512dq,avx512vl")]
    fn avx512(input: &Input) -> Outcome {
        input.outcome()
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let mut input = Input::new();
        let baseline = input.outcome();
        assert_eq!(input.dispatched(), baseline);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the machine has what the function is compiled for.
                assert_eq!(unsafe { avx2(&input) }, baseline);
            }
            let wide = is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512dq");
            if wide && is_x86_feature_detected!("avx512vl") {
                // SAFETY: as above.
                assert_eq!(unsafe { avx512(&input) }, baseline);
            }
        }
        // The last bits of one number are enough to tell two outcomes apart.
        let unlit = &mut input.groups[0].unlit[5];
        *unlit = f32::from_bits(unlit.to_bits() + 64);
        assert_ne!(input.dispatched(), baseline);
    }

    #[test]
    fn bins_are_those_of_the_plain_histogram() {
        let mut picture: Vec<f32> = (0..=64).map(|k| k as f32 / 64.0).collect();
        picture.extend([0.999_999_9, f32::NAN, -1.0, f32::INFINITY, 0.031_249_998]);
        for &i in &picture {
            let plain = ((i * 32.0) as i32).clamp(0, 31);
            assert_eq!(i32::from(bin_of(i)), plain, "{i}");
        }
        for len in 0..picture.len() {
            assert_eq!(histogram(&picture[..len]).iter().sum::<u32>(), len as u32);
        }
        let skewed = [vec![0.0; 1000], vec![1.0; 777]].concat();
        let counts = histogram(&skewed);
        assert_eq!((counts[0], counts[31]), (1000, 777));
    }

    #[test]
    fn gradients_of_runs_and_of_taps_agree() {
        let mut random = ChaCha8Rng::seed_from_u64(12);
        let width = 50;
        let picture: Vec<f32> = (0..3 * width).map(|_| random.random_range(0.0..1.0)).collect();
        for len in 1..=width - 2 {
            let run = Run { above: 0, here: width, below: 2 * width, len };
            let around = |k: u32| {
                let below = k + 2 * width;
                let here = k + width;
                [k, k + 1, k + 2, here, here + 2, below, below + 1, below + 2]
            };
            let taps: Vec<Taps> = (0..len).map(around).collect();
            let run = interior_gradient(&picture, &[run]);
            let tapped = tapped_gradient(&picture, &taps, 1.0, f32::MAX);
            assert!((run - tapped).abs() < 1e-5, "{len}: {run} {tapped}");
        }
        let flat = [0.5; 64];
        assert_eq!(interior_gradient(&flat, &[Run { above: 0, here: 0, below: 0, len: 60 }]), 0.0);
    }
}
