"""`gymnasium` environments with the in-process simulator: a policy controls one hand and its two grasp sides.

Actions pass the daemon's kinematics and safety gate; observed forces come from its perception. Rewards use the simulator's ground
truth. One step is 20 ms. Equal seeds and actions give equal bits, single or vectorised, on any number of cores.
`render_mode="rgb_array"` draws pictures, `render_mode="human"` shows them in a window.

Observation, a dict of float32 arrays, SI units:

* ``taxels`` (2, 41, 3): force of the object on each taxel, N: normal, tangential 1, tangential 2
* ``joints`` (11, 3): position, velocity, effort of each joint of the hand: rad, rad/s, N·m, or m, m/s, N
* ``percept`` (2, 6): per fingertip F_n N, F_t N, dF_t N, friction utilisation, friction coefficient, 1 during contact
* ``modules`` (4,): 1 while the module is active: first touch, slip, force limit, relax
* ``hand`` (8,): hand centre relative to the nominal grasp (x, y, z, m), half opening per grasp side (m), target relative to the centre (m)

The shapes are those of the default robot. Another `robot` has its own numbers of fingertips, taxels and joints.

Action, 5 numbers from -1 to 1: speed of the hand along x, y and z (1 is 0.1 m/s), closing speed of each grasp side (1 is 20 mm/s).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._native import Batch, Environment
from .window import Picture, Window

Row = NDArray[np.float32]
Observation = dict[str, Row]
Infos = dict[str, Any]

Parts = list[tuple[str, list[int], list[float], list[float]]]

RENDER_SIZE = (640, 480)
"""Default width and height of a picture, px."""
RENDER_HZ = 50
"""Pictures per second of a window: one per step, in real time."""


def _spaces(parts: Parts) -> tuple[Any, Any]:
    """Spaces of observations and actions."""

    def box(shape: Sequence[int], low: Sequence[float], high: Sequence[float]) -> spaces.Box:
        low_, high_ = (np.asarray(bound, np.float32).reshape(shape) for bound in (low, high))
        return spaces.Box(low_, high_, dtype=np.float32)

    told = spaces.Dict({name: box(shape, low, high) for name, shape, low, high in parts})
    return told, spaces.Box(-1.0, 1.0, (5,), np.float32)


def _split(parts: Parts, rows: Row) -> Observation:
    """Splits rows into the parts of an observation, as views."""
    told, begin = {}, 0
    for name, shape, _low, _high in parts:
        end = begin + int(np.prod(shape))
        told[name] = rows[..., begin:end].reshape(*rows.shape[:-1], *shape)
        begin = end
    return told


def _check_render_mode(mode: str | None, known: Sequence[str]) -> None:
    if mode is not None and mode not in known:
        raise ValueError(f"environment rejected: render_mode is {mode!r}, needs {' or '.join(map(repr, known))}")


def _check_noise(noise: float) -> None:
    if not 0.0 <= noise < float("inf"):
        raise ValueError(f"environment rejected: noise is {noise}, needs a finite number of at least 0")


class HandEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """One environment.

    `objects` are built-in names or paths of TOML files; by default, those that fit into the hand. `noise` scales the sensor noise.
    `robot` is a built-in robot or the path of a robot file; its acting hand moves. `render_mode` is "rgb_array" or "human",
    `render_size` the width and height of a picture, px.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": RENDER_HZ}

    def __init__(
        self,
        task: str,
        *,
        objects: Sequence[str] | None = None,
        noise: float = 1.0,
        robot: str | None = None,
        render_mode: str | None = None,
        render_size: tuple[int, int] = RENDER_SIZE,
    ) -> None:
        _check_noise(noise)
        _check_render_mode(render_mode, self.metadata["render_modes"])
        self._environment = Environment(task, None if objects is None else list(objects), noise, robot)
        self._parts = self._environment.parts()
        self.observation_space, self.action_space = _spaces(self._parts)
        self.render_mode, self._render_size = render_mode, render_size
        self._window = Window(f"ATAS {task}") if render_mode == "human" else None
        self._begun = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, Infos]:
        super().reset(seed=seed)
        if seed is None and not self._begun:
            seed = int(self.np_random.integers(2**63))
        self._begun = True
        row, info = self._environment.reset(seed)
        self._show()
        return _split(self._parts, row), info

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, Infos]:
        row, reward, terminated, truncated, info = self._environment.step(action)
        self._show()
        return _split(self._parts, row), reward, terminated, truncated, info

    def render(self) -> Picture | None:
        """Draws the hand and the object. Returns an array (height, width, 3) of uint8 with "rgb_array", otherwise None.

        Fingertips are green, objects blue, or red after a failure; the table has a grid of 100 mm. With "human", `reset` and `step`
        show each picture, and this method does nothing.
        """
        return self._draw() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            self._window.close()

    def _draw(self) -> Picture:
        return self._environment.render(*self._render_size)

    def _show(self) -> None:
        if self._window is not None and self._window.is_open:
            self._window.show(self._draw(), RENDER_HZ)

    def __repr__(self) -> str:
        mode = f", render_mode {self.render_mode!r}" if self.render_mode else ""
        return f"<{type(self).__name__} {self._environment!r}{mode}>"

    # gymnasium prints this text of the innermost environment.
    __str__ = __repr__


