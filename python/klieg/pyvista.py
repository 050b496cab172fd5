"""Lights for the view of a PyVista plotter.

>>> import klieg.pyvista
>>> klieg.pyvista.light(plotter)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista
from numpy.typing import NDArray

from klieg._design import Design, design
from klieg._device import Device
from klieg._errors import InputError
from klieg._evaluator import Evaluator
from klieg._light import Light
from klieg._scene import Mesh, Scene
from klieg._settings import DesignOptions
from klieg._view import View

if TYPE_CHECKING:
    from typing_extensions import Unpack

MOST = 512
"""Most pixels of a side of the picture that lights are searched for."""


def light(plotter: Any, *, device: str | int | Device = "auto", **options: Unpack[DesignOptions]) -> Design:
    """Search the lights of a plotter's present view, and put them in the place of the plotter's lights.

    What is lit are the surfaces of the visible actors, in the colours that they have: those of their data, where these
    are mapped. Colours, materials and camera stay as they are. VTK casts no shadows by itself, so that lights are
    searched without, unless `shadows` says otherwise. VTK shades in display space: intensities are those with which its
    picture comes nearest to klieg's.

    Args:
        plotter: a `pyvista.Plotter` with something to see.
        device: as for `klieg.design`.
        options: as for `klieg.design`.

    Returns:
        The design; its lights stand in the world of the plotter.

    Raises:
        InputError: for a plotter that shows no surfaces, and options out of their ranges.

    """
    asked: DesignOptions = {"shadows": False, **options}
    scene = scene_of(plotter)
    view = view_of(plotter, scene)
    result = design(scene, view, device=device, **asked)
    intensities = _in_display_space(scene, view, result.lights)
    plotter.remove_all_lights()
    for found, intensity in zip(result.lights, intensities, strict=True):
        if intensity > 0:
            plotter.add_light(_light(found, float(intensity), view))
    plotter.render()
    return result


def scene_of(plotter: Any) -> Scene:
    """Return the surfaces of a plotter's visible actors as a scene.

    Raises:
        InputError: where there are none.

    """
    actors = [actor for actor in plotter.renderer.actors.values() if isinstance(actor, pyvista.Actor)]
    meshes = [mesh for actor in actors if actor.visibility and (mesh := _mesh(actor)) is not None]
    if not meshes:
        raise InputError("the plotter shows no surfaces")
    return Scene.from_meshes(meshes, name="the plotter")


def view_of(plotter: Any, scene: Scene) -> View:
    """Return the present view of a plotter, its picture no larger than a search needs."""
    camera = plotter.camera
    back = np.subtract(camera.position, camera.focal_point)
    right = np.cross(camera.up, back)
    pose = np.eye(4)
    pose[:3, :] = np.column_stack([right, np.cross(back, right), back, camera.position])
    width, height = plotter.window_size
    scale = min(1.0, MOST / max(width, height))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    if camera.parallel_projection:
        return View.from_camera(scene, pose, size, half_height=camera.parallel_scale)
    return View.from_camera(scene, pose, size, fov=camera.view_angle)


def _mesh(actor: Any) -> Mesh | None:
    """Return the triangles of an actor in their colours; none where it shows no surface."""
    mapper, look = actor.mapper, actor.prop
    data = mapper.dataset
    if data is None or look.style.lower() != "surface" or look.opacity == 0:
        return None
    mapped = _mapped(mapper)
    shown = data.copy(deep=False)
    if mapped is not None:
        part = shown.point_data if len(mapped) == data.n_points else shown.cell_data
        part["klieg colours"] = mapped
    surface = shown.extract_surface(algorithm="dataset_surface").triangulate()
    if surface.n_cells == 0:
        return None
    faces = surface.faces.reshape(-1, 4)[:, 1:]
    points, colors = np.asarray(surface.points), None
    normals = np.asarray(surface.compute_normals(split_vertices=False, auto_orient_normals=False).point_normals)
    smooth = look.interpolation != pyvista.plotting.opts.InterpolationType.FLAT
    if "klieg colours" in surface.point_data:
        colors = np.asarray(surface.point_data["klieg colours"])
    elif "klieg colours" in surface.cell_data:
        # Every triangle has its own corners, so that colours do not run into each other.
        colors = np.repeat(np.asarray(surface.cell_data["klieg colours"]), 3, axis=0)
        points, normals = points[faces.ravel()], normals[faces.ravel()]
        faces = np.arange(len(points)).reshape(-1, 3)
    base = None if colors is not None else _decoded(np.asarray(look.color.float_rgb))
    return Mesh(
        points,
        faces,
        normals=normals if smooth else None,
        colors=colors,
        base_color=base,
        roughness=look.roughness if look.interpolation == pyvista.plotting.opts.InterpolationType.PBR else 0.6,
        transform=np.asarray(pyvista.array_from_vtkmatrix(actor.GetMatrix())),
        name=actor.name or "actor",
    )


def _mapped(mapper: Any) -> NDArray[np.uint8] | None:
    """Return the colours that a mapper gives the data, `uint8[points or cells, 4]`."""
    if not mapper.scalar_visibility:
        return None
    # Colours that are looked up in a texture are none of the vertices'.
    textured = mapper.GetInterpolateScalarsBeforeMapping()
    mapper.SetInterpolateScalarsBeforeMapping(False)
    found = mapper.MapScalars(1.0)
    mapper.SetInterpolateScalarsBeforeMapping(textured)
    return None if found is None else np.array(pyvista.convert_array(found), dtype=np.uint8)


def _decoded(encoded: NDArray[Any]) -> list[float]:
    """Return an sRGB colour of 0..1 in linear RGB."""
    low = encoded / 12.92
    return [float(value) for value in np.where(encoded <= 0.04045, low, ((encoded + 0.055) / 1.055) ** 2.4)]


def _encoded(linear: NDArray[Any]) -> NDArray[Any]:
    """Return linear values of 0..1 in sRGB."""
    return np.asarray(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def _in_display_space(scene: Scene, view: View, rig: list[Light]) -> NDArray[np.float64]:
    """Return the intensities with which VTK's picture comes nearest to klieg's.

    VTK adds what the lights give in display space, klieg in linear light, which is encoded at the end. What each light
    alone would give in VTK is fitted to the luminance of klieg's picture by least squares, without negative ones.
    """
    evaluator = Evaluator(scene, view, device="cpu", shadows=False)
    maps = evaluator.maps()
    target = evaluator.inspect(rig)[2]
    objects = maps["code"] > 0
    albedo = _encoded(maps["base_color"][objects] @ np.array([0.2126, 0.7152, 0.0722]))
    parts = np.stack([albedo * _shade(maps, objects, one) for one in rig], axis=1)
    lit = np.arange(len(rig))
    while True:
        found = np.zeros(len(rig))
        found[lit] = np.linalg.lstsq(parts[:, lit], target[objects], rcond=None)[0]
        if (found >= 0).all():
            return found
        lit = np.flatnonzero(found > 0)


def _shade(maps: dict[str, NDArray[Any]], objects: NDArray[np.bool_], one: Light) -> NDArray[np.float64]:
    """Return what a light of intensity 1 gives a white surface in VTK, for each object pixel."""
    position = maps["position"][objects].astype(np.float64)
    elevation, azimuth = np.radians([one.elevation_deg, one.azimuth_deg])
    towards = np.array([np.cos(elevation) * np.sin(azimuth), np.sin(elevation), np.cos(elevation) * np.cos(azimuth)])
    way = np.broadcast_to(towards, position.shape)
    falloff = np.ones(len(position))
    if one.distance is not None:
        way = towards * one.distance - position
        length = np.linalg.norm(way, axis=1)
        way, falloff = way / length[:, None], (one.distance / length) ** 2
    return np.asarray(np.clip((maps["normal"][objects] * way).sum(axis=1), 0, None) * falloff)


def _light(found: Light, intensity: float, view: View) -> Any:
    """Return a light of VTK."""
    color = np.asarray(found.color_rgb)
    strongest = color.max()
    encoded = _encoded(color / strongest)
    added = pyvista.Light(light_type="scene light", color=encoded, intensity=intensity)
    if found.position is None:
        added.positional = False
        added.position = tuple(view.center - np.asarray(found.axis) * view.radius)
        added.focal_point = tuple(view.center)
        return added
    added.positional = True
    added.position = tuple(found.position)
    added.focal_point = tuple(view.center if found.axis is None else found.position + found.axis)
    added.cone_angle = 90.0 if found.cone_deg is None else found.cone_deg[1]
    reach = float(found.distance or 1.0) * view.radius
    added.attenuation_values = (0.0, 0.0, 1.0 / reach**2)
    return added
