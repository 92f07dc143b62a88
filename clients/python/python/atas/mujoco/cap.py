"""Threaded cap and its bottle.

MuJoCo has no screw joint between two free bodies. A cap is therefore a light carrier with a turning
and a travelling joint. A loose cap has both joints locked. An engaged cap has its carrier welded to
the bottle; it turns with the thread's friction, and travels by the thread's pitch:

    loose: rests on the rim, centred and upright ─▶ engaged ─▶ loose: pulled before the first turn

The rim touches a loose cap only: an engaged one travels down past it.

Limits and friction law are those of the built-in engine (`sim-backend/src/threaded_cap.rs`).
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .options import SUPPORT_TYPE, TABLE_FRICTION

CARRIER_SHARE = 0.1
"""Share of the cap's mass in the carrier. Design choice: light, and well conditioned."""
RIM_MARGIN_M = 0.003
"""Margin of the rim beyond the cap's radius, m."""
RIM_HALF_M = 0.002
"""Half thickness of the rim, m."""
CAPTURE_M, CAPTURE_TILT_RAD = 0.002, 0.087
"""Largest offset from the axis, m, and tilt, rad, at which threads engage."""
CAPTURE_WEIGHT = 0.5
"""Share of the cap's weight that must rest on the rim to engage."""
CENTRING_RAD = np.pi / 2
"""Turn over which the thread centres the cap, rad."""
PULL_SHARE = 0.5
"""Upward force over the cap's weight that removes it. Design choice: above the solver's residuals."""
LOOSE_RAD = 0.02
"""Turn below which a pull removes the cap, rad."""
DAMPING_N_M_S_RAD = 0.004
"""Damping of the thread (built-in engine)."""
STIFF = [0.001, 1.0]
THREAD_IMPEDANCE = [0.9999, 0.9999, 0.001, 0.5, 2.0]
"""Of turn and travel, the stiffest that MuJoCo has. It softens a coupling by the inverse inertia of both joints: with the default, that
of the turn let the cap travel by 1 mm under its own weight."""


def add_rim(bottle: Any, rim_m: float, cap_radius_m: float) -> None:
    """Adds the top of the neck, `rim_m` above the bottle's middle, as a support of the cap."""
    bottle.add_geom(
        name="rim",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[cap_radius_m + RIM_MARGIN_M, RIM_HALF_M, 0],
        pos=[0, 0, rim_m - RIM_HALF_M],
        mass=0,
        contype=SUPPORT_TYPE,
        conaffinity=0,
        friction=[TABLE_FRICTION, 0, 0],
        priority=2,
        solref=[0.002, 1.0],
        rgba=[0.45, 0.62, 0.8, 0.6],
    )


