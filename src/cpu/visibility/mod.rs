//! The visible surface: which polygon is seen in each pixel, and what is known of it there.
//!
//! A first pass decides depth and colour code by rasterising; a second one interpolates the
//! attributes of the polygon that won, once a pixel.

mod clip;
mod object;
mod raster;
mod resolve;
mod vertices;

use crate::objective::maps::Surface;
use crate::scene::Scene;
use crate::scene::view::View;
use clip::Volume;
use object::Object;
use raster::{Corner, Target, Triangle, Winding};
use rayon::prelude::*;
use resolve::Pixel;
use std::ops::Range;
use vertices::Projector;

/// Rows that one task fills.
const BAND_ROWS: u32 = 16;
/// Triangles that one task sets up.
const CHUNK: u32 = 1 << 12;
/// Triangles set up before they are filled; it bounds the memory.
const BATCH: u32 = 1 << 18;

/// Draws the scene. At equal depth the polygon drawn first is seen; the result does not depend on
/// the number of threads. The background's depth is the largest object depth + 1.
///
/// # Panics
/// For a scene or a view that [`Scene::check`] or [`View::check`] refuses.
pub fn draw(scene: &Scene, view: &View) -> Surface {
    let painter = Painter::new(scene, view);
    let (code, _) = painter.codes(u64::MAX);
    painter.surface(code)
}

/// The same, or `None` where the triangles' boxes have more than `most` pixels together: triangles that cover each
/// other many times over take time without end.
///
/// # Panics
/// As [`draw`].
pub fn draw_within(scene: &Scene, view: &View, most: u64) -> Option<Surface> {
    let painter = Painter::new(scene, view);
    let (code, pixels) = painter.codes(most);
    (pixels <= most).then(|| painter.surface(code))
}

/// Triangles of a chunk in drawing order, which of them each band of rows has to draw, and the pixels of their boxes.
struct Chunk {
    triangles: Vec<Triangle>,
    bands: Vec<Vec<u32>>,
    pixels: u64,
}

struct Painter<'a> {
    scene: &'a Scene,
    view: &'a View,
    objects: Vec<Object<'a>>,
}

impl<'a> Painter<'a> {
    fn new(scene: &'a Scene, view: &'a View) -> Self {
        let object = |instance| Object::new(scene, view, instance);
        Self { scene, view, objects: scene.instances.iter().map(object).collect() }
    }

    /// Colour code of each pixel, and the pixels of all triangles' boxes; where these are more than `most`, not all
    /// are drawn.
    fn codes(&self, most: u64) -> (Vec<u32>, u64) {
        let (width, height) = (self.view.width, self.view.height);
        let pixels = width as usize * height as usize;
        let (mut depth, mut code) = (vec![0.0; pixels], vec![0; pixels]);
        let (end, mut all) = (self.scene.polygons() + 1, 0);
        for batch in chunks(1..end, BATCH) {
            let chunks: Vec<_> = chunks(batch, CHUNK).collect();
            let chunks: Vec<_> =
                chunks.into_par_iter().map(|polygons| self.set_up(polygons)).collect();
            all += chunks.iter().map(|chunk| chunk.pixels).sum::<u64>();
            if all > most {
                break;
            }
            let band = (BAND_ROWS * width) as usize;
            let bands = depth.par_chunks_mut(band).zip(code.par_chunks_mut(band)).enumerate();
            bands.for_each(|(band, (depth, code))| {
                let first = band as u32 * BAND_ROWS;
                let rows = first..(first + BAND_ROWS).min(height);
                let mut target = Target { width, rows, depth, code };
                for chunk in &chunks {
                    for &at in &chunk.bands[band] {
                        self.fill(&chunk.triangles[at as usize], &mut target);
                    }
                }
            });
        }
        (code, all)
    }

    fn fill(&self, triangle: &Triangle, target: &mut Target) {
        if !triangle.masked {
            return triangle.fill(target, |_, _| true);
        }
        let object = self.object(triangle.code);
        triangle.fill(target, |x, y| {
            let pixel = Pixel::new(self.scene, self.view, object, triangle.code, [x, y]);
            pixel.base_color().w >= object.material.alpha_cutoff
        });
    }

