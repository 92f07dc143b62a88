"""Configuration of the robots and teleoperators, registered with LeRobot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import atas
from lerobot.cameras import CameraConfig
from lerobot.robots import RobotConfig
from lerobot.teleoperators import TeleoperatorConfig

TACTILE = ("none", "summary", "taxels")
ACTIONS = ("pose", "joints")


def _check_choice(what: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"configuration rejected: {what} is {value!r}; needs one of {', '.join(known)}")


def _check_numbers(what: str, values: list[float] | None, names: str) -> None:
    count = len(names.split(", "))
    if values is None:
        return
    if len(values) != count or not all(math.isfinite(value) for value in values):
        raise ValueError(f"configuration rejected: {what} is {values}; needs {count} finite numbers: {names}")


def _check_range(what: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise ValueError(f"configuration rejected: {what} is {value}; needs {least} to {most}")


@dataclass(kw_only=True)
class _HandConfig:
    """Options of both robots."""

    # Hand: "left" or "right".
    hand: str = "right"
    # Tactile part of the observation: "none", "summary" (forces, friction, modules) or "taxels"
    # (summary and the force of every sensor element).
    tactile: str = "summary"
    # Sensor elements per fingertip, for "taxels": those of the daemon's sensor layout.
    elements: int = 41
    # Form of an action: "pose" (x, y, z, yaw, opening) or "joints" (joint positions of the hand).
    actions: str = "pose"
    # Expected object: x, y, z (m), yaw (rad), width (m). Part of the observation; zero if unknown.
    object: list[float] | None = None
    # Place of the object: x, y, z (m). Part of the observation; zero if unknown.
    place: list[float] | None = None
    # Cameras, which LeRobot reads.
    cameras: dict[str, CameraConfig] = field(default_factory=dict)

    def check(self) -> None:
        """Raises ValueError for an invalid option."""
        _check_choice("hand", self.hand, ("left", "right"))
        _check_choice("tactile", self.tactile, TACTILE)
        _check_choice("actions", self.actions, ACTIONS)
        _check_range("elements", self.elements, 1, atas.ELEMENTS)
        _check_numbers("object", self.object, "x, y, z, yaw, width")
        _check_numbers("place", self.place, "x, y, z")


@RobotConfig.register_subclass("atas")
@dataclass(kw_only=True)
class AtasConfig(_HandConfig, RobotConfig):
    """Hand of a running daemon."""

    # Bus of the daemon; default: the environment variable ATAS_BUS, else "atas".
    bus: str | None = None
    # Robot: a built-in name, or the path of a robot file. It must be the daemon's robot.
    model: str | None = None
    # Time after the last action after which the hand brakes and keeps its grip, s. At most 2.
    # Too small, and a slow policy stops the hand between two actions.
    valid_s: float = 0.4
    # Start a new teleoperation after the daemon has ended one, for example because the object
    # was lost. False raises an error instead.
    restart: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check()
        _check_range("valid_s", self.valid_s, 0.01, 2.0)


@RobotConfig.register_subclass("atas_simulation")
@dataclass(kw_only=True)
class AtasSimulationConfig(_HandConfig, RobotConfig):
    """Simulated hand and object in this process. Equal seeds and actions give equal bits."""

    # Built-in object, or the path of an object file.
    item: str = "wood"
    # Seed of the object's variation and of the sensor noise.
    seed: int = 0
    # Actions per second; divides 1000. Each action runs the simulation for one period.
    fps: int = 50
    # False removes the reflex for comparison: touch is never detected, so that the hand executes
    # the commanded openings.
    reflex: bool = True
    # Factor on the sensor noise.
    noise: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check()
        if not (0 < self.fps <= 1000 and 1000 % self.fps == 0):
            raise ValueError(
                f"configuration rejected: fps is {self.fps}; needs a divisor of 1000, for example 50"
            )


@dataclass(kw_only=True)
class _StartConfig:
    """Options of both teleoperators."""

    # Hand: "left" or "right".
    hand: str = "right"
    # First pose: x, y, z (m), yaw (rad), opening (m). Default: the measured pose, from the bus.
    start: list[float] | None = None
    # Bus of the daemon, for the measured pose.
    bus: str | None = None

    def check(self) -> None:
        """Raises ValueError for an invalid option."""
        _check_choice("hand", self.hand, ("left", "right"))
        _check_numbers("start", self.start, "x, y, z, yaw, opening")


@TeleoperatorConfig.register_subclass("atas_keyboard")
@dataclass(kw_only=True)
class AtasKeyboardConfig(_StartConfig, TeleoperatorConfig):
    """Keys: w/s x, a/d y, r/f z, q/e yaw, o/c opening."""

    # Speed of the hand, m/s.
    speed_m_s: float = 0.05
    # Speed of the yaw, rad/s.
    turn_rad_s: float = 0.5
    # Speed of the opening, m/s.
    opening_m_s: float = 0.02
    # Robot whose bounds limit the pose: a built-in name, or the path of a robot file.
    model: str | None = None

    def __post_init__(self) -> None:
        self.check()
        for name in ("speed_m_s", "turn_rad_s", "opening_m_s"):
            _check_range(name, getattr(self, name), 0.0, 10.0)


@TeleoperatorConfig.register_subclass("atas_leader")
@dataclass(kw_only=True)
class AtasLeaderConfig(_StartConfig, TeleoperatorConfig):
    """Leader arm: a teleoperator of LeRobot whose joints belong to a robot file."""

    # Type of the teleoperator that reads the leader arm, for example so101_leader, and its options,
    # for example {port: /dev/ttyACM0, id: leader}. Not a nested configuration: LeRobot's parser
    # lists the options of all teleoperators within each other without end.
    leader: str = ""
    leader_options: dict[str, Any] = field(default_factory=dict)
    # Robot file of the leader arm, or a built-in name.
    model: str | None = None
    # Hand of the leader arm; default: `hand`.
    leader_hand: str | None = None
    # Joint of the robot file for each value of the leader. Default: a value "NAME.pos" belongs to
    # the joint NAME.
    joints: dict[str, str] = field(default_factory=dict)
    # Factor from a leader's value to the joint's unit. LeRobot's arms report degrees.
    scale: float = math.pi / 180.0
    # Value of the leader's gripper, which sets the opening; None takes the opening of the model.
    gripper: str | None = None
    # Values of the closed and of the open gripper, and the openings that they request, m.
    gripper_range: list[float] = field(default_factory=lambda: [0.0, 100.0])
    opening_range_m: list[float] = field(default_factory=lambda: [0.0, 0.1])
    # True: the hand follows the leader's displacement since `connect`. False: its pose.
    relative: bool = True
    # Factor on the displacement.
    motion_scale: float = 1.0

    def __post_init__(self) -> None:
        self.check()
        if not self.leader or self.leader == "atas_leader":
            raise ValueError(
                f"configuration rejected: leader is {self.leader!r}; needs the type of a leader arm, for example "
                "--teleop.leader=so101_leader"
            )
        _check_choice("leader_hand", self.leader_hand or self.hand, ("left", "right"))
        _check_numbers("gripper_range", self.gripper_range, "closed, open")
        _check_numbers("opening_range_m", self.opening_range_m, "closed, open")
        if self.gripper_range[0] == self.gripper_range[1]:
            raise ValueError(
                f"configuration rejected: gripper_range is {self.gripper_range}; needs two different values"
            )
        _check_range("motion_scale", self.motion_scale, 0.01, 10.0)
        if not math.isfinite(self.scale) or self.scale == 0.0:
            raise ValueError(f"configuration rejected: scale is {self.scale}; needs a finite number other than 0")
