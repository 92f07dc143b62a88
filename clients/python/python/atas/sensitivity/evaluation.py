"""Evaluation of design points: runs `atas eval grasp`, and keeps every finished point in a file."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..__main__ import program as installed_program
from .design import Point, Realisation, realise
from .measures import Measures

ENGINE_PROGRAM = "atas-lab"
"""Program that `atas eval` executes, beside `atas`."""
TERMINATION_S = 10.0
"""Time for an evaluation to end after a termination signal, s. Then it is killed."""


class Failed(Exception):
    """An evaluation failed; the text is its reason."""


class MissingProgram(Failed):
    """The program `atas` was not found."""


def find_program(given: str | None) -> Path:
    """Path of `atas`: as given, else of this environment, else on the path."""
    if given is not None:
        path = shutil.which(given)
        if path is None:
            raise MissingProgram(f"could not run {given}: it is no executable file; correct --program")
        return Path(path)
    found = installed_program() or shutil.which("atas")
    if found is None:
        raise MissingProgram(
            "could not run atas: it is neither beside the interpreter nor on the path; install the wheel "
            "of a release, or name a build with --program target/debug/atas"
        )
    return Path(found)


def identity(program: Path) -> dict[str, str]:
    """Version of `atas`, and a hash of the programs, which separates development builds."""
    ran = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        raise Failed(f"could not read the version of {program}: {ran.stderr.strip() or 'no output'}")
    digest = hashlib.sha256()
    for path in (program, program.resolve().with_name(ENGINE_PROGRAM)):
        if path.is_file():
            digest.update(path.read_bytes())
    return {"version": ran.stdout.strip(), "programs_sha256": digest.hexdigest()}


@dataclass(frozen=True)
class Settings:
    """Settings that all points share."""

    trials: int
    first_seed: int
    objects: tuple[str, ...]
    robot: str | None = None
    engine: str | None = None

    def options(self) -> list[str]:
        """Options of `atas eval grasp`."""
        words = ["--trials", str(self.trials), "--first-seed", str(self.first_seed)]
        if self.robot is not None:
            words += ["--robot", self.robot]
        if self.engine is not None:
            words += ["--engine", self.engine]
        return [*words, "--no-baselines", "--threads", "1", "--format", "json"]


@dataclass
class Outcomes:
    """Measures of the finished points and reasons of the failed ones, by key of the point."""

    measures: dict[str, Measures] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    commands: dict[str, str] = field(default_factory=dict)

    def of(self, values: Point) -> Measures | None:
        """Measures of a point; `None` if it failed."""
        return self.measures.get(name_of(values))

    def command(self, values: Point) -> str:
        """Command line of a point."""
        return self.commands[name_of(values)]


def name_of(values: Point) -> str:
    """Readable name of a point, which identifies it within a run."""
    return ",".join(f"{name}={values[name]:g}" for name in sorted(values)) or "nominal"


class Evaluator:
    """Evaluates points, several at a time, with a cache in a folder."""

    def __init__(self, program: Path, folder: Path, settings: Settings, jobs: int) -> None:
        self._program, self._folder, self._settings, self._jobs = program, folder, settings, jobs
        self.identity = identity(program)
        self._running: set[subprocess.Popen[str]] = set()
        self._lock = threading.Lock()
        self._is_stopped = False

    def run(self, points: Sequence[Point], report: Callable[[int, int, float], None]) -> Outcomes:
        """Evaluates all points once. `report` receives finished, total and s per new point.

        A failed point does not stop the others. If the first one fails and no earlier result
        exists, its error is raised: the others would fail for the same reason.
        """
        outcomes = Outcomes()
        todo: list[tuple[str, Point, Realisation, Path]] = []
        unique = {name_of(values): values for values in points}
        for name, values in unique.items():
            realisation, path = self._prepare(values)
            outcomes.commands[name] = shlex.join(["atas", *self._words(realisation)])
            if (measures := self._load(path)) is not None:
                outcomes.measures[name] = measures
            else:
                todo.append((name, values, realisation, path))
        begin, kept = time.monotonic(), len(outcomes.measures)
        report(kept, len(unique), 0.0)
        with ThreadPoolExecutor(self._jobs) as pool:
            try:
                pending: dict[Future[Measures], str] = {}
                for index, (name, values, realisation, path) in enumerate(todo):
                    future = pool.submit(self._evaluate, values, realisation, path)
                    pending[future] = name
                    if index == 0 and not outcomes.measures:
                        wait(pending)
                        if (error := future.exception()) is not None:
                            raise error
                while pending:
                    done, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
                    for future in done:
                        name = pending.pop(future)
                        error = future.exception()
                        if error is None:
                            outcomes.measures[name] = future.result()
                        elif isinstance(error, Failed):
                            outcomes.failed[name] = str(error)
                        else:
                            raise error
                        finished = len(outcomes.measures) + len(outcomes.failed)
                        report(finished, len(unique), (time.monotonic() - begin) / (finished - kept))
            except BaseException:
                self._stop()
                pool.shutdown(cancel_futures=True)
                raise
        return outcomes

    def _prepare(self, values: Point) -> tuple[Realisation, Path]:
        """Options of a point and the file of its measures, whose name is a hash of all inputs."""
        tag = hashlib.sha256(name_of(values).encode()).hexdigest()[:12]
        realisation = realise(values, self._settings.objects, self._folder, tag)
        neutral = realise(values, self._settings.objects, Path(), tag)
        inputs = [self.identity, self._settings.options(), neutral.options, neutral.files, _file_hash(self._settings.robot)]
        key = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()[:16]
        return realisation, self._folder / "points" / f"{key}.json"

    def _words(self, realisation: Realisation) -> list[str]:
        return ["eval", "grasp", *self._settings.options(), *realisation.options]

    @staticmethod
    def _load(path: Path) -> Measures | None:
        """Measures of an earlier run; `None` if there are none, or if the file is damaged."""
        try:
            return Measures(**json.loads(path.read_text())["measures"])
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def _evaluate(self, values: Point, realisation: Realisation, path: Path) -> Measures:
        """Evaluates one point and keeps it."""
        for name, text in realisation.files.items():
            write(self._folder / name, text)
        words = self._words(realisation)
        begin = time.monotonic()
        try:
            measures = Measures.from_report(json.loads(self._execute(words)))
        except (ValueError, KeyError, TypeError) as error:
            raise Failed(f"could not read the report of `{shlex.join(['atas', *words])}`: {error!r}") from error
        kept: dict[str, Any] = {"point": dict(values), "command": shlex.join(["atas", *words])}
        kept |= {"identity": self.identity, "wall_s": round(time.monotonic() - begin, 3)}
        kept["measures"] = {name: getattr(measures, name) for name in Measures.__dataclass_fields__}
        write(path, json.dumps(kept, indent=1) + "\n")
        return measures

    def _execute(self, words: list[str]) -> str:
        """Standard output of an evaluation."""
        with self._lock:
            if self._is_stopped:
                raise Failed("interrupted")
            # A separate session: the terminal's interrupt reaches this process only, which ends
            # the evaluations.
            child = subprocess.Popen(
                [str(self._program), *words],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
                env={"ATAS_PYTHON": sys.executable} | os.environ,
            )
            self._running.add(child)
        try:
            out, err = child.communicate()
        finally:
            with self._lock:
                self._running.discard(child)
        if child.returncode != 0:
            raise Failed(f"`{shlex.join(['atas', *words])}` ended with {child.returncode}: {err.strip() or 'no message'}")
        return out

    def _stop(self) -> None:
        """Ends the running evaluations, and starts no more."""
        with self._lock:
            self._is_stopped = True
            running = list(self._running)
        for child in running:
            child.terminate()
        for child in running:
            try:
                child.wait(TERMINATION_S)
            except subprocess.TimeoutExpired:
                child.kill()


def write(path: Path, text: str) -> None:
    """Writes a file in one step: an interrupt leaves the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def _file_hash(path: str | None) -> str:
    """Hash of a robot file; empty for a built-in robot."""
    if path is None or not Path(path).is_file():
        return ""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
