"""The page of a judgement: every picture and measure side by side."""

from html import escape

STYLE = """
body { font: 14px/1.4 system-ui, sans-serif; margin: 2em; color: #222; background: #fafafa }
table { border-collapse: collapse; margin: 1em 0 } td, th { padding: .2em .7em; text-align: right }
th { font-weight: 600 } td:first-child, th:first-child { text-align: left } tr + tr { border-top: 1px solid #ddd }
.scene { display: flex; gap: .6em; flex-wrap: wrap } figure { margin: 0; width: 200px; font-size: 12px }
img { width: 200px; display: block } .worse { color: #b00020 } .best { font-weight: 700 }
"""
MEASURES = {
    "F": "klieg's own quality, lower is better",
    "legibility": "detail + outline/2 + tilt - burnt - crushed, higher is better",
    "detail": "share of the shape's detail that can be seen",
    "outline": "distinctness of outlines",
    "tilt": "R2 of the shading from the normals: how much tells left from right, up from down",
    "crushed": "share of pixels under 0.04: black",
    "burnt": "share of pixels with a channel of 0.985 or more",
    "unlit": "share of pixels that show less than a twentieth of their colour",
    "mean": "mean brightness",
    "spread": "standard deviation of the brightness",
}

# Other pictures of the design, which klieg's is compared with.
VIEWS = {
    "without_shadows": ("cycles-plain.png", "Cycles without bounces and shadows"),
    "with_shadows": ("cycles-direct.png", "Cycles without bounces, with ambient light"),
    "three": ("three.png", "three.js"),
}


def table(head, rows):
    """Rows of cells; cells are HTML."""
    lines = ["".join(f"<th>{cell}</th>" for cell in head)]
    lines += ["".join(f"<td>{cell}</td>" for cell in row) for row in rows]
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def medians(result, rigs):
    """Medians over all scenes."""
    rows = [[rig, *(f"{result['medians'][rig][name]:.3f}" for name in MEASURES)] for rig in rigs]
    head = ["rig", *(f'<abbr title="{escape(text)}">{name}</abbr>' for name, text in MEASURES.items())]
    return table(head, rows)


def better(entries, what, count):
    """Where a preset does better than the design."""
    scenes = {entry["scene"] for entry in entries}
    rows = [[f'<a href="#{escape(e["scene"])}">{escape(e["scene"])}</a>', e["rig"], f"{e['by']:.3f}"] for e in entries]
    found = f"<h2>Presets of better {what}: on {len(scenes)} of {count} scenes</h2>"
    return found + (table(["scene", "rig", "by"], rows) if rows else "")


def figure(name, picture, title, values):
    """A picture with its measures."""
    text = "<br>".join(f"{escape(key)} {value}" for key, value in values.items())
    source = escape(f"{name}/{picture}")
    return f'<figure><img src="{source}" alt="" loading="lazy"><b>{escape(title)}</b><br>{text}</figure>'


def scene(found, rigs):
    """A scene's pictures: Cycles under every rig, klieg's own, and Cycles as klieg sees it."""
    best = max(rigs, key=lambda rig: found["rigs"][rig]["legibility"])
    parts = []
    for rig in rigs:
        values = {key: f"{found['rigs'][rig][key]:.3f}" for key in MEASURES}
        if rig == best:
            values["legibility"] = f'<span class="best">{values["legibility"]}</span>'
        parts.append(figure(found["name"], f"cycles-{rig}.png", rig, values))
    own = {key: f"{found['own'][key]:.3f}" for key in MEASURES if key in found["own"]}
    parts.append(figure(found["name"], "best.png", "klieg's own picture", own))
    parts += [
        figure(found["name"], picture, title, {"differs from klieg's by": f"{found['difference'][key]:.3f}"})
        for key, (picture, title) in VIEWS.items()
        if key in found["difference"]
    ]
    worse = "" if best == "design" else f' <span class="worse">{best} is more legible</span>'
    title = f'<h3 id="{escape(found["name"])}">{escape(found["name"])}{worse}</h3>'
    return title + '<div class="scene">' + "".join(parts) + "</div>"


def page(result, rigs):
    """The whole page, as HTML; pictures are named relative to it."""
    settings = ", ".join(f"{key} {value}" for key, value in result["settings"].items())
    count = len(result["scenes"])
    parts = [f"<h1>Designs judged in Cycles</h1><p>{count} scenes; {escape(settings)}</p>"]
    if count:
        parts += ["<h2>Medians</h2>", medians(result, rigs)]
        parts += [better(result["better"][what], what, count) for what in ("legibility", "F")]
    if result["failed"]:
        rows = [[escape(entry["name"]), escape(entry["reason"])] for entry in result["failed"]]
        parts += ["<h2>Not judged</h2>", table(["scene", "reason"], rows)]
    parts += [scene(found, rigs) for found in result["scenes"]]
    style = f"<!doctype html><meta charset=utf-8><title>klieg: judged</title><style>{STYLE}</style>"
    return style + "".join(parts) + "\n"
