"""Types of arguments and results, for type checkers."""

from collections.abc import Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Rows: TypeAlias = NDArray[np.void]
"""A structured array: one row per payload."""
Vector: TypeAlias = Sequence[float] | NDArray[np.floating[Any]]
"""Three numbers, m."""


class Result(TypedDict):
    """State of a goal."""

    state: int
    """A `GoalState`."""
    step: str
    """Last step."""
    reason: str
    """Reason of the failure; empty for a running or successful goal."""
    took_s: float
    f1_n: float
    f2_n: float
    stiffness_n_m: float
    friction: float
    lifted_m: float
    normal_n: list[float]


class JointSetpoints(TypedDict):
    """Joint set-points of a robot."""

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    in_force: bool
    """False when the last command has expired and its positions are only held."""
    mode: int
    """The daemon's `Mode`."""
    tick: int


class Replayed(TypedDict):
    """Comparison of a replay with its recording."""

    ticks: int
    different: int
    first_tick: int | None
    first_field: str | None
    reports: Rows
    commands: Rows


class Layout(TypedDict):
    """Positions (m) and axes of the elements of a fingertip, in the tip frame."""

    normal: NDArray[np.float64]
    tangent1: NDArray[np.float64]
    tangent2: NDArray[np.float64]
    position: NDArray[np.float64]
    hash: int
