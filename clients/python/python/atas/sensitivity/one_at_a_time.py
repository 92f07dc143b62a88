"""One parameter at a time: results at the levels of each parameter, and the domain of validity.

The domain of a parameter reaches from its nominal value outward to the last level before the first
one that violates the criterion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .design import Level, Point, levels
from .evaluation import Outcomes
from .measures import Measures, wilson
from .parameters import Parameter


@dataclass(frozen=True)
class Criterion:
    """Condition for a valid point: no object crushed, and a lower bound of success."""

    least_success: float
    """Least lower end of the 95 % interval of success."""

    def check(self, trials: int) -> None:
        """Rejects a bound that not even a point without failure satisfies."""
        best = wilson(trials, trials)[0]
        if best < self.least_success:
            raise ValueError(
                f"--least-success {self.least_success:g} cannot be shown with {trials} trials: without a failure "
                f"their interval begins at {best:.3f}; raise --trials or lower --least-success"
            )

    def holds(self, measures: Measures | None) -> bool:
        """True for a valid point. A point without result is not valid."""
        return measures is not None and measures.crushed == 0 and measures.success_ci95[0] >= self.least_success


@dataclass(frozen=True)
class Beyond:
    """First level outside the domain."""

    value: float
    measures: Measures | None
    """Results there; `None` if the point failed."""

    @property
    def cause(self) -> str:
        """Most frequent failure there."""
        failures = self.measures.failures if self.measures is not None else {}
        return min(failures, key=lambda name: (-failures[name], name), default="unknown")


@dataclass(frozen=True)
class Bound:
    """Bound of the domain on one side of the nominal value."""

    value: float
    """Farthest valid level."""
    measures: Measures
    """Results there."""
    beyond: Beyond | None
    """Next level, which violates the criterion; `None` if the range ends before."""
    edge: int
    """Number of levels before the bound, counted over the range."""


@dataclass(frozen=True)
class Domain:
    """Valid values of a parameter. A bound is `None` if values on its side were not tested."""

    low: Bound | None
    high: Bound | None

    @property
    def bounds(self) -> list[Bound]:
        """Bounds of the tested sides."""
        return [bound for bound in (self.low, self.high) if bound is not None]

    def text(self) -> str:
        """Domain in words."""
        if self.low is not None and self.high is not None and self.low.value == self.high.value:
            return f"{self.low.value:g} only"
        parts = []
        for word, bound in (("from", self.low), ("to", self.high)):
            if bound is not None:
                end = " (end of the range)" if bound.beyond is None else ""
                parts.append(f"{word} {bound.value:g}{end}")
        return " ".join(parts)


@dataclass(frozen=True)
class Row:
    """Results of one parameter."""

    parameter: Parameter
    levels: tuple[Level, ...]
    measures: tuple[Measures | None, ...]
    """Results by level; `None` for a failed point."""

    @property
    def nominal_index(self) -> int:
        """Number of the nominal level."""
        return next(index for index, level in enumerate(self.levels) if level.is_nominal)

    @property
    def effect(self) -> float:
        """Largest loss of success over the range, relative to the nominal point."""
        nominal = self.measures[self.nominal_index]
        finished = [measures.success for measures in self.measures if measures is not None]
        return nominal.success - min(finished) if nominal is not None else 0.0

    def domain(self, criterion: Criterion) -> Domain | None:
        """Valid values; `None` if the nominal point is not valid."""
        nominal = self.nominal_index
        if not criterion.holds(self.measures[nominal]):
            return None
        sides = [self._bound(criterion, range(nominal + 1, len(self.levels)))]
        sides.append(self._bound(criterion, range(nominal - 1, -1, -1)))
        rises = self.parameter.last > self.parameter.first
        high, low = sides if rises else reversed(sides)
        return Domain(low, high)

    def _bound(self, criterion: Criterion, outward: range) -> Bound | None:
        """Bound on the side whose levels are `outward`; `None` without levels."""
        if not outward:
            return None
        last = self.nominal_index
        beyond = None
        for index in outward:
            if not criterion.holds(self.measures[index]):
                beyond = Beyond(self.levels[index].value, self.measures[index])
                break
            last = index
        measures = self.measures[last]
        assert measures is not None, "a valid level has a result"
        return Bound(self.levels[last].value, measures, beyond, last + (outward.step > 0))


def points(parameters: Sequence[Parameter], count: int) -> list[Point]:
    """All points, the nominal one first."""
    return [{}] + [level.point(p) for p in parameters for level in levels(p, count) if not level.is_nominal]


def rows(parameters: Sequence[Parameter], count: int, outcomes: Outcomes) -> list[Row]:
    """Results of all parameters."""
    found = []
    for parameter in parameters:
        own = tuple(levels(parameter, count))
        found.append(Row(parameter, own, tuple(outcomes.of(level.point(parameter)) for level in own)))
    return found
