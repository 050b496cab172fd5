//! Where a search starts: lights in the directions that most of what is visible faces, from a
//! k-means clustering of the visible polygons' normals (Ha and Olivier 2006, section 4).

use crate::lighting::clusters::{Cluster, Clustering, cluster};
use crate::lighting::genome::Genome;
use crate::lighting::{Light, Rig, Role, angles};
use crate::math::range::Range;
use crate::objective::maps::{Maps, PixelType};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use glam::{DMat3, Vec3};
use rand::Rng;
use rayon::prelude::*;

/// Most pixels whose normals are clustered.
const MAX_SAMPLES: usize = 1 << 16;

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

/// The individual of a given rig, each value moved to the nearest one of its box. Lights are taken as [`matched`] has
/// them.
///
/// # Errors
/// [`Error::Argument`] when the rig has another number of lights.
pub fn from_rig(genome: &Genome, rig: &[Light]) -> Result<Vec<f32>> {
    Ok(genome.encode(&matched(genome, rig)?))
}

/// The lights of a given rig in the order of the genome's: by role; a role that the rig has too few of takes what is
/// left, in order.
///
/// # Errors
/// [`Error::Argument`] when the rig has another number of lights.
pub fn matched(genome: &Genome, rig: &[Light]) -> Result<Rig> {
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
    Ok(chosen.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::profile;
    use crate::lighting::genome::Boxes;
    use crate::lighting::presets::Preset;
    use crate::lighting::{LightKind, direction};
    use crate::optimize::start::{StartSettings, population};
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    proptest! {
        #[test]
        fn first_populations_stay_in_the_box(seed: u64, point: bool) {
            let kind = if point { LightKind::POINT } else { LightKind::DIRECTIONAL };
            let genome = Genome::new(&[Role::Key, Role::Rim], kind, &Boxes::default()).unwrap();
            let normals = [&[-Vec3::Z; 5][..], &[Vec3::Y; 4]].concat();
            let clusters = cluster(&normals, 2, &mut rng(seed));
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
            let genome = Genome::new(roles, LightKind::POINT, &Boxes::default()).unwrap();
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
        let genome = Genome::new(&roles, LightKind::DIRECTIONAL, &Boxes::default()).unwrap();
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
        let genome = Genome::new(&roles, LightKind::POINT, &Boxes::default()).unwrap();
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
    fn searches_of_relative_boxes_start_inside_them() {
        let boxes = (profile::NATURAL.boxes)();
        for preset in Preset::ALL {
            let rig = preset.rig();
            let roles: Vec<Role> = rig.iter().map(|light| light.role).collect();
            let genome = Genome::new(&roles, LightKind::DIRECTIONAL, &boxes).unwrap();
            let start = from_rig(&genome, &rig).unwrap();
            assert!(genome.bounds().iter().zip(&start).all(|(r, &x)| r.contains(x)), "{preset:?}");
            let again = genome.encode(&genome.decode(&start));
            assert!(start.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-5), "{preset:?}");
        }
        // Both clusters to the right: the fill is as near to its own as it may stand.
        let clusters = [(40f32, 9), (70.0, 4)].map(|(azimuth, size)| Cluster {
            direction: direction(0.3, azimuth.to_radians()),
            size,
        });
        let genome = profile::NATURAL.genome().unwrap();
        let rig = genome.decode(&from_clusters(&genome, &clusters));
        let azimuths: Vec<_> = rig.iter().map(|l| l.azimuth.to_degrees().round()).collect();
        assert_eq!(azimuths, [40.0, 20.0]);
        // Intensities are in the middle of their ranges: the fill's is a share of the key's.
        assert!((rig[1].diffuse - 0.325 * rig[0].diffuse).abs() < 1e-6);
    }
}
