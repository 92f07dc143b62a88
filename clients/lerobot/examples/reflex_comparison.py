"""Trains the smallest policy of LeRobot on simulated grasps; runs it with and without the reflex.

    python reflex_comparison.py --out comparison

1. Records 20 episodes of a scripted operator with the robot `atas_simulation` as a data set.
2. Trains ACT with 0.2 million parameters by `lerobot-train` on the CPU.
3. Runs the policy on unseen seeds twice: above the tactile reflex, and with the reflex removed.
   Both runs of a seed have the same object, noise and policy.

An episode succeeds if the object is lifted by at least half of the 40 mm, held by both
fingertips, and neither crushed nor dropped. Needs `lerobot[core-scripts,training]`.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from atas.features import ENVIRONMENT
from lerobot.common.control_utils import predict_action
from lerobot.datasets import LeRobotDataset
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.utils.feature_utils import build_dataset_frame
from lerobot_robot_atas import AtasSimulation, AtasSimulationConfig

ITEMS = ("wood", "sponge", "paper-box")
FPS = 20
LIFT_M = 0.04
SECONDS = 16
TASK = "Grasp the object and lift it."
FIRST_TEST_SEED = 1000


def ramp(times_s: list[float], values: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Values between way points, FPS times per second."""
    for tick in range(SECONDS * FPS):
        time_s = tick / FPS
        yield np.array([np.interp(time_s, times_s, [value[axis] for value in values]) for axis in range(5)])


def operator(robot: AtasSimulation, random: np.random.Generator) -> Iterator[dict[str, float]]:
    """A scripted operator: above the object, down, close, lift, hold.

    He knows the nominal object, misses it by about 1 mm and 2 degrees, and closes 3 to 5 mm more
    than its width: the reflex beneath chooses the force.
    """
    hint = robot.simulation.hint
    seen = robot.get_observation()
    now = np.array([seen[name] for name in robot.action_features])
    x, y, z = hint["at"]
    shift, yaw = random.normal(0.0, 1e-3, 2), hint["yaw"] + random.normal(0.0, 0.03)
    width, closed = hint["width"], hint["width"] - random.uniform(0.003, 0.005)

    def pose(up: float, opening: float) -> np.ndarray:
        return np.array([x + shift[0], y + shift[1], z + up, yaw, opening])

    wide = width + 0.018
    times_s = [0.0, 2.0, 4.0, 4.5, 8.0, 9.0, 11.0, SECONDS]
    values = [now, pose(0.06, wide), pose(0.0, wide), pose(0.0, wide), pose(0.0, closed), pose(0.0, closed)]
    values += [pose(LIFT_M, closed)] * 2
    for value in ramp(times_s, values):
        yield dict(zip(robot.action_features, map(float, value), strict=True))


def features(robot: AtasSimulation) -> dict[str, dict[str, Any]]:
    """Features of the data set: those of `atas export --to lerobot`."""
    names = {
        "observation.state": [name for name in robot.observation_features if name not in ENVIRONMENT],
        "observation.environment_state": list(ENVIRONMENT),
        "action": list(robot.action_features),
    }
    return {key: {"dtype": "float32", "shape": (len(of),), "names": of} for key, of in names.items()}


def simulated(folder: Path, reflex: bool) -> AtasSimulation:
    """A connected robot."""
    robot = AtasSimulation(AtasSimulationConfig(id="comparison", calibration_dir=folder, fps=FPS, reflex=reflex))
    robot.connect()
    return robot


def outcome(robot: AtasSimulation) -> dict[str, Any]:
    """True result of an episode."""
    truth = robot.simulation.truth
    held = truth["objects"][0]
    pressed = min(truth["normal_n"][robot.features.index][:2]) > 0.03
    crushed, dropped = bool(held["crushed"]), bool(held["dropped"])
    lifted = float(held["lifted_m"]) >= LIFT_M / 2
    return {
        "success": lifted and pressed and not crushed and not dropped,
        "crushed": crushed,
        "dropped": dropped,
        "peak_n": robot.hand.peak_n,
    }


def record(out: Path, episodes: int, scratch: Path) -> None:
    """Records the operator."""
    robot = simulated(scratch, reflex=True)
    dataset = LeRobotDataset.create(
        "atas/comparison", fps=FPS, features=features(robot), root=out, robot_type=robot.name, use_videos=False
    )
    successes = 0
    for episode in range(episodes):
        random = np.random.default_rng(episode)
        robot.begin_episode(episode, ITEMS[episode % len(ITEMS)])
        for action in operator(robot, random):
            seen = robot.get_observation()
            sent = robot.send_action(action)
            frame = build_dataset_frame(dataset.features, seen, "observation")
            dataset.add_frame(frame | build_dataset_frame(dataset.features, sent, "action") | {"task": TASK})
        dataset.save_episode()
        successes += outcome(robot)["success"]
    dataset.finalize()
    print(f"recorded {episodes} episodes, {successes} successful, {dataset.num_frames} frames in {out}")


