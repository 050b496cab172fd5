"""Lights for the view of a Blender scene: what the add-on in `python/blender` does, for scripts too.

>>> import bpy
>>> import klieg.blender
>>> klieg.blender.light(bpy.context)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from klieg._blender_materials import Materials
from klieg._design import Design, design
from klieg._device import Device
from klieg._errors import InputError
from klieg._scene import Mesh, Scene, SceneLight
from klieg._settings import DesignOptions
from klieg._view import View

if TYPE_CHECKING:
    from typing_extensions import Unpack

COLLECTION = "klieg lights"
"""The collection that holds the lights that klieg made; the next ones take their place."""

MOST = 512
"""Most pixels of a side of the picture that lights are searched for."""


def light(context: Any, *, device: str | int | Device = "auto", **options: Unpack[DesignOptions]) -> Design:
    """Search the lights of the active camera's view, and put them into the scene in the place of klieg's earlier ones.

    What is lit is the evaluated scene: instances, modifiers and rigs as they stand in this frame. Other lights of the
    scene stay and count with `keep_lights`; without it those that are not locked are hidden from renders.

    Args:
        context: Blender's context.
        device: as for `klieg.design`.
        options: as for `klieg.design`.

    Returns:
        The design; its lights stand in Blender's world.

    Raises:
        InputError: for a scene without a camera or without surfaces, and options out of their ranges.

    """
    keep = options.get("keep_lights", False)
    scene, view = look(context, keep_lights=keep)
    # Those of the scene that are not kept are not in it.
    all_kept: DesignOptions = {"keep_lights": True}
    result = design(scene, view, device=device, **(options | all_kept))
    place(context, result, keep_lights=keep)
    return result


def look(context: Any, *, keep_lights: bool) -> tuple[Scene, View]:
    """Return the evaluated scene, with the lights that are kept, and the active camera's view."""
    depsgraph = context.evaluated_depsgraph_get()
    materials = Materials()
    meshes = [mesh for instance in depsgraph.object_instances for mesh in _meshes(instance, depsgraph, materials)]
    if not meshes:
        raise InputError(f"the scene {context.scene.name!r} shows no surfaces")
    lights = [_own(other) for other in _kept(context, keep_lights=keep_lights)]
    scene = Scene.from_meshes(meshes, lights, name=context.scene.name)
    return scene, _view(context, scene, depsgraph)


def place(context: Any, result: Design, *, keep_lights: bool) -> list[Any]:
    """Make Blender's lights of a result, in a collection of their own; return their objects."""
    for other in _others(context):
        if not keep_lights and not _locked(other):
            other.hide_render = True
    collection = _emptied(context)
    made = []
    for found in result.lights:
        if found.role == "scene":
            continue
        name = f"klieg {found.role}"
        lamp = bpy.data.lights.new(name, {"point": "POINT", "directional": "SUN", "spot": "SPOT"}[found.kind])
        strength = np.asarray(found.color_rgb)
        lamp.color = strength / strength.max()
        lamp.energy = power(found.kind, float(found.intensity or 0.0) * float(strength.max()))
        if found.kind == "directional":
            lamp.angle = 2 * math.atan(found.size)
        else:
            lamp.shadow_soft_size = found.size * result.view.radius
        if found.cone_deg is not None:
            inner, outer = np.radians(found.cone_deg)
            lamp.spot_size = 2 * outer
            lamp.spot_blend = 1 - math.tan(inner) / math.tan(min(outer, 1.57))
        holder = bpy.data.objects.new(name, lamp)
        holder.matrix_world = _matrix(found, result.view)
        collection.objects.link(holder)
        made.append(holder)
    return made


def power(kind: str, intensity: float) -> float:
    """Return Blender's strength of a light: watts, of a sun watts per square metre.

    A white matt surface that faces a light of I candela at 1 m has the radiance I/pi; in Cycles one of P watts gives it
    P/(4 pi^2). No luminous efficacy is in between: 683 lm/W would be one of a light's colour, not of its strength.
    """
    return intensity if kind == "directional" else 4 * math.pi * intensity


def _matrix(found: Any, view: View) -> Any:
    """Return the pose of a light, which shines along its -Z axis."""
    from mathutils import Matrix, Vector  # noqa: PLC0415 - Blender's own

    axis = view.center - found.position if found.axis is None else found.axis
    turn = Vector([float(x) for x in axis]).to_track_quat("-Z", "Y")
    where = view.center - 2 * view.radius * axis if found.position is None else found.position
    return Matrix.Translation([float(x) for x in where]) @ turn.to_matrix().to_4x4()


