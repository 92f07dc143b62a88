"""Runs the sensitivity analysis: `python -m atas.sensitivity METHOD --out FOLDER`."""

from __future__ import annotations

import argparse
import importlib.util
import json
import shlex
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from .arguments import parser
from .design import Point
from .evaluation import Evaluator, Failed, MissingProgram, Outcomes, Settings, find_program, write
from .one_at_a_time import Criterion, points, rows
from .parameters import PARAMETERS, Parameter, select

FAILED, INTERRUPTED, NOT_FOUND = 1, 5, 127
"""Exit codes: as those of `atas`, and as of a shell for a missing program."""


class Progress:
    """Progress on standard error, if it is a terminal."""

    def __init__(self) -> None:
        self.finished, self.total = 0, 0
        self._is_shown = sys.stderr.isatty()

    def report(self, finished: int, total: int, seconds: float) -> None:
        """Shows the number of finished points, and the time left at `seconds` per point."""
        self.finished, self.total = finished, total
        if self._is_shown:
            left = f", about {seconds * (total - finished) / 60:.0f} min left" if seconds > 0 else ""
            print(f"\r\x1b[K{finished} of {total} points{left}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Removes the progress."""
        if self._is_shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def need_salib() -> None:
    """Ends the program if SALib is not installed."""
    if importlib.util.find_spec("SALib") is None:
        sys.exit("SALib is not installed; run: pip install 'atas[sensitivity]'")


def print_parameters() -> None:
    """Prints the table of parameters."""
    print(f"{'name':15} {'group':8} {'unit':14} {'nominal':>8}  {'range':16} {'option':15} source of the range")
    for p in PARAMETERS:
        ends = f"{p.first:g} to {p.last:g}"
        print(f"{p.name:15} {p.group:8} {p.unit:14} {p.nominal:8g}  {ends:16} {p.via.value:15} {p.source}")


def evaluate(options: argparse.Namespace, program: Path, points: Sequence[Point]) -> tuple[Outcomes, Evaluator, Settings]:
    """Evaluates the points."""
    settings = Settings(options.trials, options.first_seed, tuple(dict.fromkeys(options.objects)), options.robot, options.engine)
    evaluator = Evaluator(program, options.out, settings, options.jobs)
    progress = Progress()
    try:
        outcomes = evaluator.run(points, progress.report)
    except KeyboardInterrupt:
        progress.clear()
        text = f"interrupted after {progress.finished} of {progress.total} points; the same command continues"
        print(text, file=sys.stderr)
        sys.exit(INTERRUPTED)
    finally:
        progress.clear()
    return outcomes, evaluator, settings


def save(out: Path, files: dict[str, str]) -> None:
    """Writes the output files and prints their paths."""
    for name, text in files.items():
        write(out / name, text)
    print("written: " + ", ".join(str(out / name) for name in files))


def one_at_a_time(options: argparse.Namespace, program: Path, parameters: tuple[Parameter, ...], command: str) -> Outcomes:
    """Runs the one-at-a-time method and writes its files."""
    from . import figures, report

    criterion = Criterion(options.least_success)
    outcomes, evaluator, settings = evaluate(options, program, points(parameters, options.levels))
    found = sorted(rows(parameters, options.levels, outcomes), key=lambda row: -row.effect)
    origin = report.Origin(command, evaluator.identity, settings)
    title = f"Grasp, one parameter at a time: {options.trials} trials per cell, seeds from {options.first_seed}"
    save(
        options.out,
        {
            "one-at-a-time.json": to_json(report.one_at_a_time_json(found, criterion, outcomes, origin)),
            "one-at-a-time.md": report.one_at_a_time_table(found, criterion, options.trials),
            "one-at-a-time.svg": figures.one_at_a_time(found, criterion, title),
            "domain.md": report.domain_table(found, criterion),
            "domain.toml": report.domain_toml(found, criterion, origin),
        },
    )
    strongest = [f"{row.parameter.name} (−{100 * row.effect:.0f} points)" for row in found[: report.NAMED]]
    print(f"largest loss of success over the range: {', '.join(strongest)}")
    if all(row.domain(criterion) is None for row in found):
        print("the nominal point violates the criterion: domain.toml contains no parameter", file=sys.stderr)
    return outcomes


def morris(options: argparse.Namespace, program: Path, parameters: tuple[Parameter, ...], command: str) -> Outcomes:
    """Runs the global method and writes its files."""
    from . import figures, report
    from .morris import Design

    design = Design.sample(parameters, options.trajectories, options.span, options.design_seed)
    # The nominal point first: it shows a wrong command line at once.
    outcomes, evaluator, settings = evaluate(options, program, [{}, *design.points()])
    screenings = design.screen(outcomes)
    origin = report.Origin(command, evaluator.identity, settings)
    files = {"morris.json": to_json(report.morris_json(design, screenings, outcomes, origin))}
    first = screenings[0]
    if first.effects:
        labels = {parameter.name: parameter.label for parameter in parameters}
        title = f"Grasp, Morris: {first.trajectories} trajectories, {options.trials} trials per point, span {options.span:g}"
        files["morris.md"] = report.morris_table(screenings, labels)
        files["morris.svg"] = figures.morris(screenings, labels, title)
    save(options.out, files)
    if first.effects:
        strongest = [f"{name} (µ* {first.effects[name].mu_star:.2f})" for name in first.ranking()[: report.NAMED]]
        print(f"largest effect on success: {', '.join(strongest)}")
    else:
        print("fewer than two complete trajectories: no effects", file=sys.stderr)
    return outcomes


def to_json(value: object) -> str:
    """JSON text of a file."""
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs the command line."""
    top = parser()
    words = list(sys.argv[1:] if arguments is None else arguments)
    options = top.parse_args(words)
    if options.command == "parameters":
        print_parameters()
        return
    need_salib()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    is_single = options.command == "one-at-a-time"
    try:
        parameters = select(options.parameters)
        if is_single:
            Criterion(options.least_success).check(options.trials)
    except ValueError as error:
        top.error(str(error))
    run = one_at_a_time if is_single else morris
    try:
        outcomes = run(options, find_program(options.program), parameters, shlex.join(["python", "-m", "atas.sensitivity", *words]))
    except MissingProgram as error:
        print(error, file=sys.stderr)
        sys.exit(NOT_FOUND)
    except (Failed, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(FAILED)
    if outcomes.failed:
        print(f"{len(outcomes.failed)} points failed, the same command tries them again:", file=sys.stderr)
        for name, reason in outcomes.failed.items():
            print(f"  {name}: {reason}", file=sys.stderr)
        sys.exit(FAILED)


if __name__ == "__main__":
    main()
