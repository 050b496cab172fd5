//! Catmull-Rom curves, and tubes of varying radius along them.

use glam::{DVec3, DVec4, Vec4Swizzles as _};

/// `per_span` points on each span of the uniform Catmull-Rom curve through `knots`, and its end.
pub fn catmull_rom(knots: &[DVec4], per_span: usize) -> Vec<DVec4> {
    let last = knots.len() - 1;
    let mut points = Vec::with_capacity(last * per_span + 1);
    for span in 0..last {
        let [p1, p2] = [knots[span], knots[span + 1]];
        // Phantom knots continue the ends in a straight line.
        let p0 = if span == 0 { p1 * 2.0 - p2 } else { knots[span - 1] };
        let p3 = if span + 2 > last { p2 * 2.0 - p1 } else { knots[span + 2] };
        for step in 0..per_span {
            let t = step as f64 / per_span as f64;
            let a = p1 * 2.0;
            let b = p2 - p0;
            let c = p0 * 2.0 - p1 * 5.0 + p2 * 4.0 - p3;
            let d = p1 * 3.0 - p0 - p2 * 3.0 + p3;
            points.push((a + (b + (c + d * t) * t) * t) * 0.5);
        }
    }
    points.push(knots[last]);
    points
}

/// A round tube along a curve: an implicit surface.
pub struct Tube {
    /// Axis points with the radius in `w`.
    samples: Vec<DVec4>,
    /// Arc length up to each sample.
    arc: Vec<f64>,
    centre: DVec3,
    reach: f64,
}

/// The tube as seen from a point.
#[derive(Clone, Copy)]
pub struct Nearest {
    /// Signed distance from the surface.
    pub distance: f64,
    /// Arc length along the axis.
    pub arc: f64,
}

/// Beyond this distance from its bounding sphere, a tube answers with that bound alone; wider than
/// any fillet.
const CULL: f64 = 0.5;

impl Tube {
    /// The tube through `knots`, each a position and a radius.
    pub fn new(knots: &[([f64; 3], f64)]) -> Self {
        let knots: Vec<DVec4> =
            knots.iter().map(|&(p, radius)| DVec3::from(p).extend(radius)).collect();
        let samples = catmull_rom(&knots, 12);
        let mut arc = vec![0.0];
        for pair in samples.windows(2) {
            arc.push(arc[arc.len() - 1] + (pair[1].xyz() - pair[0].xyz()).length());
        }
        let centre = (samples[0].xyz() + samples[samples.len() - 1].xyz()) * 0.5;
        let reach = samples.iter().fold(0.0, |r: f64, s| r.max((s.xyz() - centre).length() + s.w));
        Self { samples, arc, centre, reach }
    }

    /// Signed distance from the surface, first-order where the radius varies.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p).distance
    }

    /// Signed distance and place on the axis.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        let bound = (p - self.centre).length() - self.reach;
        let mut nearest = Nearest { distance: bound, arc: 0.0 };
        if bound > CULL {
            return nearest;
        }
        nearest.distance = f64::INFINITY;
        for (i, pair) in self.samples.windows(2).enumerate() {
            let (from, along) = (pair[0].xyz(), pair[1].xyz() - pair[0].xyz());
            let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let radius = pair[0].w + (pair[1].w - pair[0].w) * t;
            let distance = (p - from - along * t).length() - radius;
            if distance < nearest.distance {
                let arc = self.arc[i] + (self.arc[i + 1] - self.arc[i]) * t;
                nearest = Nearest { distance, arc };
            }
        }
        nearest
    }
}
