"""Tests of the example programs."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import PROGRAMS

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def test_mujoco_and_atas_agree() -> None:
    pytest.importorskip("mujoco")
    words = [sys.executable, str(EXAMPLES / "mujoco_hand.py"), "--atasd", str(PROGRAMS / "atasd"), "--objects", "block"]
    ran = subprocess.run(words, capture_output=True, text=True, timeout=600, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    rows = [line.split() for line in ran.stdout.splitlines()[1:]]
    assert [row[:3] for row in rows] == [["block", "MuJoCo", "SUCCEEDED"], ["block", "ATAS", "SUCCEEDED"]], ran.stdout
