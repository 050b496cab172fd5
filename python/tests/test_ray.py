from __future__ import annotations

import io
import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import trimesh
from PIL import Image

import klieg.ray

ray = pytest.importorskip("ray", reason="ray is not installed: make test-ray does it")

pytestmark = pytest.mark.filterwarnings("default")

SMALL: dict[str, Any] = {
    "size": (48, 48),
    "generations": 3,
    "population": 6,
    "coarse": 0,
    "shadows": False,
    "samples": 4,
}


@pytest.fixture(scope="module")
def cluster() -> Iterator[None]:
    # Two for the actors, and one for what reads files; workers import this file too.
    environment = {"env_vars": {"PYTHONPATH": str(Path(__file__).parent)}}
    ray.init(num_cpus=3, runtime_env=environment, include_dashboard=False, log_to_driver=False, logging_level="error")
    yield
    ray.shutdown()


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sixty models, and four files that are none."""
    folder = tmp_path_factory.mktemp("models")
    for number in range(60):
        mesh = trimesh.creation.torus(1.0, 0.2 + 0.01 * number, major_sections=16, minor_sections=8)
        kind = ("glb", "ply", "stl")[number % 3]
        data = mesh.export(file_type=kind)
        (folder / f"model-{number:02}.{kind}").write_bytes(data)
    for number in range(4):
        (folder / f"broken-{number}.glb").write_bytes(b"glTF" + bytes(number))
    return folder


def test_every_model_has_a_row_and_broken_ones_an_error(cluster: None, models: Path) -> None:
    files = ray.data.read_binary_files(str(models), include_paths=True)
    lit = files.map_batches(
        klieg.ray.Designer, fn_constructor_args=("cpu",), fn_constructor_kwargs=SMALL, batch_size=4, concurrency=2
    )
    rows = {Path(row["path"]).name: row for row in lit.take_all()}
    assert len(rows) == 64
    broken = {name for name, row in rows.items() if row["error"]}
    assert broken == {f"broken-{number}.glb" for number in range(4)}
    good = rows["model-07.ply"]
    assert 0 < good["score"] < 1
    assert [light["role"] for light in json.loads(good["lights"])] == ["key", "fill"]
    assert Image.open(io.BytesIO(good["png"])).size == (48, 48)
    assert klieg.Scene.from_bytes(good["glb"]).polygons == 256


class Fragile(klieg.ray.Designer):
    """Its process is killed in the middle of a batch, once."""

    def __init__(self, grave: Path, **options: Any) -> None:
        super().__init__("cpu", **options)
        self.grave = grave

    def row(self, path: str, data: bytes) -> dict[str, Any]:
        if Path(path).stem == "model-30" and not self.grave.exists():
            self.grave.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().row(path, data)


def test_a_killed_worker_loses_nothing(cluster: None, models: Path, tmp_path: Path) -> None:
    files = ray.data.read_binary_files(str(models), include_paths=True)
    arguments = {"grave": tmp_path / "killed", **SMALL}
    lit = files.map_batches(Fragile, fn_constructor_kwargs=arguments, batch_size=4, concurrency=2)
    rows = lit.take_all()
    assert (tmp_path / "killed").exists()
    assert len({row["path"] for row in rows}) == len(rows) == 64
    assert sum(row["error"] == "" for row in rows) == 60
