"""Each kind of thing that a project may hold works with the installed wheel.

A user begins in an empty folder, writes a project with what the pages of the documents show and rows of their own, and
ends with kitchens and assets that have passed every check. Each test looks for the mark of one kind of thing in them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets.core.numeric import linear_from_srgb, srgb_from_hex
from tests.consumers.own.results import Checked, by_code, certified, only_entry
from tests.support.library.libraries import box_obj
from tests.support.program.documents import saved
from tests.support.program.environments import Environment

pytestmark = pytest.mark.consumers
WHOLE, LIKE = "studio__harbour__s3", "nook__ours"  # kitchens of a plan and a style that state all, that are like others
RUNS = """
name: kitchens
libraries: [out/library]
runs:
  - textures check: {names: [plaster_harbour, paint_ours, stall_waves], out: out/textures}
  - ingest: {sources: [meshes], library: out/library, jobs: 1}
  - objects build: {names: [enamel_mug], count: 1, library: out/objects, jobs: 1}
  - families show: {names: [kettle], preset: [ours], out: out/families}
"""
SCENES = f"  - scenes check: {{scenes: [{WHOLE}, {LIKE}], out: out/scenes, jobs: 2, 3d: false, pictures: false}}\n"
# Rows of the user's own, beside those that the pages show; a style that states all.
ROWS = {
    "styles/harbour.yaml": Path(__file__).with_name("harbour.yaml").read_text(encoding="utf-8"),
    "categories.yaml": "muesli_packet: {parent: packaged_food, longest_m: [0.2, 0.3, 0.36], "
    "mass_kg: [0.25, 0.45, 0.9], shape: [0.64, 0.2, 1], upright: stands, build: filled, "
    "substance: dry_goods, front: face, affords: [graspable]}\n",
    "materials.yaml": 'enamel_ours: {color: "#a34f27", metallic: 0.1, roughness: 0.25, substance: steel}\n',
    "textures/cabinet.yaml": "paint_ours: {kind: painted_front, seed: 7, tile_m: [0.8, 0.8], substance: wood, "
    'params: {color: "#a9c6d8", roughness: 0.4}}\n',
    "habits.yaml": "habits:\n  mugs: {objects: {enamel_mug: 2}}\n",
    "families/kettle.yaml": "presets:\n  ours: {body: enamel_ours}\n",
    "limits.yaml": "hull_count: {value: 31}\nscene_bodies: {value: 399}\n",
    "waivers.yaml": f"- {{code: SCN026, subject: {LIKE}, reason: Our machine is slow.}}\n",
    "plans/nook.yaml": """like: studio
title: Nook
parameters:
  width: [6.2, 6.1, 6.3]
worktop_items:
  kettle: {on: main_drawers, at: 0.2, back: 0.1}
  fruit_bowl: {on: main_drawers_2, at: 0.5}
  jar: {on: main_dishwasher, at: 0.2}
""",
}
# In place of a kettle, a bowl and a jar: a member of the user's own, a family of the user's own, and the user's mesh.
STYLE = """like: harbour
title: Ours
cabinets: {base: {face: paint_ours}}
counter: {face: slabs_stone}
room: {wall: plaster_harbour, floor: stall_waves}
models: {kettle: kettle/ours, fruit_bowl: {preset: tea_tray/oak, width: 0.3}, jar: 'library:%s'}
"""


@dataclass(frozen=True)
class Made:
    """What was made with a project: kitchens by their ids; `mesh`, `object` and `member` are assets."""

    project: Path
    checked: Mapping[str, Checked]

    def fixture(self, name: str) -> Mapping[str, str]:
        (found,) = (one for one in self.checked[LIKE].facts["fixtures"] if one["name"] == name)
        return dict(found)


@pytest.fixture(scope="module")
def project(user: Environment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project that `casa-assets make` has made all of, kitchens last."""
    begin = tmp_path_factory.mktemp("begin")
    user.casa("init", "kitchens", code=0, cwd=begin)
    folder = begin / "kitchens"
    for name, text in (*saved("out/my_kitchens").items(), *ROWS.items()):
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        with path.open("a", encoding="utf-8") as file:
            file.write(text)
    (folder / "casa.yaml").write_text(RUNS, encoding="utf-8")
    (folder / "meshes").mkdir()
    (folder / "meshes" / "muesli_packet.obj").write_text(box_obj((0.19, 0.29, 0.06)), encoding="utf-8")
    _draw(begin / "pictures" / "stone.png")
    options = ("--pack", "slabs", "--surface", "counter", "--tile", "0.6", "0.6", "--licence", "CC0-1.0")
    user.casa("textures", "ingest", begin / "pictures", *options, "--plugins", code=0, cwd=folder)
    user.casa("make", "--plugins", code=0, cwd=folder)
    mesh = only_entry(folder / "out" / "library", "muesli_packet")
    (folder / "styles" / "ours.yaml").write_text(STYLE % mesh.name, encoding="utf-8")
    (folder / "casa.yaml").write_text(RUNS + SCENES, encoding="utf-8")
    user.casa("make", "--plugins", code=0, cwd=folder)
    return folder


