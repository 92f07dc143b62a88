"""Topics, services and actions over DDS, with Debian's Fast DDS as the peer.

The peer carries bytes; `rosbags` encodes and decodes them.
"""

import os
import subprocess
import uuid

import numpy
import pytest
from bench import Bench
from interfaces import STORE, dds_name

PEER = os.environ.get("FAST_PEER")
pytestmark = pytest.mark.skipif(not PEER, reason="FAST_PEER is not set; see tests/ros2.sh")


class FastPeer:
    """Process of the peer."""

    def __init__(self):
        self.process = subprocess.Popen(
            [PEER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, *words):
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().strip()

    def open(self, name, of):
        """Opens a client of a service."""
        request, reply = dds_name(f"{of}_Request"), dds_name(f"{of}_Response")
        answer = self.ask("open", name, f"rq{name}Request", request, f"rr{name}Reply", reply)
        assert answer == "open", answer

    def call(self, name, of, request, seconds=60):
        """Calls an open service; returns the response."""
        text = bytes(STORE.serialize_cdr(request, f"{of}_Request")).hex()
        answer = self.ask("call", name, seconds, text)
        assert answer != "timeout"
        return STORE.deserialize_cdr(bytes.fromhex(answer), f"{of}_Response")

    def close(self):
        self.process.stdin.close()
        self.process.wait(timeout=10)


@pytest.fixture(scope="module")
def bench():
    with Bench(bridge=("--services", "fastdds")) as running:
        yield running


@pytest.fixture(scope="module")
def peer(bench):
    of = FastPeer()
    yield of
    of.close()


def make(name, **fields):
    return STORE.types[name](**fields)


def test_joint_states_arrive_at_the_chosen_rate(peer):
    name = "sensor_msgs/msg/JointState"
    count, p50, p99, most, text = peer.ask("listen", "rt/joint_states", dds_name(name), 10).split()
    print(f"Fast DDS, joint states: {count} in 10 s, gap p50 {p50} p99 {p99} max {most} ms")
    assert 980 <= int(count) <= 1020 and float(p99) <= 15.0
    state = STORE.deserialize_cdr(bytes.fromhex(text), name)
    assert len(state.name) == len(state.position) == 22


def test_stop_and_recovery(bench, peer):
    of = "std_srvs/srv/Trigger"
    for service, mode in (("/atas/stop", "safe-stop"), ("/atas/recover", "ready")):
        peer.open(service, of)
        request = STORE.types[f"{of}_Request"]()
        response = peer.call(service, of, request)
        assert response.success, response.message
        bench.wait_for_mode(mode)


def test_gripper_moves_and_refuses(peer):
    name, of = "/atas/left/gripper_cmd", "control_msgs/action/GripperCommand"
    base = f"{name}/_action"
    peer.open(f"{base}/send_goal", f"{of}_SendGoal")
    peer.open(f"{base}/get_result", f"{of}_GetResult")
    for position, expected in ((0.05, 4), (0.5, 6)):
        goal_id = make("unique_identifier_msgs/msg/UUID", uuid=_bytes())
        command = make("control_msgs/msg/GripperCommand", position=position, max_effort=0.0)
        goal = make(f"{of}_Goal", command=command)
        request = make(f"{of}_SendGoal_Request", goal_id=goal_id, goal=goal)
        assert peer.call(f"{base}/send_goal", f"{of}_SendGoal", request).accepted
        request = make(f"{of}_GetResult_Request", goal_id=goal_id)
        response = peer.call(f"{base}/get_result", f"{of}_GetResult", request)
        assert response.status == expected
        assert response.result.reached_goal == (expected == 4)


def _bytes():
    return numpy.frombuffer(uuid.uuid4().bytes, dtype=numpy.uint8)
