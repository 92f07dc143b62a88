"""Learning baseline for grasping: the cross-entropy method with six parameters.

    python -m atas.learn --out grasp.svg

The policy has no memory. It learns the dependence of grip force on load and slip, without knowing the object's weight, friction and
softness. Training and evaluation use different seeds.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .arguments import count, need_gymnasium

need_gymnasium()

from .environments import GraspVectorEnv, Observation  # noqa: E402 -- after the check for gymnasium

Numbers = NDArray[np.float64]

SIZE = 6
"""Number of parameters: minimum force, gains of load, slip and closing speed, lift threshold, lift speed; see `act`."""
TEST_SEED = 1_000_000
"""First seed of the evaluation; training uses lower seeds."""


def act(parameters: Numbers, seen: Observation) -> NDArray[np.float32]:
    """Returns the actions of policies, one row per policy and observation.

    The desired normal force of a grasp side increases with tangential force and friction utilisation. The hand lifts while both
    sides reach it. Softplus keeps gains positive; the logistic function limits the lift parameters to 0 to 1.
    """
    normal, tangential, utilisation = (seen["percept"][:, :, i].astype(np.float64) for i in (0, 1, 3))
    least, load, slip, haste = (np.logaddexp(0.0, parameters[:, i, None]) for i in range(4))
    ready, speed = (1.0 / (1.0 + np.exp(-parameters[:, i])) for i in (4, 5))
    wanted = least + load * tangential + slip * np.clip(utilisation - 0.7, 0.0, 1.0) * np.abs(normal)
    actions = np.zeros((len(parameters), 5), np.float32)
    actions[:, 3:] = np.clip(haste * (wanted - normal) / wanted, -1.0, 1.0)
    actions[:, 2] = speed * ((normal / wanted).min(axis=1) > ready)
    return actions


def run_episodes(environments: GraspVectorEnv, parameters: Numbers, seeds: NDArray[np.int64]) -> tuple[Numbers, NDArray[np.str_]]:
    """Runs one episode per policy and seed; returns returns and ends."""
    seen, infos = environments.reset(seed=[int(seed) for seed in seeds])
    worth = np.zeros(len(seeds))
    over = np.zeros(len(seeds), np.bool_)
    while not over.all():
        seen, reward, terminated, truncated, infos = environments.step(act(parameters, seen))
        worth += reward
        over |= terminated | truncated
    return worth, infos["end"]


def learn(
    generations: int, population: int, episodes: int, seed: int, objects: list[str] | None, quiet: bool
) -> tuple[Numbers, list[dict[str, float]]]:
    """Returns the mean of the last generation's distribution and the learning curve."""
    random = np.random.default_rng(seed)
    elite_count = max(population // 5, 3)
    mean, deviation = np.zeros(SIZE), np.full(SIZE, 1.0)
    environments = GraspVectorEnv(population * episodes, objects=objects, autoreset=False)
    curve = []
    begin = time.monotonic()
    for generation in range(generations):
        candidates = mean + deviation * random.standard_normal((population, SIZE))
        candidates[0] = mean
        # All candidates run the same episodes; each generation has new ones.
        seeds = seed * 100_000 + generation * episodes + np.arange(episodes, dtype=np.int64)
        worth, ends = run_episodes(environments, np.repeat(candidates, episodes, axis=0), np.tile(seeds, population))
        returns = worth.reshape(population, episodes).mean(axis=1)
        elite = candidates[np.argsort(-returns, kind="stable")[:elite_count]]
        # The added deviation decreases; it prevents early convergence.
        mean, deviation = elite.mean(axis=0), elite.std(axis=0) + 0.3 * 0.7**generation
        success = (ends == "success").reshape(population, episodes).mean(axis=1)
        row = {
            "generation": generation,
            "return_mean": float(returns.mean()),
            "return_best": float(returns.max()),
            "success_mean": float(success.mean()),
            "success_best": float(success.max()),
            "wall_s": time.monotonic() - begin,
        }
        curve.append(row)
        if not quiet:
            print(
                "generation {generation:2.0f}  return {return_mean:6.2f}, best {return_best:6.2f}  "
                "success {success_mean:5.1%}, best {success_best:5.1%}  {wall_s:5.0f} s".format(**row),
                flush=True,
            )
    return mean, curve


def evaluate(parameters: Numbers, trials: int, objects: list[str] | None) -> dict[str, float]:
    """Returns the shares of episode ends on unseen seeds."""
    environments = GraspVectorEnv(trials, objects=objects, autoreset=False)
    worth, ends = run_episodes(environments, np.tile(parameters, (trials, 1)), TEST_SEED + np.arange(trials, dtype=np.int64))
    shares = {end: float((ends == end).mean()) for end in ("success", "crushed", "dropped", "tipped")}
    return {"trials": trials, "return": float(worth.mean()), **shares, "never": 1.0 - sum(shares.values())}


def draw(curve: list[dict[str, float]], judged: dict[str, float]) -> str:
    """Returns the learning curve as SVG."""
    width, height, left, bottom = 640, 320, 56, 40
    across, up = width - left - 16, height - bottom - 36
    last = max(len(curve) - 1, 1)

    def line(key: str, style: str) -> str:
        points = " ".join(
            f"{left + across * row['generation'] / last:.1f},{height - bottom - up * row[key]:.1f}" for row in curve
        )
        return f'<polyline fill="none" {style} points="{points}"/>'

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="{left}" y="20">atas/Grasp-v0, cross-entropy method: share of grasps that succeed; '
        f"{judged['success']:.1%} of {judged['trials']:.0f} on unseen seeds</text>",
    ]
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        y = height - bottom - up * share
        parts.append(f'<line x1="{left}" x2="{left + across}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{left - 8}" y="{y + 4:.1f}" text-anchor="end">{share:.0%}</text>')
    for generation in range(0, len(curve), max(len(curve) // 10, 1)):
        x = left + across * generation / last
        parts.append(f'<text x="{x:.1f}" y="{height - bottom + 18}" text-anchor="middle">{generation}</text>')
    parts += [
        line("success_best", 'stroke="#2a78b8" stroke-width="2" stroke-dasharray="5 3"'),
        line("success_mean", 'stroke="#2a78b8" stroke-width="2"'),
        f'<text x="{left + across / 2}" y="{height - 6}" text-anchor="middle">generation (solid: mean of the candidates, '
        "dashed: the best)</text>",
        "</svg>\n",
    ]
    return "\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m atas.learn", description="Learns to grasp with the cross-entropy method.")
    parser.add_argument("--generations", type=count(1), default=12, help="default %(default)s")
    parser.add_argument("--population", type=count(3), default=24, help="candidates per generation, default %(default)s")
    parser.add_argument("--episodes", type=count(1), default=12, help="per candidate, default %(default)s")
    parser.add_argument("--trials", type=count(1), default=200, help="unseen episodes at the end, default %(default)s")
    parser.add_argument("--seed", type=count(0), default=1, help="default %(default)s")
    parser.add_argument("--objects", nargs="+", help="built-in names or TOML files; default: all feasible objects")
    parser.add_argument("--out", type=Path, help="SVG file of the learning curve")
    parser.add_argument("--format", choices=("human", "json"), default="human")
    options = parser.parse_args()
    if options.out and not options.out.parent.is_dir():
        parser.error(f"could not write {options.out}: folder {options.out.parent} does not exist; create it")
    is_json = options.format == "json"
    parameters, curve = learn(
        options.generations, options.population, options.episodes, options.seed, options.objects, is_json
    )
    judged = evaluate(parameters, options.trials, options.objects)
    if options.out:
        options.out.write_text(draw(curve, judged), encoding="utf-8")
    if is_json:
        print(json.dumps({"parameters": parameters.tolist(), "curve": curve, "unseen": judged}))
    else:
        print("unseen seeds: " + ", ".join(f"{key} {value:.3g}" for key, value in judged.items()))


if __name__ == "__main__":
    main()
