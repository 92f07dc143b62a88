"""How fast the environments run: `python -m atas.bench`."""

from __future__ import annotations

import argparse
import json
import time

import numpy as np

from .environments import GraspEnv, GraspVectorEnv, HandEnv, PickPlaceEnv

STEP_S = 0.02
"""Simulated time of one step."""


def alone(environment: HandEnv, steps: int) -> float:
    """Simulated over processor time of one environment on one core."""
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


def together(count: int, steps: int) -> tuple[float, float]:
    """Simulated over wall time, and over processor time, of many on all cores."""
    environments = GraspVectorEnv(count)
    random = np.random.default_rng(0)
    environments.reset(seed=0)
    wall, cpu = time.monotonic(), time.process_time()
    for _ in range(steps):
        actions = random.uniform(-0.3, 0.3, (count, 5)).astype(np.float32)
        actions[:, 3:] += 0.2
        environments.step(actions)
    simulated = count * steps * STEP_S
    return simulated / (time.monotonic() - wall), simulated / (time.process_time() - cpu)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m atas.bench", description=__doc__)
    parser.add_argument("--steps", type=int, default=2000, help="default %(default)s")
    parser.add_argument("--format", choices=("human", "json"), default="human")
    options = parser.parse_args()
    vector_wall, vector_core = together(64, options.steps // 10)
    figures = {
        "grasp_realtime_factor": alone(GraspEnv(), options.steps),
        "pick_place_realtime_factor": alone(PickPlaceEnv(), options.steps),
        "vector_realtime_factor": vector_wall,
        "vector_realtime_factor_per_core": vector_core,
    }
    if options.format == "json":
        print(json.dumps(figures))
    else:
        for name, figure in figures.items():
            print(f"{name:34s} {figure:7.1f}")


if __name__ == "__main__":
    main()
