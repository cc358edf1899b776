"""Which material a primitive shows, and how its picture lies on it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.asset.shown_materials import ShownMaterials
from casa_assets.model.asset.asset import Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.mesh.meshes import box_mesh, texture

OPEN = np.ones(6, dtype=bool)
PAINT = Material(id="paint")
GRAIN = texture("grain", np.full((4, 8, 3), 120, dtype=np.uint8))
OAK = Material(id="oak", base_color_texture=GRAIN, tile_m=(0.5, 0.25))
GLASS = Material(id="glass", base_color=(1.0, 1.0, 1.0, 0.2))
# A panel that looks along x, at the right end of a cabinet.
PANEL: Vec3 = (0.018, 0.6, 0.7)


def shown(
    *parts: tuple[Mesh, str], middle: Vec3 = (-0.3, 0.0, 0.0), is_room: bool = False, mesh_pose: Pose | None = None
) -> ShownMaterials:
    """Of meshes with a material each."""
    visuals = [
        (Visual(name=f"v{i}", mesh=mesh, material=name), mesh_pose or Pose()) for i, (mesh, name) in enumerate(parts)
    ]
    return ShownMaterials.of(visuals, (PAINT, OAK, GLASS), np.array(middle), is_room)


def layered() -> ShownMaterials:
    """A panel of oak with a sheet of paint on its right side, each drawn as a box of its own."""
    sheet: Vec3 = (0.003, 0.6, 0.7)
    return shown((box_mesh(PANEL, (0.0, 0.0, 0.0)), "oak"), (box_mesh(sheet, (0.0105, 0.0, 0.0)), "paint"))


def material_on(found: ShownMaterials, pose: Pose | None = None, sides: npt.NDArray[np.bool_] = OPEN) -> str | None:
    """What a panel shows."""
    on = found.on(Box(size=PANEL), pose or Pose(), sides)
    return None if on is None else on.material.id


class TestMaterial:
    def test_the_outermost_layer_counts_where_it_is_not_behind_something(self) -> None:
        assert material_on(layered()) == "paint"
        assert material_on(layered(), sides=np.array([True, False, True, True, True, True])) == "oak"

    def test_a_room_is_seen_from_inside(self) -> None:
        slab: Vec3 = (4.0, 4.0, 0.02)
        parts = ((box_mesh(slab, (0.0, 0.0, -0.01)), "oak"), (box_mesh(slab, (0.0, 0.0, -0.03)), "paint"))
        floor = Box(size=(4.0, 4.0, 0.04)), Pose(position=(0.0, 0.0, -0.02)), OPEN
        found = shown(*parts, middle=(0.0, 0.0, 1.3), is_room=True).on(*floor)
        assert found is not None
        assert found.material.id == "oak"


class TestPicture:
    def lies(self, size: Vec3, pose: Pose | None = None) -> np.ndarray:
        """How the picture lies on a box in a frame in which its mesh is turned by a pose."""
        frame = pose or Pose()
        found = shown((box_mesh(size, (0.0, 0.0, 0.0)), "oak"), mesh_pose=frame, middle=(0.0, 0.0, 0.0)).on(
            Box(size=size), frame, OPEN
        )
        assert found is not None
        assert found.turn is not None
        assert np.linalg.det(found.turn) == pytest.approx(1.0)
        return found.turn

    def test_upright_on_what_stands(self) -> None:
        """Width along the side, height up, seen from outside: `box_mesh` draws it so on all sides."""
        turn = self.lies((0.6, 0.018, 0.7))
        assert abs(turn[0, 0]) == 1.0
        assert turn[2, 1] == 1.0
        assert abs(turn[1, 2]) == 1.0

    def test_along_the_grain(self) -> None:
        """The same board with its picture turned by a quarter."""
        mesh = box_mesh((2.0, 0.6, 0.04), (0.0, 0.0, 0.0))
        assert mesh.uv is not None
        turned = mesh.replace(uv=mesh.uv[:, ::-1])
        found = shown((turned, "oak"), middle=(0.0, 0.0, 0.0)).on(Box(size=(2.0, 0.6, 0.04)), Pose(), OPEN)
        assert found is not None
        assert found.turn is not None
        assert abs(found.turn[1, 0]) == 1.0
