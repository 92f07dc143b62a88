"""Tests of the texts of objects: each names its kind and its state."""

from pathlib import Path

import atas
import pytest
from atas.environments import GraspEnv, GraspVectorEnv, PickPlaceEnv
from atas.hands import SimulatedHand
from conftest import Programs
from test_daemon import daemon
from test_recording import record


def check(thing: object, *parts: str) -> None:
    text = repr(thing)
    assert "object at 0x" not in text and "\n" not in text and "Ok(" not in text, text
    assert all(part in text for part in parts), text


def test_simulation_text_names_object_robot_and_progress() -> None:
    simulation = atas.Simulation("sponge", seed=4)
    check(simulation, "grasp", "sponge", "two-hand-arm", "seed 4", "ready", "no goal yet")
    simulation.start()
    simulation.step(3000)
    check(simulation, "run", "goal running, step ")
    simulation.run()
    check(simulation, "goal succeeded after ")
    check(SimulatedHand("wood"), "SimulatedHand 'right'", "wood", "peak 0.00 N")


def test_environment_text_names_robot_and_objects() -> None:
    check(GraspEnv(objects=["wood"]), "GraspEnv", "grasp", "two-hand-arm", "wood")
    environment = PickPlaceEnv(robot="arm7-gripper", objects=["slippery-50"], render_mode="rgb_array")
    check(environment, "pick-place", "arm7-gripper", "rgb_array")
    assert str(environment) == repr(environment)
    check(GraspVectorEnv(3), "GraspVectorEnv of 3", "sponge")


def test_bus_texts_name_their_role(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    check(bus, f'Bus("{bus_name}")')
    check(bus.reports(), "Reader", "report", "0 lost")
    robot = bus.robot("test-bench")
    check(robot, "test-bench", "2 joints", "0 states published", "0 commands rejected")
    robot.publish([0.08, 0.03])
    check(robot, "1 states published")
    check(bus.sensor("left", layout="dome-1", fingers=1), "left", "1 x 1 taxels")
    with pytest.raises(ValueError, match="two-hand-arm"):
        bus.robot("no-such")


def test_goal_and_teleoperation_texts_name_their_state(programs: Programs) -> None:
    programs.start("atas-sim", "run", "--lockstep", "--object", "wood", "--seed", "3")
    daemon(programs)
    bus = atas.Bus(programs.bus)
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05)
    check(goal, str(goal.goal_id), "no goal yet")
    next(iter(goal))
    check(goal, "goal ")
    goal.wait(120)
    check(goal, "goal succeeded after ")
    bus.release("right").wait(60)
    teleop = bus.teleop("right")
    check(teleop, "right", "running")
    teleop.end()
    check(teleop, "ended")


def test_other_texts_name_their_content(programs: Programs, tmp_path: Path) -> None:
    check(atas.Rate(250, seconds=2), "250 Hz", "500 iterations", "0 late")
    check(atas.Kinematics("test-bench"), "test-bench", "2 joints")
    search = atas.SwarmSearch(16, population=4)
    check(search, "16 bits", "generation 0", "no fitness yet")
    genomes = search.ask()
    search.tell(genomes.sum(axis=1).astype(float))
    check(search, "generation 1", f"best fitness {float(genomes.sum(axis=1).max()):.1f}")
    check(atas.SwarmField("R3", agents=2), "R3", "2 agents", "128 bits", "0 evaluated")
    file = programs.folder / "run.mcap"
    record(programs, file)
    check(atas.Recording(str(file)), "run.mcap")
