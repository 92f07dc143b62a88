"""Tests of the in-process simulator with the production controller."""

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import atas
import numpy as np
import pytest


def test_simulation_is_deterministic() -> None:
    def told(seed: int) -> tuple[bytes, bytes]:
        simulation = atas.Simulation("sponge", seed=seed)
        simulation.start()
        reports = simulation.step(3000)
        frame = simulation.frame("right")
        assert frame is not None
        return reports.tobytes(), frame.tobytes()

    assert told(5) == told(5)
    assert told(5)[0] != told(6)[0]


def test_single_steps_equal_multiple_steps() -> None:
    one, many = atas.Simulation("wood", seed=2), atas.Simulation("wood", seed=2)
    one.start()
    many.start()
    rows = np.concatenate([one.step() for _ in range(500)])
    assert rows.tobytes() == many.step(500).tobytes()
    assert one.now_ns == many.now_ns and one.command.tobytes() == many.command.tobytes()


@pytest.mark.parametrize(
    ("name", "state"),
    [("wood", atas.GoalState.SUCCEEDED), ("paper-box", atas.GoalState.SUCCEEDED), ("heavy-block", atas.GoalState.REFUSED)],
)
def test_grasp_has_the_expected_outcome(name: str, state: int) -> None:
    simulation = atas.Simulation(name, seed=1)
    assert simulation.mode == atas.Mode.READY
    result = simulation.run()
    held = simulation.truth["objects"][0]
    assert result["state"] == state, result
    assert not held["crushed"] and not held["dropped"]
    assert (held["lifted_m"] > 0.03) == (state == atas.GoalState.SUCCEEDED)
    kinds = set(simulation.events["kind"])
    assert {atas.EventKind.STEP, atas.EventKind.TOUCH_ON, atas.EventKind.MODULE_ON} <= kinds


def test_invalid_arguments_raise() -> None:
    for arguments, says in (
        ({"object": "woad"}, "wood"),
        ({"scene": "grab"}, "pick-place"),
        ({"hand": "both"}, "right"),
        ({"settings": {"grasp.f9_n": 1.0}}, "grasp.f9_n"),
        ({"settings": {"grasp.f2_max_n": float("nan")}}, "grasp.f2_max_n"),
        ({"noise": -1.0}, "noise"),
    ):
        with pytest.raises(ValueError, match=says):
            atas.Simulation(**arguments)


def test_numbers_out_of_range_raise() -> None:
    simulation = atas.Simulation("wood", seed=1)
    for ticks in (10**6 + 1, 10**10, 2**63 - 1, 2**64, -1):
        with pytest.raises((ValueError, OverflowError)):
            simulation.step(ticks)
    for limit_s in (-1.0, float("nan"), float("inf"), 1e300):
        with pytest.raises(ValueError, match="invalid time"):
            simulation.run(limit_s)
    assert simulation.now_ns == atas.Simulation("wood", seed=1).now_ns, "nothing moved"


def test_ctrl_c_ends_a_long_step() -> None:
    code = "import atas; simulation = atas.Simulation('wood'); print('steps', flush=True); simulation.step(1_000_000)"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "steps\n"
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT and "KeyboardInterrupt" in error


def test_simulation_may_change_threads() -> None:
    simulation = atas.Simulation("wood", seed=1)
    with ThreadPoolExecutor(1) as pool:
        assert len(pool.submit(simulation.step, 10).result()) == 10


def test_settings_reach_the_controller() -> None:
    gentle = atas.Simulation("wood", seed=1, settings={"grasp.f2_max_n": 2.0})
    result = gentle.run()
    assert result["state"] == atas.GoalState.REFUSED and "f2_max_n" in result["reason"]
