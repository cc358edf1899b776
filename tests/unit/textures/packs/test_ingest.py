"""A folder of pictures becomes a pack: good ones tile, bad ones are named with a reason, and nothing is lost."""

from __future__ import annotations

import io
import json
import zlib
from functools import wraps
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image, PngImagePlugin

from casa_assets.errors import CasaError, RegistryError
from casa_assets.library.library import file_digests
from casa_assets.model.registry.rows import Surface
from casa_assets.textures.check import seam
from casa_assets.textures.pack_entry import REMEDIES, PictureDescription, PictureRejection
from casa_assets.textures.pack_pictures import GivenMaps, decode, tile
from casa_assets.textures.run.packs import PackOptions, PackReport, ingest_pack
from tests.support.library.pictures import encoded, pixels

pytestmark = [
    pytest.mark.content("code", "textures", keep=0),
    pytest.mark.content("code", "textures.run", keep=0),
]

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


def test_again_is_the_same_bytes_and_nothing_is_written(folder: Path, tmp_path: Path) -> None:
    first = taken(folder, tmp_path / "lib")
    before = file_digests(first.folder)
    inode = first.folder.stat().st_ino
    again = taken(folder, tmp_path / "lib")
    assert not again.changed
    assert again.pack == first.pack
    assert first.folder.stat().st_ino == inode
    assert file_digests(taken(folder, tmp_path / "other").folder) == before
    assert list((tmp_path / "lib" / ".casa" / "staging").iterdir()) == []


