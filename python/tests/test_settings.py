from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import QUICK

import klieg


def test_what_there_is_is_listed() -> None:
    assert set(klieg.profiles()) == {"paper", "natural"}
    assert "mean" in klieg.terms()
    assert "shade" in klieg.optimizers()
    found = klieg.devices()
    assert [device.index for device in found] == list(range(len(found)))
    assert found[-1].type == "cpu"
    assert sum(device.auto for device in found) == 1


def score(scene: klieg.Scene, view: klieg.View, **options: Any) -> float:
    return klieg.design(scene, view, device="cpu", **{**QUICK, **options}).score


def test_options_stand_in_the_place_of_a_file_s(pair: klieg.Scene, view: klieg.View, tmp_path: Path) -> None:
    file = tmp_path / "klieg.toml"
    file.write_text('profile = "paper"\nseed = 5\n[search]\ngenerations = 6\npopulation = 8\n')
    plain = score(pair, view, profile="paper", seed=5)
    assert klieg.design(pair, view, device="cpu", config=file).score == plain
    assert klieg.design(pair, view, device="cpu", config=file, seed=6).score == score(
        pair, view, profile="paper", seed=6
    )
    assert score(pair, view, settings={"profile": "paper"}, profile="paper", seed=5) == plain
    file.write_text("[search]\ngeneration = 6\n")
    with pytest.raises(klieg.InputError, match=r"klieg\.toml: .*line 2"):
        klieg.design(pair, view, config=file)


def test_an_objective_is_a_profile_s_or_one_s_own(pair: klieg.Scene, view: klieg.View) -> None:
    natural = klieg.Objective.of("natural")
    assert natural.mean_target == "scene"
    assert score(pair, view, objective=natural) == score(pair, view)
    mean = klieg.Objective({"mean": 1.0}, mean_target=0.9)
    assert score(pair, view, objective=mean) < 0.5
    assert score(pair, view, weights={"mean": 3.0}) != score(pair, view)
    weights = {**natural.weights, "mean": 3.0}
    assert score(pair, view, weights={"mean": 3.0}) == score(pair, view, settings={"objective": {"weights": weights}})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"profile": "film"}, "film"),
        ({"weights": {"beauty": 1.0}}, "beauty"),
        ({"lights": 0}, "0 lights"),
        ({"lights": ["back"]}, "list of roles"),
        ({"generations": "many"}, "generations|invalid type"),
        ({"optimizer": "magic"}, "magic"),
        ({"color": "red"}, "red"),
        ({"color": {"back": "#ffffff"}}, "back"),
        ({"intensities": "three"}, "three"),
        ({"seed": -1}, "seed"),
        ({"settings": {"lihgts": {}}}, "lihgts"),
        ({"samples": 3}, "square"),
        ({"time_limit": 0.0}, "time_limit"),
        ({"device": "no such device"}, "no such device"),
        ({"magic": 1}, "magic"),
        ({"size": 3}, "size"),
    ],
)
def test_options_out_of_their_ranges_are_refused(
    pair: klieg.Scene, view: klieg.View, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(klieg.InputError, match=words):
        klieg.design(pair, view, **{"device": "cpu", **options})


def test_views_by_name_by_angle_and_by_matrix(pair: klieg.Scene) -> None:
    framed = klieg.View(pair, (64, 48), azimuth=40, elevation=20, fov=30)
    assert framed.fov == pytest.approx(30)
    pose = framed.world_from_camera
    pose[:3, 0] *= 3
    same = klieg.View.from_camera(pair, pose, (64, 48), fov=30)
    assert np.allclose(same.world_from_camera, framed.world_from_camera)
    looking = klieg.View.look_at(pair, framed.world_from_camera[:3, 3], size=(64, 48), fov=30)
    back = framed.world_from_camera[:3, 3] - pair.center
    assert np.allclose(looking.world_from_camera[:3, 2], back / np.linalg.norm(back))
    flat = klieg.View.from_camera(pair, pose, half_height=2.0)
    assert (flat.fov, flat.half_height) == (None, 2.0)
    wrongs: list[Callable[[], klieg.View]] = [
        lambda: klieg.View.from_camera(pair, np.eye(3), fov=30),
        lambda: klieg.View.from_camera(pair, np.diag([1.0, 1, -1, 1]), fov=30),
        lambda: klieg.View.from_camera(pair, np.zeros((4, 4)), fov=30),
        lambda: klieg.View.from_camera(pair, np.eye(4)),
        lambda: klieg.View.look_at(pair, [0, 9, 0], [0, 0, 0]),
        lambda: klieg.View(pair, (0, 5)),
        lambda: klieg.View(pair, camera="none"),
    ]
    for wrong in wrongs:
        with pytest.raises(klieg.InputError):
            wrong()


def test_warnings_come_on_the_log(pair: klieg.Scene, view: klieg.View, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "klieg"):
        klieg.design(pair, view, device="cpu", **QUICK)
    assert any("device:" in record.getMessage() for record in caplog.records)


WITHOUT = """
import klieg
assert [device.type for device in klieg.devices()] == ["cpu"]
scene = klieg.Scene.load(__import__("sys").argv[1])
result = klieg.design(scene, klieg.View(scene, (48, 48)), generations=2, population=4, coarse=0)
try:
    klieg.Device("vulkan")
except klieg.Error as error:
    print(error, len(result.lights))
"""


def test_without_vulkan_the_cpu_does_all(elephant: Path, tmp_path: Path) -> None:
    linked = subprocess.run(["ldd", klieg._klieg.__file__], check=True, text=True, capture_output=True).stdout
    assert "libvulkan" not in linked
    none = dict.fromkeys(("VK_DRIVER_FILES", "VK_ICD_FILENAMES"), "/nonexistent")
    environment = {**os.environ, **none}
    run = subprocess.run(
        [sys.executable, "-c", WITHOUT, elephant],
        env=environment,
        cwd=tmp_path,
        check=False,
        text=True,
        capture_output=True,
    )
    assert run.returncode == 0, run.stderr
    assert "Vulkan" in run.stdout
    assert run.stdout.endswith(" 2\n")


def test_wishes_steer_the_objective_and_the_boxes() -> None:
    scene = klieg.Scene.load(Path(__file__).parents[2] / "scenes" / "pair.glb")
    view = klieg.View(scene, (32, 32))
    design = klieg.design(scene, view, device="cpu", generations=2, brightness=1.0, below=False)
    told = json.loads(design.to_json())
    assert told["intent"]["brightness"] == 1.0
    assert not told["intent"]["below"]
    assert told["objective"]["targets"]["mean_stops"] > 0.5
