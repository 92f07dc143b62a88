"""Teleoperators `atas_keyboard` and `atas_leader`: they propose a pose of the hand.

Neither controls a force: the robot `atas` passes the pose to the daemon's teleoperation, whose
tactile modules keep the grip.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import atas
import numpy as np
from atas.features import POSE
from lerobot.teleoperators import Teleoperator, TeleoperatorConfig, make_teleoperator_from_config
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from .config import AtasKeyboardConfig, AtasLeaderConfig


KEYS = {
    "w": ("hand.x", 1.0),
    "s": ("hand.x", -1.0),
    "a": ("hand.y", 1.0),
    "d": ("hand.y", -1.0),
    "r": ("hand.z", 1.0),
    "f": ("hand.z", -1.0),
    "q": ("hand.yaw", 1.0),
    "e": ("hand.yaw", -1.0),
    "o": ("hand.opening", 1.0),
    "c": ("hand.opening", -1.0),
}
"""Value and direction of each key."""

STEP_MAX_S = 0.1
"""Longest time that one call integrates, s. Design choice: a paused program must not jump."""

WAIT_S = 1.0
"""Time to wait for a measured pose, s. Design choice: a thousand ticks of the daemon."""


def measured_pose(bus: str | None, hand: str, kinematics: atas.Kinematics) -> dict[str, float]:
    """The measured pose of a daemon's hand."""
    try:
        rows = atas.Bus(bus, role="lerobot-teleop").joint_states().wait(WAIT_S)
    except atas.BusError as cause:
        raise DeviceNotConnectedError(
            f"could not read the pose of the {hand} hand: {cause}; start the daemon, or set `start`"
        ) from cause
    if len(rows) == 0:
        raise DeviceNotConnectedError(
            f"could not read the pose of the {hand} hand: no joint state for {WAIT_S} s; start the "
            "robot and the daemon, or set `start`"
        )
    position = rows[-1]["position"][: len(kinematics.joint_names)]
    (x, y, z), yaw, opening = kinematics.pinch_pose(position, hand)
    return dict(zip(POSE, (x, y, z, yaw, opening), strict=True))


