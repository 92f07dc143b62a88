"""Names and values of a hand's observations and actions, for policies and data sets.

The names equal those of `atas export --to lerobot` and of the LeRobot plugin `lerobot_robot_atas`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _native

POSE = ("hand.x", "hand.y", "hand.z", "hand.yaw", "hand.opening")
ENVIRONMENT = (
    "object.x",
    "object.y",
    "object.z",
    "object.yaw",
    "object.width",
    "place.x",
    "place.y",
    "place.z",
)
_FINGER = ("normal_n", "tangential_n", "utilisation", "in_contact")
_GRIP = ("grip.f1_n", "grip.f2_n")
_COMPONENTS = ("fn", "ft1", "ft2")
_BOUNDS = {"hand.x": "x", "hand.y": "y", "hand.z": "z", "hand.opening": "opening"}


def _modules() -> list[tuple[int, str]]:
    """Number and name of each module: `slip` for "module 2, slip"."""
    codes = next(values for name, _doc, values in _native.codes() if name == "ModuleId")
    return [
        (number, (text.partition(", ")[2] or text).replace(" ", "_"))
        for _constant, number, text in codes
        if number != 0
    ]


MODULES = _modules()


class HandFeatures:
    """Features of one hand of a robot."""

    def __init__(self, model: str | None, hand: str, tactile: str, actions: str) -> None:
        self.kinematics = _native.Kinematics(model)
        self.hand, self.tactile, self.actions = hand, tactile, actions
        self.index = ("left", "right").index(hand)
        self.range = slice(*self.kinematics.joint_range(hand))
        self.joints = [f"{name}.pos" for name in self.kinematics.joint_names[self.range]]
        self.fingers = self.kinematics.fingertips(hand)
        self.bounds = self.kinematics.teleop_bounds(hand)

    def __repr__(self) -> str:
        return (
            f"<HandFeatures {self.hand!r} of {self.kinematics!r}: {self.fingers} fingertips, "
            f"tactile {self.tactile!r}, actions {self.actions!r}>"
        )

    def state_names(self) -> list[str]:
        """Names of the state, in order."""
        names = [*POSE, *self.joints]
        if self.tactile != "none":
            for finger in range(1, self.fingers + 1):
                names += [f"finger{finger}.{what}" for what in _FINGER]
            names += [*_GRIP, *(f"module.{name}" for _number, name in MODULES)]
        return names

    def taxel_names(self, elements: int) -> list[str]:
        """Names of the taxels, in order."""
        return [
            f"finger{finger}.element{element}.{axis}_n"
            for finger in range(1, self.fingers + 1)
            for element in range(elements)
            for axis in _COMPONENTS
        ]

    def action_names(self) -> list[str]:
        """Names of an action, in order."""
        return list(POSE) if self.actions == "pose" else list(self.joints)

    def state(self, position: Any, report: Any) -> dict[str, float]:
        """Values of the state, from joint positions of the whole robot and a `TickReport`."""
        position = np.asarray(position, float)[: len(self.kinematics.joint_names)]
        (x, y, z), yaw, opening = self.kinematics.pinch_pose(position, self.hand)
        values = [x, y, z, yaw, opening, *position[self.range]]
        if self.tactile != "none":
            hand = report["hands"][self.index]
            for finger in hand["fingers"][: self.fingers]:
                values += [finger[what] for what in _FINGER]
            values += [hand["f1_n"], hand["f2_n"]]
            active = int(hand["modules_active"])
            values += [active >> number & 1 for number, _name in MODULES]
        return {name: float(value) for name, value in zip(self.state_names(), values, strict=True)}

    def taxels(self, frame: Any, elements: int) -> dict[str, float]:
        """Values of the taxels, from a `HandFrame`: zero for an element without a valid value."""
        force_n = np.array(frame["force_n"][: self.fingers, :elements], float)
        for finger in range(self.fingers):
            mask = int(frame["valid_mask"][finger])
            force_n[finger, [element for element in range(elements) if not mask >> element & 1]] = 0.0
        names = self.taxel_names(elements)
        return dict(zip(names, map(float, force_n.ravel()), strict=True))

    def environment(self, item: Sequence[float] | None, place: Sequence[float] | None) -> dict[str, float]:
        """Values of the environment; zero if unknown."""
        values = [*(item or [0.0] * 5), *(place or [0.0] * 3)]
        return dict(zip(ENVIRONMENT, map(float, values), strict=True))

    def target(self, action: Mapping[str, Any]) -> dict[str, float]:
        """The pose that an action requests, within the bounds of teleoperation.

        Raises ValueError for a missing, unknown or not finite value.
        """
        names = self.action_names()
        missing, unknown = [n for n in names if n not in action], [n for n in action if n not in names]
        if missing or unknown:
            raise ValueError(
                f"action rejected: missing {missing or 'nothing'}, unknown {unknown or 'nothing'}; "
                f"needs {', '.join(names)}"
            )
        values = {name: float(action[name]) for name in names}
        for name, value in values.items():
            if not math.isfinite(value):
                raise ValueError(f"action rejected: {name} is {value}; needs a finite number")
        if self.actions == "joints":
            position = np.zeros(len(self.kinematics.joint_names))
            position[self.range] = list(values.values())
            (x, y, z), yaw, opening = self.kinematics.pinch_pose(position, self.hand)
            values = dict(zip(POSE, (x, y, z, yaw, opening), strict=True))
        for name, bound in _BOUNDS.items():
            least, most = self.bounds[bound]
            values[name] = min(max(values[name], least), most)
        return values

    def sent(self, action: Mapping[str, Any], target: Mapping[str, float]) -> dict[str, float]:
        """The action that was sent: the bounded pose, or the joints as requested."""
        if self.actions == "pose":
            return dict(target)
        return {name: float(action[name]) for name in self.joints}
