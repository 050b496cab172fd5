"""What the peers begin with: the maps that `klieg analyze` writes, the constants of the objective, and rigs."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

SURFACE, EDGE = 1, 2
BINS = 32
TERMS = ("edge", "mean", "grad", "var", "hist")

# The shading model of the profile `paper`: docs/METHOD.md.
AMBIENT = 0.03
DIELECTRIC = 0.04
MAX_SHININESS = 4096.0
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)

# Lowest and highest elevation and azimuth (degrees), distance (scene radii), diffuse and specular intensity of key,
# fill and rim lights: docs/METHOD.md.
KEY = [(0.0, 90.0), (-90.0, 90.0), (1.5, 5.0), (0.0, 2.0), (0.0, 2.0)]
FILL = [(-30.0, 90.0), (-90.0, 90.0), (1.5, 5.0), (0.0, 1.0), (0.0, 1.0)]
RIM = [(-30.0, 90.0), (100.0, 260.0), (1.5, 5.0), (0.0, 1.0), (0.0, 1.0)]


class UnavailableError(Exception):
    """Why a peer cannot run on this machine."""


class Generation(Protocol):
    """What a peer has made ready for one number of lights and of individuals."""

    def scores(self, records: Floats) -> Floats:
        """Score rigs, from host to host: shape [population, lights, 6] to [population]."""

    def terms(self) -> Floats:
        """Give the terms of the rigs that were scored last, shape [population, 5]."""


class Peer(Protocol):
    """A program that scores rigs of a view."""

    name: str
    device: str

    def prepare(self, lights: int, population: int) -> Generation:
        """Compile for so many lights and individuals, and take the memory for them."""


@dataclass(frozen=True)
class Objective:
    """The numbers of the quality function."""

    weights: dict[str, float]
    mean_target: float
    edge_contrast: float


@dataclass(frozen=True)
class View:
    """A view of a scene, a pixel an entry, rows from the top; 0 in the background."""

    types: NDArray[np.uint8]  # 0 BACKGROUND, 1 SURFACE, 2 EDGE
    position: Floats  # [height, width, 3], scene radii from the scene's centre: right, up, to the viewer
    normal: Floats  # [height, width, 3], unit vectors
    to_viewer: Floats  # [height, width, 3], unit vectors
    shininess: Floats  # Blinn-Phong exponents
    diffuse: Floats  # luminances
    specular: Floats  # luminances, with the lobe's normalisation
    unlit: Floats  # luminances
    normal_detail: float  # mean gradient of the normals over SURFACE
    objective: Objective

    @property
    def surface(self) -> int:
        """Number of SURFACE pixels."""
        return int(np.count_nonzero(self.types == SURFACE))

    @property
    def edge(self) -> int:
        """Number of EDGE pixels."""
        return int(np.count_nonzero(self.types == EDGE))

    @property
    def weights(self) -> Floats:
        """Weights of the terms, in the order of `TERMS`."""
        return np.array([self.objective.weights[term] for term in TERMS], np.float32)


def load(folder: Path, objective: Objective) -> View:
    """Read the maps in the folder of `klieg analyze`.

    Raises:
        UnavailableError: where a map is missing, as older versions of klieg write fewer.

    """
    analysis = json.loads((folder / "analyze.json").read_text())
    maps = {array["file"].removesuffix(".npy"): np.load(folder / array["file"]) for array in analysis["arrays"]}
    for name in ("types", "position", "normal", "base_color", "metallic", "roughness", "emissive"):
        if name not in maps:
            raise UnavailableError(f"{folder} has no {name}.npy: analyze the scene with a newer klieg")
    objects = maps["types"] > 0
    base, metallic = maps["base_color"], maps["metallic"]
    with np.errstate(divide="ignore"):
        shininess = np.clip(2.0 / maps["roughness"] ** 4 - 2.0, 1.0, MAX_SHININESS)
    reflected = DIELECTRIC + (base - DIELECTRIC) * metallic[..., None]
    plain = {
        "shininess": shininess,
        "diffuse": (base @ LUMINANCE) * (1.0 - metallic),
        "specular": (reflected @ LUMINANCE) * (shininess + 8.0) / 8.0,
        "unlit": AMBIENT * (base @ LUMINANCE) + maps["emissive"] @ LUMINANCE,
    }
    return View(
        types=maps["types"],
        position=maps["position"],
        normal=maps["normal"],
        to_viewer=_to_viewer(analysis, maps["position"]) * objects[..., None],
        normal_detail=analysis["normal_detail"],
        objective=objective,
        **{name: np.where(objects, value, 0.0).astype(np.float32) for name, value in plain.items()},
    )


def _to_viewer(analysis: dict[str, Any], position: Floats) -> Floats:
    camera = analysis["camera"]
    if camera["type"] == "orthographic":
        return np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), position.shape)
    axes = np.array([camera["right"], camera["up"], camera["back"]])
    eye = axes @ (np.array(camera["position"]) - np.array(analysis["center"])) / analysis["radius"]
    away: Floats = eye.astype(np.float32) - position
    towards: Floats = away / np.linalg.norm(away, axis=-1, keepdims=True)
    return towards


def random_rigs(random: np.random.Generator, population: int, lights: int) -> NDArray[np.float64]:
    """Draw rigs that are uniform in their boxes: a key, then fill and rim lights by turns, as `klieg bench` does.

    Shape [population, lights, 5]: elevation and azimuth in degrees, distance, diffuse and specular intensity.
    """
    boxes = [KEY if i == 0 else FILL if i % 2 else RIM for i in range(lights)]
    low, high = np.moveaxis(np.array(boxes), -1, 0)
    return random.uniform(low, high, (population, lights, 5))


def records(rigs: NDArray[np.float64]) -> Floats:
    """Give what is read of lights: position, squared distance, diffuse and specular intensity, shape [..., 6]."""
    elevation, azimuth = np.radians(rigs[..., 0]), np.radians(rigs[..., 1])
    distance = rigs[..., 2]
    across = np.cos(elevation)
    towards = [across * np.sin(azimuth), np.sin(elevation), across * np.cos(azimuth)]
    columns = [*(axis * distance for axis in towards), distance**2, rigs[..., 3], rigs[..., 4]]
    return np.stack(columns, axis=-1).astype(np.float32)
