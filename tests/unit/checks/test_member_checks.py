"""Checks of each member of a category of objects: its sides, and whether its print can be read."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.objects import FOCAL_PX, ObjectMember, PrintedLine, lines_on_surface, seen_from
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Status
from tests.support.asset.examples import LIMITS, check_examples
from tests.support.hostile.untrusted_inputs import SIZE, carton, kind_of, loose
from tests.support.mesh.meshes import texture

Build = Callable[[], ObjectMember]
# Pixels of the picture of a label, and its size on the package in metres.
HIGH, WIDE, LABEL_M = 60, 120, (0.06, 0.03)
DARK, PALE = 30, 235


def sheet(mirrored: bool = False, bent_deg: float = 0.0, size: tuple[float, float] = LABEL_M) -> Mesh:
    """A label on the front of a carton, flat or bent round an upright axis by an angle from edge to edge."""
    wide, high = size
    share = np.linspace(0.0, 1.0, 25)
    if bent_deg:
        turn = math.radians(bent_deg)
        angle, radius = (share - 0.5) * turn, wide / turn
        x, y = radius * np.sin(angle), -radius * np.cos(angle)
    else:
        x, y = (share - 0.5) * wide, np.full(25, -SIZE[1] / 2 - 0.0005)
    points = np.concatenate([np.stack([x, y, np.full(25, z)], axis=1) for z in (0.04, 0.04 + high)])
    uv = np.concatenate([np.stack([1 - share if mirrored else share, np.full(25, v)], axis=1) for v in (0.0, 1.0)])
    faces = [f for i in range(24) for f in ((i, i + 1, i + 26), (i, i + 26, i + 25))]
    return Mesh(vertices=points, faces=faces, uv=uv)


def letters(height_px: int) -> Floats:
    """(H, W) ten upright strokes of so many pixels across the middle of a picture."""
    cover = np.zeros((HIGH, WIDE))
    top = (HIGH - height_px) // 2
    for k in range(10):
        cover[top : top + height_px, 15 + 9 * k : 18 + 9 * k] = 1.0
    return cover


def package(
    height_px: int = 16, ink: int = DARK, mesh: Mesh | None = None, width: float = 1.0, runs_upwards: bool = False
) -> ObjectMember:
    cover = letters(height_px).T if runs_upwards else letters(height_px)
    grey = np.where(cover > 0.5, ink, PALE).astype(np.uint8)
    picture = texture("label", np.stack([grey] * 3, axis=2))
    look = Material(id="label", base_color=(1.0, 1.0, 1.0, 1.0), base_color_texture=picture, substance="cardboard")
    size = (width * SIZE[0], SIZE[1], SIZE[2])
    asset = loose(carton(size), boxes=((size, (0.0, 0.0, size[2] / 2)),))
    front = Visual(name="front", mesh=mesh or sheet(), material="label")
    link = asset.links[0].replace(visuals=(*asset.links[0].visuals, front))
    asset = asset.replace(links=(link,), materials=(look, *asset.materials))
    return ObjectMember(asset, kind_of(asset), {"label": (PrintedLine("ACME", cover, runs_upwards),)})


# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "OBJ001": (package, lambda: package(width=1.8)),
    "OBJ002": (package, lambda: package(mesh=sheet(size=(0.012, 0.006)))),
    "OBJ003": (package, lambda: package(height_px=5, mesh=sheet(size=(0.06, 0.06)))),
    "OBJ004": (package, lambda: package(ink=PALE - 60)),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    check_examples(code, *(run(make(), "carton", LIMITS) for make in EXAMPLES[code]))


def test_letters_have_the_size_that_they_have_on_the_package() -> None:
    (line,) = lines_on_surface(package(height_px=16))
    assert line.height_px == 16
    assert np.linalg.norm(line.up, axis=1) == pytest.approx(16 / HIGH * LABEL_M[1])
    height, unseen = seen_from(line)
    assert height == pytest.approx(FOCAL_PX * 16 / HIGH * LABEL_M[1] / 0.2, rel=0.02)
    assert unseen == 0.0
    tall = sheet(size=(LABEL_M[1], LABEL_M[0]))
    (upwards,) = lines_on_surface(package(height_px=16, mesh=tall, runs_upwards=True))
    assert upwards.height_px == 16
    assert np.linalg.norm(upwards.up, axis=1) == pytest.approx(16 / HIGH * LABEL_M[1])
    assert (upwards.up[:, 0] < 0).all(), "the head of a letter is to its left"


def test_a_mirrored_line_and_one_bent_out_of_sight_are_not_read() -> None:
    assert run(package(mesh=sheet(bent_deg=120)), "carton", LIMITS).issues == ()
    for mesh, told in ((sheet(mirrored=True), "mirrored"), (sheet(bent_deg=300), "out of sight")):
        (issue,) = run(package(mesh=mesh), "carton", LIMITS).issues
        assert (issue.code, told in issue.message) == ("OBJ002", True)


def test_of_several_copies_the_one_that_is_read_counts() -> None:
    """A lid shows its picture on its underside too, where it is mirrored."""
    one = sheet()
    assert one.uv is not None
    both = Mesh(
        vertices=np.concatenate([one.vertices + np.array((0, 0.0003, 0)), one.vertices]),
        faces=np.concatenate([one.faces[:, ::-1], one.faces + len(one.vertices)]),
        uv=np.concatenate([one.uv, one.uv]),
    )
    (line,) = lines_on_surface(package(mesh=both))
    assert line.mirrored == 0.0
    assert (line.normals[:, 1] < 0).all()


def test_what_has_no_print_is_not_held_to_it_and_sides_are_sorted_by_length() -> None:
    plain = package()
    x, y, z = plain.category.extents
    lying = ObjectMember(plain.asset, plain.category.replace(size_m=(z, x, y)), {})
    report = run(lying, "carton", LIMITS)
    assert report.issues == ()
    assert [r.status for r in report.results if r.code != "OBJ001"] == [Status.NOT_APPLICABLE] * 3
