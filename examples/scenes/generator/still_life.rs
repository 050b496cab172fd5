//! A still life on a round oak table: a pewter jug, a dark bottle, a hammered pot, a clay bowl of
//! plums, and two apples on a checked cloth. Metres; the table's top is y = 0.

use glam::{DVec2, DVec3, dvec3};
use serde_json::{Value, json};

use super::curve::Tube;
use super::glb::{Glb, View};
use super::mesh::{Mesh, lathe, sheet};
use super::polygonize::polygonize;
use super::texture;
use super::vessel::Vessel;

const TABLE_RADIUS: f64 = 0.36;
/// Angular divisions of the turned things.
const AROUND: u32 = 56;

/// `still-life.glb`.
pub fn scene() -> Vec<u8> {
    let mut glb = Glb::default();
    let table = table();
    let cloth = cloth();
    let mut points: Vec<DVec3> = table.points().chain(cloth.points()).collect();
    // The bottle's mouth is the highest of all.
    points.push(dvec3(0.02, 0.31, -0.17));
    let mut roots = vec![
        add_table(&mut glb, &table),
        add_cloth(&mut glb, &cloth),
        add_jug(&mut glb),
        add_bottle(&mut glb),
        add_pot(&mut glb),
        add_bowl(&mut glb),
    ];
    roots.extend(add_apples(&mut glb));
    let view = View { azimuth: 8.0, elevation: 19.0, yfov: 0.5, fill: 0.92 };
    roots.push(glb.add_camera("painter", view, &points));
    glb.finish("still life", &roots)
}

fn material(name: &str, colour: [f64; 3], metallic: f64, roughness: f64) -> Value {
    let [r, g, b] = colour;
    json!({ "name": name, "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0],
        "metallicFactor": metallic, "roughnessFactor": roughness } })
}

/// Rotation about +Y by degrees, as a quaternion.
fn turned(degrees: f64) -> [f64; 4] {
    let half = degrees.to_radians() * 0.5;
    [0.0, libm::sin(half), 0.0, libm::cos(half)]
}

/// Rotation about +Z by degrees, as a quaternion.
fn tilted(degrees: f64) -> [f64; 4] {
    let half = degrees.to_radians() * 0.5;
    [0.0, 0.0, libm::sin(half), libm::cos(half)]
}

fn table() -> Mesh {
    let r = TABLE_RADIUS;
    let outline = [
        [0.0, -0.036],
        [0.5 * r, -0.036],
        [r - 0.04, -0.036],
        [r - 0.02, -0.036],
        [r - 0.010, -0.034],
        [r - 0.002, -0.027],
        [r, -0.018],
        [r - 0.002, -0.009],
        [r - 0.010, -0.002],
        [r - 0.02, 0.0],
        [r - 0.04, 0.0],
        [0.5 * r, 0.0],
        [0.0, 0.0],
    ];
    let mut mesh = lathe(&outline, 96, 2);
    // The boards lie across; down the rim the grain runs on.
    for (uv, [x, y, z]) in mesh.uvs.iter_mut().zip(&mesh.positions) {
        *uv = [(x + y) * 2.2, (z - y) * 2.2];
    }
    mesh.tangents.clear();
    mesh
}

fn add_table(glb: &mut Glb, table: &Mesh) -> usize {
    let texture = glb.add_texture("oak", &texture::wood());
    let oak = glb.add_material(json!({ "name": "oak", "pbrMetallicRoughness": {
        "baseColorTexture": { "index": texture },
        "metallicFactor": 0.0, "roughnessFactor": 0.5 } }));
    let mesh = glb.add_mesh("table", &[(table, oak)]);
    glb.add_node(json!({ "name": "table", "mesh": mesh }))
}

