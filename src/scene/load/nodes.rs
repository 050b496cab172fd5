//! The node hierarchy (glTF 2.0, 3.5), walked without recursion.

use super::animate::Moved;
use super::document::{Document, Place};
use super::{Parsed, node_label};
use crate::scene::assemble::affine;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;
use std::collections::HashMap;

/// All nodes in world space.
pub struct Nodes {
    /// World from each node's space.
    pub world: Vec<DMat4>,
    /// Morph weights of nodes that an animation moves.
    pub weights: HashMap<usize, Vec<f32>>,
    /// Nodes of the scene, parents before their children, in the file's order.
    pub in_scene: Vec<usize>,
}

/// Places the file's nodes, some of them `moved`, and selects those of its default scene: else of its first one, else all.
pub fn place(document: &Document, moved: Moved) -> Parsed<Nodes> {
    let root = &document.root;
    let count = root.nodes.len();
    let mut has_parent = vec![false; count];
    for (parent, node) in root.nodes.iter().enumerate() {
        for child in children(node) {
            let seen = has_parent.get_mut(child).ok_or("a node's child is not there")?;
            if std::mem::replace(seen, true) {
                return Err(format!(
                    "{} has two parents (one is {})",
                    node_label(root, child),
                    node_label(root, parent)
                ));
            }
        }
    }
    let roots: Vec<_> = (0..count).filter(|&node| !has_parent[node]).collect();
    let mut world = vec![DMat4::IDENTITY; count];
    let mut placed = vec![false; count];
    for node in walk(root, &roots) {
        world[node] *= local(moved.places.get(&node).unwrap_or(&document.places[node]))
            .map_err(|fault| format!("{}: {fault}", node_label(root, node)))?;
        if !world[node].as_mat4().is_finite() {
            return Err(format!("{} has no finite place in the world", node_label(root, node)));
        }
        placed[node] = true;
        for child in children(&root.nodes[node]) {
            world[child] = world[node];
        }
    }
    if let Some(node) = placed.iter().position(|placed| !placed) {
        return Err(format!("{} is its own ancestor", node_label(root, node)));
    }
    let scene = root.scene.map_or(0, |scene| scene.value());
    let in_scene = match root.scenes.get(scene) {
        Some(scene) => {
            let tops: Vec<_> = scene.nodes.iter().map(|node| node.value()).collect();
            walk(root, &tops)
        }
        None => walk(root, &roots),
    };
    Ok(Nodes { world, weights: moved.weights, in_scene })
}

fn children(node: &Node) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

/// Depth first from `tops`, each node once.
fn walk(root: &Root, tops: &[usize]) -> Vec<usize> {
    let mut seen = vec![false; root.nodes.len()];
    let mut order = Vec::new();
    let mut stack: Vec<_> = tops.iter().rev().copied().collect();
    while let Some(node) = stack.pop() {
        if std::mem::replace(&mut seen[node], true) {
            continue;
        }
        order.push(node);
        let first = stack.len();
        stack.extend(children(&root.nodes[node]));
        stack[first..].reverse();
    }
    order
}

/// Parent from node space.
fn local(place: &Place) -> Parsed<DMat4> {
    if let Some(matrix) = &place.matrix {
        return affine(DMat4::from_cols_array(matrix));
    }
    let rotation = place.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    if !(rotation.is_finite() && rotation.length() > 1e-6) {
        return Err("its rotation is no unit quaternion".into());
    }
    Ok(DMat4::from_scale_rotation_translation(
        place.scale.map_or(DVec3::ONE, DVec3::from),
        rotation.normalize(),
        place.translation.map_or(DVec3::ZERO, DVec3::from),
    ))
}