def _emptied(context: Any) -> Any:
    """Return klieg's collection, without the lights that it had."""
    collection = bpy.data.collections.get(COLLECTION) or bpy.data.collections.new(COLLECTION)
    for old in list(collection.objects):
        data = old.data
        bpy.data.objects.remove(old)
        if data is not None and data.users == 0:
            bpy.data.lights.remove(data)
    if collection.name not in context.scene.collection.children:
        context.scene.collection.children.link(collection)
    return collection


def _others(context: Any) -> Iterator[Any]:
    """Give the objects of lights that klieg did not make and that are rendered."""
    ours = bpy.data.collections.get(COLLECTION)
    for other in context.scene.objects:
        mine = ours is not None and other.name in ours.objects
        if other.type == "LIGHT" and not other.hide_render and not mine:
            yield other


def _locked(other: Any) -> bool:
    """Tell whether nobody may move a light: then it is a part of the picture."""
    return all(other.lock_location)


def _kept(context: Any, *, keep_lights: bool) -> Iterator[Any]:
    for other in _others(context):
        if (keep_lights or _locked(other)) and other.data.type in {"POINT", "SUN", "SPOT"}:
            yield other


def _own(other: Any) -> SceneLight:
    """Return a light of the scene as klieg has it."""
    kind = {"POINT": "point", "SUN": "directional", "SPOT": "spot"}[other.data.type]
    matrix = np.array(other.matrix_world)
    cone = (0.0, 45.0)
    if kind == "spot":
        outer = other.data.spot_size / 2
        inner = math.atan(math.tan(min(outer, 1.57)) * (1 - other.data.spot_blend))
        cone = (math.degrees(min(inner, outer - 1e-3)), math.degrees(outer))
    strength = other.data.energy / power(kind, 1.0)
    return SceneLight(kind, matrix[:3, 3], -matrix[:3, 2], strength, tuple(other.data.color), cone, other.name)


def _view(context: Any, scene: Scene, depsgraph: Any) -> View:
    """Return the view of the active camera."""
    camera, render = context.scene.camera, context.scene.render
    if camera is None:
        raise InputError(f"the scene {context.scene.name!r} has no active camera")
    width = render.resolution_x * render.pixel_aspect_x
    height = render.resolution_y * render.pixel_aspect_y
    scale = min(1.0, MOST / max(width, height))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1]))
    pose = np.array(camera.evaluated_get(depsgraph).matrix_world)
    planes = {"near": camera.data.clip_start, "far": camera.data.clip_end}
    if camera.data.type == "ORTHO":
        return View.from_camera(scene, pose, size, half_height=1 / projection[1, 1], **planes)
    return View.from_camera(scene, pose, size, fov=2 * math.degrees(math.atan(1 / projection[1, 1])), **planes)


def _meshes(instance: Any, depsgraph: Any, materials: Materials) -> list[Mesh]:
    """Return the triangles of an instance as it is rendered, by material; none of what is no surface."""
    shown = instance.object
    original = shown.original
    if shown.type not in {"MESH", "CURVE", "SURFACE", "META", "FONT"} or original.hide_render:
        return []
    data = shown.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    if data is None:
        return []
    try:
        data.calc_loop_triangles()
        count = len(data.loop_triangles)
        corners = _read(data.loop_triangles, "loops", 3 * count, np.int32).reshape(-1, 3)
        slots = _read(data.loop_triangles, "material_index", count, np.int32)
        vertices = _read(data.loops, "vertex_index", len(data.loops), np.int32)
        points = _read(data.vertices, "co", 3 * len(data.vertices), np.float32).reshape(-1, 3)
        normals = _read(data.corner_normals, "vector", 3 * len(data.loops), np.float32).reshape(-1, 3)
        made = []
        for slot in np.unique(slots):
            loops = corners[slots == slot].reshape(-1)
            held = shown.material_slots
            material = held[min(slot, len(held) - 1)].material if held else None
            made.append(
                Mesh(
                    points[vertices[loops]],
                    normals=normals[loops],
                    transform=np.array(instance.matrix_world),
                    name=original.name,
                    **materials.fields(material, data, loops),
                )
            )
        return made
    finally:
        shown.to_mesh_clear()


def _read(collection: Any, name: str, length: int, kind: type) -> NDArray[Any]:
    values: NDArray[Any] = np.empty(length, dtype=kind)
    collection.foreach_get(name, values)
    return values
