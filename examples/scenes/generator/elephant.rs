//! An African elephant in mid-step, facing +Z, the ground at y = 0. Metres.

use glam::{DVec2, DVec3, dvec2, dvec3};
use serde_json::json;

use super::curve::Tube;
use super::field::{difference, ellipsoid, intersection, plate, smoothstep, sphere, turn_y, union};
use super::glb::{Glb, View};
use super::mesh::Mesh;
use super::polygonize::polygonize;

/// Grid cell of the skin, in metres.
const CELL: f64 = 0.044;

/// The head is turned by this angle about the neck, in radians.
const HEAD_TURN: f64 = 0.22;
const NECK: DVec3 = dvec3(0.0, 1.9, 0.9);

/// The animal's surfaces, one for each material.
pub struct Elephant {
    pub skin: Mesh,
    pub ivory: Mesh,
    pub eyes: Mesh,
}

impl Elephant {
    /// Polygonises the animal.
    pub fn new() -> Self {
        let anatomy = Anatomy::new();
        let skin = |p: DVec3| anatomy.skin(p);
        let skin = polygonize(&skin, dvec3(-1.6, -0.2, -2.3), dvec3(1.6, 3.1, 3.1), CELL);
        let tusks = |p: DVec3| anatomy.tusks.distance(mirror(head_space(p)));
        let ivory = polygonize(&tusks, dvec3(-0.9, 0.8, 1.0), dvec3(1.5, 2.2, 3.1), 0.03);
        let eyes = |p: DVec3| sphere(mirror(head_space(p)), EYE, 0.046);
        let eyes = polygonize(&eyes, dvec3(-0.8, 1.8, 1.0), dvec3(1.0, 2.5, 2.1), 0.018);
        Self { skin, ivory, eyes }
    }

    pub fn points(&self) -> Vec<DVec3> {
        [&self.skin, &self.ivory, &self.eyes].into_iter().flat_map(Mesh::points).collect()
    }

    /// Adds the animal as one mesh of three materials.
    pub fn add_to(&self, glb: &mut Glb) -> usize {
        let mut material = |name: &str, colour: [f64; 3], roughness: f64| {
            let [r, g, b] = colour;
            glb.add_material(json!({ "name": name, "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": 0.0, "roughnessFactor": roughness } }))
        };
        let skin = material("elephant skin", [0.33, 0.29, 0.265], 0.55);
        let ivory = material("ivory", [0.78, 0.71, 0.58], 0.35);
        let eyes = material("eyes", [0.035, 0.025, 0.02], 0.12);
        let parts = [(&self.skin, skin), (&self.ivory, ivory), (&self.eyes, eyes)];
        glb.add_mesh("elephant", &parts)
    }
}

/// `elephant.glb`.
pub fn scene(elephant: &Elephant) -> Vec<u8> {
    let mut glb = Glb::default();
    let mesh = elephant.add_to(&mut glb);
    let body = glb.add_node(json!({ "name": "elephant", "mesh": mesh }));
    let view = View { azimuth: 47.0, elevation: 12.0, yfov: 0.55, fill: 0.86 };
    let camera = glb.add_camera("three-quarter", view, &elephant.points());
    glb.finish("elephant", &[body, camera])
}

const EYE: DVec3 = dvec3(0.392, 2.11, 1.63);

struct Anatomy {
    neck: Tube,
    legs: [Tube; 4],
    toes: Vec<DVec3>,
    trunk: Tube,
    sockets: Tube,
    lip: Tube,
    tusks: Tube,
    tail: Tube,
}

/// A leg from its joint with the body, through knee and ankle, to the sole.
fn leg(joint: [f64; 3], knee: [f64; 3], ankle: [f64; 3], thick: f64) -> Tube {
    let [x, _, z] = ankle;
    let sole = [x, 0.06, z + 0.05];
    let below = [x, -0.12, z + 0.07];
    Tube::new(&[(joint, thick), (knee, 0.265), (ankle, 0.205), (sole, 0.255), (below, 0.27)])
}

fn mirror(p: DVec3) -> DVec3 {
    dvec3(p.x.abs(), p.y, p.z)
}

fn head_space(p: DVec3) -> DVec3 {
    turn_y(p, NECK, -HEAD_TURN)
}

