from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from conftest import QUICK, ROOT

import klieg
from klieg._settings import DesignOptions

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float32)


def test_a_file_is_loaded_and_told(elephant: Path) -> None:
    scene = klieg.Scene.load(str(elephant))
    assert scene.path == elephant
    assert scene.polygons > 1000
    assert scene.center.shape == (3,)
    assert scene.radius > 0
    assert "elephant.glb" in repr(scene)


@pytest.mark.parametrize("kind", ["glb", "ply", "stl", "obj"])
def test_the_same_from_bytes(kind: str) -> None:
    data = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind)
    scene = klieg.Scene.from_bytes(data if isinstance(data, bytes) else data.encode(), kind, units=1.0)
    assert scene.polygons == 80
    assert scene.radius == pytest.approx(1, rel=1e-5)


def test_a_mesh_of_trimesh_is_lit() -> None:
    mesh = trimesh.creation.torus(1.0, 0.4)
    mesh.visual.vertex_colors = [200, 80, 40, 255]
    scene = klieg.Scene.from_trimesh(mesh)
    assert scene.polygons == len(mesh.faces)
    result = klieg.design(scene, klieg.View(scene, (64, 64)), device="cpu", **QUICK)
    assert result.to_glb()[:4] == b"glTF"
    maps = klieg.Evaluator(scene, klieg.View(scene, (64, 64)), device="cpu").maps()
    color = maps["base_color"][maps["code"] > 0]
    # As glTF has vertex colours: linear.
    assert color[0] * 255 == pytest.approx([200, 80, 40], abs=0.5)


def test_arrays_are_drawn_where_their_transform_puts_them() -> None:
    move = np.eye(4)
    move[:3, 3] = [5, 6, 7]
    scene = klieg.Scene.from_meshes([klieg.Mesh(TRIANGLE, [[0, 1, 2]], transform=move)])
    assert np.allclose(scene.center, [5.5, 6.5, 7])
    assert klieg.Scene.from_arrays(TRIANGLE.astype(np.float64)).polygons == 1


def colors(**mesh: Any) -> np.ndarray[Any, Any]:
    scene = klieg.Scene.from_arrays(TRIANGLE, **mesh)
    view = klieg.View(scene, (32, 32), azimuth=0, elevation=0)
    maps = klieg.Evaluator(scene, view, device="cpu").maps()
    return np.asarray(np.median(maps["base_color"][maps["code"] > 0], axis=0))


def test_colors_of_arrays_are_encoded_as_pictures_are() -> None:
    linear = np.array([1.0, 0.2158605, 0.0])
    bytes_ = np.tile(np.array([255, 128, 0], dtype=np.uint8), (3, 1))
    assert colors(colors=bytes_) == pytest.approx(linear, abs=4e-3)
    assert colors(colors=bytes_ / 255) == pytest.approx(linear, abs=4e-3)
    assert colors(base_color=(0.25, 0.5, 0.75)) == pytest.approx([0.25, 0.5, 0.75], abs=1e-6)
    assert colors() == pytest.approx([0.5] * 3, abs=1e-6)
    texture = np.full((2, 2, 3), (255, 128, 0), dtype=np.uint8)
    assert colors(texture=texture, uvs=np.zeros((3, 2))) == pytest.approx(linear, abs=4e-3)


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ({"faces": [[0, 1, 3]]}, "3"),
        ({"faces": [[0, 1, -1]]}, "vertex that there is not"),
        ({"faces": [[0.5, 1, 2]]}, "integers"),
        ({"faces": [[0, 1]]}, "columns"),
        ({"normals": np.zeros((2, 3))}, "normals"),
        ({"colors": np.zeros((3, 2), dtype=np.uint8)}, "channels"),
        ({"colors": np.zeros((3, 3), dtype=np.int32)}, "int32"),
        ({"transform": np.eye(3)}, "4 x 4"),
        ({"vertices": np.full((3, 3), np.nan)}, "finite"),
        ({"vertices": "abc"}, "vertices"),
        ({"vertices": np.zeros((3, 3))}, "extent"),
        ({"texture": np.zeros((2, 2, 3), dtype=np.uint8)}, "coordinate"),
    ],
)
def test_arrays_that_make_no_scene_are_refused(mesh: dict[str, Any], words: str) -> None:
    with pytest.raises(klieg.InputError, match=words):
        klieg.Scene.from_arrays(**{"vertices": TRIANGLE, **mesh})


def test_files_that_make_no_scene_are_named(tmp_path: Path) -> None:
    with pytest.raises(klieg.InputError, match=r"none\.glb"):
        klieg.Scene.load("none.glb")
    broken = tmp_path / "broken.glb"
    broken.write_bytes((ROOT / "scenes" / "pair.glb").read_bytes()[:500])
    with pytest.raises(ValueError, match=r"broken\.glb") as caught:
        klieg.Scene.load(broken)
    assert isinstance(caught.value, klieg.Error)
    with pytest.raises(klieg.InputError):
        klieg.Scene.from_bytes(b"nothing", "glb")
    with pytest.raises(klieg.InputError, match="ending"):
        klieg.Scene.from_bytes(b"nothing", "../x")
    with pytest.raises(klieg.InputError, match="trimesh"):
        klieg.Scene.from_trimesh(trimesh.Scene())


def test_a_scene_of_arrays_has_no_file_to_be_lit(tmp_path: Path) -> None:
    sphere = trimesh.creation.icosphere(subdivisions=2)
    scene = klieg.Scene.from_arrays(sphere.vertices, sphere.faces, normals=sphere.vertex_normals)
    result = klieg.design(scene, klieg.View(scene, (48, 48)), device="cpu", **QUICK)
    assert result.score < result.headlight_score
    with pytest.raises(klieg.InputError, match="made of arrays"):
        result.save_gltf(tmp_path / "lit.glb")


def test_lights_that_stand_in_a_scene_of_arrays_are_kept() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=2)
    sun = klieg.SceneLight("directional", (0, 0, 0), (0, -1, 0), np.pi)
    lamp = klieg.SceneLight("point", (3, 0, 0), (0, 0, -1), 9 * np.pi, (1, 0, 0))
    mesh = klieg.Mesh(sphere.vertices, sphere.faces, normals=sphere.vertex_normals)
    scene = klieg.Scene.from_meshes([mesh], [sun, lamp])
    assert scene.own_lights == 2
    view = klieg.View(scene, (48, 48), azimuth=0, elevation=0)
    options: DesignOptions = {"lights": 1, "keep_lights": True}
    result = klieg.design(scene, view, device="cpu", **(QUICK | options))
    key, above, red = result.lights
    assert key.role == "key"
    assert above.kind == "directional"
    assert above.diffuse == pytest.approx(1, rel=1e-5)
    assert above.elevation_deg == pytest.approx(90, abs=1e-3)
    assert red.distance == pytest.approx(3, rel=1e-4)
    assert red.color == "#ff0000"
    with pytest.raises(klieg.InputError, match="direction"):
        klieg.Scene.from_meshes([mesh], [klieg.SceneLight("point", (0, 0, 0), (0, 0, 0), 1)])
