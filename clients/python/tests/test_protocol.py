"""Tests that the protocol page suffices for a sensor, a robot and a client of the real daemon in lock-step."""

import time
from typing import Any

import atas
import numpy as np
from conftest import Programs
from peer import PAYLOADS, Peer, epoch, newest, seal, send
from test_daemon import daemon

PATIENCE_S = 60.0
DOME_41 = 0x952863CB70A35143
FINAL = {
    atas.GoalState.SUCCEEDED,
    atas.GoalState.REJECTED,
    atas.GoalState.REFUSED,
    atas.GoalState.FAILED,
    atas.GoalState.CANCELLED,
}


def test_page_and_package_layouts_are_equal() -> None:
    assert len(PAYLOADS) >= 12 and "HandFrame" in PAYLOADS and "GoalRequest" in PAYLOADS
    for name, structure in PAYLOADS.items():
        known = atas.dtype(name)
        assert known.itemsize == len(bytes(structure()))
        assert known.names == tuple(field for field, _ in structure._fields_)


class ProtocolRobot:
    """A robot with sensors, implemented only from the protocol page."""

    def __init__(self, folder: str) -> None:
        self.peer = Peer(folder, "foreign")
        self.frames = [self.peer.publisher(f"atas/v2/hand-frame/{hand}") for hand in ("left", "right")]
        self.states = self.peer.publisher("atas/v3/joint-state")
        self.commands = self.peer.subscriber("atas/v2/joint-command")
        self.epoch = epoch()
        self.noise = np.random.default_rng(1)
        self.joints = atas.Simulation().joint_state["position"][:22].copy()
        self.joints[11] += 0.15
        self.sequence = 0
        self.update: Any = None

    def tick(self, pending: Any = None) -> Any:
        now_ns = 5_000_000_000 + self.sequence * 1_000_000
        for hand, publisher in enumerate(self.frames):
            frame = PAYLOADS["HandFrame"]()
            frame.stamp.sequence, frame.stamp.captured_ns, frame.stamp.writer_epoch = self.sequence, now_ns, self.epoch
            frame.layout_hash, frame.hand, frame.finger_count = DOME_41, hand, 2
            for finger in range(2):
                frame.valid_mask[finger] = 2**41 - 1
            force_n = np.ctypeslib.as_array(frame.force_n)
            force_n[:2, :41] = self.noise.normal(0, 1e-3, (2, 41, 3))
            seal(frame)
            send(publisher, frame)
        state = PAYLOADS["JointState"]()
        state.stamp.sequence, state.stamp.captured_ns, state.stamp.writer_epoch = self.sequence, now_ns, self.epoch
        state.joint_count = 22
        np.ctypeslib.as_array(state.position)[:22] = self.joints
        seal(state)
        send(self.states, state)
        command = self.answer(pending)
        if command is None:
            return None
        if command.joint_count == 22:
            self.joints += 0.5 * (np.ctypeslib.as_array(command.position)[:22] - self.joints)
        self.sequence += 1
        return command

    def answer(self, pending: Any) -> Any:
        """Returns the command that answers the last state; None after the end of the goal, when the daemon stops ticking."""
        begin = time.monotonic()
        while time.monotonic() - begin < PATIENCE_S:
            command = newest(self.commands, PAYLOADS["JointCommand"])
            if command is not None and command.answers_sequence == self.sequence:
                unsealed = command.crc32
                seal(command)
                assert command.crc32 == unsealed and command.joint_count in (0, 22)
                return command
            if pending is not None:
                self.update = newest(pending, PAYLOADS["GoalUpdate"]) or self.update
                if self.update is not None and self.update.state in FINAL:
                    return None
            for publisher in (*self.frames, self.states):
                publisher.update_connections()
            time.sleep(0.0005)
        raise AssertionError("no command received")


def test_protocol_peer_controls_the_daemon(programs: Programs) -> None:
    bus = daemon(programs)
    statuses = bus.statuses()
    world = ProtocolRobot(bus.folder)
    modes = [world.tick().mode for _ in range(100)]
    assert modes[-1] == atas.Mode.READY, modes[-5:]
    goals = world.peer.client("atas/v3/goal")
    request = PAYLOADS["GoalRequest"]()
    request.stamp.captured_ns, request.goal_id = time.monotonic_ns(), epoch()
    request.kind, request.hand = atas.GoalKind.RELEASE, atas.Hand.RIGHT
    pending = goals.send_copy(request)
    while world.tick(pending) is not None:
        pass
    assert world.update.state == atas.GoalState.SUCCEEDED and world.update.goal_id == request.goal_id
    status = statuses.newest()
    assert status is not None
    for hand in status["hands"]:
        assert hand["frames"] > 100 and not any(hand[count] for count in ("lost", "corrupt", "foreign", "mistimed"))