/// A cloth that lies on the table in shallow folds and hangs over its front rim.
fn cloth() -> Mesh {
    const BEND: f64 = 0.014;
    let quarter = BEND * std::f64::consts::FRAC_PI_2;
    let mut mesh = sheet(44, 60, &|uv: DVec2| {
        // Metres from the far hem.
        let along = 0.40 * (1.0 - uv.y);
        let x = -0.02 + 0.27 * uv.x + 0.10 * (uv.y - 0.35) * (1.0 - 0.3 * uv.x);
        let rim = libm::sqrt(TABLE_RADIUS * TABLE_RADIUS - x * x) - 0.01;
        let start = 0.03 * uv.x;
        let past = start + along - rim;
        let angle = (past / BEND).clamp(0.0, std::f64::consts::FRAC_PI_2);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let hang = (past - quarter).max(0.0);
        // Folds swell towards the hanging hem.
        let swell = 0.0025 + 0.11 * hang;
        let fold = libm::sin(uv.x * 15.0 + 2.5 * uv.y + libm::sin(uv.y * 7.0));
        let lift = 0.003 + swell * (1.0 + fold);
        let z = rim + past.min(0.0) + BEND * sin + lift * sin;
        let y = -BEND * (1.0 - cos) - hang + lift * cos;
        dvec3(x, y, z)
    });
    for uv in &mut mesh.uvs {
        *uv = [uv[0] * 2.7, uv[1] * 4.0];
    }
    mesh.tangents.clear();
    mesh
}

fn add_cloth(glb: &mut Glb, cloth: &Mesh) -> usize {
    let texture = glb.add_texture("linen", &texture::linen());
    let linen = glb.add_material(json!({ "name": "linen", "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": texture },
            "metallicFactor": 0.0, "roughnessFactor": 0.95 } }));
    let mesh = glb.add_mesh("cloth", &[(cloth, linen)]);
    glb.add_node(json!({ "name": "cloth", "mesh": mesh }))
}

fn add_jug(glb: &mut Glb) -> usize {
    let vessel = Vessel {
        radii: vec![0.055, 0.052, 0.068, 0.078, 0.076, 0.062, 0.046, 0.04, 0.042, 0.05],
        height: 0.25,
        wall: 0.012,
        floor: 0.15,
    };
    let handle = Tube::new(&[
        ([-0.036, 0.225, 0.0], 0.0085),
        ([-0.085, 0.238, 0.0], 0.008),
        ([-0.118, 0.18, 0.0], 0.008),
        ([-0.1, 0.115, 0.0], 0.008),
        ([-0.07, 0.085, 0.0], 0.010),
    ]);
    let field = |p: DVec3| {
        // The lip is the rim drawn out towards +X.
        let drawn = ((p.y - 0.19) / 0.06).clamp(0.0, 1.0);
        let front = (p.x / 0.05).clamp(0.0, 1.0);
        let narrow = (1.0 - p.z * p.z / 0.0012).max(0.0);
        let lip = 0.026 * drawn * drawn * front * front * narrow * narrow;
        let bands = [0.02, 0.172].iter().fold(0.0, |sum, y| {
            let t = (1.0 - (p.y - y).abs() / 0.011).max(0.0);
            sum + 0.003 * t * t * (3.0 - 2.0 * t)
        });
        let body = vessel.distance(p - dvec3(lip, 0.0, 0.0), bands);
        vessel.attach(p, body, handle.distance(p))
    };
    let mesh = polygonize(&field, dvec3(-0.15, -0.02, -0.11), dvec3(0.13, 0.28, 0.11), 0.0054);
    let pewter = glb.add_material(material("pewter", [0.62, 0.60, 0.56], 1.0, 0.34));
    let mesh = glb.add_mesh("jug", &[(&mesh, pewter)]);
    glb.add_node(json!({ "name": "jug", "mesh": mesh,
        "translation": [-0.165, 0.0, -0.10], "rotation": turned(-20.0) }))
}

