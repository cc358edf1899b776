"""Our readers and trimesh see the same in the examples and in files that are made here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from tests.mesh_files import LIMITS, QUARTERS
from tests.mesh_readings import Reading, differences, ours, theirs

EXAMPLES = Path(__file__).parents[4] / "examples" / "meshes"
KINDS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".dae")
# The banana is cut short on purpose: it shows what a refusal looks like.
NAMES = sorted(p.name for p in EXAMPLES.iterdir() if p.suffix in KINDS and p.stem != "banana")
ROOMY = {**LIMITS, "input_texture_px": 4096.0, "input_texture_pixels": 1e7}


@pytest.mark.parametrize("name", NAMES)
def test_examples(name: str) -> None:
    path = EXAMPLES / name
    assert differences(path, ours(path, ROOMY), theirs(path)) == []


@pytest.mark.parametrize("kind", ["glb", "obj", "ply", "stl", "dae", "off"])
def test_what_trimesh_writes_is_read_alike(tmp_path: Path, kind: str) -> None:
    scene = trimesh.Scene()
    turn = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.1, 0, 0))
    scene.add_geometry(trimesh.creation.torus(1.0, 0.2), node_name="ring", transform=turn)
    scene.add_geometry(trimesh.creation.box((0.5, 1, 2)), node_name="block", transform=np.diag([1.0, 2.0, 3.0, 1.0]))
    whole = scene.to_mesh()
    path = tmp_path / f"made.{kind}"
    (scene if kind == "glb" else whole).export(path)
    mine = ours(path, ROOMY)
    assert len(mine.soup) == len(whole.faces)
    assert mine.area == pytest.approx(whole.area, rel=1e-4)
    found = differences(path, mine, theirs(path))
    assert [f for f in found if not f.startswith("materials")] == []


def test_a_picture_is_found_by_both(tmp_path: Path) -> None:
    picture = Image.fromarray(QUARTERS).resize((16, 8))
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    visual = TextureVisuals(uv=[(0, 0), (1, 0), (1, 1), (0, 1)], material=PBRMaterial(baseColorTexture=picture))
    trimesh.Trimesh(vertices=points, faces=[(0, 1, 2), (0, 2, 3)], visual=visual, process=False).export(
        tmp_path / "a.glb"
    )
    mine = ours(tmp_path / "a.glb", ROOMY)
    assert mine.pictures == ((16, 8),)
    assert differences(tmp_path / "a.glb", mine, theirs(tmp_path / "a.glb")) == []


def test_a_difference_is_found(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((1, 2, 3))
    mesh.export(tmp_path / "a.stl")
    right = ours(tmp_path / "a.stl", ROOMY)
    soup = right.soup.copy()
    soup[3, 0, 0] += 0.01
    assert differences(tmp_path / "a.stl", right, Reading(soup, 1, (), False, False))
    assert differences(tmp_path / "a.stl", right, Reading(right.soup[1:], 1, (), False, False))
    assert differences(tmp_path / "a.stl", right, Reading(right.soup, 1, (), True, False)) == ["has_uv: False and True"]
