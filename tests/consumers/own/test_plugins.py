"""Each kind of thing that a plug-in may add works with the installed wheel, by command and from Python.

The plug-ins are those that docs/howto/extend.md shows: once in the `plugins/` of a project, once as a package
that is built and installed as the page says. Rows of a project say what is made with them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.consumers.own.results import TELLING, Checked, certified, only_entry, told_by
from tests.support.library.libraries import write_files
from tests.support.program.documents import saved
from tests.support.program.environments import Environment, build_wheel, install

pytestmark = pytest.mark.consumers
ROWS = {"casa.yaml": "name: ours\n", "families/tea_tray.yaml": "presets:\n  waved: {face: stall_waves}\n"}
SCRIPT = f"""{TELLING}
with casa.Project(".", plugins=PLUGINS):
    for preset in ("oak", "waved"):
        tell_asset(preset, casa.build("tea_tray", preset))
    tell_asset("object", casa.build("coaster"))
    library = casa.Library("out/fetched")
    (done,) = library.ingest("stall:biscuits", jobs=1)
    certificate = json.loads((done.folder / "asset.json").read_text())["certificate"]
    tell_asset("mesh", library.get(done.asset_id))
    told["mesh"]["versions"] = certificate["versions"]
    told["mesh"]["results"] = certificate["report"]["results"]
    files = casa.plugins()["tea"].exporters[0].write(library.get(done.asset_id))
    tell("exported", casa.build("tea_tray", "oak").check(), json.loads(files["mass.json"]))
end()
"""


@dataclass(frozen=True)
class Made:
    """What was made with plug-ins: `oak`, `waved`, `object` and `mesh` are assets, `exported` what was written."""

    checked: Mapping[str, Checked]
    exported: Mapping[str, object]
    by_command: bool


class Place(NamedTuple):
    """An environment, a project in a folder outside the checkout, and the options that let its plug-ins run."""

    environment: Environment
    folder: Path
    options: list[str]


@pytest.fixture(scope="module")
def in_project(user: Environment, tmp_path_factory: pytest.TempPathFactory) -> Place:
    folder = tmp_path_factory.mktemp("project") / "ours"
    return Place(user, write_files(folder, _rows() | _code()), ["--plugins"])


@pytest.fixture(scope="module")
def in_package(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Place:
    folder = tmp_path_factory.mktemp("package") / "ours"
    package = folder.parent / "tea_things"
    modules = {f"tea_things/{Path(name).name}": text for name, text in _code().items()}
    write_files(package, {**saved("out/tea_things"), "tea_things/__init__.py": "", **modules})
    built = build_wheel(package, folder.parent / "dist")
    write_files(folder, _rows())
    return Place(install(folder.parent / "environment", wheel, built), folder, [])


def _rows() -> dict[str, str]:
    shown = saved("out/my_kitchens")
    return {name: shown[name] for name in ("fixtures.yaml", "objects/coasters.yaml", "textures/floor.yaml")} | ROWS


def _code() -> dict[str, str]:
    return {name: text for name, text in saved("out/my_kitchens").items() if name.startswith("plugins/")}


# CI tries each place and each way once, a release all pairs.
PAIRS = (
    ("in_project", "command"),
    ("in_package", "python"),
    pytest.param(("in_project", "python"), marks=pytest.mark.certify),
    pytest.param(("in_package", "command"), marks=pytest.mark.certify),
)


@pytest.fixture(scope="module", params=PAIRS, ids="-".join)
def made(request: pytest.FixtureRequest) -> Made:
    place, way = request.param
    environment, folder, options = request.getfixturevalue(place)
    if way == "command":
        return _made_by_command(environment, folder, options)
    told = told_by(environment, folder, SCRIPT.replace("PLUGINS", repr(bool(options))))
    return Made(told, told["exported"].facts, by_command=False)


def _made_by_command(environment: Environment, folder: Path, options: list[str]) -> Made:
    lines = (
        "families build tea_tray --library out/trays --no-pictures --jobs 1",
        "objects build coaster --count 1 --library out/objects --jobs 1",
        "textures check stall_waves --out out/textures --jobs 1",
        "ingest stall:biscuits --library out/library --jobs 1",
        "export plugin masses out/library --out out/masses",
    )
    for line in lines:
        environment.casa(*line.split(), *options, code=0, cwd=folder)
    out = folder / "out"
    trays = [certified(path.parent) for path in out.glob("trays/tea_tray/*/asset.json")]
    plain, waved = sorted(trays, key=lambda one: "stall_waves" in _finishes(one))
    checked = {
        "oak": plain,
        "waved": waved,
        "object": certified(only_entry(out / "objects", "coaster")),
        "mesh": certified(only_entry(out / "library", "cereal")),
    }
    (exported,) = out.glob("masses/assets/*/mass.json")
    return Made(checked, json.loads(exported.read_text(encoding="utf-8")), by_command=True)


def _finishes(asset: Checked) -> set[str]:
    return {material["id"] for material in asset.facts["materials"]}


def test_all_has_passed_its_checks_and_each_kind_of_thing_leaves_its_mark(made: Made) -> None:
    """A family, a form of objects, a source, a kind of texture, a check, an exporter; certificates state versions."""
    assert {name: one.passed for name, one in made.checked.items()} == dict.fromkeys(made.checked, True)
    oak, waved, thing, mesh = (made.checked[name] for name in ("oak", "waved", "object", "mesh"))
    assert [one.facts["labels"]["category"] for one in (oak, thing, mesh)] == ["tea_tray", "coaster", "cereal"]
    assert "oak_natural" in _finishes(oak)
    assert _finishes(waved) == {"stall_waves"}
    for one in (oak, waved, thing, mesh):
        result = one.results["TEA001"]
        assert (result["status"], result["limit"]) == ("passed", 40.0)
    assert made.exported["id"] == mesh.facts["id"]
    assert isinstance(made.exported["mass"], float)
    for name in ("oak", "waved", "object", "mesh") if made.by_command else ("mesh",):
        assert made.checked[name].versions["plugin:tea"].startswith("1.0 "), name
    if made.by_command:
        assert made.checked["object"].versions["plugin:stall"].startswith("1.0 ")