fn add_bottle(glb: &mut Glb) -> usize {
    let outline = [
        [0.0, 0.006],
        [0.024, 0.003],
        [0.034, 0.0],
        [0.039, 0.006],
        [0.04, 0.05],
        [0.04, 0.1],
        [0.04, 0.15],
        [0.034, 0.178],
        [0.02, 0.202],
        [0.0145, 0.23],
        [0.0135, 0.26],
        [0.0135, 0.284],
        [0.0165, 0.288],
        [0.017, 0.298],
        [0.0145, 0.304],
        [0.011, 0.301],
        [0.01, 0.28],
        [0.0, 0.275],
    ];
    let mesh = lathe(&outline, AROUND, 3);
    let glass = glb.add_material(material("bottle glass", [0.012, 0.035, 0.018], 0.0, 0.07));
    let mesh = glb.add_mesh("bottle", &[(&bare(mesh), glass)]);
    glb.add_node(json!({ "name": "bottle", "mesh": mesh, "translation": [0.02, 0.0, -0.17] }))
}

/// Without texture coordinates, for materials without textures.
fn bare(mut mesh: Mesh) -> Mesh {
    mesh.uvs.clear();
    mesh.tangents.clear();
    mesh
}

fn add_pot(glb: &mut Glb) -> usize {
    let outline = [
        [0.0, 0.004],
        [0.035, 0.001],
        [0.05, 0.002],
        [0.068, 0.018],
        [0.085, 0.05],
        [0.088, 0.08],
        [0.076, 0.112],
        [0.058, 0.13],
        [0.053, 0.14],
        [0.06, 0.152],
        [0.064, 0.157],
        [0.061, 0.161],
        [0.054, 0.155],
        [0.047, 0.14],
        [0.05, 0.128],
        [0.066, 0.11],
        [0.07, 0.08],
        [0.04, 0.03],
        [0.0, 0.02],
    ];
    let mut mesh = lathe(&outline, AROUND, 3);
    for uv in &mut mesh.uvs {
        *uv = [uv[0] * 4.0, uv[1] * 4.0];
    }
    let texture = glb.add_texture("hammer marks", &texture::hammered());
    let mut glaze = material("cobalt glaze", [0.035, 0.075, 0.22], 0.0, 0.3);
    glaze["normalTexture"] = json!({ "index": texture, "scale": 0.7 });
    let glaze = glb.add_material(glaze);
    let mesh = glb.add_mesh("pot", &[(&mesh, glaze)]);
    glb.add_node(json!({ "name": "pot", "mesh": mesh, "translation": [0.19, 0.0, -0.07] }))
}

/// A bowl with three plums: one mesh, placed by three nodes.
fn add_bowl(glb: &mut Glb) -> usize {
    let outline = [
        [0.0, 0.003],
        [0.03, 0.0],
        [0.045, 0.0],
        [0.051, 0.006],
        [0.08, 0.026],
        [0.103, 0.055],
        [0.113, 0.082],
        [0.112, 0.087],
        [0.107, 0.086],
        [0.097, 0.058],
        [0.075, 0.033],
        [0.04, 0.018],
        [0.0, 0.014],
    ];
    let clay = glb.add_material(material("clay", [0.52, 0.24, 0.13], 0.0, 0.95));
    let bowl = glb.add_mesh("bowl", &[(&bare(lathe(&outline, AROUND, 3)), clay)]);
    let skin = glb.add_material(material("plum skin", [0.11, 0.02, 0.07], 0.0, 0.32));
    let plum = glb.add_mesh("plum", &[(&bare(plum()), skin)]);
    let places = [
        ([0.043, 0.058, 0.018], turned(70.0), [1.0, 1.0, 1.0]),
        ([-0.038, 0.057, 0.026], tilted(35.0), [0.95, 1.05, 0.95]),
        ([-0.006, 0.060, -0.043], tilted(-50.0), [1.03, 0.97, 1.03]),
    ];
    let mut children = vec![glb.add_node(json!({ "name": "bowl", "mesh": bowl }))];
    for (i, (translation, rotation, scale)) in places.into_iter().enumerate() {
        children.push(glb.add_node(json!({ "name": format!("plum {}", i + 1), "mesh": plum,
            "translation": translation, "rotation": rotation, "scale": scale })));
    }
    glb.add_node(json!({ "name": "bowl of plums", "children": children,
        "translation": [-0.115, 0.0, 0.145], "scale": [1.05, 1.05, 1.05] }))
}

