//! Which of many good rigs a gallery shows, and how it arranges them: *Design Galleries* (Marks and others 1997) disperse
//! their pictures, so that they are as different as the good ones allow, and arrange them by what is alike.

use crate::math::color::srgb_decode;
use crate::math::eigen;
use glam::Vec3;
use image::RgbImage;

/// Longest side of the pictures that are compared, pixels.
pub const SIDE: u32 = 32;

/// How much a difference of the mean lightness counts beside other differences: a picture that is darker throughout shows
/// no other light.
const MEAN_SHARE: f32 = 0.25;

/// A small picture as the eye has it: CIE 1976 L*a*b* (D65) of each pixel of the object.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture(Vec<Vec3>);

impl Picture {
    /// The picture with `times`² of its pixels averaged in linear light to one, where half of them or more belong to the
    /// object; there is one entry of `object` a pixel.
    pub fn of(picture: &RgbImage, object: &[bool], times: u32) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let cells = (0..height.div_ceil(times))
            .flat_map(|y| (0..width.div_ceil(times)).map(move |x| (x * times, y * times)));
        let cell = |(left, top): (u32, u32)| {
            let (mut sum, mut count) = (Vec3::ZERO, 0);
            for y in top..(top + times).min(height) {
                for x in left..(left + times).min(width) {
                    if object[(y * width + x) as usize] {
                        let channels = picture.get_pixel(x, y).0.map(|c| f32::from(c) / 255.0);
                        (sum, count) = (sum + Vec3::from(channels.map(srgb_decode)), count + 1);
                    }
                }
            }
            (2 * count >= times * times).then(|| lab(sum / count as f32))
        };
        Self(cells.filter_map(cell).collect())
    }

    /// Root mean square over the pixels of the colour difference `ΔE*ab`, a difference of the mean lightness
    /// counting a quarter.
    /// Both are of one view. 0 where no pixel belongs to the object.
    pub fn distance(&self, other: &Self) -> f32 {
        let count = self.0.len().max(1) as f32;
        let pixels = || self.0.iter().zip(&other.0).map(|(a, b)| *a - *b);
        let mean = pixels().map(|off| off.x).sum::<f32>() / count;
        let square = pixels().map(Vec3::length_squared).sum::<f32>() / count;
        (square - (1.0 - MEAN_SHARE * MEAN_SHARE) * mean * mean).max(0.0).sqrt()
    }
}

/// CIE 1976 L*a*b* of linear sRGB, white D65.
fn lab(rgb: Vec3) -> Vec3 {
    let white = Vec3::new(0.950_47, 1.0, 1.088_83);
    let xyz = Vec3::new(
        rgb.dot(Vec3::new(0.412_456, 0.357_576, 0.180_438)),
        rgb.dot(Vec3::new(0.212_673, 0.715_152, 0.072_175)),
        rgb.dot(Vec3::new(0.019_334, 0.119_192, 0.950_304)),
    ) / white;
    let f = |t: f32| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 4.0 / 29.0 };
    let [x, y, z] = xyz.to_array().map(f);
    Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Farthest-point selection (Gonzalez 1985): `count` of the places 0..`len`, or all, beginning with `first`; each next one
/// is the farthest from all before it, the first of those that are equally far. What is at no distance is never chosen.
pub fn farthest(
    len: usize,
    first: usize,
    count: usize,
    distance: impl Fn(usize, usize) -> f32,
) -> Vec<usize> {
    let mut chosen = vec![first];
    let mut nearest: Vec<f32> = (0..len).map(|at| distance(first, at)).collect();
    while chosen.len() < count {
        let far = (0..len).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a)));
        let Some(far) = far.filter(|&far| nearest[far] > 0.0) else { break };
        chosen.push(far);
        nearest.iter_mut().enumerate().for_each(|(at, near)| *near = near.min(distance(far, at)));
    }
    chosen
}

