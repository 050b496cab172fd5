"""Options of Python as the tables of a configuration file: `docs/CONFIGURATION.md` is their reference."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from klieg import _klieg
from klieg._errors import InputError

if TYPE_CHECKING:
    from typing_extensions import Self


class LoadOptions(TypedDict, total=False):
    """How files are read."""

    units: float
    """Metres of a unit in PLY, STL and OBJ files; 1, of STL 0.001, where absent."""
    up: Literal["y", "z"]
    """The axis that points upwards in them; y, of STL z, where absent."""
    allow_outside: bool
    """Whether the file may name others outside its folder."""
    allow_large: bool
    """Whether it may take much more memory and time than files of its size do."""
    animation: str | int
    """Name or index of the animation that is shown; the first where absent."""
    time: float
    """The moment of it, seconds."""
    rest: bool
    """Whether no animation moves anything."""


class EvaluatorOptions(TypedDict, total=False):
    """How pictures are made and judged, and which lights are searched."""

    profile: str
    """What all others start from: a name of `klieg.profiles()`."""
    config: str | PathLike[str]
    """A TOML file of settings; options of Python stand in the place of what it says."""
    settings: Mapping[str, Any]
    """Tables as in such a file, for whatever has no option of its own."""
    objective: Objective
    """What pictures are judged by; the profile's where absent."""
    weights: Mapping[str, float]
    """Weights of terms by name; all others stay as they are."""
    brdf: Literal["blinn-phong", "gltf", "gltf-scattering"]
    """How surfaces reflect."""
    shadows: bool
    """Whether lights cast shadows."""
    background: str
    """Behind the objects of final pictures: an sRGB colour such as `#3a3c42`, which then counts, or `transparent`."""
    tone_mapping: Literal["none", "neutral"]
    """From radiance to colours in final pictures."""
    samples: int
    """Samples of a pixel of final pictures, a square number up to 64."""
    lights: int | str | Sequence[str]
    """The lights that are searched: how many, or their roles."""
    kind: Literal["point", "directional", "spot"]
    """Their kind."""
    intensities: Literal["one", "two"]
    """One intensity of each light, as lamps have, or a diffuse and a specular one."""
    color: str | Mapping[str, str]
    """Colour of the lights, `5600K` or `#ffddaa`, or one for each role."""
    keep_lights: bool
    """Whether the scene's own lights stay and count."""
    pipeline: Literal["auto", "layered", "forward", "compute"]
    """How a Vulkan device makes the pictures."""
    memory: int
    """Memory of a Vulkan device for the pictures of a population, MiB."""
    seed: int
    """Seed of every random choice, 0 or more."""


class DesignOptions(EvaluatorOptions, total=False):
    """How lights are searched."""

    population: int
    """Individuals of a generation."""
    generations: int
    """Generations; a search may end before."""
    time_limit: float
    """Seconds after which the search ends with its best."""
    optimizer: str
    """How the lights are searched: a name of `klieg.optimizers()`."""
    coarse: int
    """Longest side of the small pictures that the search begins with; 0 for none."""
    first: Literal["k-means", "random", "scene", "headlight", "light-kit", "three-point"]
    """Where the search begins."""
    brightness: float
    """Steps darker or brighter than usual, -2 to 2."""
    contrast: float
    """Steps of less or more contrast than usual, -2 to 2."""
    mood: Literal["soft", "natural", "dramatic"]
    """The character of the light."""
    below: bool
    """Whether lights may stand below the horizon of the scene's centre."""
    hold: Sequence[str]
    """Lights of the rig that `first` names that stay as they are, or one value of theirs: `key`, `fill.azimuth`."""
    one_by_one: bool
    """Whether lights are added one after another, each the best addition to those before it."""


PLACES: dict[str, tuple[str, ...]] = {
    "units": ("units",),
    "up": ("up",),
    "allow_outside": ("allow_outside",),
    "allow_large": ("allow_large",),
    "time": ("pose", "time"),
    "rest": ("pose", "rest"),
    "brdf": ("shading", "brdf"),
    "shadows": ("shadows", "on"),
    "background": ("picture", "background"),
    "tone_mapping": ("picture", "tone_mapping"),
    "samples": ("picture", "samples"),
    "kind": ("lights", "kind"),
    "keep_lights": ("lights", "keep"),
    "pipeline": ("pipeline",),
    "memory": ("memory",),
    "population": ("search", "population"),
    "generations": ("search", "generations"),
    "time_limit": ("time_limit",),
    "optimizer": ("optimizer",),
    "coarse": ("coarse", "side"),
    "first": ("first",),
    "brightness": ("intent", "brightness"),
    "contrast": ("intent", "contrast"),
    "mood": ("intent", "mood"),
    "below": ("intent", "below"),
    "hold": ("lights", "hold"),
    "one_by_one": ("lights", "one_by_one"),
    "camera": ("view", "camera"),
    "azimuth": ("view", "azimuth"),
    "elevation": ("view", "elevation"),
    "fov": ("view", "fov"),
    "fill": ("view", "fill"),
    "device": ("device",),
}
"""Where options stand in a configuration file, of those whose values are the same there."""


