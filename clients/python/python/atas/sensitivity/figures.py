"""Heat maps as SVG. Dark cells are bad in every panel; equal results give equal bytes."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from .measures import MEASURES, Measures
from .morris import Screening
from .one_at_a_time import Criterion, Row

PALETTE = ((255, 246, 214), (250, 190, 110), (214, 96, 77), (110, 30, 80), (35, 15, 50))
"""Colours from good to bad. Their lightness falls steadily, so that they remain ordered in grey."""
OVER_GRIP_MOST = 4.0
"""Over-grip of the darkest colour. Light objects reach 2 to 5 without any error (results page)."""
SHARE_MOST = 0.25
"""Share of crushed or dropped objects of the darkest colour. Design choice."""
EFFECT_LEAST = 0.2
"""Least effect of the darkest colour. Design choice: single trials must not look like large effects."""
MISSING = "#bbbbbb"
"""Colour of a cell without value."""
CELL_PX, ROW_PX, GAP_PX, TOP_PX = 28, 17, 12, 52


def colour(badness: float | None) -> str:
    """Colour of a value from 0 (good) to 1 (bad)."""
    if badness is None:
        return MISSING
    place = min(max(badness, 0.0), 1.0) * (len(PALETTE) - 1)
    index = min(int(place), len(PALETTE) - 2)
    mixed = [a + (b - a) * (place - index) for a, b in zip(PALETTE[index], PALETTE[index + 1], strict=True)]
    return "#" + "".join(f"{round(part):02x}" for part in mixed)


def _badness(measure: str, measures: Measures | None) -> float | None:
    """Value of a cell from 0 (good) to 1 (bad)."""
    value = None if measures is None else measures.values()[measure]
    if value is None:
        return None
    if measure == "over_grip":
        return (value - 1.0) / (OVER_GRIP_MOST - 1.0)
    return value / SHARE_MOST if measure in ("crushed", "dropped") else 1.0 - value


def _text(measure: str, measures: Measures | None) -> str:
    """Text of a cell; empty for the best value."""
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


def _short(value: float) -> str:
    """Value with three significant digits, without an exponent."""
    return f"{value:.0f}" if value >= 1000 else f"{value:.3g}"


class Drawing:
    """SVG with one row per parameter."""

    def __init__(self, title: str, notes: Sequence[str], rows: int, width_px: float) -> None:
        height = TOP_PX + rows * ROW_PX + 14 * len(notes) + 18
        self._parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width_px:g} {height}" font-family="sans-serif" font-size="11">',
            "<style>.m{text-anchor:middle;font-size:9px}.e{text-anchor:end}.g{font-size:9px;fill:#555}.w{fill:#fff}</style>",
            f'<rect width="{width_px:g}" height="{height}" fill="#fff"/>',
        ]
        self.text(8, 18, title, size=13)
        for index, note in enumerate(notes):
            self.text(8, TOP_PX + rows * ROW_PX + 18 + 14 * index, note)

    def text(self, x: float, y: float, text: str, kind: str = "", size: int | None = None) -> None:
        """Adds a text; `kind` is a class of the style sheet."""
        extra = (f' class="{kind}"' if kind else "") + (f' font-size="{size}"' if size else "")
        self._parts.append(f'<text x="{x:g}" y="{y:g}"{extra}>{escape(text)}</text>')

    def cell(self, x: float, row: int, badness: float | None, text: str) -> None:
        """Adds a coloured cell with a text."""
        y = TOP_PX + row * ROW_PX
        self._parts.append(f'<rect x="{x:g}" y="{y}" width="{CELL_PX - 1}" height="{ROW_PX - 1}" fill="{colour(badness)}"/>')
        if text:
            is_dark = badness is not None and badness > 0.45
            self.text(x + CELL_PX / 2, y + 12, text, "m w" if is_dark else "m")

    def line(self, x1: float, y1: float, x2: float, y2: float, stroke: str, width: float) -> None:
        """Adds a line."""
        self._parts.append(f'<path d="M{x1:g} {y1:g}L{x2:g} {y2:g}" stroke="{stroke}" stroke-width="{width:g}"/>')

    def svg(self) -> str:
        """The drawing."""
        return "\n".join([*self._parts, "</svg>", ""])


def one_at_a_time(rows: Sequence[Row], criterion: Criterion, title: str) -> str:
    """Heat map of every measure over the levels of every parameter."""
    left_px, count = 345, len(rows[0].levels)
    step_px = count * CELL_PX + GAP_PX
    notes = [
        "Underlined: nominal level. Blue line: end of the domain of validity. Numbers: % of success, objects crushed "
        "or dropped, median over-grip;",
        "none where all succeed, nothing is crushed or dropped, or nothing is held (grey).",
    ]
    drawing = Drawing(title, notes, len(rows), left_px + len(MEASURES) * step_px)
    for panel, (measure, heading) in enumerate(MEASURES.items()):
        x_px = left_px + panel * step_px
        drawing.text(x_px, TOP_PX - 8, heading)
        for y, row in enumerate(rows):
            for x, measures in enumerate(row.measures):
                drawing.cell(x_px + x * CELL_PX, y, _badness(measure, measures), _text(measure, measures))
            foot_px = TOP_PX + (y + 1) * ROW_PX - 2
            at_px = x_px + row.nominal_index * CELL_PX
            drawing.line(at_px + 4, foot_px, at_px + CELL_PX - 5, foot_px, "#000", 1)
    for y, row in enumerate(rows):
        base_px = TOP_PX + y * ROW_PX + 12
        drawing.text(150, base_px, row.parameter.label, "e")
        drawing.text(158, base_px, " · ".join(_short(level.value) for level in row.levels), "g")
        domain = row.domain(criterion)
        for bound in domain.bounds if domain is not None else ():
            if bound.beyond is not None:
                edge_px, top_px = left_px + bound.edge * CELL_PX - 0.5, TOP_PX + y * ROW_PX - 0.5
                drawing.line(edge_px, top_px, edge_px, top_px + ROW_PX, "#06c", 3)
    return drawing.svg()


def morris(screenings: Sequence[Screening], labels: dict[str, str], title: str) -> str:
    """Heat map of mu* and sigma by parameter and measure. Colours are relative to the column's largest."""
    shown = [screening for screening in screenings if screening.effects]
    names = shown[0].ranking()
    left_px, column_px = 160, 110
    notes = ["µ*, σ: mean absolute effect of the span, and deviation of the effects. Shares, except over-grip."]
    drawing = Drawing(title, notes, len(names), left_px + len(shown) * column_px + GAP_PX)
    for y, name in enumerate(names):
        drawing.text(left_px - 8, TOP_PX + y * ROW_PX + 12, labels[name], "e")
    for panel, screening in enumerate(shown):
        x_px = left_px + panel * column_px
        drawing.text(x_px, TOP_PX - 20, MEASURES[screening.measure])
        for offset, (key, symbol) in enumerate((("mu_star", "µ*"), ("sigma", "σ"))):
            at_px = x_px + offset * CELL_PX
            drawing.text(at_px + CELL_PX / 2, TOP_PX - 5, symbol, "m")
            most = max(EFFECT_LEAST, *(getattr(effect, key) for effect in screening.effects.values()))
            for y, name in enumerate(names):
                value = getattr(screening.effects[name], key)
                drawing.cell(at_px, y, value / most, f"{value:.2f}")
    return drawing.svg()
