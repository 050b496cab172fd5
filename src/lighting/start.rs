//! Where the search starts: lights in the directions that most of what is visible faces, from a
//! k-means clustering of the visible polygons' normals (Ha and Olivier 2006, section 4).

use super::genome::{Genome, Range};
use super::{Light, Role, angles};
use crate::error::within;
use crate::objective::maps::{Maps, PixelType};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use glam::{DMat3, Vec3};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Most pixels whose normals are clustered.
const MAX_SAMPLES: usize = 1 << 16;

/// Lloyd iterations at most; clusterings of normals settle in far fewer.
const ITERATIONS: usize = 100;

/// How the first population spreads around the clusters. The numbers are our reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StartSettings {
    /// Share of the population that scatters around the clusters' individual, 0..=1; the rest is
    /// uniform in the box.
    pub scattered: f32,
    /// Standard deviation of that scatter as a share of each allele's range, 0..=1.
    pub spread: f32,
}

impl Default for StartSettings {
    fn default() -> Self {
        Self { scattered: 0.3333, spread: 0.1 }
    }
}

impl StartSettings {
    /// # Errors
    /// [`Error::Argument`] for a share outside 0..=1.
    pub fn check(&self) -> Result<()> {
        within("start.scattered", self.scattered, 0.0, 1.0)?;
        within("start.spread", self.spread, 0.0, 1.0)
    }
}

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

/// Unit normals of the visible polygons in the light frame, turned to the viewer, in the order of
/// [`Maps::visible`]; polygons without area are given the viewer's direction.
fn visible_normals(scene: &Scene, view: &View, maps: &Maps) -> Vec<Vec3> {
    let from_world = view.frame.from_world();
    let rotation = DMat3::from_mat4(from_world) * view.frame.radius;
    let normal = |&code: &u32| {
        let (instance, triangle) = scene.polygon(code)?;
        let [a, b, c] = scene.corners(instance, triangle);
        let normal = (rotation * (b - a).cross(c - a)).try_normalize()?.as_vec3();
        let middle = from_world.transform_point3((a + b + c) / 3.0).as_vec3();
        let away = normal.dot(view.towards_viewer(middle)) < 0.0;
        Some(if away { -normal } else { normal })
    };
    maps.visible.par_iter().map(|code| normal(code).unwrap_or(Vec3::Z)).collect()
}

