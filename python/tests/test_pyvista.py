from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import pyvista
from conftest import QUICK

import klieg
import klieg.pyvista


@pytest.fixture
def plotter() -> Iterator[Any]:
    """A height field in the colours of its data, beside a grey ball that is moved by its actor."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(320, 240))
    field = pyvista.ImageData(dimensions=(40, 40, 1), spacing=(0.1, 0.1, 1)).cast_to_structured_grid()
    x, y = field.points[:, 0] - 2, field.points[:, 1] - 2
    height = 0.5 * np.exp(-(x**2 + y**2))
    field.points[:, 2] = height
    field["height"] = height
    plotter.add_mesh(field, cmap="viridis", smooth_shading=True, show_scalar_bar=False, name="field")
    ball = plotter.add_mesh(pyvista.Sphere(radius=0.4), color="#c08060", smooth_shading=True, name="ball")
    ball.position = (1.0, 1.0, 1.0)
    plotter.camera_position = [(-3, -4, 4), (2, 2, 0.2), (0, 0, 1)]
    plotter.set_background("black")
    yield plotter
    plotter.close()


def test_the_scene_is_what_the_plotter_shows(plotter: Any) -> None:
    scene = klieg.pyvista.scene_of(plotter)
    view = klieg.pyvista.view_of(plotter, scene)
    assert view.size == (320, 240)
    maps = klieg.Evaluator(scene, view, device="cpu", shadows=False).maps()
    drawn = plotter.screenshot(return_img=True).sum(axis=2) > 0
    assert np.mean(drawn == (maps["code"] > 0)) > 0.995


def test_lights_keep_the_colours_of_the_data_and_come_near_klieg_s_picture(plotter: Any) -> None:
    before = plotter.screenshot(return_img=True)
    result = klieg.pyvista.light(plotter, **QUICK)
    after = plotter.screenshot(return_img=True)
    assert result.score < result.headlight_score
    assert 1 <= len(plotter.renderer.lights) <= 2
    assert not np.array_equal(before, after)
    klieg_s = result.picture(samples=4)[..., :3].astype(float)
    objects = after.sum(axis=2) > 0
    weights = np.array([0.2126, 0.7152, 0.0722])
    mine, its = klieg_s[objects] @ weights, after[objects] @ weights
    assert np.corrcoef(mine, its)[0, 1] > 0.9
    assert abs(mine.mean() - its.mean()) < 25
    # White lights scale colours: their shares stay as they were under PyVista's own lights, which are tinted a little.
    bright = objects & (before.min(axis=2) > 20) & (after.min(axis=2) > 20) & (after.max(axis=2) < 250)
    shares = [picture[bright] / picture[bright].sum(axis=1, keepdims=True) for picture in (before, after)]
    assert np.median(np.abs(shares[0] - shares[1])) < 0.02


def test_colours_of_cells_and_parallel_cameras(plotter: Any) -> None:
    plotter.clear_actors()
    cube = pyvista.Cube()
    cube.cell_data["side"] = np.arange(6)
    plotter.add_mesh(cube, cmap="tab10", show_scalar_bar=False)
    plotter.view_isometric()
    plotter.enable_parallel_projection()
    scene = klieg.pyvista.scene_of(plotter)
    view = klieg.pyvista.view_of(plotter, scene)
    assert view.half_height == pytest.approx(plotter.camera.parallel_scale)
    maps = klieg.Evaluator(scene, view, device="cpu").maps()
    seen = maps["base_color"][maps["code"] > 0]
    _, counts = np.unique(seen.round(3), axis=0, return_counts=True)
    # A pixel on an edge may show what is behind.
    assert (counts > 10).sum() == 3


def test_a_plotter_without_surfaces_is_refused(plotter: Any) -> None:
    plotter.clear_actors()
    with pytest.raises(klieg.InputError, match="no surfaces"):
        klieg.pyvista.light(plotter)