def test_a_run_goes_on_where_it_was_cut_off(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = taken(folder, tmp_path / "whole")
    calls: list[int] = []

    @wraps(tile)  # what is kept has a key of the code of `tile`, whichever function counts its calls
    def counted(image: npt.NDArray[np.float32], size_px: int, given: GivenMaps) -> object:
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
    assert file_digests(resumed.folder) == file_digests(whole.folder)


def bomb() -> bytes:
    """A picture of 60000 x 60000 pixels in a few bytes, which is refused by its header."""
    data = bytearray(encoded(pixels()))
    data[16:24] = (60000).to_bytes(4, "big") * 2
    data[29:33] = zlib.crc32(bytes(data[12:29])).to_bytes(4, "big")
    return bytes(data)


BAD = {
    "not_a_picture.png": (PictureRejection.NOT_A_PICTURE, b"GIF89a not a picture at all"),
    "broken.png": (PictureRejection.BROKEN, encoded(pixels())[:4000]),
    "too_large.png": (PictureRejection.TOO_LARGE, encoded(np.zeros((1, 9000, 3), np.uint8))),
    "bomb.png": (PictureRejection.TOO_LARGE, bomb()),
    "too_small.png": (PictureRejection.TOO_SMALL, encoded(pixels(1, 511, 600))),
    "too_long.png": (PictureRejection.TOO_LONG, encoded(pixels(1, 1100, 540))),
    "transparent.png": (
        PictureRejection.TRANSPARENT,
        encoded(np.dstack([pixels(), np.full((520, 520), 128, np.uint8)])),
    ),
    "blank.png": (PictureRejection.BLANK, encoded(np.full((520, 520, 3), 7, np.uint8))),
}


def test_bad_pictures_and_links_are_left_out_with_their_reasons(folder: Path, tmp_path: Path) -> None:
    wanted = {"dead.png": PictureRejection.UNREADABLE, "link.png": PictureRejection.UNREADABLE}
    for name, (fault, data) in BAD.items():
        (folder / name).write_bytes(data)
        wanted[name] = fault
    (tmp_path / "secret.png").write_bytes(encoded(pixels(5)))
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    (folder / "dead.png").symlink_to(tmp_path / "nowhere.png")
    report = taken(folder, tmp_path / "lib")
    assert {r.source: r.code for r in report.pack.refused} == {name: fault.value for name, fault in wanted.items()}
    assert all(row.fix == REMEDIES[wanted[row.source]] for row in report.pack.refused)
    assert len(report.pack.pictures) == 2


def test_duplicates_are_named(folder: Path, tmp_path: Path) -> None:
    (folder / "zz_copy.png").write_bytes((folder / "Old Brick 01.png").read_bytes())
    (folder / "other.jpg").write_bytes(encoded(pixels(1), "JPEG"))  # the same picture, other bytes
    pack = taken(folder, tmp_path / "lib").pack
    assert [(r.source, r.code) for r in pack.refused] == [("zz_copy.png", PictureRejection.DUPLICATE.value)]
    assert "Old Brick 01.png" in pack.refused[0].message
    assert [(a.first, a.second) for a in pack.alike] == [("my_stones_old_brick_01", "my_stones_other")]
    assert pack.alike[0].distance < 0.3


def test_the_manifest_is_kept(folder: Path, tmp_path: Path) -> None:
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


def test_flags_stand_between_rows_and_defaults(folder: Path, tmp_path: Path) -> None:
    (folder / "pack.yaml").write_text("defaults: {surface: floor, licence: A}\npictures: {ember.jpg: {licence: B}}\n")
    flags = PictureDescription(licence="C", tile_m=(1.0, 1.0))
    pack = taken(folder, tmp_path / "lib", flags).pack
    assert [(p.licence, p.surface) for p in pack.pictures] == [("C", Surface.FLOOR), ("B", Surface.FLOOR)]


def test_what_nobody_says_is_asked_for(folder: Path, tmp_path: Path) -> None:
    refused = taken(folder, tmp_path / "lib", PictureDescription(tile_m=(1.0, 1.0))).pack.refused
    assert {r.code for r in refused} == {PictureRejection.NOT_DESCRIBED.value}
    assert refused[0].message == "nobody says its surface, licence"
    assert "--licence" in refused[0].fix


@pytest.mark.parametrize("row", ["{tile_m: [0, 1]}", "{surfaces: wall}", "{substance: unobtainium}", "7"])
def test_a_wrong_row_costs_its_picture_and_no_other(row: str, folder: Path, tmp_path: Path) -> None:
    (folder / "pack.yaml").write_text(f"pictures:\n  ember.jpg: {row}\n")
    pack = taken(folder, tmp_path / "lib").pack
    assert [(r.source, r.code) for r in pack.refused] == [("ember.jpg", PictureRejection.BAD_ROW.value)]
    assert [p.source for p in pack.pictures] == ["Old Brick 01.png"]


@pytest.mark.parametrize("text", ["[1, 2]", "colour: red", "defaults: {surface: roof}", "pictures: [a]", "a: [", "3"])
def test_a_wrong_manifest_is_said_with_its_line(text: str, folder: Path, tmp_path: Path) -> None:
    (folder / "pack.yaml").write_text(f"# pack\n{text}\n")
    with pytest.raises(RegistryError, match=r"pack.yaml:[1-3]"):
        taken(folder, tmp_path / "lib")


def test_json_manifest_and_prompt_inside_the_file(folder: Path, tmp_path: Path) -> None:
    said = PngImagePlugin.PngInfo()
    said.add_text("parameters", "grey stone,  seamless")
    Image.fromarray(pixels(9, color=(110, 115, 120))).save(folder / "grey.png", pnginfo=said)
    (folder / "pack.json").write_text(json.dumps({"pack": "from json", "pictures": {"grey.png": {"author": "me"}}}))
    report = ingest_pack(folder, PackOptions(library=tmp_path / "lib", flags=FLAGS))
    assert report.pack.id == "from_json"
    grey = next(p for p in report.pack.pictures if p.source == "grey.png")
    assert (grey.prompt, grey.author) == ("grey stone, seamless", "me")


def test_a_folder_that_is_not_there_a_file_and_an_empty_folder(tmp_path: Path) -> None:
    with pytest.raises(CasaError, match="no such folder"):
        taken(tmp_path / "nothing", tmp_path / "lib")
    (tmp_path / "a.zip").write_bytes(b"PK")
    with pytest.raises(CasaError, match="is no folder; unpack it first"):
        taken(tmp_path / "a.zip", tmp_path / "lib")
    (tmp_path / "in").mkdir()
    report = taken(tmp_path / "in", tmp_path / "lib")
    assert (report.pack.pictures, report.pack.refused) == ((), ())


def test_other_channels_are_converted(subtests: pytest.Subtests) -> None:
    for mode in ["L", "CMYK", "P", "RGBA", "I;16"]:
        with subtests.test(mode=mode):
            source = Image.fromarray(pixels())
            out = io.BytesIO()
            if mode == "I;16":
                Image.fromarray(pixels()[..., 0].astype(np.uint16) * 257).save(out, "PNG")
            else:
                source.convert(mode).save(out, "JPEG" if mode == "CMYK" else "PNG")
            seen = decode(out.getvalue())
            assert seen.pixels.shape == (520, 520, 3)
            expected = pixels().mean() / 255 if mode != "I;16" else pixels()[..., 0].mean() / 255
            assert float(seen.pixels.mean()) == pytest.approx(expected, abs=0.04)
            assert seen.notes
