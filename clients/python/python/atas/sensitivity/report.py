"""Reports: JSON with all numbers, Markdown tables, and the domain of validity as TOML."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from .design import Point
from .evaluation import Outcomes, Settings
from .measures import Measures
from .morris import Design, Screening
from .one_at_a_time import Bound, Criterion, Row
from .parameters import Parameter

LIBRARIES = ("SALib", "numpy")
NAMED = 3
"""Number of parameters that the summary names as the most important ones."""


@dataclass(frozen=True)
class Origin:
    """Origin of the results: commands, versions and settings."""

    command: str
    identity: dict[str, str]
    settings: Settings

    def json(self) -> dict[str, Any]:
        """Origin as JSON values."""
        versions = {"atas": self.identity["version"], "programs_sha256": self.identity["programs_sha256"]}
        versions |= {"python": platform.python_version()}
        versions |= {name: importlib.metadata.version(name) for name in LIBRARIES}
        last_seed = self.settings.first_seed + -(-self.settings.trials // len(self.settings.objects)) - 1
        return {"command": self.command, "versions": versions, "settings": asdict(self.settings) | {"last_seed": last_seed}}


def _describe(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "group": parameter.group,
        "unit": parameter.unit,
        "nominal": parameter.nominal,
        "range": [parameter.first, parameter.last],
        "scale": parameter.scale.value,
        "option": parameter.via.value,
        "source": parameter.source,
    }


def one_at_a_time_json(rows: Sequence[Row], criterion: Criterion, outcomes: Outcomes, origin: Origin) -> dict[str, Any]:
    """All numbers of the one-at-a-time method."""
    found = []
    for row in rows:
        results = []
        for level, measures in zip(row.levels, row.measures, strict=True):
            values: Point = level.point(row.parameter)
            result = {"value": level.value, "fraction": level.fraction, "command": outcomes.command(values)}
            results.append(result | {"measures": None if measures is None else measures.json()})
        domain = row.domain(criterion)
        valid = {} if domain is None else {"low": _bound(domain.low), "high": _bound(domain.high)}
        found.append(_describe(row.parameter) | {"effect": row.effect, "domain": valid, "levels": results})
    least = {"least_success": criterion.least_success, "crushed": 0}
    nominal = outcomes.of({})
    return origin.json() | {
        "method": "one-at-a-time",
        "criterion": least,
        "nominal": None if nominal is None else nominal.json(),
        "parameters": found,
        "failed_points": outcomes.failed,
    }


def _bound(bound: Bound | None) -> dict[str, Any] | None:
    if bound is None:
        return None
    beyond = None if bound.beyond is None else {"value": bound.beyond.value, "cause": bound.beyond.cause}
    return {"value": bound.value, "succeeded": bound.measures.succeeded, "beyond": beyond}


def morris_json(design: Design, screenings: Sequence[Screening], outcomes: Outcomes, origin: Origin) -> dict[str, Any]:
    """All numbers of the global method."""
    points = []
    for values in design.points():
        measures = outcomes.of(values)
        result = {"point": dict(values), "command": outcomes.command(values)}
        points.append(result | {"measures": None if measures is None else measures.json()})
    effects = {
        screening.measure: {
            "trajectories": screening.trajectories,
            "ranking": screening.ranking(),
            "effects": {name: asdict(effect) for name, effect in screening.effects.items()},
        }
        for screening in screenings
    }
    return origin.json() | {
        "method": "morris",
        "span": design.span,
        "design_seed": design.seed,
        "parameters": [_describe(parameter) for parameter in design.parameters],
        "measures": effects,
        "shares": design.shares.tolist(),
        "points": points,
        "failed_points": outcomes.failed,
    }


def _table(heading: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    lines = [heading, ["---"] * len(heading), *body]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def one_at_a_time_table(rows: Sequence[Row], criterion: Criterion, trials: int) -> str:
    """Markdown table, largest effect first. Bold: the nominal level."""
    body = []
    for row in rows:
        def series(of: str, row: Row = row) -> str:
            texts = []
            for level, measures in zip(row.levels, row.measures, strict=True):
                if measures is None:
                    text = "–"
                elif of == "value":
                    text = f"{level.value:g}"
                elif of == "over_grip":
                    text = "–" if measures.over_grip is None else f"{measures.over_grip:.2f}"
                else:
                    text = str(getattr(measures, of))
                texts.append(f"**{text}**" if level.is_nominal and of == "value" else text)
            return ", ".join(texts)

        domain = row.domain(criterion)
        columns = [series(of) for of in ("value", "succeeded", "succeeded_by_physics", "crushed", "dropped", "over_grip")]
        body.append([row.parameter.label, *columns, "none" if domain is None else domain.text()])
    heading = ["parameter", "levels", f"succeeded of {trials}", "by physics", "crushed", "dropped", "over-grip", "valid"]
    return _table(heading, body)


def _success_cell(measures: Measures | None) -> str:
    """Success with its interval, %."""
    if measures is None:
        return "–"
    low, high = measures.success_ci95
    return f"{100 * measures.success:.0f} [{100 * low:.0f}, {100 * high:.0f}]"


def domain_table(rows: Sequence[Row], criterion: Criterion) -> str:
    """Markdown table of the domain of validity, largest effect first."""
    body = []
    for row in rows:
        domain = row.domain(criterion)
        beyond = [bound.beyond for bound in domain.bounds if bound.beyond is not None] if domain is not None else []
        columns = [
            [f"{next_one.value:g}" for next_one in beyond],
            [_success_cell(next_one.measures) for next_one in beyond],
            [next_one.cause for next_one in beyond],
        ]
        body.append([row.parameter.label, "none" if domain is None else domain.text(), *("; ".join(column) for column in columns)])
    return _table(["parameter", "valid", "fails at", "success there, % [95 %]", "most frequent failure there"], body)


def morris_table(screenings: Sequence[Screening], labels: dict[str, str]) -> str:
    """Markdown table of the effects, largest effect on success first."""
    first = screenings[0]
    body = []
    for name in first.ranking():
        cells = [labels[name]]
        for screening in screenings:
            effect = screening.effects.get(name)
            if effect is None:
                cells.append("–")
            elif screening is first:
                cells.append(f"{effect.mu_star:.3f} ± {effect.mu_star_ci95:.3f}, {effect.mu:+.3f}, {effect.sigma:.3f}")
            else:
                cells.append(f"{effect.mu_star:.3f} ± {effect.mu_star_ci95:.3f}")
        body.append(cells)
    return _table(["parameter", "success: µ*, µ, σ", *(f"{s.measure.replace('_', ' ')}: µ*" for s in screenings[1:])], body)


DOMAIN_HEADER = """\
# Domain of validity of the grasp controller in simulation: how far each parameter may leave its
# nominal value, with all others nominal. Combinations of parameters are not covered. Written by
# `python -m atas.sensitivity one-at-a-time`; see clients/guide/src/results.md, section Sensitivity.
#
# [evaluation]     command, version, robot and seeds of the trials; `last_seed` is inclusive.
# [criterion]      condition for a valid level: the 95 % Wilson interval of success begins at
#                  `success_lower_bound` or above, and at most `crushed` objects are crushed.
# [[parameter]]    one per parameter, amounts in `unit`:
#   nominal        value of the simulator's default.
#   low, high      least and largest valid value. Absent: values on this side of `nominal` were not
#                  tested; they are better than nominal (less noise, higher rate).
#   low_fails_at, high_fails_at
#                  next tested value, which violates the criterion. The domain ends between both
#                  values. Absent: the tested range ends at `low` or `high` without a violation.
#   low_failure, high_failure
#                  most frequent failure at that value.
#   low_success, high_success
#                  successes and trials at the bound.
#   model_key, model_factor
#                  key of a sensor model file with this property: amount = `model_factor` × value.
#                  Of a list, the largest magnitude (`saturation_n`: the smallest). Absent: none.
# A unit with ± is a half width: each trial draws its amount within it. Amounts per element hold for
# the fingertips of the robot in [evaluation].
"""


def domain_toml(rows: Sequence[Row], criterion: Criterion, origin: Origin) -> str:
    """Domain of validity as TOML."""
    data = origin.json()
    settings = data["settings"]
    lines = [DOMAIN_HEADER, "version = 1\n", "[evaluation]", f"command = {_string(origin.command)}"]
    lines += [f"atas = {_string(data['versions']['atas'])}", f"robot = {_string(settings['robot'] or 'two-hand-arm')}"]
    lines += [f"engine = {_string(settings['engine'] or 'built-in')}", f"trials = {settings['trials']}"]
    lines += [f"first_seed = {settings['first_seed']}", f"last_seed = {settings['last_seed']}"]
    lines += [f"objects = [{', '.join(_string(name) for name in settings['objects'])}]", "", "[criterion]"]
    lines += [f"success_lower_bound = {criterion.least_success}", "crushed = 0"]
    for row in rows:
        domain = row.domain(criterion)
        if domain is None:
            continue
        parameter = row.parameter
        lines += ["", "[[parameter]]", f"name = {_string(parameter.name)}", f"group = {_string(parameter.group)}"]
        lines += [f"unit = {_string(parameter.unit)}", f"nominal = {parameter.nominal}"]
        for side, bound in (("low", domain.low), ("high", domain.high)):
            if bound is None:
                continue
            lines.append(f"{side} = {bound.value}")
            if bound.beyond is not None:
                lines.append(f"{side}_fails_at = {bound.beyond.value}")
                lines.append(f"{side}_failure = {_string(bound.beyond.cause)}")
            lines.append(f"{side}_success = [{bound.measures.succeeded}, {bound.measures.trials}]")
        if parameter.model_key is not None:
            lines += [f"model_key = {_string(parameter.model_key)}", f"model_factor = {float(f'{parameter.model_factor:.6g}')}"]
    return "\n".join(lines) + "\n"


def _string(text: str) -> str:
    """TOML basic string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " else f"\\u{ord(c):04x}" for c in escaped) + '"'
