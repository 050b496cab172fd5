"""Designs of many models on a cluster of Ray.

>>> import klieg.ray
>>> import ray
>>> files = ray.data.read_binary_files("s3://models", include_paths=True)
>>> lit = files.map_batches(klieg.ray.Designer, batch_size=1, num_gpus=1, concurrency=4)
>>> lit.write_parquet("s3://lit")
"""

from __future__ import annotations

import json
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from klieg._design import Design, design
from klieg._device import Device
from klieg._errors import Error
from klieg._scene import Scene
from klieg._settings import DesignOptions, native
from klieg._view import View

if TYPE_CHECKING:
    from typing_extensions import Unpack

NONE: dict[str, Any] = {"score": float("nan"), "stopped": False, "lights": "", "png": b"", "glb": b""}
"""The columns of an item that failed, beside its error."""


class Designer:
    """Designs every model of a batch; an actor keeps its device open, with the compiled pipelines.

    A batch has the columns `path` and `bytes`, as `ray.data.read_binary_files(..., include_paths=True)` gives them.
    Rows come out with `path`, `score`, `stopped` (whether the time limit ended the search), `lights` (JSON, as in
    `result.json`), `png` (the final picture), `glb` (the lit scene) and `error`: empty, or what is wrong with the item,
    whose other columns are then empty. One bad item does not end a job.
    """

    def __init__(
        self,
        device: str | int = "auto",
        *,
        size: tuple[int, int] = (512, 512),
        **options: Unpack[DesignOptions],
    ) -> None:
        """Open the device.

        Args:
            device: what `klieg.Device` takes.
            size: width and height of the pictures, pixels.
            options: as for `klieg.design`; `time_limit` is that of each search.

        Raises:
            InputError: for an option that there is not, or a value that it cannot have.
            Error: for a device that does not work.

        """
        native(options)
        self._device = Device(device)
        self._size, self._options = size, options

    def __call__(self, batch: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Return the rows of a batch."""
        rows = [self.row(str(path), bytes(data)) for path, data in zip(batch["path"], batch["bytes"], strict=True)]
        columns = {name: np.array([row[name] for row in rows], dtype=object) for name in ("path", "lights", "error")}
        columns["score"] = np.array([row["score"] for row in rows], dtype=np.float32)
        columns["stopped"] = np.array([row["stopped"] for row in rows], dtype=bool)
        return columns | {name: np.array([row[name] for row in rows], dtype=object) for name in ("png", "glb")}

    def row(self, path: str, data: bytes) -> dict[str, Any]:
        """Return the row of one model."""
        try:
            return {"path": path, "error": "", **self._columns(self._design(path, data))}
        except Error as fault:
            return {"path": path, "error": str(fault), **NONE}
        except BaseException as fault:
            # What PyO3 makes of a panic in Rust is no `Exception`; all others of these end the worker.
            if type(fault).__name__ != "PanicException":
                raise
            return {"path": path, "error": f"a fault of klieg's own: {fault}", **NONE}

    def _design(self, path: str, data: bytes) -> Design:
        kind = PurePath(path).suffix.removeprefix(".").lower() or "glb"
        scene = Scene.from_bytes(data, kind)
        return design(scene, View(scene, self._size), device=self._device, **self._options)

    def _columns(self, result: Design) -> dict[str, Any]:
        lights = json.dumps(json.loads(result.to_json())["lights"])
        png, glb = result.to_png(), result.to_glb()
        return {"score": result.score, "stopped": result.stopped, "lights": lights, "png": png, "glb": glb}
