//! Two objects, one partly behind the other: the elephant and a glazed amphora as tall as itself.

use glam::{DVec3, dvec3};
use serde_json::json;

use super::curve::Tube;
use super::elephant::Elephant;
use super::field::smoothstep;
use super::glb::{Glb, View};
use super::mesh::Mesh;
use super::polygonize::polygonize;
use super::vessel::Vessel;

/// Where the amphora stands: behind the head, on the far side from the camera.
pub const PLACE: DVec3 = dvec3(-2.35, 0.0, 0.0);

/// `pair.glb`, with the amphora at `place`.
pub fn scene(elephant: &Elephant, place: DVec3) -> Vec<u8> {
    let mut glb = Glb::default();
    let glaze = glb.add_material(json!({ "name": "glaze", "pbrMetallicRoughness": {
        "baseColorFactor": [0.09, 0.24, 0.25, 1.0],
        "metallicFactor": 0.0, "roughnessFactor": 0.28 } }));
    let amphora = amphora();
    let vessel = glb.add_mesh("amphora", &[(&amphora, glaze)]);
    let mut points = elephant.points();
    points.extend(amphora.points().map(|point| point + place));
    let body = elephant.add_to(&mut glb);
    let view = View { azimuth: 40.0, elevation: 11.0, yfov: 0.55, fill: 0.88 };
    let roots = [
        glb.add_node(json!({ "name": "elephant", "mesh": body })),
        glb.add_node(json!({ "name": "amphora", "mesh": vessel, "translation": place.to_array() })),
        glb.add_camera("pair", view, &points),
    ];
    glb.finish("pair", &roots)
}

/// A fluted amphora with two handles, 2.6 m tall.
fn amphora() -> Mesh {
    let vessel = Vessel {
        radii: vec![0.46, 0.38, 0.5, 0.68, 0.81, 0.86, 0.8, 0.62, 0.4, 0.31, 0.33, 0.48],
        height: 2.6,
        wall: 0.12,
        floor: 1.6,
    };
    let handle = Tube::new(&[
        ([0.3, 2.25, 0.0], 0.07),
        ([0.62, 2.38, 0.0], 0.068),
        ([0.88, 2.08, 0.0], 0.068),
        ([0.72, 1.62, 0.0], 0.08),
    ]);
    let field = |p: DVec3| {
        let belly = smoothstep(0.35, 0.7, p.y) * (1.0 - smoothstep(1.5, 1.9, p.y));
        let flutes = libm::cos(18.0 * libm::atan2(p.z, p.x) + 2.2 * p.y);
        let collar = smoothstep(1.96, 2.06, p.y) * (1.0 - smoothstep(2.06, 2.16, p.y));
        let body = vessel.distance(p, 0.026 * belly * flutes + 0.045 * collar);
        // The handles lie in a plane across the view.
        let q = dvec3(0.77 * p.x - 0.64 * p.z, p.y, 0.77 * p.z + 0.64 * p.x);
        vessel.attach(p, body, handle.distance(dvec3(q.x.abs(), q.y, q.z)))
    };
    polygonize(&field, dvec3(-1.2, -0.2, -1.2), dvec3(1.2, 2.9, 1.2), 0.052)
}
