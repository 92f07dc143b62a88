"""Actions of atas_msgs over DDS: grasp, refusal with cause, cancellation, many goals."""

import math
import signal
import statistics
import time

import pytest
from bench import PROGRAMS
from cyclone import ABORTED, CANCELED, SUCCEEDED
from interfaces import cyclone
from test_dds import read

POINT = cyclone("geometry_msgs/msg/Point")
TARGET = cyclone("atas_msgs/msg/ObjectTarget")


def wood(**changed):
    fields = {
        "position": POINT(x=0.32, y=-0.15, z=0.0345),
        "yaw_rad": math.pi / 2,
        "width_m": 0.05,
        "top_m": 0.0,
        "max_force_n": 0.0,
    }
    return TARGET(**{**fields, **changed})


def opened(peer, name, of):
    action = peer.action(f"/atas/{name}", f"atas_msgs/action/{of}")
    action.wait_for_server()
    return action


def test_refusals_have_cause_value_and_remedy(peer):
    grasp = opened(peer, "grasp", "Grasp")
    for fields, part in (
        ({"hand": "third", "object": wood()}, "use left or right"),
        ({"hand": "right", "object": wood(width_m=math.nan)}, "width is NaN"),
        ({"hand": "right", "object": wood(position=POINT(x=3.0, y=0.0, z=0.0))}, "reach"),
        ({"hand": "right", "object": wood(max_force_n=1000.0)}, "maximum force"),
    ):
        status, result = grasp.execute(lift_m=0.03, hold_s=0.1, **fields)
        assert status == ABORTED and result.outcome.state == "rejected", fields
        assert part in result.outcome.cause, result.outcome.cause
    names = ["x" * 100_000] * 3
    status, result = grasp.execute(hand=names[0], object=wood(), lift_m=0.0, hold_s=0.0)
    assert status == ABORTED and len(result.outcome.cause) < 200


def test_grasp_reports_progress_and_holds(peer):
    grasp = opened(peer, "grasp", "Grasp")
    read(grasp.feedback, 0.2)
    goal_id = grasp.send(hand="right", object=wood(), lift_m=0.03, hold_s=0.5)
    status, result = grasp.result(goal_id, timeout=60)
    assert status == SUCCEEDED, result.outcome.cause
    assert result.outcome.state == "succeeded" and result.outcome.cause == ""
    assert result.outcome.lifted_m == pytest.approx(0.03, abs=0.005)
    assert result.outcome.friction > 0.1 and result.outcome.stiffness_n_m > 100
    steps = [sample.feedback.progress.step for sample in read(grasp.feedback, 0.5)[0]]
    for step in ("reach", "approach", "grip", "lift", "hold"):
        assert step in steps, steps
    print(f"grasp: {result.outcome.took_s:.1f} s, {max(result.outcome.normal_n):.2f} N")


def test_second_goal_is_refused_while_the_hand_is_full(peer):
    grasp = opened(peer, "grasp", "Grasp")
    status, result = grasp.execute(hand="right", object=wood(), lift_m=0.03, hold_s=0.1)
    assert status == ABORTED and "holds" in result.outcome.cause, result.outcome.cause


def test_held_object_is_released(peer):
    release = opened(peer, "release", "Release")
    status, result = release.execute(hand="right")
    assert status == SUCCEEDED, result.outcome.cause


def test_cancelled_grasp_ends_and_next_one_runs(peer):
    grasp = opened(peer, "grasp", "Grasp")
    fields = {"hand": "left", "object": wood(position=POINT(x=0.32, y=0.15, z=0.0345))}
    goal_id = grasp.send(lift_m=0.03, hold_s=1.0, **fields)
    time.sleep(1.0)
    assert grasp.cancel(goal_id) == 0
    status, result = grasp.result(goal_id)
    assert status == CANCELED and result.outcome.state == "cancelled"


def test_no_goal_and_no_result_of_many_is_lost(peer):
    """1,000 goals that the daemon rejects, up to 20 at once; every one has its result."""
    grasp = opened(peer, "grasp", "Grasp")
    far = wood(position=POINT(x=3.0, y=0.0, z=0.0))
    begin, ended = time.monotonic(), 0
    for _ in range(50):
        ids = [
            grasp.send(hand="right", object=far, lift_m=0.03, hold_s=0.1) for _ in range(20)
        ]
        for goal_id in ids:
            status, result = grasp.result(goal_id)
            assert status == ABORTED and result.outcome.cause
            ended += 1
    took_s = time.monotonic() - begin
    assert ended == 1000
    print(f"1000 goals and results in {took_s:.1f} s")


def test_first_motion_is_as_early_as_from_the_console(bench, peer):
    """Time from the call of the client to the first motion of a grasp, by turns over ROS 2 and by
    the command, which starts a process.
    """
    grasp = opened(peer, "grasp", "Grasp")
    joints = peer.reader("/joint_states", "sensor_msgs/msg/JointState")
    target = {"hand": "left", "object": wood(position=POINT(x=0.32, y=0.15, z=0.0345))}
    words = ("grasp", "--hand", "left", "--at", "0.32,0.15,0.0345", "--width", "50")

    def delay_s(begin):
        while time.monotonic() < begin + 5:
            for sample in joints.take(10):
                if max(abs(v) for v in sample.velocity) > 0.01:
                    return time.monotonic() - begin
            time.sleep(0.0005)
        raise AssertionError("no motion")

    delays = {"ROS 2": [], "console": []}
    for _ in range(5):
        bench.wait_for_mode("ready")
        read(joints, 0.5)
        begin = time.monotonic()
        goal_id = grasp.send(lift_m=0.03, hold_s=0.1, **target)
        delays["ROS 2"].append(delay_s(begin))
        assert grasp.cancel(goal_id) == 0
        assert grasp.result(goal_id)[0] == CANCELED
        bench.wait_for_mode("ready")
        read(joints, 0.5)
        begin = time.monotonic()
        process = bench.start("console", [PROGRAMS / "atas", *words])
        delays["console"].append(delay_s(begin))
        bench.kill("console", signal.SIGINT)
        assert process.returncode != 0, "cancelled"
    medians = {name: statistics.median(of) for name, of in delays.items()}
    print("goal to first motion, ms:", {n: [round(s * 1e3) for s in d] for n, d in delays.items()})
    assert medians["ROS 2"] <= medians["console"] + 0.05
