"""Our readers and trimesh see the same in the examples and in files that are made here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.support.mesh.mesh_files import LIMITS
from tests.support.mesh.mesh_readings import differences, ours, theirs

EXAMPLES = Path(__file__).parents[4] / "examples" / "meshes"
KINDS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".dae")
# The banana is cut short on purpose: it shows what a refusal looks like.
NAMES = sorted(p.name for p in EXAMPLES.iterdir() if p.suffix in KINDS and p.stem != "banana")
ROOMY = {**LIMITS, "input_texture_px": 4096.0, "input_texture_pixels": 1e7}


def test_examples(subtests: pytest.Subtests) -> None:
    for name in NAMES:
        with subtests.test(name=name):
            path = EXAMPLES / name
            assert differences(path, ours(path, ROOMY), theirs(path)) == []


def test_what_trimesh_writes_is_read_alike(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for kind in ["glb", "obj", "ply", "stl", "dae", "off"]:
        with subtests.test(kind=kind):
            tmp_path = tmp_path_factory.mktemp("case")
            scene = trimesh.Scene()
            turn = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.1, 0, 0))
            scene.add_geometry(trimesh.creation.torus(1.0, 0.2), node_name="ring", transform=turn)
            scene.add_geometry(
                trimesh.creation.box((0.5, 1, 2)), node_name="block", transform=np.diag([1.0, 2.0, 3.0, 1.0])
            )
            whole = scene.to_mesh()
            path = tmp_path / f"made.{kind}"
            (scene if kind == "glb" else whole).export(path)
            mine = ours(path, ROOMY)
            assert len(mine.soup) == len(whole.faces)
            assert mine.area == pytest.approx(whole.area, rel=1e-4)
            found = differences(path, mine, theirs(path))
            assert [f for f in found if not f.startswith("materials")] == []


def test_a_scale_near_one_is_kept(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="box", transform=np.diag([1, 1, 0.999995, 1.0]))
    scene.export(tmp_path / "a.glb")
    mine, other = ours(tmp_path / "a.glb", ROOMY), theirs(tmp_path / "a.glb")
    assert np.ptp(other.bounds, axis=0) == pytest.approx(np.ptp(mine.bounds, axis=0), abs=1e-7)
    assert np.ptp(mine.bounds, axis=0).min() == pytest.approx(0.999995, abs=1e-7)
