"""What a wheel has to do in an environment that has nothing else: `make wheel` runs it."""

import sys
import tempfile
from pathlib import Path

import klieg

scene = klieg.Scene.load(sys.argv[1])
result = klieg.design(scene, klieg.View(scene, (64, 64)), device="cpu", generations=3, population=6)
assert result.score < result.headlight_score
with tempfile.TemporaryDirectory() as folder:
    result.save_gltf(Path(folder) / "lit.glb")
    assert "klieg camera" in klieg.Scene.load(Path(folder) / "lit.glb").cameras
    assert len(result.save(Path(folder) / "out")) == 7
print(f"klieg {klieg.__version__}: {result}")
