"""klieg's program, as the peers' run needs it."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from view import TERMS, Objective

# Longest time of one command, seconds.
PATIENCE = 600


class ProgramError(Exception):
    """Why a command of klieg gave no result."""


@dataclass(frozen=True)
class Program:
    """A klieg program and the view that it works on."""

    path: Path
    scene: Path
    size: str

    def analyze(self, folder: Path) -> None:
        """Write the view's maps into a folder."""
        self._run("analyze", "--size", self.size, "--device", "cpu", "--out", str(folder))

    def score(self, rig: list[list[float]]) -> dict[str, Any]:
        """Score a rig with the native evaluator: `klieg.score/1`."""
        lights = [word for light in rig for word in ("--light", ",".join(map(str, light)))]
        return self._json("score", "--size", self.size, "--device", "cpu", *lights)

    def bench(self, options: list[str]) -> dict[str, Any]:
        """Time generations: `klieg.bench/2`."""
        return self._json("bench", "--size", self.size, *options)

    def objective(self) -> Objective:
        """Give the numbers of the quality function.

        Raises:
            ProgramError: for an objective that the peers do not compute.

        """
        of = self.score([[30.0, 30.0, 2.0, 1.0, 1.0]])["objective"]
        weights = {name: weight for name, weight in of["weights"].items() if weight > 0.0}
        if set(weights) - set(TERMS) or of["targets"]["mean_stops"] != 0.0:
            raise ProgramError(f"the peers know the terms {', '.join(TERMS)} alone, without stops")
        return Objective(
            {term: weights.get(term, 0.0) for term in TERMS}, of["targets"]["mean"], of["targets"]["edge_contrast"]
        )

    def _json(self, *words: str) -> dict[str, Any]:
        result: dict[str, Any] = json.loads(self._run(*words, "--json"))
        return result

    def _run(self, command: str, *words: str) -> str:
        line = [str(self.path), command, str(self.scene), "--profile", "paper", "--quiet", *words]
        try:
            done = subprocess.run(line, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except subprocess.TimeoutExpired as fault:
            raise ProgramError(f"klieg {command}: no result within {PATIENCE} s") from fault
        except OSError as fault:
            raise ProgramError(f"{self.path}: {fault.strerror}") from fault
        if done.returncode != 0:
            raise ProgramError(f"klieg {command} ended with {done.returncode}: {done.stderr.strip()}")
        return done.stdout
