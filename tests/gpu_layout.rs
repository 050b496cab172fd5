//! The blocks that the shaders declare against the structs that the host writes, by reflection.

use klieg::gpu::layout::{
    AppearancePart, Camera, Chunk, Detail, EngineSurface, GradientPart, InstanceRecord,
    MaterialRecord, MomentPart, Parameters, ShapePart, TextureUse, Tile, ViewStatistics,
};
use klieg::gpu::shaders;
use klieg::lighting::LightRecord;
use klieg::scene::occluders::{Node, Triangle};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op};
use std::collections::{BTreeMap, HashMap};
use std::mem::offset_of;

/// Members and their byte offsets, in order.
type Members = Vec<(String, u32)>;

/// A struct of the host: its size and its members.
struct Host {
    size: u32,
    members: Members,
}

macro_rules! host {
    ($type:ty { $($member:ident),* $(,)? }) => {
        Host {
            size: size_of::<$type>() as u32,
            members: vec![
                $((stringify!($member).to_owned(), offset_of!($type, $member) as u32)),*
            ],
        }
    };
}

/// Every struct that both sides know, by its name in the shaders.
fn hosts() -> BTreeMap<&'static str, Host> {
    BTreeMap::from([
        (
            "Parameters",
            host!(Parameters {
                size,
                orthographic,
                mean_stops,
                eye,
                ambient,
                dielectric,
                max_shininess,
                edge_sobel,
                edge_laplace,
                edge_contrast,
                mean_target,
                background,
                spread_target,
                weights,
                example,
            }),
        ),
        (
            "ViewStatistics",
            host!(ViewStatistics {
                surface,
                edge,
                normal_detail,
                background_depth,
                normal_mean,
                normal_xx,
                normal_xy,
                normal_yy,
                detail_weight,
                base_luminance,
                target
            }),
        ),
        ("Chunk", host!(Chunk { first, histogram_entries, entries, block, light, lights })),
        ("Tile", host!(Tile { column, row, origin })),
        (
            "EngineSurface",
            host!(EngineSurface {
                frame_from_clip,
                frame_from_normals,
                eye,
                base_color_roughness,
                metallic,
                cleared_depth,
                flags,
                channels,
                size,
                padding,
            }),
        ),
        (
            "Camera",
            host!(Camera {
                clip_from_frame,
                eye,
                shading,
                first_light,
                first_instance,
                instances_of_picture,
            }),
        ),
        (
            "InstanceRecord",
            host!(InstanceRecord {
                frame_from_mesh,
                normal_from_mesh,
                first_polygon,
                material,
                mirrored,
                padding,
            }),
        ),
        (
            "MaterialRecord",
            host!(MaterialRecord {
                base_color,
                emissive_normal_scale,
                metallic,
                roughness,
                alpha_cutoff,
                flags,
                textures,
            }),
        ),
        ("ShapePart", host!(ShapePart { gradient, weight, x, y, xx, xy, yy, base })),
        ("TextureUse", host!(TextureUse { u, v })),
        (
            "Light",
            host!(LightRecord {
                position,
                radius2,
                diffuse,
                specular,
                cone_scale,
                cone_offset,
                color,
                size,
                axis,
                key
            }),
        ),
        ("Node", host!(Node { low, skip, high, triangles })),
        ("Triangle", host!(Triangle { corner, opacity, edge1, padding1, edge2, padding2 })),
        ("Moments", host!(MomentPart { count, mean, deviation })),
        ("Gradient", host!(GradientPart { surface, edge })),
        (
            "Appearance",
            host!(AppearancePart {
                count,
                mean,
                deviation,
                covariance_x,
                covariance_y,
                burnt,
                unlit,
                residual,
                detail,
                outline_count,
                outline
            }),
        ),
        (
            "Detail",
            host!(Detail {
                edge_contrast,
                mean,
                variance,
                gradient,
                detail,
                burnt,
                unlit,
                residual,
                outline,
                irradiance_mean,
                irradiance_variance,
                covariance_x,
                covariance_y,
                key_x,
                key_y,
                key_z,
                entropy,
                histogram
            }),
        ),
    ])
}

/// What a shader says of its structs that lie in memory.
struct Reflection {
    /// By name.
    structs: Vec<(String, Members)>,
    /// Struct name and stride of each array of structs.
    strides: Vec<(String, u32)>,
}

