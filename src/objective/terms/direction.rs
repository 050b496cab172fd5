//! Direction of the key light: its angle from the nearer of two directions, 30° above the viewer and 35° to
//! one side. Free within 15°, 1 at 75°. People read shape best with light 20° to 30° above the viewer
//! (O'Shea, Agrawala and Banks 2010); Shacked and Lischinski (2001) had such a term. 0 without a key.

use crate::constants::{DIRECTION_FREE, DIRECTION_MOST, DIRECTION_PREFERRED};
use crate::objective::maps::ViewStatistics;
use crate::objective::{Needs, Objective, Statistics, Term};
use glam::Vec3;

/// Unit vector towards the light that people expect, on the right; light frame.
pub const PREFERRED: Vec3 = Vec3::from_array(DIRECTION_PREFERRED);

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
    ((cosine.clamp(-1.0, 1.0).acos() - DIRECTION_FREE) / (DIRECTION_MOST - DIRECTION_FREE)).clamp(0.0, 1.0)
}
