"""Evolves behaviour tables of a swarm: our genetic algorithm against pyribs, on the same budget.

    pip install 'ribs>=0.12,<0.13' scipy
    python outside_optimiser.py --out comparison.json

Each method evaluates the same number of genomes per seed on the same field:

* `ga`: `atas.SwarmSearch`, the paper's genetic algorithm (population 10, 2 elites, 1 % mutation).
* `cma-me`: pyribs, five CMA-ES emitters on an archive; a bit is set where a number is positive.
* `map-elites`: pyribs, isotropic and line mutation on the same archive.
* `random`: uniform genomes.

The archive's measures are the points on the four goals of even and of odd number. The comparison
is by the best fitness of each seed (maximum 800), with the Mann-Whitney U test against `ga`.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import atas
import numpy as np
from ribs.archives import GridArchive
from ribs.emitters import EvolutionStrategyEmitter, IsoLineEmitter
from ribs.schedulers import Scheduler
from scipy.stats import mannwhitneyu

POPULATION = 10
CELLS = 20
EMITTERS = 5


class Budget:
    """A field that evaluates a limited number of genomes and keeps the best."""

    def __init__(self, evaluations: int) -> None:
        self.field = atas.SwarmField("R3", agents=2, threads=1)
        self.evaluations = evaluations
        self.best = 0.0

    @property
    def left(self) -> int:
        """Evaluations left."""
        return self.evaluations - self.field.evaluations

    def points(self, genomes: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        """Points per goal of a batch; zero for genomes beyond the budget."""
        counted = self.field.points(genomes[: self.left])
        self.best = max(self.best, float(counted.sum(axis=1).max(initial=0.0)))
        missing = np.zeros((len(genomes) - len(counted), counted.shape[1]), np.float32)
        return np.concatenate([counted, missing])


def genetic_algorithm(budget: Budget, seed: int) -> None:
    """Our genetic algorithm: ask for genomes, tell their fitness."""
    search = atas.SwarmSearch(budget.field.bits, seed=seed, population=POPULATION)
    while budget.left > 0:
        search.tell(budget.points(search.ask()).sum(axis=1))


def uniform(budget: Budget, seed: int) -> None:
    """Uniform genomes."""
    random = np.random.default_rng(seed)
    while budget.left > 0:
        budget.points(random.integers(0, 2, (POPULATION, budget.field.bits), dtype=np.uint8))


def by_ribs(budget: Budget, emitters: Callable[[GridArchive], list[Any]], seed: int) -> None:
    """A scheduler of pyribs; thresholds its numbers to bits."""
    ranges = [(0.0, 400.0), (0.0, 400.0)]
    archive = GridArchive(solution_dim=budget.field.bits, dims=(CELLS, CELLS), ranges=ranges, seed=seed)
    scheduler = Scheduler(archive, emitters(archive))
    while budget.left > 0:
        points = budget.points(scheduler.ask() > 0.0)
        scheduler.tell(points.sum(axis=1), np.stack([points[:, ::2].sum(axis=1), points[:, 1::2].sum(axis=1)], axis=1))


def cma_me(budget: Budget, seed: int) -> None:
    """CMA-ES emitters."""

    def emitters(archive: GridArchive) -> list[Any]:
        zero = np.zeros(budget.field.bits)
        return [
            EvolutionStrategyEmitter(archive, x0=zero, sigma0=0.5, batch_size=POPULATION, seed=seed * EMITTERS + k)
            for k in range(EMITTERS)
        ]

    by_ribs(budget, emitters, seed)


def map_elites(budget: Budget, seed: int) -> None:
    """Isotropic and line mutation of archived genomes."""

    def emitters(archive: GridArchive) -> list[Any]:
        start = np.random.default_rng(seed).normal(0.0, 0.5, (POPULATION * EMITTERS, budget.field.bits))
        size = POPULATION * EMITTERS
        return [IsoLineEmitter(archive, iso_sigma=0.3, line_sigma=0.2, initial_solutions=start, batch_size=size, seed=seed)]

    by_ribs(budget, emitters, seed)


METHODS = {"ga": genetic_algorithm, "cma-me": cma_me, "map-elites": map_elites, "random": uniform}


def main() -> None:
    """Runs all methods and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=30, help="seeds per method (default %(default)s)")
    parser.add_argument("--evaluations", type=int, default=20_010, help="genomes per seed (default %(default)s: 2,000 generations)")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="results as JSON")
    given = parser.parse_args()
    if min(given.seeds, given.evaluations) < 1:
        parser.error("--seeds and --evaluations need at least 1")
    results: dict[str, Any] = {"seeds": given.seeds, "evaluations": given.evaluations, "methods": {}}
    for name, method in METHODS.items():
        begin, best = time.process_time(), []
        for seed in range(1, given.seeds + 1):
            budget = Budget(given.evaluations)
            method(budget, seed)
            assert budget.field.evaluations == given.evaluations, "every method has the same budget"
            best.append(budget.best)
        seconds = (time.process_time() - begin) / given.seeds
        results["methods"][name] = {"best": best, "processor_s_per_seed": seconds}
        print(f"{name}: median {np.median(best):.1f}", flush=True)
    own = results["methods"]["ga"]["best"]
    print("\n| method | best fitness: median | quartiles | largest | p against ga | processor time per seed, s |")
    print("|---|---|---|---|---|---|")
    for name, result in results["methods"].items():
        best = result["best"]
        low, high = np.percentile(best, [25, 75])
        p = "–" if name == "ga" else f"{mannwhitneyu(best, own).pvalue:.3g}"
        print(
            f"| `{name}` | {np.median(best):.1f} | {low:.1f} to {high:.1f} | {max(best):.1f} | {p} | "
            f"{result['processor_s_per_seed']:.1f} |"
        )
    given.out.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
