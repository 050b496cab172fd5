//! k-means clusters of unit normals.

use glam::Vec3;
use rand::{Rng, RngExt};
use rayon::prelude::*;

/// Lloyd iterations at most; clusterings of normals settle in far fewer.
const ITERATIONS: usize = 100;

/// A group of similar normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Unit mean direction, light frame.
    pub direction: Vec3,
    /// Normals in it.
    pub size: usize,
}

/// k-means clusters of unit normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Clustering {
    /// The clusters, the largest first.
    pub clusters: Vec<Cluster>,
    /// Index of each normal's cluster.
    pub labels: Vec<usize>,
}

/// k-means of unit vectors with a k-means++ start (Arthur and Vassilvitskii 2007), by Euclidean
/// distance, to convergence. With fewer distinct normals than `k`, some clusters are empty and share
/// another's direction; without any normal all face the viewer.
pub fn cluster(normals: &[Vec3], k: usize, rng: &mut impl Rng) -> Clustering {
    let mut centroids = plus_plus(normals, k, rng);
    let mut labels = Vec::new();
    for _ in 0..ITERATIONS {
        let next: Vec<usize> = normals.par_iter().map(|n| nearest(&centroids, *n)).collect();
        if next == labels {
            break;
        }
        labels = next;
        for (i, (sum, count)) in sums(normals, &labels, k).into_iter().enumerate() {
            if count > 0 {
                centroids[i] = sum / count as f32;
            }
        }
    }
    by_size(&centroids, labels)
}

/// Sum and number of the normals of each cluster.
fn sums(normals: &[Vec3], labels: &[usize], k: usize) -> Vec<(Vec3, usize)> {
    let mut sums = vec![(glam::DVec3::ZERO, 0); k];
    for (normal, &label) in normals.iter().zip(labels) {
        sums[label].0 += normal.as_dvec3();
        sums[label].1 += 1;
    }
    sums.into_iter().map(|(sum, count)| (sum.as_vec3(), count)).collect()
}

/// First centroids: each is a normal drawn with a probability proportional to the squared distance
/// from those chosen before.
fn plus_plus(normals: &[Vec3], k: usize, rng: &mut impl Rng) -> Vec<Vec3> {
    let Some(&last) = normals.last() else { return vec![Vec3::Z; k] };
    let mut centroids = vec![normals[rng.random_range(0..normals.len())]];
    let mut distances = vec![f64::INFINITY; normals.len()];
    while centroids.len() < k {
        let newest = centroids[centroids.len() - 1];
        for (distance, normal) in distances.iter_mut().zip(normals) {
            *distance = distance.min(f64::from(normal.distance_squared(newest)));
        }
        let mut left = rng.random::<f64>() * distances.iter().sum::<f64>();
        let chosen = normals.iter().zip(&distances).find(|(_, distance)| {
            left -= **distance;
            left < 0.0
        });
        centroids.push(chosen.map_or(last, |(normal, _)| *normal));
    }
    centroids
}

/// Index of the nearest centroid, the first of equals.
fn nearest(centroids: &[Vec3], normal: Vec3) -> usize {
    let mut best = (0, f32::INFINITY);
    for (i, centroid) in centroids.iter().enumerate() {
        let distance = centroid.distance_squared(normal);
        if distance < best.1 {
            best = (i, distance);
        }
    }
    best.0
}

/// Orders the clusters by size, the first of equals first.
fn by_size(centroids: &[Vec3], mut labels: Vec<usize>) -> Clustering {
    let mut sizes = vec![0; centroids.len()];
    labels.iter().for_each(|&label| sizes[label] += 1);
    let mut order: Vec<usize> = (0..centroids.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(sizes[i]));
    let mut rank = vec![0; order.len()];
    order.iter().enumerate().for_each(|(r, &i)| rank[i] = r);
    labels.iter_mut().for_each(|label| *label = rank[*label]);
    let cluster =
        |&i: &usize| Cluster { direction: centroids[i].normalize_or(Vec3::Z), size: sizes[i] };
    Clustering { clusters: order.iter().map(cluster).collect(), labels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    /// Normals in tight bundles around known directions.
    fn bundles(directions: &[(Vec3, usize)], seed: u64) -> Vec<Vec3> {
        let mut rng = rng(seed);
        let mut jitter = || Vec3::from([0; 3].map(|_| rng.random_range(-0.05..0.05)));
        let bundle = |&(d, count): &(Vec3, usize)| {
            (0..count).map(|_| (d + jitter()).normalize()).collect::<Vec<_>>()
        };
        directions.iter().flat_map(bundle).collect()
    }

    /// Lloyd's algorithm again, in double precision and written another way: every pair of normal and
    /// centroid, means by dividing at the end, restarted from the given labels.
    fn second_lloyd(normals: &[Vec3], mut labels: Vec<usize>, k: usize) -> Vec<usize> {
        loop {
            let mean = |c: usize| {
                let members = || (0..normals.len()).filter(|&i| labels[i] == c);
                let sum: glam::DVec3 = members().map(|i| normals[i].as_dvec3()).sum();
                sum / members().count() as f64
            };
            let means: Vec<_> = (0..k).map(mean).collect();
            let closest = |n: &Vec3| {
                let n = n.as_dvec3();
                (0..k).min_by(|&a, &b| n.distance(means[a]).total_cmp(&n.distance(means[b])))
            };
            let next: Vec<usize> = normals.iter().filter_map(closest).collect();
            if next == labels {
                return labels;
            }
            labels = next;
        }
    }

    #[test]
    fn clusters_are_the_bundles_by_size() {
        let directions = [(Vec3::Y, 50), (Vec3::Z, 100), (Vec3::X, 20)];
        let normals = bundles(&directions, 1);
        for seed in 0..20 {
            let clustering = cluster(&normals, 3, &mut rng(seed));
            let sizes: Vec<_> = clustering.clusters.iter().map(|c| c.size).collect();
            assert_eq!(sizes, [100, 50, 20]);
            for (cluster, expected) in clustering.clusters.iter().zip([Vec3::Z, Vec3::Y, Vec3::X]) {
                assert!(cluster.direction.dot(expected) > 0.999);
            }
            assert_eq!(clustering.labels[0], 1);
        }
    }

    proptest! {
        #[test]
        fn the_result_is_a_fixed_point_of_a_second_implementation(seed: u64, k in 1usize..6) {
            let mut source = rng(seed);
            let draw = |_| Vec3::from([0; 3].map(|_| source.random_range(-1.0..1.0))).normalize_or(Vec3::X);
            let normals: Vec<Vec3> = (0..200).map(draw).collect();
            let ours = cluster(&normals, k, &mut rng(seed ^ 1));
            let theirs = second_lloyd(&normals, ours.labels.clone(), k);
            prop_assert_eq!(&ours.labels, &theirs);
            let planted: Vec<usize> = ours.labels.iter().map(|l| (l + usize::from(*l == 0)) % k).collect();
            prop_assert!(k == 1 || planted != theirs);
        }
    }

    #[test]
    fn few_or_no_normals_still_give_k_directions() {
        let clustering = cluster(&[Vec3::Y; 4], 3, &mut rng(0));
        assert_eq!(clustering.clusters.iter().map(|c| c.size).collect::<Vec<_>>(), [4, 0, 0]);
        assert!(clustering.clusters.iter().all(|c| c.direction == Vec3::Y));
        assert_eq!(cluster(&[], 2, &mut rng(0)).clusters.len(), 2);
    }
}
