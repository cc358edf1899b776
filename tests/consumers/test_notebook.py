"""docs/quickstart.ipynb runs from end to end, shows pictures of a kitchen, and is kept without outputs."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

from tests.support.program.documents import ROOT, program

pytestmark = pytest.mark.consumers
NOTEBOOK = ROOT / "docs" / "quickstart.ipynb"


def test_it_is_kept_without_outputs() -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) > 6
    assert [cell for cell in cells if cell.outputs or cell.execution_count is not None] == []


def test_it_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in program().items():
        monkeypatch.setenv(name, value)
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(
        notebook, timeout=900, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pictures = [o["data"]["image/png"] for o in outputs if "image/png" in o.get("data", {})]
    assert len(pictures) == 2
    before, after = (np.asarray(Image.open(io.BytesIO(base64.b64decode(p))).convert("RGB"), float) for p in pictures)
    assert 60 < before.mean() < 245
    orange = [int(((p[..., 0] > 170) & (abs(p[..., 1] - 120) < 50) & (p[..., 2] < 90)).sum()) for p in (before, after)]
    assert orange[1] > orange[0] + 100, "the base of the robot is seen"
    assert "'microjoint': 'open'" in str(outputs)
    (scene,) = (tmp_path / "out" / "scenes").glob("*/scene.json")
    assert scene.parent.name == "one_wall_small__coastal__s7"
