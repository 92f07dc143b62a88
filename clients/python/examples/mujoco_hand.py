"""A custom simulator: a hand in MuJoCo with tactile pads, connected to the real daemon in lock-step.

    pip install mujoco
    python examples/mujoco_hand.py --atasd target/debug/atasd

MuJoCo simulates the robot of `daemon/robot/robots/two-hand-arm/robot.urdf` and the objects below. Each fingertip has 41 sprung pins
along the elements' normals; the contact forces on a pin are the forces of its taxel. The daemon receives frames and joint states and
sends commands, as with any robot. The same objects are then grasped in ATAS's simulator with the same controller. Both results are
printed, as a comparison of two independent contact models.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import atas
import mujoco
import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[3]
URDF = ROOT / "daemon" / "robot" / "robots" / "two-hand-arm" / "robot.urdf"
AT = (0.32, -0.15)
"""Position of objects in front of the right hand, m."""
TICK_NS = 1_000_000
SUBSTEPS = 4
SERVOS = [(0.45, 120.0)] * 2 + [(0.2, 120.0), (0.05, 160.0), (0.02, 160.0)] + [(2e-3, 200.0), (1e-3, 200.0), (1e-3, 200.0)] * 2
"""Reflected inertia, kg·m², and natural frequency, rad/s, of a hand's joints, as in a drive's datasheet."""
PIN_N_M = 1060.0
"""Stiffness of the skin under one taxel, N/m: 1.7e8 N/m³ times 6.2 mm²."""
PIN_RADIUS_M = 0.0015
NOISE_N = 0.002


@dataclass
class GraspObject:
    """An object: a box or an upright cylinder."""

    name: str
    mass_kg: float
    friction: float
    width_m: float
    height_m: float
    round: bool = False

    def toml(self) -> str:
        """Returns the object file for ATAS's simulator."""
        half = f"radius_m = {self.width_m / 2}" if self.round else f"size_m = [{self.width_m}, {self.width_m}, {self.height_m}]"
        shape = f'kind = "cylinder", {half}, height_m = {self.height_m}' if self.round else f'kind = "box", {half}'
        return f'name = "{self.name}"\nmass_kg = {self.mass_kg}\nfriction = {self.friction}\nshape = {{ {shape} }}\n'

    @property
    def grasp_height_m(self) -> float:
        """Grasp height, slightly above the middle and clear of the top, as recommended in `clients/protocol.md`."""
        top = self.height_m
        return max(min(max(0.575 * top, top - 0.040), top - 0.010), 0.025)


THINGS = [
    GraspObject("block", 0.20, 0.6, 0.050, 0.06),
    GraspObject("can", 0.15, 0.4, 0.050, 0.08, round=True),
    GraspObject("slippery-block", 0.12, 0.25, 0.045, 0.06),
    GraspObject("anvil", 2.50, 0.4, 0.050, 0.06),
]


