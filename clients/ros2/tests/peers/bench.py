"""Processes of a test: simulator, daemon, bridge, each on a bus of its own."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).parents[4]
PROGRAMS = Path(os.environ.get("ATAS_PROGRAMS", ROOT / "target/debug"))
BRIDGE = os.environ.get("ATAS_ROS2", str(ROOT / "target/ros2/debug/atas-ros2"))
LOGS = Path(os.environ.get("ATAS_LOGS", "/tmp"))


class Bench:
    """Robot, daemon and bridge on one bus.

    The daemon tolerates the pauses of a busy machine.
    """

    count = 0

    def __init__(self, scene=("--object", "wood"), bridge=(), daemon=(), start_bridge=True):
        Bench.count += 1
        self.bus = f"ros2-{os.getpid()}-{Bench.count}"
        self.environment = {**os.environ, "ATAS_BUS": self.bus}
        self.processes = {}
        self.bridge_arguments = [str(argument) for argument in bridge]
        self.start("sim", [PROGRAMS / "atas-sim", "run", *scene])
        self.daemon_arguments = daemon
        self.start_daemon()
        self.wait_for_mode("ready")
        if start_bridge:
            self.start_bridge()

    def start(self, name, command):
        """Starts a process with a log of its own."""
        log = open(LOGS / f"{self.bus}-{name}.log", "ab")
        self.processes[name] = subprocess.Popen(
            [str(part) for part in command], env=self.environment, stdout=log, stderr=log
        )
        return self.processes[name]

    def start_daemon(self):
        """Starts the daemon."""
        patient = ("--set", "intake.hold_age_s=0.08")
        words = [PROGRAMS / "atasd", "--config", "/dev/null", *patient, *self.daemon_arguments]
        return self.start("atasd", words)

    def start_bridge(self):
        """Starts the bridge."""
        return self.start("bridge", [BRIDGE, *self.bridge_arguments])

    def kill(self, name, by=signal.SIGKILL):
        """Ends a process and waits for its end."""
        process = self.processes.pop(name)
        process.send_signal(by)
        process.wait(timeout=10)

    def atas(self, *words, check=True, timeout=60):
        """Runs a command of the console; returns its output."""
        done = subprocess.run(
            [str(PROGRAMS / "atas"), *map(str, words)],
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        assert not check or done.returncode == 0, f"atas {words}: {done.stdout}{done.stderr}"
        return done.stdout + done.stderr

    def mode(self):
        """Returns the mode of the daemon."""
        found = re.search(r"^mode (\S+?)[:,]?(\s|$)", self.atas("status", check=False), re.M)
        return found.group(1) if found else None

    def wait_for_mode(self, mode, timeout=10):
        """Waits until the daemon has this mode."""
        end = time.monotonic() + timeout
        while self.mode() != mode:
            assert time.monotonic() < end, f"mode is {self.mode()}, not {mode}"
            time.sleep(0.05)

    def move_hand(self, x, y, z, yaw, opening, seconds=4.0):
        """Moves the right hand there by teleoperation; the fingers stay open."""
        path = LOGS / f"{self.bus}-targets.csv"
        rows = ["t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m"]
        for step in range(int(seconds * 20)):
            rows.append(f"{step / 20:.2f},right,{x},{y},{z},{yaw},{opening}")
        path.write_text("\n".join(rows))
        self.atas("teleop", path)

    def close(self):
        """Ends all processes, the bridge first."""
        for name in ("bridge", *list(self.processes)):
            process = self.processes.pop(name, None)
            if process is not None:
                process.terminate()
                try:
                    process.wait(timeout=10)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def wait(condition, timeout, what):
    """Polls a condition until it returns a true value."""
    end = time.monotonic() + timeout
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < end, f"{what}: not within {timeout} s"
        time.sleep(0.002)
