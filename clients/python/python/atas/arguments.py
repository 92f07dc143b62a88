"""Argument checks of the package's programs."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Callable


def count(least: int) -> Callable[[str], int]:
    """Returns a parser of integers of at least `least`."""

    def parse(text: str) -> int:
        if not text.lstrip("-").isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is no integer of at least {least}")
        return int(text)

    return parse


def seconds(text: str) -> float:
    """Parses a time from 0.1 to 86400 s."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 86_400.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not in the range 0.1 to 86400 seconds")
    return value


def need_gymnasium() -> None:
    """Ends the program if gymnasium is not installed."""
    if importlib.util.find_spec("gymnasium") is None:
        sys.exit('gymnasium is not installed; run: pip install "gymnasium>=1.1"')
