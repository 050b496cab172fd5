"""klieg finds the lights that make a 3D scene easiest to see.

>>> import klieg
>>> result = klieg.design("scene.glb")
>>> result.save_gltf("lit.glb")

`docs/PYTHON.md` leads through the package; `klieg.design` and `klieg.Evaluator` are where to begin.
"""

from klieg._design import Design, Progress, design
from klieg._device import Device, DeviceInfo, devices
from klieg._errors import Error, InputError
from klieg._evaluator import Evaluator
from klieg._klieg import __version__
from klieg._light import LIGHT_COLUMNS, Light
from klieg._scene import Mesh, Scene, SceneLight
from klieg._settings import Objective, optimizers, profiles, terms
from klieg._view import View

__all__ = [
    "LIGHT_COLUMNS",
    "Design",
    "Device",
    "DeviceInfo",
    "Error",
    "Evaluator",
    "InputError",
    "Light",
    "Mesh",
    "Objective",
    "Progress",
    "Scene",
    "SceneLight",
    "View",
    "__version__",
    "design",
    "devices",
    "optimizers",
    "profiles",
    "terms",
]
