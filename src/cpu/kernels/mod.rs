//! The inner loops of the native evaluator, compiled for several vector instruction sets, of which the
//! machine's best is chosen at run time. All of them give the same bits: every sum is taken in
//! [`LANES`] parts in a fixed order.

mod appearance;
mod color;
mod histogram;
mod shade;
mod shadow;
mod statistics;

pub use appearance::{AppearanceSums, appearance, interior_detail, residual, tapped_detail};
pub use color::{paint, shade_color};
pub use histogram::{histogram, weighted_histogram};
pub use shade::shade;
pub use shadow::Casting;
pub use statistics::{interior_gradient, moments, tapped_gradient};

use super::compact::Lanes;
use bytemuck::{Pod, Zeroable};

/// A picture's pixels, group by group.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub struct Tile(Lanes);

#[cfg(test)]
mod tests {
    use super::appearance::{appearance_in_lanes, residual_in_lanes, runs_detail, taps_detail};
    use super::color::color_in_lanes;
    use super::histogram::histogram_in_lanes;
    use super::shade::shade_in_lanes;
    use super::statistics::{moments_in_lanes, runs_gradient, taps_gradient};
    use super::*;
    use crate::cpu::compact::{ColorGroup, Group, LANES, Run, Shaped, Taps};
    use crate::lighting::LightRecord;
    use crate::lighting::shading::Brdf;
    use crate::objective::HISTOGRAM_BINS;
    use crate::objective::shadows::Shadows;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::sync::Arc;

    /// What every kernel makes of the same input, as bits.
    #[derive(Debug, PartialEq)]
    struct Outcome {
        picture: Vec<u32>,
        sums: [u64; 4],
        histogram: [u32; HISTOGRAM_BINS],
    }

    struct Input {
        groups: Vec<Group>,
        rig: Vec<LightRecord>,
        taps: Vec<Taps>,
        colors: Vec<ColorGroup>,
        shaped: Vec<Shaped>,
        /// Coordinates of normals, and a target picture.
        numbers: [Vec<f32>; 3],
        shadows: Shadows,
    }

    /// More than a block of groups and than a block of pixels to count, and no multiple of either.
    const LEN: usize = 69 * LANES;
    /// What every kernel for colour makes of the same input, as bits.
    #[derive(Debug, PartialEq)]
    struct Colored {
        planes: Vec<u32>,
        sums: [AppearanceSums; 2],
        others: [u64; 5],
    }

