"""What is read of EXR, TIFF and PNG of 16 bits: the numbers that were written, within bounds that the header tells."""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.core.color import linear_from_srgb_array
from casa_assets.errors import CasaError, Rejected
from casa_assets.model.registry.finish import Surface
from casa_assets.pipeline.textures.packs.ingest import PackOptions, ingest_pack
from casa_assets.textures.finish import normals
from casa_assets.textures.packs import exr as exr_files
from casa_assets.textures.packs.decode import decode, decode_map
from casa_assets.textures.packs.derive import GivenMaps, finish_of_tile, pixels_of, png, tile
from casa_assets.textures.packs.entry import Pack, PackPicture, PictureDescription
from casa_assets.textures.packs.limits import MAX_SIDE_PX
from casa_assets.textures.packs.maps import MapRole
from tests.pictures import deep_png, encoded, exr, relief, tiff, tiling

pytestmark = [
    pytest.mark.content("code", "textures.packs", keep=0),
    pytest.mark.content("code", "pipeline.textures", keep=0),
]

SIZED = PictureDescription(surface=Surface.WALL, licence="CC0-1.0", tile_m=(1.0, 1.0))
RAMP = np.tile(np.linspace(0.0, 1.0, 600, dtype=np.float32), (540, 1))
HALF_ULP, BYTE, WORD = 0.0005, 0.5 / 255, 1.0 / 65535


def deep(image: npt.NDArray[np.floating], depth: int = 16) -> npt.NDArray[np.uint16]:
    return np.round(image * (2**depth - 1)).astype(np.uint16)


