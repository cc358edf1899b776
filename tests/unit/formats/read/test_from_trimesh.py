"""trimesh: its meshes as raw models, what it reads of files that our readers read too, and OFF, 3MF and XAML."""

from __future__ import annotations

import io
import socket
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.formats.read.from_trimesh import bundle_from_trimesh, raw_from_trimesh
from casa_assets.ingest.clean import clean
from casa_assets.ingest.run.steps import run_stages
from casa_assets.mesh.trimesh_exchange import to_trimesh
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import RawPart, Up
from tests.support.mesh.mesh_files import LIMITS, QUARTERS, load_bytes, refusal
from tests.support.mesh.mesh_readings import differences, ours, theirs
from tests.support.mesh.raw_models import brief


def box(units: str | None = None) -> trimesh.Trimesh:
    """2 x 3 x 4 units."""
    mesh = trimesh.creation.box((2, 3, 4))
    mesh.units = units
    return mesh


def test_what_is_refused_or_passed_over() -> None:
    few = {**LIMITS, "input_faces": 11}
    broken = trimesh.Trimesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 7)], process=False)
    for read, code in (
        (lambda: raw_from_trimesh(trimesh.Scene([box("mm"), box("inches")])), codes.MIXED_UNITS),
        (lambda: raw_from_trimesh(box(), few), codes.TOO_LARGE),
        (lambda: load(bundle_from_trimesh(box()), few), codes.TOO_LARGE),
        (lambda: raw_from_trimesh(broken), codes.OUT_OF_BOUNDS),
    ):
        with pytest.raises(Rejected) as refused:
            read()
        assert refused.value.code == code
    raw = raw_from_trimesh(trimesh.Scene([box(), trimesh.PointCloud([(0, 0, 0)])]))
    assert len(raw.parts) == 1
    assert [n.code for n in raw.notes] == [codes.FEATURE_IGNORED]


def test_nodes_place_and_mirror() -> None:
    scene = trimesh.Scene()
    matrix = np.diag([-2.0, 1.0, 1.0, 1.0])
    matrix[0, 3] = 10.0
    scene.add_geometry(box(), node_name="left", transform=matrix)
    (part,) = raw_from_trimesh(scene).parts
    np.testing.assert_allclose(part.mesh.bounds, [[8, -1.5, -2], [12, 1.5, 2]])
    a, b, c = (part.mesh.vertices[part.mesh.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(48.0)  # outward still


def test_pbr_pictures_and_factors() -> None:
    factors = {"metallicFactor": 0.25, "roughnessFactor": 0.5, "baseColorFactor": [0.5, 1, 1, 1.0]}
    pbr = PBRMaterial(name="Paint", baseColorTexture=Image.fromarray(QUARTERS), **factors)
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])

    def part_of(material: PBRMaterial | SimpleMaterial) -> RawPart:
        look = TextureVisuals(uv=corners, material=material)
        square = trimesh.Trimesh(np.pad(corners, ((0, 0), (0, 1))), [(0, 1, 2), (0, 2, 3)], visual=look, process=False)
        (part,) = raw_from_trimesh(square).parts
        return part

    part = part_of(pbr)
    assert part.material.id == "paint"
    assert (part.material.metallic, part.material.roughness) == (0.25, 0.5)
    assert part.material.base_color[0] == pytest.approx(0.5, abs=0.5 / 255)
    assert part.material.base_color_texture is not None
    assert (part.material.base_color_texture.width_px, part.material.base_color_texture.height_px) == (2, 2)
    assert np.array(part.mesh.uv)[2].tolist() == [1.0, 1.0]
    simple = part_of(SimpleMaterial(diffuse=[188, 0, 0, 255]))
    assert simple.material.base_color[0] == pytest.approx(0.503, abs=0.001), "simple colours are display values"


def test_the_digest_is_of_the_content() -> None:
    mesh = box("mm")
    first = bundle_from_trimesh(mesh).sha256
    assert mesh.vertex_normals is not None  # trimesh now keeps normals that nobody has given
    assert mesh.volume == pytest.approx(24.0)
    assert bundle_from_trimesh(mesh).sha256 == first == bundle_from_trimesh(box("mm")).sha256
    assert bundle_from_trimesh(box("cm")).sha256 != first
    mesh.vertices[0] += 0.5
    assert bundle_from_trimesh(mesh).sha256 != first


