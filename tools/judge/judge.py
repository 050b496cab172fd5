"""Judges klieg's designs from outside: renders each in Cycles beside the usual rigs and measures the pictures.

Writes `judge.json`, `judge.csv` and `judge.html` into the folder OUT, and a folder of pictures for each scene.
They are brought up to date after every scene, so that a run that is ended leaves what it has.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

import measures
import page
from three import Three

PRESETS = ["headlight", "light-kit", "three-point"]
RIGS = ["design", *PRESETS]
# klieg's ambient light, a share of the base colour.
AMBIENT = 0.03
# Longest time of one program, seconds.
PATIENCE = 900


class Failure(Exception):
    """Why a scene could not be judged."""


def run(command):
    """Runs a program; gives what it prints."""
    command = [str(word) for word in command]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired as error:
        raise Failure(f"{Path(command[0]).name} {command[1]}: no result within {PATIENCE} s") from error
    except OSError as error:
        raise Failure(f"{command[0]}: {error.strerror}") from error
    if done.returncode != 0:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        raise Failure("\n".join(lines[-4:]) or f"{command[0]} ended with {done.returncode}")
    return done.stdout


def find_scenes(place):
    """The scenes of a list (a text file of paths, relative to its own folder), of a folder or its folders, or
    the one scene that is named."""
    place = Path(place)
    if place.is_dir():
        found = [file for level in ("*", "*/*") for file in place.glob(level)]
        scenes = sorted(file for file in found if file.suffix in (".glb", ".gltf"))
    elif place.suffix in (".glb", ".gltf"):
        scenes = [place]
    elif place.is_file():
        lines = [line.strip() for line in place.read_text().splitlines()]
        scenes = [place.parent / line for line in lines if line and not line.startswith("#")]
    else:
        sys.exit(f"judge: {place}: no such scene, folder of scenes or list of scenes")
    if not scenes:
        sys.exit(f"judge: {place}: no .glb or .gltf file in it")
    return scenes


def named(scenes):
    """The scenes by names for their folders: the file's, with a number where it is taken."""
    names = {}
    for scene in scenes:
        name, number = scene.stem, 2
        while name in names:
            name, number = f"{scene.stem}-{number}", number + 1
        names[name] = scene
    return names


def design(options, scene, folder):
    """klieg's design, and its score of every preset: `F` and the lights, by rig."""
    common = ["--size", f"{options.size}x{options.size}", "--json", *options.klieg_args]
    result = json.loads(run([options.klieg, "design", scene, "--out", folder, *common, *options.design_args]))
    scores = {"design": result}
    for preset in PRESETS:
        scores[preset] = json.loads(run([options.klieg, "score", scene, "--preset", preset, *common]))
    return scores


def render(options, scores, folder):
    """Renders the scene under all rigs in Blender; gives the pictures by name, linear and not premultiplied, and
    the surface that they show."""

    def rig(lights):
        return [[light["elevation_deg"], light["azimuth_deg"], light["diffuse"]] for light in lights]

    job = {
        "scene": str(folder / "lit.glb"),
        "out": str(folder),
        "size": [options.size, options.size],
        "samples": options.samples,
        "threads": options.threads,
        "ambient": AMBIENT,
        "rigs": {preset: rig(scores[preset]["lights"]) for preset in PRESETS},
    }
    (folder / "job.json").write_text(json.dumps(job))
    run([sys.executable, Path(__file__).with_name("blender.py"), folder / "job.json"])
    names = [*RIGS, "direct", "plain", "normal", "albedo", "depth"]
    arrays = {name: np.load(folder / f"{name}.npy").astype(np.float64) for name in names}
    for name in [*names, "job"]:
        (folder / f"{name}.{'json' if name == 'job' else 'npy'}").unlink()
    # Depth is that of one ray a pixel, which may miss where the others hit.
    mask = (arrays["design"][..., 3] > 0.5) & (arrays["depth"] < 1e6)
    if not mask.any():
        raise Failure("Blender shows no object where klieg does")
    surface = measures.Surface(mask, arrays["normal"], arrays["albedo"], arrays["depth"])
    pictures = {}
    for name in [*RIGS, "direct", "plain"]:
        alpha = arrays[name][..., 3:]
        pictures[name] = np.where(mask[..., None], arrays[name][..., :3] / np.maximum(alpha, 1e-6), 0)
    return pictures, surface


def save(pictures, surface, own, folder):
    """Writes the pictures that the page shows, on the background of klieg's own."""
    ground = own[0, 0]
    for name, picture in pictures.items():
        encoded = np.where(surface.mask[..., None], measures.encode(picture), ground)
        Image.fromarray((encoded * 255 + 0.5).astype(np.uint8)).save(folder / f"cycles-{name}.png")