impl Anatomy {
    fn new() -> Self {
        let legs = [
            leg([0.36, 1.5, 0.62], [0.41, 0.78, 0.86], [0.40, 0.26, 0.92], 0.36),
            leg([-0.36, 1.5, 0.58], [-0.41, 0.80, 0.60], [-0.40, 0.26, 0.40], 0.36),
            leg([0.36, 1.5, -0.98], [0.42, 0.82, -1.02], [0.40, 0.30, -1.30], 0.38),
            leg([-0.36, 1.5, -0.92], [-0.42, 0.82, -0.66], [-0.40, 0.28, -0.80], 0.38),
        ];
        let soles = [[0.40, 0.97], [-0.40, 0.45], [0.40, -1.25], [-0.40, -0.75]];
        let mut toes = Vec::new();
        for [x, z] in soles {
            for angle in [-1.05, -0.38, 0.38, 1.05] {
                let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                toes.push(dvec3(x + 0.225 * sin, 0.055, z + 0.225 * cos));
            }
        }
        Self {
            neck: Tube::new(&[
                ([0.0, 1.78, 0.35], 0.62),
                ([0.0, 1.98, 0.85], 0.52),
                ([0.05, 2.12, 1.25], 0.44),
            ]),
            legs,
            toes,
            trunk: Tube::new(&[
                ([0.0, 2.12, 1.60], 0.29),
                ([0.0, 1.78, 1.88], 0.245),
                ([0.01, 1.36, 2.02], 0.195),
                ([0.03, 0.95, 2.03], 0.158),
                ([0.07, 0.58, 2.08], 0.128),
                ([0.11, 0.37, 2.28], 0.106),
                ([0.13, 0.45, 2.52], 0.088),
                ([0.11, 0.68, 2.57], 0.076),
            ]),
            sockets: Tube::new(&[
                ([0.17, 2.0, 1.6], 0.15),
                ([0.21, 1.78, 1.78], 0.135),
                ([0.24, 1.6, 1.9], 0.11),
            ]),
            lip: Tube::new(&[
                ([0.0, 1.72, 1.35], 0.2),
                ([0.0, 1.52, 1.56], 0.13),
                ([0.0, 1.42, 1.72], 0.06),
            ]),
            tusks: Tube::new(&[
                ([0.21, 1.80, 1.76], 0.08),
                ([0.27, 1.52, 1.95], 0.08),
                ([0.32, 1.31, 2.17], 0.073),
                ([0.335, 1.23, 2.44], 0.058),
                ([0.30, 1.28, 2.68], 0.03),
            ]),
            tail: Tube::new(&[
                ([0.0, 2.02, -1.45], 0.12),
                ([0.0, 1.82, -1.72], 0.075),
                ([0.03, 1.4, -1.83], 0.052),
                ([0.09, 1.0, -1.86], 0.046),
                ([0.12, 0.86, -1.88], 0.07),
                ([0.14, 0.66, -1.9], 0.05),
            ]),
        }
    }

    /// The skin's distance.
    fn skin(&self, p: DVec3) -> f64 {
        let body = union(self.torso(p), self.limbs(p), 0.22);
        let skin = union(body, self.head(head_space(p)), 0.16);
        let tail = union(skin, self.tail.distance(p), 0.08);
        intersection(tail + folds(p), -p.y, 0.04)
    }

    fn torso(&self, p: DVec3) -> f64 {
        let barrel = ellipsoid(p, dvec3(0.0, 1.62, -0.2), dvec3(0.76, 0.78, 1.15));
        let withers = ellipsoid(p, dvec3(0.0, 1.86, 0.42), dvec3(0.56, 0.72, 0.62));
        let rump = ellipsoid(p, dvec3(0.0, 1.78, -0.95), dvec3(0.64, 0.74, 0.62));
        let belly = ellipsoid(p, dvec3(0.0, 1.3, -0.15), dvec3(0.62, 0.52, 0.8));
        let q = mirror(p);
        let blade = ellipsoid(q, dvec3(0.44, 1.5, 0.57), dvec3(0.28, 0.64, 0.38));
        let haunch = ellipsoid(q, dvec3(0.42, 1.36, -0.98), dvec3(0.31, 0.6, 0.46));
        let trunk = union(union(barrel, withers, 0.3), union(rump, belly, 0.2), 0.3);
        let muscled = union(union(trunk, blade, 0.16), haunch, 0.18);
        union(muscled, self.neck.distance(p), 0.3)
    }

    fn limbs(&self, p: DVec3) -> f64 {
        let legs = self.legs.iter().fold(f64::INFINITY, |d, leg| d.min(leg.distance(p)));
        // Creases ring the legs around the knees and above the feet.
        let crease = smoothstep(0.18, 0.4, p.y) * (1.0 - smoothstep(0.85, 1.15, p.y));
        let rings = 0.006 * crease * libm::sin(p.y * 25.0 + 1.2 * libm::sin(p.x * 9.0 + p.z * 5.0));
        let toe = dvec3(0.075, 0.075, 0.075);
        self.toes.iter().fold(legs + rings, |d, &centre| union(d, ellipsoid(p, centre, toe), 0.03))
    }

