"""The same scores by a JAX program: `vmap` over the population, `jit` over all of it, float32."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from view import BINS, EDGE, SURFACE, TERMS, Floats, UnavailableError, View, random_rigs, records

Array: TypeAlias = "jax.Array | NDArray[Any]"
barrier: Callable[[Array], Array] = jax.lax.optimization_barrier
# Individuals that are evaluated at once: pictures that fit a CPU's cache, or enough of them for any GPU.
BATCH = {"cpu": 30, "gpu": 500}


@dataclass(frozen=True)
class Variant:
    """What is faster on one device or another."""

    histogram: Callable[[Array], Array]
    over: Callable[[Callable[[Array], Any]], Callable[[Array], Any]]  # how pictures are measured: together or in turn


def by_scatter(picture: Array) -> Array:
    """Count the pixels of each bin one by one."""
    bins = jnp.minimum((picture * BINS).astype(jnp.int32), BINS - 1)
    return jnp.zeros(BINS, jnp.int32).at[bins].add(1)


def by_comparison(picture: Array) -> Array:
    """Count the pixels from each bin on."""
    starts = jnp.arange(BINS) / BINS
    least = jnp.sum(picture[None, :] >= starts[:, None], axis=1)
    return least - jnp.append(least[1:], 0)


def in_turn(function: Callable[[Array], Any]) -> Callable[[Array], Any]:
    """Apply a function to one individual after the other."""
    return partial(jax.lax.map, function)


VARIANTS = [Variant(by_scatter, in_turn), Variant(by_scatter, jax.vmap), Variant(by_comparison, jax.vmap)]


class Surface(NamedTuple):
    """The object pixels, and where they stand in the part of the picture that shows objects."""

    position: list[Array]
    normal: list[Array]
    to_viewer: list[Array]
    lobe: Array  # half the Blinn-Phong exponent
    diffuse: Array
    specular: Array
    unlit: Array
    place: Array  # of each pixel's brightness among those of the object pixels; the background comes behind them
    is_surface: Array
    is_edge: Array


def surface_of(view: View) -> Surface:
    """Pick the object pixels of a view."""
    objects = view.types > 0
    rows, columns = np.nonzero(objects)
    window = np.s_[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    place = np.full(objects.shape, len(rows), np.int32)
    place[objects] = np.arange(len(rows))
    return Surface(
        position=[*view.position[objects].T],
        normal=[*view.normal[objects].T],
        to_viewer=[*view.to_viewer[objects].T],
        lobe=0.5 * view.shininess[objects],
        diffuse=view.diffuse[objects],
        specular=view.specular[objects],
        unlit=view.unlit[objects],
        place=place[window],
        is_surface=view.types[window] == SURFACE,
        is_edge=view.types[window] == EDGE,
    )


def dot(a: list[Array], b: list[Array]) -> Array:
    """Multiply vectors of which each coordinate is an array."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def shade(surface: Surface, rig: Array) -> Array:
    """Give the sRGB-encoded luminance of the object pixels under the lights of a rig, shape [lights, 6]."""
    radiance = surface.unlit
    n_v = dot(surface.normal, surface.to_viewer)
    for light in rig:
        to_light = [light[axis] - surface.position[axis] for axis in range(3)]
        inverse = jax.lax.rsqrt(dot(to_light, to_light))
        n_l = dot(surface.normal, to_light) * inverse
        l_v = dot(surface.to_viewer, to_light) * inverse
        along = jnp.maximum(n_l + n_v, 0.0)
        n_h2 = jnp.minimum(along * along / jnp.maximum(2.0 + 2.0 * l_v, 1e-20), 1.0)
        both = light[4] * surface.diffuse + light[5] * surface.specular * jnp.power(n_h2, surface.lobe)
        radiance += jnp.where(n_l > 0.0, light[3] * inverse * inverse * n_l * both, 0.0)
    x = jnp.minimum(radiance, 1.0)
    return jnp.where(x <= 0.0031308, 12.92 * x, 1.055 * jnp.power(x, 1.0 / 2.4) - 0.055)


