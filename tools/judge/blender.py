"""Renders a lit scene in Cycles: blender.py JOB.json.

The job names `scene` (a lit.glb), `size`, `samples`, `threads`, `ambient`, `rigs` (name: list of
[elevation, azimuth, intensity], degrees in the camera's axes) and `out`, a folder, where every picture comes
to lie as `NAME.npy`: float32, height x width x 4, linear sRGB with premultiplied alpha. `design` has the
scene's own lights and `rigs` those of the job, with shadows and all bounces. `direct` is the design without
bounces under the ambient light, `plain` without bounces and shadows. `normal.npy` (camera's axes),
`albedo.npy` and `depth.npy` (radii of the scene) tell of the surface.
"""

import json
import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector


def at_rest(file, out):
    """Writes the GLB without animations: nodes stand as the file has them, as klieg draws them."""
    data = file.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    document, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    document.pop("animations", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    sizes = [12 + 8 + len(text) + len(rest), len(text)]
    whole, chunk = (size.to_bytes(4, "little") for size in sizes)
    out.write_bytes(data[:8] + whole + chunk + b"JSON" + text + rest)


def load(job):
    """Imports the scene; gives klieg's camera."""
    still = Path(job["out"]) / "still.glb"
    at_rest(Path(job["scene"]), still)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    options = {"export_import_convert_lighting_mode": "COMPAT", "disable_bone_shape": True}
    bpy.ops.import_scene.gltf(filepath=str(still), **options)
    still.unlink()
    scene = bpy.context.scene
    for material in bpy.data.materials:
        if material.use_nodes and material.use_backface_culling:
            cull(material)
    cameras = [thing for thing in scene.objects if thing.type == "CAMERA" and "camera" in extras(thing)]
    if not cameras:
        raise ValueError("the scene has no camera of klieg's")
    scene.camera = cameras[-1]
    return scene.camera


def extras(thing):
    """What klieg noted at a node."""
    block = thing.get("klieg")
    return block.to_dict() if hasattr(block, "to_dict") else {}


def cull(material):
    """Lets the camera see through the back faces of a single-sided material, as glTF's viewers do; they still
    cast shadows."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    output = material.node_tree.get_output_node("CYCLES")
    surface = output.inputs["Surface"].links[0].from_socket
    side, ray = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeLightPath")
    both, mixed = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeMixShader")
    both.operation = "MULTIPLY"
    links.new(side.outputs["Backfacing"], both.inputs[0])
    links.new(ray.outputs["Is Camera Ray"], both.inputs[1])
    links.new(both.outputs["Value"], mixed.inputs["Fac"])
    links.new(surface, mixed.inputs[1])
    links.new(nodes.new("ShaderNodeBsdfTransparent").outputs["BSDF"], mixed.inputs[2])
    links.new(mixed.outputs["Shader"], output.inputs["Surface"])


def prepare(job):
    """Cycles as it comes, on a black world, without a view transform."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = True
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", job["samples"], 0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    set_ambient(0.0)
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = True
    layer.cycles.denoising_store_passes = True


def set_ambient(radiance):
    """Lights the scene from all sides; nothing of it shows in the background."""
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (radiance, radiance, radiance, 1.0)


def write_passes(folder):
    """Lets every render write its passes as OpenEXR files; gives their names."""
    scene = bpy.context.scene
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    layers, files = nodes.new("CompositorNodeRLayers"), nodes.new("CompositorNodeOutputFile")
    files.base_path = str(folder)
    files.format.file_format, files.format.color_depth = "OPEN_EXR", "32"
    files.format.color_mode = "RGBA"
    files.file_slots.clear()
    passes = {"picture": "Image", "depth": "Depth", "normal": "Normal", "albedo": "Denoising Albedo"}
    for name, socket in passes.items():
        files.file_slots.new(name)
        links.new(layers.outputs[socket], files.inputs[name])
    links.new(layers.outputs["Image"], nodes.new("CompositorNodeComposite").inputs["Image"])


def render(folder, size):
    """Renders; gives the passes as arrays, the top row first."""
    bpy.ops.render.render()
    found = {}
    for name in ("picture", "depth", "normal", "albedo"):
        image = bpy.data.images.load(str(folder / f"{name}{bpy.context.scene.frame_current:04}.exr"))
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(size[0] * size[1] * 4, np.float32)
        image.pixels.foreach_get(pixels)
        found[name] = pixels.reshape(size[1], size[0], 4)[::-1]
        bpy.data.images.remove(image)
    return found


def emits(thing):
    """Whether a mesh has a material that emits."""
    materials = [slot.material for slot in thing.material_slots if slot.material and slot.material.use_nodes]
    nodes = [node for material in materials for node in material.node_tree.nodes]
    strengths = [node.inputs["Emission Strength"] for node in nodes if "Emission Strength" in node.inputs]
    return any(strength.is_linked or strength.default_value > 0 for strength in strengths)


def set_glow(lit):
    """Whether surfaces that emit light others."""
    for thing in bpy.context.scene.objects:
        if thing.type == "MESH" and emits(thing):
            thing.visible_diffuse = thing.visible_glossy = thing.visible_transmission = lit
    for material in bpy.data.materials:
        material.cycles.emission_sampling = "AUTO" if lit else "NONE"


def lights():
    return [thing for thing in bpy.context.scene.objects if thing.type == "LIGHT"]


def set_sizes():
    """Gives the design's lights the radii that klieg noted, in world units; others are points."""
    for thing in lights():
        radius = extras(thing).get("light", {}).get("radius", 0.0)
        thing.visible_camera = False
        if thing.data.type == "SUN":
            thing.data.angle = 0.0
        else:
            thing.data.shadow_soft_size = radius


def set_rig(rig, camera):
    """Puts directional lights in the place of all lights."""
    for thing in lights():
        bpy.data.objects.remove(thing)
    axes = camera.matrix_world.to_3x3().normalized()
    for elevation, azimuth, intensity in rig:
        elevation, azimuth = math.radians(elevation), math.radians(azimuth)
        level = math.cos(elevation)
        towards = Vector((level * math.sin(azimuth), math.sin(elevation), level * math.cos(azimuth)))
        sun = bpy.data.lights.new("preset", "SUN")
        # A white matt surface that faces a sun of strength pi shows white.
        sun.energy, sun.angle = math.pi * intensity, 0.0
        thing = bpy.data.objects.new("preset", sun)
        thing.matrix_world = (axes @ towards).to_track_quat("Z", "Y").to_matrix().to_4x4()
        bpy.context.scene.collection.objects.link(thing)


def scene_radius():
    """Radius of the ball around all meshes' boxes, world units."""
    meshes = [thing for thing in bpy.context.scene.objects if thing.type == "MESH" and not thing.hide_render]
    corners = [thing.matrix_world @ Vector(corner) for thing in meshes for corner in thing.bound_box]
    corners = np.array(corners)
    return max(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)) / 2, 1e-12)