@pytest.fixture(scope="module")
def made(project: Path) -> Made:
    found: dict[str, Checked] = {}
    for name in (WHOLE, LIKE):
        folder = project / "out" / "scenes" / name
        facts, report = (json.loads((folder / f"{kind}.json").read_text("utf-8")) for kind in ("scene", "report"))
        found[name] = Checked(report["passed"], facts, by_code(report))
    libraries = {"mesh": "library/muesli_packet", "object": "objects/enamel_mug", "member": "families/kettle"}
    for name, place in libraries.items():
        library, _, category = place.partition("/")
        found[name] = certified(only_entry(project / "out" / library, category))
    return Made(project, found)


def _draw(path: Path) -> None:
    path.parent.mkdir(parents=True)
    y, x = np.meshgrid(*(np.arange(512) / 512 * 2 * np.pi,) * 2, indexing="ij")
    waves = np.sin(9 * x + 2 * np.sin(7 * y)) + np.sin(8 * y + 2 * np.sin(11 * x))
    grain = np.random.default_rng(5).normal(size=(512, 512))
    grey = 150 + 8 * waves + 5 * grain
    Image.fromarray(np.repeat(grey[..., None], 3, axis=2).clip(0, 255).astype(np.uint8)).save(path)


def test_all_has_passed_its_checks_and_rows_of_a_kitchen_that_states_all(made: Made) -> None:
    """A plan, a style, habits."""
    assert {name: one.passed for name, one in made.checked.items()} == dict.fromkeys(made.checked, True)
    assert set(made.checked) == {WHOLE, LIKE, "mesh", "object", "member"}
    facts = made.checked[WHOLE].facts
    assert 5.9 <= facts["parameters"]["width"] <= 6.4
    assert {"sink", "main_range", "main_fridge", "toaster"} <= {f["name"] for f in facts["fixtures"]}
    assert facts["surfaces"]["cabinet"] == "paint_powder_blue"
    presets = {f["role"]: f["preset"] for f in facts["fixtures"]}
    assert (presets["range"], presets["toaster"]) == ("black_steel", "long_navy_brass")
    assert {"enamel_mug", "plate"} <= {thing for space in facts["spawn"] for thing in space["objects"]}


def test_rows_of_a_kitchen_that_is_like_another(made: Made) -> None:
    """A plan and a style that are like others, recipes of textures, a pack of pictures."""
    facts = made.checked[LIKE].facts
    assert facts["parameters"]["width"] == 6.2
    assert {"main_range", "toaster", "jar"} <= {f["name"] for f in facts["fixtures"]}
    assert made.fixture("main_range")["preset"] == "black_steel"
    assert made.fixture("fruit_bowl")["family"] == "tea_tray"
    surfaces = [facts["surfaces"][name] for name in ("wall", "cabinet", "counter")]
    assert surfaces == ["plaster_harbour", "paint_ours", "slabs_stone"]
    (credit,) = facts["textures"]
    assert "CC0-1.0" in json.dumps(credit)


def test_rows_of_assets_limits_and_waivers(made: Made) -> None:
    """A category and a mesh of it in a kitchen, objects, a member of a family and its plain finish."""
    mesh, thing, member = (made.checked[name].facts for name in ("mesh", "object", "member"))
    assert mesh["labels"]["category"] == "muesli_packet"
    jar = made.fixture("jar")
    assert (jar["family"], jar["asset"], jar["category"]) == ("library", mesh["id"], "muesli_packet")
    assert (thing["labels"]["category"], thing["base"]) == ("enamel_mug", "free")
    kettle = made.fixture("kettle")
    assert (kettle["preset"], kettle["asset"]) == ("ours", member["id"])
    colors = {material["id"]: material["base_color"] for material in member["materials"]}
    assert colors["enamel_ours"][:3] == pytest.approx([linear_from_srgb(c) for c in srgb_from_hex("#a34f27")], abs=1e-3)
    assert made.checked["mesh"].results["AST005"]["limit"] == 31
    assert made.checked[LIKE].results["SCN010"]["limit"] == 399
    waived = made.checked[LIKE].results["SCN026"]
    assert (waived["waived"], waived["reason"]) == (True, "Our machine is slow.")
    assert not made.checked[WHOLE].results["SCN026"]["waived"]


def test_what_was_made_and_has_not_changed_is_kept(project: Path, user: Environment) -> None:
    done = user.casa("make", "--plugins", "--json", code=0, cwd=project)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert {row["id"]: row["kept"] for row in rows if row["id"] in (WHOLE, LIKE)} == {WHOLE: True, LIKE: True}


def test_a_word_that_is_wrong_is_told_with_its_line(project: Path, user: Environment) -> None:
    plan = project / "plans" / "studio.yaml"
    text = plan.read_text(encoding="utf-8")
    plan.write_text(text.replace("- dishwasher", "- dishwahser"), encoding="utf-8")
    try:
        done = user.casa("scenes", "new", "studio", "--style", "harbour", "--plugins", code=2, cwd=project)
    finally:
        plan.write_text(text, encoding="utf-8")
    line = text[: text.index("- dishwasher")].count("\n") + 1
    assert re.search(rf"{project}/plans/studio\.yaml:{line}: runs\.main\.base\.3", done.stderr)
