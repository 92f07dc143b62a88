"""Design points, and the options of `atas eval grasp` that realise them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .objects import OBJECTS, file_text
from .parameters import PARAMETERS, Parameter, Via

Point = Mapping[str, float]
"""Values that differ from the nominal ones, by parameter name. The empty point is nominal."""


@dataclass(frozen=True)
class Level:
    """One level of a parameter."""

    fraction: float
    """Fraction of the range."""
    value: float
    """Value in the parameter's unit."""
    is_nominal: bool

    def point(self, parameter: Parameter) -> Point:
        """Point with this level; all other parameters are nominal."""
        return {} if self.is_nominal else {parameter.name: self.value}


def levels(parameter: Parameter, count: int) -> list[Level]:
    """`count` levels with equal steps over the range. `count` is odd and at least 3."""
    if count < 3 or count % 2 == 0:
        raise ValueError(f"{count} levels; needs an odd number of at least 3")
    fractions = [index / (count - 1) for index in range(count)]
    return [Level(f, parameter.value(f), f == parameter.nominal_fraction) for f in fractions]


def point(parameters: Sequence[Parameter], shares: Sequence[float], span: float) -> Point:
    """Point of the global method. A share of 0 to 1 covers `span` of each range around nominal."""
    values = {}
    for parameter, share in zip(parameters, shares, strict=True):
        nominal = parameter.nominal_fraction
        value = parameter.value(min(max(nominal + (share - nominal) * span, 0.0), 1.0))
        if value != parameter.nominal:
            values[parameter.name] = value
    return values


@dataclass(frozen=True)
class Realisation:
    """Options of a point, and the texts of the files that they name."""

    options: list[str]
    files: dict[str, str]
    """Text by path, relative to the folder of the options."""


def realise(values: Point, objects: Sequence[str], folder: Path, tag: str) -> Realisation:
    """Options for a point. Paths of files begin with `folder`; `tag` separates points."""
    by_name = {parameter.name: parameter for parameter in PARAMETERS}
    errors, model, factors = [], {}, {}
    noise, rate_hz = by_name["noise"].nominal, by_name["rate"].nominal
    for name in sorted(values):
        parameter, value = by_name[name], values[name]
        key = parameter.key or name
        match parameter.via:
            case Via.NOISE:
                noise = value
            case Via.RATE:
                rate_hz = value
            case Via.ERROR:
                errors.append(f"{key}={value:g}")
            case Via.MODEL:
                model[key] = value / parameter.model_factor
            case Via.OBJECT:
                factors[key] = value
    options = ["--noise", f"{noise:g}", "--rate-hz", f"{rate_hz:g}"]
    files = {}
    if errors:
        options += ["--errors", ",".join(errors)]
    if model:
        path = f"models/{tag}.toml"
        files[path] = "".join(f"{key} = {_pair(key, value)}\n" for key, value in model.items())
        options += ["--sensor-model", str(folder / path)]
    names = list(objects)
    if factors:
        files |= {f"objects/{tag}/{name}.toml": file_text(name, factors) for name in objects}
        names = [str(folder / "objects" / tag / f"{name}.toml") for name in objects]
    if factors or tuple(objects) != tuple(OBJECTS):
        options += ["--objects", ",".join(names)]
    return Realisation(options, files)


def _pair(key: str, value: float) -> str:
    """TOML value of a key of the sensor model; `step_n` has a value for normal and for shear."""
    return f"[{value:.6g}, {value:.6g}]" if key == "step_n" else f"{value:.6g}"
