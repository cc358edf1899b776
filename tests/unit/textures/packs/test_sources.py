"""Packs of zips and maps as libraries of textures give them, of lists of prompts, and hostile ones of both."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.model.registry.finish import Surface
from casa_assets.pipeline.textures.packs.ingest import PackOptions, ingest_pack
from casa_assets.textures.finish import normals
from casa_assets.textures.packs.entry import Pack, PackPicture, PictureDescription
from casa_assets.textures.packs.maps import MapRole, group_maps, name_and_role
from casa_assets.textures.packs.rejections import PictureRejection
from casa_assets.textures.packs.statements import read_prompts, read_sizes
from tests.pictures import encoded, pixels, relief, tiling

pytestmark = [
    pytest.mark.content("code", "textures.packs", keep=0),
    pytest.mark.content("code", "pipeline.textures", keep=0),
]

WALL = PictureDescription(surface=Surface.WALL, licence="CC0-1.0")
SIZED = WALL.replace(tile_m=(1.0, 1.0))


def grey(value: float) -> bytes:
    return encoded(np.full((512, 512), round(value * 255), np.uint8))


def normal_map(up: bool = True) -> bytes:
    """Normals of the relief of a seed; y down for DirectX."""
    made = normals(relief() * 0.004, (1.0, 1.0)).copy()
    made[..., 1] = made[..., 1] if up else 255 - made[..., 1]
    return encoded(made)


def ambientcg(name: str = "Bricks001", **more: bytes) -> dict[str, bytes]:
    """Members of a zip of ambientCG, in small."""
    stem = f"{name}_1K-JPG"
    return {
        f"{name}.png": encoded(tiling(8)),
        f"{name}_1K-JPG.usdc": b"PXR-USDC",
        f"{stem}_AmbientOcclusion.jpg": encoded(np.full((512, 512), 250, np.uint8), "JPEG"),
        f"{stem}_Color.jpg": encoded(tiling(2), "JPEG"),
        f"{stem}_Displacement.jpg": encoded(np.full((512, 512), 128, np.uint8), "JPEG"),
        f"{stem}_NormalDX.png": normal_map(up=False),
        f"{stem}_NormalGL.png": normal_map(),
        f"{stem}_Roughness.png": grey(0.3),
        **{f"{stem}_{key}": data for key, data in more.items()},
    }


def polyhaven(name: str = "brick_wall_02") -> dict[str, bytes]:
    """Members of a zip of Poly Haven, in small: its normals are an EXR that cannot be read."""
    return {
        f"{name}_1k.blend": b"BLENDER",
        f"textures/{name}_arm_1k.png": encoded(
            np.dstack([tiling()[..., 0], *(np.full((512, 512), v, np.uint8) for v in (102, 204))])
        ),
        f"textures/{name}_diff_1k.jpg": encoded(tiling(3), "JPEG"),
        f"textures/{name}_disp_1k.png": encoded(np.full((512, 512), 128, np.uint8)),
        f"textures/{name}_nor_gl_1k.exr": b"v/1\x01",
    }


def zipped(path: Path, members: Mapping[str, bytes]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def taken(source: Path, library: Path, flags: PictureDescription = SIZED) -> Pack:
    return ingest_pack(source, PackOptions(library=library, pack="p", flags=flags)).pack


def plane(picture: PackPicture, library: Path, number: int) -> np.ndarray:  # type: ignore[type-arg]
    with Image.open(library / "textures" / "p" / picture.files[number]) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255


def test_names_of_maps(subtests: pytest.Subtests) -> None:
    for name, expected in [
        ("Bricks001_1K-JPG_Color.jpg", ("bricks001", MapRole.COLOR)),
        ("Bricks001_2K_NormalDX.jpg", ("bricks001", MapRole.NORMAL_DX)),
        ("MetalPlates001_1K_Metalness.jpg", ("metalplates001", MapRole.METALNESS)),
        ("brick_wall_02_nor_gl_4k.exr", ("brick_wall_02", MapRole.NORMAL_GL)),
        ("brick_wall_02_diff_1k.jpg", ("brick_wall_02", MapRole.COLOR)),
        ("aerial_rocks_02_arm_1k.jpg", ("aerial_rocks_02", MapRole.PACKED)),
        ("oak_metallic_roughness.png", ("oak", MapRole.PACKED)),
        ("a farm.png", None),
        ("color.png", None),
    ]:
        with subtests.test(name=name, expected=expected):
            assert name_and_role(name) == expected


def test_pictures_that_are_called_like_maps_are_pictures() -> None:
    found = group_maps(["a/old_metal.png", "a/rusty_color.png", "b/rusty_rough.png"])
    assert [(one.name, list(one.maps)) for one in found] == [
        ("old_metal", [MapRole.COLOR]),
        ("rusty_color", [MapRole.COLOR]),
        ("rusty_rough", [MapRole.COLOR]),
    ]


def test_a_zip_of_ambientcg(tmp_path: Path) -> None:
    source = zipped(tmp_path / "Bricks001_1K-JPG.zip", ambientcg())
    pack = taken(source, tmp_path / "lib")
    (picture,) = pack.pictures
    assert pack.refused == ()
    assert picture.id == "p_bricks001"
    assert picture.source == "Bricks001_1K-JPG_Color.jpg"
    assert picture.given == {
        "height": "Bricks001_1K-JPG_Displacement.jpg",
        "normal": "Bricks001_1K-JPG_NormalGL.png",
        "roughness": "Bricks001_1K-JPG_Roughness.png",
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


def test_normals_of_directx_are_turned(tmp_path: Path) -> None:
    members = {name: data for name, data in ambientcg().items() if "NormalGL" not in name}
    (picture,) = taken(zipped(tmp_path / "a.zip", members), tmp_path / "lib").pictures
    assert picture.given["normal"].endswith("NormalDX.png")
    wanted = normals(relief() * 0.004, (1.0, 1.0)).astype(np.float64).reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
    shown = plane(picture, tmp_path / "lib", 1)
    assert np.corrcoef(shown[..., 1].ravel(), wanted[..., 1].ravel())[0, 1] > 0.99


def test_zips_in_a_folder_with_what_their_libraries_state(tmp_path: Path) -> None:
    """A metal of ambientCG, and a wall of Poly Haven without readable normals; sizes and authors from their JSON."""
    folder = tmp_path / "in"
    zipped(folder / "Metal014_1K-JPG.zip", ambientcg("Metal014", **{"Metalness.png": grey(1.0)}))
    zipped(folder / "brick_wall_02_1k.zip", polyhaven())
    stated = {"assetId": "Metal014", "dimensionX": "120", "dimensionY": 60}
    (folder / "ambientcg.json").write_text(json.dumps({"foundAssets": [stated]}))
    (folder / "brick_wall_02.json").write_text(
        json.dumps({"name": "Brick Wall 02", "dimensions": [2000, 1500], "authors": {"A. Maker": "All"}})
    )
    pack = taken(folder, tmp_path / "lib", WALL)
    metal, bricks = pack.pictures
    assert (metal.source, metal.tile_m, metal.author) == (
        "Metal014_1K-JPG.zip/Metal014_1K-JPG_Color.jpg",
        (1.2, 0.6),
        "unknown",
    )
    assert sorted(metal.given) == ["height", "metalness", "normal", "roughness"]
    assert plane(metal, tmp_path / "lib", 2)[..., 2].min() == 1.0
    assert (bricks.id, bricks.tile_m, bricks.author) == ("p_brick_wall_02", (2.0, 1.5), "A. Maker")
    assert sorted(bricks.given) == ["height", "metalness", "roughness"]
    assert bricks.derived == ("normal",)
    assert bricks.notes == (
        "its map of the normal was left out: it cannot be decoded: its EXR header is cut or garbled",
    )
    packed = plane(bricks, tmp_path / "lib", 2)
    assert packed[..., 1:].mean(axis=(0, 1)) == pytest.approx([0.4, 0.8], abs=0.01)
    assert bricks.faults == ("TEX008 the picture is coarse for its size: 256 px/m is below 400",)


def test_maps_that_do_not_fit_are_left_out_with_a_note(tmp_path: Path) -> None:
    members = ambientcg(**{"Roughness.png": encoded(pixels(1, 1024, 600)), "Metalness.png": b"no picture"})
    (picture,) = taken(zipped(tmp_path / "a.zip", members), tmp_path / "lib").pictures
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
    (folder / "a_rough.png").write_bytes(encoded(image[..., 0]))
    (picture,) = taken(folder, tmp_path / "lib").pictures
    assert picture.repaired
    base, rough = plane(picture, tmp_path / "lib", 0), plane(picture, tmp_path / "lib", 2)
    height, width = (n - n % 2 for n in base.shape[:2])
    small = base[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
    assert np.corrcoef(small[..., 0].ravel(), rough[..., 1].ravel())[0, 1] > 0.8


def test_maps_without_a_colour(tmp_path: Path) -> None:
    members = {name: data for name, data in ambientcg().items() if "Color" not in name}
    pack = taken(zipped(tmp_path / "a.zip", members), tmp_path / "lib")
    assert [row.code for row in pack.refused] == [PictureRejection.NO_COLOR.value]
    assert pack.pictures == ()


def test_without_a_size_the_way_to_one_is_told(tmp_path: Path) -> None:
    (row,) = taken(zipped(tmp_path / "a.zip", ambientcg()), tmp_path / "lib", WALL).refused
    assert (row.code, row.message) == (PictureRejection.NOT_DESCRIBED.value, "nobody says its tile_m")
    assert "--tile" in row.fix
    assert "JSON" in row.fix


def _lying_zip() -> bytes:
    """A zip whose member claims to unpack to a thousand times its size."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a_color.png", bytes(40_000_000))
    return out.getvalue()


