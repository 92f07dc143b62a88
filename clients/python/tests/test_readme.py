"""Tests of the programs in the READMEs."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import atas
import pytest
from conftest import Programs
from test_daemon import daemon, wait_for
from test_recording import record

ROOT = Path(__file__).resolve().parents[3]
README = ROOT / "clients" / "python" / "README.md"


def blocks() -> Iterator[tuple[str, str, str]]:
    """Yields name, requirements and text of each program."""
    for text in re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL):
        yield "README.md", "", text
    for text in re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL):
        first = text.splitlines()[0]
        name, _, needs = first.removeprefix("# ").partition(": ")
        yield name, needs, text


def run(programs: Programs, text: str, *arguments: str) -> str:
    program = programs.folder / "program.py"
    program.write_text(text)
    ran = subprocess.run(
        [sys.executable, "-W", "error", program, *arguments],
        env=os.environ | {"ATAS_BUS": programs.bus},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


SAYS = {
    "README.md": "stiffness_n_m",
    "simulate.py": "heavy-block  REFUSED",
    "feel.py": "taxels of the right hand: (2, 41, 3)",
    "grasp.py": "SUCCEEDED",
    "look.py": "frame age",
    "teleop.py": "carry F_n",
    "sensor.py": "",
    "robot.py": "SUCCEEDED",
    "replay.py": ", 0 commands differ",
    "show.py": 'robot "test-bench"',
    "learn.py": "(480, 640, 3) (2, 3)",
    "optimise.py": "of 800 after 2000 genomes",
}


@pytest.mark.parametrize(("name", "needs", "text"), list(blocks()), ids=[name for name, *_ in blocks()])
def test_readme_program_runs(programs: Programs, name: str, needs: str, text: str) -> None:
    arguments: list[str] = []
    if name == "grasp.py":
        # In lock-step the result does not depend on the machine's speed.
        programs.start("atas-sim", "run", "--lockstep", "--object", "wood", "--seed", "3")
        daemon(programs)
    elif "simulator" in needs:
        programs.start("atas-sim", "run", "--object", "wood")
        programs.start("atasd", "--config", "/dev/null", "--set", "realtime.mode=off")
        wait_for("reports", atas.Bus(programs.bus, create=True).reports().newest)
    elif "lock-step" in needs:
        daemon(programs)
    elif "recording" in needs:
        file = programs.folder / "run.mcap"
        record(programs, file)
        arguments = [str(file)]
    assert SAYS[name] in run(programs, text, *arguments)
