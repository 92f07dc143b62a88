"""Global method of Morris: elementary effects of all parameters, by SALib.

A trajectory changes one parameter after another, by two thirds of its span. The mean absolute
effect (mu*) ranks the parameters; the deviation (sigma) shows interactions and curvature.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .design import Point, point
from .evaluation import Outcomes
from .measures import MEASURES
from .parameters import Parameter

GRID_LEVELS = 4
"""Levels of the grid, the method's usual number (Morris 1991)."""
RESAMPLES = 1000
"""Bootstrap samples of the interval of mu*."""


@dataclass(frozen=True)
class Effect:
    """Effect of a parameter on a measure, over its span."""

    mu: float
    mu_star: float
    sigma: float
    mu_star_ci95: float
    """Half width of the 95 % interval of `mu_star`."""


@dataclass(frozen=True)
class Screening:
    """Effects on one measure."""

    measure: str
    trajectories: int
    """Trajectories with a value at every point; the others are left out."""
    effects: dict[str, Effect]
    """Effects by parameter; empty with fewer than two trajectories."""

    def ranking(self) -> list[str]:
        """Parameters, largest mu* first."""
        return sorted(self.effects, key=lambda name: -self.effects[name].mu_star)


@dataclass(frozen=True)
class Design:
    """Trajectories over the spans of the parameters."""

    parameters: tuple[Parameter, ...]
    span: float
    """Share of each range around the nominal value."""
    seed: int
    shares: NDArray[np.float64]
    """Share of the span by point and parameter."""

    @classmethod
    def sample(cls, parameters: Sequence[Parameter], trajectories: int, span: float, seed: int) -> Design:
        """Samples trajectories."""
        from SALib.sample import morris

        shares = morris.sample(_problem(parameters), trajectories, num_levels=GRID_LEVELS, seed=seed)
        return cls(tuple(parameters), span, seed, np.asarray(shares, np.float64))

    def points(self) -> list[Point]:
        """Points of all trajectories."""
        return [point(self.parameters, [float(share) for share in row], self.span) for row in self.shares]

    def screen(self, outcomes: Outcomes) -> list[Screening]:
        """Effects on each measure."""
        found = []
        size = len(self.parameters) + 1
        results = [outcomes.of(values) for values in self.points()]
        for measure in MEASURES:
            values = [None if result is None else result.values()[measure] for result in results]
            numbers = np.array([np.nan if value is None else value for value in values], np.float64)
            is_complete = np.isfinite(numbers.reshape(-1, size)).all(axis=1)
            kept = np.repeat(is_complete, size)
            found.append(self._analyse(measure, int(is_complete.sum()), self.shares[kept], numbers[kept]))
        return found

    def _analyse(
        self, measure: str, trajectories: int, shares: NDArray[np.float64], numbers: NDArray[np.float64]
    ) -> Screening:
        if trajectories < 2:
            return Screening(measure, trajectories, {})
        from SALib.analyze import morris

        result = morris.analyze(
            _problem(self.parameters), shares, numbers, num_resamples=RESAMPLES, num_levels=GRID_LEVELS, seed=self.seed
        )
        columns = [np.asarray(result[key], np.float64) for key in ("mu", "mu_star", "sigma", "mu_star_conf")]
        effects = {p.name: Effect(*(float(column[i]) for column in columns)) for i, p in enumerate(self.parameters)}
        return Screening(measure, trajectories, effects)


def _problem(parameters: Sequence[Parameter]) -> dict[str, object]:
    """Problem description of SALib. Its ranges are shares of the span."""
    names = [parameter.name for parameter in parameters]
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
