"""Tests of `python -m atas`."""

import sysconfig
from pathlib import Path

import pytest
from atas import __main__ as command


def install(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Makes `folder` the script folder of this environment."""
    monkeypatch.setattr(sysconfig, "get_path", lambda *_: str(folder))
    return folder / "atas"


def test_arguments_and_program_are_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = install(tmp_path, monkeypatch)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    executed: list[tuple[Path, list[str]]] = []
    monkeypatch.setattr("os.execv", lambda path, words: executed.append((path, words)))
    monkeypatch.setattr("sys.argv", ["atas/__main__.py", "demo", "grasp"])
    command.main()
    assert executed == [(program, [str(program), "demo", "grasp"])]


def test_missing_program_is_named_with_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(tmp_path, monkeypatch)
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == command.NOT_FOUND
    message = capsys.readouterr().err
    assert str(tmp_path) in message and "cargo build --workspace" in message


def test_file_without_execute_permission_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch).write_text("text")
    assert command.program() is None
