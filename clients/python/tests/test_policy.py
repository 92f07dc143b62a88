"""Tests of a policy over the network: recorded chunks, and every fault."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import atas
import numpy as np
import pytest
from atas.features import POSE
from atas.hands import BusHand, SimulatedHand
from atas.policy import (
    ChunkExecutor,
    PolicyChunkError,
    PolicyClient,
    PolicyConnectionError,
    PolicyError,
    PolicySilentError,
    ReplayServer,
    run,
    wire,
)
from conftest import Programs
from test_daemon import wait_for

EXAMPLES = Path(__file__).parents[1] / "examples"

RATE_HZ = 20.0
STEPS = 20
"""Steps of a recorded chunk: one second."""


def chunks(hand: SimulatedHand, seconds: float = 12.0) -> np.ndarray[Any, Any]:
    """Records the poses of a scripted grasp as chunks that begin every half second."""
    hint = hand.simulation.hint
    x, y, z = hint["at"]
    wide, closed = hint["width"] + 0.018, hint["width"] - 0.004
    times_s = [0.0, 1.5, 3.0, 3.5, 6.0, 6.5, 8.5]
    ups, openings = [0.06, 0.06, 0.0, 0.0, 0.0, 0.0, 0.04], [wide, wide, wide, wide, closed, closed, closed]
    at_s = np.arange(0.0, seconds + 1.0, 1.0 / RATE_HZ)
    up, opening = np.interp(at_s, times_s, ups), np.interp(at_s, times_s, openings)
    poses = np.stack([np.full_like(up, x), np.full_like(up, y), z + up, np.full_like(up, hint["yaw"]), opening], axis=1)
    begins = range(0, int(seconds * RATE_HZ), STEPS // 2)
    return np.stack([poses[begin : begin + STEPS] for begin in begins])


class Blocking:
    """A client that waits for each answer, so that virtual time and chunks stay together."""

    def __init__(self, client: PolicyClient) -> None:
        self.client = client

    @property
    def is_waiting(self) -> bool:
        return self.client.is_waiting

    def request(self, observation: Mapping[str, Any]) -> None:
        self.client.request(observation)

    def poll(self) -> Mapping[str, Any] | None:
        return wait_for("the answer", self.client.poll) if self.client.is_waiting else None


@pytest.fixture
def hand() -> SimulatedHand:
    return SimulatedHand("paper-box", seed=1)


def pressed_n(hand: SimulatedHand) -> float:
    return float(hand.simulation.truth["normal_n"][hand.features.index][:2].min())


def test_recorded_chunks_grasp_and_lift_gently(hand: SimulatedHand) -> None:
    with ReplayServer(chunks(hand)) as server, PolicyClient(server.url) as client:
        assert client.metadata == server.metadata
        executor = ChunkExecutor(hand, Blocking(client), rate_hz=RATE_HZ, replan=10, prompt="lift the box")
        run(executor, 12.0)
    held = hand.simulation.truth["objects"][0]
    assert held["lifted_m"] > 0.03 and not held["crushed"] and pressed_n(hand) > 0.03
    assert hand.peak_n < held["crush_n"]
    assert executor.late_steps == 0 and executor.chunks >= 20
    seen = server.observations[-1]
    assert seen["prompt"] == "lift the box" and seen["observation/state"].dtype == np.float32
    state = dict(zip(hand.features.state_names(), seen["observation/state"].tolist(), strict=True))
    assert state["finger1.in_contact"] == 1.0 and state["hand.z"] > hand.simulation.hint["at"][2] + 0.03
    assert seen["observation/environment"].shape == (8,)


def grasped(hand: SimulatedHand) -> None:
    """Grasps and lifts without a policy."""
    for chunk in chunks(hand)[::2]:
        for pose in chunk:
            hand.send(dict(zip(POSE, map(float, pose), strict=True)))
            hand.run(50)
    assert hand.simulation.truth["objects"][0]["lifted_m"] > 0.03


@pytest.mark.parametrize(
    ("fault", "kind", "says"),
    [
        ("nan", PolicyChunkError, "of step 19 is nan"),
        ("shape", PolicyChunkError, r"shape \(20, 6\); needs \(steps, 5\)"),
        ("malformed", PolicyChunkError, "not valid MessagePack"),
        ("error", PolicyConnectionError, "the model has no weights"),
        ("close", PolicyConnectionError, "closed the connection"),
    ],
)
def test_fault_holds_the_grasp_and_names_the_cause(
    hand: SimulatedHand, fault: str, kind: type[PolicyError], says: str
) -> None:
    grasped(hand)
    above = chunks(hand)[-1:]
    sent: list[Mapping[str, float]] = []
    with ReplayServer(above, faults={2: fault}) as server, PolicyClient(server.url) as client:
        executor = ChunkExecutor(hand, Blocking(client), rate_hz=RATE_HZ)
        original = hand.send

        def send(target: Mapping[str, float]) -> None:
            sent.append(target)
            original(target)

        hand.send = send  # type: ignore[method-assign]
        with pytest.raises(kind, match=says):
            run(executor, 60.0)
        executed = len(sent)
        assert executed == executor.steps > 0
    hand.run(3000)
    assert len(sent) == executed, "nothing of the chunk was executed"
    held = hand.simulation.truth["objects"][0]
    assert held["lifted_m"] > 0.03 and not held["dropped"] and not held["crushed"] and pressed_n(hand) > 0.03


class Slow:
    """A client whose answers arrive after a virtual time; None: never."""

    def __init__(self, hand: SimulatedHand, chunk: np.ndarray[Any, Any], delays_s: Iterator[float | None]) -> None:
        self.hand, self.chunk, self.delays_s = hand, chunk, delays_s
        self.due_s: float | None = None
        self.is_waiting = False

    def request(self, observation: Mapping[str, Any]) -> None:
        delay_s = next(self.delays_s)
        self.is_waiting, self.due_s = True, None if delay_s is None else self.hand.now_s() + delay_s

    def poll(self) -> Mapping[str, Any] | None:
        if self.due_s is None or self.hand.now_s() < self.due_s:
            return None
        self.is_waiting, self.due_s = False, None
        return {"actions": self.chunk}


def test_late_chunks_pause_the_hand_and_motion_continues(hand: SimulatedHand) -> None:
    grasped(hand)
    chunk = chunks(hand)[-1]
    client = Slow(hand, chunk, iter([0.1, 1.5, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]))
    executor = ChunkExecutor(hand, client, rate_hz=RATE_HZ, silence_s=3.0)
    run(executor, 4.0)
    # The second answer comes after its own chunk has ended: all its rows are in the past.
    assert executor.late_steps >= 10 and executor.steps > 40 and executor.chunks >= 4
    held = hand.simulation.truth["objects"][0]
    assert held["lifted_m"] > 0.03 and pressed_n(hand) > 0.03


def test_rows_of_the_past_are_left_out(hand: SimulatedHand) -> None:
    sent: list[float] = []
    hand.send = lambda target: sent.append(target["hand.z"])  # type: ignore[method-assign]
    chunk = np.tile([0.32, -0.15, 0.1, math.pi / 2, 0.07], (STEPS, 1))
    chunk[:, 2] = 0.1 + 0.001 * np.arange(STEPS)
    executor = ChunkExecutor(hand, Slow(hand, chunk, iter([0.2, None])), rate_hz=RATE_HZ, silence_s=10.0)
    run(executor, 1.2)
    assert sent == pytest.approx((0.1 + 0.001 * np.arange(4, STEPS)).tolist()), "the answer took four periods"


def test_silent_server_holds_the_grasp(hand: SimulatedHand) -> None:
    grasped(hand)
    client = Slow(hand, chunks(hand)[-1], iter([0.1, None]))
    executor = ChunkExecutor(hand, client, rate_hz=RATE_HZ, silence_s=2.0)
    begin_s = hand.now_s()
    with pytest.raises(PolicySilentError, match=r"did not answer for 2\.\d s \(limit 2.0 s\)"):
        run(executor, 60.0)
    assert hand.now_s() - begin_s < 4.0
    hand.run(3000)
    held = hand.simulation.truth["objects"][0]
    assert held["lifted_m"] > 0.03 and not held["dropped"] and pressed_n(hand) > 0.03


def test_silent_connection_does_not_block_a_step(hand: SimulatedHand) -> None:
    with ReplayServer(chunks(hand), faults={0: "silent"}) as server, PolicyClient(server.url) as client:
        executor = ChunkExecutor(hand, client, rate_hz=RATE_HZ, silence_s=0.5)
        with pytest.raises(PolicySilentError):
            run(executor, 60.0)


def test_daemon_ends_the_teleoperation_of_a_silent_policy(programs: Programs) -> None:
    """Simulator, daemon and server in real time. The daemon's own reaction is tested in lock-step elsewhere."""
    programs.start("atas-sim", "run", "--object", "paper-box")
    programs.start("atasd", "--config", "/dev/null", "--set", "realtime.mode=off", "--set", "safety.stall_s=1")
    bus = atas.Bus(programs.bus, create=True)
    statuses = bus.statuses()
    wait_for("reports", bus.reports().newest)
    hand = BusHand(programs.bus, item=[0.32, -0.15, 0.02875, math.pi / 2, 0.05])
    chunk = np.tile([0.32, -0.15, 0.1, math.pi / 2, 0.07], (1, 5, 1))

    def goal_state(of: tuple[int, ...]) -> int | None:
        status = statuses.newest()
        found = None if status is None else int(status["goal_state"])
        return found if found in of else None

    with ReplayServer(chunk, faults={2: "silent"}) as server, PolicyClient(server.url) as client:
        executor = ChunkExecutor(hand, client, rate_hz=RATE_HZ, replan=3, silence_s=1.0)
        wait_for("the teleoperation", lambda: executor.step() or None)
        wait_for("the goal", lambda: goal_state((atas.GoalState.ACCEPTED, atas.GoalState.RUNNING)))
        with pytest.raises(PolicySilentError):
            run(executor, 600.0)
    assert server.observations[0]["observation/state"].shape == (len(hand.features.state_names()),)
    wait_for("its end", lambda: goal_state((atas.GoalState.CANCELLED, atas.GoalState.FAILED)))


