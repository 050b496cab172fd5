//! Clipping of triangles in homogeneous coordinates (Sutherland and Hodgman 1974).

use glam::{DVec4, Vec4};

/// Distance from the picture's centre, in pixels, beyond which triangles are clipped sideways, so
/// that products of subpixel coordinates fit in 64 bits.
const GUARD_PIXELS: f64 = (1 << 20) as f64;

/// Most corners of a clipped triangle: each of the six planes can add one.
const MAX_CORNERS: usize = 9;

/// The volume that triangles are clipped to.
#[derive(Debug, Clone, Copy)]
pub struct Volume {
    /// Guard band in normalised device coordinates, horizontally and vertically.
    guard: [f64; 2],
}

/// A convex polygon in clip space.
#[derive(Debug, Clone, Copy)]
pub struct Polygon {
    corners: [DVec4; MAX_CORNERS],
    len: usize,
}

impl Volume {
    /// The volume of a picture of the given size.
    pub fn new(width: u32, height: u32) -> Self {
        Self { guard: [width, height].map(|size| 2.0 * GUARD_PIXELS / f64::from(size)) }
    }

    /// Signed distances to the planes; all are positive inside. Depth is reversed: near is `z = w`.
    fn distances(&self, p: DVec4) -> [f64; 6] {
        let [gx, gy] = self.guard;
        [p.w - p.z, p.z, gx * p.w - p.x, gx * p.w + p.x, gy * p.w - p.y, gy * p.w + p.y]
    }

    /// Whether the point lies inside; a triangle of such corners can be drawn as it is.
    pub fn contains(&self, p: Vec4) -> bool {
        p.w > 0.0 && self.distances(p.as_dvec4()).iter().all(|&distance| distance >= 0.0)
    }

    /// The part of a triangle that lies inside.
    pub fn clip(&self, triangle: &[Vec4; 3]) -> Polygon {
        let mut polygon = Polygon { corners: [DVec4::ZERO; MAX_CORNERS], len: 0 };
        triangle.iter().for_each(|p| polygon.push(p.as_dvec4()));
        for plane in 0..6 {
            polygon = polygon.cut(|p| self.distances(p)[plane]);
        }
        polygon
    }
}

impl Polygon {
    /// The corners in order.
    pub fn corners(&self) -> &[DVec4] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: DVec4) {
        self.corners[self.len] = corner;
        self.len += 1;
    }

    /// The part where `distance` is not negative.
    fn cut(&self, distance: impl Fn(DVec4) -> f64) -> Self {
        let mut result = Self { corners: [DVec4::ZERO; MAX_CORNERS], len: 0 };
        for (i, &a) in self.corners().iter().enumerate() {
            let b = self.corners[(i + 1) % self.len];
            let (da, db) = (distance(a), distance(b));
            if da >= 0.0 {
                result.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                // Always from the inner to the outer end: neighbours share the same point.
                let (inner, outer, di, d_o) =
                    if da >= 0.0 { (a, b, da, db) } else { (b, a, db, da) };
                result.push(inner + (outer - inner) * (di / (di - d_o)));
            }
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_through_the_near_plane_loses_its_corner() {
        let volume = Volume::new(64, 64);
        let at = |x: f32, z: f32| Vec4::new(x, 0.0, z, 1.0);
        let triangle = [at(0.0, 2.0), at(1.0, 0.5), at(-1.0, 0.5)];
        assert!(!triangle.iter().all(|&p| volume.contains(p)));
        let polygon = volume.clip(&triangle);
        assert_eq!(polygon.corners().len(), 4);
        assert!(polygon.corners().iter().all(|p| p.z <= p.w + 1e-12));
    }

    #[test]
    fn what_is_behind_the_viewer_vanishes_and_what_is_inside_stays() {
        let volume = Volume::new(64, 64);
        let behind = [Vec4::new(0.0, 0.0, 0.1, -1.0); 3];
        assert!(volume.clip(&behind).corners().is_empty());
        let inside = [Vec4::new(0.0, 0.0, 0.1, 1.0); 3];
        assert!(inside.iter().all(|&p| volume.contains(p)));
        assert_eq!(volume.clip(&inside).corners().len(), 3);
    }

    #[test]
    fn huge_triangles_end_at_the_guard_band() {
        let volume = Volume::new(64, 64);
        let at = |x: f32, y: f32| Vec4::new(x, y, 0.5, 1.0);
        let polygon = volume.clip(&[at(-1e30, -1e30), at(1e30, -1e30), at(0.0, 1e30)]);
        assert!(polygon.corners().len() >= 3);
        assert!(polygon.corners().iter().all(|p| p.x.abs() <= 1.001 * 32768.0 * p.w));
    }
}
