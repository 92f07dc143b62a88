"""Tests of the learning baseline: it improves and is deterministic."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


def learn(*arguments: str) -> dict[str, object]:
    words = [sys.executable, "-m", "atas.learn", "--format", "json", *arguments]
    told: dict[str, object] = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)
    return told


def test_the_baseline_learns(tmp_path: Path) -> None:
    words = "--generations 3 --population 8 --episodes 2 --trials 6 --objects slippery-50".split()
    figure = tmp_path / "curve.svg"
    told = learn(*words, "--out", str(figure))
    curve = told["curve"]
    assert isinstance(curve, list)
    assert curve[-1]["return_mean"] > curve[0]["return_mean"] + 2.0, curve
    assert told["parameters"] == learn(*words)["parameters"], "equal seeds give equal bits"
    assert figure.read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("atas.learn --generations 0", "at least 1"),
        ("atas.learn --population x", "at least 3"),
        ("atas.learn --out absent/x.svg", "does not exist"),
        ("atas.bench --steps 5", "at least 100"),
        ("atas.bench --sensor 0", "0.1 to 86400"),
    ],
)
def test_invalid_arguments_are_rejected(words: str, says: str) -> None:
    ran = subprocess.run([sys.executable, "-m", *words.split()], capture_output=True, text=True, check=False)
    assert ran.returncode == 2 and says in ran.stderr and "Traceback" not in ran.stderr, ran.stderr