def judge(options, name, scene):
    """All that is found of a scene."""
    begin = time.monotonic()
    folder = options.out / name
    folder.mkdir(parents=True, exist_ok=True)
    if not scene.is_file():
        raise Failure("no such file")
    scores = design(options, scene, folder)
    designed = time.monotonic()
    pictures, surface = render(options, scores, folder)
    pictures["plain"] += AMBIENT * surface.albedo
    own = np.asarray(Image.open(folder / "best.png").convert("RGB")) / 255
    save(pictures, surface, own, folder)
    rigs = {rig: {"F": scores[rig]["score"], **measures.measure(pictures[rig], surface)} for rig in RIGS}
    linear = measures.decode(own)
    found = {
        "name": name,
        "file": str(scene),
        "seconds": {"klieg": designed - begin, "all": time.monotonic() - begin},
        "rigs": rigs,
        "own": measures.measure(linear, surface),
        "difference": {
            "with_shadows": measures.difference(linear, pictures["direct"], surface.mask),
            "without_shadows": measures.difference(linear, pictures["plain"], surface.mask),
        },
        "terms": {rig: scores[rig]["terms"] for rig in RIGS},
        "lights": scores["design"]["lights"],
    }
    if options.three:
        viewed = options.three.render(folder / "lit.glb", options.size)
        ground = np.where(surface.mask[..., None], viewed, own[0, 0])
        Image.fromarray((ground * 255 + 0.5).astype(np.uint8)).save(folder / "three.png")
        found["difference"]["three"] = measures.difference(linear, measures.decode(viewed), surface.mask)
    return found


def summary(found):
    """Medians over the scenes by rig, and where a preset does better than the design."""
    if not found:
        return {"medians": {}, "better": {"legibility": [], "F": []}}
    keys = found[0]["rigs"]["design"].keys()

    def median(rig, key):
        return statistics.median(scene["rigs"][rig][key] for scene in found)

    better = {"legibility": [], "F": []}
    for scene in found:
        for measure, sign in (("legibility", 1), ("F", -1)):
            gains = {rig: sign * (scene["rigs"][rig][measure] - scene["rigs"]["design"][measure]) for rig in PRESETS}
            better[measure] += [{"scene": scene["name"], "rig": rig, "by": by} for rig, by in gains.items() if by > 0]
    for ranked in better.values():
        ranked.sort(key=lambda entry: -entry["by"])
    return {"medians": {rig: {key: median(rig, key) for key in keys} for rig in RIGS}, "better": better}


def write(options, found, failed):
    """Writes the result anew."""
    settings = {"klieg": options.version, "size": options.size, "samples": options.samples}
    result = {"settings": settings, **summary(found), "scenes": found, "failed": failed}
    (options.out / "judge.json").write_text(json.dumps(result, indent=1) + "\n")
    (options.out / "judge.html").write_text(page.page(result, RIGS))
    with open(options.out / "judge.csv", "w", newline="") as file:
        table = csv.writer(file)
        for scene in found:
            for rig, values in scene["rigs"].items():
                if file.tell() == 0:
                    table.writerow(["scene", "rig", *values])
                table.writerow([scene["name"], rig, *(f"{value:.6g}" for value in values.values())])


def arguments():
    """What the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", help="a scene, a folder of scenes, or a text file with a path a line")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--klieg", type=Path, required=True, help="klieg's program")
    parser.add_argument("--size", type=int, default=256, help="width and height of all pictures, pixels [256]")
    parser.add_argument("--samples", type=int, default=64, help="Cycles' samples a pixel [64]")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="Cycles' threads [all cores]")
    parser.add_argument("--klieg-args", type=str.split, default=[], help="further arguments of `klieg design` and `klieg score`")
    parser.add_argument("--design-args", type=str.split, default=[], help="further arguments of `klieg design` alone")
    parser.add_argument("--three", action="store_true", help="compare klieg's picture with that of three.js too")
    return parser.parse_args()


def main():
    options = arguments()
    scenes = named(find_scenes(options.scenes))
    try:
        options.version = run([options.klieg, "--version"]).split()[-1]
    except Failure as failure:
        sys.exit(f"judge: {failure}")
    options.three = Three() if options.three else None
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    found, failed = [], []
    for number, (name, scene) in enumerate(scenes.items(), 1):
        try:
            found.append(judge(options, name, scene))
            shown = found[-1]["rigs"]["design"]
            outcome = f"legibility {shown['legibility']:.2f}, F {shown['F']:.3f}, {found[-1]['seconds']['all']:.0f} s"
        except (Failure, OSError, ValueError, KeyError) as error:
            outcome = str(error) or repr(error)
            failed.append({"name": name, "file": str(scene), "reason": outcome})
            outcome = f"failed: {outcome}"
        print(f"{number}/{len(scenes)} {name}: {outcome}", flush=True)
        write(options, found, failed)
    print(f"{len(found)} judged, {len(failed)} failed: {options.out / 'judge.html'}")
    return 0 if found else 1


if __name__ == "__main__":
    sys.exit(main())
