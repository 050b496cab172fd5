"""Lights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from klieg import _klieg
from klieg._errors import InputError

LIGHT_COLUMNS = ("elevation_deg", "azimuth_deg", "distance", "diffuse", "specular", "size", "red", "green", "blue")
"""The last axis of arrays of lights: the first five, six or all nine of these, with the units of `Light`."""


class Light:
    """A light in the light frame: the camera's axes at the scene's centre, lengths in scene radii.

    Lights of results also know where they stand in the world.
    """

    __slots__ = ("_native",)

    def __init__(
        self,
        elevation_deg: float,
        azimuth_deg: float,
        distance: float = 3.0,
        diffuse: float = 1.0,
        specular: float | None = None,
        *,
        role: str = "key",
        kind: str = "point",
        color: str = "#ffffff",
        size: float = 0.0,
        cone_deg: tuple[float, float] = (0.0, 45.0),
    ) -> None:
        """Make a light.

        Args:
            elevation_deg: elevation above the camera's horizontal plane, degrees.
            azimuth_deg: 0 from the viewer, positive to the viewer's right, degrees.
            distance: from the scene's centre, scene radii; directional lights have none and ignore it.
            diffuse: diffuse intensity: 1 shows a white matt surface at the centre that faces it as white.
            specular: specular intensity; the diffuse one where absent.
            role: `key`, `fill` or `rim`.
            kind: `point`, `directional` or `spot`.
            color: a temperature, `5600K`, or an sRGB colour, `#ffddaa`, whose brightness does not count.
            size: radius of the light itself, scene radii; 0 for hard shadows.
            cone_deg: inner and outer half angle of a spot's cone, degrees.

        Raises:
            InputError: for a value out of its range.

        """
        second = diffuse if specular is None else specular
        self._native = _klieg.Light(
            elevation_deg, azimuth_deg, distance, diffuse, second, size, color, kind, role, cone_deg
        )

    @classmethod
    def _of(cls, native: _klieg.Light) -> Light:
        light = cls.__new__(cls)
        light._native = native
        return light

    @property
    def role(self) -> str:
        """`key`, `fill`, `rim`, or `scene` for a light of the scene that was kept."""
        return self._native.role

    @property
    def kind(self) -> str:
        """`point`, `directional` or `spot`."""
        return self._native.kind

    @property
    def color(self) -> str:
        """A temperature, `5600K`, or the nearest sRGB colour, `#ffddaa`."""
        return self._native.color

    @property
    def color_rgb(self) -> tuple[float, float, float]:
        """The colour in linear RGB of luminance 1."""
        return self._native.color_rgb

    @property
    def elevation_deg(self) -> float:
        """Elevation above the camera's horizontal plane, degrees."""
        return self._native.elevation_deg

    @property
    def azimuth_deg(self) -> float:
        """Azimuth, degrees: 0 from the viewer, positive to the viewer's right."""
        return self._native.azimuth_deg

    @property
    def distance(self) -> float | None:
        """Distance from the scene's centre, scene radii; none of directional lights."""
        return self._native.distance

    @property
    def diffuse(self) -> float:
        """Diffuse intensity."""
        return self._native.diffuse

    @property
    def specular(self) -> float:
        """Specular intensity."""
        return self._native.specular

    @property
    def size(self) -> float:
        """Radius of the light itself, scene radii."""
        return self._native.size

    @property
    def cone_deg(self) -> tuple[float, float] | None:
        """Inner and outer half angle of a spot's cone, degrees; none of other lights."""
        return self._native.cone_deg

    @property
    def position(self) -> NDArray[np.float64] | None:
        """Position in the world, shape [3]; none of directional lights, and of lights of no result."""
        return _vector(self._native.position)

    @property
    def axis(self) -> NDArray[np.float64] | None:
        """Unit vector of a directional light or a spot in the world, away from the light, shape [3]."""
        return _vector(self._native.axis)

    @property
    def intensity(self) -> float | None:
        """Physical intensity as glTF has it: candela, of directional lights lux; none of lights of no result."""
        return self._native.intensity

    def to_dict(self) -> dict[str, Any]:
        """Return all values by their names, for `json` and tables."""
        names = [*LIGHT_COLUMNS[:6], "role", "kind", "color", "color_rgb", "cone_deg", "position", "axis", "intensity"]
        return {name: getattr(self._native, name) for name in names}

    def __eq__(self, other: object) -> bool:
        """Tell whether all values are the same."""
        return isinstance(other, Light) and self._native == other._native

    def __hash__(self) -> int:
        """Hash the place."""
        return hash((self.role, self.elevation_deg, self.azimuth_deg))

    def __repr__(self) -> str:
        """Tell role and place."""
        place = "" if self.distance is None else f", distance={self.distance:.3g}"
        return (
            f"Light({self.elevation_deg:.1f}, {self.azimuth_deg:.1f}{place}, diffuse={self.diffuse:.3g}, "
            f"role={self.role!r}, kind={self.kind!r})"
        )


def _vector(values: Sequence[float] | None) -> NDArray[np.float64] | None:
    return None if values is None else np.asarray(values)


def natives(rig: Sequence[Light]) -> list[_klieg.Light]:
    """Return the native lights of a rig."""
    return [light._native for light in rig]


def of_natives(rig: Sequence[_klieg.Light]) -> list[Light]:
    """Return the lights of native ones."""
    return [Light._of(light) for light in rig]


def array(values: ArrayLike, axes: int, what: str) -> NDArray[np.float32]:
    """Return values as a contiguous array of single precision, without a copy where it is one.

    Raises:
        InputError: for another number of axes, or values that are no numbers.

    """
    try:
        found = np.ascontiguousarray(values, dtype=np.float32)
    except (TypeError, ValueError) as fault:
        raise InputError(f"{what}: {fault}") from fault
    if found.ndim != axes:
        raise InputError(f"{what} have {found.ndim} axes: they must have {axes}")
    return found
