#!/usr/bin/env python3
"""Makes the rows of pictures of docs/INTENT.md: one design a picture, side by side, a gallery and a turntable. Needs Pillow.

    tools/intent/rows.py KLIEG [OUT]

KLIEG is the program, OUT the folder (docs/intent where absent). Other arguments of the designs are the same for all.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw

ROOT = Path(__file__).resolve().parents[2]
BACKGROUND = (58, 60, 66)
COMMON = ["--device", "cpu", "--size", "160x160", "--coarse", "0", "--generations", "40", "-q"]
# The terms of profile natural.
TERMS = "edge mean hist detail range burnt unlit relief direction outline".split()


def only(term: str) -> list[str]:
    """The options of an objective of one term."""
    return ["--weights", ",".join([f"{name}=0" for name in TERMS] + [f"{term}=1"])]


# Where the strokes lie, pixels of 160: a highlight on the jug of the still life, and a shadow on the elephant.
HIGHLIGHT = ("still-life", (57, 45, 63, 51), 255)
SHADOW = ("elephant", (86, 66, 100, 78), 0)

# Name of the row, the scene, and the options of each picture.
ROWS = [
    ("brightness", "elephant", [["--brightness", str(step)] for step in (-2, -1, 0, 1, 2)]),
    ("contrast", "elephant", [["--contrast", str(step)] for step in (-2, -1, 0, 1, 2)]),
    ("mood", "elephant", [["--mood", mood] for mood in ("soft", "natural", "dramatic")]),
    ("below", "pair", [BELOW := ["--config", str(ROOT / "tools/intent/low.toml")], [*BELOW, "--no-below"]]),
    ("focus", "pair", [[], ["--focus", "amphora"], ["--dim", "amphora"], ["--dim", "elephant"]]),
    ("like", "elephant", [["--mood", "dramatic", "--background", "transparent"], [], ["--like", "{0}"]]),
    ("entropy", "elephant", [only("hist"), only("entropy"), [*only("entropy"), "--one-by-one"], []]),
    ("warm", "pair", [[], ["--warm", "key=3000K"], ["--warm", "key=3000K", "--warm", "fill=12000K"]]),
]


def row(pictures: list[Image.Image]) -> Image.Image:
    """Pictures side by side."""
    side_by_side = Image.new("RGB", (sum(picture.width for picture in pictures), pictures[0].height))
    left = 0
    for picture in pictures:
        side_by_side.paste(picture, (left, 0))
        left += picture.width
    return side_by_side


def on_ground(picture: Image.Image) -> Image.Image:
    """A picture that is transparent in places, on the rows' background."""
    return Image.alpha_composite(Image.new("RGBA", picture.size, BACKGROUND), picture).convert("RGB")


def design(klieg: str, scene: str, options: list[str], folder: Path) -> Image.Image:
    """The final picture of a design."""
    file = ROOT / "scenes" / f"{scene}.glb"
    subprocess.run([klieg, "design", file, "--out", folder, *COMMON, *options], check=True, stdout=subprocess.DEVNULL)
    return on_ground(Image.open(folder / "best.png").convert("RGBA"))


def paint(klieg: str, out: Path, folder: Path) -> None:
    """The usual light, the same painted over where another light is wanted, and the light that makes that."""
    usual = design(klieg, "elephant", ["--background", "transparent"], folder / "usual")
    picture = Image.open(folder / "usual/best.png").convert("RGBA")
    warm = Image.new("RGB", picture.size, (255, 176, 110))
    cold = Image.new("RGB", picture.size, (28, 34, 48))
    across = Image.linear_gradient("L").rotate(90).resize(picture.size)
    painted = Image.blend(picture.convert("RGB"), Image.composite(warm, cold, across), 0.55)
    painted.putalpha(picture.getchannel("A").point(lambda alpha: 255 if alpha == 255 else 0))
    painted.save(folder / "painted.png")
    made = design(klieg, "elephant", ["--target-picture", str(folder / "painted.png")], folder / "made")
    row([usual, on_ground(painted), made]).save(out / "paint.jpg", quality=88)


