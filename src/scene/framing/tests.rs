use super::*;
use crate::scene::{Instance, Material, Mesh, Vertex};
use bytemuck::Zeroable;
use proptest::prelude::*;

/// A scene whose triangles are the points three by three.
fn scene(points: &[[f32; 3]], world: DMat4) -> Scene {
    let vertex = |&position: &[f32; 3]| Vertex { position, ..Vertex::zeroed() };
    let mesh = Mesh {
        vertices: points.iter().map(vertex).collect(),
        indices: (0..points.len() as u32 / 3 * 3).collect(),
        ..Mesh::default()
    };
    let instance = Instance { name: String::new(), mesh: 0, world, first_polygon: 1 };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        instances: vec![instance],
        ..Scene::default()
    }
}

/// Smallest and largest picture coordinates, −1..1 across the picture.
fn projected(scene: &Scene, camera: &Camera, aspect: f64) -> [[f64; 2]; 2] {
    let Projection::Perspective { yfov } = camera.projection else { unreachable!() };
    let half = (yfov / 2.0).tan();
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let mesh = &scene.meshes[0];
    for &index in &mesh.indices {
        let position = Vec3::from(mesh.vertices[index as usize].position).as_dvec3();
        let p = scene.instances[0].world.transform_point3(position) - camera.eye;
        let depth = -p.dot(camera.back);
        assert!(depth > camera.near && depth < camera.far.unwrap_or(f64::INFINITY));
        let at = [p.dot(camera.right) / (depth * half * aspect), p.dot(camera.up) / (depth * half)];
        for (bound, at) in bounds.iter_mut().zip(at) {
            *bound = [bound[0].min(at), bound[1].max(at)];
        }
    }
    bounds
}

fn assert_framed(scene: &Scene, framing: &Framing, aspect: f64) {
    let camera = frame(scene, framing, aspect).expect("the scene has extent");
    let limits = projected(scene, &camera, aspect);
    let sizes = limits.map(|[low, high]| (high - low) / 2.0);
    let largest = sizes[0].max(sizes[1]);
    let (_, radius) = bounds(scene).expect("the scene has extent");
    let closest = camera.near < 0.901 * CLOSEST * radius;
    let fills = (largest - framing.fill).abs() < 1e-3;
    assert!(fills || closest && largest < framing.fill, "{limits:?}");
    for [low, high] in limits {
        assert!((low + high).abs() < 1e-3, "{limits:?}");
    }
    let axes = DMat3::from_cols(camera.right, camera.up, camera.back);
    assert!((axes.determinant() - 1.0).abs() < 1e-9);
}

proptest! {
    #[test]
    fn scenes_fill_the_picture_and_stand_in_its_middle(
        points in prop::collection::vec(prop::array::uniform3(-1f32..1.0), 6..40),
        flat in prop::option::of(0usize..3),
        azimuth in -7.0..7.0,
        elevation in prop_oneof![Just(-90.0), Just(90.0), -90.0..90.0],
        fov in 1.0..150.0,
        fill in 0.1..1.0,
        aspect in 0.2..5.0,
        exponent in -12i32..12,
        shift in prop::array::uniform3(-3.0..3.0),
    ) {
        let mut points = points;
        if let Some(axis) = flat {
            points.iter_mut().for_each(|p| p[axis] = 0.25);
        }
        let unit = 10f64.powi(exponent);
        let world = DMat4::from_scale(DVec3::splat(unit)) * DMat4::from_translation(shift.into());
        let (elevation, fov) = (f64::to_radians(elevation), f64::to_radians(fov));
        let framing = Framing { azimuth, elevation, fov, fill };
        assert_framed(&scene(&points, world), &framing, aspect);
    }
}

#[test]
fn azimuth_turns_to_the_right_and_elevation_up() {
    let cube = [[-1., -1., -1.], [1., 1., 1.], [1., -1., 1.]];
    let scene = scene(&cube, DMat4::IDENTITY);
    let back = |azimuth: f64, elevation: f64| {
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        let framing = Framing { azimuth, elevation, ..Framing::default() };
        frame(&scene, &framing, 1.0).expect("the scene has extent").back
    };
    assert!(back(0.0, 0.0).abs_diff_eq(DVec3::Z, 1e-12));
    assert!(back(90.0, 0.0).abs_diff_eq(DVec3::X, 1e-12));
    assert!(back(45.0, 90.0).abs_diff_eq(DVec3::Y, 1e-12));
}

