"""Tests of the MuJoCo engine: skin against closed forms, thread, protocol, and tasks with the real controller."""

import json
import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import atas
import numpy as np
import pytest
from conftest import PROGRAMS, Programs
from numpy.typing import NDArray
from test_daemon import daemon

mujoco = pytest.importorskip("mujoco")

from atas.mujoco import protocol  # noqa: E402
from atas.mujoco.options import Options, parse  # noqa: E402
from atas.mujoco.world import Failed, World  # noqa: E402

RADIUS_M = 0.015
FOUNDATION_N_M3 = 1.7e8
QUIET = Options(effort_noise=0.0, joint_friction=0.0)
DUMP = "import sys,struct;k,n=struct.unpack('<II',sys.stdin.buffer.read(8));open(sys.argv[1],'wb').write(sys.stdin.buffer.read(n))"


def scene_of(folder: Path, *arguments: str) -> dict[str, Any]:
    """Scene description of `atas-sim run` with these arguments."""
    script, out = folder / "dump.py", folder / "scene.json"
    script.write_text(DUMP)
    words = [str(PROGRAMS / "atas-sim"), "run", "--lockstep", "--bus", f"fmj-{os.getpid()}", *arguments]
    ran = subprocess.run([*words, "--engine", f"{sys.executable} {script} {out}"], capture_output=True, text=True, timeout=60, check=False)
    assert "could not exchange data with the engine: it ended" in ran.stderr
    scene: dict[str, Any] = json.loads(out.read_bytes())
    return scene


def bench(folder: Path, friction: float) -> dict[str, Any]:
    """A fingertip of the two-hand arm on two slides, above a clamped plate; its pole points down."""
    scene = scene_of(folder)
    servo = {"stiffness": 1e6, "damping": 2e3, "inertia_kg_m2": 1.0, "effort_max": 1e3}
    joint = {"slides": True, "start": 0.0, "lower": -0.1, "upper": 0.1} | servo
    along_x, down = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), np.diag([1, -1, -1])
    slide = {"slides": True, "ratio": 1.0, "offset": 0.0}
    frames = [
        {"parent": None, "position_m": [0, 0, 0.1], "rotation": along_x.tolist(), "joint": 0} | slide,
        {"parent": 0, "position_m": [0, 0, 0], "rotation": (along_x.T @ down).tolist(), "joint": 1} | slide,
    ]
    tip = scene["hands"][1]["fingertips"][0] | {"frame": 1, "position_m": [0, 0, 0], "rotation": np.eye(3).tolist()}
    plate = {
        "name": "plate",
        "shape": {"box": [0.05, 0.05, (0.1 - RADIUS_M) / 2]},
        "mass_kg": 1.0,
        "friction": friction,
        "stiffness_n_m": None,
        "centre_of_mass_m": [0, 0, 0],
        "position_m": [0, 0],
        "yaw_rad": 0.0,
        "clamped": True,
        "on_neck": False,
        "thread": None,
        "neck": None,
    }
    none: dict[str, Any] = {"joints": [], "frames": [], "fingertips": []}
    right = {"joints": [{"name": "x"} | joint, {"name": "z"} | joint], "frames": frames, "fingertips": [tip]}
    return scene | {"hands": [none, right], "objects": [plate], "plates": []}


def move(world: World, x_m: float, z_m: float, ticks: int) -> tuple[np.ndarray[Any, Any], float]:
    """Moves the fingertip; returns the sum of the element forces, tip frame, N, and the depth, m."""
    for _ in range(ticks):
        state = world.advance(np.array([x_m, z_m, 0, 0, 0, 0, 0, 0, 0, np.inf]))
    return state[6 : 6 + 123].reshape(41, 3).sum(axis=0), float(state[1])


