"""Object files: the built-in objects with scaled properties."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Object:
    """Nominal values of a built-in object; `None` for a rigid or uncrushable one."""

    shape: str
    mass_kg: float
    friction: float
    stiffness_n_m: float | None = None
    crush_n: float | None = None


def _box(x: float, y: float, z: float) -> str:
    return f'{{ kind = "box", size_m = [{x}, {y}, {z}] }}'


OBJECTS: Mapping[str, Object] = MappingProxyType(
    {
        "wood": Object(_box(0.05, 0.05, 0.06), 0.3, 0.5),
        "slippery-200": Object(_box(0.05, 0.05, 0.06), 0.2, 0.25),
        "slippery-50": Object(_box(0.04, 0.04, 0.05), 0.05, 0.2),
        "paper-box": Object(_box(0.05, 0.05, 0.05), 0.02, 0.4, 1500.0, 1.5),
        "sponge": Object(_box(0.06, 0.06, 0.05), 0.015, 0.6, 400.0, 3.0),
        "bottle": Object('{ kind = "cylinder", radius_m = 0.03, height_m = 0.12 }', 0.5, 0.5, 3e4, 15.0),
        "heavy-block": Object(_box(0.05, 0.05, 0.08), 1.5, 0.4),
        "filled-paper-box": Object(_box(0.05, 0.05, 0.05), 0.12, 0.4, 1500.0, 1.5),
    }
)
"""Built-in objects, as in `sim-backend/objects` (a test compares them)."""

_RANGES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "mass_kg": (0.0125, 5.0),
        "friction": (0.05, 2.0),
        "stiffness_n_m": (100.0, 1e6),
        "crush_n": (0.1, 1e3),
    }
)
"""Limits of the simulator. A scaled value beyond them is set to the limit."""


def file_text(name: str, factors: Mapping[str, float]) -> str:
    """Object file of a built-in object whose properties are multiplied by `factors`."""
    of = OBJECTS[name]
    lines = [f'name = "{name}"']
    for key, (least, most) in _RANGES.items():
        nominal = getattr(of, key)
        if nominal is not None:
            lines.append(f"{key} = {min(max(float(f'{nominal * factors.get(key, 1.0):.6g}'), least), most)}")
    return "\n".join([*lines, f"shape = {of.shape}", ""])
