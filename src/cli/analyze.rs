//! `klieg analyze`: the view's maps as pictures and arrays.

use super::options::{SceneOptions, TargetOptions};
use super::print;
use super::session::Session;
use super::values::Lights;
use crate::design::profile;
use crate::lighting::angles;
use crate::lighting::clusters::{Cluster, Clustering};
use crate::objective::maps::Maps;
use crate::report::json::{self, Header};
use crate::report::{Staging, npy, picture};
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Write the maps of a view
///
/// Colour code, depth, edges, pixel types, normals and clusters of the visible normals as pictures,
/// the maps as NumPy arrays, and analyze.json, which names shapes, units, counts and objects.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    target: TargetOptions,
    /// Folder for the results, created where absent
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Number of clusters, as lights of a design: roles, or a number from 1 to 16 [default: 2]
    #[arg(long, value_name = "ROLES|NUMBER")]
    lights: Option<Lights>,
    /// Seed of the clustering [default: 0]
    #[arg(long)]
    seed: Option<u64>,
}

/// All files that it writes.
const FILES: [&str; 16] = [
    "code.png",
    "depth.png",
    "edges.png",
    "types.png",
    "normals.png",
    "clusters.png",
    "code.npy",
    "depth.npy",
    "position.npy",
    "normal.npy",
    "base_color.npy",
    "metallic.npy",
    "roughness.npy",
    "emissive.npy",
    "types.npy",
    "analyze.json",
];

/// `analyze.json`.
#[derive(Serialize)]
struct Analysis {
    #[serde(flatten)]
    header: Header,
    /// Scene radius and centre, world units.
    radius: f64,
    center: glam::DVec3,
    pixels: Pixels,
    /// `G_n`.
    normal_detail: f32,
    polygons: u32,
    visible_polygons: usize,
    objects: Vec<Object>,
    clusters: Vec<ClusterRecord>,
    arrays: Vec<Array>,
}

/// Pixels of each kind.
#[derive(Serialize)]
struct Pixels {
    background: u64,
    surface: u32,
    edge: u32,
}

/// An instance of a mesh.
#[derive(Serialize)]
struct Object {
    name: String,
    mesh: String,
    first_polygon: u32,
    polygons: u32,
    visible_polygons: usize,
    visible_pixels: u64,
}

/// A cluster of visible normals.
#[derive(Serialize)]
struct ClusterRecord {
    polygons: usize,
    direction: glam::Vec3,
    elevation_deg: f32,
    azimuth_deg: f32,
    color: [u8; 3],
}

/// A `.npy` file.
#[derive(Serialize)]
struct Array {
    file: &'static str,
    dtype: &'static str,
    shape: Vec<u64>,
    unit: String,
}

pub(super) fn run(options: &Options) -> Result<()> {
    let mut settings = options.scene.settings(profile::DEFAULT)?;
    options.target.apply(&mut settings);
    settings.seed = options.seed.unwrap_or(settings.seed);
    let lights = options.lights.as_ref().unwrap_or(&settings.lights.roles).0.len();
    let mut session = Session::open(options.scene.path()?, settings)?;
    let inputs = session.inputs(options.scene.config());
    inputs.spare(&options.out, FILES)?;
    let mut staging = Staging::new(&options.out)?.sparing(inputs);
    let header = session.header("klieg.analysis/1");
    let clustering = session.clusters(lights)?;
    let maps = session.evaluator.maps()?;

    let edge_sobel = session.settings.objective.edge_sobel;
    write_pictures(maps, edge_sobel, &clustering, &mut staging)?;
    let arrays = write_arrays(maps, &mut staging)?;
    let counts = maps.counts;
    let analysis = Analysis {
        header,
        radius: session.view.frame.radius,
        center: session.view.frame.center,
        pixels: Pixels {
            background: maps.types.len() as u64 - u64::from(counts.object()),
            surface: counts.surface,
            edge: counts.edge,
        },
        normal_detail: maps.normal_detail,
        polygons: session.scene.polygons(),
        visible_polygons: maps.visible.len(),
        objects: objects(&session.scene, maps),
        clusters: clusters(&clustering),
        arrays,
    };
    let text = json::text(&analysis)?;
    staging.write("analyze.json", &text)?;
    let files = staging.publish()?;
    if options.scene.json { print::out(text) } else { print::out(show(&analysis, &files)) }
}

fn write_pictures(
    maps: &Maps,
    edge_sobel: f32,
    clustering: &Clustering,
    staging: &mut Staging,
) -> Result<()> {
    for (name, image) in [
        ("code.png", picture::code(maps)),
        ("depth.png", picture::depth(maps)),
        ("edges.png", picture::edges(maps, edge_sobel)),
        ("types.png", picture::types(maps)),
        ("normals.png", picture::normals(maps)),
        ("clusters.png", picture::clusters(maps, clustering)),
    ] {
        staging.write(name, picture::png(&image)?)?;
    }
    Ok(())
}

