//! Turned vessels with an open mouth: implicit surfaces of revolution about +Y.

use glam::{DVec2, DVec3};

use super::field::{difference, intersection, union};

/// A vessel that stands on y = 0.
pub struct Vessel {
    /// Outer radius at evenly spaced heights from the foot to the rim.
    pub radii: Vec<f64>,
    pub height: f64,
    pub wall: f64,
    /// Height of the inside's floor.
    pub floor: f64,
}

impl Vessel {
    /// Signed distance, first-order. `relief` is added to the outer radius.
    pub fn distance(&self, p: DVec3, relief: f64) -> f64 {
        let radius = DVec2::new(p.x, p.z).length();
        let (outline, slope) = self.outline(p.y);
        let side = (radius - outline) / libm::sqrt(1.0 + slope * slope);
        let round = self.wall * 1.6;
        let ends = (p.y - self.height).max(-p.y);
        let solid = intersection(side - relief, ends, round);
        // The hollow reaches past the rim.
        difference(solid, intersection(side + self.wall, self.floor - p.y, round), self.wall * 0.9)
    }

    /// Adds a handle or a spout outside, without filling the hollow.
    pub fn attach(&self, p: DVec3, vessel: f64, part: f64) -> f64 {
        let radius = DVec2::new(p.x, p.z).length();
        let inside = radius - self.outline(p.y).0 + self.wall * 0.5;
        let outside = intersection(part, -inside, self.wall * 0.3);
        union(vessel, outside, self.wall * 2.0)
    }

    /// Outer radius and its slope at a height, by Catmull-Rom; constant beyond the ends.
    fn outline(&self, y: f64) -> (f64, f64) {
        let last = self.radii.len() - 1;
        let spacing = self.height / last as f64;
        let place = (y / spacing).clamp(0.0, last as f64);
        let span = (libm::floor(place) as usize).min(last - 1);
        let t = place - span as f64;
        let [p1, p2] = [self.radii[span], self.radii[span + 1]];
        let p0 = if span == 0 { p1 } else { self.radii[span - 1] };
        let p3 = if span + 2 > last { p2 } else { self.radii[span + 2] };
        let (b, c) = (p2 - p0, 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3);
        let d = 3.0 * (p1 - p2) + p3 - p0;
        let radius = p1 + 0.5 * (b + (c + d * t) * t) * t;
        (radius, 0.5 * (b + (2.0 * c + 3.0 * d * t) * t) / spacing)
    }
}
