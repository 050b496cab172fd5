"""Times klieg in turn with what a user would otherwise write for the same work. See README.md beside this file."""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from program import Program, ProgramError
from view import TERMS, Floats, Generation, Peer, UnavailableError, View, load, random_rigs, records

PEERS = ("jax-cpu", "jax-gpu", "cupy")
# Largest difference of a term or a score from klieg's.
TOLERANCE = 1e-3
# Of each number of lights: the population that is checked, no multiple of any block, and the rigs that klieg scores.
CHECKED, CHECKED_RIGS = 37, (0, 11, 24, 36)
# Generations of a sample: at least, and at most.
LEAST, MOST = 3, 200
# Warming up goes on so long, seconds.
WARM_UP = 0.1
# Different populations that a sample takes by turns.
POOL = 4
# A generation that would take longer than so many times the seconds of a sample is left out.
TOO_LONG = 10


def main() -> int:
    """Run the comparison; 1 where a peer's scores are not klieg's."""
    options = parse()
    program = Program(options.klieg, options.scene, options.size)
    try:
        view = maps(program, options.maps)
        peers, not_run = find_peers(view, options.peers)
        agreement = check_all(program, peers, options.lights, not_run)
        agreeing = [peer for peer in peers if peer.name in agreement and agreement[peer.name]["agrees"]]
        result = {
            "schema": "klieg.peers/1",
            "machine": {"processor": processor(), "cores": os.cpu_count()},
            "scene": str(options.scene),
            "size": options.size,
            "object_pixels": view.surface + view.edge,
            "agreement": agreement,
            "not_run": not_run,
        }
        # Brought up to date after every round, so that a run that is ended leaves what it has.
        for rows in time_in_turn(program, agreeing, options, not_run):
            result["rows"] = rows
            options.out.write_text(json.dumps(result, indent=2) + "\n")
    except (ProgramError, UnavailableError) as fault:
        say(f"peers: {fault}")
        return 2
    print(table(result, options))
    return 0 if all(of["agrees"] for of in agreement.values()) else 1


def parse() -> argparse.Namespace:
    """Read the command line."""

    def numbers(text: str) -> list[int]:
        return [int(word) for word in text.split(",")]

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("klieg", type=Path, help="klieg's program")
    parser.add_argument("scene", type=Path, help="a scene")
    parser.add_argument("--peers", type=lambda text: text.split(","), default=list(PEERS), help="default: all")
    parser.add_argument("--devices", help="klieg's devices, as of `klieg bench --device` [default: its own]")
    parser.add_argument("--size", default="512x512", metavar="WxH", help="of the picture")
    parser.add_argument("--lights", type=numbers, default=[1, 2, 4], help="numbers of lights [default: 1,2,4]")
    parser.add_argument("--population", type=numbers, default=[30, 300, 3000], help="[default: 30,300,3000]")
    parser.add_argument("--seconds", type=float, default=1.0, help="most seconds of a sample [default: 1]")
    parser.add_argument("--rounds", type=int, default=3, help="samples of each, taken in turn [default: 3]")
    parser.add_argument("--maps", type=Path, help="a folder of `klieg analyze --profile paper`, not to analyze anew")
    parser.add_argument("--out", type=Path, default=Path("peers.json"), help="[default: peers.json]")
    options = parser.parse_args()
    unknown = set(options.peers) - set(PEERS)
    if unknown:
        parser.error(f"no peer is called {', '.join(sorted(unknown))}: they are {', '.join(PEERS)}")
    return options


def maps(program: Program, folder: Path | None) -> View:
    """Read the view's maps, which klieg makes where they are not there."""
    objective = program.objective()
    if folder is not None:
        return load(folder, objective)
    with tempfile.TemporaryDirectory() as made:
        program.analyze(Path(made))
        return load(Path(made), objective)


def find_peers(view: View, names: list[str]) -> tuple[list[Peer], dict[str, str]]:
    """Set the peers up that this machine can run; the others with the reason why not."""
    peers: list[Peer] = []
    not_run: dict[str, str] = {}
    for name in names:
        say(f"setting up {name}")
        with failing(name, not_run):
            peers.append(make(name, view))
    return peers, not_run


