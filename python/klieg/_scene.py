"""Scenes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from klieg import _klieg
from klieg._errors import InputError
from klieg._light import array
from klieg._settings import LoadOptions, native

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass
class Mesh:
    """Triangles and their material. V vertices, F triangles."""

    vertices: ArrayLike
    """Positions, shape [V, 3]."""
    faces: ArrayLike | None = None
    """Vertices of each triangle, shape [F, 3], counter-clockwise seen from the front; without them every three
    vertices are a triangle."""
    normals: ArrayLike | None = None
    """Normals, shape [V, 3], of any length; without them every triangle is flat."""
    colors: ArrayLike | None = None
    """sRGB colours, shape [V, 3] or [V, 4]: `uint8`, or floats of 0..1."""
    uvs: ArrayLike | None = None
    """Texture coordinates, shape [V, 2], (0, 0) at the texture's first texel."""
    texture: ArrayLike | None = None
    """The texture of the base colour, sRGB, `uint8[rows, columns, 3 or 4]`, rows from the top."""
    base_color: Sequence[float] | None = None
    """Linear RGB or RGBA of 0..1, multiplied with colours and texture; without those a neutral grey where absent."""
    metallic: float = 0.0
    """0 (a dielectric) to 1 (a metal)."""
    roughness: float = 0.6
    """Perceptual roughness, 0..1."""
    emissive: Sequence[float] = (0.0, 0.0, 0.0)
    """Linear emitted radiance, RGB."""
    double_sided: bool = True
    """Whether triangles are seen from behind, too."""
    transform: ArrayLike | None = None
    """World from the mesh's space, shape [4, 4]."""
    name: str = "mesh"
    """Name, for messages."""


@dataclass
class SceneLight:
    """A light that stands in the scene already; it counts where `keep_lights` says so."""

    kind: str
    """`point`, `directional` or `spot`."""
    position: ArrayLike
    """Position, shape [3], world units; directional lights ignore it."""
    direction: ArrayLike
    """Where it shines, shape [3]; point lights ignore it."""
    intensity: float
    """Candela, of directional lights lux: a white matt surface that faces 1 lux has the radiance 1/pi."""
    color: Sequence[float] = (1.0, 1.0, 1.0)
    """Linear RGB."""
    cone_deg: tuple[float, float] = (0.0, 45.0)
    """Inner and outer half angle of a spot's cone, degrees."""
    name: str = "light"
    """Name, for messages."""


class Scene:
    """Triangles, materials, cameras and lights, ready to be looked at. Nothing changes it."""

    __slots__ = ("_native",)

    def __init__(self, native: _klieg.Scene) -> None:
        """Wrap a native scene: take `load` or `from_arrays`."""
        self._native = native

    @classmethod
    def load(cls, path: str | PathLike[str], **options: Unpack[LoadOptions]) -> Scene:
        """Load a glTF, GLB, PLY, STL or OBJ file.

        What klieg leaves out of it is said on the logger `klieg`, and in `warnings`.

        Raises:
            InputError: for a file that cannot be read or used.

        """
        return cls(_klieg.Scene.load(path, native(options)))

    @classmethod
    def from_bytes(cls, data: bytes, kind: str = "glb", **options: Unpack[LoadOptions]) -> Scene:
        """Load what a file of the given kind, `glb`, `gltf`, `ply`, `stl` or `obj`, would hold.

        Raises:
            InputError: for data that cannot be used.

        """
        if not kind.isalnum():
            raise InputError(f"kind is {kind!r}: it must be the ending of a file's name")
        return cls(_klieg.Scene.from_bytes(bytes(data), kind, native(options)))

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, faces: ArrayLike | None = None, **mesh: Any) -> Scene:
        """Make a scene of one mesh: the arguments are the fields of `Mesh`.

        Raises:
            InputError: names what is wrong with the arrays.

        """
        return cls.from_meshes([Mesh(vertices, faces, **mesh)])

    @classmethod
    def from_meshes(cls, meshes: Iterable[Mesh], lights: Iterable[SceneLight] = (), *, name: str = "arrays") -> Scene:
        """Make a scene of meshes, and of lights that stand in it already.

        There is no file to put the lights of a result in: `Design.lights` tells where they stand.

        Raises:
            InputError: names the mesh and what is wrong with it.

        """
        builder = _klieg.SceneBuilder()
        for mesh in meshes:
            _add(builder, mesh)
        for one in lights:
            place, towards = (_three(value, one.name) for value in (one.position, one.direction))
            builder.light(one.name, one.kind, place, towards, list(one.color), one.intensity, one.cone_deg)
        return cls(builder.finish(name))

    @classmethod
    def from_trimesh(cls, mesh: Any, **options: Unpack[LoadOptions]) -> Scene:
        """Make a scene of a `trimesh.Trimesh` or `trimesh.Scene`, with its materials, colours and cameras.

        trimesh writes it as glTF, which klieg loads: PLY, STL, OBJ and whatever else trimesh reads comes in this way.

        Raises:
            InputError: for a mesh that trimesh cannot write, or that has no triangles.

        """
        try:
            data = mesh.export(file_type="glb")
        except Exception as fault:
            raise InputError(f"trimesh cannot write this mesh as glTF: {fault}") from fault
        return cls.from_bytes(data, "glb", **options)

    @property
    def path(self) -> Path:
        """The file, or the name of a scene of arrays."""
        return self._native.path

    @property
    def polygons(self) -> int:
        """Triangles that are drawn."""
        return self._native.polygons

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras."""
        return self._native.cameras

    @property
    def own_lights(self) -> int:
        """Number of the scene's own lights."""
        return self._native.own_lights

    @property
    def warnings(self) -> list[str]:
        """What was left out or replaced in loading."""
        return self._native.warnings

    @property
    def center(self) -> NDArray[np.float64]:
        """Centre of the box around all that is drawn, shape [3], world units."""
        return np.asarray(self._native.bounds()[0])

    @property
    def radius(self) -> float:
        """Largest distance of a vertex from the centre, world units."""
        return self._native.bounds()[1]

    def __repr__(self) -> str:
        """Tell name and size."""
        return f"Scene({str(self.path)!r}, {self.polygons} triangles)"