/// The same places, each but the first exchanged for the one of the lowest score that leaves the least distance between
/// any two at `share` of what it was or more.
pub fn polished(
    chosen: &[usize],
    scores: &[f32],
    share: f32,
    distance: impl Fn(usize, usize) -> f32,
) -> Vec<usize> {
    let limit = share * least(chosen, &distance);
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]));
    let mut chosen = chosen.to_vec();
    for place in 1..chosen.len() {
        let clear = |at: usize| {
            let others = chosen.iter().enumerate().filter(|(other, _)| *other != place);
            others.into_iter().all(|(_, &other)| other != at && distance(other, at) >= limit)
        };
        if let Some(better) = order.iter().copied().find(|&at| clear(at)) {
            chosen[place] = better;
        }
    }
    chosen
}

/// The least distance between any two of these places; infinite for fewer than two.
pub fn least(chosen: &[usize], distance: impl Fn(usize, usize) -> f32) -> f32 {
    let pairs = (0..chosen.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| distance(chosen[a], chosen[b])).fold(f32::INFINITY, f32::min)
}

/// Places in the plane whose distances are as near to these as can be: classical multidimensional scaling (Torgerson
/// 1952). `distances` is a symmetric square matrix. The first axis has the larger spread; each axis points to where its
/// farthest place is.
pub fn positions(distances: &[Vec<f32>]) -> Vec<[f32; 2]> {
    let n = distances.len();
    let square = |i: usize, j: usize| f64::from(distances[i][j]).powi(2);
    let rows: Vec<f64> =
        (0..n).map(|i| (0..n).map(|j| square(i, j)).sum::<f64>() / n as f64).collect();
    let mean = rows.iter().sum::<f64>() / n.max(1) as f64;
    let gram = (0..n * n).map(|at| {
        let (i, j) = (at / n, at % n);
        -0.5 * (square(i, j) - rows[i] - rows[j] + mean)
    });
    let (values, vectors) = eigen::symmetric(gram.collect(), n);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let axis = |rank: usize| -> Vec<f32> {
        let Some(&at) = order.get(rank) else { return vec![0.0; n] };
        let scale = values[at].max(0.0).sqrt();
        let along: Vec<f32> = (0..n).map(|i| (scale * vectors[i * n + at]) as f32).collect();
        let end =
            along.iter().copied().fold(0.0, |a: f32, b| if b.abs() > a.abs() { b } else { a });
        along.into_iter().map(|x| if end < 0.0 { -x } else { x }).collect()
    };
    std::iter::zip(axis(0), axis(1)).map(|(x, y)| [x, y]).collect()
}