/// The visible polygons' normals in `k` clusters; [`Clustering::labels`] are in the order of
/// [`Maps::visible`].
pub fn visible_clusters(
    scene: &Scene,
    view: &View,
    maps: &Maps,
    k: usize,
    rng: &mut impl Rng,
) -> Clustering {
    cluster(&visible_normals(scene, view, maps), k, rng)
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

/// The chromosome with its lights in the clusters' directions, moved to the nearest point of their
/// boxes, and every other value in the middle of its range. The first clusters are the key lights',
/// wherever in the rig these stand; the others follow in the rig's order.
pub fn from_clusters(genome: &Genome, clusters: &[Cluster]) -> Vec<f32> {
    let middle: Vec<f32> = genome.bounds().iter().map(Range::middle).collect();
    let mut rig = genome.decode(&middle);
    let mut lights: Vec<&mut Light> = rig.iter_mut().collect();
    lights.sort_by_key(|light| light.role != Role::Key);
    for (light, cluster) in lights.into_iter().zip(clusters) {
        (light.elevation, light.azimuth) = angles(cluster.direction);
    }
    genome.encode(&rig)
}

/// The individual that the visible polygons' clusters suggest.
pub fn first(
    scene: &Scene,
    view: &View,
    maps: &Maps,
    genome: &Genome,
    rng: &mut impl Rng,
) -> Vec<f32> {
    let clustering = visible_clusters(scene, view, maps, genome.lights(), rng);
    from_clusters(genome, &clustering.clusters)
}

/// The individual that a surface without a scene suggests: that of the clusters of its object pixels'
/// normals, so that what is large in the picture weighs more. Of a large picture every n-th object
/// pixel counts, 65,536 at most.
pub fn first_of_surface(maps: &Maps, genome: &Genome, rng: &mut impl Rng) -> Vec<f32> {
    let clustering = cluster(&surface_normals(maps), genome.lights(), rng);
    from_clusters(genome, &clustering.clusters)
}

/// Normals of every n-th object pixel, [`MAX_SAMPLES`] at most.
fn surface_normals(maps: &Maps) -> Vec<Vec3> {
    let pixels = std::iter::zip(&maps.types, &maps.surface.normal);
    let object = pixels.filter(|&(&kind, _)| kind != PixelType::Background);
    let step = object.clone().count().div_ceil(MAX_SAMPLES).max(1);
    object.step_by(step).map(|(_, &normal)| normal.into()).collect()
}

/// The individual of a given rig, each value moved to the nearest one of its box. Lights are taken by
/// role; a role that the rig has too few of takes what is left, in order.
///
/// # Errors
/// [`Error::Argument`] when the rig has another number of lights.
pub fn from_rig(genome: &Genome, rig: &[Light]) -> Result<Vec<f32>> {
    let (given, wanted) = (rig.len(), genome.lights());
    if given != wanted {
        let fault = format!("a rig of {given} lights cannot start a search for {wanted}");
        return Err(Error::Argument(fault));
    }
    let mut left = rig.to_vec();
    let mut chosen: Vec<Option<Light>> = genome
        .roles()
        .iter()
        .map(|role| {
            let at = left.iter().position(|light| light.role == *role)?;
            Some(left.remove(at))
        })
        .collect();
    let mut left = left.into_iter();
    chosen.iter_mut().filter(|light| light.is_none()).for_each(|light| *light = left.next());
    let rig: Vec<Light> = chosen.into_iter().flatten().collect();
    Ok(genome.encode(&rig))
}

/// The first population: `first` itself, some scattered around it, the rest uniform in the box.
pub fn population(
    bounds: &[Range],
    first: Vec<f32>,
    size: usize,
    settings: &StartSettings,
    rng: &mut impl Rng,
) -> Vec<Vec<f32>> {
    let scattered = (size as f32 * settings.scattered).round() as usize;
    let mut population = vec![first];
    while population.len() < size {
        let near = population.len() <= scattered;
        let individual =
            std::iter::zip(bounds, &population[0])
                .map(|(range, &center)| {
                    if near { range.step(center, settings.spread, rng) } else { range.uniform(rng) }
                })
                .collect();
        population.push(individual);
    }
    population
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::LightKind;
    use crate::lighting::genome::Boxes;
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

        #[test]
        fn first_populations_stay_in_the_box(seed: u64, point: bool) {
            let kind = if point { LightKind::Point } else { LightKind::Directional };
            let genome = Genome::new(&[Role::Key, Role::Rim], kind, &Boxes::default()).unwrap();
            let clusters = cluster(&bundles(&[(-Vec3::Z, 5), (Vec3::Y, 4)], seed), 2, &mut rng(seed));
            let first = from_clusters(&genome, &clusters.clusters);
            let population = population(genome.bounds(), first.clone(), 30, &StartSettings::default(), &mut rng(seed));
            prop_assert_eq!(population.len(), 30);
            prop_assert_eq!(&population[0], &first);
            for individual in &population {
                prop_assert!(genome.bounds().iter().zip(individual).all(|(r, &x)| r.contains(x)));
            }
        }
    }

    #[test]
    fn the_largest_cluster_is_the_key_lights() {
        let clusters = [(Vec3::Z, 9), (Vec3::Y, 4), (-Vec3::Z, 2)]
            .map(|(direction, size)| Cluster { direction, size });
        let elevations = |roles: &[Role]| {
            let genome = Genome::new(roles, LightKind::Point, &Boxes::default()).unwrap();
            let rig = genome.decode(&from_clusters(&genome, &clusters));
            rig.iter().map(|light| light.elevation.to_degrees().round()).collect::<Vec<_>>()
        };
        assert_eq!(elevations(&[Role::Key, Role::Fill]), [0.0, 90.0]);
        assert_eq!(elevations(&[Role::Fill, Role::Key]), [90.0, 0.0]);
        assert_eq!(elevations(&[Role::Fill, Role::Rim, Role::Key]), [90.0, 0.0, 0.0]);
    }

    /// A picture of `counts` pixels of each kind, row after row.
    fn pixels(counts: &[(PixelType, Vec3, usize)]) -> Maps {
        let mut maps = Maps::default();
        for &(kind, normal, count) in counts {
            maps.types.extend(vec![kind; count]);
            maps.surface.normal.extend(vec![normal.to_array(); count]);
        }
        maps
    }

    #[test]
    fn a_surface_alone_suggests_what_most_of_its_object_pixels_face() {
        use PixelType::{Background, Edge, Surface};
        let roles = [Role::Key, Role::Fill];
        let genome = Genome::new(&roles, LightKind::Directional, &Boxes::default()).unwrap();
        let elevations = |maps: &Maps| {
            let rig = genome.decode(&first_of_surface(maps, &genome, &mut rng(3)));
            rig.iter().map(|light| light.elevation.to_degrees().round()).collect::<Vec<_>>()
        };
        let (up, front) = (Vec3::Y, Vec3::Z);
        let background = (Background, front, 900);
        let maps = pixels(&[background, (Surface, up, 200), (Edge, front, 100)]);
        assert_eq!(elevations(&maps), [90.0, 0.0]);
        let maps = pixels(&[background, (Surface, up, 200), (Edge, front, 300)]);
        assert_eq!(elevations(&maps), [0.0, 90.0]);
    }

    #[test]
    fn large_pictures_are_sampled_evenly() {
        use PixelType::{Background, Surface};
        let third = 3 * MAX_SAMPLES + 5;
        let faces = [Vec3::X, Vec3::Y, Vec3::Z];
        let parts = faces.map(|normal| (Surface, normal, third));
        let normals =
            surface_normals(&pixels(&[&parts[..], &[(Background, -Vec3::X, third)]].concat()));
        assert!((MAX_SAMPLES / 2..=MAX_SAMPLES).contains(&normals.len()), "{}", normals.len());
        for face in faces {
            let share = normals.iter().filter(|&&normal| normal == face).count();
            assert!(share.abs_diff(normals.len() / 3) <= 1, "{share}");
        }
        // A picture of that many pixels is taken whole.
        let whole = surface_normals(&pixels(&[(Surface, Vec3::X, MAX_SAMPLES)]));
        assert_eq!(whole.len(), MAX_SAMPLES);
    }

    #[test]
    fn a_given_rig_is_matched_by_role() {
        let roles = [Role::Key, Role::Fill, Role::Rim];
        let genome = Genome::new(&roles, LightKind::Point, &Boxes::default()).unwrap();
        let middle: Vec<f32> = genome.bounds().iter().map(Range::middle).collect();
        let [mut key, fill, mut rim] = <[Light; 3]>::try_from(genome.decode(&middle)).unwrap();
        (key.diffuse, rim.diffuse) = (1.5, 0.25);
        let start = from_rig(&genome, &[rim, fill, key]).unwrap();
        assert_eq!(genome.decode(&start), [key, fill, rim]);
        // A second key stands in for the missing rim, at the nearest place that rims have.
        let start = genome.decode(&from_rig(&genome, &[key, key, fill]).unwrap());
        assert_eq!(start[..2], [key, fill]);
        assert_eq!((start[2].role, start[2].diffuse), (Role::Rim, 1.0));
        assert!(from_rig(&genome, &[key, fill]).is_err());
    }

    #[test]
    fn few_or_no_normals_still_give_k_directions() {
        let clustering = cluster(&[Vec3::Y; 4], 3, &mut rng(0));
        assert_eq!(clustering.clusters.iter().map(|c| c.size).collect::<Vec<_>>(), [4, 0, 0]);
        assert!(clustering.clusters.iter().all(|c| c.direction == Vec3::Y));
        assert_eq!(cluster(&[], 2, &mut rng(0)).clusters.len(), 2);
    }
}
