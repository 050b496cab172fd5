"""Views."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from klieg import _klieg
from klieg._errors import InputError
from klieg._scene import Scene
from klieg._settings import native


class View:
    """A camera and a picture's size in a scene: what is looked at, and the frame that lights stand in."""

    def __init__(
        self,
        scene: Scene,
        size: tuple[int, int] | None = None,
        *,
        camera: str | int | None = None,
        azimuth: float | None = None,
        elevation: float | None = None,
        fov: float | None = None,
        fill: float | None = None,
    ) -> None:
        """Look through a camera of the scene, or frame the whole scene.

        Without more words it is the camera that klieg wrote, else the scene's first, else a framing.

        Args:
            scene: the scene.
            size: width and height, pixels; 512 x 512, or what the file says beside a camera that klieg wrote.
            camera: name or index of a camera of the scene.
            azimuth: of a framing: 0 on the +Z axis, positive to +X, degrees.
            elevation: of a framing, degrees.
            fov: vertical field of view of a framing, degrees.
            fill: share of the picture's height or width that a framing fills, 0..1.

        Raises:
            InputError: for a camera that is not there and for values out of their ranges.

        """
        options = {"size": size, "camera": camera, "azimuth": azimuth, "elevation": elevation, "fov": fov, "fill": fill}
        self._native = _klieg.View.of_settings(scene._native, native(options))

    @classmethod
    def from_camera(
        cls,
        scene: Scene,
        world_from_camera: ArrayLike,
        size: tuple[int, int] = (512, 512),
        *,
        fov: float | None = None,
        half_height: float | None = None,
        near: float | None = None,
        far: float | None = None,
    ) -> View:
        """Look through a camera that a matrix places.

        Args:
            scene: the scene.
            world_from_camera: shape [4, 4]: the camera looks along its -Z axis, +Y is up, as in glTF and Blender. A
                scale is taken out.
            size: width and height, pixels.
            fov: vertical field of view of a perspective camera, degrees.
            half_height: half of the picture's height of an orthographic one, world units.
            near: distance of the near plane, world units; a thousandth of the scene's radius where absent.
            far: distance of the far plane; none where absent.

        Raises:
            InputError: for a matrix that is no pose, and a lens that shows nothing.

        """
        try:
            pose = np.array(world_from_camera, dtype=np.float64)
        except (TypeError, ValueError) as fault:
            raise InputError(f"world_from_camera: {fault}") from fault
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise InputError("world_from_camera must be 4 x 4 finite numbers")
        lengths = np.linalg.norm(pose[:3, :3], axis=0)
        if not (lengths > 0).all():
            raise InputError("world_from_camera has an axis of no length")
        turn = pose[:3, :3] / lengths
        matrix = np.eye(4)
        matrix[:3, :3] = turn.T
        matrix[:3, 3] = -turn.T @ pose[:3, 3]
        yfov = None if fov is None else math.radians(fov)
        if near is None:
            near = 0.0 if fov is None else scene.radius / 1000
        view = cls.__new__(cls)
        view._native = _klieg.View.of_matrix(scene._native, matrix.tolist(), yfov, half_height, near, far, size)
        return view

    @classmethod
    def look_at(
        cls,
        scene: Scene,
        eye: ArrayLike,
        target: ArrayLike | None = None,
        size: tuple[int, int] = (512, 512),
        *,
        up: ArrayLike = (0.0, 1.0, 0.0),
        fov: float = 35.0,
    ) -> View:
        """Look from a point at another one, by default the scene's centre.

        Args:
            scene: the scene.
            eye: shape [3], world units.
            target: shape [3], world units.
            size: width and height, pixels.
            up: what is above, shape [3].
            fov: vertical field of view, degrees.

        Raises:
            InputError: for a view along `up`, or from `eye` to itself.

        """
        place = np.asarray(eye, dtype=np.float64)
        middle = np.asarray(scene.center if target is None else target, dtype=np.float64)
        if place.shape != (3,) or middle.shape != (3,):
            raise InputError("eye and target must have 3 numbers")
        back = place - middle
        right = np.cross(np.asarray(up, dtype=np.float64), back)
        if not np.linalg.norm(right) > 0:
            raise InputError("eye and target are one, or the view is along up")
        pose = np.eye(4)
        pose[:3, :] = np.column_stack([right, np.cross(back, right), back, place])
        return cls.from_camera(scene, pose, size, fov=fov)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._native.size

    @property
    def camera(self) -> str:
        """The camera's name."""
        return self._native.camera

    @property
    def center(self) -> NDArray[np.float64]:
        """Centre of the scene and of the light frame, shape [3], world units."""
        return np.asarray(self._native.center)

    @property
    def radius(self) -> float:
        """Radius of the scene, the unit of lengths in the light frame, world units."""
        return self._native.radius

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """The camera's pose, shape [4, 4]: it looks along its -Z axis, +Y is up."""
        eye, right, up, back = self._native.pose
        pose = np.eye(4)
        pose[:3, :] = np.column_stack([right, up, back, eye])
        return pose

    @property
    def fov(self) -> float | None:
        """Vertical field of view, degrees; none of orthographic cameras."""
        yfov = self._native.lens[0]
        return None if yfov is None else math.degrees(yfov)

    @property
    def half_height(self) -> float | None:
        """Half of the picture's height of an orthographic camera, world units; none of perspective ones."""
        return self._native.lens[1]

    def __repr__(self) -> str:
        """Tell camera and size."""
        width, height = self.size
        return f"View({self.camera!r}, {width}x{height})"
