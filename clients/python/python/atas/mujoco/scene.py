"""Builds table, plates and objects from a scene description."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from .cap import CARRIER_SHARE, add_joints, add_rim, engaged_height_m, half_height_m
from .options import CONTACT_TIME_S, OBJECT_TYPE, SUPPORT_TYPE, TABLE_FRICTION
from .robot import quaternion, set_inertia

COLOURS = [[0.78, 0.6, 0.38, 1.0], [0.45, 0.62, 0.8, 0.6], [0.6, 0.75, 0.5, 1.0], [0.8, 0.5, 0.5, 1.0]]
SUPPORT_SOLREF = [0.002, 1.0]
"""Contact of objects with table and plates: stiff, without bounce."""


def add_scene(spec: Any, scene: dict[str, Any]) -> list[str]:
    """Adds table, plates and objects to a model. Returns the names of the objects' bodies."""
    world = spec.worldbody
    sky = {"type": mujoco.mjtTexture.mjTEXTURE_SKYBOX, "builtin": mujoco.mjtBuiltin.mjBUILTIN_GRADIENT}
    spec.add_texture(name="sky", rgb1=[0.95, 0.97, 1.0], rgb2=[0.6, 0.7, 0.8], width=64, height=384, **sky)
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    world.add_light(pos=[0, 0, 2], dir=[0, 0, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    support = {"contype": SUPPORT_TYPE, "conaffinity": 0, "friction": [TABLE_FRICTION, 0.0, 0.0], "solref": SUPPORT_SOLREF, "priority": 2}
    world.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], rgba=[0.72, 0.72, 0.7, 1], **support)
    for index, plate in enumerate(scene["plates"]):
        half = plate["height_m"] / 2
        if half > 0:
            size, at = [*plate["half_m"], half], [*plate["centre_m"], half]
            world.add_geom(
                name=f"plate{index}", type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=at, rgba=[0.6, 0.6, 0.62, 1], **support
            )
    bottle = next((index for index, thing in enumerate(scene["objects"]) if thing["neck"]), None)
    for index, thing in enumerate(scene["objects"]):
        _add_object(spec, index, thing, scene, bottle)
    return [f"object{index}" for index in range(len(scene["objects"]))]


def _add_object(spec: Any, index: int, thing: dict[str, Any], scene: dict[str, Any], bottle: int | None) -> None:
    foot_m = 0.0
    for plate in scene["plates"]:
        inside = [abs(thing["position_m"][axis] - plate["centre_m"][axis]) <= plate["half_m"][axis] for axis in (0, 1)]
        foot_m = max(foot_m, plate["height_m"] if all(inside) else 0.0)
    middle_m = foot_m + half_height_m(thing["shape"])
    is_cap = thing["thread"] is not None and bottle is not None
    if is_cap and thing["on_neck"]:
        below = scene["objects"][bottle]
        middle_m = half_height_m(below["shape"]) + engaged_height_m(thing, below)
    body = spec.worldbody.add_body(name=f"object{index}", pos=[*thing["position_m"], middle_m], quat=_yaw(thing["yaw_rad"]))
    if not thing["clamped"]:
        body.add_freejoint(name=f"object{index}")
    if thing["neck"] and (cap := next((other for other in scene["objects"] if other["thread"]), None)):
        add_rim(body, thing["neck"]["rim_m"] - half_height_m(thing["shape"]), cap["shape"]["cylinder"][0])
    if not is_cap:
        _add_geometry(body, index, thing)
        return
    carrier_kg = CARRIER_SHARE * thing["mass_kg"]
    set_inertia(body, carrier_kg, [share * CARRIER_SHARE for share in _inertia(thing)])
    cap_body = add_joints(spec, body, f"object{bottle}", thing["thread"])
    _add_geometry(cap_body, index, thing | {"mass_kg": thing["mass_kg"] - carrier_kg})


def _add_geometry(body: Any, index: int, thing: dict[str, Any]) -> None:
    box = thing["shape"].get("box")
    cylinder = thing["shape"].get("cylinder")
    set_inertia(body, thing["mass_kg"], _inertia(thing), thing["centre_of_mass_m"])
    body.add_geom(
        name=f"object{index}",
        type=mujoco.mjtGeom.mjGEOM_BOX if box else mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=box or [*cylinder, 0],
        contype=OBJECT_TYPE,
        conaffinity=SUPPORT_TYPE,
        rgba=COLOURS[index % len(COLOURS)],
    )


def add_contacts(spec: Any, scene: dict[str, Any], pins: list[str]) -> None:
    """Lets each pin touch each object."""
    for index, thing in enumerate(scene["objects"]):
        for pin in pins:
            spec.add_pair(
                geomname1=pin,
                geomname2=f"object{index}",
                condim=3,
                friction=[thing["friction"]] * 2 + [0.0] * 3,
                solref=[CONTACT_TIME_S, 1.0],
                solimp=[0.995, 0.999, 0.0001, 0.5, 2.0],
            )


def _inertia(thing: dict[str, Any]) -> list[float]:
    mass_kg, shape = thing["mass_kg"], thing["shape"]
    if "box" in shape:
        x, y, z = (half * half for half in shape["box"])
        return [mass_kg / 3 * (y + z), mass_kg / 3 * (x + z), mass_kg / 3 * (x + y)]
    radius, half = shape["cylinder"]
    about_x = mass_kg * (radius * radius / 4 + half * half / 3)
    return [about_x, about_x, mass_kg * radius * radius / 2]


def _yaw(angle_rad: float) -> Any:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return quaternion([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