def build_model(thing: GraspObject) -> Any:
    """Returns a model of the robot with tactile pads, a table and an object."""
    spec = mujoco.MjSpec.from_file(str(URDF))
    spec.option.timestep = TICK_NS * 1e-9 / SUBSTEPS
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 20.0
    for geom in spec.geoms:
        # Only fingertips collide; the links' shapes are for clearance checks.
        geom.contype = geom.conaffinity = 0
    for body in spec.bodies:
        body.gravcomp = 1.0
    for joint, (inertia, _) in zip(spec.joints, SERVOS * 2, strict=True):
        joint.armature = inertia
        motor = spec.add_actuator(name=f"drive-{joint.name}", target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gainprm[0] = 1.0
    layout = atas.layout("dome-41")
    for finger in (1, 2):
        tip = spec.body(f"right_finger{finger}_tip")
        for taxel, (normal, position) in enumerate(zip(layout["normal"], layout["position"], strict=True)):
            at = position - normal * PIN_RADIUS_M
            pin = tip.add_body(name=f"pin-{finger}-{taxel}", pos=at, gravcomp=1.0)
            pin.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=normal, stiffness=PIN_N_M, damping=2.0, armature=1e-3)
            pin.add_geom(
                name=f"pin-{finger}-{taxel}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[PIN_RADIUS_M, 0, 0],
                mass=1e-5,
                contype=2,
                conaffinity=4,
            )
    world = spec.worldbody
    world.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], contype=1, conaffinity=4)
    half = [thing.width_m / 2, thing.height_m / 2, 0] if thing.round else [thing.width_m / 2, thing.width_m / 2, thing.height_m / 2]
    body = world.add_body(name="object", pos=[*AT, thing.height_m / 2])
    body.add_freejoint()
    body.add_geom(
        name="object",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER if thing.round else mujoco.mjtGeom.mjGEOM_BOX,
        size=half,
        mass=thing.mass_kg,
        friction=[thing.friction, 0.0, 0.0],
        priority=1,
        contype=4,
        conaffinity=3,
        solref=[0.004, 1.0],
        solimp=[0.95, 0.99, 0.0005, 0.5, 2.0],
    )
    return spec.compile()


class Hand:
    """The simulated robot with its sensors and drives."""

    def __init__(self, thing: GraspObject) -> None:
        self.model = build_model(thing)
        self.data = mujoco.MjData(self.model)
        names = [mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_JOINT, joint) for joint in range(self.model.njnt)]
        joints = [names.index(name) for name in atas.JOINT_NAMES]
        self.q, self.v = self.model.jnt_qposadr[joints], self.model.jnt_dofadr[joints]
        inertia, frequency = np.array(SERVOS * 2).T
        self.stiffness, self.damping = inertia * frequency**2, 2 * inertia * frequency
        self.effort_n_m = np.zeros(atas.JOINTS)
        self.taxel: dict[int, tuple[int, int]] = {}
        for finger in range(2):
            for taxel in range(41):
                geom = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_GEOM, f"pin-{finger + 1}-{taxel}")
                self.taxel[geom] = (finger, taxel)
        layout = atas.layout("dome-41")
        self.axes = np.stack([-layout["normal"], layout["tangent1"], layout["tangent2"]], axis=1)
        self.thing = self.model.body("object").id
        self.data.qpos[self.q] = atas.Simulation().joint_state["position_rad"][: atas.JOINTS]
        mujoco.mj_forward(self.model, self.data)
        self.rest_m = self.height_m
        self.strongest_n = 0.0

    @property
    def height_m(self) -> float:
        return float(self.data.xpos[self.thing][2])

    def taxel_forces(self) -> NDArray[np.float64]:
        """Returns the force of the object on each taxel of the right hand along the taxel's axes, N."""
        force_n = np.zeros((2, 41, 3))
        wrench = np.zeros(6)
        for index, contact in enumerate(self.data.contact):
            for geom, sign in ((contact.geom1, -1.0), (contact.geom2, 1.0)):
                found = self.taxel.get(int(geom))
                if found is None:
                    continue
                # MuJoCo returns the force of geom1 on geom2 in the contact frame.
                mujoco.mj_contactForce(self.model, self.data, index, wrench)
                in_world = sign * (wrench[:3] @ np.asarray(contact.frame).reshape(3, 3))
                # A pin slides along its normal without rotation, so its axes are those of the tip.
                base_from_tip = self.data.xmat[self.model.geom_bodyid[geom]].reshape(3, 3)
                force_n[found] += self.axes[found[1]] @ (base_from_tip.T @ in_world)
        self.strongest_n = max(self.strongest_n, float(force_n[:, :, 0].sum(axis=1).max()))
        return force_n

    def move(self, orders: Any) -> None:
        """Advances the simulation by 1 ms with the servos' torques."""
        for _ in range(SUBSTEPS):
            off_rad = orders["position_rad"] - self.data.qpos[self.q]
            off_rad_s = orders["velocity_rad_s"] - self.data.qvel[self.v]
            self.effort_n_m = self.stiffness * off_rad + self.damping * off_rad_s
            self.data.ctrl[:] = self.effort_n_m
            mujoco.mj_step(self.model, self.data)


