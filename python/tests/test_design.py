from __future__ import annotations

import io
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import QUICK
from PIL import Image

import klieg
from klieg._settings import DesignOptions

Program = Callable[..., subprocess.CompletedProcess[str]]


def without_times(text: str) -> dict[str, Any]:
    result: dict[str, Any] = json.loads(text)
    del result["timing_ms"]
    return result


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
@pytest.mark.parametrize("profile", ["natural", "paper"])
def test_results_have_the_bits_of_the_program(
    *, program: Program, elephant: Path, tmp_path: Path, device: str, profile: str
) -> None:
    options = ["--generations", "5", "--population", "8", "--seed", "7", "--lights", "key,rim", "--color", "rim=3200K"]
    size = ["--size", "80x64", "--coarse", "32", "--device", device, "--profile", profile]
    program("design", elephant, "--out", tmp_path, *options, *size)
    scene = klieg.Scene.load(elephant)
    result = klieg.design(
        scene,
        klieg.View(scene, (80, 64)),
        device=device,
        profile=profile,
        generations=5,
        population=8,
        seed=7,
        lights=["key", "rim"],
        color={"rim": "3200K"},
        coarse=32,
    )
    assert without_times(result.to_json()) == without_times((tmp_path / "result.json").read_text())
    assert result.to_glb() == (tmp_path / "lit.glb").read_bytes()
    assert result.to_png() == (tmp_path / "best.png").read_bytes()
    rows = np.genfromtxt(tmp_path / "convergence.csv", delimiter=",", names=True)
    assert np.array_equal(result.history["evaluations"], rows["evaluations"])
    assert np.array_equal(result.history["best"], rows["best"].astype(np.float32))


def test_a_result_tells_what_was_found(pair: klieg.Scene, view: klieg.View) -> None:
    result = klieg.design(pair, view, device="cpu", **(QUICK | {"lights": 3}))
    assert [light.role for light in result.lights] == ["key", "fill", "rim"]
    assert result.score < result.headlight_score
    assert set(result.terms) >= {"mean", "unlit"}
    assert result.history["best"][-1] == np.float32(result.score)
    assert not result.stopped
    key = result.lights[0]
    assert key.position is not None
    assert key.distance is not None
    reach = np.linalg.norm(key.position - view.center) / view.radius
    assert reach == pytest.approx(key.distance, rel=1e-5)
    assert key.intensity == pytest.approx(np.pi * key.diffuse * (reach * view.radius) ** 2, rel=1e-5)
    assert "3 lights" in repr(result)
    assert key.to_dict()["role"] == "key"


def test_pictures_before_and_after(pair: klieg.Scene, view: klieg.View) -> None:
    result = klieg.design(pair, view, device="cpu", **QUICK)
    picture = result.picture()
    assert picture.shape == (72, 96, 4)
    assert picture.dtype == np.uint8
    assert not np.array_equal(picture, result.headlight())
    assert result.picture(size=(32, 16), samples=1).shape == (16, 32, 4)
    for png in (result._repr_png_(), result.to_png()):
        assert Image.open(io.BytesIO(png)).size == (96, 72)
    page = result._repr_html_()
    assert page.count("<img") == 2
    assert f"Designed, F {result.score:.4f}" in page


def test_lit_scenes_keep_the_view_and_the_lights(pair: klieg.Scene, view: klieg.View, tmp_path: Path) -> None:
    result = klieg.design(pair, view, device="cpu", **QUICK)
    result.save_gltf(tmp_path / "lit.glb")
    lit = klieg.Scene.load(tmp_path / "lit.glb")
    assert (lit.own_lights, lit.cameras) == (0, ["klieg camera"])
    assert klieg.View(lit).size == (96, 72)
    # Lights of somebody else.
    other = klieg.Scene.from_bytes(result.to_glb().replace(b"klieg", b"other"))
    assert other.own_lights == 2
    kept: DesignOptions = {"keep_lights": True, "lights": 1}
    again = klieg.design(other, view, device="cpu", **(QUICK | kept))
    assert [light.role for light in again.lights] == ["key", "scene", "scene"]
    names = {path.name for path in result.save(tmp_path / "out")}
    assert names >= {"best.png", "report.html", "result.json", "lit.glb"}


def test_progress_is_told_and_ends_a_search(pair: klieg.Scene, view: klieg.View) -> None:
    heard: list[klieg.Progress] = []
    klieg.design(pair, view, device="cpu", **QUICK, progress=heard.append)
    assert [progress.generation for progress in heard] == list(range(1, 7))
    assert heard[0].generations == 6
    assert heard[-1].evaluations == 48
    stopped = klieg.design(pair, view, device="cpu", **QUICK, progress=lambda progress: progress.generation < 3)
    assert stopped.stopped
    assert len(stopped.history) == 3

    def broken(_: klieg.Progress) -> None:
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        klieg.design(pair, view, device="cpu", **QUICK, progress=broken)


def test_a_bar_of_tqdm(pair: klieg.Scene, view: klieg.View, capsys: pytest.CaptureFixture[str]) -> None:
    klieg.design(pair, view, device="cpu", **QUICK, progress=True)
    assert "6/6" in capsys.readouterr().err


# A shell that starts programs in the background has them ignore Ctrl-C.
ENDLESS = """
import klieg, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = klieg.Scene.load(sys.argv[1])
told = lambda progress: print(progress.generation, flush=True)
result = klieg.design(scene, klieg.View(scene, (64, 64)), device="cpu", generations=10**6, coarse=0, progress=told)
print("best", result.score, result.stopped, flush=True)
"""


def test_ctrl_c_ends_a_search_with_the_best_so_far(elephant: Path, tmp_path: Path) -> None:
    child = subprocess.Popen([sys.executable, "-c", ENDLESS, elephant], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "1\n"
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert child.returncode == 0
    best, score, stopped = out.splitlines()[-1].split()
    assert (best, stopped) == ("best", "True")
    assert float(score) > 0


def test_a_time_limit_ends_a_search(pair: klieg.Scene, view: klieg.View) -> None:
    begin = time.monotonic()
    result = klieg.design(pair, view, device="cpu", generations=10**6, coarse=0, time_limit=0.3)
    assert time.monotonic() - begin < 20
    assert result.stopped


def test_other_threads_go_on(pair: klieg.Scene, view: klieg.View) -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.wait(0.005):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    klieg.design(pair, view, device="cpu", generations=10**6, coarse=0, time_limit=0.5)
    done.set()
    thread.join()
    assert counted > 10


def test_a_device_stays_open_for_many_designs(pair: klieg.Scene, view: klieg.View) -> None:
    device = klieg.Device("vulkan")
    assert device.type in repr(device)
    found = {klieg.design(pair, view, device=device, **QUICK).score for _ in range(3)}
    assert found == {klieg.design(pair, view, device="vulkan", **QUICK).score}