    const RUNS: [Run; 2] = [
        Run { above: 0, here: 21, below: 42, len: 36 },
        Run { above: 7, here: 28, below: 49, len: 1030 },
    ];

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
                ..LightRecord::DARK
            };
            let rig = (0..9).map(light).collect();
            let tap = |_| std::array::from_fn(|_| number(0.0, LEN as f32) as u32);
            let taps = (0..LANES).map(tap).collect();
            let mut color = || {
                let mut lanes = |low, high| -> Lanes { std::array::from_fn(|_| number(low, high)) };
                ColorGroup {
                    diffuse: [lanes(0.0, 1.0), lanes(0.0, 1.0), lanes(0.0, 1.0)],
                    specular: [lanes(0.0, 1.0), lanes(0.0, 1.0), lanes(0.0, 1.0)],
                    lobe: lanes(0.001, 1.0),
                    unlit: [lanes(0.0, 0.1), lanes(0.0, 0.1), lanes(0.0, 0.1)],
                }
            };
            let colors = (0..LEN / LANES).map(|_| color()).collect();
            let shaped =
                (0..LEN).map(|_| Shaped { weight: number(0.0, 0.5), scale: number(1.0, 250.0) });
            let shaped = shaped.collect();
            let numbers = [(-1.0, 1.0), (-1.0, 1.0), (-0.5, 1.0)]
                .map(|(low, high)| (0..LEN).map(|_| number(low, high)).collect());
            let object = std::iter::repeat_n(true, LEN);
            let mut shadows = Shadows::new(31, object, Arc::default());
            for (pixel, word) in (0..LEN).flat_map(|pixel| (0..31).map(move |word| (pixel, word))) {
                *shadows.word_mut(pixel, word) = random.random();
            }
            Self { groups, rig, taps, colors, shaped, numbers, shadows }
        }

        /// By the version that the caller is compiled for.
        #[inline(always)]
        fn outcome(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            let stride = tiles.len();
            shade_in_lanes(&self.groups, &self.rig, self.rig.len(), &mut tiles, stride);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            Outcome::new(
                picture,
                moments_in_lanes(&picture[3..]),
                runs_gradient(picture, &RUNS),
                taps_gradient(picture, &self.taps, 1.0 / 0.06, 1.0),
                histogram_in_lanes(&picture[3..]),
            )
        }

        /// Colour, by the version that the caller is compiled for or, of kernels, by that which is chosen for
        /// this machine.
        #[inline(always)]
        fn colored(&self, here: bool) -> Colored {
            let stride = self.groups.len();
            let mut planes = vec![Tile::default(); 4 * stride];
            let surface = (&self.groups[..], &self.colors[..]);
            let rigs = (&self.rig[..], self.rig.len());
            let casting = Casting { shadows: Some(&self.shadows), ..Casting::default() };
            for (brdf, planes) in
                [Brdf::BlinnPhong, Brdf::Gltf].into_iter().zip(planes.chunks_mut(2 * stride))
            {
                match here {
                    true => color_in_lanes(surface, &casting, rigs, brdf, (planes, stride)),
                    false => shade_color(surface, &casting, rigs, brdf, (planes, stride)),
                }
            }
            let shaded = bytemuck::cast_slice(&planes).iter().map(|x: &f32| x.to_bits()).collect();
            let mut others = Vec::new();
            let at: Vec<u32> = (0..LANES as u32).collect();
            let [x, y, target] = self.numbers.each_ref().map(|numbers| &numbers[5..]);
            let sums = [0, 1].map(|k| {
                let (pictures, irradiances) =
                    planes[2 * k * stride..][..2 * stride].split_at_mut(stride);
                let picture: &[f32] = bytemuck::cast_slice(pictures);
                let (detail, tapped, residual) = match here {
                    true => (
                        runs_detail(picture, &RUNS, &self.shaped),
                        taps_detail(picture, (&self.taps, &at), &self.shaped),
                        residual_in_lanes(&picture[5..], target),
                    ),
                    false => (
                        interior_detail(picture, &RUNS, &self.shaped),
                        tapped_detail(picture, (&self.taps, &at), &self.shaped),
                        residual(&picture[5..], target),
                    ),
                };
                others = [&detail[..], &tapped, &[residual]].concat();
                let own = &mut bytemuck::cast_slice_mut::<_, f32>(irradiances)[5..];
                match here {
                    true => appearance_in_lanes(own, [x, y]),
                    false => appearance(own, [x, y]),
                }
            });
            let others = std::array::from_fn(|k| others[k].to_bits());
            Colored { planes: shaded, sums, others }
        }

        /// By the version that is chosen for this machine.
        fn dispatched(&self) -> Outcome {
            let mut tiles = vec![Tile::default(); self.groups.len()];
            let stride = tiles.len();
            shade(&self.groups, &self.rig, self.rig.len(), &mut tiles, stride);
            let picture: &[f32] = bytemuck::cast_slice(&tiles);
            Outcome::new(
                picture,
                moments(&picture[3..]),
                interior_gradient(picture, &RUNS),
                tapped_gradient(picture, &self.taps, 1.0 / 0.06, 1.0),
                histogram(&picture[3..]),
            )
        }
    }

    impl Outcome {
        fn new(
            picture: &[f32],
            (sum, squares): (f64, f64),
            inner: f64,
            outer: f64,
            histogram: [u32; HISTOGRAM_BINS],
        ) -> Self {
            let sums = [sum, squares, inner, outer].map(f64::to_bits);
            Self { picture: picture.iter().map(|i| i.to_bits()).collect(), sums, histogram }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn avx2(input: &Input) -> (Outcome, Colored) {
        (input.outcome(), input.colored(true))
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx,avx2,fma,avx512f,avx512bw,avx512dq,avx512vl")]
    fn avx512(input: &Input) -> (Outcome, Colored) {
        (input.outcome(), input.colored(true))
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let mut input = Input::new();
        let baseline = (input.outcome(), input.colored(true));
        assert!((input.dispatched(), input.colored(false)) == baseline);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the machine has what the function is compiled for.
                assert!(unsafe { avx2(&input) } == baseline);
            }
            let wide = is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512dq");
            if wide && is_x86_feature_detected!("avx512vl") {
                // SAFETY: as above.
                assert!(unsafe { avx512(&input) } == baseline);
            }
        }
        // The last bits of one number are enough to tell two outcomes apart.
        let unlit = &mut input.groups[0].unlit[5];
        *unlit = f32::from_bits(unlit.to_bits() + 64);
        assert_ne!(input.dispatched(), baseline.0);
        input.colors[0].unlit[1].iter_mut().for_each(|unlit| *unlit += 1e-4);
        assert!(input.colored(false) != baseline.1);
    }
}
