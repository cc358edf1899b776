"""The pictures of a pack in a project are finishes of kitchens beside ours: by name, in styles, drawn at random."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from PIL import Image

import casa_assets as casa
from casa_assets.cli import doctor, options
from casa_assets.errors import CasaError, OutputError, RegistryError, UnknownId
from casa_assets.layouts.run import pack as scene_pack
from casa_assets.layouts.run.resolve import draw_surfaces
from casa_assets.layouts.run.sample import draw_recipes
from casa_assets.model.registry.rows import Surface
from casa_assets.projects import use_project
from casa_assets.textures.pack_entry import PictureDescription
from casa_assets.textures.run import pictures as pack_files
from casa_assets.textures.run.packs import PackOptions, PackReport, ingest_pack
from casa_assets.textures.run.recipes import find_recipe, finish_of, finishes, finishes_key, origin_of, recipes
from tests.support.library.libraries import ROOT, command
from tests.support.library.pictures import encoded, pixels, tiling, write_pictures
from tests.support.program.projects import Project

pytestmark = [pytest.mark.content("code", "textures", keep=0), pytest.mark.content("code", "textures.run", keep=0)]

FLOOR = PictureDescription(surface=Surface.FLOOR, tile_m=(1.0, 1.0), licence="CC0-1.0", substance="stone")
Ingested = Callable[..., PackReport]


@pytest.fixture
def ingested(project: Project, tmp_path: Path) -> Ingested:
    """Take pictures into the project in use: `count` of them, or those in a folder."""
    ours = project({})

    def take(count: int = 2, pack: str = "slates", flags: PictureDescription = FLOOR) -> PackReport:
        folder = write_pictures(tmp_path / f"in_{pack}", count)
        return ingest_pack(folder, PackOptions(library=ours, pack=pack, flags=flags))

    return take


def test_pictures_stand_beside_recipes(ingested: Ingested, tmp_path: Path) -> None:
    report = ingested()
    assert report.folder == tmp_path / "textures" / "slates"
    assert len(recipes()[Surface.FLOOR]) == 102
    recipe = recipes()[Surface.FLOOR]["slates_stone_01"]
    assert (recipe.kind, recipe.substance, recipe.tile_m) == ("picture", "stone", report.pack.pictures[1].tile_m)
    assert origin_of(recipe) == "ours/slates"
    assert "slates_stone_01" in casa.surfaces()["floor"]
    assert "slates_stone_01" not in casa.surfaces()["wall"]
    assert options.complete_textures("slates_") == ["slates_stone_00", "slates_stone_01"]
    assert "texture packs: textures/slates" in next(doctor._project()).message
    use_project(None)
    assert "slates_stone_01" not in casa.surfaces()["floor"]
    with pytest.raises(UnknownId):
        find_recipe("slates_stone_01")


def test_the_finish_is_what_stands_in_the_files(ingested: Ingested, tmp_path: Path) -> None:
    report = ingested()
    picture = report.pack.pictures[0]
    made = finishes([picture.id], tmp_path / "cache")[picture.id]
    texture, normal = made.material.base_color_texture, made.material.normal_texture
    assert texture is not None
    assert normal is not None
    vectors = np.asarray(Image.open(io.BytesIO(normal.png)), dtype=np.float64) / 127.5 - 1
    assert np.linalg.norm(vectors, axis=2) == pytest.approx(np.ones(vectors.shape[:2]), abs=0.02)
    assert vectors[..., 2].min() > 0
    assert texture.png == (report.folder / picture.files[0]).read_bytes()
    assert (made.tile_m, made.substance.id) == (picture.tile_m, "stone")
    small = finish_of(find_recipe(picture.id), tmp_path / "cache", 64).material.base_color_texture
    assert small is not None
    assert (small.width_px, small.height_px) == (64, 64)
    assert not (tmp_path / "cache").exists(), "the files of a pack are not kept a second time"


def test_a_file_that_was_changed_is_an_error_and_a_new_pack_is_another_key(ingested: Ingested, tmp_path: Path) -> None:
    report = ingested(1)
    (picture,) = report.pack.pictures
    name, base = picture.id, report.folder / picture.files[0]
    key, whole = finishes_key([name]), base.read_bytes()
    base.write_bytes(encoded(pixels(8)))
    use_project(tmp_path)
    for reads in (lambda: finishes_key([name]), lambda: finish_of(find_recipe(name), tmp_path / "cache")):
        with pytest.raises(OutputError, match="is not the file that was written; ingest the pack again"):
            reads()
    base.write_bytes(whole)
    use_project(tmp_path)
    assert finishes_key([name]) == key
    (tmp_path / "in_slates" / "stone 00.png").write_bytes(encoded(tiling(9, color=(90, 100, 110))))
    ingest_pack(tmp_path / "in_slates", PackOptions(library=tmp_path, pack="slates", flags=FLOOR))
    assert finishes_key([name]) != key


def test_names_that_are_taken(ingested: Ingested, tmp_path: Path) -> None:
    write_pictures(tmp_path / "clash", 1, "natural plank")
    (tmp_path / "clash" / "natural plank 00.png").rename(tmp_path / "clash" / "natural plank.png")
    with pytest.raises(CasaError, match=r"oak_natural_plank: is the id of a texture of casa-assets; .* --pack"):
        ingest_pack(tmp_path / "clash", PackOptions(library=tmp_path, pack="oak", flags=FLOOR))
    assert not (tmp_path / "textures" / "oak").exists()
    ingested()
    assert not ingested().changed, "the pictures of the pack itself are not in its way"
    shutil.copytree(tmp_path / "textures" / "slates", tmp_path / "textures" / "moved")
    use_project(tmp_path)
    with pytest.raises(RegistryError, match=r"slates/pack\.json:1: pictures\.0\.id: expected an id that nothing else"):
        recipes()


def test_a_pack_does_not_take_the_place_of_pictures(ingested: Ingested, tmp_path: Path) -> None:
    folder = write_pictures(tmp_path / "textures" / "raw", 1)
    for source in (folder, tmp_path / "textures"):
        with pytest.raises(OutputError, match="among the pictures that it is made of"):
            ingest_pack(source, PackOptions(library=tmp_path, pack="raw", flags=FLOOR))
    with pytest.raises(OutputError, match="is no pack; choose another name"):
        ingest_pack(write_pictures(tmp_path / "other", 1), PackOptions(library=tmp_path, pack="raw", flags=FLOOR))
    assert (folder / "stone 00.png").is_file()


def test_from_python(project: Project, tmp_path: Path) -> None:
    """What the command line does: into the project in use, by ids that kitchens take at once; or into a folder."""
    pictures = write_pictures(tmp_path / "slates", 2)
    (pictures / "broken.png").write_bytes(b"no picture")
    stated: dict[str, Any] = {"tile_m": (1.0, 1.0), "licence": "CC0-1.0", "substance": "stone"}
    with pytest.raises(CasaError, match=r"casa\.Project\(folder\)\.ingest_textures\(\.\.\.\), or library=folder"):
        casa.ingest_textures(pictures, surface="floor", **stated)
    ours = project({})
    done = casa.ingest_textures(pictures, surface="floor", **stated)
    assert (done.folder, done.changed) == (ours / "textures" / "slates", True)
    assert [picture.id for picture in done.pack.pictures] == ["slates_stone_00", "slates_stone_01"]
    assert [(row.source, row.code) for row in done.pack.refused] == [("broken.png", "PCK002")]
    assert set(casa.surfaces()["floor"]) >= {"slates_stone_00", "slates_stone_01"}
    assert not casa.ingest_textures(pictures, surface="floor", **stated).changed
    elsewhere = casa.ingest_textures(pictures, "other", surface="wall", library=tmp_path / "lib", **stated)
    assert elsewhere.folder == tmp_path / "lib" / "textures" / "other"
    with pytest.raises(UnknownId, match="did you mean floor"):
        casa.ingest_textures(pictures, surface="flor", **stated)
    with pytest.raises(CasaError, match=r"tile_m\.1: .*greater than 0, got -1"):
        casa.ingest_textures(pictures, surface="floor", tile_m=(1.0, -1.0))


def test_a_damaged_pack_is_an_error_with_its_file(ingested: Ingested, tmp_path: Path) -> None:
    path = ingested().folder / "pack.json"
    for text in ("{}", "[", '{"id": "slates", "version": 3, "pictures": [{"files": ["../a.png"]}]}'):
        path.write_text(text, encoding="utf-8")
        use_project(tmp_path)
        with pytest.raises(OutputError, match=r"textures/slates/pack\.json: cannot be read"):
            recipes()


def test_a_hundred_pictures_are_read_once_and_drawn(
    ingested: Ingested, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = ingested(1)
    path = report.folder / "pack.json"
    pack = json.loads(path.read_text(encoding="utf-8"))
    pack["pictures"] = [{**pack["pictures"][0], "id": f"slates_no_{n}"} for n in range(100)]
    path.write_text(json.dumps(pack), encoding="utf-8")
    use_project(tmp_path)
    counted = Mock(wraps=pack_files.load_pack)
    monkeypatch.setattr(pack_files, "load_pack", counted)
    drawn = [dict(draw_surfaces(seed))[Surface.FLOOR] for seed in range(60)]
    assert 15 < sum(name.startswith("slates_no_") for name in drawn) < 45
    sampled = [dict(recipe.surfaces)[Surface.FLOOR] for recipe in draw_recipes(30, 7)]
    assert any(name.startswith("slates_no_") for name in sampled)
    counted.assert_called_once_with(report.folder)


def run(*words: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the program in a folder."""
    environment = {**os.environ, "COLUMNS": "200", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command(*words), cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done


def test_from_an_empty_folder_to_a_checked_kitchen(tmp_path: Path) -> None:
    """By the command line: a project, a pack, a style that uses it, and the other pack by name; then from Python."""
    run("init", "ours", folder=tmp_path)
    ours = tmp_path / "ours"
    write_pictures(tmp_path / "slates", 2)
    stated = ("--tile", "1", "1", "--licence", "CC0-1.0")
    done = run("textures", "ingest", "../slates", "--surface", "floor", *stated, folder=ours)
    assert "2 pictures taken" in done.stdout
    run("textures", "ingest", "../slates", "--pack", "plaster", "--surface", "wall", *stated, folder=ours)
    rows = [json.loads(line) for line in run("textures", "list", "--json", folder=ours).stdout.splitlines()]
    found = {row["id"]: row["from"] for row in rows if row["kind"] == "picture"}
    assert found == {f"{pack}_stone_0{n}": f"ours/{pack}" for pack in ("slates", "plaster") for n in (0, 1)}
    style = "like: coastal\ntitle: Slated\nroom: {floor: slates_stone_01}\n"
    (ours / "styles" / "slated.yaml").write_text(style, encoding="utf-8")
    words = ("scenes", "new", "one_wall_small", "--style", "slated", "--textures", "wall=plaster_stone_00", "--json")
    row = json.loads(run(*words, folder=ours).stdout.splitlines()[-1])
    checked = run("scenes", "check", row["id"], "--jobs", "1", "--no-pictures", "--json", folder=ours)
    assert json.loads(checked.stdout.splitlines()[-1])["verdict"] == "passed"
    place = ours / "out" / "scenes" / row["id"]
    credit = {"licence": "CC0-1.0", "author": "unknown", "generator": "unknown"}
    listed = json.loads((place / "scene.json").read_text(encoding="utf-8"))["textures"]
    assert listed == [{"id": "plaster_stone_00", **credit}, {"id": "slates_stone_01", **credit}]
    assert "slates_stone_01" in scene_pack.members_of(place)["ATTRIBUTION.md"].decode()
    kitchen = casa.Project(ours).kitchen("one_wall_small", "slated", surfaces={"wall": "plaster_stone_00"})
    model = kitchen.to_mjmodel()
    shown = {model.material(i).name.partition("__")[2] for i in range(model.nmat)}
    assert {"slates_stone_01", "plaster_stone_00"} <= shown
    before = model.tex_data.copy()
    with casa.Project(ours):
        kitchen.textures_of(model).show({"wall": "plaster_stone_01"})
    assert (model.tex_data != before).any()
