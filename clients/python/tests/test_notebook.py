"""Test of the example notebook: its cells run, and their stored texts are those that they print.

`ATAS_BLESS=1 python -m pytest clients/python -k notebook` runs the cells and stores their outputs.
"""

import ast
import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

NOTEBOOK = Path(__file__).resolve().parents[1] / "examples" / "gentle_grasp.ipynb"


def run_cell(source: str, names: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Runs a cell like Jupyter: returns the printed text, and the value of a final expression."""
    body = ast.parse(source).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    printed = io.StringIO()
    value = None
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(body, []), "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": printed.getvalue().splitlines(True)})
    if value is not None:
        data: dict[str, Any] = {"text/plain": [repr(value)]}
        if hasattr(value, "_repr_svg_"):
            data["image/svg+xml"] = value._repr_svg_().splitlines(True)
        outputs.append({"data": data, "execution_count": count, "metadata": {}, "output_type": "execute_result"})
    return outputs


def texts(outputs: list[dict[str, Any]]) -> list[list[str]]:
    """Printed and displayed texts, without pictures."""
    return [output.get("text") or output["data"]["text/plain"] for output in outputs]


def test_notebook_outputs_are_current() -> None:
    notebook = json.loads(NOTEBOOK.read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names: dict[str, Any] = {"__name__": "__main__"}
    pictures = 0
    for count, cell in enumerate(cells, 1):
        outputs = run_cell("".join(cell["source"]), names, count)
        pictures += sum("image/svg+xml" in output.get("data", {}) for output in outputs)
        if "ATAS_BLESS" in os.environ:
            cell["outputs"], cell["execution_count"] = outputs, count
        assert texts(cell["outputs"]) == texts(outputs), f"cell {count} is not current; see the head of this test"
        assert len(cell["outputs"]) == len(outputs) and cell["execution_count"] == count
    assert pictures >= 3, "the notebook shows pictures"
    if "ATAS_BLESS" in os.environ:
        NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