def add_joints(spec: Any, carrier: Any, bottle_name: str, thread: dict[str, Any]) -> Any:
    """Adds the cap's body with its joints to a carrier. Returns the body."""
    body = carrier.add_body(name=f"{carrier.name}-cap")
    body.add_joint(name="cap-travel", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1], armature=0.01)
    turn = body.add_joint(name="cap-turn", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    turn.armature, turn.frictionloss, turn.damping[0] = thread["inertia_kg_m2"], thread["friction_n_m"], DAMPING_N_M_S_RAD
    # Sticks: with the default, a thread creeps below its friction.
    turn.solref_friction, turn.solimp_friction = STIFF, [0.999, 0.9999, 0.001, 0.5, 2.0]
    for name, first, second in (("cap-lock", "cap-turn", None), ("cap-thread", "cap-travel", "cap-turn")):
        equality = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
        equality.name1, equality.solref = first, STIFF
        if second:
            equality.name2 = second
            equality.solimp = THREAD_IMPEDANCE
            equality.data[1] = -thread["sign"] * thread["pitch_m"] / (2 * np.pi)
    weld = spec.add_equality(name="cap-weld", type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
    weld.name1, weld.name2, weld.solref, weld.active = bottle_name, carrier.name, STIFF, False
    # Anchor, relative pose (position, quaternion), torque scale; `Cap` sets the pose.
    weld.data[:11] = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]
    return body


class CapParts:
    """Indices of cap, thread and bottle in one model: finding parts by name takes longer than a step without contact."""

    def __init__(self, model: Any, data: Any, bottle: int, cap: int) -> None:
        self.model, self.data = model, data
        turn, travel = model.joint("cap-turn").id, model.joint("cap-travel").id
        self.turn_qpos, self.travel_qpos = int(model.jnt_qposadr[turn]), int(model.jnt_qposadr[travel])
        self.turn_dof = int(model.jnt_dofadr[turn])
        self.rim = model.geom("rim").id
        self.lock, self.thread, self.weld = (model.equality(name).id for name in ("cap-lock", "cap-thread", "cap-weld"))
        self.bottle, self.carrier = model.body(f"object{bottle}").id, model.body(f"object{cap}").id
        self.qpos, self.qvel = data.qpos, data.qvel


class Cap:
    """State of the cap on its thread."""

    def __init__(self, scene: dict[str, Any]) -> None:
        objects = scene["objects"]
        self.index = next(index for index, thing in enumerate(objects) if thing["thread"])
        self.bottle = next(index for index, thing in enumerate(objects) if thing["neck"])
        cap, bottle = objects[self.index], objects[self.bottle]
        self._thread: dict[str, float] = cap["thread"]
        self._weight_n = cap["mass_kg"] * scene["gravity_m_s2"]
        self._engaged_m = engaged_height_m(cap, bottle)
        self._starts_engaged = bool(cap["on_neck"])
        self.engaged = False
        self._turn_rad = self._yaw_rad = 0.0
        self._remaining = np.nan
        self._offset_m, self._tilt_rad = np.zeros(3), np.zeros(3)

    def parts(self, model: Any, data: Any) -> CapParts:
        """Returns the parts of cap and thread in a model of the scene."""
        return CapParts(model, data, self.bottle, self.index)

    def begin(self, parts: CapParts) -> None:
        """Engages a cap that starts on the neck."""
        if self._starts_engaged:
            self._engage(parts)

    def update(self, parts: CapParts, rim_n: float) -> None:
        """Engages or releases the cap, and follows the thread. `rim_n` is the upward force of the rim on a loose cap."""
        if not self.engaged and rim_n >= CAPTURE_WEIGHT * self._weight_n and self._is_aligned(parts):
            self._engage(parts)
        elif self.engaged and self.angle_rad(parts) < LOOSE_RAD and _pull_n(parts) > PULL_SHARE * self._weight_n:
            self._release(parts)
        elif self.engaged:
            self._follow(parts)
        parts.model.geom_contype[parts.rim] = 0 if self.engaged else SUPPORT_TYPE

    def _follow(self, parts: CapParts) -> None:
        """Sets the weld and the thread's friction for the present angle."""
        angle = self.angle_rad(parts)
        self._weld(parts, angle)
        beyond = max(angle - self._thread["closing_rad"], 0.0)
        limit_n_m = self._thread["friction_n_m"] + self._thread["rise_n_m_rad"] * beyond
        # Damping, which keeps the solver from creeping, is a part of the friction.
        rate_rad_s = abs(float(parts.qvel[parts.turn_dof]))
        damping = min(DAMPING_N_M_S_RAD, limit_n_m / rate_rad_s) if rate_rad_s > 0 else DAMPING_N_M_S_RAD
        parts.model.dof_damping[parts.turn_dof] = damping
        parts.model.dof_frictionloss[parts.turn_dof] = limit_n_m - damping * rate_rad_s

    def angle_rad(self, parts: CapParts) -> float:
        """Angle since the engagement, closing positive, rad."""
        return float(self._thread["sign"] * (parts.qpos[parts.turn_qpos] - self._turn_rad))

    def state(self, parts: CapParts) -> NDArray[np.float64]:
        """Engaged, angle, torque of the cap on the bottle, as in the message."""
        if not self.engaged:
            return np.zeros(3)
        data, dof = parts.data, parts.turn_dof
        # The row of the only joint with friction follows those of the equalities.
        friction_n_m = float(data.efc_force[data.ne]) if data.nf else 0.0
        damper_n_m = -parts.model.dof_damping[dof] * parts.qvel[dof]
        return np.array([1.0, self.angle_rad(parts), -self._thread["sign"] * (friction_n_m + damper_n_m)])

    def _local(self, parts: CapParts) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Offset of the carrier from the engaged position, m, and its rotation, in the bottle's frame."""
        data, bottle, carrier = parts.data, parts.bottle, parts.carrier
        axes = data.xmat[bottle].reshape(3, 3)
        offset = axes.T @ (data.xpos[carrier] - data.xpos[bottle]) - [0, 0, self._engaged_m]
        return offset, axes.T @ data.xmat[carrier].reshape(3, 3)

    def _is_aligned(self, parts: CapParts) -> bool:
        offset, rotation = self._local(parts)
        lean = np.cross([0, 0, 1], rotation[:, 2])
        return bool(np.hypot(*offset[:2]) < CAPTURE_M and rotation[2, 2] > 0 and np.linalg.norm(lean) < CAPTURE_TILT_RAD)

    def _engage(self, parts: CapParts) -> None:
        self._offset_m, rotation = self._local(parts)
        self._tilt_rad = np.cross([0, 0, 1], rotation[:, 2])
        self._yaw_rad = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
        self._turn_rad = float(parts.qpos[parts.turn_qpos])
        data = parts.model.eq_data
        data[parts.thread, 0] = float(parts.qpos[parts.travel_qpos]) - data[parts.thread, 1] * self._turn_rad
        parts.data.eq_active[parts.lock] = False
        parts.data.eq_active[parts.weld] = True
        self.engaged, self._remaining = True, np.nan
        self._weld(parts, 0.0)

    def _release(self, parts: CapParts) -> None:
        parts.model.eq_data[parts.lock, 0] = float(parts.qpos[parts.turn_qpos])
        parts.data.eq_active[parts.lock] = True
        parts.data.eq_active[parts.weld] = False
        self.engaged = False

    def _weld(self, parts: CapParts, angle_rad: float) -> None:
        """Holds the carrier on the axis; offset and tilt at the engagement vanish over the first turn."""
        remaining = min(max(1.0 - angle_rad / CENTRING_RAD, 0.0), 1.0)
        if remaining == self._remaining:
            return
        self._remaining = remaining
        upright, lean, pose = np.zeros(4), np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(upright, np.array([0.0, 0.0, 1.0]), self._yaw_rad)
        tilt = remaining * self._tilt_rad
        size = float(np.linalg.norm(tilt))
        mujoco.mju_axisAngle2Quat(lean, tilt / size if size > 0 else np.array([1.0, 0.0, 0.0]), size)
        mujoco.mju_mulQuat(pose, lean, upright)
        weld = parts.model.eq_data[parts.weld]
        weld[3:6] = remaining * self._offset_m + [0, 0, self._engaged_m]
        weld[6:10] = pose


def _pull_n(parts: CapParts) -> float:
    """Upward force of the cap on the weld beyond its weight, N."""
    data = parts.data
    # Rows of equalities are the first.
    rows = np.flatnonzero(data.efc_id[: data.ne] == parts.weld)
    # The third row is the vertical force on the first body, the bottle.
    return float(data.efc_force[rows[2]]) if len(rows) else 0.0


def engaged_height_m(cap: dict[str, Any], bottle: dict[str, Any]) -> float:
    """Height of the cap's middle above the bottle's middle when the threads meet, m."""
    return float(bottle["neck"]["rim_m"] - half_height_m(bottle["shape"]) + half_height_m(cap["shape"]))


def half_height_m(shape: dict[str, Any]) -> float:
    """Half height of an object, m."""
    return float(shape["box"][2] if "box" in shape else shape["cylinder"][1])