/// The places in rows of `columns` at most, in which neighbours are neighbours in the plane: rows from the top by `y`, and
/// in each from the left by `x`.
pub fn rows(positions: &[[f32; 2]], columns: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&a, &b| positions[b][1].total_cmp(&positions[a][1]));
    let columns = columns.max(1);
    let count = positions.len().div_ceil(columns).max(1);
    let mut rows = Vec::new();
    for row in 0..count {
        // As even as the number allows.
        let end = (row + 1) * positions.len() / count - row * positions.len() / count;
        let mut cells: Vec<usize> = order.drain(..end).collect();
        cells.sort_by(|&a, &b| positions[a][0].total_cmp(&positions[b][0]));
        rows.push(cells);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn points(count: usize, seed: u64) -> Vec<[f32; 2]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| [rng.random_range(0.0..4.0), rng.random_range(0.0..1.0)]).collect()
    }

    fn apart(points: &[[f32; 2]]) -> impl Fn(usize, usize) -> f32 {
        |a, b| (points[a][0] - points[b][0]).hypot(points[a][1] - points[b][1])
    }

    fn matrix(points: &[[f32; 2]]) -> Vec<Vec<f32>> {
        let all = 0..points.len();
        all.clone().map(|a| all.clone().map(|b| apart(points)(a, b)).collect()).collect()
    }

    fn filled(colors: &[[u8; 3]]) -> Picture {
        let picture = RgbImage::from_fn(colors.len() as u32, 1, |x, _| Rgb(colors[x as usize]));
        Picture::of(&picture, &vec![true; colors.len()], 1)
    }

    #[test]
    fn distances_are_those_of_the_eye() {
        let grey = filled(&[[119; 3]; 2]);
        assert_eq!(grey.distance(&grey), 0.0);
        // L* of sRGB 119 is 50, of white 100; the difference is one of the mean alone.
        assert!((grey.distance(&filled(&[[255; 3]; 2])) - 12.5).abs() < 0.15);
        // The same pixels the other way round: 100 in each, and none of the mean.
        let (left, right) = (filled(&[[255; 3], [0; 3]]), filled(&[[0; 3], [255; 3]]));
        assert!((left.distance(&right) - 100.0).abs() < 0.1);
        // ΔE*ab of the sRGB red and green: L* 53.2, a* 80.1, b* 67.2 and 87.7, -86.2, 83.2.
        let (red, green) = (lab(Vec3::X), lab(Vec3::Y));
        assert!((red - Vec3::new(53.24, 80.09, 67.2)).length() < 0.1, "{red}");
        assert!((green - Vec3::new(87.73, -86.18, 83.18)).length() < 0.1, "{green}");
    }

    #[test]
    fn pictures_are_made_small_in_linear_light_where_the_object_is() {
        let picture = RgbImage::from_fn(4, 2, |x, y| match (x, y) {
            (0, 0) | (1, 1) => Rgb([255; 3]),
            _ => Rgb([0; 3]),
        });
        let object = [true, true, true, false, true, true, false, false];
        let Picture(cells) = Picture::of(&picture, &object, 2);
        // Half of the light of white has L* 76; the right cell has one pixel of the object in four.
        assert_eq!(cells.len(), 1);
        assert!((cells[0].x - 76.07).abs() < 0.1, "{cells:?}");
    }

    #[test]
    fn the_farthest_points_are_spread() {
        let points = points(300, 1);
        let chosen = farthest(300, 7, 12, apart(&points));
        assert_eq!((chosen[0], chosen.len()), (7, 12));
        let spread = least(&chosen, apart(&points));
        let blind = |start: usize| -> Vec<usize> {
            (0..12).map(|at| (start * 13 + at * 17) % 300).collect()
        };
        let mean = (0..20).map(|start| least(&blind(start), apart(&points))).sum::<f32>() / 20.0;
        assert!(spread > 4.0 * mean, "{spread} {mean}");
        // What is the same place is not chosen again.
        assert_eq!(farthest(9, 2, 4, |_, _| 0.0), [2]);
        assert_eq!(farthest(3, 1, 9, |a, b| a.abs_diff(b) as f32), [1, 0, 2]);
    }

    #[test]
    fn better_ones_are_taken_where_they_are_as_far_apart() {
        let points = points(300, 2);
        let scores: Vec<f32> = points.iter().map(|[x, y]| (3.0 * x).sin() + y).collect();
        let chosen = farthest(300, 0, 10, apart(&points));
        let better = polished(&chosen, &scores, 0.8, apart(&points));
        let sum = |chosen: &[usize]| chosen.iter().map(|&at| scores[at]).sum::<f32>();
        assert_eq!((better[0], better.len()), (0, 10));
        assert!(sum(&better) < sum(&chosen) - 1.0, "{} {}", sum(&better), sum(&chosen));
        let (before, after) = (least(&chosen, apart(&points)), least(&better, apart(&points)));
        assert!(after >= 0.8 * before, "{after} {before}");
    }

    #[test]
    fn a_plane_is_found_again_from_its_distances() {
        let points = points(14, 3);
        let places = positions(&matrix(&points));
        for (a, b) in (0..14).flat_map(|a| (0..a).map(move |b| (a, b))) {
            assert!((apart(&places)(a, b) - apart(&points)(a, b)).abs() < 1e-4);
        }
        let spread = |axis: usize| places.iter().map(|p| p[axis] * p[axis]).sum::<f32>();
        assert!(spread(0) > spread(1));
        assert_eq!(positions(&[vec![0.0]]), [[0.0; 2]]);
        assert!(positions(&[]).is_empty());
    }

    #[test]
    fn rows_keep_neighbours_together() {
        let points =
            [[0.0, 1.0], [2.0, 1.1], [1.0, 0.9], [1.0, 0.1], [0.0, 0.0], [2.0, -0.1], [3.0, 0.0]];
        assert_eq!(rows(&points, 4), [vec![0, 2, 1], vec![4, 3, 5, 6]]);
        assert_eq!(rows(&points, 9), [vec![0, 4, 2, 3, 1, 5, 6]]);
        assert_eq!(rows(&[], 3).concat(), [0usize; 0]);
    }
}