def _zip_of(name: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr(name, encoded(tiling()))
    return out.getvalue()


HOSTILE = {
    "cut": _zip_of("a.png")[:-30],
    "no zip": b"PK\x03\x04" + bytes(100),
    "empty": b"",
    "bomb": _lying_zip(),
    "leaves": _zip_of("../../a.png"),
    "absolute": _zip_of("/etc/a.png"),
}


@pytest.mark.parametrize("data", HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_zip_is_left_out_and_the_others_are_taken(tmp_path: Path, data: bytes) -> None:
    folder = tmp_path / "in"
    zipped(folder / "good.zip", ambientcg())
    (folder / "bad.zip").write_bytes(data)
    pack = taken(folder, tmp_path / "lib")
    assert [(row.source, row.code) for row in pack.refused] == [("bad.zip", PictureRejection.BAD_ARCHIVE.value)]
    assert len(pack.pictures) == 1


def test_a_hostile_picture_in_a_zip(tmp_path: Path) -> None:
    source = zipped(tmp_path / "a.zip", {"x.png": encoded(tiling())[:3000], "y.png": encoded(tiling(4))})
    pack = taken(source, tmp_path / "lib")
    assert [(row.source, row.code) for row in pack.refused] == [("x.png", PictureRejection.BROKEN.value)]
    assert [picture.source for picture in pack.pictures] == ["y.png"]
    with pytest.raises(CasaError, match="is no zip"):
        taken(Path(__file__), tmp_path / "lib")


def test_lists_of_prompts(subtests: pytest.Subtests) -> None:
    for name, text, expected in [
        ("prompts.txt", "a wall\n# note\n\na floor\n", {"a.png": "a wall", "b.png": "a floor"}),
        ("prompts.txt", "b.png: oak: planks\n", {"b.png": "oak: planks"}),
        ("prompts.json", '{"a.png": "a wall", "b.png": {"prompt": "x"}}', {"a.png": "a wall", "b.png": "x"}),
        ("prompts.json", '[{"file": "a.png", "prompt": "a  wall"}]', {"a.png": "a wall"}),
        ("metadata.jsonl", '{"file_name": "a.png", "text": "a wall"}\n', {"a.png": "a wall"}),
        ("prompts.csv", "file,prompt\na.png,a wall\n", {"a.png": "a wall"}),
    ]:
        with subtests.test(name=name, text=text, expected=expected):
            assert read_prompts(name, text, ["a.png", "b.png"]) == expected


def test_lists_that_are_wrong(subtests: pytest.Subtests) -> None:
    for name, text, message in [
        ("prompts.txt", "one\ntwo\nthree\n", "3 prompts for 2 pictures"),
        ("prompts.txt", "a.png: one\ntwo\n", "'two' has none"),
        ("prompts.json", "[", "cannot be read"),
        ("prompts.json", "[1]", "cannot be read"),
        ("prompts.csv", "picture,prompt\na.png,x\n", "a row names no file"),
    ]:
        with subtests.test(name=name, text=text, message=message), pytest.raises(CasaError, match=message):
            read_prompts(name, text, ["a.png", "b.png"])


def test_output_of_a_generator(tmp_path: Path) -> None:
    """Pictures that do not tile, with a list of prompts: they are made to tile, and a prompt of nothing is told."""
    folder = tmp_path / "in" / "run 1"
    folder.mkdir(parents=True)
    for number in range(2):
        (folder / f"0000{number}.png").write_bytes(encoded(pixels(number)))
    rows = [{"file": f"0000{number}.png", "prompt": f"stone {number}"} for number in range(3)]
    (folder / "prompts.json").write_text(json.dumps(rows))
    pack = taken(tmp_path / "in", tmp_path / "lib", SIZED.replace(generator="painter 3"))
    assert [(p.id, p.prompt, p.generator, p.repaired) for p in pack.pictures] == [
        ("p_p00000", "stone 0", "painter 3", True),
        ("p_p00001", "stone 1", "painter 3", True),
    ]
    assert [(row.source, row.code) for row in pack.refused] == [("run 1/00002.png", PictureRejection.MISSING.value)]
    assert pack.ignored == ()


def test_json_that_states_no_size(subtests: pytest.Subtests) -> None:
    for text in [
        "[",
        "[1]",
        '{"assetId": "x", "dimensionX": 0, "dimensionY": 1}',
        '{"dimensions": ["a", 2]}',
        "{}",
        '{"dimensions": [1e300, 1]}',
    ]:
        with subtests.test(text=text):
            assert read_sizes("x.json", text) == {}


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