def dome_force_n(depth_m: float) -> float:
    """Force of a sticking dome on a flat: integral over the cap of depth × (k_n cos² + k_t sin²)."""
    angle = np.linspace(0, np.radians(35), 20_000)
    depth = np.maximum(depth_m - RADIUS_M * (1 - np.cos(angle)), 0)
    density = depth * (np.cos(angle) ** 2 + 0.7 * np.sin(angle) ** 2) * np.sin(angle)
    step = angle[1] - angle[0]
    return float(2 * np.pi * FOUNDATION_N_M3 * RADIUS_M**2 * density.sum() * step)


@pytest.mark.parametrize(("pins", "depth_m", "error"), [(1, 5e-4, 0.12), (1, 8e-4, 0.12), (3, 2e-4, 0.08), (3, 5e-4, 0.04), (3, 8e-4, 0.06)])
def test_normal_force_matches_the_closed_form(tmp_path: Path, pins: int, depth_m: float, error: float) -> None:
    world = World(bench(tmp_path, 5.0), Options(effort_noise=0.0, joint_friction=0.0, pins=pins))
    for depth in np.linspace(0, depth_m, 100):
        move(world, 0.0, depth, 1)
    force_n, reached_m = move(world, 0.0, depth_m, 200)
    assert -force_n[2] == pytest.approx(dome_force_n(reached_m), rel=error)


def test_soft_object_yields_in_series_with_the_skin(tmp_path: Path) -> None:
    """A stiffness that changed with each touch would drive an oscillation, which crushed a sponge."""
    scene, depth_m, stiffness_n_m = bench(tmp_path, friction=0.5), 0.0003, 500.0
    scene["objects"][0]["stiffness_n_m"] = stiffness_n_m
    world = World(scene, QUIET)
    forces_n = []
    for tick in range(600):
        # 2 mm/s, as a hand approaches.
        z_m = min(-0.0005 + 2e-6 * tick, depth_m)
        state = world.advance(np.array([0, z_m, 0, 0, 0, 0, 0, 0, 0, stiffness_n_m]))
        forces_n.append(-state[6 : 6 + 123].reshape(41, 3).sum(axis=0)[2])
        if world.now.skins[1]:
            assert world.model.jnt_stiffness[world.now.carriers] == pytest.approx(stiffness_n_m)
    # Sum of both compressions is the depth.
    yields_m = np.linspace(0, depth_m, 3001)
    force_n = next(stiffness_n_m * y for y in yields_m if stiffness_n_m * y >= dome_force_n(depth_m - y))
    assert forces_n[-1] == pytest.approx(force_n, rel=0.1)
    touched = int(np.flatnonzero(np.array(forces_n) > 0.01)[0])
    assert min(forces_n[touched:]) > 0.005, "the touch is lost"
    assert np.ptp(forces_n[-50:]) < 0.02 * force_n, "the force oscillates"


def test_carrier_is_damped_on_a_rigid_object(tmp_path: Path) -> None:
    """A new model has the stiffness of a rigid object, but no damping yet. Carriers exist because of the soft object."""
    scene = bench(tmp_path, 5.0)
    plate = scene["objects"][0]
    scene["objects"].append(plate | {"name": "foam", "stiffness_n_m": 500.0, "position_m": [0.5, 0]})
    world = World(scene, QUIET)
    for depth_m in np.linspace(0, 5e-4, 100):
        world.advance(np.array([0, depth_m, *np.zeros(10), np.inf, 500.0]))
    carriers = world.now.carriers
    assert len(carriers) > 0
    assert (world.model.dof_damping[world.model.jnt_dofadr[carriers]] > 0).all()


def test_tremor_moves_the_fingertips(tmp_path: Path) -> None:
    world = World(bench(tmp_path, 5.0), QUIET)
    for depth in np.linspace(0, 5e-4, 100):
        move(world, 0.0, depth, 1)
    pressed_n, _ = move(world, 0.0, 5e-4, 100)
    reference_n, _ = move(world, 0.0, 3e-4, 200)
    move(world, 0.0, 5e-4, 200)
    for ticks, raised_m in [(1, 0.0), (200, 2e-4)]:
        for _ in range(ticks):
            state = world.advance(np.array([0, 5e-4, 0, 0, 0, raised_m, 0, 0, 0, np.inf]))
    raised_n = state[6 : 6 + 123].reshape(41, 3).sum(axis=0)
    assert raised_n[2] == pytest.approx(reference_n[2], rel=0.1)
    assert raised_n[2] > 0.7 * pressed_n[2], "the force acts along -z"


