"""What several tests share."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

import klieg

ROOT = Path(__file__).resolve().parents[2]

# A search of these takes a fraction of a second.
QUICK = klieg._settings.DesignOptions(generations=6, population=8, coarse=0)


@pytest.fixture(scope="session")
def pair() -> klieg.Scene:
    """A scene of two objects."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    ring = trimesh.creation.torus(1.0, 0.3, major_sections=24, minor_sections=12)
    return klieg.Scene.from_trimesh(trimesh.Scene([ball.apply_translation([1.8, 0.4, 0]), ring]))


@pytest.fixture(scope="session")
def elephant() -> Path:
    return ROOT / "scenes" / "elephant.glb"


@pytest.fixture(scope="session")
def view(pair: klieg.Scene) -> klieg.View:
    return klieg.View(pair, (96, 72))


@pytest.fixture(scope="session")
def program() -> Callable[..., subprocess.CompletedProcess[str]]:
    """The command line, built beside the package."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = Path(os.environ.get("KLIEG", target / "debug" / "klieg"))
    assert path.exists(), f"{path} is missing: build klieg, or name it in KLIEG"

    def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run([path, *arguments], check=True, text=True, capture_output=True)

    return run
