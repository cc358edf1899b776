"""FBX, USD, X3D, VRML, 3DS and members of archives: the same box out of each, with unit, axis, place and picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.core import system
from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import RawModel, Up
from tests.support.mesh import format_files as made
from tests.support.mesh.mesh_files import LIMITS, QUARTERS, codes_of, load_bytes, load_path, png, refusal

PICTURE = {"a.png": png(QUARTERS)}
# Format -> file, metres per unit, up, and the length of its sides in metres along x, y, z of the file.
SIZE = (0.08, 0.1, 0.06)
FILES = {
    "a.usda": (made.usda().encode(), 0.01, Up.Z, SIZE),
    "a.usdz": (made.usdz(), 0.01, Up.Z, SIZE),
    "a.fbx": (made.fbx(), 0.01, Up.Y, SIZE),
    "a.x3d": (made.x3d().encode(), 1.0, Up.Y, SIZE),
    "a.wrl": (made.wrl().encode(), 1.0, Up.Y, SIZE),
    "a.3ds": (made.max3ds(), None, Up.Z, (0.08, 0.06, 0.1)),
}


# Where a node has moved the lowest point of the box to.
MOVED = {"a.fbx": 2.0, "a.x3d": 0.02, "a.wrl": 0.02}


def extents(model: RawModel) -> Floats:
    points = np.concatenate([part.mesh.vertices for part in model.parts])
    return np.asarray(np.ptp(points, axis=0) * (model.metres_per_unit or 1.0))


def test_a_box_is_read_with_its_unit_and_axis() -> None:
    for name in sorted(FILES):
        data, metres, up, size = FILES[name]
        model = load_bytes(name, data, **PICTURE)
        assert (model.metres_per_unit, model.up) == (metres, up)
        assert sum(len(part.mesh.faces) for part in model.parts) == 12
        assert np.allclose(extents(model), size, atol=1e-5)
        assert codes.TYPE_BY_CONTENT not in codes_of(model)
        if name in MOVED:
            assert model.parts[0].mesh.vertices[:, 1].min() == pytest.approx(MOVED[name])


def test_the_picture_beside_it_is_shown(tmp_path_factory: pytest.TempPathFactory) -> None:
    for name in sorted(set(FILES) - {"a.wrl"}):
        tmp_path = tmp_path_factory.mktemp("case")
        (tmp_path / name).write_bytes(FILES[name][0])
        (tmp_path / "a.png").write_bytes(PICTURE["a.png"])
        model = load_path(tmp_path / name)
        assert model.parts[0].material.base_color_texture is not None
    packed = load_bytes("a.fbx", made.fbx(PICTURE["a.png"]))
    assert packed.parts[0].material.base_color_texture is not None
    # of X3D, stored upside down
    text = made.x3d()
    plain = load_bytes("a.x3d", text, **PICTURE).parts[0].mesh.uv
    turned = load_bytes("a.x3d", text.replace("<ImageTexture", "<ImageTexture flipVertically='true'"), **PICTURE)
    assert plain is not None
    assert np.allclose(plain * (1, -1) + (0, 1), turned.parts[0].mesh.uv)


def test_usd_instances_are_expanded() -> None:
    box = made.usda().replace('def Xform "thing"', 'class "shared"', 1).replace("</thing/", "</shared/")
    box = box.replace('defaultPrim = "thing"', 'defaultPrim = "a"')
    uses = "".join(
        f'def Xform "{n}" (\n instanceable = true\n references = </shared>\n)\n'
        f'{{\n double3 xformOp:translate = ({x}, 0, 0)\n uniform token[] xformOpOrder = ["xformOp:translate"]\n}}\n'
        for n, x in (("a", 0), ("b", 20), ("c", 40))
    )
    model = load_bytes("a.usda", box + uses)
    assert len(model.parts) == 3
    assert extents(model)[0] == pytest.approx(0.48)


def test_usd_holes_hidden_prims_and_handedness_are_minded() -> None:
    def with_line(line: str) -> str:
        return made.usda().replace("int[] faceVertexCounts", f"{line}\n int[] faceVertexCounts")

    assert len(load_bytes("a.usda", with_line("int[] holeIndices = [0, 1]")).parts[0].mesh.faces) == 10
    assert refusal("a.usda", with_line('token visibility = "invisible"')) == codes.NO_GEOMETRY
    volumes = []
    for line in ("", 'uniform token orientation = "leftHanded"'):
        mesh = load_bytes("a.usda", with_line(line)).parts[0].mesh
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        volumes.append(np.einsum("fi,fi->", a, np.cross(b, c)))
    assert volumes[0] == pytest.approx(-volumes[1])


def test_usd_layers_of_the_folder_are_followed_and_no_others(tmp_path: Path) -> None:
    folder = tmp_path / "in" / "sub"
    folder.mkdir(parents=True)
    (tmp_path / "in" / "box.usda").write_text(made.usda())
    (tmp_path / "box.usda").write_text(made.usda())
    for name, where in (("inside", "../box.usda"), ("outside", "../../box.usda"), ("root", "/etc/hostname")):
        text = f'#usda 1.0\ndef Xform "a" (\n references = @{where}@</thing>\n)\n{{\n}}\n'
        (folder / f"{name}.usda").write_text(text)
    found = {one.main: one for one in discover([tmp_path / "in"]) if isinstance(one, Found)}
    assert len(load(collect(found["sub/inside.usda"], LIMITS), LIMITS).parts) == 1
    for name in ("outside", "root"):
        with pytest.raises(Rejected) as error:
            collect(found[f"sub/{name}.usda"], LIMITS)
        assert error.value.code == codes.PATH_TRAVERSAL


def test_a_blend_without_blender_says_how_to_install_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.blend").write_bytes(b"BLENDER-v300RENDH")
    monkeypatch.delenv(system.BLENDER_VARIABLE, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr(system, "_CHECKOUT", tmp_path / "none")
    (one,) = discover([tmp_path])
    assert isinstance(one, Found)
    with pytest.raises(Rejected, match="pip install bpy") as error:
        collect(one, LIMITS)
    assert error.value.code == codes.NEEDS_BLENDER