def train(dataset: Path, out: Path, steps: int) -> None:
    """Trains by LeRobot's own command."""
    options = {
        "dataset.repo_id": "atas/comparison",
        "dataset.root": dataset,
        "policy.type": "act",
        "policy.device": "cpu",
        "policy.push_to_hub": "false",
        "policy.chunk_size": FPS,
        "policy.n_action_steps": FPS // 2,
        "policy.dim_model": 64,
        "policy.n_heads": 4,
        "policy.dim_feedforward": 256,
        "policy.n_encoder_layers": 2,
        "policy.use_vae": "false",
        "policy.optimizer_lr": 3e-4,
        "batch_size": 64,
        "num_workers": 0,
        "persistent_workers": "false",
        "steps": steps,
        "log_freq": 500,
        "save_freq": steps,
        "env_eval_freq": 0,
        "wandb.enable": "false",
        "seed": 1,
        "output_dir": out,
    }
    program = Path(sys.executable).with_name("lerobot-train")
    # Several threads of a policy this small wait for each other more than they compute.
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    given = [f"--{name}={value}" for name, value in options.items()]
    subprocess.run([program, *given], env=environment, check=True)


def run(robot: AtasSimulation, policy: Any, processors: Any, dataset: LeRobotDataset) -> dict[str, Any]:
    """Runs the policy for one episode."""
    policy.reset()
    names = dataset.features["action"]["names"]
    for _ in range(SECONDS * FPS):
        seen = build_dataset_frame(dataset.features, robot.get_observation(), "observation")
        action = predict_action(seen, policy, torch.device("cpu"), *processors, use_amp=False, task=TASK)
        robot.send_action(dict(zip(names, action.squeeze(0).tolist(), strict=True)))
    return outcome(robot)


def compare(dataset: LeRobotDataset, checkpoint: Path, pairs: int, scratch: Path) -> dict[str, list[dict[str, Any]]]:
    """Runs the policy on each seed, with and without the reflex."""
    policy = ACTPolicy.from_pretrained(checkpoint)
    policy.eval()
    processors = make_pre_post_processors(policy.config, pretrained_path=str(checkpoint))
    results: dict[str, list[dict[str, Any]]] = {}
    for name, reflex in (("with", True), ("without", False)):
        robot = simulated(scratch, reflex)
        results[name] = []
        for pair in range(pairs):
            item = ITEMS[pair % len(ITEMS)]
            robot.begin_episode(FIRST_TEST_SEED + pair, item)
            result = run(robot, policy, processors, dataset)
            results[name].append({"item": item, "seed": FIRST_TEST_SEED + pair} | result)
            print(f"{name} the reflex: {pair + 1} of {pairs} episodes", file=sys.stderr, flush=True)
        robot.disconnect()
    return results


def report(results: dict[str, list[dict[str, Any]]]) -> str:
    """A table of the results by object."""
    lines = ["| reflex | object | success | crushed | dropped | median peak force, N |", "|---|---|---|---|---|---|"]
    for name, rows in results.items():
        for item in (*ITEMS, "all"):
            own = [row for row in rows if item in (row["item"], "all")]
            if own:
                count = {what: sum(row[what] for row in own) for what in ("success", "crushed", "dropped")}
                peak = float(np.median([row["peak_n"] for row in own]))
                cells = [f"{count[what]} of {len(own)}" for what in count]
                lines.append(f"| {name} | {item} | {' | '.join(cells)} | {peak:.2f} |")
    return "\n".join(lines)


def main() -> None:
    """Runs all three steps; a step whose folder exists is not repeated."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="folder of data set, policy, results")
    parser.add_argument("--episodes", type=int, default=20, help="episodes to record (default %(default)s)")
    parser.add_argument("--steps", type=int, default=1500, help="training steps (default %(default)s)")
    parser.add_argument("--pairs", type=int, default=60, help="test episodes with and without (default %(default)s)")
    given = parser.parse_args()
    if min(given.episodes, given.steps, given.pairs) < 1:
        parser.error("--episodes, --steps and --pairs need at least 1")
    given.out.mkdir(parents=True, exist_ok=True)
    data, policy = given.out / "dataset", given.out / "policy"
    with tempfile.TemporaryDirectory() as scratch:
        if not data.exists():
            record(data, given.episodes, Path(scratch))
        if not policy.exists():
            train(data, policy, given.steps)
        checkpoint = policy / "checkpoints" / "last" / "pretrained_model"
        dataset = LeRobotDataset("atas/comparison", root=data)
        results = compare(dataset, checkpoint, given.pairs, Path(scratch))
    (given.out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    print(report(results))
    if not all(math.isfinite(row["peak_n"]) for rows in results.values() for row in rows):
        sys.exit("a force is not finite")


if __name__ == "__main__":
    main()
