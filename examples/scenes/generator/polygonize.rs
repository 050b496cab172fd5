//! Naive surface nets (Gibson 1998): an implicit surface becomes a closed mesh of even triangles.
//!
//! Each grid cell that the surface passes through gets one vertex, each grid edge that it cuts a
//! quadrilateral. The vertices are then evened out along the surface and put on it by Newton steps.

use glam::{DVec3, UVec3};

use super::field::gradient;
use super::mesh::Mesh;

/// Grid nodes along the side of a block that is decided by one look at its centre.
const BLOCK: u32 = 8;
/// The fields' slopes stay below this, which is what makes that look safe.
const SLOPE: f64 = 2.0;
/// Rounds of evening out.
const ROUNDS: usize = 8;
const NONE: u32 = u32::MAX;

/// The surface `field = 0` within `[low, high]`, on a grid of `cell` metres. The surface must not
/// touch the box, and nothing should be thinner than about two cells.
pub fn polygonize(field: &impl Fn(DVec3) -> f64, low: DVec3, high: DVec3, cell: f64) -> Mesh {
    let mut grid = Grid::sample(field, low, high, cell);
    grid.untangle();
    let (mut vertices, cells) = grid.vertices();
    let quads = grid.quads(&cells);
    for _ in 0..ROUNDS {
        even_out(field, &mut vertices, &quads, cell);
    }
    for vertex in &mut vertices {
        *vertex = project(field, *vertex, cell, 3);
    }
    let mut mesh = Mesh::default();
    for &vertex in &vertices {
        mesh.push(vertex, gradient(field, vertex, cell * 0.02).normalize());
    }
    for [a, b, c, d] in quads {
        let length = |i: u32, j: u32| (vertices[i as usize] - vertices[j as usize]).length();
        if length(a, c) <= length(b, d) {
            mesh.indices.extend([a, b, c, a, c, d]);
        } else {
            mesh.indices.extend([a, b, d, b, c, d]);
        }
    }
    mesh
}

/// Moves every vertex towards the mean of its neighbours, then back onto the surface.
fn even_out(field: &impl Fn(DVec3) -> f64, vertices: &mut [DVec3], quads: &[[u32; 4]], cell: f64) {
    let mut sums = vec![(DVec3::ZERO, 0.0); vertices.len()];
    for quad in quads {
        for side in 0..4 {
            let (i, j) = (quad[side] as usize, quad[(side + 1) % 4] as usize);
            sums[i].0 += vertices[j];
            sums[i].1 += 1.0;
        }
    }
    for (vertex, (sum, count)) in vertices.iter_mut().zip(sums) {
        *vertex = project(field, (*vertex + sum / count) * 0.5, cell, 1);
    }
}

/// Newton steps along the gradient, none longer than half a cell.
fn project(field: &impl Fn(DVec3) -> f64, mut p: DVec3, cell: f64, steps: usize) -> DVec3 {
    for _ in 0..steps {
        let slope = gradient(field, p, cell * 0.02);
        let step = slope * (field(p) / slope.length_squared().max(1e-6));
        p -= step * (0.5 * cell / step.length().max(0.5 * cell));
    }
    p
}

struct Grid {
    low: DVec3,
    cell: f64,
    /// Nodes along each axis.
    nodes: UVec3,
    values: Vec<f64>,
}

impl Grid {
    fn sample(field: &impl Fn(DVec3) -> f64, low: DVec3, high: DVec3, cell: f64) -> Self {
        let blocks = ((high - low) / (cell * f64::from(BLOCK))).ceil().as_uvec3();
        let nodes = blocks * BLOCK;
        let values = vec![0.0; nodes.element_product() as usize];
        let mut grid = Self { low, cell, nodes, values };
        // From a block's centre to the far end of an edge that leaves it.
        let reach = cell * (f64::from(BLOCK) * 0.5 + 1.0) * libm::sqrt(3.0);
        for block in boxes(blocks) {
            let corner = block * BLOCK;
            let centre = low + (corner.as_dvec3() + 0.5 * f64::from(BLOCK - 1)) * cell;
            let middle = field(centre);
            for offset in boxes(UVec3::splat(BLOCK)) {
                let node = corner + offset;
                let index = grid.index(node);
                let far = middle.abs() > SLOPE * reach;
                grid.values[index] = if far { middle } else { field(grid.position(node)) };
            }
        }
        grid
    }

    fn index(&self, node: UVec3) -> usize {
        ((node.z * self.nodes.y + node.y) * self.nodes.x + node.x) as usize
    }

    fn position(&self, node: UVec3) -> DVec3 {
        self.low + node.as_dvec3() * self.cell
    }

    fn value(&self, node: UVec3) -> f64 {
        self.values[self.index(node)]
    }

    /// Four triangles would share an edge across a grid face whose corners lie inside and outside
    /// in turn, as they do on a saddle. The outer corner that is nearest the surface is counted
    /// inside instead; the number of inner nodes only grows, so that this ends.
    fn untangle(&mut self) {
        let mut again = true;
        while again {
            again = false;
            for node in boxes(self.nodes - 1) {
                for i in 0..3 {
                    let (u, v) = (UVec3::AXES[i], UVec3::AXES[(i + 1) % 3]);
                    let face = [node, node + u, node + u + v, node + v].map(|at| self.index(at));
                    let inside = face.map(|at| self.values[at] < 0.0);
                    if inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1] {
                        let outer = usize::from(inside[0]);
                        let (a, b) = (face[outer], face[outer + 2]);
                        let nearer = if self.values[a] <= self.values[b] { a } else { b };
                        // A distance of exactly zero becomes negative too.
                        self.values[nearer] = -self.values[nearer].max(f64::MIN_POSITIVE);
                        again = true;
                    }
                }
            }
        }
    }

    /// A vertex in the middle of the surface's crossings of each cell that has any, and the
    /// vertex number of each cell (by its lowest node).
    fn vertices(&self) -> (Vec<DVec3>, Vec<u32>) {
        let mut vertices = Vec::new();
        let mut cells = vec![NONE; self.values.len()];
        for cell in boxes(self.nodes - 1) {
            let (mut sum, mut count) = (DVec3::ZERO, 0.0);
            for axis in UVec3::AXES {
                for corner in boxes(UVec3::splat(2) - axis) {
                    let (a, b) = (cell + corner, cell + corner + axis);
                    let (va, vb) = (self.value(a), self.value(b));
                    if (va < 0.0) != (vb < 0.0) {
                        let t = va / (va - vb);
                        sum += self.position(a) + axis.as_dvec3() * (t * self.cell);
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 {
                cells[self.index(cell)] = vertices.len() as u32;
                vertices.push(sum / count);
            }
        }
        (vertices, cells)
    }

    /// A quadrilateral around each grid edge that the surface cuts, counter-clockwise from outside.
    fn quads(&self, cells: &[u32]) -> Vec<[u32; 4]> {
        let mut quads = Vec::new();
        for node in boxes(self.nodes - 1) {
            for (i, axis) in UVec3::AXES.into_iter().enumerate() {
                let inside = self.value(node) < 0.0;
                if inside == (self.value(node + axis) < 0.0) {
                    continue;
                }
                let (u, v) = (UVec3::AXES[(i + 1) % 3], UVec3::AXES[(i + 2) % 3]);
                let around = [node - u - v, node - v, node, node - u];
                let mut quad = around.map(|cell| cells[self.index(cell)]);
                if !inside {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
        quads
    }
}

/// Every index below `size`, x fastest.
fn boxes(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z).flat_map(move |z| {
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z)))
    })
}