def keep(klieg: str, out: Path, folder: Path) -> None:
    """A three-point rig, what becomes of it where its key or its other lights are kept, and three free lights."""
    folder.mkdir()
    picture = folder / "preset.png"
    render = ["--preset", "three-point", "--size", "160x160", "--background", "transparent"]
    scene = ROOT / "scenes/elephant.glb"
    subprocess.run([klieg, "render", scene, "--out", picture, *render], check=True, stdout=subprocess.DEVNULL)
    free = ["--lights", "3"]
    first = [*free, "--first", "three-point"]
    wishes = [[*first, "--keep", "key"], [*first, "--keep", "fill", "--keep", "rim"], free]
    made = [design(klieg, "elephant", options, folder / str(at)) for at, options in enumerate(wishes)]
    row([on_ground(Image.open(picture).convert("RGBA")), *made]).save(out / "keep.jpg", quality=88)


def strokes(klieg: str, out: Path, folder: Path) -> None:
    """The usual light with a stroke on it, of a highlight and of a shadow, each beside the light that puts it there."""
    pictures = []
    for scene, place, grey in (HIGHLIGHT, SHADOW):
        usual = design(klieg, scene, [], folder / f"{scene}-usual")
        drawn = Image.new("RGBA", usual.size)
        ImageDraw.Draw(drawn).ellipse(place, fill=(grey, grey, grey, 255))
        drawn.save(folder / f"{scene}.png")
        over = Image.alpha_composite(usual.convert("RGBA"), drawn).convert("RGB")
        made = design(klieg, scene, ["--strokes", str(folder / f"{scene}.png")], folder / f"{scene}-made")
        pictures += [over, made]
    row(pictures).save(out / "strokes.jpg", quality=88)


def collage(klieg: str, out: Path, folder: Path) -> None:
    """A light collage, the nearest rigs of two and of four lights, and the usual light."""
    made = []
    for at, options in enumerate((["--collage"], ["--collage", "--lights", "key,fill,rim,fill"], [])):
        place = folder / str(at)
        made.append(design(klieg, "elephant", options, place))
        if at == 0:
            made.insert(0, on_ground(Image.open(place / "collage.png").convert("RGBA")))
    row(made).save(out / "collage.jpg", quality=88)


def gallery(klieg: str, out: Path, folder: Path) -> None:
    """The pictures of a gallery, best first, in rows of six."""
    file = ROOT / "scenes" / "elephant.glb"
    command = [klieg, "gallery", file, "--out", folder, "--device", "cpu", "--size", "160x160", "-q"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    made = [Image.open(path).convert("RGB") for path in sorted(folder.glob("*.png"))]
    sheet = Image.new("RGB", (6 * 160, -(-len(made) // 6) * 160), BACKGROUND)
    for at, picture in enumerate(made):
        sheet.paste(picture, (at % 6 * 160, at // 6 * 160))
    sheet.save(out / "gallery.jpg", quality=88)


def turntable(klieg: str, out: Path, folder: Path) -> None:
    """Every other view of a turntable: under a headlight above, under one rig that stands still below."""
    file = ROOT / "scenes" / "elephant.glb"
    options = ["--views", "8", "--lights", "key,fill,fill"]
    subprocess.run([klieg, "design", file, "--out", folder, *COMMON, *options], check=True, stdout=subprocess.DEVNULL)
    with Image.open(folder / "turntable.png") as frames:
        step = frames.n_frames // 4
        strip = Image.new("RGB", (4 * 160, 2 * 160), BACKGROUND)
        for at in range(4):
            frames.seek(at * step)
            both = frames.convert("RGB")
            strip.paste(both.crop((0, 0, 160, 160)), (160 * at, 0))
            strip.paste(both.crop((both.width - 160, 0, both.width, 160)), (160 * at, 160))
    strip.save(out / "views.jpg", quality=88)


def main() -> None:
    """Makes all rows."""
    klieg, *rest = sys.argv[1:]
    out = Path(rest[0]) if rest else ROOT / "docs/intent"
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        for name, scene, pictures in ROWS:
            made = []
            for at, options in enumerate(pictures):
                # "{0}" is the first picture of the row.
                options = [option.format(Path(place, f"{name}0", "best.png")) for option in options]
                made.append(design(klieg, scene, options, Path(place, f"{name}{at}")))
            row(made).save(out / f"{name}.jpg", quality=88)
        paint(klieg, out, Path(place, "paint"))
        strokes(klieg, out, Path(place, "strokes"))
        keep(klieg, out, Path(place, "keep"))
        collage(klieg, out, Path(place, "collage"))
        gallery(klieg, out, Path(place, "gallery"))
        turntable(klieg, out, Path(place, "views"))


if __name__ == "__main__":
    main()
