"""Evaluators."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from klieg import _klieg
from klieg._device import Device, DeviceInfo, opened
from klieg._light import Light, array, natives, of_natives
from klieg._scene import Scene
from klieg._settings import EvaluatorOptions, native
from klieg._view import View

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Evaluator:
    """Measures lights in one view of one scene, many rigs at a time. Scores are `F`: lower is better.

    Threads of Python may share it; they take turns. While it works, others go on.
    """

    def __init__(
        self,
        scene: Scene,
        view: View | None = None,
        *,
        device: str | int | Device = "auto",
        **options: Unpack[EvaluatorOptions],
    ) -> None:
        """Draw the view and make its maps.

        Args:
            scene: the scene.
            view: the view; `View(scene)` where absent.
            device: a `Device`, or what `Device` takes; one that nobody has named and that fails is replaced by the CPU.
            options: see `EvaluatorOptions`.

        Raises:
            InputError: for options out of their ranges, and a view that sees nothing.
            Error: for a device that does not work.

        """
        named, device_native = opened(device)
        self.scene = scene
        self.view = View(scene) if view is None else view
        settings = native({**options, **named})
        self._native = _klieg.Evaluator(scene._native, self.view._native, settings, device_native)

    @property
    def device(self) -> DeviceInfo:
        """What computes; its index is not known."""
        name, kind, driver = self._native.device()
        return DeviceInfo(-1, name, kind, driver, (), False)

    def evaluate(
        self,
        lights: ArrayLike | Sequence[Sequence[Light]],
        *,
        kind: str = "point",
        roles: Sequence[str] | None = None,
    ) -> NDArray[np.float32]:
        """Return the score of each of N rigs, shape [N].

        Args:
            lights: shape [N, L, C]: L lights of the first C of `LIGHT_COLUMNS`, 5, 6 or 9; or N lists of `Light`.
            kind: kind of the lights of an array.
            roles: their roles, L of them; the first a key and all others fills where absent.

        Raises:
            InputError: for a shape or a value out of its range.

        """
        rigs = _rigs(lights)
        if rigs is not None:
            return self._native.evaluate_rigs([natives(rig) for rig in rigs])
        return self._native.evaluate(array(lights, 3, "lights"), kind, roles)  # type: ignore[arg-type]

    def terms(
        self, lights: ArrayLike, *, kind: str = "point", roles: Sequence[str] | None = None
    ) -> dict[str, NDArray[np.float32]]:
        """Return the terms of each of N rigs by name, each of shape [N] and 0..1: lower is better.

        The arguments are those of `evaluate`, as an array.
        """
        return dict(self._native.terms(array(lights, 3, "lights"), kind, roles))

    def inspect(self, rig: Sequence[Light]) -> tuple[float, dict[str, float], NDArray[np.float32]]:
        """Return the score of a rig, its terms, and the picture that was judged.

        The picture is sRGB-encoded luminance of 0..1, shape [rows, columns], 0 in the background.
        """
        score, terms, picture = self._native.inspect(natives(rig))
        return score, dict(terms), picture

    def picture(self, rig: Sequence[Light]) -> NDArray[np.uint8]:
        """Return the final picture of a rig, sRGB with alpha, `uint8[rows, columns, 4]`."""
        return self._native.picture(natives(rig))

    def maps(self) -> dict[str, NDArray[Any]]:
        """Return every map of the view; all are of the shape [rows, columns] or [rows, columns, 3].

        `code`: number of the visible triangle, 0 in the background, `uint32`. `types`: 0 background, 1 surface, 2 edge,
        `uint8`. All others are `float32`: `depth` (scene radii along the view axis), `position` (light frame, scene
        radii), `normal` and `face` (unit vectors of the shading and of the triangle: right, up, to the viewer),
        `base_color` and `emissive` (linear RGB), `metallic`, `roughness`, `sobel` and `laplace` (of the depth),
        `normal_gradient`.
        """
        return self._native.maps()

    def clusters(self, count: int = 2) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Return clusters of the visible triangles' normals.

        Returns:
            The cluster of each pixel from 1 on, 0 in the background, shape [rows, columns]; and the clusters' mean
            directions, unit vectors in the light frame, shape [count, 3].

        """
        labels, directions = self._native.clusters(count)
        return labels, np.asarray(directions, dtype=np.float32)

    @property
    def genes(self) -> list[str]:
        """Names of the D values that a search changes, such as `key 0 azimuth`: angles in radians.

        Options `lights`, `kind` and `intensities` decide them. In some profiles values of fills and rims are told
        relative to the key's.
        """
        return [f"{role} {number} {name}" for role, number, name in self._native.genes()]

    @property
    def bounds(self) -> NDArray[np.float32]:
        """Lowest and highest value of each gene, shape [D, 2]."""
        return np.asarray(self._native.bounds(), dtype=np.float32)

    def evaluate_genes(self, genes: ArrayLike) -> NDArray[np.float32]:
        """Return the score of each of N rigs that are told by their genes, shape [N, D]."""
        return self._native.evaluate_genes(array(genes, 2, "genes"))

    def lights(self, genes: ArrayLike) -> list[Light]:
        """Return the rig of genes, shape [D]."""
        return of_natives(self._native.decode(array(genes, 1, "genes")))

    def start(self) -> NDArray[np.float32]:
        """Return the genes of the rig that a search would begin with, shape [D]."""
        return self._native.start()

    def __repr__(self) -> str:
        """Tell view and device."""
        return f"Evaluator({self.scene!r}, {self.view!r}, {self.device.name!r})"


def _rigs(lights: Any) -> Sequence[Sequence[Light]] | None:
    """Return the rigs where they are lists of `Light`."""
    rigs = isinstance(lights, Sequence) and len(lights) > 0
    light = rigs and isinstance(lights[0], Sequence) and len(lights[0]) > 0 and isinstance(lights[0][0], Light)
    return lights if light else None
