"""Window and pictures of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco

from .options import Options

if TYPE_CHECKING:
    from .world import World

FRAME_S = 1 / 30
"""Period of the window's frames, s."""
PICTURE_S = 0.5
"""Period of pictures, s."""
SIZE = (960, 720)


class Show:
    """Shows the running scene as the options request."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._window: Any = None
        self._renderer: Any = None
        self._world: World | None = None
        self._due_s = 0.0
        self._count = 0

    def begin(self, world: World) -> None:
        """Shows another scene from its beginning."""
        self._world, self._due_s, self._count = world, 0.0, 0
        if self._options.viewer:
            import mujoco.viewer

            if self._window is not None:
                self._window.close()
            self._window = mujoco.viewer.launch_passive(world.model, world.data)
            self._aim(self._window.cam)
        if self._options.pictures is not None:
            self._options.pictures.mkdir(parents=True, exist_ok=True)
            world.model.vis.global_.offwidth, world.model.vis.global_.offheight = SIZE
            self._renderer = mujoco.Renderer(world.model, height=SIZE[1], width=SIZE[0])

    def update(self) -> None:
        """Shows the present state if a frame is due."""
        world = self._world
        if world is None or world.data.time < self._due_s:
            return
        if self._window is not None and self._window.is_running():
            self._window.sync()
            self._due_s = world.data.time + FRAME_S
        if self._renderer is not None and self._options.pictures is not None:
            camera = mujoco.MjvCamera()
            self._aim(camera)
            self._renderer.update_scene(world.data, camera)
            path = self._options.pictures / f"{self._count:05d}.ppm"
            pixels = self._renderer.render()
            path.write_bytes(b"P6 %d %d 255\n" % SIZE + pixels.tobytes())
            self._count += 1
            self._due_s = world.data.time + PICTURE_S

    def _aim(self, camera: Any) -> None:
        """Points a camera at the first object."""
        assert self._world is not None
        camera.lookat[:] = self._world.first_object_m
        camera.distance, camera.azimuth, camera.elevation = 0.5, 140, -20
