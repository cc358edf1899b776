"""Links that are sheets, rods or nothing at all: each gets a shape that MuJoCo loads, or is no link."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.articulate.assemble import drop_empty_links
from casa_assets.articulate.link_shapes import MIN_THICKNESS_M, fit_shape
from casa_assets.articulate.plan import Articulation, Frame, JointPlan, PartKind, PartPlan
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_triangles
from casa_assets.model.asset.parts import Hull, JointKind
from tests.unit.articulate.blocks import Floats, box, together


def _disc(radius: float) -> Floats:
    """A flat disc that is tilted against all axes, as single precision holds it."""
    angle = np.arange(24) / 24 * 2 * np.pi
    flat = np.stack([np.cos(angle) * radius, np.sin(angle) * radius, 0 * angle], axis=1)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return (flat @ turn).astype(np.float32).astype(np.float64)


def test_a_tilted_sheet_has_a_shape_with_a_volume(subtests: pytest.Subtests) -> None:
    for cloud in [_disc(0.3), _disc(0.0005), _disc(0.3)[:2], _disc(0.3)[:1]]:
        with subtests.test(cloud=cloud):
            shape, pose = fit_shape(cloud + 0.2)
            assert isinstance(shape, Hull)
            vertices = " ".join(f"{v:.9g}" for v in shape.mesh.vertices.ravel())
            model = mujoco.MjModel.from_xml_string(
                f'<mujoco><asset><mesh name="m" vertex="{vertices}"/></asset>'
                '<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
            )
            assert model.ngeom == 1
            placed = shape.mesh.vertices + np.array(pose.position)
            beyond = np.maximum(
                placed.max(axis=0) - (cloud + 0.2).max(axis=0), (cloud + 0.2).min(axis=0) - placed.min(axis=0)
            )
            assert beyond.max() <= MIN_THICKNESS_M / 2 * np.sqrt(3) + 1e-6


def _part(name: str, faces: list[int], parent: str = "") -> PartPlan:
    rows = np.array(faces, dtype=np.int64)
    joint = JointPlan(kind=JointKind.HINGE, axis=(0, 0, 1), anchor=(0, 0, 0), range=(0, 1))
    return PartPlan(name=name, kind=PartKind.DOOR, parent=parent, faces=rows, grip=rows[:0], joint=joint)


def _plan(*parts: PartPlan) -> tuple[Articulation, WeldedMesh]:
    vertices, faces, _ = together(box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 3, 3)))
    frame = Frame(rotation=np.eye(3), origin=(0, 0, 0), scale=1.0)
    return Articulation(frame=frame, parts=parts), weld_triangles(vertices, faces)


def test_a_part_without_faces_is_no_part_and_what_it_carried_stays() -> None:
    plan, mesh = _plan(_part("a", [0, 1]), _part("b", [], "a"), _part("c", [2, 3], "b"))
    kept = drop_empty_links(plan, mesh).parts
    assert [(p.name, p.parent) for p in kept] == [("a", ""), ("c", "a")]


def test_where_parts_take_all_faces_the_largest_is_the_body() -> None:
    plan, mesh = _plan(_part("small", list(range(12))), _part("large", list(range(12, 24))))
    assert [p.name for p in drop_empty_links(plan, mesh).parts] == ["small"]
    plan, mesh = _plan(_part("all", list(range(24))))
    assert drop_empty_links(plan, mesh).parts == ()


def test_a_face_belongs_to_one_part() -> None:
    plan, mesh = _plan(_part("a", [0, 1, 2]), _part("b", [1, 2, 3]), _part("same", [4, 5]), _part("twin", [4, 5]))
    kept = drop_empty_links(plan, mesh).parts
    assert [(p.name, p.faces.tolist()) for p in kept] == [("a", [0]), ("b", [1, 2, 3]), ("twin", [4, 5])]
