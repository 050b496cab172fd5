"""Pictures of lit scenes by three.js in headless Chromium, with the script of klieg's tests."""

import base64
import io
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

SOURCE = Path(__file__).parents[2] / "tests" / "three"
PATIENCE = 180


class Three:
    """three.js, ready to render."""

    def __init__(self):
        """Installs what is missing into this Python's environment; exits where that cannot be."""
        names = [os.environ["CHROMIUM"]] if os.environ.get("CHROMIUM") else ["chromium", "chromium-browser", "google-chrome"]
        self.chromium = next(filter(None, map(shutil.which, names)), None)
        if not self.chromium:
            sys.exit(f"judge: --three needs Chromium or Chrome, and there is no {' or '.join(names)}: install it, or set CHROMIUM")
        if not (shutil.which("node") and shutil.which("npm")):
            sys.exit("judge: --three needs Node.js 18 or later and npm: install them")
        self.folder = Path(sys.prefix) / "three"
        self.folder.mkdir(exist_ok=True)
        for name in ("package.json", "render.mjs"):
            shutil.copyfile(SOURCE / name, self.folder / name)
        command = ["npm", "install", "--no-package-lock", "--no-audit", "--no-fund", "--silent"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"judge: npm could not install what --three needs: {done.stderr.strip()[-500:]}")

    def render(self, scene, size):
        """What three.js makes of the scene's last camera: encoded sRGB in 0..1. Raises ValueError where it cannot."""
        command = ["node", self.folder / "render.mjs", self.chromium, scene, f"{size}x{size}"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            raise ValueError(f"three.js: no picture within {PATIENCE} s") from None
        if done.returncode != 0:
            raise ValueError(f"three.js: {done.stderr.strip()[-300:]}")
        png = base64.b64decode(json.loads(done.stdout)["shipped"])
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")) / 255