def three(image: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    return np.dstack([image] * 3)


def colours(
    image: npt.NDArray[np.floating], kind: type[np.floating] = np.float16
) -> dict[str, npt.NDArray[np.generic]]:
    return {name: image[..., at].astype(kind) for at, name in enumerate("RGB")}


READ = {
    "exr half": (lambda: exr({"Y": RAMP.astype(np.float16)}, "NO"), HALF_ULP),
    "exr float": (lambda: exr(colours(three(RAMP), np.float32), "ZIPS"), 1e-6),
    "exr of piz": (lambda: exr(colours(three(RAMP)), "PIZ"), HALF_ULP),
    "exr of dwaa": (lambda: exr(colours(three(RAMP)), "DWAA"), 0.02),
    "exr of any name": (lambda: exr({"V": RAMP}), 1e-6),
    "exr that is opaque": (lambda: exr({**colours(three(RAMP)), "A": np.ones_like(RAMP, np.float16)}), HALF_ULP),
    "tiff 8": (lambda: encoded(np.round(three(RAMP) * 255).astype(np.uint8), "TIFF"), 2 * BYTE),
    "tiff 16": (lambda: tiff(deep(RAMP)), WORD),
    "tiff 16 colours": (lambda: tiff(three(deep(RAMP))), 2 * BYTE),
    "tiff float": (lambda: tiff(RAMP), 1e-6),
    "png 16": (lambda: deep_png(deep(RAMP)), WORD),
    "png 16 colours": (lambda: deep_png(three(deep(RAMP))), 2 * BYTE),
}


def test_numbers_of_a_map_are_those_of_its_file(subtests: pytest.Subtests) -> None:
    for name in sorted(READ):
        with subtests.test(name=name):
            write, error = READ[name]
            found = decode_map(write(), MapRole.ROUGHNESS)
            assert found.shape == (*RAMP.shape, 3)
            assert np.abs(found - RAMP[..., None]).max() <= error


def test_a_map_of_16_bits_that_is_nearly_black_stays_so() -> None:
    """Its largest number is one that 8 bits could hold as well."""
    found = decode_map(deep_png(deep(RAMP * 0.003)), MapRole.METALNESS)
    assert found.max() == pytest.approx(0.003, abs=1e-4)


def test_colours_of_an_exr_are_linear_light() -> None:
    shown = tiling().astype(np.float32) / 255
    bright = linear_from_srgb_array(shown)
    bright[:8] = 7.5  # brighter than white
    found = decode(exr(colours(bright))).pixels
    assert np.abs(found[8:] - shown[8:]).max() < 0.002
    assert found[:8].min() == pytest.approx(1.0)


def test_floats_are_brought_into_their_range(subtests: pytest.Subtests) -> None:
    for role, stated, expected in [
        (MapRole.NORMAL_GL, RAMP * 2 - 1, RAMP),
        (MapRole.NORMAL_GL, RAMP, RAMP),
        (MapRole.HEIGHT, RAMP * 0.02, RAMP),  # metres
        (MapRole.HEIGHT, RAMP * 3 - 1, RAMP),
        (MapRole.HEIGHT, 0.3 + RAMP * 0.4, 0.3 + RAMP * 0.4),
        (MapRole.HEIGHT, RAMP * 0, RAMP * 0),
        (MapRole.ROUGHNESS, RAMP * 2 - 0.5, np.clip(RAMP * 2 - 0.5, 0, 1)),
    ]:
        with subtests.test(role=role, stated=stated, expected=expected):
            for data in (exr({"Y": stated.astype(np.float32)}), tiff(stated.astype(np.float32))):
                assert np.abs(decode_map(data, role)[..., 0] - expected).max() < 1e-5


def _with_size(width: int, height: int) -> bytes:
    """An EXR whose header claims another size than it has."""
    data = exr({"Y": RAMP})
    at = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    return data[:at] + struct.pack("<4i", 0, 0, width - 1, height - 1) + data[at + 16 :]


REFUSED: dict[str, tuple[Callable[[], bytes], str]] = {
    "exr too large": (lambda: _with_size(60000, 60000), "PCK004: 60000 x 60000 pixels, over 8192"),
    "exr of no size": (lambda: _with_size(0, -5), "PCK005"),
    "exr that lies": (lambda: _with_size(8000, 8000), "PCK003: cannot be decoded: OpenEXR"),
    "exr too small": (lambda: exr({"Y": RAMP[:100]}), "PCK005"),
    "exr to see through": (lambda: exr({"Y": RAMP, "A": RAMP}), "PCK007"),
    "exr with a number that is none": (lambda: exr({"Y": RAMP / RAMP}), "PCK003: holds values that are no numbers"),
    "exr of other channels": (lambda: exr({"X": RAMP, "Z": RAMP}), "PCK002: .* with the channels X, Z; R, G and B"),
    "exr of integers": (lambda: exr({"Y": deep(RAMP).astype(np.uint32)}), "PCK002: .* channel Y holds no half or"),
    "exr of parts": (lambda: b"v/1\x01" + struct.pack("<I", 2 | 0x1000) + b"\0", "PCK002: .* several parts"),
    "exr without a header": (lambda: b"v/1\x01\x02\0\0\0\0", "PCK003: .* header is cut or garbled"),
    "tiff of three floats": (lambda: tiff(three(RAMP)), "PCK002: is a TIFF file of a kind that is not read"),
    "tiff of 32 bits": (lambda: tiff(deep(RAMP).astype(np.uint32)), "PCK002: .* not of 8 or 16 bits"),
    "tiff below 0": (lambda: tiff((RAMP * 1000 - 500).astype(np.int16)), "PCK002: .* not of 8 or 16 bits"),
    "tiff with a number that is none": (lambda: tiff(RAMP * np.inf), "PCK003: holds values that are no numbers"),
    "tiff of large tiles": (
        lambda: tiff(deep(RAMP), width=MAX_SIDE_PX * 8, height=16),
        "PCK004: has tiles of over 8192",
    ),
}


@pytest.mark.filterwarnings("ignore:invalid value encountered")
def test_what_cannot_be_read_is_told_before_it_is_unpacked(subtests: pytest.Subtests) -> None:
    for name in sorted(REFUSED):
        with subtests.test(name=name):
            write, message = REFUSED[name]
            with pytest.raises(Rejected, match=message):
                decode_map(write(), MapRole.HEIGHT)


def test_any_cut_of_a_file_is_refused_and_raises_nothing_else() -> None:
    for whole in (exr(colours(three(RAMP))), tiff(deep(RAMP)), deep_png(deep(RAMP))):
        for share in (0.0, 0.0001, 0.001, 0.3, 0.9):
            with pytest.raises(Rejected, match="PCK00"):
                decode(whole[: int(len(whole) * share)])


def test_a_process_that_ends_is_a_broken_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exr_files, "MEMORY_BYTES", 1)
    whole = exr({"Y": RAMP})
    header = exr_files.read_header(whole)
    ended = [sys.executable, "-c", "import os; os.kill(os.getpid(), 11)"]
    run = subprocess.run
    monkeypatch.setattr(exr_files.subprocess, "run", lambda _, **rest: run(ended, **rest))
    with pytest.raises(Rejected, match="PCK003: cannot be decoded: OpenEXR: it ended with -11"):
        exr_files.read_pixels(whole, header)


def test_heights_keep_16_bits() -> None:
    image = RAMP[..., None]
    assert np.abs(pixels_of(png(image, is_deep=True)) - image).max() < WORD
    assert np.abs(pixels_of(png(image)) - image).max() > WORD


def material(folder: Path, **maps: bytes) -> Path:
    """A material as Poly Haven gives it: a colour, and maps in other formats (`nor_gl_1k.exr` -> bytes)."""
    folder.mkdir(parents=True)
    (folder / "slab_diff_1k.jpg").write_bytes(encoded(tiling(), "JPEG"))
    for name, data in maps.items():
        (folder / f"slab_{name.replace('__', '.')}").write_bytes(data)
    return folder


