"""Table of the parameters: unit, range, source of the range, and the option that applies a value.

A parameter has two ends. Fraction 0 of its range is the first end, fraction 1 the last end. The
nominal value is the first end, or the middle of a range with two sides.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Scale(Enum):
    """Spacing of the levels over the range."""

    LINEAR = "linear"
    """Constant differences."""
    SQUARE = "square"
    """Value over the last end is the square of the fraction: finer near zero."""
    LOG = "logarithmic"
    """Constant ratios."""


class Via(Enum):
    """Option of `atas eval grasp` that applies a value."""

    NOISE = "--noise"
    RATE = "--rate-hz"
    ERROR = "--errors"
    MODEL = "--sensor-model"
    OBJECT = "--objects"


@dataclass(frozen=True)
class Parameter:
    """One parameter."""

    name: str
    group: str
    """`sensor`, `contact`, `object` or `robot`."""
    unit: str
    first: float
    """Value at fraction 0, in `unit`."""
    last: float
    """Value at fraction 1."""
    via: Via
    source: str
    """Source of the range."""
    key: str = ""
    """Kind of error, or key of the sensor model or object file. Default: the name."""
    is_two_sided: bool = False
    """True: the nominal value is the middle of the range. False: it is the first end."""
    scale: Scale = Scale.LINEAR
    model_key: str | None = None
    """Key of a sensor model with this property, for comparison with an own sensor."""
    model_factor: float = 1.0
    """Value of this parameter over the value of `model_key`."""

    def value(self, fraction: float) -> float:
        """Value at a fraction of the range, with four significant digits."""
        if not 0.0 <= fraction <= 1.0:
            raise ValueError(f"fraction {fraction} of the range of {self.name}; needs 0 to 1")
        match self.scale:
            case Scale.LINEAR:
                value = self.first + (self.last - self.first) * fraction
            case Scale.SQUARE:
                value = self.first + (self.last - self.first) * fraction**2
            case Scale.LOG:
                value = self.first * (self.last / self.first) ** fraction
        # `--rate-hz` takes whole numbers.
        return float(round(value)) if self.via is Via.RATE else float(f"{value:.4g}")

    @property
    def nominal_fraction(self) -> float:
        """Fraction of the nominal value."""
        return 0.5 if self.is_two_sided else 0.0

    @property
    def nominal(self) -> float:
        """Nominal value."""
        return self.value(self.nominal_fraction)

    @property
    def label(self) -> str:
        """Name with unit."""
        return f"{self.name}, {self.unit}"


def _error(
    name: str, group: str, unit: str, last: float, source: str, *, first: float = 0.0, model: tuple[str, float] | None = None
) -> Parameter:
    """Parameter of `--errors`, off at its nominal value. `model`: key of a sensor model, and factor."""
    key, factor = model or (None, 1.0)
    scale = Scale.LOG if first > 0.0 else Scale.SQUARE
    return Parameter(name, group, unit, first, last, Via.ERROR, source, scale=scale, model_key=key, model_factor=factor)


def _factor(name: str, key: str, last: float, source: str) -> Parameter:
    """Factor on a property of every object, from 1/`last` to `last`."""
    return Parameter(name, "object", "×", 1.0 / last, last, Via.OBJECT, source, key, is_two_sided=True, scale=Scale.LOG)


PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "rate", "sensor", "Hz", 1000.0, 10.0, Via.RATE,
        "tick rate to a third of the slowest rate of the acceptance criterion (30 Hz)",
        scale=Scale.LOG, model_key="rate_hz",
    ),
    Parameter(
        "noise", "sensor", "× design", 1.0, 25.0, Via.NOISE,
        "design (3 mN per element) to eFlesh (70 mN, fitted)",
        scale=Scale.LOG, model_key="noise_n", model_factor=1 / 0.003,
    ),
    Parameter(
        "resolution", "sensor", "mN", 1.0, 100.0, Via.MODEL, "design to step of Paxini GEN3 (vendor's protocol)",
        "step_n", scale=Scale.LOG, model_key="step_n", model_factor=1e3,
    ),
    Parameter(
        "gain-spread", "sensor", "%", 3.0, 48.0, Via.MODEL, "design to the simulator's limit (50 %)",
        "gain_spread", scale=Scale.LOG, model_key="gain_spread", model_factor=1e2,
    ),
    _error("gain", "sensor", "± %", 40.0, "four times the default error; the simulator's limit is 50 %"),
    _error("bias", "sensor", "± mN", 80.0, "OptoForce OMD-20: 90 % within 37 to 77 mN per axis", model=("bias_n", 1e3)),
    _error("crosstalk", "sensor", "%", 40.0, "eight times the default error; the simulator's limit is 50 %", model=("crosstalk", 1e2)),
    _error("drift", "sensor", "± N/s", 0.1, "twice the default error; eFlesh has 0.0013 N/s", model=("drift.rate_n_s", 1.0)),
    _error("hysteresis", "sensor", "%", 20.0, "the simulator's limit; four times the default error", model=("hysteresis.share", 1e2)),
    _error(
        "creep", "sensor", "% per decade", 40.0, "six times that of eFlesh (6.25 %); the simulator's limit is 50 %",
        model=("creep.per_decade", 1e2),
    ),
    _error(
        "saturation", "sensor", "N per element", 0.25, "largest force of the hand to half of the default error",
        first=8.0, model=("saturation_n", 1.0),
    ),
    _error("dead", "sensor", "% of elements", 20.0, "four times the default error", model=("dead.share", 1e2)),
    _error("wear", "sensor", "% of gain", 50.0, "loss of half of the gain", model=("wear.loss", 1e2)),
    _error(
        "latency", "sensor", "ms", 100.0, "USB bridges (timer of 16 ms) to six times that; design choice",
        model=("frames.latency_s", 1e3),
    ),
    _error(
        "jitter", "sensor", "ms", 64.0, "USB bridges (timer of 16 ms) to four times that; design choice",
        model=("frames.jitter_s", 1e3),
    ),
    _error("frame-loss", "sensor", "%", 80.0, "16 times the default error", model=("frames.loss", 1e2)),
    _error("tips", "contact", "± %", 50.0, "the simulator's limit; true stiffness of the skin, unknown to the controller"),
    _factor("friction", "friction", 3.0, "smooth plastic to rubber: 0.07 to 1.8 over all objects"),
    _factor("stiffness", "stiffness_n_m", 4.0, "spread of soft packaging; rigid objects stay rigid"),
    _factor("mass", "mass_kg", 3.0, "empty to full container; at least 12.5 g, the simulator's limit"),
    _factor("crush", "crush_n", 2.0, "spread of packaging; objects without crushing force stay without"),
    _error("centre-of-mass", "object", "± mm", 16.0, "three times the default error; below the half width of all objects"),
    _error("position", "object", "± mm", 16.0, "three times the default error; a camera without calibration"),
    _error("yaw", "object", "± °", 40.0, "nearly half the turn from one pair of faces of a box to the next (45°)"),
    _error("expected-width", "object", "± mm", 16.0, "four times the default error"),
    _error("height", "object", "mm at most", 200.0, "the default error"),
    _error("servo", "robot", "± %", 50.0, "the simulator's limit; five times the default error"),
    _error("servo-lag", "robot", "ms", 80.0, "four times the default error"),
    _error("links", "robot", "± mm", 10.0, "the simulator's limit; ten times the default error"),
)  # fmt: skip
"""All parameters, by group."""


def select(names: Iterable[str]) -> tuple[Parameter, ...]:
    """Parameters of these names, in the order of the table; all for no name."""
    wanted = set(names)
    known = {parameter.name for parameter in PARAMETERS}
    if unknown := sorted(wanted - known):
        raise ValueError(f"unknown parameter {', '.join(unknown)}; needs some of {', '.join(p.name for p in PARAMETERS)}")
    return tuple(parameter for parameter in PARAMETERS if not wanted or parameter.name in wanted)
