"""ros2_control both ways, with Cyclone DDS in the place of its nodes."""

import math
import os
import threading
import time

import pytest
from bench import PROGRAMS, Bench, wait
from cyclone import Peer
from interfaces import cyclone
from test_dds import read

JOINTS = cyclone("sensor_msgs/msg/JointState")
CONTROLLERS = {
    "forward": ("/forward_position_controller/commands", "std_msgs/msg/Float64MultiArray"),
    "trajectory": (
        "/joint_trajectory_controller/joint_trajectory",
        "trajectory_msgs/msg/JointTrajectory",
    ),
}


def newest(reader):
    """Returns the newest sample that arrives."""
    return wait(lambda: read(reader, 0.1)[0], 5, "sample")[-1]


def test_daemon_follows_joint_commands_of_one_hand():
    with Bench(bridge=("--services", "cyclonedds", "--follow", "right")) as bench:
        peer = Peer()
        commands = peer.writer("/atas/joint_commands", "sensor_msgs/msg/JointState")
        joints = peer.reader("/joint_states", "sensor_msgs/msg/JointState")
        hand = peer.reader("/atas/right/state", "atas_msgs/msg/HandState")
        wait(commands.get_matched_subscriptions, 10, "bridge")
        time.sleep(0.5)
        commands.write(JOINTS(name=["right_elbow_pitch"], position=[math.nan]))
        commands.write(JOINTS(name=["right_elbow_pitch"], position=[]))
        before = newest(joints)
        start = newest(hand)
        index = before.name.index("right_elbow_pitch")
        wanted = before.position[index] - 0.15
        # A hardware interface of topics is silent while its commands do not change: one message.
        commands.write(JOINTS(name=["right_elbow_pitch"], position=[wanted]))
        moved = lambda: math.dist(  # noqa: E731
            *((of.centre_m.x, of.centre_m.y, of.centre_m.z) for of in (start, newest(hand)))
        )
        wait(lambda: moved() > 0.01, 10, "motion")
        time.sleep(2.0)
        at = newest(joints)
        time.sleep(1.0)
        later = newest(joints)
        assert max(abs(a - b) for a, b in zip(at.position, later.position, strict=True)) < 2e-3
        print(f"hand followed by {moved() * 1e3:.0f} mm, then kept its place in silence")
        # The stream of an empty hand ends after 10 s of silence, and the next command opens it.
        wait(lambda: "goal teleop cancelled" in bench.atas("status"), 15, "end of the stream")
        far = moved()
        commands.write(JOINTS(name=["right_elbow_pitch"], position=[wanted + 0.05]))
        wait(lambda: moved() < far - 0.003, 15, "motion of the next stream")


class Controllers(threading.Thread):
    """Stand-in for a controller manager: a forward controller and a joint state broadcaster."""

    def __init__(self, controller, names, position):
        super().__init__(daemon=True)
        self.peer = Peer()
        self.commands = self.peer.reader(*CONTROLLERS[controller])
        self.states = self.peer.writer("/joint_states", "sensor_msgs/msg/JointState")
        self.names = names
        self.position = position
        self.received, self.publishes, self.ends = [], True, False

    def run(self):
        while not self.ends:
            for sample in self.commands.take(100):
                positions = self.positions(sample)
                if positions:
                    self.received.append((time.monotonic(), positions))
                    self.position = positions
            if self.publishes:
                zeros = [0.0] * len(self.names)
                self.states.write(
                    JOINTS(
                        name=self.names[::-1],
                        position=self.position[::-1],
                        velocity=zeros,
                        effort=[math.nan] * len(zeros),
                    )
                )
            time.sleep(0.01)


    def positions(self, sample):
        """Returns the positions of a command; None for a sample without data."""
        if hasattr(sample, "data"):
            return list(sample.data)
        if not hasattr(sample, "points"):
            return None
        (point,) = sample.points
        assert list(sample.joint_names) == self.names
        reached_s = point.time_from_start.sec + point.time_from_start.nanosec * 1e-9
        assert 0.0 < reached_s < 0.1, reached_s
        return list(point.positions)


class Driven(Bench):
    """Daemon with the robot of the controllers, without tactile sensors."""

    def __init__(self, controller, names, position):
        Bench.count += 1
        self.bus = f"ros2-{os.getpid()}-{Bench.count}"
        self.environment = {**os.environ, "ATAS_BUS": self.bus}
        self.processes = {}
        self.bridge_arguments = [
            "--services", "cyclonedds", "--drive", controller, "--robot", "two-hand-arm",
        ]  # fmt: skip
        self.controllers = Controllers(controller, names, position)
        self.controllers.start()
        self.start_bridge()
        self.start_daemon()

    def start_daemon(self):
        """Starts a daemon that accepts joint states at 100 Hz."""
        self.start(
            "atasd",
            [
                PROGRAMS / "atasd", "--config", "/dev/null",
                "--set", "hands.left.required=false", "--set", "hands.right.required=false",
                "--set", "intake.hold_age_s=0.05",
            ],
        )  # fmt: skip

    def close(self):
        """Ends all processes and the controllers."""
        super().close()
        self.controllers.ends = True
        self.controllers.join()


@pytest.fixture(scope="module")
def robot():
    """Returns names and positions of the joints of a robot at home."""
    with Bench(bridge=("--services", "cyclonedds")):
        state = newest(Peer().reader("/joint_states", "sensor_msgs/msg/JointState"))
        return list(state.name), list(state.position)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_robot_of_controllers_is_held_by_the_daemon(robot, controller):
    with Driven(controller, *robot) as bench:
        of = bench.controllers
        start = list(of.position)
        bench.wait_for_mode("ready", timeout=20)
        wait(lambda: len(of.received) > 50, 10, "commands")
        drift = max(abs(a - b) for a, b in zip(of.position, start, strict=True))
        assert drift < 1e-3, "the daemon holds the robot where it is"
        gaps = [b[0] - a[0] for a, b in zip(of.received[-50:], of.received[-49:], strict=False)]
        print(f"commands at {1 / (sum(gaps) / len(gaps)):.0f} Hz, drift {drift:.1e} rad")
        # Lost joint states: hold; their return: ready.
        of.publishes = False
        bench.wait_for_mode("hold", timeout=5)
        of.publishes = True
        bench.wait_for_mode("ready", timeout=10)
        # A killed daemon: the last command expires and nothing more is sent.
        bench.kill("atasd")
        time.sleep(0.5)
        count = len(of.received)
        time.sleep(1.0)
        assert len(of.received) == count, "commands after their time-out"
        bench.start_daemon()
        bench.wait_for_mode("ready", timeout=20)
        wait(lambda: len(of.received) > count, 10, "commands of the new daemon")
        drift = max(abs(a - b) for a, b in zip(of.position, start, strict=True))
        assert drift < 1e-3, "no jump at the restart"