fn id(operand: &Operand) -> u32 {
    operand.id_ref_any().expect("an id")
}

fn number(operand: Option<&Operand>) -> u32 {
    match operand {
        Some(Operand::LiteralBit32(value)) => *value,
        other => panic!("not a number: {other:?}"),
    }
}

/// The decorations of one kind: what they decorate, and their value.
fn decorations(module: &Module, op: Op, kind: Decoration) -> Vec<(&Instruction, u32)> {
    let at = if op == Op::MemberDecorate { 2 } else { 1 };
    let of_kind =
        |i: &&Instruction| i.class.opcode == op && i.operands[at] == Operand::Decoration(kind);
    let found = module.annotations.iter().filter(of_kind);
    found.map(|i| (i, number(i.operands.get(at + 1)))).collect()
}

fn reflect(words: &[u32]) -> Reflection {
    let module = rspirv::dr::load_words(words).expect("SPIR-V");
    let mut names = HashMap::new();
    let mut members: BTreeMap<u32, BTreeMap<u32, (String, u32)>> = BTreeMap::new();
    let mut member_names = HashMap::new();
    for i in &module.debug_names {
        match (i.class.opcode, i.operands.as_slice()) {
            (Op::Name, [target, Operand::LiteralString(name)]) => {
                names.insert(id(target), name.clone());
            }
            (Op::MemberName, [target, index, Operand::LiteralString(name)]) => {
                member_names.insert((id(target), number(Some(index))), name.clone());
            }
            _ => {}
        }
    }
    for (i, offset) in decorations(&module, Op::MemberDecorate, Decoration::Offset) {
        let key = (id(&i.operands[0]), number(i.operands.get(1)));
        let name = member_names.get(&key).cloned().unwrap_or_default();
        members.entry(key.0).or_default().insert(key.1, (name, offset));
    }
    let mut strides = Vec::new();
    for (i, stride) in decorations(&module, Op::Decorate, Decoration::ArrayStride) {
        let array = id(&i.operands[0]);
        let declared = module.types_global_values.iter().find(|t| t.result_id == Some(array));
        let element = id(&declared.expect("a declared array").operands[0]);
        if members.contains_key(&element) {
            strides.push((names[&element].clone(), stride));
        }
    }
    let structs = members
        .into_iter()
        .map(|(target, members)| (names[&target].clone(), members.into_values().collect()))
        .collect();
    Reflection { structs, strides }
}

/// What differs between a shader and the host, in words.
fn differences(reflection: &Reflection, hosts: &BTreeMap<&str, Host>) -> Vec<String> {
    let mut found = Vec::new();
    for (name, members) in &reflection.structs {
        match hosts.get(name.as_str()) {
            Some(host) if host.members == *members => {}
            Some(host) => found.push(format!("{name}: {members:?}, host {:?}", host.members)),
            // A block of one member needs no layout of its own.
            None if members.len() == 1 && members[0].1 == 0 => {}
            None => found.push(format!("{name}: unknown to the host")),
        }
    }
    for (name, stride) in &reflection.strides {
        if hosts.get(name.as_str()).is_some_and(|host| host.size != *stride) {
            found.push(format!("{name}: stride {stride}, host {}", hosts[name.as_str()].size));
        }
    }
    found
}

#[test]
fn blocks_are_laid_out_as_the_host_writes_them() {
    let hosts = hosts();
    let mut seen = Vec::new();
    for (file, words) in shaders::ALL {
        let reflection = reflect(words);
        assert_eq!(differences(&reflection, &hosts), Vec::<String>::new(), "{file}");
        seen.extend(reflection.structs.into_iter().map(|(name, _)| name));
    }
    for name in hosts.keys() {
        assert!(seen.iter().any(|s| s == name), "no shader has a block of {name}");
    }
}

#[test]
fn a_moved_member_is_noticed() {
    let mut moved = hosts();
    let parameters = moved.get_mut("Parameters").expect("a struct of both sides");
    parameters.members[4].1 += 4;
    moved.get_mut("Light").expect("a struct of both sides").size += 16;
    assert_eq!(differences(&reflect(shaders::REFLECTANCE_COMP), &moved).len(), 1);
    assert_eq!(differences(&reflect(shaders::POPULATION_VERT), &moved).len(), 1);
}
