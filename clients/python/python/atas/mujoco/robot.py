"""Builds a robot with drives and tactile skins from a scene description.

Each moving frame of the robot is a body with one joint. A joint carries the reflected inertia of its
drive; links have next to no mass, because gravity is compensated and the drives' inertia dominates. A
mimicking frame follows its joint by an equality constraint.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from .options import PIN_MASS_KG, PIN_RADIUS_M, PIN_RADIUS_SHARE, PIN_STIFFENING, SHEAR_RATIO, SKIN_DAMPING_S, Options

LINK_KG = 1e-5
"""Mass of a link, kg: MuJoCo needs one. Design choice: negligible beside a drive's inertia, and 20 links weigh 2 mN, so that no
gravity compensation is needed, which costs a Jacobian per body."""
ROBOT_GROUP = 2
"""Geometry group of the parts that only show the robot."""
CARRIER_MASS_KG = 0.01
"""Inertia of a fingertip's carrier, kg. Design choice: light beside objects that are not soft, and stable."""
RIGID_N_M = 1e5
"""Stiffness of the carrier against a rigid object, N/m. Design choice: stable, and ten times the stiffness of the skin."""
BASE_INERTIA_KG = 100.0
"""Inertia of a base that tremor and bumps move, kg. Design choice: contact forces move it by nanometres per step."""
DAMPING_SHARE = 1.0
"""Largest damping times step over inertia of a carrier or pin. The solver computes contact forces before implicit damping acts: at
a share of 20, the fingertips oscillated at 129 Hz on a bottle; up to 1 they do not, with steps of 125 to 500 µs."""


def bounded_damping(damping: Any, mass_kg: float, step_s: float) -> Any:
    """Damping that the solver can simulate, N·s/m."""
    return np.minimum(damping, DAMPING_SHARE * mass_kg / step_s)


@dataclass
class Names:
    """Names of the parts of a robot, in the order of the messages."""

    joints: list[str] = field(default_factory=list)
    bases: list[str] = field(default_factory=list)
    pins: list[str] = field(default_factory=list)
    tip_of_pin: list[int] = field(default_factory=list)
    element_of_pin: list[int] = field(default_factory=list)
    axes_of_pin: list[Any] = field(default_factory=list)
    stiffness_of_pin: list[float] = field(default_factory=list)
    elements: list[int] = field(default_factory=list)
    tips: list[str] = field(default_factory=list)
    carriers: list[str] = field(default_factory=list)
    tip_of_carrier: list[int] = field(default_factory=list)


def quaternion(rotation: Any) -> Any:
    """Quaternion w, x, y, z of a rotation matrix."""
    result = np.zeros(4)
    mujoco.mju_mat2Quat(result, np.asarray(rotation, dtype=float).ravel())
    return result


def set_inertia(body: Any, mass_kg: float, inertia_kg_m2: list[float], centre_m: Any = (0.0, 0.0, 0.0)) -> None:
    """Sets mass, moments of inertia along the body's axes, and centre of mass. Geometries add nothing."""
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos, body.iquat = mass_kg, inertia_kg_m2, centre_m, [1.0, 0.0, 0.0, 0.0]


