"""Topics, services and actions over DDS, with Cyclone DDS as the peer."""

import math
import signal
import statistics
import struct
import time

import numpy as np
import pytest
from bench import wait
from cyclone import ABORTED, CANCELED, SUCCEEDED, Peer
from interfaces import cyclone

OBJECT = {"x": 0.32, "y": -0.15, "z": 0.0345}
GRIPPER = ("/atas/right/gripper_cmd", "control_msgs/action/GripperCommand")
PARALLEL = ("/atas/right/parallel_gripper_cmd", "control_msgs/action/ParallelGripperCommand")


def read(reader, seconds):
    """Returns the valid samples of a time and their times of arrival."""
    samples, times, end = [], [], time.monotonic() + seconds
    while time.monotonic() < end:
        for sample in reader.take(1000):
            if hasattr(sample, "__idl__") or hasattr(sample, "__dataclass_fields__"):
                samples.append(sample)
                times.append(time.monotonic())
        time.sleep(0.0005)
    return samples, times


def command(position, max_effort=0.0):
    return cyclone("control_msgs/msg/GripperCommand")(position=position, max_effort=max_effort)


def trigger(peer, name):
    client = peer.client(name, "std_srvs/srv/Trigger")
    client.wait_for_server()
    return client.call()


def test_joint_states_arrive_at_the_chosen_rate(peer):
    reader = peer.reader("/joint_states", "sensor_msgs/msg/JointState")
    read(reader, 1.0)
    samples, times = read(reader, 10.0)
    gaps_ms = np.diff(times) * 1e3
    p50, p99, most = np.percentile(gaps_ms, [50, 99, 100])
    gaps = f"gap p50 {p50:.2f} p99 {p99:.2f} max {most:.2f} ms"
    print(f"Cyclone DDS, joint states: {len(samples)} in 10 s, {gaps}")
    assert 980 <= len(samples) <= 1020
    assert p99 <= 15.0
    last = samples[-1]
    assert len(last.name) == len(last.position) == len(last.velocity) == len(last.effort) == 22
    assert abs(last.header.stamp.sec - time.time()) < 2


def test_every_topic_is_listed_and_carries_data(peer):
    found = peer.topics()
    hands, kinds = ("left", "right"), ("wrench", "elements")
    tips = [f"/atas/{hand}/finger1/{kind}" for hand in hands for kind in kinds]
    expected = {
        "/joint_states": "sensor_msgs::msg::dds_::JointState_",
        "/tf": "tf2_msgs::msg::dds_::TFMessage_",
        "/robot_description": "std_msgs::msg::dds_::String_",
        "/diagnostics": "diagnostic_msgs::msg::dds_::DiagnosticArray_",
        "/atas/state": "atas_msgs::msg::dds_::DaemonState_",
        "/atas/right/state": "atas_msgs::msg::dds_::HandState_",
        "/atas/events": "rcl_interfaces::msg::dds_::Log_",
        "/atas/goal_events": "atas_msgs::msg::dds_::GoalEvent_",
        "/parameter_events": "rcl_interfaces::msg::dds_::ParameterEvent_",
    }
    for topic, of in expected.items():
        assert found.get(f"rt{topic}") == of, (topic, sorted(found))
    assert all(f"rt{tip}" in found for tip in tips)
    one = lambda topic, of, **how: read(peer.reader(topic, of, **how), 2.5)[0][-1]  # noqa: E731
    links = one("/tf", "tf2_msgs/msg/TFMessage").transforms
    assert len(links) > 20 and all(math.isfinite(link.transform.rotation.w) for link in links)
    cloud = one("/atas/right/finger1/elements", "sensor_msgs/msg/PointCloud2", best_effort=True)
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "fx", "fy", "fz", "force"]
    assert cloud.width == 41 and len(cloud.data) == cloud.row_step == 41 * cloud.point_step
    assert all(math.isfinite(x) for x in struct.unpack(f"<{41 * 7}f", bytes(cloud.data)))
    assert cloud.header.frame_id in {link.child_frame_id for link in links}
    wrench = one("/atas/right/finger1/wrench", "geometry_msgs/msg/WrenchStamped")
    assert wrench.header.frame_id == cloud.header.frame_id
    urdf = one("/robot_description", "std_msgs/msg/String", latched=True, depth=1)
    assert "<robot" in urdf.data
    state = one("/atas/state", "atas_msgs/msg/DaemonState", latched=True, depth=1)
    assert (state.alive, state.mode) == (True, "ready")
    hand = one("/atas/right/state", "atas_msgs/msg/HandState")
    assert hand.hand == "right" and 0.0 < hand.opening_m < 0.2 and not hand.holds_object
    diagnostics = one("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    assert [of.name for of in diagnostics.status] == [
        "atas: daemon",
        "atas: left hand",
        "atas: right hand",
    ]


