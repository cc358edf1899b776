"""A folder of pictures becomes a pack, bad ones are named with a reason; in a project it gives finishes to kitchens."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import zlib
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image, PngImagePlugin

import casa_assets as casa
from casa_assets.cli import doctor, options
from casa_assets.errors import CasaError, OutputError, RegistryError, Rejected, UnknownId
from casa_assets.layouts.run import pack as scene_pack
from casa_assets.layouts.run.resolve import draw_surfaces
from casa_assets.layouts.run.sample import draw_recipes
from casa_assets.library.entry_files import file_digests
from casa_assets.model.registry.rows import Surface
from casa_assets.projects import use_project
from casa_assets.textures.check import seam
from casa_assets.textures.finish import normals
from casa_assets.textures.pack_entry import (
    MAX_SIDE_PX,
    REMEDIES,
    MapRole,
    PackPicture,
    PictureDescription,
    PictureRejection,
)
from casa_assets.textures.pack_pictures import decode, decode_map, tile
from casa_assets.textures.run import pictures as pack_files
from casa_assets.textures.run.packs import PackOptions, PackReport, ingest_pack
from casa_assets.textures.run.recipes import find_recipe, finish_of, finishes, finishes_key, origin_of, recipes
from tests.support.library.libraries import ROOT, command
from tests.support.library.pictures import deep_png, encoded, pixels, relief, tiff, tiling, write_pictures
from tests.support.program.projects import Project

pytestmark = [pytest.mark.content("code", "textures", keep=0), pytest.mark.content("code", "textures.run", keep=0)]

FLAGS = PictureDescription(surface=Surface.WALL, tile_m=(1.0, 1.0), licence="CC0-1.0")


def taken(folder: Path, library: Path, flags: PictureDescription = FLAGS) -> PackReport:
    return ingest_pack(folder, PackOptions(library=library, pack="my stones", flags=flags))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "in"
    place.mkdir()
    (place / "Old Brick 01.png").write_bytes(encoded(pixels(1)))
    (place / "ember.jpg").write_bytes(encoded(pixels(2, 640, 560, (120, 60, 50)), "JPEG"))
    return place


def test_good_pictures_become_tiles(folder: Path, tmp_path: Path) -> None:
    report = taken(folder, tmp_path / "lib")
    assert report.changed
    assert report.folder == tmp_path / "lib" / "textures" / "my_stones"
    assert [p.id for p in report.pack.pictures] == ["my_stones_old_brick_01", "my_stones_ember"]
    assert report.pack.refused == ()
    for picture in report.pack.pictures:
        assert picture.repaired
        assert picture.seam_before > 1.5 > picture.seam_after
        assert picture.derived == ("normal", "roughness")
        assert (picture.licence, picture.prompt, picture.generator) == ("CC0-1.0", "unknown", "unknown")
        base = np.asarray(Image.open(report.folder / picture.files[0]), dtype=np.float32) / 255
        assert base.shape == (picture.height_px, picture.width_px, 3)
        assert seam(base).worst == pytest.approx(picture.seam_after, abs=0.02)
    ember = report.pack.pictures[1]  # what is cut off is cut off its metres too
    assert ember.tile_m == pytest.approx((ember.width_px / 640, ember.height_px / 560), abs=1e-3)
    assert 0.55 < ember.tile_m[0] <= 1.0
    names = sorted(p.name for p in report.folder.iterdir())
    assert names == sorted([*(f for p in report.pack.pictures for f in p.files), "pack.json", "sheet.png"])


def test_again_is_the_same_bytes_nothing_is_written_and_a_run_goes_on_where_it_was_cut_off(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = taken(folder, tmp_path / "first")
    inode = first.folder.stat().st_ino
    again = taken(folder, tmp_path / "first")
    assert not again.changed
    assert again.pack == first.pack
    assert first.folder.stat().st_ino == inode
    assert list((tmp_path / "first" / ".casa" / "staging").iterdir()) == []
    calls: list[int] = []

    @wraps(tile)  # what is kept has a key of the code of `tile`, whichever function counts its calls
    def counted(image: npt.NDArray[np.float32], size_px: int, given: dict[str, npt.NDArray[np.float32]]) -> object:
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return tile(image, size_px, given)

    monkeypatch.setattr("casa_assets.textures.run.packs.tile", counted)
    with pytest.raises(KeyboardInterrupt):
        taken(folder, tmp_path / "lib")
    assert not (tmp_path / "lib" / "textures").exists()
    resumed = taken(folder, tmp_path / "lib")
    assert len(calls) == 3  # one before the cut, one cut off, one after: the first was kept
    assert file_digests(resumed.folder) == file_digests(first.folder)


# A picture of 60000 x 60000 pixels in a few bytes, which is refused by its header.
BOMB = bytearray(encoded(pixels()))
BOMB[16:24] = (60000).to_bytes(4, "big") * 2
BOMB[29:33] = zlib.crc32(bytes(BOMB[12:29])).to_bytes(4, "big")
# Files by the names of why they are refused.
BAD = {
    "not_a_picture.png": b"GIF89a not a picture at all",
    "broken.png": encoded(pixels())[:4000],
    "too_large.png": encoded(np.zeros((1, 9000, 3), np.uint8)),
    "too_large.bomb.png": bytes(BOMB),
    "too_small.png": encoded(pixels(1, 511, 600)),
    "too_long.png": encoded(pixels(1, 1100, 540)),
    "transparent.png": encoded(np.dstack([pixels(), np.full((520, 520), 128, np.uint8)])),
    "blank.png": encoded(np.full((520, 520, 3), 7, np.uint8)),
}


def test_bad_pictures_and_links_are_left_out_with_their_reasons(folder: Path, tmp_path: Path) -> None:
    for name, data in BAD.items():
        (folder / name).write_bytes(data)
    (tmp_path / "secret.png").write_bytes(encoded(pixels(5)))
    (folder / "unreadable.png").symlink_to(tmp_path / "secret.png")
    (folder / "unreadable.dead.png").symlink_to(tmp_path / "nowhere.png")
    pack = taken(folder, tmp_path / "lib").pack
    wanted = {row.source: PictureRejection[row.source.split(".")[0].upper()] for row in pack.refused}
    assert wanted.keys() == {*BAD, "unreadable.png", "unreadable.dead.png"}
    assert all((row.code, row.fix) == (wanted[row.source].value, REMEDIES[wanted[row.source]]) for row in pack.refused)
    assert len(pack.pictures) == 2


def test_duplicates_are_named(folder: Path, tmp_path: Path) -> None:
    (folder / "zz_copy.png").write_bytes((folder / "Old Brick 01.png").read_bytes())
    (folder / "other.jpg").write_bytes(encoded(pixels(1), "JPEG"))  # the same picture, other bytes
    pack = taken(folder, tmp_path / "lib").pack
    assert [(r.source, r.code) for r in pack.refused] == [("zz_copy.png", PictureRejection.DUPLICATE.value)]
    assert "Old Brick 01.png" in pack.refused[0].message
    assert [(a.first, a.second) for a in pack.alike] == [("my_stones_old_brick_01", "my_stones_other")]
    assert pack.alike[0].distance < 0.3


def test_the_manifest_is_kept_also_one_of_json_and_a_prompt_inside_a_file(folder: Path, tmp_path: Path) -> None:
    (folder / "pack.yaml").write_text(
        "defaults: {surface: floor, tile_m: [2, 2], licence: CC-BY-4.0, generator: painter 3}\n"
        "pictures:\n"
        "  ember.jpg: {name: Glowing Ember, surface: counter, tile_m: [0.5, 0.5], prompt: embers, author: A. Maker}\n"
        "  lost.png: {licence: CC0-1.0}\n"
    )
    (folder / "readme.md").write_text("hello")
    pack = taken(folder, tmp_path / "lib", PictureDescription()).pack
    brick, ember = pack.pictures
    assert (brick.surface, brick.licence) == (Surface.FLOOR, "CC-BY-4.0")
    assert (brick.generator, brick.prompt) == ("painter 3", "unknown")
    assert (ember.id, ember.surface) == ("my_stones_glowing_ember", Surface.COUNTER)
    assert (ember.prompt, ember.author) == ("embers", "A. Maker")
    assert [(r.source, r.code) for r in pack.refused] == [("lost.png", PictureRejection.MISSING.value)]
    assert pack.ignored == ("readme.md",)
    (folder / "pack.yaml").unlink()
    (folder / "pack.json").write_text(json.dumps({"pack": "from json", "pictures": {"grey.png": {"author": "me"}}}))
    notes = PngImagePlugin.PngInfo()
    notes.add_text("parameters", "grey stone,  seamless")
    Image.fromarray(pixels(9, color=(110, 115, 120))).save(folder / "grey.png", pnginfo=notes)
    pack = ingest_pack(folder, PackOptions(library=tmp_path / "lib", flags=FLAGS)).pack
    grey = next(p for p in pack.pictures if p.source == "grey.png")
    assert (pack.id, grey.prompt, grey.author) == ("from_json", "grey stone, seamless", "me")


def test_what_nobody_says_is_asked_for_and_flags_stand_between_rows_and_defaults(folder: Path, tmp_path: Path) -> None:
    refused = taken(folder, tmp_path / "lib", PictureDescription(tile_m=(1.0, 1.0))).pack.refused
    assert {r.code for r in refused} == {PictureRejection.NOT_DESCRIBED.value}
    assert refused[0].message == "nobody says its surface, licence"
    assert "--licence" in refused[0].fix
    (folder / "pack.yaml").write_text("defaults: {surface: floor, licence: A}\npictures: {ember.jpg: {licence: B}}\n")
    pack = taken(folder, tmp_path / "lib", PictureDescription(licence="C", tile_m=(1.0, 1.0))).pack
    assert [(p.licence, p.surface) for p in pack.pictures] == [("C", Surface.FLOOR), ("B", Surface.FLOOR)]


def test_a_wrong_row_costs_its_picture_and_a_wrong_manifest_is_said_with_its_line(folder: Path, tmp_path: Path) -> None:
    for row in ("{tile_m: [0, 1]}", "{surfaces: wall}", "{substance: unobtainium}", "7"):
        (folder / "pack.yaml").write_text(f"pictures:\n  ember.jpg: {row}\n")
        pack = taken(folder, tmp_path / "lib").pack
        assert [(r.source, r.code) for r in pack.refused] == [("ember.jpg", PictureRejection.BAD_ROW.value)]
        assert [p.source for p in pack.pictures] == ["Old Brick 01.png"]
    for text in ("[1, 2]", "colour: red", "defaults: {surface: roof}", "pictures: [a]", "a: [", "3"):
        (folder / "pack.yaml").write_text(f"# pack\n{text}\n")
        with pytest.raises(RegistryError, match=r"pack.yaml:[1-3]"):
            taken(folder, tmp_path / "lib")


def test_a_folder_that_is_not_there_a_file_and_an_empty_folder(tmp_path: Path) -> None:
    with pytest.raises(CasaError, match="no such folder"):
        taken(tmp_path / "nothing", tmp_path / "lib")
    (tmp_path / "a.zip").write_bytes(b"PK")
    with pytest.raises(CasaError, match="is no folder; unpack it first"):
        taken(tmp_path / "a.zip", tmp_path / "lib")
    (tmp_path / "in").mkdir()
    pack = taken(tmp_path / "in", tmp_path / "lib").pack
    assert (pack.pictures, pack.refused) == ((), ())


def test_other_channels_are_converted() -> None:
    deep_grey = Image.fromarray(pixels()[..., 0].astype(np.uint16) * 257)
    for mode in ["L", "CMYK", "P", "RGBA", "I;16"]:
        out = io.BytesIO()
        image = deep_grey if mode == "I;16" else Image.fromarray(pixels()).convert(mode)
        image.save(out, "JPEG" if mode == "CMYK" else "PNG")
        seen = decode(out.getvalue())
        assert seen.pixels.shape == (520, 520, 3)
        expected = (pixels()[..., 0] if mode == "I;16" else pixels()).mean() / 255
        assert float(seen.pixels.mean()) == pytest.approx(expected, abs=0.04)
        assert seen.notes


RAMP = np.tile(np.linspace(0.0, 1.0, 600, dtype=np.float32), (540, 1))
BYTE, WORD = 0.5 / 255, 1.0 / 65535


def deep(image: npt.NDArray[np.floating], depth: int = 16) -> npt.NDArray[np.uint16]:
    return np.asarray(np.round(image * (2**depth - 1)), dtype=np.uint16)


def three(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.dstack([image] * 3)


# Files of the ramp, and by how much what is read of them may be off.
READ: list[tuple[bytes, float]] = [
    (encoded(np.round(three(RAMP) * 255).astype(np.uint8), "TIFF"), 2 * BYTE),
    (tiff(deep(RAMP)), WORD),
    (tiff(three(deep(RAMP))), 2 * BYTE),
    (tiff(RAMP), 1e-6),
    (deep_png(deep(RAMP)), WORD),
    (deep_png(three(deep(RAMP))), 2 * BYTE),
]
REFUSED: list[tuple[npt.NDArray[Any], dict[str, int], str]] = [
    (three(RAMP), {}, "PCK002: is a TIFF file of a kind that is not read"),
    (deep(RAMP).astype(np.uint32), {}, "PCK002: .* not of 8 or 16 bits"),
    ((RAMP * 1000 - 500).astype(np.int16), {}, "PCK002: .* not of 8 or 16 bits"),
    (np.where(RAMP > 0, np.inf, np.nan).astype(np.float32), {}, "PCK003: holds values that are no numbers"),
    (deep(RAMP), {"width": MAX_SIDE_PX * 8, "height": 16}, "PCK004: has tiles of over 81"),
]


def test_numbers_of_a_map_are_those_of_its_file_and_what_cannot_be_read_is_told_before_it_is_unpacked() -> None:
    for data, error in READ:
        found = decode_map(data, MapRole.ROUGHNESS)
        assert found.shape == (*RAMP.shape, 3)
        assert np.abs(found - RAMP[..., None]).max() <= error
    for image, tiles, message in REFUSED:
        with pytest.raises(Rejected, match=message):
            decode_map(tiff(image, **tiles), MapRole.HEIGHT)


def test_any_cut_of_a_file_is_refused_and_raises_nothing_else() -> None:
    kinds = [encoded(pixels(), kind) for kind in ("PNG", "JPEG", "WEBP")]
    for whole in (tiff(deep(RAMP)), deep_png(deep(RAMP)), *kinds):
        for share in (0.0, 0.0001, 0.001, 0.01, 0.3, 0.7):
            with pytest.raises(Rejected, match="PCK00"):
                decode(whole[: int(len(whole) * share)])
    assert [decode(whole).pixels.shape for whole in kinds] == [(520, 520, 3)] * 3


NORMALS = normals(relief() * 0.004, (1.0, 1.0))
GREY, DARK = (encoded(np.full((512, 512), level, np.uint8)) for level in (128, 76))
MAPS = {"height__png": GREY, "normal__png": encoded(NORMALS), "roughness__png": DARK}


def material(folder: Path, **maps: bytes) -> Path:
    """A folder with a colour and maps of one material (`normal__tif` -> bytes)."""
    folder.mkdir(parents=True)
    for name, data in {"color__png": encoded(tiling(2)), **maps}.items():
        (folder / f"Bricks_{name.replace('__', '.')}").write_bytes(data)
    return folder


def plane(picture: PackPicture, library: Path, number: int) -> npt.NDArray[np.floating]:
    with Image.open(library / "textures" / "my_stones" / picture.files[number]) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255


def test_maps_of_other_formats_are_used_as_if_they_were_png(tmp_path: Path) -> None:
    """Roughness as a PNG of 16 bits, metalness as a TIFF of 16, heights as a TIFF of floats."""
    one = np.ones((512, 512), np.float32)
    source = material(
        tmp_path / "in",
        normal__png=encoded(NORMALS),
        roughness__png=deep_png(deep(one * 0.3)),
        metalness__tif=tiff(deep(one)),
        height__tiff=tiff(relief() * 0.01),
    )
    pack = taken(source, tmp_path / "lib").pack
    (picture,) = pack.pictures
    assert (pack.refused, picture.derived, picture.notes, picture.faults) == ((), (), (), ())
    endings = {"height": "tiff", "metalness": "tif", "normal": "png", "roughness": "png"}
    assert picture.given == {role: f"Bricks_{role}.{ending}" for role, ending in endings.items()}
    gloss = plane(picture, tmp_path / "lib", 2)
    assert gloss[..., 1:].mean(axis=(0, 1)) == pytest.approx([0.3, 1.0], abs=0.01)


def test_a_material_with_its_maps(tmp_path: Path) -> None:
    pack = taken(material(tmp_path / "in", **MAPS), tmp_path / "lib").pack
    (picture,) = pack.pictures
    assert (picture.id, picture.source) == ("my_stones_bricks", "Bricks_color.png")
    assert picture.given == {role: f"Bricks_{role}.png" for role in ("height", "normal", "roughness")}
    assert (pack.refused, picture.derived, picture.repaired, picture.faults) == ((), (), False, ())
    rough = plane(picture, tmp_path / "lib", 2)
    assert rough[..., 1] == pytest.approx(np.full(rough.shape[:2], 0.3), abs=0.01)
    assert rough[..., 2].max() == 0
    shown = plane(picture, tmp_path / "lib", 1) * 2 - 1
    mean = (NORMALS.astype(np.float64) / 127.5 - 1).reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
    assert np.abs(shown - mean).mean() < 0.03
    assert np.corrcoef(shown[..., 1].ravel(), mean[..., 1].ravel())[0, 1] > 0.99


def test_maps_that_do_not_fit_are_left_out_with_a_note_and_maps_without_a_colour_are_refused(tmp_path: Path) -> None:
    unfit = {"roughness__png": encoded(pixels(1, 1024, 600)), "metalness__png": b"no picture"}
    source = material(tmp_path / "in", **MAPS | unfit)
    (picture,) = taken(source, tmp_path / "lib").pack.pictures
    assert sorted(picture.given) == ["height", "normal"]
    notes = [note.partition(" was")[0] for note in picture.notes]
    assert notes == ["its map of the metalness", "its map of the roughness"]
    (source / "Bricks_color.png").unlink()
    pack = taken(source, tmp_path / "lib").pack
    assert ([row.code for row in pack.refused], pack.pictures) == ([PictureRejection.NO_COLOR.value], ())


def test_maps_are_cut_with_the_colour(tmp_path: Path) -> None:
    image = pixels(1, 640, 640)
    folder = material(tmp_path / "in", color__png=encoded(image), roughness__png=encoded(image[..., 0]))
    (picture,) = taken(folder, tmp_path / "lib").pack.pictures
    assert picture.repaired
    base, rough = plane(picture, tmp_path / "lib", 0), plane(picture, tmp_path / "lib", 2)
    height, width = (n - n % 2 for n in base.shape[:2])
    small = base[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
    assert np.corrcoef(small[..., 0].ravel(), rough[..., 1].ravel())[0, 1] > 0.8


def test_a_large_photograph_is_made_smaller(tmp_path: Path) -> None:
    """Noise packs badly: the files of a picture of 1024 px would be larger than a check allows."""
    noisy = np.clip(np.random.default_rng(3).normal(128, 40, (1024, 1024, 3)), 0, 255).astype(np.uint8)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "noise.png").write_bytes(encoded(noisy))
    (picture,) = taken(tmp_path / "in", tmp_path / "lib").pack.pictures
    assert picture.width_px < 1000
    place = tmp_path / "lib" / "textures" / "my_stones"
    assert sum((place / name).stat().st_size for name in picture.files) < 2_500_000
    assert "was scaled down to" in " ".join(picture.notes)


# In a project --------------------------------------------------------------------------------------------------------

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
