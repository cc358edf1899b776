"""Each kind of row that a project lays over the package's works with the installed wheel, by command.

Here are the kinds that decide what one asset is; those of kitchens are in test_projects.py. A kind is a row of KINDS:
files of the project, the thing that is made with them, and the mark that they leave on it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

import casa_assets
from casa_assets.projects import data_root
from tests.consumers.own.results import Checked, certified, only_entry
from tests.support.library.libraries import BOXES, box_obj, write_files
from tests.support.program.environments import Environment

pytestmark = pytest.mark.consumers
MESH = "cereal_beside_banana"  # by the words of the package a thing that is called so is a banana
RUNS = f"""name: rows
runs:
  - objects build: {{names: [mug], count: 1, library: out/mug, jobs: 1}}
  - families show: {{names: [base_cabinet], preset: [ours], out: out/base_cabinet}}
  - families show: {{names: [kettle], preset: [jug_steel], out: out/kettle}}
  - ingest: {{sources: [meshes/{MESH}.obj], library: out/mesh, jobs: 1}}
"""
CATEGORIES = {"mug": "mug", "base_cabinet": "base_cabinet", "kettle": "kettle", "mesh": "cereal"}
SKIN = """skin_ours: {kind: skin, seed: 330, tile_m: [0.28, 0.22], substance: ceramic,
  params: {colors: ["#efeee8", "#a34f27"], at: [0, 1], mottle: 0.04, relief_mm: 0.0, roughness: 0.2}}
"""


@dataclass(frozen=True)
class Kind:
    """A kind of row. files: of the project. thing: what is made with them. leaves_mark: whether that shows."""

    files: Mapping[str, str]
    thing: str
    leaves_mark: Callable[[Checked], bool]


def _materials(asset: Checked) -> set[str]:
    return {material["id"] for material in asset.facts["materials"]}


KINDS = {
    "skins": Kind(
        {"skins/ours.yaml": SKIN, "objects/tableware.yaml": "mug: {sample: {skin: skin_ours}}\n"},
        "mug",
        lambda mug: "skin_ours" in _materials(mug),
    ),
    "looks": Kind(
        {
            "looks.yaml": "ours: {front: slab, handle: knob, face: paint_forest, metal: bronze_ours}\n",
            "families/base_cabinet.yaml": "presets:\n  ours: {look: ours}\n",
        },
        "base_cabinet",
        lambda cabinet: "paint_forest" in _materials(cabinet),
    ),
    "substances": Kind(
        {
            "substances.yaml": "tin_bronze: {density: 8100, static_friction: 0.5, dynamic_friction: 0.4, metallic: 1, "
            "roughness: 0.3}\n",
            "materials.yaml": 'bronze_ours: {color: "#7a5a3a", metallic: 1, roughness: 0.4, substance: tin_bronze}\n',
        },
        "base_cabinet",
        lambda cabinet: {s["id"]: s["density"] for s in cabinet.facts["substances"]}.get("tin_bronze") == 8100,
    ),
    "densities": Kind(
        {"densities.yaml": "kettle_base: {kg_m3: 1500}\n"},
        "kettle",
        lambda kettle: (
            sum(link["inertial"]["mass"] for link in kettle.facts["links"])
            > casa_assets.build("kettle", "jug_steel").mass + 0.05
        ),
    ),
    "words": Kind(
        {"words.yaml": 'separators: [with, without, w, for, from, in, "on", by, near, under, beside]\n'},
        "mesh",
        lambda mesh: mesh.facts["labels"]["category"] == "cereal",
    ),
}


@pytest.fixture(scope="module")
def project(user: Environment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rows")
    files = {name: text for kind in KINDS.values() for name, text in kind.files.items()}
    mesh = box_obj(BOXES["cereal_box"])
    return write_files(folder, {**files, "casa.yaml": RUNS, f"meshes/{MESH}.obj": mesh})


@pytest.fixture(scope="module")
def made(project: Path, user: Environment) -> Mapping[str, Checked]:
    user.casa("make", code=0, cwd=project)
    return {name: certified(only_entry(project / "out" / name, "*")) for name in CATEGORIES}


def test_all_has_passed_its_checks_and_each_kind_of_row_leaves_its_mark(made: Mapping[str, Checked]) -> None:
    assert {name: one.passed for name, one in made.items()} == dict.fromkeys(CATEGORIES, True)
    assert {name: one.facts["labels"]["category"] for name, one in made.items()} == CATEGORIES
    assert [name for name, kind in KINDS.items() if not kind.leaves_mark(made[kind.thing])] == []


def test_a_contract_asks_for_more(user: Environment, tmp_path: Path) -> None:
    """A runtime of the user's own wants a region of clocks that ours do not have: a check tells."""
    rows = {"casa.yaml": "name: rows\n", "contracts/clock.yaml": "regions: [main, dial_front]\n"}
    words = ("families", "show", "wall_clock", "--preset", "square", "--out", "out")
    done = user.casa(*words, code=1, cwd=write_files(tmp_path, rows))
    assert "CON004" in done.stdout + done.stderr
    assert "dial_front" in done.stdout + done.stderr


def test_a_robot(user: Environment, tmp_path: Path) -> None:
    """The file of a project's robot is read, and what it names is looked for; robosuite's own files are not here."""
    text = (data_root() / "robots" / "PandaOmron.yaml").read_text(encoding="utf-8")
    ours = text.replace("bases/omron_mobile_base.xml", "bases/ours.xml")
    write_files(tmp_path, {"casa.yaml": "name: rows\n", "robots/Ours.yaml": ours})
    words = ("scenes", "robots", "one_wall_small__coastal", "--models", ".", "--robot")
    done = user.casa(*words, "Ours", code=2, cwd=tmp_path)
    assert "bases/ours.xml: robot Ours needs this file" in done.stderr
    assert "did you mean Ours" in user.casa(*words, "Our", cwd=tmp_path).stderr
    write_files(tmp_path, {"robots/Ours.yaml": text.replace("drives: true", "drives: north")})
    assert "robots/Ours.yaml:" in user.casa(*words, "Ours", cwd=tmp_path).stderr
