"""Speed of the environments (`python -m atas.bench`) and cost of a Python sensor (`python -m atas.bench --sensor 60`)."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import numpy as np

from ._native import Bus, wipe
from .arguments import count, need_gymnasium, seconds
from .rate import Rate

if TYPE_CHECKING:
    from .environments import HandEnv

STEP_S = 0.02
"""Simulated time of one step, s."""


def single_factor(environment: HandEnv, steps: int) -> float:
    """Ratio of simulated to processor time of one environment on one core."""
    random = np.random.default_rng(0)
    actions = random.uniform(-0.3, 0.3, (steps, 5)).astype(np.float32)
    actions[:, 3:] += 0.2
    environment.reset(seed=0)
    begin = time.process_time()
    for action in actions:
        _, _, terminated, truncated, _ = environment.step(action)
        if terminated or truncated:
            environment.reset()
    return steps * STEP_S / (time.process_time() - begin)


def vector_factors(number: int, steps: int) -> tuple[float, float]:
    """Ratios of simulated to wall time and to processor time of `number` environments on all cores."""
    from .environments import GraspVectorEnv

    environments = GraspVectorEnv(number)
    random = np.random.default_rng(0)
    environments.reset(seed=0)
    wall, cpu = time.monotonic(), time.process_time()
    for _ in range(steps):
        actions = random.uniform(-0.3, 0.3, (number, 5)).astype(np.float32)
        actions[:, 3:] += 0.2
        environments.step(actions)
    simulated = number * steps * STEP_S
    return simulated / (time.monotonic() - wall), simulated / (time.process_time() - cpu)


def environments(steps: int) -> dict[str, float]:
    """Real-time factors of the environments."""
    need_gymnasium()
    from .environments import GraspEnv, PickPlaceEnv

    vector_wall, vector_core = vector_factors(64, steps // 10)
    return {
        "grasp_realtime_factor": single_factor(GraspEnv(), steps),
        "pick_place_realtime_factor": single_factor(PickPlaceEnv(), steps),
        "vector_realtime_factor": vector_wall,
        "vector_realtime_factor_per_core": vector_core,
    }


def publish(bus: str, seconds: float) -> None:
    """Sensor process: prints the processor share of its loop without and with publishing."""
    sensor = Bus(bus, role="sensor-left", create=True).sensor("left")
    force_n = np.zeros((2, 41, 3), np.float32)
    shares = []
    for publishes in (False, True):
        begin, cpu = time.monotonic(), time.process_time()
        for tick in Rate(1000, seconds):
            force_n[0, 0, 0] = tick
            if publishes:
                sensor.publish(force_n)
        shares.append((time.process_time() - cpu) / (time.monotonic() - begin))
    print(json.dumps({"loop_cores": shares[0], "sensor_cores": shares[1]}))


def sensor(seconds: float) -> dict[str, float]:
    """Figures of a 1 kHz sensor in a child process and a reader in this one."""
    name = f"bench-{os.getpid()}"
    bus = Bus(name, create=True)
    frames, received = bus.frames("left"), 0
    words = [sys.executable, "-m", "atas.bench", "--publish", name, "--sensor", str(seconds)]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as child:
        while child.poll() is None:
            received += len(frames.wait(0.1))
        received += len(frames.receive())
        told: dict[str, float] = json.loads(child.stdout.read() if child.stdout else b"")
    sent = round(seconds * 1000)
    cost = {"publishing_cores": told["sensor_cores"] - told["loop_cores"]}
    figures = {"sent": sent, "received": received, "lost": frames.lost} | told | cost
    del frames, bus
    wipe(name)
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m atas.bench", description=__doc__)
    parser.add_argument("--steps", type=count(100), default=2000, help="default %(default)s")
    parser.add_argument("--sensor", type=seconds, metavar="SECONDS", help="measure a 1 kHz sensor for this time instead")
    parser.add_argument("--publish", metavar="BUS", help=argparse.SUPPRESS)
    parser.add_argument("--format", choices=("human", "json"), default="human")
    options = parser.parse_args()
    if options.publish:
        publish(options.publish, options.sensor)
        return
    figures = sensor(options.sensor) if options.sensor is not None else environments(options.steps)
    if options.format == "json":
        print(json.dumps(figures))
    else:
        for name, figure in figures.items():
            print(f"{name:34s} {figure:10.4g}")


if __name__ == "__main__":
    main()
