"""Planted faults and how a run of them ends; a walk through code; the picture of imports; drawings with labels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.articulate.draw import KINDS, draw
from benchmarks.articulate.labelled import fused
from benchmarks.imports import PAGE, arrows, box_of, embedded, imported, picture
from benchmarks.planted.faults import Fault, mistakes, read_faults
from benchmarks.planted.trial import Bench, Failure, Results, Verdict, summary
from benchmarks.walk import ROOT, sentence, walked
from casa_assets import errors, projects
from tests.selection import Imports, Reaching, reaching
from tests.support.library.libraries import write_files

# A made-up checkout: two modules, one of which loads another by its name, and tests that reach them in many ways.
FILES = {
    "casa_assets/__init__.py": "",
    "casa_assets/deep.py": "def area(side: float) -> float:\n    return side * side\n",
    "casa_assets/near.py": 'WORK = "casa_assets.deep:area"\n',
    "casa_assets/typed.py": "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n    import casa_assets.deep\n",
    "casa_assets/cli/__init__.py": "",
    "casa_assets/cli/main.py": "",
    "registry/limits.yaml": "",
    "tests/__init__.py": "",
    "tests/shapes.py": "from casa_assets.deep import area\n\nSQUARE = area(3.0)\n",
    "tests/start.py": 'PROGRAM = ["-m", "casa_assets.cli.main"]\n',
    "tests/conftest.py": (
        "import pytest\n\nfrom casa_assets.near import WORK\n\n\n@pytest.fixture\ndef work():\n    return WORK\n"
    ),
    "tests/unit/test_deep.py": "def test_area():\n    from casa_assets.deep import area\n\n    assert area(3) == 9\n",
    "tests/unit/test_helper.py": "from tests.shapes import SQUARE\n\n\ndef test_square():\n    assert SQUARE == 9.0\n",
    "tests/unit/test_fixture.py": "def test_work(work):\n    assert work\n",
    "tests/unit/test_typed.py": "import casa_assets.typed\n\n\ndef test_typed():\n    assert casa_assets.typed\n",
    "tests/unit/test_program.py": "from tests.start import PROGRAM\n\n\ndef test_program():\n    assert PROGRAM\n",
    "tests/unit/test_limits.py": 'def test_limits():\n    assert "limits"\n',
    "tests/consumers/test_other.py": "import casa_assets.deep\n",
}
FAULT = Fault("wrong", "casa_assets/deep.py", "side * side", "side + side", "formula", "areas are no areas")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    return write_files(tmp_path / "checkout", FILES)


def test_every_fault_applies_once_and_compiles_and_one_that_does_not_is_told(checkout: Path) -> None:
    faults = read_faults()
    assert len(faults) == 120
    assert mistakes(faults, ROOT, importing=False) == []
    twice = Fault("twice", FAULT.file, "side", "edge", "formula", "")
    broken = Fault("broken", FAULT.file, "return side", "return (side", "formula", "")
    found = mistakes([FAULT, twice, broken], checkout, importing=False)
    assert [line.split(":")[0] for line in found] == ["twice", "broken"]


def test_tests_are_ordered_by_steps_and_those_of_the_program_are_last(checkout: Path) -> None:
    imports = Imports(checkout)
    assert reaching(imports, ["tests/unit/test_deep.py"]) == [Reaching("tests/unit/test_deep.py", 0)]
    assert reaching(imports, ["registry/limits.yaml"]) == [Reaching("tests/unit/test_limits.py", 0)]
    assert {test.path for test in reaching(imports, ["tests/conftest.py"])} == set(imports.tests)
    assert reaching(imports, [FAULT.file]) == [
        Reaching("tests/unit/test_deep.py", 1),
        Reaching("tests/unit/test_fixture.py", 2),
        Reaching("tests/unit/test_helper.py", 2),
        Reaching("tests/unit/test_program.py", None),
    ]


def test_run_names_the_test_that_fails_due_to_the_fault(checkout: Path, tmp_path: Path) -> None:
    (checkout / "pyproject.toml").write_text(
        '[tool.pytest.ini_options]\npythonpath = ["."]\naddopts = "--import-mode=importlib"\n'
        'markers = ["consumers", "certify"]\n'
    )
    # A test that fails without any fault as well, and a file that cannot be read.
    (checkout / "tests/unit/test_deep.py").write_text("import casa_assets.deep\n\n\ndef test_never():\n    assert 0\n")
    (checkout / "tests/unit/test_lost.py").write_text("import casa_assets.deep\nimport not_there\n")
    tests = reaching(Imports(checkout), [FAULT.file])
    bench = Bench(checkout, tmp_path / "work", jobs=1, budget_s=120.0)
    verdict = bench.try_fault(FAULT, tests)
    assert verdict.failure is not None
    assert verdict.failure.test == "tests/unit/test_helper.py::test_square"
    assert (verdict.outcome, verdict.steps) == ("others", 2)
    lost, never = "tests/unit/test_lost.py", "tests/unit/test_deep.py::test_never"
    assert bench.clean_fails == {lost: True, never: True, verdict.failure.test: False}
    harmless = Fault("harmless", FAULT.file, "side * side", "side**2", "formula", "")
    assert bench.try_fault(harmless, tests).outcome == "not caught"


def test_results_are_kept_by_checkout_and_text_of_the_fault(tmp_path: Path) -> None:
    results = Results(tmp_path / "results.jsonl", "a")
    caught = Verdict("nearest", 1.0, 8, Failure("tests/unit/test_deep.py::test_area", "assert 6 == 9"), 1)
    late = Fault("late", FAULT.file, "side", "edge", "formula", "edges")
    results.add(FAULT, caught, 60.0)
    results.add(late, Verdict("not caught within the budget", 60.0, 8), 60.0)
    with results.path.open("a") as file:
        file.write('{"checkout": "a", "fault"')  # it was stopped while it wrote
    assert results.verdicts([FAULT], 60.0) == {"wrong": caught}
    assert set(results.verdicts([FAULT, late], 60.0)) == {"wrong", "late"}
    assert set(results.verdicts([FAULT, late], 120.0)) == {"wrong"}
    assert Results(results.path, "b").verdicts([FAULT], 60.0) == {}
    changed = Fault(FAULT.id, FAULT.file, FAULT.old, "side", FAULT.kind, FAULT.what)
    assert results.verdicts([changed], 60.0) == {}
    told = summary([FAULT, late], results.verdicts([FAULT, late], 60.0))
    assert "late (casa_assets/deep.py): edges [not caught within the budget, 8 files]" in told


def test_files_are_listed_in_the_order_in_which_they_are_entered() -> None:
    def walk(_: Path) -> None:
        errors.UnknownId("plan", "l_smal", ["l_small"])
        projects.data_root()

    found = {Path(path).name: count for path, count in walked(walk).items()}
    assert list(found) == ["errors.py", "projects.py"]
    assert min(found.values()) >= 1
    assert sentence(ROOT / "benchmarks" / "walk.py").endswith("in their order.")


def test_the_page_shows_what_the_script_prints_and_arrows_lead_down() -> None:
    assert embedded(PAGE.read_text(encoding="utf-8")) == picture(), "python -m benchmarks.imports --write"
    found = arrows()
    assert found
    assert all(start < end for start, end in found)


def test_every_form_of_import_is_read() -> None:
    text = (
        "import numpy, casa_assets.core.numeric\n"
        "from casa_assets import model, registry\n"
        "def f():\n    from casa_assets.model.asset import Asset\n"
    )
    assert [sorted(names) for names in imported(text) if names] == [
        ["core.numeric"],
        ["model", "registry"],
        ["model.asset.Asset"],
    ]
    assert box_of("ingest.run.inputs") != box_of("ingest.clean") == box_of("articulate.infer")
    assert box_of("errors") is None


def test_drawn_fronts_open_outward(subtests: pytest.Subtests) -> None:
    for kind in list(KINDS):
        with subtests.test(kind=kind):
            for index in range(6):
                mesh = draw(kind, 5, index)
                assert mesh.truth["parts"]
                for row in mesh.truth["parts"]:
                    joint = row["joint"]
                    cloud = mesh.points[mesh.faces[mesh.part == row["id"]]].reshape(-1, 3)
                    assert len(cloud), row["name"]
                    assert np.linalg.norm(joint["axis"]) == pytest.approx(1.0)
                    is_front = row["type"] in ("door", "drawer", "lid")
                    if is_front and joint["range"][0] == 0.0 and joint["type"] == "revolute":
                        arm = cloud.mean(axis=0) - np.array(joint["origin"])
                        way = np.cross(joint["axis"], arm)
                        middle = (mesh.points.min(axis=0) + mesh.points.max(axis=0)) / 2
                        assert way @ (cloud.mean(axis=0) - middle) > 0 or kind == "laptop"
                    if row["type"] == "drawer":
                        np.testing.assert_allclose(joint["axis"], [0, -1, 0], atol=1e-9)


def test_fused_shell_shows_every_front() -> None:
    mesh, shell = fused(draw("cabinet", 2, 13))
    parts = mesh.truth["parts"]
    assert {row["type"] for row in parts} == {"door", "drawer"}
    assert all(row["visible"] > 0.1 for row in parts)
    assert {row["id"] for row in parts} <= set(shell.part.tolist())