def surface(passes, camera):
    """Normals in the camera's axes, albedo, and depth in radii of the scene."""
    axes = np.array(camera.matrix_world.to_3x3().normalized())
    normal = passes["normal"][..., :3] @ axes
    lengths = np.linalg.norm(normal, axis=-1, keepdims=True)
    alpha = np.maximum(passes["picture"][..., 3:], 1e-6)
    return {
        "normal": normal / np.maximum(lengths, 1e-6),
        "albedo": passes["albedo"][..., :3] / alpha,
        "depth": passes["depth"][..., 0] / scene_radius(),
    }


def main(job):
    out = Path(job["out"])
    camera = load(job)
    prepare(job)
    write_passes(out)
    set_sizes()
    cycles = bpy.context.scene.cycles
    size = job["size"]

    def save(name, array):
        np.save(out / f"{name}.npy", array.astype(np.float32))

    passes = render(out, size)
    save("design", passes["picture"])
    for name, array in surface(passes, camera).items():
        save(name, array)
    bounces, cycles.max_bounces = cycles.max_bounces, 0
    set_ambient(job["ambient"])
    set_glow(False)
    save("direct", render(out, size)["picture"])
    set_ambient(0.0)
    for thing in lights():
        thing.data.use_shadow = False
    save("plain", render(out, size)["picture"])
    cycles.max_bounces = bounces
    set_glow(True)
    for name, rig in job["rigs"].items():
        set_rig(rig, camera)
        save(name, render(out, size)["picture"])
    for file in out.glob("*.exr"):
        file.unlink()


if __name__ == "__main__":
    main(json.loads(Path(sys.argv[1]).read_text()))
