"""Materials with their maps, the numbers that are read of TIFF and PNG of 16 bits, and pictures made smaller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.model.registry.rows import Surface
from casa_assets.textures.finish import normals
from casa_assets.textures.pack_entry import (
    MAX_SIDE_PX,
    MapRole,
    Pack,
    PackPicture,
    PictureDescription,
    PictureRejection,
)
from casa_assets.textures.pack_pictures import decode, decode_map
from casa_assets.textures.run.packs import PackOptions, ingest_pack
from tests.support.library.pictures import deep_png, encoded, pixels, relief, tiff, tiling

pytestmark = [
    pytest.mark.content("code", "textures", keep=0),
    pytest.mark.content("code", "textures.run", keep=0),
]

SIZED = PictureDescription(surface=Surface.WALL, licence="CC0-1.0", tile_m=(1.0, 1.0))
RAMP = np.tile(np.linspace(0.0, 1.0, 600, dtype=np.float32), (540, 1))
BYTE, WORD = 0.5 / 255, 1.0 / 65535


def deep(image: npt.NDArray[np.floating], depth: int = 16) -> npt.NDArray[np.uint16]:
    return np.round(image * (2**depth - 1)).astype(np.uint16)


def three(image: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    return np.dstack([image] * 3)


READ = {
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


REFUSED: dict[str, tuple[Callable[[], bytes], str]] = {
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
    kinds = [encoded(pixels(), kind) for kind in ("PNG", "JPEG", "WEBP")]
    for whole in (tiff(deep(RAMP)), deep_png(deep(RAMP)), *kinds):
        for share in (0.0, 0.0001, 0.001, 0.01, 0.3, 0.7):
            with pytest.raises(Rejected, match="PCK00"):
                decode(whole[: int(len(whole) * share)])
    assert [decode(whole).pixels.shape for whole in kinds] == [(520, 520, 3)] * 3


def grey(value: float) -> bytes:
    return encoded(np.full((512, 512), round(value * 255), np.uint8))


NORMALS = normals(relief() * 0.004, (1.0, 1.0))
MAPS = {"height__png": grey(0.5), "normal__png": encoded(NORMALS), "roughness__png": grey(0.3)}


def material(folder: Path, **maps: bytes) -> Path:
    """A folder with a colour and maps of one material (`normal__tif` -> bytes)."""
    folder.mkdir(parents=True)
    for name, data in {"color__png": encoded(tiling(2)), **maps}.items():
        (folder / f"Bricks_{name.replace('__', '.')}").write_bytes(data)
    return folder


def taken(source: Path, library: Path) -> Pack:
    return ingest_pack(source, PackOptions(library=library, pack="p", flags=SIZED)).pack


def plane(picture: PackPicture, library: Path, number: int) -> npt.NDArray[np.floating]:
    with Image.open(library / "textures" / "p" / picture.files[number]) as image:
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
    pack = taken(source, tmp_path / "lib")
    (picture,) = pack.pictures
    assert (pack.refused, picture.derived, picture.notes, picture.faults) == ((), (), (), ())
    assert picture.given == {
        "height": "Bricks_height.tiff",
        "metalness": "Bricks_metalness.tif",
        "normal": "Bricks_normal.png",
        "roughness": "Bricks_roughness.png",
    }
    gloss = plane(picture, tmp_path / "lib", 2)
    assert gloss[..., 1:].mean(axis=(0, 1)) == pytest.approx([0.3, 1.0], abs=0.01)


def test_a_material_with_its_maps(tmp_path: Path) -> None:
    pack = taken(material(tmp_path / "in", **MAPS), tmp_path / "lib")
    (picture,) = pack.pictures
    assert pack.refused == ()
    assert (picture.id, picture.source) == ("p_bricks", "Bricks_color.png")
    assert picture.given == {
        "height": "Bricks_height.png",
        "normal": "Bricks_normal.png",
        "roughness": "Bricks_roughness.png",
    }
    assert picture.derived == ()
    assert not picture.repaired
    assert picture.faults == ()
    rough = plane(picture, tmp_path / "lib", 2)
    assert rough[..., 1] == pytest.approx(np.full(rough.shape[:2], 0.3), abs=0.01)
    assert rough[..., 2].max() == 0
    shown = plane(picture, tmp_path / "lib", 1) * 2 - 1
    wanted = NORMALS.astype(np.float64) / 127.5 - 1
    mean = wanted.reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
    assert np.abs(shown - mean).mean() < 0.03
    assert np.corrcoef(shown[..., 1].ravel(), mean[..., 1].ravel())[0, 1] > 0.99


def test_maps_that_do_not_fit_are_left_out_with_a_note(tmp_path: Path) -> None:
    unfit = {"roughness__png": encoded(pixels(1, 1024, 600)), "metalness__png": b"no picture"}
    source = material(tmp_path / "in", **MAPS | unfit)
    (picture,) = taken(source, tmp_path / "lib").pictures
    assert sorted(picture.given) == ["height", "normal"]
    assert [note.partition(" was")[0] for note in picture.notes] == [
        "its map of the metalness",
        "its map of the roughness",
    ]


def test_maps_are_cut_with_the_colour(tmp_path: Path) -> None:
    image = pixels(1, 640, 640)
    folder = material(tmp_path / "in", color__png=encoded(image), roughness__png=encoded(image[..., 0]))
    (picture,) = taken(folder, tmp_path / "lib").pictures
    assert picture.repaired
    base, rough = plane(picture, tmp_path / "lib", 0), plane(picture, tmp_path / "lib", 2)
    height, width = (n - n % 2 for n in base.shape[:2])
    small = base[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
    assert np.corrcoef(small[..., 0].ravel(), rough[..., 1].ravel())[0, 1] > 0.8


def test_maps_without_a_colour(tmp_path: Path) -> None:
    source = material(tmp_path / "in", **MAPS)
    (source / "Bricks_color.png").unlink()
    pack = taken(source, tmp_path / "lib")
    assert [row.code for row in pack.refused] == [PictureRejection.NO_COLOR.value]
    assert pack.pictures == ()


def test_a_large_photograph_is_made_smaller(tmp_path: Path) -> None:
    """Noise packs badly: the files of a picture of 1024 px would be larger than a check allows."""
    rng = np.random.default_rng(3)
    noisy = np.clip(rng.normal(128, 40, (1024, 1024, 3)), 0, 255).astype(np.uint8)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "noise.png").write_bytes(encoded(noisy))
    (picture,) = taken(tmp_path / "in", tmp_path / "lib").pictures
    assert picture.width_px < 1000
    assert sum((tmp_path / "lib" / "textures" / "p" / name).stat().st_size for name in picture.files) < 2_500_000
    assert "was scaled down to" in " ".join(picture.notes)