/// A plum of radius 35 mm about its centre, with a seam.
fn plum() -> Mesh {
    sheet(40, 28, &|uv: DVec2| {
        let around = uv.x * std::f64::consts::TAU;
        let up = -libm::cos(uv.y * std::f64::consts::PI);
        let seam = libm::exp(-40.0 * (1.0 - libm::cos(around)));
        let dip = libm::exp(-30.0 * (1.0 - up));
        let r = 0.035 * libm::sqrt(1.0 - up * up) * (1.0 - 0.05 * seam);
        let y = 0.036 * up - 0.006 * dip;
        dvec3(r * libm::sin(around), y, r * libm::cos(around))
    })
}

/// Two apples of one mesh, each with its stalk.
fn add_apples(glb: &mut Glb) -> [usize; 2] {
    let outline = [
        [0.0, 0.011],
        [0.007, 0.007],
        [0.016, 0.002],
        [0.026, 0.007],
        [0.036, 0.026],
        [0.0405, 0.047],
        [0.036, 0.066],
        [0.024, 0.0755],
        [0.012, 0.073],
        [0.005, 0.065],
        [0.0, 0.061],
    ];
    let mut apple = bare(lathe(&outline, AROUND, 4));
    apple.colours = apple.points().map(blush).collect();
    let skin = glb.add_material(material("apple skin", [1.0, 1.0, 1.0], 0.0, 0.22));
    let apple = glb.add_mesh("apple", &[(&apple, skin)]);
    let bark = glb.add_material(material("stalk", [0.09, 0.05, 0.025], 0.0, 0.8));
    let twig = [[0.0, 0.0], [0.0012, 0.001], [0.0012, 0.012], [0.0018, 0.026], [0.0, 0.028]];
    let stalk = glb.add_mesh("stalk", &[(&bare(lathe(&twig, 10, 2)), bark)]);
    let mut place = |name: &str, translation: [f64; 3], rotation: [f64; 4], scale: f64| {
        let stalk = glb.add_node(json!({ "name": format!("{name}'s stalk"), "mesh": stalk,
            "translation": [0.0, 0.058, 0.0], "rotation": tilted(14.0) }));
        glb.add_node(json!({ "name": name, "mesh": apple, "children": [stalk],
            "translation": translation, "rotation": rotation, "scale": [scale, scale, scale] }))
    };
    [
        place("front apple", [0.085, 0.005, 0.215], turned(30.0), 1.0),
        place("back apple", [0.165, 0.005, 0.13], turned(190.0), 0.94),
    ]
}

/// Linear colour of the apple's skin: red on the sunny side, streaked, yellow-green around the
/// stalk and below.
fn blush(p: DVec3) -> [u8; 4] {
    let around = libm::atan2(p.x, p.z);
    let streaks = 0.10 * libm::sin(around * 13.0) + 0.06 * libm::sin(around * 29.0 + 1.0);
    let height = (p.y - 0.04) / 0.04;
    let red = 0.72 + 0.35 * libm::cos(around) + streaks - 0.75 * height * height * height * height;
    let red = red.clamp(0.0, 1.0);
    let colour = dvec3(0.55, 0.47, 0.08).lerp(dvec3(0.46, 0.025, 0.02), red);
    let [r, g, b] = (colour * 255.0 + 0.5).as_uvec3().to_array().map(|c| c as u8);
    [r, g, b, u8::MAX]
}
