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
    samples: Vec<Sample>,
    centre: DVec3,
    reach: f64,
}

struct Sample {
    axis: DVec3,
    radius: f64,
    /// Unit direction of the axis.
    tangent: DVec3,
    /// Arc length up to here.
    arc: f64,
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
        let points = catmull_rom(&knots, 12);
        let last = points.len() - 1;
        let mut arc = 0.0;
        let mut samples = Vec::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            let (before, after) =
                (points[i.saturating_sub(1)].xyz(), points[(i + 1).min(last)].xyz());
            let axis = point.xyz();
            arc += (axis - before).length();
            samples.push(Sample {
                axis,
                radius: point.w,
                tangent: (after - before).normalize(),
                arc,
            });
        }
        let centre = (samples[0].axis + samples[last].axis) * 0.5;
        let reach =
            samples.iter().fold(0.0, |r: f64, s| r.max((s.axis - centre).length() + s.radius));
        Self { samples, centre, reach }
    }

    /// Signed distance from the surface, first-order where the radius varies.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p).distance
    }

    /// Signed distance and place on the axis.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        let bound = (p - self.centre).length() - self.reach;
        if bound > CULL {
            return Nearest { distance: bound, arc: 0.0 };
        }
        let mut nearest = Nearest { distance: 0.0, arc: 0.0 };
        let mut least = f64::INFINITY;
        let last = self.samples.len() - 2;
        for (i, pair) in self.samples.windows(2).enumerate() {
            let (a, b) = (&pair[0], &pair[1]);
            // The planes across the axis at the samples sweep over the segment. Neighbours share
            // them, so that the place on the axis is continuous where the curve bends.
            let (past, ahead) = ((p - a.axis).dot(a.tangent), (b.axis - p).dot(b.tangent));
            let t = match (past > 0.0, ahead > 0.0) {
                (true, true) => past / (past + ahead),
                (false, _) if i == 0 => 0.0,
                (_, false) if i == last => 1.0,
                _ => continue,
            };
            let from_axis = (p - a.axis.lerp(b.axis, t)).length_squared();
            if from_axis < least {
                least = from_axis;
                let radius = a.radius + (b.radius - a.radius) * t;
                let arc = a.arc + (b.arc - a.arc) * t;
                nearest = Nearest { distance: libm::sqrt(from_axis) - radius, arc };
            }
        }
        nearest
    }
}
