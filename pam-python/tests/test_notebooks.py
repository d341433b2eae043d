"""The notebooks run, and what comes out is what is stored: the same words, numbers within 5 %."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nbclient")
for package in ("ipykernel", "jax", "optax", "matplotlib", "pandas"):
    pytest.importorskip(package)

FOLDER = Path(__file__).parents[2] / "notebooks" / "python"
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def runner() -> Any:
    spec = importlib.util.spec_from_file_location("run_notebooks", FOLDER / "run.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def texts(notebook: Any) -> list[tuple[int, str]]:
    """What the cells print and show as text; figures by their kind alone."""
    found = []
    for k, cell in enumerate(notebook.cells):
        for output in cell.get("outputs", []):
            if output.output_type == "stream":
                found.append((k, output.text))
            elif "image/png" in output.get("data", {}):
                found.append((k, "figure"))
            else:
                found.append((k, output.get("data", {}).get("text/plain", "")))
    return found


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda p: p.stem)
def test_the_notebook_gives_what_is_stored(path: Path) -> None:
    module = runner()
    stored = texts(module.nbformat.read(path, as_version=4))
    found = texts(module.executed(path))
    assert stored, "the notebook has no outputs: run notebooks/python/run.py"
    assert [k for k, _ in found] == [k for k, _ in stored]
    for (cell, new), (_, old) in zip(found, stored):
        assert NUMBER.sub("0", new) == NUMBER.sub("0", old), f"cell {cell}"
        for a, b in zip(NUMBER.findall(new), NUMBER.findall(old)):
            assert float(a) == pytest.approx(float(b), rel=0.05, abs=0.02), f"cell {cell}"
