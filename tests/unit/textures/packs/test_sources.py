"""Materials with their maps, and pictures that have to be made smaller."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.model.registry.rows import Surface
from casa_assets.pipeline.textures.packs.ingest import PackOptions, ingest_pack
from casa_assets.textures.finish import normals
from casa_assets.textures.packs.entry import (
    MapRole,
    Pack,
    PackPicture,
    PictureDescription,
    PictureRejection,
    group_maps,
    name_and_role,
)
from tests.pictures import encoded, pixels, relief, tiling

pytestmark = [
    pytest.mark.content("code", "textures.packs", keep=0),
    pytest.mark.content("code", "pipeline.textures", keep=0),
]

WALL = PictureDescription(surface=Surface.WALL, licence="CC0-1.0")
SIZED = WALL.replace(tile_m=(1.0, 1.0))


def grey(value: float) -> bytes:
    return encoded(np.full((512, 512), round(value * 255), np.uint8))


def material(folder: Path, **more: bytes) -> Path:
    """A folder with a colour and four maps of one material; `more` replaces or adds maps."""
    maps = {
        "color": encoded(tiling(2)),
        "height": grey(0.5),
        "normal": encoded(normals(relief() * 0.004, (1.0, 1.0))),
        "roughness": grey(0.3),
        **more,
    }
    folder.mkdir(parents=True)
    for role, data in maps.items():
        (folder / f"Bricks_{role}.png").write_bytes(data)
    return folder


def taken(source: Path, library: Path, flags: PictureDescription = SIZED) -> Pack:
    return ingest_pack(source, PackOptions(library=library, pack="p", flags=flags)).pack


def plane(picture: PackPicture, library: Path, number: int) -> np.ndarray:  # type: ignore[type-arg]
    with Image.open(library / "textures" / "p" / picture.files[number]) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255


def test_names_of_maps(subtests: pytest.Subtests) -> None:
    for name, expected in [
        ("Bricks001_Color.jpg", ("bricks001", MapRole.COLOR)),
        ("brick_wall_02_normal.png", ("brick_wall_02", MapRole.NORMAL)),
        ("a/oak_metalness.tif", ("oak", MapRole.METALNESS)),
        ("a farm.png", None),
        ("color.png", None),
    ]:
        with subtests.test(name=name, expected=expected):
            assert name_and_role(name) == expected


def test_pictures_that_are_called_like_maps_are_pictures() -> None:
    found = group_maps(["a/old_metal.png", "a/rusty_color.png", "b/rusty_roughness.png"])
    assert [(one.name, list(one.maps)) for one in found] == [
        ("old_metal", [MapRole.COLOR]),
        ("rusty_color", [MapRole.COLOR]),
        ("rusty_roughness", [MapRole.COLOR]),
    ]


def test_a_material_with_its_maps(tmp_path: Path) -> None:
    pack = taken(material(tmp_path / "in"), tmp_path / "lib")
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
    wanted = normals(relief() * 0.004, (1.0, 1.0)).astype(np.float64) / 127.5 - 1
    mean = wanted.reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
    assert np.abs(shown - mean).mean() < 0.03
    assert np.corrcoef(shown[..., 1].ravel(), mean[..., 1].ravel())[0, 1] > 0.99


def test_a_metal(tmp_path: Path) -> None:
    (picture,) = taken(material(tmp_path / "in", metalness=grey(1.0)), tmp_path / "lib").pictures
    assert sorted(picture.given) == ["height", "metalness", "normal", "roughness"]
    assert plane(picture, tmp_path / "lib", 2)[..., 2].min() == 1.0


def test_maps_that_do_not_fit_are_left_out_with_a_note(tmp_path: Path) -> None:
    source = material(tmp_path / "in", roughness=encoded(pixels(1, 1024, 600)), metalness=b"no picture")
    (picture,) = taken(source, tmp_path / "lib").pictures
    assert sorted(picture.given) == ["height", "normal"]
    assert [note.partition(" was")[0] for note in picture.notes] == [
        "its map of the metalness",
        "its map of the roughness",
    ]


def test_maps_are_cut_with_the_colour(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    image = pixels(1, 640, 640)
    (folder / "a_color.png").write_bytes(encoded(image))
    (folder / "a_roughness.png").write_bytes(encoded(image[..., 0]))
    (picture,) = taken(folder, tmp_path / "lib").pictures
    assert picture.repaired
    base, rough = plane(picture, tmp_path / "lib", 0), plane(picture, tmp_path / "lib", 2)
    height, width = (n - n % 2 for n in base.shape[:2])
    small = base[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
    assert np.corrcoef(small[..., 0].ravel(), rough[..., 1].ravel())[0, 1] > 0.8


def test_maps_without_a_colour(tmp_path: Path) -> None:
    source = material(tmp_path / "in")
    (source / "Bricks_color.png").unlink()
    pack = taken(source, tmp_path / "lib")
    assert [row.code for row in pack.refused] == [PictureRejection.NO_COLOR.value]
    assert pack.pictures == ()


def test_without_a_size_the_way_to_one_is_told(tmp_path: Path) -> None:
    (row,) = taken(material(tmp_path / "in"), tmp_path / "lib", WALL).refused
    assert (row.code, row.message) == (PictureRejection.NOT_DESCRIBED.value, "nobody says its tile_m")
    assert "--tile" in row.fix


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "a.zip").write_bytes(b"PK")
    with pytest.raises(CasaError, match="is no folder; unpack it first"):
        taken(tmp_path / "a.zip", tmp_path / "lib")


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