def test_missing_server_is_named() -> None:
    with pytest.raises(PolicyConnectionError, match="could not connect to the policy server ws://127.0.0.1:9"):
        PolicyClient("ws://127.0.0.1:9")
    with pytest.raises(PolicyConnectionError, match="could not connect"):
        PolicyClient("http://127.0.0.1:9")


def test_second_request_waits_for_the_first_answer(hand: SimulatedHand) -> None:
    with ReplayServer(chunks(hand), faults={0: "silent"}) as server, PolicyClient(server.url) as client:
        client.request({"observation/state": np.zeros(3, np.float32)})
        with pytest.raises(RuntimeError, match="no answer yet"):
            client.request({})
    with ReplayServer(chunks(hand)) as server, PolicyClient(server.url) as client:
        answer = client.infer({"observation/state": np.zeros(3, np.float32), "prompt": "x"})
        assert answer["actions"].shape == (STEPS, 5)


@pytest.mark.parametrize(
    "value",
    [
        np.zeros((0, 3), np.float32),
        np.arange(24, dtype=np.int16).reshape(2, 3, 4)[:, ::2],
        np.float32(0.1),
        np.bool_(True),
        {"a": [1, "b", None, {"c": np.ones(2, np.uint8)}]},
    ],
    ids=["empty", "strided", "float", "bool", "nested"],
)
def test_values_survive_the_wire(value: Any) -> None:
    back = wire.unpack(wire.pack({"value": value}))["value"]
    assert type(back) is type(value)
    if isinstance(value, dict):
        assert back["a"][:3] == value["a"][:3] and (back["a"][3]["c"] == 1).all()
    else:
        assert back.dtype == value.dtype and np.array_equal(back, value)


