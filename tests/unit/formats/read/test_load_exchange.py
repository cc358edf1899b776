"""OFF, 3MF and XAML through trimesh: what they hold, and what is refused before it grows."""

from __future__ import annotations

import io
import socket
import zipfile

import numpy as np
import pytest
import trimesh

from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Up
from tests.support.mesh.mesh_files import load_bytes, refusal

MESH = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)
XAML = (
    '<Viewport3D xmlns="http://schemas.microsoft.com/winfx/2006/xaml/presentation"><GeometryModel3D>'
    '<GeometryModel3D.Geometry><MeshGeometry3D Positions="0,0,0 1,0,0 0,1,0" Normals="0,0,1 0,0,1 0,0,1" '
    'TriangleIndices="0 1 2"/></GeometryModel3D.Geometry></GeometryModel3D></Viewport3D>'
)


def package(model: str, **others: str) -> bytes:
    """A 3MF with this main model."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
        for name, text in others.items():
            archive.writestr(f"3D/{name}.model", text)
    return out.getvalue()


def model(resources: str, build: str, unit: str = "millimeter", head: str = "") -> str:
    """Text of a 3MF model."""
    space = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    return (
        f'{head}<model unit="{unit}" xmlns="{space}"><resources>{resources}</resources><build>{build}</build></model>'
    )


def test_each_states_its_unit_and_axis_as_far_as_it_has_them() -> None:
    off = load_bytes("a.off", "OFF # made by hand\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n")
    assert (off.format, off.up, off.metres_per_unit) == ("off", None, None)
    assert len(off.parts[0].mesh.faces) == 3
    xaml = load_bytes("a.xaml", XAML)
    assert (xaml.format, xaml.up, xaml.metres_per_unit) == ("xaml", Up.Y, pytest.approx(1.0))
    scene = trimesh.Scene()
    matrix = np.eye(4)
    matrix[:3, 3] = 5, 6, 7
    scene.add_geometry(trimesh.creation.box((1, 2, 3)), transform=matrix)
    raw = load_bytes("part.3mf", scene.export(file_type="3mf"))
    assert (raw.format, raw.up, raw.metres_per_unit) == ("threemf", Up.Z, pytest.approx(0.001))
    np.testing.assert_allclose(raw.parts[0].mesh.bounds, [[4.5, 5, 5.5], [5.5, 7, 8.5]])


def test_hostile_text_and_packages() -> None:
    for name, data, code in [
        ("counts.off", "OFF\n1000000000 1000000000 0\n0 0 0\n", codes.EXCHANGE_UNREADABLE),
        ("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", codes.EXCHANGE_UNREADABLE),
        ("words.off", "OFF\n3 1 0\n" + "0 " * 2_000_000, codes.TOO_LARGE),
        ("empty.off", "OFF\n", codes.EXCHANGE_UNREADABLE),
        ("nan.off", "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", codes.NON_FINITE),
        ("points.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", codes.NO_FACES),
        (
            "nested.xaml",
            XAML.replace("<MeshGeometry3D", "<GeometryModel3D/><MeshGeometry3D"),
            codes.BAD_SCENE_GRAPH,
        ),
        ("entity.xaml", '<!DOCTYPE a [<!ENTITY b "c">]>' + XAML, codes.XML_ENTITY),
        ("prefix.xaml", XAML.replace("<MeshGeometry3D", '<MeshGeometry3D s:size="1"'), codes.BAD_XML),
        ("few.xaml", XAML.replace("1,0,0", "1,0"), codes.EXCHANGE_UNREADABLE),
    ]:
        assert refusal(name, data) == code, name
    for content, code in [
        (
            model(f'<object id="1">{MESH}</object>', '<item objectid="1"/>', head='<!DOCTYPE a [<!ENTITY b "c">]>'),
            "SRC022",
        ),
        (
            model('<object id="1"><components><component objectid="1"/></components></object>', '<item objectid="1"/>'),
            "SRC010",
        ),
        (model(f'<object id="1">{MESH}</object>', '<item objectid="1"/>' * 20_001), "SRC010"),
        (model(f'<object id="1">{MESH}<mesh/></object>', '<item objectid="1"/>'), "SRC029"),
        (model(f'<object id="1">{MESH}</object>', '<item objectid="1"/>', unit="cubits"), "SRC030"),
        (model("", ""), "SRC012"),
        ("<model>", "SRC002"),
        (model(f'<object id="1" s:size="1">{MESH}</object>', '<item objectid="1"/>'), codes.BAD_XML),
    ]:
        assert refusal("a.3mf", package(content)) == code


def test_copies_of_copies_are_counted_before_they_are_made() -> None:
    rows = [f'<object id="0">{MESH}</object>']
    for level in range(1, 40):
        twice = f'<component objectid="{level - 1}"/>' * 2
        rows.append(f'<object id="{level}"><components>{twice}</components></object>')
    assert refusal("a.3mf", package(model("".join(rows), '<item objectid="39"/>'))) == codes.BAD_SCENE_GRAPH
    ten = MESH.replace("</triangles>", '<triangle v1="0" v2="1" v3="2"/>' * 9 + "</triangles>")
    many = model(f'<object id="1">{ten}</object>', '<item objectid="1"/>' * 15_000)
    assert refusal("a.3mf", package(many)) == codes.TOO_LARGE
    # 200 MB of spaces in 200 kB; the limits of the tests allow 21 MB
    bomb = package(model(" " * 200_000_000, ""))
    assert len(bomb) < 1_000_000
    assert refusal("a.3mf", bomb) == codes.TOO_LARGE


def test_members_that_leave_the_package_and_cut_archives() -> None:
    slip = io.BytesIO()
    with zipfile.ZipFile(slip, "w") as archive:
        archive.writestr("3D/3dmodel.model", model("", ""))
        archive.writestr("../../evil.model", "x")
    assert refusal("a.3mf", slip.getvalue()) == codes.PATH_TRAVERSAL
    sound = package(model(f'<object id="1">{MESH}</object>', '<item objectid="1"/>'))
    spoilt = bytearray(sound)
    spoilt[60:80] = b"\xff" * 20
    assert refusal("a.3mf", bytes(spoilt)) == codes.EXCHANGE_UNREADABLE


def test_nothing_is_fetched(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*arguments: object, **named: object) -> None:
        raise AssertionError(f"a socket was asked for: {arguments}")

    monkeypatch.setattr(socket, "socket", never)
    other = (
        '<object id="1"><components><component objectid="9" path="http://example.com/a.model"/></components></object>'
    )
    assert refusal("a.3mf", package(model(other, '<item objectid="1"/>'))) == codes.NO_GEOMETRY