@dataclass
class Objective:
    """What pictures are judged by: the sum of the terms, each times its weight; lower is better.

    `Objective.of("natural")` is a profile's; `klieg.terms()` tells which terms there are.
    """

    weights: dict[str, float]
    """Weight of each term by its name, 0 or more."""
    mean_target: float | Literal["scene"] = "scene"
    """Mean brightness aimed at, sRGB-encoded 0..1, or `scene` for that which suits the scene's colours."""
    mean_stops: float = 0.0
    """Photographic stops by which that is moved, -4 to 4."""
    spread_target: float = 0.2
    """Standard deviation of the brightness that the term `spread` aims at, encoded, 0 to 0.5."""
    example: dict[str, Any] | None = None
    """What the term `example` aims at: `histogram`, 32 shares, and `gradient`."""
    edge_contrast: float = 0.06
    """Gradient of the picture at which an edge counts as fully distinct, encoded units a pixel."""
    edge_sobel: float = field(default=0.02)
    """Sobel length of the depth above which a pixel can be an edge, scene radii a pixel."""
    edge_laplace: float = field(default=0.02)
    """Absolute Laplacian of the depth above which a pixel can be an edge, scene radii."""

    @classmethod
    def of(cls, profile: str) -> Self:
        """Return the objective of a profile.

        Raises:
            InputError: for a name that is none of a profile.

        """
        return cls(**json.loads(native({"profile": profile}).json())["objective"])


def profiles() -> dict[str, str]:
    """Return the meaning of each profile by its name."""
    return dict(_klieg.profiles())


def terms() -> dict[str, str]:
    """Return what each term says of a picture, by its name."""
    return dict(_klieg.terms())


def optimizers() -> dict[str, str]:
    """Return what each optimiser does, by its name."""
    return dict(_klieg.optimizers())


def native(options: Mapping[str, Any]) -> _klieg.Settings:
    """Return the settings that the given options ask for; an option that is `None` is one that was not given.

    Raises:
        InputError: for an option that there is not, or a value that it cannot have.

    """
    given = {name: value for name, value in options.items() if value is not None}
    tables: dict[str, Any] = json.loads(json.dumps(dict(given.pop("settings", {}))))
    color = given.pop("color", {})
    seed = given.pop("seed", None)
    one = given.pop("intensities", None)
    if one not in {None, "one", "two"}:
        raise InputError(f"intensities is {one!r}: it must be 'one' or 'two'")
    if seed is not None and not 0 <= seed < 1 << 64:
        raise InputError(f"seed is {seed}: it must be 0 or more, and less than 2**64")
    rest: dict[str, Any] = {name: given.pop(name, None) for name in ("config", "profile", "weights")}
    for path, value in _places(given):
        _put(tables, path, value)
    return _klieg.Settings(
        json.dumps(tables),
        rest["config"],
        rest["profile"],
        seed,
        list((rest["weights"] or {}).items()),
        None if one is None else one == "one",
        [(None, color)] if isinstance(color, str) else list(color.items()),
    )


def _places(options: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Tell where options stand in a configuration file, and their values there."""
    for name, value in options.items():
        match name, value:
            case "lights", str() if not value.isdigit():
                yield ("lights", "roles"), [role.strip() for role in value.split(",")]
            case "lights", str() | int():
                yield ("lights", "roles"), int(value)
            case "lights", _:
                yield ("lights", "roles"), list(value)
            case "size", (width, height):
                yield ("view", "size"), f"{width}x{height}"
            case "animation", _:
                yield ("pose", "animation"), str(value)
            case "objective", Objective():
                yield ("objective",), {name: part for name, part in asdict(value).items() if part is not None}
            case _ if name in PLACES:
                yield PLACES[name], value
            case _:
                known = ", ".join(sorted({*PLACES, *DesignOptions.__annotations__, *LoadOptions.__annotations__}))
                raise InputError(f"there is no option {name!r} with such a value: the options are {known}")


def _put(tables: dict[str, Any], path: tuple[str, ...], value: object) -> None:
    for name in path[:-1]:
        tables = tables.setdefault(name, {})
    tables[path[-1]] = value
