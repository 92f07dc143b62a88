"""What the package's programs check before they begin."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Callable


def count(least: int) -> Callable[[str], int]:
    """A whole number from `least` on."""

    def parse(text: str) -> int:
        if not text.lstrip("-").isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"was {text!r}, needs a whole number from {least} on")
        return int(text)

    return parse


def seconds(text: str) -> float:
    """A time that can be waited for."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 86_400.0:
        raise argparse.ArgumentTypeError(f"was {text!r}, needs 0.1 to 86400 seconds")
    return value


def need_gymnasium() -> None:
    """Ends the program if there are no environments to run."""
    if importlib.util.find_spec("gymnasium") is None:
        sys.exit('could not begin because gymnasium is not installed; install it with: pip install "gymnasium>=1.1"')
