"""The same scores by CUDA kernels of our own through CuPy: `generation.cu`, launched as a CUDA graph."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import cupy
import numpy as np
from cupy.cuda import runtime
from numpy.lib.stride_tricks import sliding_window_view

from view import BINS, SURFACE, TERMS, Floats, UnavailableError, View, random_rigs, records

SOURCE = Path(__file__).with_name("generation.cu")
OPTIONS = ("-std=c++17", "--use_fast_math")

# As in the source.
SIDE = 32
THREADS = 256
MOST = 32
OBJECT_FLAG, SURFACE_FLAG, EDGE_FLAG = 1, 2, 4


def tiles_of(view: View) -> Floats:
    """Cut the picture into tiles with a border of one pixel: four records of four numbers for each pixel of a tile.

    Shape [tiles, 4, 32 * 32, 4]. Tiles without object pixels are left out.
    """
    objects = view.types > 0
    counts_as = np.where(view.types == SURFACE, SURFACE_FLAG, EDGE_FLAG) * objects
    pixels = np.zeros((*objects.shape, 16), np.float32)
    pixels[..., 0:3], pixels[..., 3] = view.position, 0.5 * view.shininess
    pixels[..., 4:7], pixels[..., 7] = view.normal, view.diffuse
    pixels[..., 8:11], pixels[..., 11] = view.to_viewer, view.specular
    pixels[..., 12], pixels[..., 13] = view.unlit, OBJECT_FLAG * objects + counts_as
    pixels[~objects] = 0.0
    step = SIDE - 2
    filling = [(1, -size % step + 1) for size in objects.shape]
    padded = np.pad(pixels, [*filling, (0, 0)])
    windows = sliding_window_view(padded, (SIDE, SIDE), axis=(0, 1))[::step, ::step]  # [rows, columns, 16, 32, 32]
    tiles = windows.reshape(-1, 4, 4, SIDE, SIDE).transpose(0, 1, 3, 4, 2).copy()
    border = np.ones((SIDE, SIDE), bool)
    border[1:-1, 1:-1] = False
    flags = tiles[:, 3, :, :, 1]
    flags[:, border] = np.minimum(flags[:, border], OBJECT_FLAG)
    counted = (flags > OBJECT_FLAG).any(axis=(1, 2))
    return np.ascontiguousarray(tiles[counted].reshape(-1, 4, SIDE * SIDE, 4))


class Pinned:
    """An array in page-locked memory of the host."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        count = int(np.prod(shape))
        self._memory = cupy.cuda.alloc_pinned_memory(4 * count)
        self.array = np.frombuffer(self._memory, np.float32, count).reshape(shape)


class CupyGeneration:
    """A graph for one number of lights and of individuals: rigs up, two kernels, scores down."""

    def __init__(self, peer: CupyPeer, lights: int, population: int, individuals: int) -> None:
        """Take the memory and record the graph.

        Args:
            peer: what all generations share.
            lights: of an individual.
            population: number of individuals.
            individuals: how many of them a block takes, at most `MOST`.

        """
        measure_kernel, judge_kernel = peer.kernels(lights)
        tiles = len(peer.surface)
        self._rigs, self._scores = Pinned((population, lights, 6)), Pinned((population,))
        self._device_rigs = cupy.empty((population, lights, 6), cupy.float32)
        self._device_scores = cupy.empty(population, cupy.float32)
        self._terms = cupy.empty((population, len(TERMS)), cupy.float32)
        self._bins = cupy.empty((population, tiles, BINS), cupy.uint32)
        self._sums = cupy.empty((population, tiles, 4), cupy.float32)
        blocks = (tiles, -(-population // individuals))
        counts = (np.int32(population), np.int32(individuals))
        measure = (peer.surface, self._device_rigs, *counts, peer.per_contrast, self._bins, self._sums)
        judge = (self._bins, self._sums, np.int32(tiles), peer.constants, self._terms, self._device_scores)
        self._stream = cupy.cuda.Stream(non_blocking=True)

        def work() -> None:
            self._copy_up()
            measure_kernel(blocks, (THREADS,), measure)
            judge_kernel((population,), (THREADS,), judge)
            self._copy_down()

        self._rigs.array[:] = 0.0
        cupy.cuda.Device().synchronize()
        with self._stream:
            work()  # compiles and loads the kernels, which cannot be done while recording
            self._stream.synchronize()
            self._stream.begin_capture()
            work()
            self._graph = self._stream.end_capture()

    def _copy_up(self) -> None:
        host, device = self._rigs.array, self._device_rigs.data
        runtime.memcpyAsync(device.ptr, host.ctypes.data, host.nbytes, runtime.memcpyHostToDevice, self._stream.ptr)

    def _copy_down(self) -> None:
        host, device = self._scores.array, self._device_scores.data
        runtime.memcpyAsync(host.ctypes.data, device.ptr, host.nbytes, runtime.memcpyDeviceToHost, self._stream.ptr)

    def scores(self, records: Floats) -> Floats:
        """Score rigs, from host to host."""
        self._rigs.array[:] = records
        self._graph.launch(self._stream)
        self._stream.synchronize()
        return self._scores.array.copy()

    def terms(self) -> Floats:
        """Give the terms of the rigs that were scored last."""
        terms: Floats = cupy.asnumpy(self._terms)
        return terms


class CupyPeer:
    """Kernels on the first CUDA device."""

    name = "cupy"

    def __init__(self, view: View) -> None:
        """Put the surface on the device.

        Raises:
            UnavailableError: where there is no device.

        """
        try:
            properties = runtime.getDeviceProperties(0)
        except runtime.CUDARuntimeError as fault:
            raise UnavailableError(f"CuPy {cupy.__version__} finds no device: {fault}") from fault
        self.device = f"{properties['name'].decode()}, CuPy {cupy.__version__}"
        self.surface = cupy.asarray(tiles_of(view))
        self.per_contrast = np.float32(1.0 / view.objective.edge_contrast)
        numbers = [view.surface, view.edge, view.normal_detail, view.objective.mean_target, *view.weights]
        self.constants = cupy.asarray(np.array(numbers, np.float32))
        self._kernels: dict[int, tuple[Any, Any]] = {}

    def kernels(self, lights: int) -> tuple[Any, Any]:
        """Give `measure` and `judge` for so many lights."""
        if lights not in self._kernels:
            module = cupy.RawModule(code=SOURCE.read_text(), options=(*OPTIONS, f"-DLIGHTS={lights}"))
            self._kernels[lights] = (module.get_function("measure"), module.get_function("judge"))
        return self._kernels[lights]

    def prepare(self, lights: int, population: int) -> CupyGeneration:
        """Record the graph for so many lights and individuals, with blocks of the size that is fastest."""
        sizes = [size for size in (1, 2, 4, 8, 16, MOST) if size < 2 * population]
        tried = [CupyGeneration(self, lights, population, size) for size in sizes]
        rigs = records(random_rigs(np.random.default_rng(0), population, lights))
        return min(tried, key=lambda generation: _time(generation, rigs))


def _time(generation: CupyGeneration, rigs: Floats) -> float:
    times = []
    for _ in range(10):
        start = time.perf_counter()
        generation.scores(rigs)
        times.append(time.perf_counter() - start)
    return sorted(times)[len(times) // 2]
