"""The baseline learns, and the same seed learns the same."""

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
    assert told["parameters"] == learn(*words)["parameters"], "the same seed, the same bits"
    assert figure.read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("atas.learn --generations 0", "from 1 on"),
        ("atas.learn --population x", "from 3 on"),
        ("atas.learn --out absent/x.svg", "is no folder"),
        ("atas.bench --steps 5", "from 100 on"),
        ("atas.bench --sensor 0", "0.1 to 86400"),
    ],
)
def test_wrong_words_are_refused(words: str, says: str) -> None:
    ran = subprocess.run([sys.executable, "-m", *words.split()], capture_output=True, text=True, check=False)
    assert ran.returncode == 2 and says in ran.stderr and "Traceback" not in ran.stderr, ran.stderr
