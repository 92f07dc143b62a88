"""Tests of the package's enumerations, types and documentation."""

import enum
import inspect
import subprocess
import sys
from pathlib import Path

import atas
from atas import _native, codes

PACKAGE = Path(codes.__file__).parent
HOME = Path(__file__).resolve().parents[1]
"""Folder with mypy's settings (strict)."""


def generated() -> str:
    lines = [
        '"""Codes of the bus, generated from the schema (checked by a test). Unknown values remain plain numbers."""',
        "",
        "from enum import IntEnum",
    ]
    for name, about, values in _native.codes():
        lines += ["", "", f"class {name}(IntEnum):", f'    """{about}"""', ""]
        lines += [f"    {value} = {number}" for value, number, _text in values]
    return "\n".join(lines) + "\n"


def test_codes_match_schema(tmp_path: Path) -> None:
    expected = generated()
    actual = PACKAGE / "codes.py"
    if actual.read_text() != expected:
        (tmp_path / "codes.py").write_text(expected)
        raise AssertionError(f"codes.py differs from the schema; replace it with {tmp_path / 'codes.py'}")
    assert issubclass(codes.Mode, enum.IntEnum) and int(codes.Mode.SAFE_STOP) == 4


def test_everything_public_is_documented() -> None:
    for name in atas.__all__:
        thing = getattr(atas, name)
        if not inspect.isclass(thing) and not callable(thing):
            continue
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and thing.__module__ == "atas":
            for method in (member for member in vars(thing) if not member.startswith("_")):
                assert inspect.getdoc(getattr(thing, method)), f"{name}.{method}"


def test_types_match_library() -> None:
    for command in (
        ["mypy.stubtest", "atas._native", "--ignore-disjoint-bases"],
        ["mypy", "--package", "atas"],
        ["mypy", "tests"],
    ):
        checked = subprocess.run([sys.executable, "-m", *command], cwd=HOME, capture_output=True, text=True, check=False)
        assert checked.returncode == 0, checked.stdout + checked.stderr
