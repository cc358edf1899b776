"""Content that is unchanged is left to `./dev certify`: a change of one family makes its rows run, and no others."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from tests import content_keys
from tests.support.program.projects import Project

FILE = "tests/unit/families/test_fixtures.py"
MICROWAVE = "casa_assets.kitchenware.fixtures.microwave"
FAMILIES = ("hob", "hood", "microwave", "range", "toaster_oven", "wall_oven")


class Row:
    """A row of a test of families, as pytest hands it to a hook."""

    def __init__(self, family: str, preset: int, **keep: int) -> None:
        self.nodeid = f"{FILE}::test_preset[{family}-{preset}]"
        self.callspec = SimpleNamespace(params={"family": family})
        self.mark = getattr(pytest.mark, content_keys.MARK)("family", "{family}", **keep).mark

    def get_closest_marker(self, name: str) -> Any:
        return self.mark if name == "content" else None

    def iter_markers(self, name: str) -> list[Any]:
        return [self.mark] if name == "content" else []


def rows(**keep: int) -> list[Any]:
    """Four presets of each family."""
    return [Row(family, preset, **keep) for family in FAMILIES for preset in range(4)]


def ids(found: list[Any]) -> list[str]:
    return [row.nodeid.partition("[")[2].rstrip("]") for row in found]


@pytest.fixture
def forgotten() -> Iterator[None]:
    """Keys are found anew in the test and after it."""
    _forget()
    yield
    _forget()


def _forget() -> None:
    for kept in (content_keys.subject_key, content_keys._code, content_keys.file_key):
        kept.cache_clear()


def keys() -> dict[str, str]:
    """Keys of some subjects of each kind, and of a file of tests."""
    names = [f"family/{name}" for name in FAMILIES]
    names += ["object/apple", "texture/oak_ebony", "plan/galley", "style/coastal"]
    return {name: content_keys.subject_key(name) for name in names} | {FILE: content_keys.file_key(FILE)}


def test_recorded_content_is_left_out_but_for_representatives() -> None:
    left = ids(content_keys.unchanged(rows(), keys()))
    kept = [name for name in ids(rows()) if name not in left]
    assert kept == ["hob-0", "microwave-0", "toaster_oven-0"]
    assert len(content_keys.unchanged(rows(keep=0), keys())) == len(rows())
    assert ids(content_keys.unchanged(rows(keep=1), keys())) == ids(rows())[1:]


def test_content_that_is_not_recorded_runs() -> None:
    assert content_keys.unchanged(rows(), {}) == []
    assert content_keys.unchanged(rows(), {**keys(), FILE: "another"}) == []
    assert content_keys.unchanged(rows(), {}, most=21) == []
    assert len(content_keys.unchanged(rows(), {}, most=20)) == len(rows()) - 3, "the representatives alone"


@pytest.mark.usefixtures("forgotten")
def test_a_change_of_one_family_or_of_what_several_reach_makes_their_rows_run(monkeypatch: pytest.MonkeyPatch) -> None:
    before, real = keys(), content_keys.module_digest
    _forget()
    monkeypatch.setattr(content_keys, "module_digest", lambda name: "new" if name == MICROWAVE else real(name))
    assert {name for name, key in keys().items() if key != before[name]} == {"family/microwave"}
    left = ids(content_keys.unchanged(rows(keep=0), before))
    assert left == [name for name in ids(rows()) if not name.startswith("microwave")]
    _forget()
    all_reach = "casa_assets.asset.assemble"
    monkeypatch.setattr(content_keys, "module_digest", lambda name: "new" if name == all_reach else real(name))
    found = {name for name, key in keys().items() if key != before[name]}
    assert found == {*(f"family/{name}" for name in FAMILIES), "object/apple"}


@pytest.mark.usefixtures("forgotten")
def test_the_key_of_a_package_is_that_of_its_code_and_of_what_it_imports(monkeypatch: pytest.MonkeyPatch) -> None:
    before, real = content_keys.subject_key("code/ingest.collision"), content_keys.module_digest
    own, imported, other = "ingest.collision.plane_splits", "mesh.surface", "show.reports.kitchens"
    for changed, differs in ((own, True), (imported, True), (other, False)):
        _forget()
        module = f"casa_assets.{changed}"
        monkeypatch.setattr(content_keys, "module_digest", lambda name, at=module: "new" if name == at else real(name))
        assert (content_keys.subject_key("code/ingest.collision") != before) == differs, changed


def test_a_row_of_the_registry_changes_its_subject_alone(project: Project) -> None:
    before = keys()
    project({"families/hob.yaml": "presets:\n  tiny: {}\n", "plans/galley.yaml": _other_plan()})
    changed = {name for name, key in keys().items() if key != before[name]}
    # A style may choose any preset of the families that it names.
    assert changed == {"family/hob", "plan/galley", "style/coastal"}


def _other_plan() -> str:
    text = (content_keys.ROOT / "registry/plans/galley.yaml").read_text(encoding="utf-8")
    return text.replace("title: ", "title: Other ", 1)


def test_every_recorded_name_is_one_of_content() -> None:
    assert set(content_keys.read_recorded()) <= set(content_keys.present_keys())