def taken(source: Path, library: Path) -> Pack:
    return ingest_pack(source, PackOptions(library=library, pack="p", flags=SIZED)).pack


def plane(picture: PackPicture, library: Path, number: int) -> npt.NDArray[np.floating]:
    with Image.open(library / "textures" / "p" / picture.files[number]) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255


def test_maps_of_poly_haven_as_exr(tmp_path: Path) -> None:
    """Normals, roughness and metalness as EXR, heights as a TIFF of floats: all are used as if they were PNG."""
    shown = normals(relief() * 0.004, (1.0, 1.0)).astype(np.float32) / 255
    one = np.ones((512, 512), np.float16)
    source = material(
        tmp_path / "in",
        nor_gl_1k__exr=exr(colours(shown), "PIZ"),
        rough_1k__exr=exr({"Y": one * 0.3}),
        metal_1k__exr=exr({"Y": one}),
        disp_1k__tiff=tiff(relief() * 0.01),
        ao_1k__exr=b"is not looked at",
    )
    pack = taken(source, tmp_path / "lib")
    (picture,) = pack.pictures
    assert (pack.refused, picture.derived, picture.notes, picture.faults) == ((), (), (), ())
    assert picture.given == {
        "height": "slab_disp_1k.tiff",
        "metalness": "slab_metal_1k.exr",
        "normal": "slab_nor_gl_1k.exr",
        "roughness": "slab_rough_1k.exr",
    }
    gloss = plane(picture, tmp_path / "lib", 2)
    assert gloss[..., 1:].mean(axis=(0, 1)) == pytest.approx([0.3, 1.0], abs=0.01)
    mean = shown.reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
    assert np.abs(plane(picture, tmp_path / "lib", 1) - mean).mean() < 0.01


def test_of_two_files_of_one_map_a_picture_of_8_bits_is_read(tmp_path: Path) -> None:
    grey = np.full((512, 512), 77, np.uint8)
    one = np.ones((512, 512), np.float32)
    source = material(
        tmp_path / "in", rough_1k__exr=exr({"Y": one}), rough_1k__tif=tiff(one), rough_1k__png=encoded(grey)
    )
    (picture,) = taken(source, tmp_path / "lib").pictures
    assert picture.given == {"roughness": "slab_rough_1k.png"}


def test_normals_of_heights_of_16_bits_are_no_stairs() -> None:
    """Slopes of a shallow relief, which 8 bits hold in a few steps."""
    x = np.linspace(0.0, 2 * np.pi, 512, endpoint=False)
    shallow = np.tile(0.5 + 0.02 * np.sin(16 * x), (512, 1))
    stone, look = registry.load().substances["stone"], (Surface.WALL, None)
    steps = {}
    for name, data in (("deep", deep_png(deep(shallow))), ("flat", encoded(np.round(shallow * 255).astype(np.uint8)))):
        given = GivenMaps(height=decode_map(data, MapRole.HEIGHT)[..., :1])
        made = tile(tiling().astype(np.float32) / 255, 512, given)
        finish = finish_of_tile("slab", made, (0.1, 0.1), look, stone, 512)
        texture = finish.material.normal_texture
        assert texture is not None
        steps[name] = float(np.abs(np.diff(pixels_of(texture.png)[..., 0], axis=1)).max())
    assert steps["deep"] < 0.8 * steps["flat"]


def test_pictures_of_tiff_and_exr_stand_alone(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "a.exr").write_bytes(exr(colours(linear_from_srgb_array(tiling(1).astype(np.float32) / 255))))
    (folder / "b.tif").write_bytes(encoded(tiling(2), "TIFF"))
    (folder / "c.png").write_bytes(encoded(tiling(3)))
    pack = taken(folder, tmp_path / "lib")
    assert [picture.source for picture in pack.pictures] == ["a.exr", "b.tif", "c.png"]
    seen = plane(pack.pictures[0], tmp_path / "lib", 0)
    assert seen.mean() == pytest.approx(tiling(1).mean() / 255, abs=0.01)


def test_without_openexr_its_file_and_the_extra_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("casa_assets.textures.packs.exr.MODULE", "module_that_is_nowhere")
    source = material(tmp_path / "in", rough_1k__exr=exr({"Y": RAMP}))
    with pytest.raises(CasaError, match=r"^slab_rough_1k\.exr: .*PNG.* needs .*; the extra 'exr' brings it: .*pip"):
        taken(source, tmp_path / "lib")
    assert not (tmp_path / "lib" / "textures").exists()
    (source / "slab_rough_1k.exr").rename(source / "slab_ao_1k.exr")
    assert len(taken(source, tmp_path / "lib").pictures) == 1, "what is not read asks for nothing"
