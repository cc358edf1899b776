"""trimesh: its meshes and scenes as raw models, and what it reads of files that our readers read too."""

from __future__ import annotations

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
from casa_assets.model.source import Up
from tests.support.mesh.mesh_files import LIMITS, QUARTERS
from tests.support.mesh.mesh_readings import differences, ours, theirs
from tests.support.mesh.raw_models import brief


def box(units: str | None = None) -> trimesh.Trimesh:
    """2 x 3 x 4 units."""
    mesh = trimesh.creation.box((2, 3, 4))
    mesh.units = units
    return mesh


def square(material: PBRMaterial | SimpleMaterial) -> trimesh.Trimesh:
    """Two triangles with texture coordinates."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    visual = TextureVisuals(uv=[(0, 0), (1, 0), (1, 1), (0, 1)], material=material)
    return trimesh.Trimesh(vertices=points, faces=[(0, 1, 2), (0, 2, 3)], visual=visual, process=False)


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
    picture = Image.fromarray(QUARTERS)
    material = PBRMaterial(
        name="Paint",
        baseColorTexture=picture,
        metallicFactor=0.25,
        roughnessFactor=0.5,
        baseColorFactor=[0.5, 1, 1, 1.0],
    )
    (part,) = raw_from_trimesh(square(material)).parts
    assert part.material.id == "paint"
    assert (part.material.metallic, part.material.roughness) == (0.25, 0.5)
    assert part.material.base_color[0] == pytest.approx(0.5, abs=0.5 / 255)
    assert part.material.base_color_texture is not None
    assert (part.material.base_color_texture.width_px, part.material.base_color_texture.height_px) == (2, 2)
    assert part.mesh.uv is not None
    assert part.mesh.uv[2].tolist() == [1.0, 1.0]
    # simple colours are display values
    (part,) = raw_from_trimesh(square(SimpleMaterial(diffuse=[188, 0, 0, 255]))).parts
    assert part.material.base_color[0] == pytest.approx(0.503, abs=0.001)


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