#[test]
fn a_line_along_the_view_is_seen_from_before_it() {
    let line = [[0., 0., -1.], [0., 0., 0.], [0., 0., 1.]];
    let framing = Framing { azimuth: 0.0, elevation: 0.0, ..Framing::default() };
    let camera = frame(&scene(&line, DMat4::IDENTITY), &framing, 1.0).expect("it has extent");
    assert!(camera.eye.z > 1.0 && camera.near > 0.0);
}

#[test]
fn values_out_of_range_are_refused() {
    let triangle = scene(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], DMat4::IDENTITY);
    let default = Framing::default();
    for framing in [
        Framing { azimuth: f64::NAN, ..default },
        Framing { elevation: 2.0, ..default },
        Framing { fov: 0.0, ..default },
        Framing { fov: 3.2, ..default },
        Framing { fill: 1.1, ..default },
    ] {
        assert!(matches!(frame(&triangle, &framing, 1.0), Err(Error::Argument(_))));
    }
    assert!(frame(&triangle, &default, 0.0).is_err());
    assert!(frame(&Scene::default(), &default, 1.0).is_err());
}

/// The picture coordinates of a scene's vertices through each of `cameras`, as [`projected`] has them.
fn all_projected(scenes: &[&Scene], cameras: &[Camera]) -> Vec<[[f64; 2]; 2]> {
    let through = |camera| scenes.iter().map(move |scene| projected(scene, camera, 1.0));
    cameras.iter().flat_map(through).collect()
}

#[test]
fn a_turntable_keeps_its_axis_in_the_middle_and_all_in_sight() {
    let points =
        [[-1., 0., 0.2], [0.4, 2., 0.], [0., 1., -0.7], [3., 0.5, 0.], [1., 0., 1.], [0., 0., 0.]];
    let scene = scene(&points, DMat4::IDENTITY);
    let framing = Framing::default();
    let cameras = around(&[&scene], &framing, 1.0, 8).unwrap();
    let (center, _) = bounds(&scene).unwrap();
    let single = frame(&scene, &framing, 1.0).unwrap();
    assert_eq!((cameras.len(), cameras[0].back), (8, single.back));
    let place = |camera: &Camera| (camera.eye - center).dot(camera.right);
    assert!(cameras.iter().all(|camera| place(camera).abs() < 1e-9));
    let heights: Vec<f64> = cameras.iter().map(|camera| camera.eye.y).collect();
    assert!(heights.iter().all(|height| (height - heights[0]).abs() < 1e-9), "{heights:?}");
    // An eighth of a turn to the scene's right, seven times.
    for (a, b) in cameras.iter().zip(&cameras[1..]) {
        let turn = DMat3::from_rotation_y(std::f64::consts::FRAC_PI_4);
        assert!((turn * (a.eye - center)).abs_diff_eq(b.eye - center, 1e-9));
    }
    let limits = all_projected(&[&scene], &cameras);
    let most = limits.iter().flatten().flatten().fold(0f64, |most, at| most.max(at.abs()));
    assert!((most - framing.fill).abs() < 1e-3, "{most}");
}

#[test]
fn one_camera_shows_all_moments() {
    let triangle = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let moments = [0.0, 1.5, 4.0]
        .map(|shift| scene(&triangle, DMat4::from_translation(DVec3::new(shift, 0.0, 0.0))));
    let scenes: Vec<&Scene> = moments.iter().collect();
    let framing = Framing::default();
    let camera = around(&scenes, &framing, 1.0, 1).unwrap();
    let limits = all_projected(&scenes, &camera);
    let low = limits.iter().map(|[[low, _], _]| *low).fold(f64::INFINITY, f64::min);
    let high = limits.iter().map(|[[_, high], _]| *high).fold(f64::NEG_INFINITY, f64::max);
    assert!((high - framing.fill).abs() < 1e-3 && (low + high).abs() < 1e-3, "{low} {high}");
    assert!(around(&[], &framing, 1.0, 1).is_err());
}
