"""A policy with jittered targets, with and without the tactile reflex beneath.

    python jittered_policy.py --seeds 100

A scripted policy grasps and lifts an object by targets of the pose and the opening. Each target is
late by up to 40 % of the period, and has errors of 1 mm (position), 1 degree (yaw) and 2 mm
(opening), root mean square, anew for each target. The opening is too narrow by 4 mm on average.
Both runs of a seed have the same object, noise and targets. Without the reflex the hand executes
the requested openings. Prints a Markdown table, or JSON with `--json`.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from atas import AtasError
from atas.hands import SimulatedHand

ITEMS = ("wood", "sponge", "paper-box")
LIFT_M = 0.04
END_S = 14.0
DELAY_SHARE = 0.4
ERRORS = np.array([1e-3, 1e-3, 1e-3, np.radians(1.0), 2e-3])
NARROWER_M = 0.004


def episode(job: tuple[int, int, bool]) -> dict[str, Any]:
    """Runs one seed at a rate of targets, Hz."""
    seed, rate_hz, reflex = job
    item = ITEMS[seed % len(ITEMS)]
    hand = SimulatedHand(item, seed=seed, reflex=reflex)
    random = np.random.default_rng([seed, rate_hz])
    hint, seen = hand.simulation.hint, hand.observe()
    names = hand.features.action_names()
    x, y, z = hint["at"]
    wide, closed = hint["width"] + 0.02, hint["width"] - NARROWER_M

    def pose(up: float, opening: float) -> list[float]:
        return [x, y, z + up, hint["yaw"], opening]

    times_s = [0.0, 2.0, 4.0, 4.5, 8.0, 9.0, 11.0, END_S]
    poses = [[seen[name] for name in names], pose(0.06, wide), pose(0.0, wide), pose(0.0, wide)]
    poses += [pose(0.0, closed)] * 2 + [pose(LIFT_M, closed)] * 2
    begin_s = hand.now_s()
    for step in range(round(END_S * rate_hz)):
        at_s = (step + DELAY_SHARE * random.random()) / rate_hz
        hand.wait(begin_s + at_s)
        target = np.array([np.interp(at_s, times_s, axis) for axis in zip(*poses, strict=True)])
        target += random.normal(0.0, ERRORS) * min(at_s / 2.0, 1.0)
        try:
            hand.send(hand.features.target(dict(zip(names, map(float, target), strict=True))))
        except AtasError:
            # The task ended, for example because the probe took too long. The policy starts it again.
            continue
    truth = hand.simulation.truth
    held = truth["objects"][0]
    pressed = min(truth["normal_n"][hand.features.index][:2]) > 0.03
    crushed, dropped = bool(held["crushed"]), bool(held["dropped"])
    lifted = float(held["lifted_m"]) >= LIFT_M / 2 and pressed
    return {
        "item": item,
        "rate_hz": rate_hz,
        "reflex": reflex,
        "success": lifted and not crushed and not dropped,
        "crushed": crushed,
        "dropped": dropped,
        "peak_n": hand.peak_n,
    }


def main() -> None:
    """Runs all seeds on all cores."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100, help="number of seeds")
    parser.add_argument("--first-seed", type=int, default=20001, help="first seed")
    parser.add_argument("--rates", type=int, nargs="+", default=[10, 20, 50], help="targets per second")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    jobs = [(seed, rate, reflex) for rate in options.rates for reflex in (True, False) for seed in seeds]
    with ProcessPoolExecutor() as pool:
        episodes = list(pool.map(episode, jobs, chunksize=4))
    if options.json:
        print(json.dumps(episodes))
        return
    print("| targets, Hz | reflex | success | crushed | dropped | median peak force, N |\n|---|---|---|---|---|---|")
    for rate in options.rates:
        for reflex in (True, False):
            of = [one for one in episodes if one["rate_hz"] == rate and one["reflex"] == reflex]
            count = {key: sum(one[key] for one in of) for key in ("success", "crushed", "dropped")}
            cells = [f"{count[key]} of {len(of)}" for key in ("success", "crushed", "dropped")]
            peak_n = np.median([one["peak_n"] for one in of])
            print("|", " | ".join([str(rate), "with" if reflex else "without", *cells, f"{peak_n:.2f}"]), "|")


if __name__ == "__main__":
    main()