def test_shear_slips_partially_and_ends_at_the_friction_limit(tmp_path: Path) -> None:
    world = World(bench(tmp_path, 0.5), QUIET)
    for depth in np.linspace(0, 5e-4, 100):
        move(world, 0.0, depth, 1)
    move(world, 0.0, 5e-4, 100)
    shear, ratio = [], []
    for x_m in np.linspace(0, 6e-4, 300):
        force_n, _ = move(world, x_m, 5e-4, 1)
        shear.append(float(np.hypot(*force_n[:2])))
        ratio.append(shear[-1] / -force_n[2])
    first, middle = (shear[60] - shear[30]) / 30, (shear[200] - shear[100]) / 100
    # Full stick: 0.7 of the normal stiffness of the touching pins. Then pins slide one after the other.
    assert middle < 0.6 * first, (first, middle)
    assert float(np.mean(ratio[200:])) == pytest.approx(0.5, rel=0.03)
    assert max(ratio) < 0.5 * 1.06


@dataclass
class ScrewWorld:
    """World of a cap on its bottle, with the hands at rest."""

    scene: dict[str, Any]
    world: World

    @property
    def weight_n(self) -> float:
        return float(self.scene["objects"][0]["mass_kg"] * self.scene["gravity_m_s2"])

    def advance(self, force_n: float, ticks: int) -> Iterator[NDArray[np.float64]]:
        """States of the ticks with this vertical force on the cap."""
        joints = [joint["start"] for hand in self.scene["hands"] for joint in hand["joints"]]
        values = np.concatenate([joints, np.zeros(len(joints) + 2), [0, 0, force_n, 0, 0, 0], [np.inf, np.inf]])
        for _ in range(ticks):
            yield self.world.advance(values)


@pytest.fixture
def screw_world(tmp_path: Path) -> ScrewWorld:
    scene = scene_of(tmp_path, "--scene", "screw")
    return ScrewWorld(scene, World(scene, QUIET))


def test_cap_turns_only_above_thread_friction(screw_world: ScrewWorld) -> None:
    world, state, angle = screw_world.world, np.zeros(3), {}
    # The bottle settles on the table, which can lift a cap that has not turned yet.
    list(screw_world.advance(0.0, 300))
    for torque_n_m in (0.010, 0.016):
        for state in screw_world.advance(0.0, 200):
            world.data.xfrc_applied[world.model.body("object0-cap").id, 5] = -torque_n_m
        angle[torque_n_m] = float(state[-2])
    assert state[-3] == 1.0
    assert abs(angle[0.010]) < 0.005 < 0.1 < angle[0.016]
    assert state[-1] == pytest.approx(0.015, rel=0.05), "the thread passes its friction to the bottle"


def test_cap_that_falls_on_its_thread_engages_once(screw_world: ScrewWorld) -> None:
    def engaged(weights: float, ticks: int) -> list[float]:
        """Whether the cap is engaged at the end of each tick with this vertical force, in weights of the cap."""
        return [float(state[-3]) for state in screw_world.advance(weights * screw_world.weight_n, ticks)]

    engaged(0.0, 300)
    assert engaged(1.1, 100)[-1] == 1.0, "a pull of a tenth of the weight holds the cap"
    assert engaged(2.0, 20)[-1] == 0.0, "a pull of the whole weight removes it"
    states = engaged(0.0, 300)
    assert min(states[states.index(1.0) :]) == 1.0, "a cap on its thread is not pulled"