def test_parameters_are_read_and_changed_within_their_range(peer):
    node = "/atas/bridge"
    of = lambda name: f"rcl_interfaces/srv/{name}"  # noqa: E731
    names = peer.client(f"{node}/list_parameters", of("ListParameters"))
    get = peer.client(f"{node}/get_parameters", of("GetParameters"))
    set_ = peer.client(f"{node}/set_parameters", of("SetParameters"))
    describe = peer.client(f"{node}/describe_parameters", of("DescribeParameters"))
    for client in (names, get, set_, describe):
        client.wait_for_server()
    found = names.call(prefixes=["grasp"], depth=0).result.names
    assert "grasp.dr_n" in found
    before = get.call(names=["grasp.dr_n", "no.such"]).values
    assert [value.type for value in before] == [3, 0]
    value = cyclone("rcl_interfaces/msg/ParameterValue")
    parameter = cyclone("rcl_interfaces/msg/Parameter")
    change = lambda of: set_.call(  # noqa: E731
        parameters=[parameter(name="grasp.dr_n", value=value(type=3, double_value=of))]
    ).results[0]
    assert change(0.07).successful
    assert get.call(names=["grasp.dr_n"]).values[0].double_value == pytest.approx(0.07)
    refused = change(1e9)
    assert not refused.successful and refused.reason
    assert not change(math.nan).successful
    described = describe.call(names=["grasp.dr_n"]).descriptors[0]
    assert described.floating_point_range[0].to_value == pytest.approx(10.0)
    assert change(before[0].double_value).successful


def test_gripper_grasps_by_touch_within_the_force_limit(bench, peer):
    gripper = peer.action(*GRIPPER)
    gripper.wait_for_server()
    bench.move_hand(**OBJECT, yaw=math.pi / 2, opening=0.07)
    hand = peer.reader("/atas/right/state", "atas_msgs/msg/HandState")
    forces, peaks = {}, {}
    # Without a limit, then with one below the force that the controller chooses.
    for limit in (0.0, 0.3):
        read(hand, 0.1)
        status, result = gripper.execute(command=command(0.0, limit))
        assert status == SUCCEEDED, result
        assert result.stalled and not result.reached_goal, result
        assert 0.03 < result.position < 0.06, result
        states, _ = read(hand, 2.0)
        assert states[-1].holds_object
        strongest = [max(tip.normal_n for tip in state.fingertips) for state in states]
        forces[limit], peaks[limit] = statistics.median(strongest), max(strongest)
        print(
            f"gripper, limit {limit} N: {result.position * 1e3:.1f} mm, "
            f"{forces[limit]:.2f} N, at most {peaks[limit]:.2f} N"
        )
        status, result = gripper.execute(command=command(0.07))
        assert status == SUCCEEDED and result.reached_goal and not result.stalled, result
        wait(lambda: not read(hand, 0.2)[0][-1].holds_object, 5, "released")
    # The reading of a fingertip has noise of 0.02 N.
    assert forces[0.0] > 0.4 and 0.1 < forces[0.3] <= 0.3 * 1.05, forces
    assert peaks[0.3] <= 0.3 + 0.08, peaks


