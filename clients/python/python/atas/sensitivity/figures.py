"""Heat maps as SVG. Equal results give equal bytes with one version of matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from .measures import MEASURES, Measures
from .morris import Screening
from .one_at_a_time import Criterion, Row

STYLE: Any = {"svg.fonttype": "none", "svg.hashsalt": "atas", "font.family": "sans-serif", "font.size": 7.5}
"""Text remains text, and identifiers do not depend on the run."""
OVER_GRIP_MOST = 4.0
"""Over-grip of the darkest colour. Design choice: the least force already gives 2 to 4 on light objects."""
SHARE_MOST = 0.25
"""Share of crushed or dropped objects of the darkest colour."""


def _save(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()) + "\n"


def _panel(axes: Any, cells: Sequence[Sequence[float | None]], texts: Sequence[Sequence[str]], norm: Normalize, colours: str) -> None:
    """Draws a grid of coloured cells with texts; cells without value are grey."""
    numbers = np.array([[np.nan if cell is None else cell for cell in row] for row in cells])
    palette = matplotlib.colormaps[colours].with_extremes(bad="#cccccc")
    mesh = axes.pcolormesh(np.ma.masked_invalid(numbers), cmap=palette, norm=norm, edgecolors="white", linewidth=0.5)
    axes.invert_yaxis()
    axes.tick_params(length=0)
    for y, row in enumerate(texts):
        for x, text in enumerate(row):
            if text:
                red, green, blue, _ = mesh.cmap(norm(numbers[y, x]))
                is_dark = 0.3 * red + 0.6 * green + 0.1 * blue < 0.5
                axes.text(x + 0.5, y + 0.5, text, ha="center", va="center", color="white" if is_dark else "black", fontsize=6.5)
    for spine in axes.spines.values():
        spine.set_visible(False)


def one_at_a_time(rows: Sequence[Row], criterion: Criterion, title: str) -> str:
    """Heat map of every measure over the levels of every parameter, largest effect first."""
    count = len(rows[0].levels)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(11.5, 1.3 + 0.27 * len(rows)))
        panels = figure.subplots(1, len(MEASURES), sharey=True, gridspec_kw={"wspace": 0.06})
        for axes, (measure, heading) in zip(panels, MEASURES.items(), strict=True):
            cells = [[None if m is None else m.values()[measure] for m in row.measures] for row in rows]
            texts = [[_text(measure, m) for m in row.measures] for row in rows]
            norm, colours = _scale(measure)
            _panel(axes, cells, texts, norm, colours)
            axes.set_title(heading, fontsize=8.5)
            axes.set_xticks([0.5, count / 2, count - 0.5], ["first", "middle", "last"])
            axes.set_xlabel("level")
            for y, row in enumerate(rows):
                x = row.nominal_index
                axes.plot([x + 0.1, x + 0.9], [y + 0.9, y + 0.9], color="black", linewidth=0.8)
            if measure == "success":
                _mark_domain(axes, rows, criterion)
        labels = [f"{row.parameter.label}:  {' · '.join(f'{level.value:g}' for level in row.levels)}" for row in rows]
        panels[0].set_yticks(np.arange(len(rows)) + 0.5, labels)
        figure.suptitle(title, fontsize=9, y=0.99 - 0.004 * len(rows) ** 0.5)
        return _save(figure)


def _mark_domain(axes: Any, rows: Sequence[Row], criterion: Criterion) -> None:
    """Draws a line between the last valid level and the first that fails."""
    for y, row in enumerate(rows):
        domain = row.domain(criterion)
        for bound in (domain.low, domain.high) if domain is not None else ():
            if bound is not None and bound.fails_at is not None:
                axes.plot([bound.edge, bound.edge], [y, y + 1], color="red", linewidth=2.0)


def _text(measure: str, measures: Measures | None) -> str:
    """Text of a cell; empty for the value without any failure."""
    if measures is None:
        return "–"
    value = measures.values()[measure]
    if value is None:
        return ""
    if measure == "over_grip":
        return f"{value:.1f}"
    if measure in ("crushed", "dropped"):
        return str(getattr(measures, measure)) if value else ""
    return f"{100 * value:.0f}" if value < 1.0 else ""


def _scale(measure: str) -> tuple[Normalize, str]:
    """Range and colours of a measure. Dark cells are bad in every panel."""
    if measure == "over_grip":
        return Normalize(1.0, OVER_GRIP_MOST, clip=True), "cividis_r"
    if measure in ("crushed", "dropped"):
        return Normalize(0.0, SHARE_MOST, clip=True), "cividis_r"
    return Normalize(0.0, 1.0), "cividis"


def morris(screenings: Sequence[Screening], labels: dict[str, str], title: str) -> str:
    """Heat map of mu* and sigma by parameter and measure; colours are relative to the column."""
    shown = [screening for screening in screenings if screening.effects]
    names = shown[0].ranking()
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 1.3 + 0.27 * len(names)))
        panels = figure.subplots(1, 2, sharey=True, gridspec_kw={"wspace": 0.05})
        for axes, key in zip(panels, ("mu_star", "sigma"), strict=True):
            table = np.array([[getattr(screening.effects[name], key) for screening in shown] for name in names])
            relative = table / np.maximum(table.max(axis=0), 1e-12)
            _panel(axes, relative.tolist(), [[f"{cell:.2f}" for cell in row] for row in table], Normalize(0.0, 1.0), "cividis_r")
            axes.set_title("µ*: mean absolute effect" if key == "mu_star" else "σ: interactions and curvature", fontsize=8.5)
            axes.set_xticks(np.arange(len(shown)) + 0.5, [MEASURES[s.measure].replace(" ", "\n", 1) for s in shown])
        panels[0].set_yticks(np.arange(len(names)) + 0.5, [labels[name] for name in names])
        figure.suptitle(title, fontsize=9, y=0.99 - 0.004 * len(names) ** 0.5)
        return _save(figure)
