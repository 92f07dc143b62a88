"""Tests of Python sensors, robots and clients with the real daemon in lock-step, independent of the machine's speed."""

import time
from collections.abc import Callable
from typing import TypeVar

import atas
import numpy as np
import pytest
from atas.types import JointSetpoints
from conftest import Programs

TIMEOUT_S = 60.0
T = TypeVar("T")


def wait_for(what: str, ask: Callable[[], T | None]) -> T:
    """Calls `ask` until it returns a value; the timeout suits slow machines."""
    begin = time.monotonic()
    while time.monotonic() - begin < TIMEOUT_S:
        answer = ask()
        if answer is not None:
            return answer
        time.sleep(0.002)
    raise AssertionError(f"timed out waiting for {what}")


def daemon(programs: Programs, *more: str) -> atas.Bus:
    """Starts a daemon in lock-step and waits for its status."""
    programs.start("atasd", "--lockstep", "--config", "/dev/null", *more)
    bus = atas.Bus(programs.bus, create=True)
    statuses = bus.statuses()
    wait_for("the daemon", statuses.newest)
    return bus


class World:
    """A custom robot that moves to its commanded position, with unloaded, noisy fingertips."""

    def __init__(self, bus: atas.Bus) -> None:
        self.robot = bus.robot()
        self.sensors = [bus.sensor(hand) for hand in ("left", "right")]
        self.noise = np.random.default_rng(0)
        self.joints = atas.Simulation().joint_state["position"][: atas.JOINTS].copy()
        # Away from the home position of the right hand, so that it must move.
        self.joints[11] += 0.15
        self.now_ns = 10_000_000_000

    def tick(self, goal: atas.Goal | None = None) -> JointSetpoints | None:
        for sensor in self.sensors:
            sensor.publish(self.noise.normal(0, 1e-3, (2, 41, 3)), captured_ns=self.now_ns)
        self.robot.publish(self.joints, captured_ns=self.now_ns)
        orders = self.robot.answer(self.now_ns, goal)
        if orders is not None:
            self.joints += 0.5 * (orders["position"] - self.joints)
            self.now_ns += 1_000_000
        return orders

    def settle(self) -> list[JointSetpoints]:
        """Runs the ticks before the daemon accepts a goal."""
        told = [self.tick() for _ in range(100)]
        return [orders for orders in told if orders is not None]


def test_custom_robot_runs_in_lockstep(programs: Programs) -> None:
    bus = daemon(programs)
    reports, world = bus.reports(), World(bus)
    modes = [orders["mode"] for orders in world.settle()]
    # Commands before the daemon knows the joint positions are invalid.
    unanchored = world.robot.rejected
    assert modes[0] == atas.Mode.INIT and modes[-1] == atas.Mode.READY
    # From here on the daemon ticks only while a goal is active.
    before = world.joints.copy()
    goal = bus.release("right")
    while world.tick(goal) is not None:
        pass
    assert goal.result["state"] == atas.GoalState.SUCCEEDED, goal.result
    moved = np.abs(world.joints - before)
    assert moved[11:].max() > 0.01 and moved[:11].max() < 1e-3, "only the right arm moves"
    assert world.robot.rejected == unanchored < 50
    # The queue keeps the newest 256 reports, which are consecutive.
    told = reports.receive()
    assert len(told) == 256 and (np.diff(told["tick"].astype(np.int64)) == 1).all()


def test_commands_are_deterministic(programs: Programs, tmp_path_factory: pytest.TempPathFactory) -> None:
    def run(programs: Programs) -> list[bytes]:
        world = World(daemon(programs))
        return [orders["position"].tobytes() for orders in world.settle()]

    first = run(programs)
    again = Programs(programs.bus + "x", tmp_path_factory.mktemp("again"))
    try:
        assert run(again) == first
    finally:
        for process in again.started:
            process.terminate()
            process.wait(60)
        atas.wipe(again.bus)


def test_goal_updates_arrive_until_the_end(programs: Programs) -> None:
    programs.start("atas-sim", "run", "--lockstep", "--object", "wood", "--seed", "3")
    bus = daemon(programs)
    events, frames, truths = bus.events(), bus.frames("right"), bus.truths()
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05, lift=0.01, hold=0.1)
    steps = [update["step"].decode() for update in goal]
    assert goal.result["state"] == atas.GoalState.SUCCEEDED, goal.result
    assert "lift" in steps and goal.result["f2_n"] > 1.0
    told = events.receive()
    assert events.lost == 0 and (told["kind"] == atas.EventKind.TOUCH_ON).sum() >= 2
    rows = frames.receive()
    assert len(rows) == 128 and rows["force_n"][-1, :2, :, 0].sum() > 1.0
    truth = truths.newest()
    assert truth is not None and truth["objects"][0]["lifted_m"] > 0.005
    refused = bus.grasp((2.0, 0.0, 0.1), width=0.05).wait(TIMEOUT_S)
    assert refused["state"] == atas.GoalState.REJECTED and refused["reason"]


def test_stop_recover_cancel_and_parameters(programs: Programs) -> None:
    programs.start("atas-sim", "run", "--lockstep", "--object", "wood", "--seed", "3")
    bus = daemon(programs)
    statuses = bus.statuses()
    parameters = bus.parameters()
    value, lower, upper, meaning = parameters["grasp.f2_max_n"]
    assert lower <= value <= upper and meaning
    bus.set_parameter("grasp.f2_max_n", 5.0)
    assert bus.parameters()["grasp.f2_max_n"][0] == 5.0
    with pytest.raises(atas.AtasError, match="f2_max_n"):
        bus.set_parameter("grasp.f2_max_n", 1e9)
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05, hold=3600)
    wait_for("its beginning", lambda: next(iter(goal)))
    with pytest.raises(TimeoutError, match="not ended"):
        goal.wait(0.01)
    goal.cancel()
    assert goal.wait(TIMEOUT_S)["state"] == atas.GoalState.CANCELLED
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05, hold=3600)
    wait_for("its beginning", lambda: next(iter(goal)))
    bus.estop("a test")

    def mode(wanted: int) -> bool | None:
        status = statuses.newest()
        return True if status is not None and status["mode"] == wanted else None

    wait_for("the stop", lambda: mode(atas.Mode.SAFE_STOP))
    assert goal.wait(TIMEOUT_S)["state"] != atas.GoalState.SUCCEEDED
    bus.recover()
    wait_for("ready", lambda: mode(atas.Mode.READY))