@pytest.mark.parametrize(
    ("array", "says"),
    [
        ({b"data": b"12345678", b"dtype": "<f4", b"shape": [3]}, "has 8 bytes; needs 12"),
        ({b"data": b"", b"dtype": "O", b"shape": [0]}, "element type object"),
        ({b"data": b"", b"dtype": "no type", b"shape": [0]}, "without a valid element type"),
        ({b"data": b"", b"dtype": "<f4", b"shape": [-1]}, "without data or shape"),
        ({b"data": b"", b"dtype": "<f4", b"shape": [1 << 60]}, "needs 4611686018427387904"),
        ({b"data": "text", b"dtype": "<f4", b"shape": [1]}, "without data or shape"),
    ],
)
def test_malformed_array_is_refused(array: dict[bytes, Any], says: str) -> None:
    import msgpack

    with pytest.raises(PolicyChunkError, match=says):
        wire.unpack(msgpack.packb({"actions": array | {b"__ndarray__": True}}))


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"rate_hz": 0.5}, "1 to 1000"),
        ({"replan": 0}, "at least 1"),
        ({"silence_s": math.nan}, "positive number"),
    ],
)
def test_invalid_option_is_refused(hand: SimulatedHand, option: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        ChunkExecutor(hand, Slow(hand, np.zeros((1, 5)), iter([])), **option)
    with pytest.raises(ValueError, match="faults rejected"):
        ReplayServer(np.zeros((1, 1, 5)), faults={0: "fire"})


def test_other_action_space_is_converted(hand: SimulatedHand) -> None:
    wide = np.concatenate([chunks(hand)[0], np.zeros((STEPS, 27))], axis=1)
    client = Slow(hand, wide, iter([0.0] * 9))
    executor = ChunkExecutor(hand, client, rate_hz=RATE_HZ, width=32, convert=lambda chunk: chunk[:, :5])
    run(executor, 1.0)
    assert executor.steps > 10
    refused = ChunkExecutor(hand, Slow(hand, wide, iter([0.0])), width=32, convert=lambda chunk: chunk)
    with pytest.raises(PolicyChunkError, match="`convert` made the shape"):
        run(refused, 1.0)


def test_commands_serve_and_run_a_policy(tmp_path: Path, hand: SimulatedHand) -> None:
    file = tmp_path / "chunks.npy"
    np.save(file, chunks(hand))
    python = [sys.executable, "-m", "atas.policy"]
    with subprocess.Popen([*python, "serve", file, "--port", "0"], stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[-1]
            line = [*python, "run", url, "--simulate", "paper-box", "--seed", "1", "--seconds", "2"]
            ran = subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)
            assert ran.returncode == 0 and "the hand holds" in ran.stdout and "peak force" in ran.stdout, ran
            absent = [*python, "run", "ws://127.0.0.1:9", "--simulate", "wood"]
            failed = subprocess.run(absent, capture_output=True, text=True, timeout=60, check=False)
            assert failed.returncode == 1 and failed.stderr.startswith("error: could not connect"), failed
        finally:
            server.terminate()


def test_reflex_protects_objects_from_jittered_targets() -> None:
    options = ["--seeds", "6", "--first-seed", "1", "--rates", "20", "--json"]
    words = [sys.executable, str(EXAMPLES / "jittered_policy.py"), *options]
    ran = subprocess.run(words, capture_output=True, text=True, timeout=300, check=True)
    harmed = {True: 0, False: 0}
    for one in json.loads(ran.stdout):
        harmed[one["reflex"]] += one["crushed"] or one["dropped"]
    assert harmed[True] == 0 and harmed[False] >= 3, harmed
