"""Topics, services and actions over Zenoh, with pyzeros and eclipse-zenoh's router as peers."""

import asyncio
import math
import os
import subprocess
import sys
import time
import uuid
from pathlib import Path

import numpy
import pytest
from bench import Bench
from interfaces import STORE

pytestmark = pytest.mark.skipif(
    not os.environ.get("ATAS_ZENOH"), reason="ATAS_ZENOH is not set; see tests/ros2.sh"
)
ROUTER = Path(__file__).with_name("zenoh_router.py")


def message(name):
    """Returns the type of a message as pyzeros expects it, encoded by rosbags."""

    class Type:
        def __init__(self, **fields):
            self.value = STORE.types[name](**fields)

        @classmethod
        def get_type_name(cls):
            return name

        @classmethod
        def hash_rihs01(cls):
            return STORE.hash_rihs01(name)

        def serialize(self):
            return bytes(STORE.serialize_cdr(self.value, name))

        @classmethod
        def deserialize(cls, data):
            return STORE.deserialize_cdr(bytes(data), name)

    return Type


def service(name):
    """Returns the type of a service as pyzeros expects it."""

    class Type:
        Request = message(f"{name}_Request")
        Response = message(f"{name}_Response")

        @classmethod
        def get_type_name(cls):
            return name

        @classmethod
        def hash_rihs01(cls):
            return STORE.hash_rihs01(name)

    return Type


@pytest.fixture(scope="module")
def bench():
    router = subprocess.Popen([sys.executable, str(ROUTER)], stdout=subprocess.PIPE, text=True)
    assert router.stdout.readline().strip() == "ready"
    with Bench(bridge=("--middleware", "zenoh")) as running:
        time.sleep(2.0)
        yield running
    router.kill()
    router.wait()


@pytest.fixture(scope="module")
def node(bench):
    import pyzeros
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("connect/endpoints", '["tcp/127.0.0.1:7447"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        yield pyzeros.Node("test", session=session, namespace="/test")


def call(node, name, of, seconds=60, **fields):
    """Calls a service; returns the response."""
    import pyzeros

    async def run():
        client = pyzeros.Client(service(of), name, session=node, scope=None)
        await asyncio.wait_for(client.wait_for_service(), 10)
        answer = await asyncio.wait_for(
            client.call_async(service(of).Request(**fields)), seconds
        )
        client.close()
        return answer

    return asyncio.run(run())


def test_joint_states_arrive_at_the_chosen_rate(node):
    from pyzeros.sub import RawSub

    times, samples = [], []

    def receive(sample):
        times.append(time.monotonic())
        samples.append(bytes(sample.payload))

    name = "sensor_msgs/msg/JointState"
    sub = RawSub(message(name), "/joint_states", receive, session=node, scope=None)
    time.sleep(11.0)
    sub.close()
    begin = times[0] + 1.0
    gaps_ms = numpy.diff([at for at in times if at > begin]) * 1e3
    p50, p99, most = numpy.percentile(gaps_ms, [50, 99, 100])
    print(f"Zenoh, joint states: {len(gaps_ms)}, gap p50 {p50:.2f} p99 {p99:.2f} max {most:.2f} ms")
    assert p99 <= 15.0
    state = STORE.deserialize_cdr(samples[-1], name)
    assert len(state.name) == len(state.position) == 22


def test_stop_and_recovery(bench, node):
    assert call(node, "/atas/stop", "std_srvs/srv/Trigger").success
    bench.wait_for_mode("safe-stop")
    assert call(node, "/atas/recover", "std_srvs/srv/Trigger").success
    bench.wait_for_mode("ready")


def test_gripper_moves_and_refuses(node):
    name, of = "/atas/left/gripper_cmd", "control_msgs/action/GripperCommand"
    for position, expected in ((0.05, 4), (math.nan, 6)):
        uid = numpy.frombuffer(uuid.uuid4().bytes, dtype=numpy.uint8)
        goal_id = STORE.types["unique_identifier_msgs/msg/UUID"](uuid=uid)
        command = STORE.types["control_msgs/msg/GripperCommand"](
            position=position, max_effort=0.0
        )
        goal = STORE.types[f"{of}_Goal"](command=command)
        base = f"{name}/_action"
        accepted = call(node, f"{base}/send_goal", f"{of}_SendGoal", goal_id=goal_id, goal=goal)
        assert accepted.accepted
        answer = call(node, f"{base}/get_result", f"{of}_GetResult", goal_id=goal_id)
        assert answer.status == expected
        assert answer.result.reached_goal == (expected == 4)


def test_parameters_are_read(node):
    answer = call(
        node,
        "/atas/bridge/get_parameters",
        "rcl_interfaces/srv/GetParameters",
        names=["grasp.dr_n"],
    )
    assert answer.values[0].type == 3 and answer.values[0].double_value > 0.0