def grasp(thing: GraspObject, atasd: Path, limit_s: float) -> dict[str, Any]:
    """Runs a grasp over the bus with the real daemon in lock-step."""
    name = f"mujoco-{os.getpid()}"
    words = [str(atasd), "--lockstep", "--config", "/dev/null", "--bus", name]
    bus = atas.Bus(name, role="mujoco", create=True)
    hand, robot = Hand(thing), bus.robot()
    left, right = bus.sensor("left"), bus.sensor("right")
    random = np.random.default_rng(1)
    goal, tick = None, 0
    begin = time.monotonic()
    with subprocess.Popen(words, stderr=subprocess.DEVNULL) as daemon:
        try:
            while tick < limit_s * 1e3:
                now_ns = 10_000_000_000 + tick * TICK_NS
                noise_n = random.normal(0, NOISE_N, (2, 2, 41, 3))
                left.publish(noise_n[0], captured_ns=now_ns)
                right.publish(hand.taxel_forces() + noise_n[1], captured_ns=now_ns)
                robot.publish(hand.data.qpos[hand.q], hand.data.qvel[hand.v], hand.effort_n_m, captured_ns=now_ns)
                orders = robot.answer(now_ns, goal)
                if orders is None:
                    break
                hand.move(orders)
                tick += 1
                if tick == 100:
                    goal = bus.grasp((*AT, thing.grasp_height_m), width=thing.width_m)
        finally:
            daemon.terminate()
    result: dict[str, Any] = dict(goal.result) if goal else {}
    verdict = result | {
        "lifted_true_m": hand.height_m - hand.rest_m,
        "strongest_n": hand.strongest_n,
        "pace": tick * 1e-3 / (time.monotonic() - begin),
    }
    del goal, robot, left, right, bus
    atas.wipe(name)
    return verdict


def grasp_in_atas(thing: GraspObject, folder: Path) -> dict[str, Any]:
    """Runs the grasp in ATAS's simulator, in process."""
    file = folder / f"{thing.name}.toml"
    file.write_text(thing.toml())
    simulation = atas.Simulation(str(file), seed=1, vary=False)
    result: dict[str, Any] = dict(simulation.run())
    truth = simulation.truth["objects"][0]
    return result | {"lifted_true_m": float(truth["lifted_m"]), "strongest_n": float(truth["max_force_n"])}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--atasd", type=Path, default=ROOT / "target" / "debug" / "atasd", help="path of the daemon [%(default)s]")
    parser.add_argument("--objects", nargs="+", choices=[thing.name for thing in THINGS], help="default: all")
    parser.add_argument("--limit", type=float, default=40.0, metavar="SECONDS", help="limit of simulated time [%(default)s]")
    options = parser.parse_args()
    print(f"{'object':15s} {'simulator':8s} {'outcome':10s} {'F_2 N':>6s} {'strongest N':>11s} {'lifted mm':>9s}  reason")
    with tempfile.TemporaryDirectory() as folder:
        for thing in THINGS:
            if options.objects and thing.name not in options.objects:
                continue
            for name, verdict in (
                ("MuJoCo", grasp(thing, options.atasd, options.limit)),
                ("ATAS", grasp_in_atas(thing, Path(folder))),
            ):
                outcome = atas.GoalState(verdict["state"]).name if verdict.get("state") else "none"
                print(
                    f"{thing.name:15s} {name:8s} {outcome:10s} {verdict['f2_n']:6.2f} {verdict['strongest_n']:11.2f} "
                    f"{verdict['lifted_true_m'] * 1e3:9.1f}  {verdict['reason']}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
