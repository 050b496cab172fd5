//! Direction of the key light: its angle from the nearer of two directions, 30° above the viewer and 35° to
//! one side. Free within 15°, 1 at 75°. People read shape best with light 20° to 30° above the viewer
//! (O'Shea, Agrawala and Banks 2010); Shacked and Lischinski (2001) had such a term. 0 without a key.

use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};
use glam::Vec3;

/// Unit vector 30° up and 35° to the right, light frame.
pub const PREFERRED: Vec3 = Vec3::new(0.496_731_76, 0.5, 0.709_406_5);
/// Angle within which the term is 0, radians.
pub const FREE: f32 = 15.0 * std::f32::consts::PI / 180.0;
/// Angle from which on it is 1, radians.
pub const MOST: f32 = 75.0 * std::f32::consts::PI / 180.0;

/// See the module.
pub static TERM: Term = Term {
    name: "direction",
    title: "Direction",
    meaning: "how far the key light is from where people expect light, above and to one side",
    needs: Needs::NONE,
    formula,
};

fn formula(picture: &Statistics, _: &ViewStatistics, _: &Objective) -> f32 {
    let key = Vec3::from(picture.key);
    if key == Vec3::ZERO {
        return 0.0;
    }
    // The two differ in the sign of x alone.
    let cosine = Vec3::new(key.x.abs(), key.y, key.z).dot(PREFERRED);
    ((cosine.clamp(-1.0, 1.0).acos() - FREE) / (MOST - FREE)).clamp(0.0, 1.0)
}
