//! Projected vertices. Neighbouring triangles share their corners, which a small table keeps as a
//! GPU's post-transform cache does.

use super::clip::Volume;
use super::object::Object;
use super::raster::Corner;
use crate::scene::view::View;
use glam::Vec4;

/// Entries of the table, a power of 2: two rows of a grid of a million vertices fit.
const ENTRIES: usize = 1 << 12;

/// A vertex in the picture.
#[derive(Debug, Clone, Copy)]
pub struct Projected {
    /// Where it falls; of no meaning unless it is inside.
    pub corner: Corner,
    /// Whether it lies in the volume that triangles are clipped to.
    pub inside: bool,
}

/// Projects the vertices of a view.
pub struct Projector<'a> {
    view: &'a View,
    volume: &'a Volume,
    /// Each with the first polygon of its object and its index in the mesh; polygons count from 1.
    table: Vec<((u32, u32), Projected)>,
}

impl<'a> Projector<'a> {
    /// A projector that knows no vertex.
    pub fn new(view: &'a View, volume: &'a Volume) -> Self {
        let nothing = Projected { corner: Corner::default(), inside: false };
        Self { view, volume, table: vec![((0, 0), nothing); ENTRIES] }
    }

    /// Vertex `index` of the object's mesh.
    pub fn projected(&mut self, object: &Object, index: u32) -> Projected {
        let key = (object.first_polygon, index);
        let entry = &mut self.table[index as usize % ENTRIES];
        if entry.0 != key {
            let clip = clip(self.view, object, index);
            let corner = Corner::project(clip.as_dvec4(), self.view.width, self.view.height);
            *entry = (key, Projected { corner, inside: self.volume.contains(clip) });
        }
        entry.1
    }
}

/// Clip-space position of vertex `index` of the object's mesh.
pub fn clip(view: &View, object: &Object, index: u32) -> Vec4 {
    view.clip_from_frame * object.position(object.vertex(index)).extend(1.0)
}