def test_parallel_gripper_moves_to_an_opening(peer):
    gripper = peer.action(*PARALLEL)
    gripper.wait_for_server()
    joints = cyclone("sensor_msgs/msg/JointState")
    status, result = gripper.execute(command=joints(position=[0.06]))
    assert status == SUCCEEDED and result.reached_goal
    assert result.state.position[0] == pytest.approx(0.06, abs=0.0015)


def test_impossible_commands_are_aborted_with_cause(peer):
    gripper, parallel = peer.action(*GRIPPER), peer.action(*PARALLEL)
    events = peer.reader("/atas/goal_events", "atas_msgs/msg/GoalEvent")
    gripper.wait_for_server()
    parallel.wait_for_server()
    for position, effort, part in (
        (math.nan, 0.0, "position is NaN"),
        (0.5, 0.0, "outside 0 to"),
        (0.02, -1.0, "max_effort is -1"),
        (0.02, 0.001, "below the smallest grip force"),
    ):
        goal_id = gripper.send(command=command(position, effort))
        status, result = gripper.result(goal_id)
        assert status == ABORTED and not result.reached_goal, (position, effort)
        seen = read(events, 0.5)[0]
        causes = [of.cause for of in seen if list(of.goal_id.uuid) == list(goal_id.uuid)]
        assert any(part in cause for cause in causes), (part, causes)
    joints = cyclone("sensor_msgs/msg/JointState")
    status, result = parallel.execute(command=joints(position=[0.01, 0.02]))
    assert status == ABORTED and "2 positions" in result.state.header.frame_id


def test_cancelled_gripper_stops(peer):
    gripper = peer.action(*GRIPPER)
    gripper.wait_for_server()
    assert gripper.execute(command=command(0.07))[0] == SUCCEEDED
    goal_id = gripper.send(command=command(0.001))
    time.sleep(0.3)
    assert gripper.cancel(goal_id) == 0
    status, result = gripper.result(goal_id)
    assert status == CANCELED and not result.reached_goal and result.position > 0.002, result
    assert gripper.cancel(goal_id) == 3, "the goal has ended"


def test_stop_and_recovery(bench, peer):
    stopped = trigger(peer, "/atas/stop")
    assert stopped.success and "socket" in stopped.message, stopped.message
    bench.wait_for_mode("safe-stop")
    gripper = peer.action(*GRIPPER)
    gripper.wait_for_server()
    status, _ = gripper.execute(command=command(0.05))
    assert status == ABORTED
    assert trigger(peer, "/atas/recover").success
    bench.wait_for_mode("ready")
    zeroed = trigger(peer, "/atas/left/zero")
    assert zeroed.success, zeroed.message


def test_killed_daemon_aborts_and_its_successor_executes(bench, peer):
    gripper = peer.action(*GRIPPER)
    gripper.wait_for_server()
    goal_id = gripper.send(command=command(0.01))
    bench.kill("atasd")
    status, _ = gripper.result(goal_id)
    assert status == ABORTED
    bench.start_daemon()
    bench.wait_for_mode("ready")
    wait(lambda: gripper.execute(command=command(0.06))[0] == SUCCEEDED, 20, "success")


def test_killed_bridge_holds_and_returns(bench, peer):
    gripper = peer.action(*GRIPPER)
    gripper.wait_for_server()
    gripper.send(command=command(0.001))
    wait(lambda: "goal teleop running" in bench.atas("status", check=False), 5, "running goal")
    bench.kill("bridge", by=signal.SIGKILL)
    wait(lambda: "goal teleop failed" in bench.atas("status", check=False), 5, "failed goal")
    bench.start_bridge()
    returned = Peer().action(*GRIPPER)
    returned.wait_for_server(timeout=20)
    wait(lambda: returned.execute(command=command(0.06))[0] == SUCCEEDED, 20, "success")
