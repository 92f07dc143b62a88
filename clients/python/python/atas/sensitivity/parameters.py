"""Table of the parameters: unit, range, source of the range, and the option that applies a value.

A parameter has two ends. Fraction 0 of its range is the first end, fraction 1 the last end. The
nominal value is the first end, or the middle of a range with two sides.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


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
    is_log: bool = False
    """True: levels have constant ratios. False: constant differences."""
    model_key: str | None = None
    """Key of a sensor model with this property, for comparison with an own sensor."""
    model_factor: float = 1.0
    """Value of this parameter over the value of `model_key`."""

    def value(self, fraction: float) -> float:
        """Value at a fraction of the range, with four significant digits."""
        if not 0.0 <= fraction <= 1.0:
            raise ValueError(f"fraction {fraction} of the range of {self.name}; needs 0 to 1")
        if self.is_log:
            value = self.first * (self.last / self.first) ** fraction
        else:
            value = self.first + (self.last - self.first) * fraction
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
    return Parameter(
        name, group, unit, first, last, Via.ERROR, source, is_log=first > 0.0, model_key=key, model_factor=factor
    )  # fmt: skip


def _factor(name: str, key: str, last: float, source: str) -> Parameter:
    """Factor on a property of every object, from 1/`last` to `last`."""
    return Parameter(name, "object", "×", 1.0 / last, last, Via.OBJECT, source, key, is_two_sided=True, is_log=True)


PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "rate", "sensor", "Hz", 1000.0, 30.0, Via.RATE,
        "tick rate to the slowest rate of the acceptance criterion; built-in models have 100 to 176 Hz",
        is_log=True, model_key="rate_hz",
    ),
    Parameter(
        "noise", "sensor", "× design", 1.0, 10.0, Via.NOISE,
        "design is 3 mN per element; eFlesh has 70 mN on one element, 4 times the design's sum",
        is_log=True, model_key="noise_n", model_factor=1 / 0.003,
    ),
    Parameter(
        "resolution", "sensor", "mN", 1.0, 100.0, Via.MODEL, "design to step of Paxini GEN3 (vendor's protocol)",
        "step_n", is_log=True, model_key="step_n", model_factor=1e3,
    ),
    Parameter(
        "gain-spread", "sensor", "%", 3.0, 23.0, Via.MODEL, "design choice: eight times the design's deviation",
        "gain_spread", model_key="gain_spread", model_factor=1e2,
    ),
    _error("gain", "sensor", "± %", 40.0, "four times the default error; the simulator's limit is 50 %"),
    _error("bias", "sensor", "± mN", 80.0, "OptoForce OMD-20: 90 % within 37 to 77 mN per axis", model=("bias_n", 1e3)),
    _error("crosstalk", "sensor", "%", 20.0, "four times the default error; skins before calibration", model=("crosstalk", 1e2)),
    _error("drift", "sensor", "± N/s", 0.1, "twice the default error; eFlesh has 0.0013 N/s", model=("drift.rate_n_s", 1.0)),
    _error("hysteresis", "sensor", "%", 20.0, "the simulator's limit; four times the default error", model=("hysteresis.share", 1e2)),
    _error("creep", "sensor", "% per decade", 20.0, "three times that of eFlesh (6.25 %)", model=("creep.per_decade", 1e2)),
    _error(
        "saturation", "sensor", "N per element", 0.25, "largest force of the hand to half of the default error",
        first=8.0, model=("saturation_n", 1.0),
    ),
    _error("dead", "sensor", "% of elements", 20.0, "four times the default error", model=("dead.share", 1e2)),
    _error("wear", "sensor", "% of gain", 50.0, "loss of half of the gain", model=("wear.loss", 1e2)),
    _error(
        "latency", "sensor", "ms", 32.0, "two periods of the default latency timer of USB bridges (16 ms)",
        model=("frames.latency_s", 1e3),
    ),
    _error("jitter", "sensor", "ms", 16.0, "default latency timer of USB bridges", model=("frames.jitter_s", 1e3)),
    _error("frame-loss", "sensor", "%", 40.0, "eight times the default error", model=("frames.loss", 1e2)),
    _error("tips", "contact", "± %", 50.0, "the simulator's limit; true stiffness of the skin, unknown to the controller"),
    _factor("friction", "friction", 2.0, "dusty or moist face to rubber on a clean face"),
    _factor("stiffness", "stiffness_n_m", 4.0, "spread of soft packaging; rigid objects stay rigid"),
    _factor("mass", "mass_kg", 2.0, "empty to full container; at least 12.5 g, the simulator's limit"),
    _factor("crush", "crush_n", 2.0, "spread of packaging; objects without crushing force stay without"),
    _error("centre-of-mass", "object", "± mm", 16.0, "three times the default error; below the half width of all objects"),
    _error("position", "object", "± mm", 16.0, "three times the default error; a camera without calibration"),
    _error("yaw", "object", "± °", 40.0, "nearly half the turn from one pair of faces of a box to the next (45°)"),
    _error("expected-width", "object", "± mm", 16.0, "four times the default error"),
    _error("height", "object", "mm at most", 200.0, "the default error"),
    _error("servo", "robot", "± %", 40.0, "four times the default error; the simulator's limit is 50 %"),
    _error("links", "robot", "± mm", 4.0, "four times the default error; a printed arm without calibration"),
)  # fmt: skip
"""All parameters, by group."""


def select(names: Iterable[str]) -> tuple[Parameter, ...]:
    """Parameters of these names, in the order of the table; all for no name."""
    wanted = set(names)
    known = {parameter.name for parameter in PARAMETERS}
    if unknown := sorted(wanted - known):
        raise ValueError(f"unknown parameter {', '.join(unknown)}; needs some of {', '.join(p.name for p in PARAMETERS)}")
    return tuple(parameter for parameter in PARAMETERS if not wanted or parameter.name in wanted)
