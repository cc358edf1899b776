"""Rows of --json: one form over all verbs, looked at in what each verb really prints of a small input."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from casa_assets.addons.batch import batch_form
from casa_assets.cli.main import app
from casa_assets.cli.verbs.project import write_starter
from casa_assets.ingest.sources import objaverse
from casa_assets.layouts.run import check, sample, scene_folders
from casa_assets.layouts.run.recipe import SceneResult
from casa_assets.library.library import Library
from casa_assets.projects import NO_PROJECT, PLUGINS, VARIABLE, data_root
from casa_assets.show.stills.kitchen import PictureSettings
from tests.architecture.test_commands import SERVERS, VERBS
from tests.support.library.libraries import no_workers
from tests.support.program.plugin_code import PLUGIN

# What a row says at least, by what its verb does.
NAMED = {"id"}
JUDGED = {"id", "verdict"}
MADE = {"id", "verdict", "folder", "mass", "size"}
# robosuite and Objaverse are not here: the rows of the first come from the function that all verbs on kitchens use.
ELSEWHERE = {"scenes robots"}


# A verb with words after it, fields of each row, and whether some thing of it has a mass and a size.
CASES: list[tuple[str, set[str], bool]] = [
    ("ingest {mesh} --library {new}", MADE, True),
    ("library merge {shard} --library {new}", MADE, True),
    ("articulate {mesh} --library {new}", MADE, False),
    *((f"library {way} {{library}} {{new}}", MADE, False) for way in ("push", "pull")),
    ("fetch --lvis Mug --out {new}", MADE, False),
    ("report --library {library}", MADE, False),
    ("library index {library} --out {new}", MADE, False),
    ("find box --library {library}", MADE, True),
    ("preview {asset} --out {new} --width-px 64", MADE, True),
    *((f"export {form} {{library}} --out {{new}}", MADE, True) for form in ("glb", "urdf")),
    ("export robocasa {library} --out {new}", MADE, False),
    *((f"{things} list", NAMED, False) for things in ("families", "objects", "categories", "textures", "scenes")),
    ("families show switch --preset rocker --out {new} --no-check --width-px 64", MADE, True),
    ("families build switch --samples 1 --no-pictures --library {new}", MADE, True),
    ("families catalogue switch apple --no-swatches --no-3d --out {new}", MADE, False),
    ("objects show apple --count 1 --width-px 64 --out {new}", MADE, False),
    ("objects build apple --count 1 --library {new}", MADE, True),
    ("categories show mug", NAMED, False),
    *((f"textures {verb} oak_ebony --width-px 64 --out {{new}}", MADE, False) for verb in ("make", "sheet")),
    ("textures check oak_ebony --out {new}", JUDGED, False),
    ("textures ingest {tiles} --surface wall --tile 1 1 --licence CC0-1.0 --library {new}", MADE, False),
    ("scenes new one_wall_small --style coastal --out {scenes}", MADE, True),
    *((f"scenes {verb} one_wall_small__coastal --out {{scenes}}", MADE, True) for verb in ("build", "check")),
    ("scenes sample 1 --out {scenes}", MADE, True),
    ("scenes states one_wall_small__coastal --count 1 --objects 1 --out {scenes}", MADE, False),
    ("scenes batch one_wall_small__coastal --out {scenes}", MADE, False),
    ("scenes preview one_wall_small__coastal --camera overview --width-px 64 --out {scenes}", MADE, True),
    ("scenes pack one_wall_small__coastal --zip --scenes-folder {scenes} --out {new}.zip", MADE, True),
    ("scenes check-plan {plan}", JUDGED, False),
    ("scenes fit {plan} --width 3.4 --depth 5.2", JUDGED, False),
    ("check {asset}", MADE, True),
    ("doctor", JUDGED, False),
    *((words, NAMED, False) for words in ("checks", "schemas", "schemas behavior")),
    ("init {new}", MADE, False),
    ("export plugin blocks {library} --out {new} --project {project} --plugins", MADE, True),
    ("make --project {project} --dry-run", JUDGED, False),
]


IDS = [" ".join(words.split("{")[0].split("--")[0].split()[:3]) for words, *_ in CASES]


@pytest.fixture
def places(
    boxes: Path, checked_kitchen: tuple[Path, SceneResult], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Path]:
    """Small inputs by the words that stand for them; each may be written to."""
    scenes, library = (tmp_path / "outputs" / name for name in ("scenes", "library"))
    shutil.copytree(checked_kitchen[0], scenes, symlinks=True)
    shutil.copytree(boxes / "library", library)
    tiles = tmp_path / "tiles"
    tiles.mkdir()
    stripes = np.indices((512, 512)).sum(axis=0) % 64 * 2 + 90
    Image.fromarray(np.repeat(stripes.astype(np.uint8)[..., None], 3, axis=2)).save(tiles / "stripes.png")
    asset = next(Library(library).accepted())
    monkeypatch.setenv(VARIABLE, NO_PROJECT)  # a verb that uses a project sets it; it is as it was after the test
    monkeypatch.setenv(PLUGINS, "")
    project = tmp_path / "project"
    write_starter(project)
    (project / "plugins").mkdir()
    (project / "plugins" / "testing.py").write_text(PLUGIN, encoding="utf-8")
    found = {"mesh": boxes / "in" / "milk_carton.obj", "library": library, "scenes": scenes, "asset": asset}
    found |= {"tiles": tiles, "project": project, "plan": data_root() / "plans" / "galley.yaml"}
    return found | {name: tmp_path / name for name in ("new", "shard")}


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch, checked_kitchen: tuple[Path, SceneResult]) -> Iterator[None]:
    """Nothing asks for a network or starts workers, and no kitchen is drawn by chance, merged, or drawn large."""
    smallest = PictureSettings(64, 48, 1)
    monkeypatch.setattr(check, "CHECK_FRAME", smallest)
    monkeypatch.setattr(scene_folders.draw_cameras, "__defaults__", ((), smallest, "start"))
    monkeypatch.setattr(objaverse, "download", lambda uids, lvis, most, out: out.mkdir() or out)
    monkeypatch.setattr(sample, "sample_all", lambda *_, **__: iter([checked_kitchen[1]]))
    monkeypatch.setattr(batch_form, "make_all", lambda *_, **__: iter([checked_kitchen[1]]))
    with no_workers():
        yield


def test_every_verb_is_tried() -> None:
    tried = {verb for words, *_ in CASES for verb in VERBS if f"{words} ".startswith(f"{verb} ")}
    assert tried == VERBS.keys() - SERVERS - ELSEWHERE


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(("line", "has", "measured"), CASES, ids=IDS)
def test_rows_have_one_form(line: str, has: set[str], measured: bool, places: dict[str, Path]) -> None:
    if "{shard}" in line:
        whole = ["--shard", "1/1", "--library", str(places["shard"])]
        assert CliRunner().invoke(app, ["ingest", str(places["mesh"]), *whole]).exit_code in (0, 1, 4)
    words = [word.format(**{k: str(v) for k, v in places.items()}) for word in line.split()]
    run = CliRunner().invoke(app, [*words, "--json"])
    assert run.exit_code in (0, 1, 4), run.output
    assert isinstance(run.exception, SystemExit | None), run.exception
    rows = [json.loads(text) for text in run.stdout.splitlines()]
    assert rows
    for row in rows:
        assert has <= row.keys(), row
        if has == MADE:
            assert row["mass"] is None or row["mass"] > 0.0
            assert row["size"] is None or (len(row["size"]) in (2, 3) and min(row["size"]) > 0.0)
            assert row["folder"] == "" or Path(row["folder"]).is_dir(), row
    if measured:
        assert any(row["mass"] and row["size"] for row in rows), rows
