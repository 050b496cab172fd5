"""Rows of `klieg.ray.Designer`, which needs no Ray for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import klieg.ray

SMALL: dict[str, Any] = {"size": (48, 48), "generations": 3, "population": 6, "coarse": 0, "shadows": False}


def test_good_and_bad_items_have_a_row_each(elephant: Path) -> None:
    items = {"a.glb": elephant.read_bytes(), "b.glb": b"glTF", "c.ply": b"ply"}
    batch = {"path": np.array(list(items)), "bytes": np.array(list(items.values()), dtype=object)}
    rows = klieg.ray.Designer("cpu", **SMALL)(batch)
    assert {name: len(column) for name, column in rows.items()} == dict.fromkeys(
        ["path", "lights", "error", "score", "stopped", "png", "glb"], 3
    )
    assert rows["error"][0] == ""
    assert rows["glb"][0][:4] == b"glTF"
    assert all(rows["error"][1:])
    assert np.isfinite(rows["score"]).tolist() == [True, False, False]


def test_an_item_that_exceeds_its_time_gives_its_best(elephant: Path) -> None:
    designer = klieg.ray.Designer("cpu", size=(48, 48), generations=10**6, coarse=0, time_limit=0.2)
    row = designer.row("elephant.glb", elephant.read_bytes())
    assert row["stopped"]
    assert row["error"] == ""


class PanicException(BaseException):
    """Named like what PyO3 raises for a panic."""


class Faulty(klieg.ray.Designer):
    """Raises what it is told in the place of a design."""

    fault: BaseException

    def _design(self, path: str, data: bytes) -> klieg.Design:
        raise self.fault


def test_a_fault_of_its_own_is_that_items_and_an_interrupt_is_not() -> None:
    designer = Faulty("cpu", **SMALL)
    designer.fault = PanicException("index out of bounds")
    assert designer.row("a.glb", b"")["error"] == "a fault of klieg's own: index out of bounds"
    designer.fault = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        designer.row("a.glb", b"")


def test_options_that_there_are_not_are_refused_at_once() -> None:
    with pytest.raises(klieg.InputError, match="lights are a number"):
        klieg.ray.Designer("cpu", lights="lamp")