def turned_about_z(rotation: Any, angle_rad: float) -> Any:
    """The rotation, followed by a turn about its z axis."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray(rotation) @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


def add_robot(spec: Any, hands: list[dict[str, Any]], options: Options, has_soft_object: bool, skins: tuple[bool, bool]) -> Names:
    """Adds both hands to a model; `skins` selects the hands with tactile skin."""
    names = Names()
    for side, hand, has_skin in zip(("left", "right"), hands, skins, strict=True):
        bodies = _add_hand(spec, side, hand, options, names)
        for index, fingertip in enumerate(hand["fingertips"]):
            parent = bodies[-1] if fingertip["frame"] is None else bodies[fingertip["frame"]]
            tip = _add_fingertip(parent, f"{side}-tip{index}", fingertip, names)
            if has_skin:
                _add_skin(tip, f"{side}-tip{index}", fingertip, options, has_soft_object, names)
    return names


def _add_hand(spec: Any, side: str, hand: dict[str, Any], options: Options, names: Names) -> list[Any]:
    """Returns the bodies of the moving frames, and the base as the last one. A saved model has a fixed base."""
    base = spec.worldbody.add_body(name=f"{side}-base")
    if options.save is None:
        set_inertia(base, LINK_KG, [LINK_KG * 1e-4] * 3)
        base.add_joint(name=f"{side}-base", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1], armature=BASE_INERTIA_KG)
        names.bases.append(f"{side}-base")
    bodies: list[Any] = []
    driven: dict[int, str] = {}
    for index, frame in enumerate(hand["frames"]):
        parent = base if frame["parent"] is None else bodies[frame["parent"]]
        bodies.append(_add_frame(spec, parent, f"{side}-frame{index}", frame, hand["joints"][frame["joint"]], driven))
    names.joints += [driven[index] for index in range(len(hand["joints"]))]
    return [*bodies, base]


def _add_frame(
    spec: Any, parent: Any, name: str, frame: dict[str, Any], joint: dict[str, Any], driven: dict[int, str]
) -> Any:
    rotation, position = np.asarray(frame["rotation"]), np.asarray(frame["position_m"])
    if frame["slides"]:
        position = position + rotation[:, 2] * frame["offset"]
    else:
        rotation = turned_about_z(rotation, frame["offset"])
    body = parent.add_body(name=name, pos=position, quat=quaternion(rotation))
    set_inertia(body, LINK_KG, [LINK_KG * 1e-4] * 3)
    kind = mujoco.mjtJoint.mjJNT_SLIDE if frame["slides"] else mujoco.mjtJoint.mjJNT_HINGE
    moving = body.add_joint(name=name, type=kind, axis=[0, 0, 1])
    if frame["joint"] in driven:
        moving.armature = 0.01 * joint["inertia_kg_m2"]
        coupling = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
        coupling.name1, coupling.name2 = name, driven[frame["joint"]]
        coupling.data[:2] = [0.0, frame["ratio"]]
        coupling.solref = [0.001, 1.0]
    else:
        driven[frame["joint"]] = name
        _add_drive(spec, moving, joint)
    _add_link(parent, position)
    return body


def _add_drive(spec: Any, moving: Any, joint: dict[str, Any]) -> None:
    moving.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    moving.range = [joint["lower"], joint["upper"]]
    moving.armature = joint["inertia_kg_m2"]
    limit = joint["effort_max"]
    drive = spec.add_actuator(name=moving.name, target=moving.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    drive.gaintype, drive.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    stiffness, damping = joint["stiffness"], joint["damping"]
    drive.gainprm[0] = stiffness
    drive.biasprm[:3] = [0.0, -stiffness, -damping]
    drive.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    drive.forcerange = [-limit, limit]


def _add_link(parent: Any, to: Any) -> None:
    """Shows a link as a capsule from its frame to the next."""
    if np.linalg.norm(to) > 1e-3:
        parent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, *to],
            size=[0.012, 0, 0],
            group=ROBOT_GROUP,
            contype=0,
            conaffinity=0,
            mass=0,
            rgba=[0.75, 0.77, 0.8, 1.0],
        )


def _add_fingertip(parent: Any, name: str, fingertip: dict[str, Any], names: Names) -> Any:
    tip = parent.add_body(name=name, pos=fingertip["position_m"], quat=quaternion(fingertip["rotation"]))
    set_inertia(tip, LINK_KG, [LINK_KG * 1e-4] * 3)
    _add_link(parent, fingertip["position_m"])
    names.tips.append(name)
    names.elements.append(fingertip["elements"])
    return tip


def _add_skin(tip: Any, name: str, fingertip: dict[str, Any], options: Options, has_soft_object: bool, names: Names) -> None:
    index = len(names.tips) - 1
    if has_soft_object:
        # The compliance of a soft object under one fingertip, in series with the skin along the dome's axis.
        joint = tip.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1], armature=CARRIER_MASS_KG)
        joint.stiffness[0] = RIGID_N_M
        names.carriers.append(name)
        names.tip_of_carrier.append(index)
    for number, pin in enumerate(_pins(fingertip["pins"], options.pins)):
        _add_pin(tip, f"{name}-pin{number}", pin, options)
        names.pins.append(f"{name}-pin{number}")
        names.tip_of_pin.append(index)
        names.element_of_pin.append(pin["element"])
        names.axes_of_pin.append([pin["normal"], *pin["tangents"]])
        names.stiffness_of_pin.append(pin["stiffness_n_m"])


def _pins(pins: list[dict[str, Any]], per_element: int) -> list[dict[str, Any]]:
    """Divides each pin into equal ones on a circle with the second moment of area of the element's disc."""
    divided = []
    for pin in pins:
        position, normal, tangents = (np.asarray(pin[key]) for key in ("position_m", "normal", "tangents"))
        circle_m = np.sqrt(pin["area_m2"] / (2 * np.pi)) if per_element > 1 else 0.0
        distance_m = np.linalg.norm(position)
        is_dome = np.allclose(position, distance_m * normal)
        radius_m = PIN_RADIUS_SHARE / np.sqrt(per_element) * distance_m if is_dome else PIN_RADIUS_M
        # On a dome of radius R, spheres of radius r touch over a larger area than points: R / (R - r).
        share = PIN_STIFFENING * (1 - radius_m / distance_m) if is_dome else 1.0
        for number in range(per_element):
            angle = 2 * np.pi * number / per_element
            place = position + circle_m * np.array([np.cos(angle), np.sin(angle)]) @ tangents
            outward = place / np.linalg.norm(place) if is_dome else normal
            along = tangents - np.outer(tangents @ outward, outward)
            divided.append(
                pin
                | {
                    "position_m": outward * distance_m if is_dome else place,
                    "normal": outward,
                    "tangents": along / np.linalg.norm(along, axis=1, keepdims=True),
                    "stiffness_n_m": pin["stiffness_n_m"] * share / per_element,
                    "radius_m": radius_m,
                }
            )
    return divided


def _add_pin(tip: Any, name: str, pin: dict[str, Any], options: Options) -> None:
    normal = np.asarray(pin["normal"])
    body = tip.add_body(name=name, pos=np.asarray(pin["position_m"]) - pin["radius_m"] * normal)
    mass_kg = PIN_MASS_KG / options.pins
    for axis, ratio, suffix in zip((normal, *pin["tangents"]), (1.0, SHEAR_RATIO, SHEAR_RATIO), "nxy", strict=True):
        stiffness = ratio * pin["stiffness_n_m"]
        joint = body.add_joint(name=f"{name}-{suffix}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, armature=mass_kg)
        joint.stiffness[0] = stiffness
        joint.damping[0] = bounded_damping(SKIN_DAMPING_S * stiffness, mass_kg, options.step_us * 1e-6)
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[pin["radius_m"], 0, 0],
        mass=1e-6,
        contype=0,
        conaffinity=0,
        rgba=[0.2, 0.25, 0.3, 1.0],
    )