    /// Projects and culls polygons, and sorts them into the bands that they touch.
    fn set_up(&self, polygons: Range<u32>) -> Chunk {
        let bands = self.view.height.div_ceil(BAND_ROWS) as usize;
        let mut chunk = Chunk { triangles: Vec::new(), bands: vec![Vec::new(); bands], pixels: 0 };
        let volume = Volume::new(self.view.width, self.view.height);
        let mut object = self.object(polygons.start);
        let mut projector = Projector::new(self.view, &volume);
        for code in polygons {
            if code >= object.end() {
                object = self.object(code);
            }
            let indices = object.corners(code);
            let corners = indices.map(|index| projector.projected(object, index));
            if corners.iter().all(|corner| corner.inside) {
                self.add(&mut chunk, object, code, corners.map(|corner| corner.corner));
                continue;
            }
            let polygon =
                volume.clip(&indices.map(|index| vertices::clip(self.view, object, index)));
            let project = |p| Corner::project(p, self.view.width, self.view.height);
            for pair in polygon.corners().get(1..).unwrap_or_default().windows(2) {
                let fan = [polygon.corners()[0], pair[0], pair[1]];
                self.add(&mut chunk, object, code, fan.map(project));
            }
        }
        chunk
    }

    /// Adds a triangle, unless it is empty, outside the picture or the back of a single-sided face.
    fn add(&self, chunk: &mut Chunk, object: &Object, code: u32, corners: [Corner; 3]) {
        let masked = object.material.alpha_cutoff > 0.0;
        let Some((triangle, winding)) = Triangle::new(corners, code, masked) else { return };
        let front = (winding == Winding::CounterClockwise) != object.mirrored;
        let rows = triangle.rows(self.view.height);
        let shown = front || object.material.double_sided;
        let columns = triangle.columns(self.view.width);
        if !shown || rows.is_empty() || columns.is_empty() {
            return;
        }
        chunk.pixels += rows.len() as u64 * columns.len() as u64;
        let at = chunk.triangles.len() as u32;
        for band in rows.start / BAND_ROWS..=(rows.end - 1) / BAND_ROWS {
            chunk.bands[band as usize].push(at);
        }
        chunk.triangles.push(triangle);
    }

    /// The object that a polygon belongs to.
    fn object(&self, code: u32) -> &Object<'_> {
        &self.objects[self.objects.partition_point(|object| object.first_polygon <= code) - 1]
    }

    /// The attributes of what is seen.
    fn surface(&self, code: Vec<u32>) -> Surface {
        let n = code.len();
        let mut surface = Surface {
            width: self.view.width,
            height: self.view.height,
            code,
            depth: vec![0.0; n],
            position: vec![[0.0; 3]; n],
            normal: vec![[0.0; 3]; n],
            face: vec![[0.0; 3]; n],
            base_color: vec![[0.0; 3]; n],
            metallic: vec![0.0; n],
            roughness: vec![0.0; n],
            emissive: vec![[0.0; 3]; n],
        };
        let Surface {
            code,
            depth,
            position,
            normal,
            face,
            base_color,
            metallic,
            roughness,
            emissive,
            ..
        } = &mut surface;
        let attributes = (depth, position, normal, face, base_color, metallic, roughness, emissive);
        (&*code, attributes.into_par_iter())
            .into_par_iter()
            .enumerate()
            .filter(|(_, (code, _))| **code != 0)
            .for_each(|(at, (&code, attributes))| {
                let at = [at as u32 % self.view.width, at as u32 / self.view.width];
                let object = self.object(code);
                let seen = Pixel::new(self.scene, self.view, object, code, at).fragment();
                let (depth, position, normal, face, base_color, metallic, roughness, emissive) =
                    attributes;
                *depth = seen.depth;
                *position = seen.position.to_array();
                *normal = seen.normal.to_array();
                *face = seen.face.to_array();
                *base_color = seen.base_color.to_array();
                (*metallic, *roughness) = (seen.metallic, seen.roughness);
                *emissive = seen.emissive.to_array();
            });
        super::set_background_depth(&mut surface);
        surface
    }
}

/// `range` in pieces of `size`, the last one shorter.
fn chunks(range: Range<u32>, size: u32) -> impl Iterator<Item = Range<u32>> {
    let end = range.end;
    range.step_by(size as usize).map(move |start| start..(start.saturating_add(size)).min(end))
}