class GraspEnv(HandEnv):
    """Grasp the object between the fingertips, lift it by 40 mm and hold it for 0.5 s. A crushed or dropped object ends the episode."""

    def __init__(self, **options: Any) -> None:
        super().__init__("grasp", **options)


class PickPlaceEnv(HandEnv):
    """Move the object to the target in ``hand``, 12 cm away, and release it there. The true height differs by up to 10 mm."""

    def __init__(self, **options: Any) -> None:
        super().__init__("pick-place", **options)


class HandVectorEnv(VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """Several environments, stepped by Rust threads (`threads`, 0 for one per core).

    With `autoreset` (default), an environment starts the next episode in the step after the end and ignores that step's action.
    Without it, the environment does nothing until `reset`. Other options are those of `HandEnv`, except for the window.
    """

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        *,
        objects: Sequence[str] | None = None,
        noise: float = 1.0,
        threads: int = 0,
        autoreset: bool = True,
        robot: str | None = None,
        render_mode: str | None = None,
        render_size: tuple[int, int] = RENDER_SIZE,
    ) -> None:
        _check_noise(noise)
        _check_render_mode(render_mode, ["rgb_array"])
        if num_envs < 1:
            raise ValueError(f"environments rejected: num_envs is {num_envs}, needs at least 1")
        if threads < 0:
            raise ValueError(f"environments rejected: threads is {threads}, needs 0 (one per core) or more")
        mode = AutoresetMode.NEXT_STEP if autoreset else AutoresetMode.DISABLED
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": RENDER_HZ, "autoreset_mode": mode}
        self.num_envs = num_envs
        names = None if objects is None else list(objects)
        self._batch = Batch(task, num_envs, names, noise, threads, autoreset, robot)
        self._parts = self._batch.parts()
        self.render_mode, self._render_size = render_mode, render_size
        self.single_observation_space, self.single_action_space = _spaces(self._parts)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._begun = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, Infos]:
        """Starts an episode in each: environment `i` with `seed + i` or `seed[i]`; without a seed, the next of its series."""
        if seed is None and not self._begun:
            seed = int(self.np_random.integers(2**62))
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        elif isinstance(seed, int):
            super().reset(seed=seed)
            seeds = [seed + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        self._begun = True
        rows, infos = self._batch.reset(seeds)
        return _split(self._parts, rows), _masked(infos)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], Infos]:
        rows, infos = self._batch.step(actions)
        reward, terminated, truncated = (infos.pop(key) for key in ("reward", "terminated", "truncated"))
        return _split(self._parts, rows), reward, terminated, truncated, _masked(infos)


    def render(self) -> tuple[Picture, ...] | None:
        """Draws each environment; see `HandEnv.render`. Returns None without render_mode "rgb_array"."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(self._batch.render(index, *self._render_size) for index in range(self.num_envs))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.num_envs}: {self._batch!r}>"


def _masked(infos: Infos) -> Infos:
    """Adds gymnasium's mask for each key: the environments that it applies to."""
    for key in ("reward", "terminated", "truncated"):
        infos.pop(key, None)
    infos["end"] = np.array(infos["end"])
    return infos | {f"_{key}": np.ones(len(values), np.bool_) for key, values in infos.items()}


class GraspVectorEnv(HandVectorEnv):
    """Vectorised `GraspEnv`."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__("grasp", num_envs, **options)


class PickPlaceVectorEnv(HandVectorEnv):
    """Vectorised `PickPlaceEnv`."""

    def __init__(self, num_envs: int = 1, **options: Any) -> None:
        super().__init__("pick-place", num_envs, **options)


def register() -> None:
    """Registers the environments with gymnasium."""
    for name, one, many in (
        ("atas/Grasp-v0", "GraspEnv", "GraspVectorEnv"),
        ("atas/PickPlace-v0", "PickPlaceEnv", "PickPlaceVectorEnv"),
    ):
        if name not in gymnasium.registry:
            room = "atas.environments:"
            gymnasium.register(name, entry_point=room + one, vector_entry_point=room + many)
