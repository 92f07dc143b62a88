"""Compiled models of a scene: with the tactile skins of some hands, or of none.

Pins cost time also without contact. A scene is therefore simulated with the skins of those hands only
that are near an object. `Model.take_motion` continues the motion of another model of the same scene.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .._native import Contacts
from .options import SHEAR_RATIO, Options
from .robot import Names, add_robot
from .scene import add_contacts, add_scene


def build(scene: dict[str, Any], options: Options, skins: tuple[bool, bool]) -> tuple[Any, Names, list[str]]:
    """Returns the model of a scene with the skins of the left and the right hand, and the names of its parts."""
    spec = mujoco.MjSpec()
    spec.modelname = "atas"
    spec.compiler.degree = False
    spec.option.timestep = options.step_us * 1e-6
    spec.option.gravity = [0, 0, -scene["gravity_m_s2"]]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 200.0
    # Contacts are fewer than joints: the dual solver takes half of the time of Newton's method, with equal results.
    spec.option.solver = mujoco.mjtSolver.mjSOL_PGS
    # Forces and poses of a grasp differ from those of 3000 iterations by the same 0.003 (root mean square, N and m) as with 1e-8.
    spec.option.tolerance = 1e-6
    has_soft_object = any(thing["stiffness_n_m"] is not None for thing in scene["objects"])
    # The solver eliminates joints from last to first. Pins after objects couple only with their arm and an object.
    objects = add_scene(spec, scene)
    names = add_robot(spec, scene["hands"], options, has_soft_object, skins)
    add_contacts(spec, scene, names.pins)
    model = spec.compile()
    if options.save is not None:
        options.save.write_text(spec.to_xml())
    return model, names, objects


class Model:
    """Model with its state, and the indices of its parts in the order of the messages."""

    def __init__(self, scene: dict[str, Any], options: Options, skins: tuple[bool, bool]) -> None:
        self.skins = skins
        self.model, names, objects = build(scene, options, skins)
        self.data = mujoco.MjData(self.model)
        self.qpos_now, self.qvel_now = self.data.qpos, self.data.qvel
        """Views of the state: getting them from MuJoCo takes longer than reading them."""
        self._find_joints(names)
        self._find_contacts(names, scene, objects)

    def _find_joints(self, names: Names) -> None:
        model = self.model
        index = [model.joint(name).id for name in names.joints]
        self.qpos, self.dof = model.jnt_qposadr[index], model.jnt_dofadr[index]
        self.drives = [model.actuator(name).id for name in names.joints]
        bases = [model.joint(name).id for name in names.bases]
        self.base_qpos, self.base_dof = model.jnt_qposadr[bases], model.jnt_dofadr[bases]
        # The solver's tolerance scales with the mean inertia, to which the bases do not belong.
        model.stat.meaninertia = float(np.delete(model.dof_M0, self.base_dof).mean())
        self.tip_bodies = np.array([model.body(name).id for name in names.tips], dtype=int)
        self.carriers = np.array([model.joint(name).id for name in names.carriers], dtype=int)
        self.tip_of_carrier = np.array(names.tip_of_carrier, dtype=int)
        joints = [model.joint(index).name for index in range(model.njnt)]
        # All but pins and carriers are parts of every model of the scene.
        self._shared = [name for name in joints if "-tip" not in name]

    def _find_contacts(self, names: Names, scene: dict[str, Any], objects: list[str]) -> None:
        model = self.model
        self.bodies = np.array([model.geom(name).bodyid[0] for name in objects], dtype=int)
        object_of_geom = np.full(model.ngeom, -1)
        object_of_geom[[model.geom(name).id for name in objects]] = np.arange(len(objects))
        sizes = [next(iter(thing["shape"].values())) for thing in scene["objects"]]
        first = np.concatenate([[0], np.cumsum(names.elements)]).astype(int)
        pins = zip(names.pins, names.tip_of_pin, names.element_of_pin, names.stiffness_of_pin, names.axes_of_pin, strict=True)
        self.contacts = Contacts(
            list(zip(self.bodies.tolist(), sizes, strict=True)),
            object_of_geom.tolist(),
            self.tip_bodies.tolist(),
            int(first[-1]),
            [self._pin(name, tip, int(first[tip] + element), n_m, axes) for name, tip, element, n_m, axes in pins],
        )

    def _pin(self, name: str, tip: int, element: int, stiffness_n_m: float, axes: Any) -> tuple[Any, ...]:
        """Returns the description of a pin for `Contacts`."""
        model = self.model
        joints = [model.joint(f"{name}-{axis}").id for axis in "nxy"]
        dof = model.jnt_dofadr[joints]
        stiffness = [stiffness_n_m * ratio for ratio in (1.0, SHEAR_RATIO, SHEAR_RATIO)]
        addresses = model.jnt_qposadr[joints].tolist(), dof.tolist()
        return model.geom(name).id, tip, element, *addresses, stiffness, model.dof_damping[dof].tolist(), np.asarray(axes).tolist()

    @property
    def first_object_m(self) -> NDArray[np.float64]:
        """Position of the first object, or a place before the robot, m."""
        return np.array(self.data.xpos[self.bodies[0]]) if len(self.bodies) else np.array([0.3, 0.0, 0.1])

    def set_joints(self, position: NDArray[np.float64]) -> None:
        """Places the joints, and mimicking frames where their joints put them."""
        model, data = self.model, self.data
        data.qpos[self.qpos] = position
        for equality in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
            follower, leader = model.eq_obj1id[equality], model.eq_obj2id[equality]
            offset, ratio = model.eq_data[equality][:2]
            data.qpos[model.jnt_qposadr[follower]] = offset + ratio * data.qpos[model.jnt_qposadr[leader]]

    def take_motion(self, other: Model) -> None:
        """Continues the motion of another model; pins start relaxed."""
        data, source = self.data, other.data
        mujoco.mj_resetData(self.model, data)
        data.time = source.time
        data.xfrc_applied[self.bodies] = source.xfrc_applied[other.bodies]
        data.ctrl[self.drives] = source.ctrl[other.drives]
        data.eq_active[:], self.model.eq_data[:] = source.eq_active, other.model.eq_data
        for name in self._shared:
            data.joint(name).qpos[:] = source.joint(name).qpos
            data.joint(name).qvel[:] = source.joint(name).qvel
            data.joint(name).qacc_warmstart[:] = source.joint(name).qacc_warmstart
        self.contacts.continue_from(other.contacts)
        mujoco.mj_forward(self.model, data)