def test_the_stages_take_it_like_a_file() -> None:
    mesh = trimesh.creation.cylinder(0.04, 0.1, sections=32)
    mesh.units = "meters"
    order = brief("mug")
    asset, _ = run_stages(bundle_from_trimesh(mesh, up=Up.Z), order)
    again, _ = run_stages(bundle_from_trimesh(to_trimesh(asset)), order)
    np.testing.assert_allclose(again.bounds, asset.bounds, atol=1e-6)
    assert again.mass == pytest.approx(asset.mass, rel=1e-3)
    assert len(clean(raw_from_trimesh(mesh)).parts) == 1


def test_what_trimesh_reads_and_writes_is_read_alike(tmp_path: Path) -> None:
    ring = trimesh.creation.torus(1.0, 0.2)
    ring.export(tmp_path / "ring.off")
    # The banana is cut short on purpose: it shows what a refusal looks like.
    examples = (Path(__file__).parents[4] / "examples" / "meshes").iterdir()
    kinds = (".glb", ".gltf", ".obj", ".ply", ".stl", ".dae")
    roomy = {**LIMITS, "input_texture_px": 4096.0, "input_texture_pixels": 1e7}
    for path in (tmp_path / "ring.off", *sorted(p for p in examples if p.suffix in kinds and p.stem != "banana")):
        found = differences(path, ours(path, roomy), theirs(path))
        assert [f for f in found if path.suffix != ".off" or not f.startswith("materials")] == [], path


MESH = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)
THING, ITEM = f'<object id="1">{MESH}</object>', '<item objectid="1"/>'
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
    content = f"<resources>{resources}</resources><build>{build}</build>"
    return f'{head}<model unit="{unit}" xmlns="{space}">{content}</model>'


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
        ("nested.xaml", XAML.replace("<MeshGeometry3D", "<GeometryModel3D/><MeshGeometry3D"), codes.BAD_SCENE_GRAPH),
        ("entity.xaml", '<!DOCTYPE a [<!ENTITY b "c">]>' + XAML, codes.XML_ENTITY),
        ("prefix.xaml", XAML.replace("<MeshGeometry3D", '<MeshGeometry3D s:size="1"'), codes.BAD_XML),
        ("few.xaml", XAML.replace("1,0,0", "1,0"), codes.EXCHANGE_UNREADABLE),
    ]:
        assert refusal(name, data) == code, name
    own = "<components><component objectid='1'/></components>"
    for content, code in [
        (model(THING, ITEM, head='<!DOCTYPE a [<!ENTITY b "c">]>'), codes.XML_ENTITY),
        (model(f'<object id="1">{own}</object>', ITEM), codes.BAD_SCENE_GRAPH),
        (model(THING, ITEM * 20_001), codes.BAD_SCENE_GRAPH),
        (model(f'<object id="1">{MESH}<mesh/></object>', ITEM), "SRC029"),
        (model(THING, ITEM, unit="cubits"), "SRC030"),
        (model("", ""), "SRC012"),
        ("<model>", "SRC002"),
        (model(f'<object id="1" s:size="1">{MESH}</object>', ITEM), codes.BAD_XML),
    ]:
        assert refusal("a.3mf", package(content)) == code


def test_copies_of_copies_are_counted_before_they_are_made() -> None:
    rows = [f'<object id="0">{MESH}</object>']
    for level in range(1, 40):
        twice = f'<component objectid="{level - 1}"/>' * 2
        rows.append(f'<object id="{level}"><components>{twice}</components></object>')
    assert refusal("a.3mf", package(model("".join(rows), '<item objectid="39"/>'))) == codes.BAD_SCENE_GRAPH
    ten = MESH.replace("</triangles>", '<triangle v1="0" v2="1" v3="2"/>' * 9 + "</triangles>")
    many = model(f'<object id="1">{ten}</object>', ITEM * 15_000)
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
    spoilt = bytearray(package(model(THING, ITEM)))
    spoilt[60:80] = b"\xff" * 20
    assert refusal("a.3mf", bytes(spoilt)) == codes.EXCHANGE_UNREADABLE


def test_nothing_is_fetched(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*arguments: object, **named: object) -> None:
        raise AssertionError(f"a socket was asked for: {arguments}")

    monkeypatch.setattr(socket, "socket", never)
    other = '<components><component objectid="9" path="http://example.com/a.model"/></components>'
    assert refusal("a.3mf", package(model(f'<object id="1">{other}</object>', ITEM))) == codes.NO_GEOMETRY
