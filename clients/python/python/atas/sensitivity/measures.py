"""Measures of a design point: counts of outcomes with intervals, and over-grip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import sqrt
from typing import Any

Z95 = 1.959963984540054
"""Quantile of the normal distribution for 95 % intervals."""


def wilson(part: int, whole: int) -> tuple[float, float]:
    """95 % Wilson interval of a share; 0 to 1 without trials."""
    if whole == 0:
        return 0.0, 1.0
    share, z2 = part / whole, Z95 * Z95
    centre = (share + z2 / (2 * whole)) / (1 + z2 / whole)
    half = Z95 / (1 + z2 / whole) * sqrt(share * (1 - share) / whole + z2 / (4 * whole * whole))
    return max(centre - half, 0.0), min(centre + half, 1.0)


@dataclass(frozen=True)
class Measures:
    """Outcomes of the trials of one point."""

    trials: int
    succeeded: int
    """Held if the rule allows it, else left unharmed."""
    succeeded_by_physics: int
    """Success if any rule of the grip could hold the object."""
    crushed: int
    dropped: int
    discarded: int
    """Trials that the physics engine ended; they are no successes."""
    over_grip: float | None
    """Median ratio of grip force to required force, held objects; `None` without one."""
    failures: dict[str, int]
    """Failures by outcome."""

    @classmethod
    def from_report(cls, report: Mapping[str, Any]) -> Measures:
        """Measures of a report of `atas eval grasp --format json`."""
        rule, physics = (report, report["by_physics"])
        groups = [report["feasible"], report["infeasible"]]
        trials = int(report["trials"])
        failures = {str(outcome): int(count) for outcome, count in report["failures"].items()}
        return cls(
            trials=trials,
            succeeded=round(rule["success"] * trials),
            succeeded_by_physics=round(physics["success"] * trials),
            crushed=sum(int(group["crushed"]) for group in groups),
            dropped=sum(int(group["dropped"]) for group in groups),
            discarded=sum(count for outcome, count in failures.items() if outcome.startswith("discarded")),
            over_grip=report["feasible"]["over_grip_median"],
            failures=failures,
        )

    @property
    def success(self) -> float:
        """Share of successful trials."""
        return self.succeeded / self.trials

    @property
    def success_ci95(self) -> tuple[float, float]:
        """95 % Wilson interval of `success`."""
        return wilson(self.succeeded, self.trials)

    def values(self) -> dict[str, float | None]:
        """Values by measure, as figures and the global method use them."""
        return {
            "success": self.success,
            "success_by_physics": self.succeeded_by_physics / self.trials,
            "crushed": self.crushed / self.trials,
            "dropped": self.dropped / self.trials,
            "over_grip": self.over_grip,
        }

    def json(self) -> dict[str, Any]:
        """Counts and intervals as JSON values."""
        counts = {name: getattr(self, name) for name in ("succeeded", "succeeded_by_physics", "crushed", "dropped")}
        intervals = {f"{name}_ci95": list(wilson(count, self.trials)) for name, count in counts.items()}
        return asdict(self) | {"success": self.success} | intervals


MEASURES: Mapping[str, str] = {
    "success": "success",
    "success_by_physics": "success by physics",
    "crushed": "crushed",
    "dropped": "dropped",
    "over_grip": "over-grip, median",
}
"""Headings of the measures."""