@contextmanager
def failing(what: str, not_run: dict[str, str]) -> Iterator[None]:
    """Note why a peer could not do something: whatever its package or a driver raises stops no other."""
    try:
        yield
    except Exception as fault:
        not_run[what] = f"{type(fault).__name__}: {fault}"
        say(f"{what} is not run: {not_run[what]}")


def make(name: str, view: View) -> Peer:
    """Set a peer up. Its package is looked for here, as no other peer needs it."""
    if name == "cupy":
        from cupy_peer import CupyPeer  # noqa: PLC0415

        return CupyPeer(view)
    # klieg's processes need memory of the same GPU.
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    from jax_peer import JaxPeer  # noqa: PLC0415

    return JaxPeer(view, name.removeprefix("jax-"))


def check_all(
    program: Program, peers: list[Peer], numbers: list[int], not_run: dict[str, str]
) -> dict[str, dict[str, Any]]:
    """Compare each peer's terms and scores with klieg's: the proof that all compute the same."""
    random = np.random.default_rng(1)
    rigs = [random_rigs(random, CHECKED, lights) for lights in numbers]
    expected = [[program.score(of[at].tolist()) for at in CHECKED_RIGS] for of in rigs] if peers else []
    agreement: dict[str, dict[str, Any]] = {}
    for peer in peers:
        with failing(peer.name, not_run):
            agreement[peer.name] = check(peer, rigs, expected)
    return agreement


def check(peer: Peer, rigs: list[NDArray[np.float64]], expected: list[list[dict[str, Any]]]) -> dict[str, Any]:
    """Compare a peer with klieg's scores of some of the rigs."""
    terms, scores = 0.0, 0.0
    for of, by_klieg in zip(rigs, expected, strict=True):
        generation = peer.prepare(of.shape[1], len(of))
        found, found_terms = generation.scores(records(of)), generation.terms()
        for at, score in zip(CHECKED_RIGS, by_klieg, strict=True):
            differences = np.abs(found_terms[at] - [score["terms"][term] for term in TERMS])
            terms = max(terms, float(differences.max()))
            scores = max(scores, abs(float(found[at]) - score["score"]))
    agrees = bool(max(terms, scores) <= TOLERANCE)
    count = len(rigs) * len(CHECKED_RIGS)
    say(f"{peer.name}: terms within {terms:.1e}, scores within {scores:.1e} of klieg's, {count} rigs")
    if not agrees:
        say(f"{peer.name} is not timed: it computes something else")
    return {"rigs": count, "terms": terms, "scores": scores, "agrees": agrees}


# Who, on what, and the numbers of lights and of individuals.
Key = tuple[str, str, int, int]
# What a peer has compiled, by its name and the numbers of lights and of individuals.
Prepared = dict[tuple[str, int, int], Generation]


def time_in_turn(
    program: Program, peers: list[Peer], options: argparse.Namespace, not_run: dict[str, str]
) -> Iterator[list[dict[str, Any]]]:
    """Sample klieg, then each peer, and all of it again: the rows so far, after every round."""
    medians: dict[Key, list[float]] = {}
    prepared: Prepared = {}
    for number in range(options.rounds):
        say(f"round {number + 1} of {options.rounds}")
        for key, median in sample_klieg(program, options):
            medians.setdefault(key, []).append(median)
        for peer in peers:
            for lights in options.lights:
                for key, times in sample_peer(peer, lights, prepared, options, not_run):
                    medians.setdefault(key, []).extend(times)
        yield [row(key, found) for key, found in medians.items()]


def row(key: Key, medians: list[float]) -> dict[str, Any]:
    """Say what the rounds found; no median where none was measured."""
    of = dict(zip(("name", "device", "lights", "population"), key, strict=True))
    return of | {"median_ms": statistics.median(medians) if medians else None, "medians_ms": medians}