class _Proposer(Teleoperator):
    """Base of both teleoperators: the features and the start pose."""

    def __init__(self, config: Any) -> None:
        super().__init__(config)
        self.config = config
        self.pose: dict[str, float] | None = None

    @property
    def action_features(self) -> dict[str, Any]:
        """Pose and opening of the hand: float."""
        return dict.fromkeys(POSE, float)

    @property
    def feedback_features(self) -> dict[str, Any]:
        """None: the device has no actuators."""
        return {}

    @property
    def is_connected(self) -> bool:
        """True from `connect` to `disconnect`."""
        return self.pose is not None

    @property
    def is_calibrated(self) -> bool:
        """Always true: a pose needs no calibration."""
        return True

    def calibrate(self) -> None:
        """Does nothing."""

    def configure(self) -> None:
        """Does nothing."""

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Does nothing: see `feedback_features`."""

    def _start(self) -> dict[str, float]:
        if self.config.start is not None:
            return dict(zip(POSE, map(float, self.config.start), strict=True))
        return measured_pose(self.config.bus, self.config.hand, atas.Kinematics(self.config.model))

    def _require(self, connected: bool) -> None:
        if connected and not self.is_connected:
            raise DeviceNotConnectedError(f"{self} is not connected; call `connect` first")
        if not connected and self.is_connected:
            raise DeviceAlreadyConnectedError(f"{self} is connected already; call `disconnect` first")


class AtasKeyboard(_Proposer):
    """Keys move a pose at constant speed, within the bounds of teleoperation.

    `pressed` returns the pressed keys and replaces LeRobot's keyboard, for example for another
    input device.
    """

    config_class = AtasKeyboardConfig
    name = "atas_keyboard"

    def __init__(
        self,
        config: AtasKeyboardConfig,
        pressed: Callable[[], Iterable[Any]] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(config)
        self._pressed, self._clock = pressed, clock
        self._keyboard: Teleoperator | None = None
        self._before_s = 0.0
        self._bounds = atas.Kinematics(config.model).teleop_bounds(config.hand)

    def connect(self, calibrate: bool = True) -> None:
        """Opens the keyboard and takes the start pose."""
        self._require(connected=False)
        pose = self._start()
        if self._pressed is None:
            from lerobot.teleoperators.keyboard import KeyboardTeleop, KeyboardTeleopConfig

            self._keyboard = KeyboardTeleop(KeyboardTeleopConfig(id=self.id))
            self._keyboard.connect()
            if not self._keyboard.is_connected:
                raise DeviceNotConnectedError(
                    f"could not open the keyboard of {self}: LeRobot cannot capture keys here; it needs an X11 "
                    "session; use a leader arm instead"
                )
        self.pose, self._before_s = pose, self._clock()

    def get_action(self) -> dict[str, Any]:
        """The pose after the time since the last call; at most 0.1 s of motion."""
        self._require(connected=True)
        assert self.pose is not None
        keys = self._pressed() if self._pressed else self._keyboard.get_action()  # type: ignore[union-attr]
        now_s = self._clock()
        step_s = min(max(now_s - self._before_s, 0.0), STEP_MAX_S)
        self._before_s = now_s
        for key in set(keys):
            name, direction = KEYS.get(key, ("", 0.0))
            if name:
                self.pose[name] += direction * self._speed(name) * step_s
        for name, bound in (("hand.x", "x"), ("hand.y", "y"), ("hand.z", "z"), ("hand.opening", "opening")):
            least, most = self._bounds[bound]
            self.pose[name] = min(max(self.pose[name], least), most)
        return dict(self.pose)

    def disconnect(self) -> None:
        """Closes the keyboard."""
        self._require(connected=True)
        self.pose = None
        keyboard, self._keyboard = self._keyboard, None
        if keyboard is not None and keyboard.is_connected:
            keyboard.disconnect()

    def _speed(self, name: str) -> float:
        config = self.config
        special = {"hand.yaw": config.turn_rad_s, "hand.opening": config.opening_m_s}
        return float(special.get(name, config.speed_m_s))


def _make_leader(config: AtasLeaderConfig) -> Teleoperator:
    """The teleoperator of LeRobot that reads the leader arm."""
    import draccus

    known = TeleoperatorConfig.get_known_choices()
    if config.leader not in known:
        raise ValueError(
            f"configuration rejected: leader is {config.leader!r}; this program knows {', '.join(sorted(known))}"
        )
    options = draccus.decode(known[config.leader], config.leader_options)
    return make_teleoperator_from_config(options)


class AtasLeader(_Proposer):
    """A leader arm of LeRobot: its joints, by the kinematics of its robot file, give a pose.

    `leader` replaces the teleoperator of the configuration.
    """

    config_class = AtasLeaderConfig
    name = "atas_leader"

    def __init__(self, config: AtasLeaderConfig, leader: Teleoperator | None = None) -> None:
        super().__init__(config)
        self.leader = leader or _make_leader(config)
        self.kinematics = atas.Kinematics(config.model)
        self.leader_hand = config.leader_hand or config.hand
        self._origin: dict[str, float] | None = None
        unknown = sorted(set(config.joints.values()) - set(self.kinematics.joint_names))
        if unknown:
            raise ValueError(
                f"configuration rejected: the robot file has no joint {', '.join(unknown)}; "
                f"it has {', '.join(self.kinematics.joint_names)}"
            )

    def connect(self, calibrate: bool = True) -> None:
        """Connects the leader arm. With `relative`, its present pose is the start pose."""
        self._require(connected=False)
        start = self._start() if self.config.relative else None
        self.leader.connect(calibrate)
        try:
            origin = self._leader_pose(self.leader.get_action())
        except BaseException:
            self.leader.disconnect()
            raise
        self._origin, self.pose = origin, start or dict(origin)

    @property
    def is_calibrated(self) -> bool:
        """Whether the leader arm is calibrated."""
        return bool(self.leader.is_calibrated)

    def calibrate(self) -> None:
        """Calibrates the leader arm."""
        self.leader.calibrate()

    def get_action(self) -> dict[str, Any]:
        """The pose that the leader arm proposes."""
        self._require(connected=True)
        assert self.pose is not None and self._origin is not None
        now = self._leader_pose(self.leader.get_action())
        if not self.config.relative:
            return now
        proposed = dict(now)
        for name in ("hand.x", "hand.y", "hand.z"):
            proposed[name] = self.pose[name] + self.config.motion_scale * (now[name] - self._origin[name])
        turned = math.remainder(now["hand.yaw"] - self._origin["hand.yaw"], 2 * math.pi)
        proposed["hand.yaw"] = self.pose["hand.yaw"] + turned
        return proposed

    def disconnect(self) -> None:
        """Disconnects the leader arm."""
        self._require(connected=True)
        self.pose = self._origin = None
        self.leader.disconnect()

    def _leader_pose(self, values: Mapping[str, Any]) -> dict[str, float]:
        config = self.config
        names = self.kinematics.joint_names
        position = np.zeros(len(names))
        known = dict.fromkeys(names[slice(*self.kinematics.joint_range(self.leader_hand))], False)
        for key, value in values.items():
            joint = config.joints.get(key, key.removesuffix(".pos"))
            if joint in known and key != config.gripper:
                position[names.index(joint)] = float(value) * config.scale
                known[joint] = True
        if not any(known.values()):
            raise ValueError(
                f"leader arm rejected: none of its values {', '.join(map(str, values))} belongs to a joint "
                f"of the {self.leader_hand} hand: {', '.join(known)}; set `joints`"
            )
        (x, y, z), yaw, opening = self.kinematics.pinch_pose(position, self.leader_hand)
        if config.gripper is not None:
            if config.gripper not in values:
                raise ValueError(
                    f"leader arm rejected: it has no value {config.gripper!r}; it has {', '.join(map(str, values))}"
                )
            closed, open_ = config.gripper_range
            share = min(max((float(values[config.gripper]) - closed) / (open_ - closed), 0.0), 1.0)
            least, most = config.opening_range_m
            opening = least + share * (most - least)
        return dict(zip(POSE, (x, y, z, yaw, opening), strict=True))