def _add(builder: _klieg.SceneBuilder, mesh: Mesh) -> None:
    """Add a mesh with its material."""
    plain = mesh.colors is None and mesh.texture is None
    base = (0.5, 0.5, 0.5) if plain else (1.0, 1.0, 1.0)
    color = [*(mesh.base_color if mesh.base_color is not None else base), 1.0][:4]
    texture = None
    if mesh.texture is not None:
        texture = builder.texture(mesh.name, _rgba(mesh.texture, 3, f"the texture of {mesh.name!r}"), True)
    textures = [texture, None, None, None]
    cutoff = 0.0
    material = builder.material(
        mesh.name, color, mesh.metallic, mesh.roughness, list(mesh.emissive), textures, cutoff, mesh.double_sided
    )
    number = builder.mesh(
        mesh.name,
        array(mesh.vertices, 2, f"the vertices of {mesh.name!r}"),
        None if mesh.faces is None else _faces(mesh.faces, mesh.name),
        None if mesh.normals is None else array(mesh.normals, 2, f"the normals of {mesh.name!r}"),
        None if mesh.uvs is None else array(mesh.uvs, 2, f"the uvs of {mesh.name!r}"),
        None if mesh.colors is None else _linear(_rgba(mesh.colors, 2, f"the colors of {mesh.name!r}")),
        material,
    )
    transform = np.eye(4) if mesh.transform is None else np.asarray(mesh.transform, dtype=np.float64)
    if transform.shape != (4, 4):
        raise InputError(f"the transform of {mesh.name!r} must be 4 x 4 numbers")
    builder.instance(mesh.name, number, transform.tolist())


def _three(values: ArrayLike, name: str) -> list[float]:
    found = np.asarray(values, dtype=np.float64)
    if found.shape != (3,):
        raise InputError(f"position and direction of the light {name!r} must have 3 numbers")
    return [float(value) for value in found]


def _faces(faces: ArrayLike, name: str) -> NDArray[np.uint32]:
    found = np.asarray(faces)
    if found.ndim != 2 or not np.issubdtype(found.dtype, np.integer):
        raise InputError(f"the faces of {name!r} must be integers of the shape [F, 3]")
    if found.size and (found.min() < 0 or found.max() > np.iinfo(np.uint32).max):
        raise InputError(f"the faces of {name!r} name a vertex that there is not")
    return np.ascontiguousarray(found, dtype=np.uint32)


def _rgba(colors: ArrayLike, axes: int, what: str) -> NDArray[np.uint8]:
    """Return colours of three or four channels as `uint8` with four."""
    found = np.asarray(colors)
    if found.ndim != axes or found.shape[-1] not in {3, 4}:
        raise InputError(f"{what} must have {axes} axes, the last of 3 or 4 channels")
    if np.issubdtype(found.dtype, np.floating):
        found = np.rint(np.clip(np.nan_to_num(found), 0.0, 1.0) * 255.0)
    elif found.dtype != np.uint8:
        raise InputError(f"{what} are of type {found.dtype}: they must be uint8, or floats of 0..1")
    rgba = np.full((*found.shape[:-1], 4), 255, dtype=np.uint8)
    rgba[..., : found.shape[-1]] = found
    return rgba


def _linear(rgba: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Decode sRGB (IEC 61966-2-1); alpha stays."""
    encoded = np.arange(256) / 255.0
    decoded = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    table = np.rint(decoded * 255.0).astype(np.uint8)
    rgba[..., :3] = table[rgba[..., :3]]
    return rgba