def sample_klieg(program: Program, options: argparse.Namespace) -> Iterator[tuple[Key, float]]:
    """Sample klieg's generations, milliseconds."""
    lights, population = (",".join(map(str, numbers)) for numbers in (options.lights, options.population))
    words = ["--lights", lights, "--population", population, "--seconds", str(options.seconds), "--runs", str(MOST)]
    words += ["--device", options.devices] if options.devices else []
    for row in program.bench(words)["rows"]:
        device = row["device"]["name"] + (f", {row['threads']} threads" if row["threads"] else "")
        yield (f"klieg {row['pipeline']}", device, row["lights"], row["population"]), row["median_ms"]


def sample_peer(
    peer: Peer, lights: int, prepared: Prepared, options: argparse.Namespace, not_run: dict[str, str]
) -> Iterator[tuple[Key, list[float]]]:
    """Sample a peer's generations of any population: the median in milliseconds, or nothing of what is left out."""
    each = 0.0  # seconds of an individual
    for population in sorted(options.population):
        medians: list[float] = []
        what = f"{peer.name}, {lights} lights, N = {population}"
        if each * population > TOO_LONG * options.seconds:
            not_run[what] = f"too slow, some {each * population:.0f} seconds a generation"
        else:
            with failing(what, not_run):
                key = (peer.name, lights, population)
                if key not in prepared:
                    prepared[key] = peer.prepare(lights, population)
                median = statistics.median(sample(prepared[key], lights, population, options.seconds))
                each = median / population
                medians.append(1e3 * median)
        yield (peer.name, peer.device, lights, population), medians


def sample(generation: Generation, lights: int, population: int, seconds: float) -> list[float]:
    """Time generations, after some to warm up: seconds each, from rigs on the host to scores on the host."""
    random = np.random.default_rng(2)
    pool = [records(random_rigs(random, population, lights)) for _ in range(POOL)]
    generation.scores(pool[0])  # compiles
    repeat(generation.scores, pool, min(seconds, WARM_UP), 1)
    return repeat(generation.scores, pool, seconds, LEAST)


def repeat(work: Callable[[Floats], Floats], pool: list[Floats], seconds: float, least: int) -> list[float]:
    """Time calls until the seconds are over."""
    times: list[float] = []
    begin = time.perf_counter()
    while len(times) < least or (len(times) < MOST and time.perf_counter() - begin < seconds):
        rigs = pool[len(times) % len(pool)]
        start = time.perf_counter()
        work(rigs)
        times.append(time.perf_counter() - start)
    return times


def say(text: str) -> None:
    """Tell people how far the run is."""
    print(text, file=sys.stderr)


def processor() -> str:
    """Name the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def table(result: dict[str, Any], options: argparse.Namespace) -> str:
    """Write the result for people: a line for each program and number of lights, a column for each population."""
    columns = sorted(options.population)
    lines = [
        f"{result['scene']}, {result['size']}, {result['object_pixels']} object pixels; "
        f"{result['machine']['processor']}, {result['machine']['cores']} cores",
        "milliseconds a generation, median of the rounds' medians (lowest to highest)",
        "",
        f"{'lights':>6}  {'':50}" + "".join(f"{'N = ' + str(n):>26}" for n in columns),
    ]
    cells = {(row["name"], row["device"], row["lights"], row["population"]): row for row in result["rows"]}
    names = list(dict.fromkeys((row["name"], row["device"]) for row in result["rows"]))
    for lights in options.lights:
        for name, device in names:
            values = "".join(f"{cell(cells[name, device, lights, n]):>26}" for n in columns)
            lines.append(f"{lights:>6}  {f'{name}, {device}'[:50]:50}" + values)
    lines += [f"not run: {what}: {reason}" for what, reason in result["not_run"].items()]
    lines += [f"not timed: {name}, whose scores differ" for name, of in result["agreement"].items() if not of["agrees"]]
    return "\n".join(lines)


def cell(row: dict[str, Any]) -> str:
    """Write a median and the range of the rounds'."""
    if row["median_ms"] is None:
        return "not run"
    low, high = min(row["medians_ms"]), max(row["medians_ms"])
    return f"{digits(row['median_ms'])} ({digits(low)} to {digits(high)})"


def digits(value: float) -> str:
    """Write three significant digits, or all before the point."""
    return f"{value:.0f}" if value >= 1000 else f"{value:.3g}"


if __name__ == "__main__":
    sys.exit(main())