fn write_arrays(maps: &Maps, staging: &mut Staging) -> Result<Vec<Array>> {
    let surface = &maps.surface;
    let plane = [u64::from(surface.height), u64::from(surface.width)];
    let vectors = [plane[0], plane[1], 3];
    let numbers = |map: &[f32]| npy::array(&plane, map.iter().copied());
    let triples = |map: &[[f32; 3]]| npy::array(&vectors, map.iter().flatten().copied());
    let codes = npy::array(&plane, surface.code.iter().copied())?;
    let types = npy::array(&plane, maps.types.iter().map(|&kind| kind as u8))?;
    let (depth, metallic) = (numbers(&surface.depth)?, numbers(&surface.metallic)?);
    let (position, normal) = (triples(&surface.position)?, triples(&surface.normal)?);
    let (color, emissive) = (triples(&surface.base_color)?, triples(&surface.emissive)?);
    let roughness = numbers(&surface.roughness)?;
    let axes = "to the right, up and to the viewer";
    let mut arrays = Vec::new();
    for (file, dtype, shape, unit, bytes) in [
        ("code.npy", "uint32", &plane[..], "polygon number, 0 in the background".into(), codes),
        ("depth.npy", "float32", &plane, "scene radii along the view axis".into(), depth),
        (
            "position.npy",
            "float32",
            &vectors,
            format!("scene radii from the scene's centre: {axes}"),
            position,
        ),
        ("normal.npy", "float32", &vectors, format!("unit vector: {axes}"), normal),
        ("base_color.npy", "float32", &vectors, "linear RGB".into(), color),
        ("metallic.npy", "float32", &plane, "metallic factor".into(), metallic),
        ("roughness.npy", "float32", &plane, "perceptual roughness".into(), roughness),
        ("emissive.npy", "float32", &vectors, "linear RGB".into(), emissive),
        ("types.npy", "uint8", &plane, "0 background, 1 surface, 2 edge".into(), types),
    ] {
        staging.write(file, bytes)?;
        arrays.push(Array { file, dtype, shape: shape.to_vec(), unit });
    }
    Ok(arrays)
}

fn objects(scene: &crate::scene::Scene, maps: &Maps) -> Vec<Object> {
    let mut pixels = vec![0; scene.instances.len()];
    let mut polygons = vec![0; scene.instances.len()];
    let instance = |&code: &u32| scene.polygon(code).map(|(instance, _)| instance);
    maps.surface.code.iter().filter_map(instance).for_each(|at| pixels[at] += 1);
    maps.visible.iter().filter_map(instance).for_each(|at| polygons[at] += 1);
    let counts = pixels.into_iter().zip(polygons);
    let object = |(instance, (visible_pixels, visible_polygons)): (&crate::scene::Instance, _)| {
        let range = scene.polygon_range(instance);
        Object {
            name: instance.name.clone(),
            mesh: scene.meshes[instance.mesh as usize].name.clone(),
            first_polygon: range.start,
            polygons: range.end - range.start,
            visible_polygons,
            visible_pixels,
        }
    };
    scene.instances.iter().zip(counts).map(object).collect()
}

fn clusters(clustering: &Clustering) -> Vec<ClusterRecord> {
    let record = |(i, cluster): (usize, &Cluster)| {
        let (elevation, azimuth) = angles(cluster.direction);
        ClusterRecord {
            polygons: cluster.size,
            direction: cluster.direction,
            elevation_deg: elevation.to_degrees(),
            azimuth_deg: azimuth.to_degrees(),
            color: picture::CLUSTERS[i % picture::CLUSTERS.len()],
        }
    };
    clustering.clusters.iter().enumerate().map(record).collect()
}

fn show(analysis: &Analysis, files: &[PathBuf]) -> String {
    let Pixels { background, surface, edge } = analysis.pixels;
    let (visible, all) = (analysis.visible_polygons, analysis.polygons);
    let mut objects = print::columns(&["object", "polygons", "visible", "pixels"], &[]);
    for object in &analysis.objects {
        objects.add_row([
            print::name(&object.name),
            object.polygons.to_string(),
            object.visible_polygons.to_string(),
            object.visible_pixels.to_string(),
        ]);
    }
    let mut clusters = print::columns(&["cluster", "polygons", "elevation", "azimuth"], &[]);
    for (i, cluster) in analysis.clusters.iter().enumerate() {
        clusters.add_row([
            format!("{} #{}", i + 1, cluster.color.map(|c| format!("{c:02x}")).concat()),
            cluster.polygons.to_string(),
            format!("{:.1}°", cluster.elevation_deg),
            format!("{:.1}°", cluster.azimuth_deg),
        ]);
    }
    format!(
        "pixels: {surface} surface, {edge} edge, {background} background\n\
         polygons: {visible} of {all} visible; G_n {:.4}\n\n{objects}\n\n{clusters}\n\n{}",
        analysis.normal_detail,
        print::written(files)
    )
}
