//! What is seen of a polygon in one pixel: attributes are interpolated perspective-correctly in
//! homogeneous coordinates (Olano and Greer 1997), without regard to clipping.

use super::object::Object;
use crate::scene::view::View;
use crate::scene::{Scene, TextureRef, Vertex, texture};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};

/// The visible surface in one pixel; fields as in [`crate::objective::maps::Surface`].
pub struct Fragment {
    pub depth: f32,
    pub position: Vec3,
    pub normal: Vec3,
    pub face: Vec3,
    pub base_color: Vec3,
    pub metallic: f32,
    pub roughness: f32,
    pub emissive: Vec3,
}

/// One pixel of one triangle.
pub struct Pixel<'a> {
    scene: &'a Scene,
    view: &'a View,
    object: &'a Object<'a>,
    vertices: [&'a Vertex; 3],
    /// Corners in the light frame.
    corners: [Vec3; 3],
    /// The corners in clip space.
    clip: [Vec4; 3],
    /// The pixel.
    at: [u32; 2],
    /// Shares of the three vertices here.
    weights: Vec3,
}

impl<'a> Pixel<'a> {
    /// Pixel (x, y) of the object's polygon number `code`.
    pub fn new(
        scene: &'a Scene,
        view: &'a View,
        object: &'a Object<'a>,
        code: u32,
        [x, y]: [u32; 2],
    ) -> Self {
        let vertices = object.vertices(code);
        let corners = vertices.map(|v| object.position(v));
        let clip = corners.map(|p| view.clip_from_frame * p.extend(1.0));
        let weights = inside(weights(&clip, ndc(view, [x, y], [0.5, 0.5]))).as_vec3();
        Self { scene, view, object, vertices, corners, clip, at: [x, y], weights }
    }

    /// Base colour and alpha.
    pub fn base_color(&self) -> Vec4 {
        let material = self.object.material;
        let vertex = self.blend(|v| Vec4::from(v.color.map(f32::from)) / 255.0);
        Vec4::from(material.base_color) * vertex * self.lookup(&material.base_color_texture)
    }

    /// Everything that is seen here.
    pub fn fragment(&self) -> Fragment {
        let material = self.object.material;
        let [a, b, c] = self.corners;
        let w = self.weights;
        let position = a * w.x + b * w.y + c * w.z;
        let towards_viewer = self.view.towards_viewer(position);
        let face = (b - a).cross(c - a).normalize_or(towards_viewer);
        let metallic_roughness = self.lookup(&material.metallic_roughness_texture);
        Fragment {
            depth: self.view.eye.z - position.z,
            position,
            normal: self.normal(towards_viewer),
            face: if face.dot(towards_viewer) < 0.0 { -face } else { face },
            base_color: self.base_color().xyz(),
            metallic: material.metallic * metallic_roughness.z,
            roughness: material.roughness * metallic_roughness.y,
            emissive: Vec3::from(material.emissive) * self.lookup(&material.emissive_texture).xyz(),
        }
    }

    /// Unit shading normal, turned to the viewer.
    fn normal(&self, towards_viewer: Vec3) -> Vec3 {
        let material = self.object.material;
        let mut n = self.blend(|v| self.object.normal(v).extend(0.0)).xyz();
        if material.normal_texture.is_some() {
            let texel = 2.0 * self.lookup(&material.normal_texture).xyz() - 1.0;
            let tangent = self.blend(|v| self.object.tangent(v).extend(v.tangent[3]));
            let (t, sign) = (tangent.xyz(), tangent.w);
            let b = sign * n.cross(t);
            let scale = material.normal_scale;
            n = t * (texel.x * scale) + b * (texel.y * scale) + n * texel.z;
        }
        self.turned(n.normalize_or(towards_viewer), towards_viewer)
    }

    /// `n` turned to the viewer. On the polygon's hidden side it changes sides; where interpolation
    /// or a texture bent it over the horizon it is mirrored back, which unlike a change of sides is
    /// continuous, so that outlines have no dark fringe.
    fn turned(&self, n: Vec3, towards_viewer: Vec3) -> Vec3 {
        let [a, b, c] = self.corners;
        let face = (b - a).cross(c - a);
        let n = if n.dot(face) * face.dot(towards_viewer) < 0.0 { -n } else { n };
        n - 2.0 * n.dot(towards_viewer).min(0.0) * towards_viewer
    }

    /// A vertex attribute here.
    fn blend(&self, attribute: impl Fn(&Vertex) -> Vec4) -> Vec4 {
        let [a, b, c] = self.vertices.map(attribute);
        let w = self.weights;
        a * w.x + b * w.y + c * w.z
    }

    /// A texture's colour here; white where there is none.
    fn lookup(&self, texture: &Option<TextureRef>) -> Vec4 {
        let Some(texture) = texture else { return Vec4::ONE };
        let [u, v] = texture.transform.map(Vec3::from);
        let corners = self.vertices.map(|vertex| {
            let uv = Vec2::from(vertex.uv[texture.uv_set as usize & 1]).extend(1.0);
            Vec2::new(u.dot(uv), v.dot(uv))
        });
        let at = |w: Vec3| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
        // One pixel to the right and below.
        let beside = |offset| at(weights(&self.clip, ndc(self.view, self.at, offset)).as_vec3());
        let (here, right, below) = (at(self.weights), beside([1.5, 0.5]), beside([0.5, 1.5]));
        let image = &self.scene.textures[texture.texture as usize];
        texture::sample(image, here, right - here, below - here)
    }
}

/// Normalised device coordinates of a place in the picture, `offset` from a pixel's corner.
fn ndc(view: &View, at: [u32; 2], offset: [f64; 2]) -> DVec2 {
    let size = DVec2::new(view.width.into(), view.height.into());
    let place = DVec2::new(at[0].into(), at[1].into()) + DVec2::from(offset);
    2.0 * place / size - 1.0
}

/// Perspective-correct shares of the three corners at a point of the picture: the `b` with
/// `Σ b·(x − ndc.x·w, y − ndc.y·w) = 0` and `Σ b = 1`.
fn weights(clip: &[Vec4; 3], ndc: DVec2) -> DVec3 {
    let [a, b, c] = clip.map(|p| p.as_dvec4().xy() - ndc * f64::from(p.w));
    let shares = DVec3::new(b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
    let result = shares / shares.element_sum();
    if result.is_finite() { result } else { DVec3::splat(1.0 / 3.0) }
}

/// Snapping to the subpixel grid can cover a pixel centre just outside the triangle; what is seen
/// there is the triangle's nearest part.
fn inside(weights: DVec3) -> DVec3 {
    let weights = weights.max(DVec3::ZERO);
    weights / weights.element_sum()
}
