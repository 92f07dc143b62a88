"""What the package takes and gives, for those who check types."""

from collections.abc import Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Rows: TypeAlias = NDArray[np.void]
"""A structured array: one row per payload."""
Vector: TypeAlias = Sequence[float] | NDArray[np.floating[Any]]
"""Three numbers, m."""


class Result(TypedDict):
    """How a goal stands."""

    state: int
    """A `GoalState`."""
    step: str
    """The step that decided."""
    reason: str
    """Why it did not succeed; empty if it did or goes on."""
    took_s: float
    f1_n: float
    f2_n: float
    stiffness_n_m: float
    friction: float
    lifted_m: float
    normal_n: list[float]


class Orders(TypedDict):
    """What a robot's joints shall do."""

    position_rad: NDArray[np.float64]
    velocity_rad_s: NDArray[np.float64]
    in_force: bool
    """False when the last command has expired and its positions are only held."""
    mode: int
    """The daemon's `Mode`."""
    tick: int


class Replayed(TypedDict):
    """How far a replay agreed with its recording."""

    ticks: int
    different: int
    first_tick: int | None
    first_field: str | None
    reports: Rows
    commands: Rows


class Layout(TypedDict):
    """Where the elements of a fingertip sit (metres) and along which axes they feel, tip frame."""

    normal: NDArray[np.float64]
    tangent1: NDArray[np.float64]
    tangent2: NDArray[np.float64]
    position: NDArray[np.float64]
    hash: int