def test_engaged_cap_follows_its_thread_and_leaves_the_rim(screw_world: ScrewWorld) -> None:
    cap = screw_world.world._cap
    assert cap is not None
    for weights in (0.0, -2.0, 1.1):
        for _ in screw_world.advance(weights * screw_world.weight_n, 100):
            parts = screw_world.world._cap_parts[screw_world.world.now.skins]
            offset, per_rad = parts.model.eq_data[parts.thread][:2]
            travel_m = offset + per_rad * parts.qpos[parts.turn_qpos]
            assert parts.qpos[parts.travel_qpos] == pytest.approx(travel_m, abs=20e-6)
            assert screw_world.world._support_n[0] == 0.0


def exchange(messages: list[tuple[int, bytes]], *options: str) -> list[tuple[int, bytes]]:
    """Answers of an engine process."""
    sent = b"".join(struct.pack("<II", kind, len(payload)) + payload for kind, payload in messages)
    words = [sys.executable, "-m", "atas.mujoco", *options]
    ran = subprocess.run(words, input=sent, capture_output=True, timeout=60, check=True)
    answers, rest = [], ran.stdout
    while rest:
        kind, length = struct.unpack("<II", rest[:8])
        answers.append((kind, rest[8 : 8 + length]))
        rest = rest[8 + length :]
    return answers


def test_wrong_messages_are_refused_with_a_reason(tmp_path: Path) -> None:
    scene = scene_of(tmp_path)
    old = json.dumps(scene | {"protocol": 99}).encode()
    lacking = json.dumps({key: value for key, value in scene.items() if key != "plates"}).encode()
    answers = exchange(
        [
            (protocol.TICK, b""),
            (protocol.BEGIN, old),
            (protocol.BEGIN, b"{"),
            (protocol.BEGIN, lacking),
            (protocol.BEGIN, json.dumps(scene).encode()),
            (77, b""),
        ]
    )
    kinds = [kind for kind, _ in answers]
    assert kinds == [protocol.FAILED] * 4 + [protocol.READY, protocol.FAILED]
    assert b"version 99" in answers[1][1] and b"plates" in answers[3][1]


@pytest.mark.parametrize("words", [["--step-us", "333"], ["--step-us", "0"], ["--pins", "2"], ["--effort-noise", "nan"], ["--speed"]])
def test_wrong_options_are_refused(words: list[str]) -> None:
    with pytest.raises(SystemExit):
        parse(words)


def test_unstable_scene_is_discarded(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, "--object", "wood")
    world = World(scene, QUIET)
    joints = sum(len(hand["joints"]) for hand in scene["hands"])
    wild = np.concatenate([np.zeros(2 * joints + 2), [1e12, 0, 0, np.inf]])
    with pytest.raises(Failed, match="MuJoCo warned|not finite"):
        for _ in range(100):
            world.advance(wild)


def test_wood_is_held_on_the_bus(programs: Programs, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATAS_PYTHON", sys.executable)
    programs.start("atas-sim", "run", "--object", "wood", "--lockstep", "--engine", "mujoco")
    bus = daemon(programs)
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05, yaw=np.pi / 2, hold=0.1)
    steps = [update["step"].decode() for update in goal]
    assert goal.result["state"] == atas.GoalState.SUCCEEDED, (goal.result, programs.log("atas-sim"))
    assert "lift" in steps and goal.result["f2_n"] > 1.0


def test_pictures_are_written_without_a_display(tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"} | {"ATAS_PYTHON": sys.executable}
    words = [str(PROGRAMS / "atas-sim"), "run", "--duration", "0.6", "--bus", f"fmj-{os.getpid()}", "--object", "wood"]
    words += ["--engine", f"mujoco --pictures {tmp_path}"]
    ran = subprocess.run(words, capture_output=True, text=True, timeout=120, env=environment, check=False)
    first = tmp_path / "00000.png"
    if "pictures need OpenGL" in ran.stderr:
        assert "libegl1" in ran.stderr and not first.exists()
        return
    assert ran.returncode == 0, ran.stderr
    assert first.read_bytes().startswith(b"\x89PNG") and first.stat().st_size > 5_000
