"""Tests of reading and replaying a real recording."""

import json
import subprocess
from pathlib import Path

import atas
import numpy as np
import pytest
from atas.features import HandFeatures
from conftest import PROGRAMS, Programs
from test_daemon import daemon, wait_for


def record(programs: Programs, file: Path) -> None:
    """Records a short grasp in lock-step."""
    recorder = programs.start("atas", "record", "--out", str(file))
    wait_for("the recorder", lambda: True if file.exists() else None)
    programs.start("atas-sim", "run", "--lockstep", "--object", "sponge", "--seed", "3")
    bus = daemon(programs, "--record-stream")
    goal = bus.grasp((0.32, -0.15, 0.0345), width=0.05, lift=0.01, hold=0.05)
    assert goal.wait(60)["state"] == atas.GoalState.SUCCEEDED
    ended = programs.started[2]
    ended.terminate()
    assert ended.wait(60) == 0
    recorder.send_signal(2)
    assert recorder.wait(60) == 0


def test_recording_is_read_and_replayed_exactly(programs: Programs, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    record(programs, file)
    recording = atas.Recording(str(file))
    commands, reports = recording.commands, recording.reports
    assert len(commands) > 1000 and len(recording.headers) == 1
    for hand in ("left", "right"):
        frames = recording.frames(hand)
        assert (np.diff(frames["stamp"]["sequence"].astype(np.int64)) == 1).all()
    assert frames["force_n"][:, :2, :, 0].sum(axis=2).max() > 0.1, "contact is recorded"
    assert len(recording.joint_states) == len(commands)
    assert set(recording.events["kind"]) >= {atas.EventKind.STEP, atas.EventKind.TOUCH_ON}
    assert len(recording.statuses) > 0
    replayed = recording.replay()
    assert (replayed["ticks"], replayed["different"], replayed["first_tick"]) == (len(commands), 0, None)
    assert replayed["commands"].tobytes() == commands.tobytes()
    # Reports differ in measured times, not in forces.
    felt = replayed["reports"]["hands"]["fingers"]["normal_n"]
    known = dict(zip(replayed["reports"]["tick"].tolist(), felt, strict=True))
    assert len(reports) > 0
    assert all((known[row["tick"]] == row["hands"]["fingers"]["normal_n"]).all() for row in reports)
    # The command line gives the same result.
    line = subprocess.run([PROGRAMS / "atas", "replay", file, "--format", "json"], capture_output=True, check=True)
    assert b'"different":0' in line.stdout.replace(b" ", b"")


def test_exported_data_set_has_the_features_of_a_hand(programs: Programs, tmp_path: Path) -> None:
    file, out = tmp_path / "run.mcap", tmp_path / "set"
    record(programs, file)
    words = ["export", str(file), "--to", "lerobot", "--elements", "--out", str(out)]
    subprocess.run([str(PROGRAMS / "atas"), *words], check=True, capture_output=True)
    features = json.loads((out / "meta" / "info.json").read_text())["features"]
    hand = HandFeatures(None, "right", "taxels", "pose")
    assert features["observation.state"]["names"] == hand.state_names()
    assert features["observation.taxels"]["names"] == hand.taxel_names(41)
    assert features["action"]["names"] == hand.action_names()


def test_unreadable_recording_raises(tmp_path: Path) -> None:
    with pytest.raises(atas.AtasError, match="absent.mcap"):
        atas.Recording(str(tmp_path / "absent.mcap"))
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"\x89MCAP0\r\n" + b"junk" * 100)
    with pytest.raises(atas.AtasError, match="repair"):
        _ = atas.Recording(str(broken)).commands
