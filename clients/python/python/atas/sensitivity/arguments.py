"""Command line of `python -m atas.sensitivity`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from ..arguments import count
from .objects import OBJECTS

EXAMPLES = """\
examples:
  python -m atas.sensitivity parameters
  python -m atas.sensitivity one-at-a-time --out sensitivity --trials 40
  python -m atas.sensitivity morris --out sensitivity --trials 24 --trajectories 8
  python -m atas.sensitivity one-at-a-time --parameters drift latency rate --levels 9
  python -m atas.sensitivity one-at-a-time --engine mujoco --trials 16 --least-success 0.8

Finished points stay in FOLDER/points. The same command continues after an interrupt, and another
method reuses them. Other trials, or another build of the programs, are evaluated again. After a
change of an own engine, use another folder.

exit codes: 0 success, 1 a point failed, 2 invalid command line, 5 interrupted, 127 atas not found
"""
RUN_FIRST_SEED = 20_001
"""First seed for judging; lower seeds are for tuning."""


def share(least: float, most: float) -> Callable[[str], float]:
    """Returns a parser of numbers in a range."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not in the range {least:g} to {most:g}")
        return value

    return parse


def odd(text: str) -> int:
    """Parses an odd number of levels."""
    value = count(3)(text)
    if value % 2 == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is even; an odd number contains the nominal level")
    return value


def folder(text: str) -> Path:
    """Parses the output folder. Its path becomes a part of `--objects`, which splits at commas."""
    if "," in text:
        raise argparse.ArgumentTypeError(f"{text!r} contains a comma; use a folder without one")
    if Path(text).exists() and not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is no folder")
    return Path(text)


def parser() -> argparse.ArgumentParser:
    """Parser of the command line."""
    raw = argparse.RawDescriptionHelpFormatter
    top = argparse.ArgumentParser(
        prog="python -m atas.sensitivity",
        description="Measures the effect of sensor, contact, object and robot parameters on the grasp.",
        epilog=EXAMPLES,
        formatter_class=raw,
    )
    commands = top.add_subparsers(dest="command", required=True)
    commands.add_parser("parameters", help="print the parameters with range and source")
    single = commands.add_parser(
        "one-at-a-time", help="vary each parameter alone; writes domain.toml", epilog=EXAMPLES, formatter_class=raw
    )
    _add_common(single, trials=40)
    single.add_argument("--levels", type=odd, default=5, metavar="N", help="levels per parameter, odd [%(default)s]")
    single.add_argument(
        "--least-success", type=share(0.0, 1.0), default=0.85, metavar="SHARE",
        help="domain of validity: least lower end of the 95 %% interval of success [%(default)s]",
    )  # fmt: skip
    screen = commands.add_parser(
        "morris", help="vary all parameters together: elementary effects", epilog=EXAMPLES, formatter_class=raw
    )
    _add_common(screen, trials=24)
    screen.add_argument("--trajectories", type=count(2), default=8, metavar="N", help="trajectories [%(default)s]")
    screen.add_argument(
        "--span", type=share(0.01, 1.0), default=0.4, metavar="SHARE",
        help="share of each range around the nominal value; all parameters at their ends leave no success [%(default)s]",
    )  # fmt: skip
    screen.add_argument("--design-seed", type=count(0), default=1, metavar="N", help="seed of the trajectories [%(default)s]")
    return top


def _add_common(method: argparse.ArgumentParser, trials: int) -> None:
    method.add_argument("--out", type=folder, default=Path("sensitivity"), metavar="FOLDER", help="output folder [%(default)s]")
    method.add_argument("--trials", type=count(1), default=trials, metavar="N", help="trials per point [%(default)s]")
    method.add_argument(
        "--first-seed", type=count(0), default=RUN_FIRST_SEED, metavar="N", help="first seed of every point [%(default)s]"
    )
    method.add_argument("--parameters", nargs="+", default=[], metavar="NAME", help="parameters to vary [all]")
    method.add_argument(
        "--objects", nargs="+", choices=tuple(OBJECTS), default=list(OBJECTS), metavar="NAME", help="built-in objects [all]"
    )
    method.add_argument("--robot", metavar="NAME|FILE", help="robot of `atas eval` [two-hand-arm]")
    method.add_argument("--engine", metavar="mujoco|PROGRAM", help="physics engine of `atas eval` [built-in]")
    method.add_argument("--jobs", type=count(1), default=os.cpu_count() or 1, metavar="N", help="points at a time [one per core]")
    method.add_argument("--program", metavar="PATH", help="program atas [beside the interpreter, else on the path]")
