"""Window and pictures of the scene."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .model import Model
from .options import Options

if TYPE_CHECKING:
    from .world import World

FRAME_S = 1 / 30
"""Period of the window's frames, s."""
PICTURE_S = 0.5
"""Period of pictures, s."""
SIZE = (960, 720)


class Show:
    """Shows the running scene as the options request.

    The simulated model changes when a hand comes near an object. A model of its own, which has all
    skins, shows the motion of each of them.
    """

    def __init__(self, options: Options) -> None:
        self._options = options
        self._window: Any = None
        self._renderer: Any = None
        self._shown: Model | None = None
        self._frame_due_s = self._picture_due_s = 0.0
        self._count = 0

    def begin(self, world: World) -> None:
        """Shows another scene from its beginning."""
        if not self._options.viewer and self._options.pictures is None:
            return
        self._frame_due_s = self._picture_due_s = 0.0
        self._shown = shown = world.shown_model()
        if self._options.viewer:
            import mujoco.viewer

            if self._window is not None:
                self._window.close()
            self._window = mujoco.viewer.launch_passive(shown.model, shown.data)
            self._aim(self._window.cam)
        if self._options.pictures is not None:
            self._options.pictures.mkdir(parents=True, exist_ok=True)
            shown.model.vis.global_.offwidth, shown.model.vis.global_.offheight = SIZE
            if self._renderer is not None:
                self._renderer.close()
            self._renderer = renderer(shown.model)

    def update(self, world: World) -> None:
        """Shows the present state if a frame is due."""
        shown, now_s = self._shown, float(world.data.time)
        if shown is None or now_s < min(self._frame_due_s, self._picture_due_s):
            return
        shown.take_motion(world.now)
        self._frame_due_s = now_s + FRAME_S
        if self._window is not None and self._window.is_running():
            self._window.sync()
        if self._renderer is not None and self._options.pictures is not None and now_s >= self._picture_due_s:
            camera = mujoco.MjvCamera()
            self._aim(camera)
            self._renderer.update_scene(shown.data, camera)
            path = self._options.pictures / f"{self._count:05d}.png"
            path.write_bytes(png(self._renderer.render()))
            self._count += 1
            self._picture_due_s = now_s + PICTURE_S

    def _aim(self, camera: Any) -> None:
        """Points a camera at the first object."""
        assert self._shown is not None
        camera.lookat[:] = self._shown.first_object_m
        camera.distance, camera.azimuth, camera.elevation = 0.5, 140, -20


def renderer(model: Any) -> Any:
    """Creates the off-screen renderer. Raises ValueError without OpenGL."""
    try:
        return mujoco.Renderer(model, height=SIZE[1], width=SIZE[0])
    except (mujoco.FatalError, AttributeError, ImportError, RuntimeError) as error:
        raise ValueError(f"pictures need OpenGL: {error}; install libegl1 or libosmesa6 and set MUJOCO_GL to egl or osmesa") from error


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Encodes pixels (height, width, 3) as PNG."""
    height, width, _ = pixels.shape
    lines = np.zeros((height, 1 + 3 * width), dtype=np.uint8)
    lines[:, 1:] = pixels.reshape(height, -1)

    def part(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + part(b"IDAT", zlib.compress(lines.tobytes())) + part(b"IEND", b"")
