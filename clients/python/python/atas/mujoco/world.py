"""World of one scene: advances MuJoCo by ticks."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .cap import Cap, CapParts
from .model import Model
from .options import OBJECT_DAMPING_S, Options
from .robot import BASE_INERTIA_KG, CARRIER_MASS_KG, DAMPING_SHARE, RIGID_N_M, bounded_damping

NEAR_M = 0.003
"""Distance of a skin from an object at which its pins are simulated, m. Design choice: no part of the robot moves 3 mm between two
checks."""
CHECK_TICKS = 4
"""Ticks between two checks of this distance."""
FAR_M = 0.006
"""Distance at which they are no longer simulated, m. Above `NEAR_M`, so that a resting hand changes the model once."""
FRICTION_SPEED = 0.005
"""Speed at which a joint's friction is 76 % of its Coulomb value, rad/s or m/s. Design choice: the friction acts as a torque of
the state, because a constraint per joint triples the time of a step without contact. A joint of little inertia has a larger one."""


class Failed(Exception):
    """A scene or tick that is discarded: the solver warned, or the model cannot be built."""


class World:
    """Simulated scene."""

    def __init__(self, scene: dict[str, Any], options: Options) -> None:
        # By default, MuJoCo appends its warnings to a file in the working directory.
        mujoco.set_mju_user_warning(lambda text: print(f"MuJoCo: {text}", file=sys.stderr))
        self._scene, self._options = scene, options
        self._models: dict[tuple[bool, bool], Model] = {}
        self._cap_parts: dict[tuple[bool, bool], CapParts] = {}
        self._substeps = round(scene["tick_s"] * 1e6 / options.step_us)
        self._random = np.random.default_rng(scene["seed"])
        joints = [joint for hand in scene["hands"] for joint in hand["joints"]]
        stiffness = np.array([joint["stiffness"] for joint in joints])
        self._feed_forward = np.array([joint["damping"] for joint in joints]) / stiffness
        self._noise_n_m = options.effort_noise * np.array([joint["effort_max"] for joint in joints])
        self._reference = np.array([joint["start"] for joint in joints])
        tips = [fingertip for hand in scene["hands"] for fingertip in hand["fingertips"]]
        self._hand_of_tip = np.array([side for side, hand in enumerate(scene["hands"]) for _ in hand["fingertips"]], dtype=int)
        self._reach_m = np.array([max(float(np.linalg.norm(pin["position_m"])) for pin in tip["pins"]) for tip in tips])
        self._friction_n_m = options.joint_friction * np.array([joint["effort_max"] for joint in joints])
        steady = self._friction_n_m * options.step_us * 1e-6 / (DAMPING_SHARE * np.array([joint["inertia_kg_m2"] for joint in joints]))
        self._friction_speed = np.maximum(FRICTION_SPEED, steady)
        has = [any(thing[part] for thing in scene["objects"]) for part in ("thread", "neck")]
        self._cap = Cap(scene) if all(has) else None
        self._support_n: NDArray[np.float64] = np.zeros(len(scene["objects"]))
        self._nearest: NDArray[np.int64] = np.zeros(len(tips), dtype=np.int64)
        self._tick = 0
        # A saved model has all skins.
        self._now = self._model((options.save is not None,) * 2)
        self._now.set_joints(self._reference)
        mujoco.mj_forward(self._now.model, self._now.data)
        if self._cap is not None:
            self._cap.begin(self._cap_parts[self._now.skins])

    @property
    def model(self) -> Any:
        """The present MuJoCo model."""
        return self._now.model

    @property
    def data(self) -> Any:
        """The present MuJoCo state."""
        return self._now.data

    @property
    def now(self) -> Model:
        """The present model with its state."""
        return self._now

    def shown_model(self) -> Model:
        """A further model with all skins, to show the motion."""
        return Model(self._scene, self._options, (True, True))

    def advance(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Simulates one tick; returns the state at its end. Raises `Failed` if the solver warned."""
        if self._tick % CHECK_TICKS == 0:
            self._choose_model()
        self._tick += 1
        now, model, data = self._now, self.model, self.data
        joints, objects = len(now.qpos), len(now.bodies)
        target, velocity, rest = values[:joints], values[joints : 2 * joints], values[2 * joints :]
        data.xfrc_applied[now.bodies, :3] = rest[2 : 2 + 3 * objects].reshape(-1, 3)
        self._set_compliance(rest[2 + 3 * objects :])
        if self._cap is not None:
            self._cap.update(self._cap_parts[now.skins], self._support_n[self._cap.index])
        begin, way = self._reference + self._feed_forward * velocity, target - self._reference
        ctrl, applied, qvel = data.ctrl, data.qfrc_applied, now.qvel_now
        self._push_on_bases(rest[:2])
        for step in range(self._substeps):
            # As a drive interpolates: the position of the substep's begin, and the velocity.
            ctrl[now.drives] = begin + way * (step / self._substeps)
            applied[now.dof] = -self._friction_n_m * np.tanh(qvel[now.dof] / self._friction_speed)
            mujoco.mj_step(model, data)
            if step == 0:
                applied[now.base_dof] = 0.0
        self._reference = target.copy()
        warnings = data.warning.number
        if warnings.any():
            raise Failed(f"MuJoCo warned: {mujoco.mjtWarning(int(warnings.argmax())).name} at {data.time:.3f} s")
        return self._state()

    def _model(self, skins: tuple[bool, bool]) -> Model:
        if skins not in self._models:
            added = self._models[skins] = Model(self._scene, self._options, skins)
            if self._cap is not None:
                self._cap_parts[skins] = self._cap.parts(added.model, added.data)
        return self._models[skins]

    def _choose_model(self) -> None:
        """Simulates the skins of the hands that are near an object."""
        now, data = self._now, self.data
        if len(now.bodies) == 0:
            return
        # A stiffness that changed with each touch would drive an oscillation: its spring would be tensed by one and relaxed by another.
        distances_m, self._nearest = now.contacts.nearest(data)
        nearest_m = distances_m - self._reach_m
        left, right = (
            bool((nearest_m[self._hand_of_tip == side] < (FAR_M if has_skin else NEAR_M)).any())
            for side, has_skin in enumerate(now.skins)
        )
        if (left, right) != now.skins:
            following = self._model((left, right))
            following.take_motion(now)
            self._now = following

    def _push_on_bases(self, target_m: NDArray[np.float64]) -> None:
        """Applies a force for one step, after which the bases reach the displacement of tremor and bumps at the end of the tick.

        Contact forces follow velocities: a base that jumped would slide along an object without friction.
        """
        now, step_s, applied = self._now, self._options.step_us * 1e-6, self.data.qfrc_applied
        for qpos, dof, base_m in zip(now.base_qpos, now.base_dof, target_m, strict=False):
            velocity_m_s = (base_m - now.qpos_now[qpos]) / (self._substeps * step_s)
            applied[dof] = BASE_INERTIA_KG * (velocity_m_s - now.qvel_now[dof]) / step_s

    def _set_compliance(self, stiffness: NDArray[np.float64]) -> None:
        """Gives each fingertip's carrier the stiffness of the object that it touches or will touch first."""
        carriers = self._now.carriers
        if len(carriers) == 0:
            return
        n_m = np.minimum(stiffness[self._nearest[self._now.tip_of_carrier]], RIGID_N_M)
        self.model.jnt_stiffness[carriers] = n_m
        damping = bounded_damping(OBJECT_DAMPING_S * n_m, CARRIER_MASS_KG, self.model.opt.timestep)
        self.model.dof_damping[self.model.jnt_dofadr[carriers]] = damping

    def _state(self) -> NDArray[np.float64]:
        now, data = self._now, self.data
        effort = data.actuator_force[now.drives] + self._noise_n_m * self._random.standard_normal(len(now.drives))
        elements_n, normal_n, slip_m, touched, self._support_n = now.contacts.read(data)
        parts = [
            now.qpos_now[now.qpos],
            now.qvel_now[now.dof],
            effort,
            elements_n,
            normal_n,
            slip_m,
            touched,
            *self._objects(),
            np.zeros(3) if self._cap is None else self._cap.state(self._cap_parts[now.skins]),
        ]
        state = np.concatenate(parts)
        # A sum is finite if its terms are, and takes less time than a look at each.
        if not np.isfinite(state.sum()):
            raise Failed(f"a value is not finite at {data.time:.3f} s")
        return state

    def _objects(self) -> Iterator[NDArray[np.float64]]:
        """Pose, velocity and support force of each object."""
        now, data = self._now, self.data
        for index, body in enumerate(now.bodies):
            velocity = np.zeros(6)
            mujoco.mj_objectVelocity(self.model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
            yield from (data.xpos[body], data.xquat[body], velocity[3:], velocity[:3], self._support_n[index : index + 1])