def slopes(surface: Surface, picture: Array) -> Array:
    """Give the length of the Sobel pair at each pixel; a tap outside the object takes the centre's value."""
    image = jnp.append(picture, -1.0)[surface.place]
    height, width = image.shape
    padded = jnp.pad(image, 1, constant_values=-1.0)
    shifted = [padded[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    t = [jnp.where(tap < 0.0, image, tap) for tap in shifted]
    x = (t[2] - t[0]) + 2.0 * (t[5] - t[3]) + (t[8] - t[6])
    y = (t[6] - t[0]) + 2.0 * (t[7] - t[1]) + (t[8] - t[2])
    return jnp.sqrt(x * x + y * y) / 8.0


def terms(view: View, surface: Surface, variant: Variant, picture: Array) -> Array:
    """Give the five terms of a picture."""
    objective = view.objective
    slope = slopes(surface, picture)
    contrast = jnp.sum(jnp.where(surface.is_edge, jnp.minimum(slope / objective.edge_contrast, 1.0), 0.0))
    gradient = jnp.sum(jnp.where(surface.is_surface, slope, 0.0)) / max(view.surface, 1)
    distance = jnp.mean(picture - 0.5)
    variance = jnp.mean(jnp.square(picture - 0.5 - distance))
    share = variant.histogram(picture) / picture.size
    entropy = -jnp.sum(jnp.where(share > 0.0, share * jnp.log(jnp.where(share > 0.0, share, 1.0)), 0.0))
    target = objective.mean_target
    flat = view.normal_detail < 1e-6
    return jnp.stack(
        [
            1.0 - contrast / view.edge if view.edge else jnp.float32(0.0),
            jnp.abs(0.5 + distance - target) / max(target, 1.0 - target),
            jnp.float32(0.0) if flat else 1.0 - jnp.minimum(gradient / view.normal_detail, 1.0),
            1.0 - jnp.minimum(jnp.sqrt(12.0 * variance), 1.0),
            1.0 - entropy / np.log(BINS),
        ]
    )


class JaxGeneration:
    """The program for one number of lights and of individuals."""

    def __init__(self, view: View, surface: Surface, variant: Variant, shape: tuple[int, int], batch: int) -> None:
        population, lights = shape
        batches = -(-population // batch)
        each = -(-population // batches)
        self._surface = surface
        self._filling = np.zeros((batches * each - population, lights, 6), np.float32)
        self._terms: Array | None = None

        def one_batch(surface: Surface, rigs: Array) -> Array:
            # A barrier keeps the shading from being made again for each tap.
            pictures = barrier(jax.vmap(partial(shade, surface))(rigs))
            result: Array = variant.over(partial(terms, view, surface, variant))(pictures)
            return result

        def evaluate(surface: Surface, rigs: Array) -> tuple[Array, Array]:
            parts = rigs.reshape(batches, each, lights, 6)
            table = jax.lax.map(partial(one_batch, surface), parts) if batches > 1 else one_batch(surface, rigs)
            table = table.reshape(-1, len(TERMS))[:population]
            return jnp.sum(table * view.weights, axis=1), table

        self._evaluate = jax.jit(evaluate)

    def scores(self, records: Floats) -> Floats:
        """Score rigs, from host to host."""
        if len(self._filling):
            records = np.concatenate([records, self._filling])
        scores, self._terms = self._evaluate(self._surface, records)
        return np.asarray(scores)

    def terms(self) -> Floats:
        """Give the terms of the rigs that were scored last."""
        return np.asarray(self._terms)


class JaxPeer:
    """JAX on one kind of device."""

    def __init__(self, view: View, platform: str) -> None:
        """Find the device and the variant that is fastest there.

        Raises:
            UnavailableError: where there is no such device.

        """
        try:
            device = jax.devices(platform)[0]
        except RuntimeError as fault:
            raise UnavailableError(f"JAX {jax.__version__} finds no {platform}: {fault}") from fault
        self.name = f"jax-{platform}"
        self.device = f"{device.device_kind}, JAX {jax.__version__}"
        self._view, self._batch = view, BATCH[platform]
        self._surface = jax.device_put(surface_of(view), device)  # where this is, all is computed
        self._variant = min(VARIANTS, key=self._time)

    def prepare(self, lights: int, population: int) -> JaxGeneration:
        """Make the program for so many lights and individuals; it is compiled when it first runs."""
        return self._generation(self._variant, (population, lights))

    def _generation(self, variant: Variant, shape: tuple[int, int]) -> JaxGeneration:
        return JaxGeneration(self._view, self._surface, variant, shape, self._batch)

    def _time(self, variant: Variant) -> float:
        generation = self._generation(variant, (30, 2))
        rigs = records(random_rigs(np.random.default_rng(0), 30, 2))
        times = []
        for _ in range(4):  # the first one compiles
            start = time.perf_counter()
            generation.scores(rigs)
            times.append(time.perf_counter() - start)
        return min(times)