    fn head(&self, p: DVec3) -> f64 {
        let q = mirror(p);
        let skull = ellipsoid(p, dvec3(0.0, 2.16, 1.33), dvec3(0.44, 0.52, 0.46));
        let dome = ellipsoid(p, dvec3(0.0, 2.45, 1.33), dvec3(0.33, 0.3, 0.32));
        let brow = ellipsoid(q, dvec3(0.24, 2.27, 1.55), dvec3(0.17, 0.13, 0.16));
        let cheek = ellipsoid(q, dvec3(0.25, 1.86, 1.38), dvec3(0.2, 0.3, 0.26));
        let temple = ellipsoid(q, dvec3(0.5, 2.3, 1.5), dvec3(0.13, 0.16, 0.2));
        let bone = union(union(skull, dome, 0.25), union(brow, cheek, 0.1), 0.14);
        let hollow = difference(bone, temple, 0.12);
        let jaw = union(hollow, self.lip.distance(p), 0.1);
        let muzzle = union(jaw, self.sockets.distance(q), 0.12);
        let face = union(muzzle, self.trunk(p), 0.14);
        let socket = difference(face, sphere(q, EYE + dvec3(0.05, 0.0, 0.03), 0.085), 0.1);
        let lids = ellipsoid(q, EYE - dvec3(0.03, -0.005, 0.02), dvec3(0.058, 0.062, 0.08));
        let lidded = union(socket, lids, 0.08);
        union(lidded, ear(q), 0.07)
    }

    /// The trunk, ringed by folds that fade towards both ends.
    fn trunk(&self, p: DVec3) -> f64 {
        let near = self.trunk.nearest(p);
        let fade = smoothstep(0.25, 0.6, near.arc) * (1.0 - smoothstep(1.9, 2.5, near.arc));
        near.distance + 0.008 * fade * libm::sin(near.arc * 30.0 + 0.6 * libm::sin(p.x * 9.0))
    }
}

/// The right ear: a fan that spreads out and back from the head, hollow in front, its rim waved.
fn ear(p: DVec3) -> f64 {
    let from_root = p - dvec3(0.36, 2.28, 1.2);
    // Outwards along the fan, up, and towards its front.
    let out = dvec3(0.83, 0.0, -0.557);
    let front = dvec3(0.557, 0.0, 0.83);
    let uv = dvec2(from_root.dot(out), from_root.y);
    let circle = |x: f64, y: f64, r: f64| (uv - dvec2(x, y)).length() - r;
    let upper = union(circle(0.46, 0.08, 0.46), circle(0.72, -0.06, 0.42), 0.3);
    let lobe = circle(0.46, -0.66, 0.2);
    let outline = union(union(upper, lobe, 0.6), circle(0.1, -0.1, 0.3), 0.2);
    let from_middle = uv - dvec2(0.48, -0.12);
    let rim = smoothstep(0.25, 0.85, from_middle.length());
    let hollow = 0.22 * from_middle.length_squared();
    let wave = 0.05 * rim * libm::sin(uv.y * 9.0 - uv.x * 4.0 + 0.6);
    let veins = 0.006 * (1.0 - rim) * vein(uv + dvec2(0.12, 0.1));
    let sheet = from_root.dot(front) - hollow + 0.08 - wave;
    let root = 1.0 - smoothstep(0.0, 0.35, uv.x);
    plate(outline, sheet, 0.05 + 0.03 * root) * 0.85 - veins
}

/// Veins that fan out from the ear's root.
fn vein(from_root: DVec2) -> f64 {
    let fade = smoothstep(0.25, 0.5, from_root.length());
    fade * libm::cos(libm::atan2(from_root.y, from_root.x) * 13.0)
}

/// Loose skin: low folds that run mostly downwards and bend with the body.
fn folds(p: DVec3) -> f64 {
    let bend = libm::sin(p.y * 2.6 + p.x * 1.7);
    let down = libm::sin(p.z * 17.0 + 2.4 * bend);
    let across = libm::sin(p.y * 21.0 + p.z * 6.0 + 1.5 * libm::sin(p.x * 4.0 + p.z * 3.0));
    0.005 * down + 0.004 * across * libm::sin(p.z * 5.0 + p.x * 3.0)
}
