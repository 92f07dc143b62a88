"""Options of the engine and constants of its models."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

SHEAR_RATIO = 0.7
"""Tangential over normal stiffness of a pin. Mindlin's theory gives 0.7 to 1 for rubber on a flat; as in `atas-sim`."""
SKIN_DAMPING_S = 0.002
"""Damping over stiffness of a pin, s; as in `atas-sim`."""
PIN_MASS_KG = 2e-3
"""Inertia of a pin along each of its axes, kg. Design choice: its natural frequency (160 Hz) is far below the step rate and above the
skin's own bandwidth of 80 Hz. With half of it, sliding pins chatter at steps of 500 µs."""
PIN_RADIUS_M = 0.0015
"""Radius of a pin's tip on a flat face, m. Design choice: smaller than half of the distance of elements."""
PIN_RADIUS_SHARE = 0.25
"""Radius of a pin's tip over a dome's radius and the root of the pins per element. Fine tips touch one after the other, so that the
stiffness of a light contact varies with the place. At 0.1 the controller measured caps of 25 mm as soft, at 0.25 as stiff."""
PIN_STIFFENING = 1.14
"""Factor on the stiffness of a dome's pins. Calibrated: oblique pins also bend and the contact yields, so that the sum was 12 % below
the closed form."""
CONTACT_TIME_S = 0.004
"""Time constant of the contact between pin and object, s. Design choice: eight steps; the contact is still 20 times as stiff as a pin.
At two steps, the solver's least, the force of sliding fingertips scattered by 30 %, at eight by 4 %."""
OBJECT_TYPE, SUPPORT_TYPE = 1, 2
"""Collision bits: supports touch objects. Pins touch objects by explicit pairs, which costs less than a search; nothing else touches."""
TABLE_FRICTION = 0.3
"""Friction coefficient of table and plates; as in `atas-sim`."""
OBJECT_DAMPING_S = 0.005
"""Damping over stiffness of a soft object, s; as in `atas-sim`."""


@dataclass(frozen=True)
class Options:
    """Options of a run."""

    step_us: float = 500.0
    """Length of a simulation step, µs; divides the tick of 1 ms."""
    pins: int = 1
    """Pins per element: 1 or 3."""
    effort_noise: float = 0.0005
    """Standard deviation of the measured joint torque over the drive's maximum."""
    joint_friction: float = 0.002
    """Coulomb friction of a joint over the drive's maximum torque."""
    viewer: bool = False
    """True: show the scene in a window."""
    pictures: Path | None = None
    """Folder for pictures."""
    save: Path | None = None
    """File for the model as MJCF."""


@dataclass(frozen=True)
class RobotOptions:
    """Arguments of `atas-mujoco robot`."""

    robot: str
    """Name of a built-in robot, or path of a robot file."""
    out: Path
    """File for the model as MJCF."""
    pins: int
    """Pins per element: 1 or 3."""


def parse(arguments: list[str]) -> Options:
    """Parses the arguments of the engine."""
    default = Options()
    parser = argparse.ArgumentParser(prog="mujoco", description="Engine options: --engine 'mujoco --step-us 250'")
    parser.add_argument("--step-us", type=float, default=default.step_us, help="simulation step in µs, divides 1000 [%(default)s]")
    parser.add_argument("--pins", type=int, choices=(1, 3), default=default.pins, help="pins per tactile element [%(default)s]")
    parser.add_argument(
        "--effort-noise", type=float, default=default.effort_noise, help="noise of measured torques over their maximum [%(default)s]"
    )
    parser.add_argument(
        "--joint-friction", type=float, default=default.joint_friction, help="joint friction over the maximum torque [%(default)s]"
    )
    parser.add_argument("--viewer", action="store_true", help="show the scene in a window")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="write a picture every 0.5 s to this folder")
    parser.add_argument("--save", type=Path, metavar="FILE", help="write the model to this file (MJCF)")
    options = Options(**vars(parser.parse_args(arguments)))
    substeps = 1000 / options.step_us if options.step_us > 0 else 0.5
    if not 1 <= substeps <= 100 or substeps != round(substeps):
        parser.error(f"--step-us is {options.step_us}, needs 1000 divided by 1 to 100, for example 500")
    for name in ("effort_noise", "joint_friction"):
        value = getattr(options, name)
        if not 0 <= value <= 0.1:
            parser.error(f"--{name.replace('_', '-')} is {value}, needs 0 to 0.1")
    return options


def parse_robot(arguments: list[str]) -> RobotOptions:
    """Parses the arguments of `atas-mujoco robot`."""
    parser = argparse.ArgumentParser(prog="atas-mujoco robot", description="Write a robot with its tactile skins as MuJoCo model")
    parser.add_argument("robot", metavar="NAME|FILE", help="built-in robot or robot file")
    parser.add_argument("--out", type=Path, default=Path("robot.xml"), metavar="FILE", help="MJCF file [%(default)s]")
    parser.add_argument("--pins", type=int, choices=(1, 3), default=1, help="pins per tactile element [%(default)s]")
    return RobotOptions(**vars(parser.parse_args(arguments)))
