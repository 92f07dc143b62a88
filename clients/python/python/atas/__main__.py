"""Runs the program `atas` of this environment: `python -m atas demo grasp`.

The wheel of a release installs the program next to the interpreter's other commands. The program
replaces this process, so its output, signals and exit code are unchanged.
"""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path

NOT_FOUND = 127
"""Exit code of a shell for a missing command."""


def program() -> Path | None:
    """Path of `atas` in the script folders of this environment, or `None` if it is not installed."""
    folders = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user"))]
    paths = [Path(folder) / "atas" for folder in folders]
    return next((path for path in paths if os.access(path, os.X_OK) and path.is_file()), None)


def main() -> None:
    path = program()
    if path is None:
        folder = sysconfig.get_path("scripts")
        print(
            f"could not run atas: {folder} does not contain the program; install the wheel of a release, "
            "or build the programs with `cargo build --workspace` and run target/debug/atas",
            file=sys.stderr,
        )
        sys.exit(NOT_FOUND)
    sys.stdout.flush()
    os.execv(path, [str(path), *sys.argv[1:]])


if __name__ == "__main__":
    main()
