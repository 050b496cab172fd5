"""Designs."""

from __future__ import annotations

import base64
import html
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from klieg import _klieg
from klieg._device import Device, opened
from klieg._light import Light, of_natives
from klieg._scene import Scene
from klieg._settings import DesignOptions, native
from klieg._view import View

if TYPE_CHECKING:
    from typing_extensions import Unpack

Progress = _klieg.Progress

HISTORY = np.dtype(
    [("generation", "u4"), ("evaluations", "u4"), ("best", "f4"), ("mean", "f4"), ("worst", "f4"), ("step", "u4")]
)
"""A row of `Design.history`."""

SHOWN = 512
"""Most pixels of a side of pictures in notebooks."""


class Design:
    """What a search found."""

    def __init__(self, native: _klieg.Design, scene: Scene, view: View) -> None:
        """Wrap a native design: take `klieg.design`."""
        self._native = native
        self.scene = scene
        self.view = view

    @property
    def lights(self) -> list[Light]:
        """The best rig, with the lights of the scene that were kept."""
        return of_natives(self._native.lights)

    @property
    def score(self) -> float:
        """Its score `F`; lower is better."""
        return self._native.quality[0]

    @property
    def terms(self) -> dict[str, float]:
        """Its terms, 0..1 each; lower is better."""
        return dict(self._native.quality[1])

    @property
    def headlight_score(self) -> float:
        """The score of one light from the viewer, for comparison."""
        return self._native.headlight[0]

    @property
    def history(self) -> NDArray[Any]:
        """The course of the search, a row for each generation.

        Its fields are `generation`, `evaluations` so far, `best` score so far, `mean` and `worst` score of the
        generation, and `step`: the scores are of pictures of every `step`-th pixel along both sides, 1 for whole ones,
        and those of one size are not compared with those of another.
        """
        return np.array(self._native.history(), dtype=HISTORY)

    @property
    def stopped(self) -> bool:
        """Whether the search was ended before its time: by Ctrl-C, its time limit or the `progress` callback."""
        return self._native.stopped

    def picture(self, *, size: tuple[int, int] | None = None, samples: int | None = None) -> NDArray[np.uint8]:
        """Return the final picture, sRGB with straight alpha, `uint8[rows, columns, 4]`.

        Args:
            size: width and height, pixels; the view's where absent.
            samples: samples of a pixel, a square number up to 64; 16 where absent.

        """
        return self._native.picture(False, size, samples)

    def headlight(self, *, size: tuple[int, int] | None = None, samples: int | None = None) -> NDArray[np.uint8]:
        """Return the picture under one light from the viewer, as `picture`."""
        return self._native.picture(True, size, samples)

    def to_png(self, *, size: tuple[int, int] | None = None, samples: int | None = None) -> bytes:
        """Return the final picture as a PNG file."""
        return self._native.png(False, size, samples)

    def to_json(self) -> str:
        """Return what `result.json` of `klieg design` says: `docs/RESULT.md` is its reference."""
        return self._native.json()

    def to_glb(self) -> bytes:
        """Return the lit scene as a GLB file: the scene with the lights and the camera of the view.

        Raises:
            InputError: for a scene that was made of arrays.

        """
        return self._native.glb()

    def save_gltf(self, path: str | PathLike[str]) -> None:
        """Write the lit scene as a GLB file, whole or not at all.

        Raises:
            InputError: for a scene that was made of arrays.
            Error: for a file that cannot be written.

        """
        self._native.save_gltf(path)

    def save(self, folder: str | PathLike[str]) -> list[Path]:
        """Write all files that `klieg design` writes, the report among them, into a folder; return their paths.

        Raises:
            InputError: for a scene that was made of arrays, and files that would replace it.
            Error: for files that cannot be written.

        """
        return self._native.save(folder)

    def _repr_png_(self) -> bytes:
        return self._native.png(False, self._shown(), 4)

    def _repr_html_(self) -> str:
        """Show the scene under a headlight and under the lights that were found."""
        size = self._shown()
        figures = [
            (True, f"Headlight, F {self.headlight_score:.4f}"),
            (False, f"Designed, F {self.score:.4f}"),
        ]
        cells = "".join(
            f'<figure style="margin:0 8px 0 0"><img width="{size[0]}" height="{size[1]}" alt="{html.escape(text)}" '
            f'style="max-width:100%;height:auto" src="data:image/png;base64,'
            f'{base64.b64encode(self._native.png(headlight, size, 4)).decode()}">'
            f"<figcaption>{html.escape(text)}</figcaption></figure>"
            for headlight, text in figures
        )
        return f'<div style="display:flex;flex-wrap:wrap">{cells}</div>'

    def _shown(self) -> tuple[int, int]:
        """Size of the picture in notebooks."""
        width, height = self.view.size
        scale = min(1.0, SHOWN / max(width, height))
        return max(1, round(width * scale)), max(1, round(height * scale))

    def __repr__(self) -> str:
        """Tell lights and scores."""
        ended = ", stopped" if self.stopped else ""
        return f"Design({len(self.lights)} lights, F {self.score:.4f}, headlight {self.headlight_score:.4f}{ended})"


def design(
    scene: Scene | str | PathLike[str],
    view: View | None = None,
    *,
    device: str | int | Device = "auto",
    progress: Callable[[Progress], object] | bool | None = None,
    **options: Unpack[DesignOptions],
) -> Design:
    """Search the lights that make a scene easiest to see.

    With the same options, seed and device the result has the bits of that of `klieg design`. Ctrl-C ends the search
    with the best so far, which is then returned with `stopped`.

    Args:
        scene: a scene, or the file of one.
        view: the view; `View(scene)` where absent.
        device: a `Device`, or what `Device` takes; one that nobody has named and that fails is replaced by the CPU.
        progress: called after every generation, whose search it ends where it returns something false other than
            `None`; or `True` for a bar, which needs tqdm.
        options: see `DesignOptions`.

    Raises:
        InputError: for a file or an option that cannot be used.
        Error: for a device that does not work.

    """
    seen = scene if isinstance(scene, Scene) else Scene.load(scene)
    looked = View(seen) if view is None else view
    named, device_native = opened(device)
    settings = native({**options, **named})
    if progress is True:
        with _Bar() as bar:
            found = _klieg.design(seen._native, looked._native, settings, device_native, bar.show)
    else:
        told = progress if callable(progress) else None
        found = _klieg.design(seen._native, looked._native, settings, device_native, told)
    return Design(found, seen, looked)


class _Bar:
    """A progress bar of tqdm."""

    def __init__(self) -> None:
        from tqdm.auto import tqdm  # noqa: PLC0415 - an extra

        self._bar = tqdm(unit=" generations")

    def show(self, progress: Progress) -> None:
        self._bar.total = progress.generations
        self._bar.set_postfix_str(f"F {progress.best:.4f}", refresh=False)
        self._bar.update(progress.generation - self._bar.n)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()
