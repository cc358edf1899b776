"""Mass: measured where a volume means matter, the usual one where it does not, and a tensor of a real body."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.ingest.mass import mass
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.parts import Box, Mesh, Shape
from casa_assets.model.pose import Pose
from tests.support.mesh.raw_models import category, codes, draft, flipped, joined, moved
from tests.support.mesh.solids import box

SIZE = (0.06, 0.07, 0.055)
BLOCK = box(SIZE, (0.2, 0.1, 0.03))
FULL = 0.06 * 0.07 * 0.055 * 900
FLESH = Substance(id="fruit_flesh", density=900.0, static_friction=0.6, dynamic_friction=0.5)
CLAY = Substance(id="ceramic", density=2400.0, static_friction=0.6, dynamic_friction=0.5)
SLACK = 2.0


def with_shapes(mesh: Mesh, *shapes: tuple[Shape, Pose]) -> Draft:
    return draft(mesh).replace(colliders=tuple(PlacedShape(shape=s, pose=p) for s, p in shapes))


def boxed(mesh: Mesh) -> Draft:
    low, high = mesh.bounds
    x, y, z = (high - low).tolist()
    a, b, c = ((low + high) / 2).tolist()
    return with_shapes(mesh, (Box(size=(x, y, z)), Pose(position=(a, b, c))))


def box_inertia(kg: float, x: float, y: float, z: float) -> list[float]:
    return [kg * (y * y + z * z) / 12, kg * (z * z + x * x) / 12, kg * (x * x + y * y) / 12, 0, 0, 0]


INNER = moved(box((0.04, 0.05, 0.035)), (0.2, 0.1, 0.03))
THIN = moved(box((0.056, 0.066, 0.051)), (0.2, 0.1, 0.03))
AIR = 0.04 * 0.05 * 0.035 * 900


class TestSolid:
    @pytest.mark.parametrize(
        ("mesh", "kg", "rel"),
        [
            pytest.param(BLOCK, FULL, 1e-5, id="volume times density"),
            pytest.param(Mesh(vertices=BLOCK.vertices, faces=BLOCK.faces[2:]), FULL, 0.15, id="open: its outline"),
            pytest.param(joined(BLOCK, moved(BLOCK, (0.001, 0.0, 0.0))), FULL * 61 / 60, 1e-4, id="overlaps once"),
            pytest.param(joined(BLOCK, flipped(INNER)), FULL - AIR, 1e-4, id="a wall inside is no matter"),
            pytest.param(joined(BLOCK, flipped(THIN)), FULL, 0.1, id="a shell that stands for a full thing"),
        ],
    )
    def test_mass(self, mesh: Mesh, kg: float, rel: float) -> None:
        inertial = mass(boxed(mesh), category("apple"), FLESH, SLACK).inertial
        assert inertial is not None
        assert inertial.mass == pytest.approx(kg, rel=rel)

    @pytest.mark.parametrize(("mesh", "air"), [(BLOCK, 0.0), (joined(BLOCK, flipped(INNER)), AIR)])
    def test_tensor(self, mesh: Mesh, air: float) -> None:
        inertial = mass(boxed(mesh), category("apple"), FLESH, SLACK).inertial
        assert inertial is not None
        assert inertial.center_of_mass == pytest.approx((0.2, 0.1, 0.03))
        wanted = np.subtract(box_inertia(FULL, *SIZE), box_inertia(air, 0.04, 0.05, 0.035))
        assert inertial.inertia == pytest.approx(wanted.tolist(), rel=1e-5 if not air else 1e-4, abs=1e-12)

    def test_an_implausible_volume_leaves_the_range_of_no_category(self) -> None:
        lead = FLESH.replace(density=90000.0)
        out = mass(boxed(BLOCK), category("apple"), lead, SLACK)
        span = category("apple").mass_kg
        assert out.inertial is not None
        assert span.low <= out.inertial.mass <= span.high
        assert codes(out.notes) == ["MSH021"]
        assert "matter 20.8 kg" in out.notes[0].message
        assert out.guesses[-1].confidence < 0.5


def test_shapes_that_overlap_are_united_before_they_are_weighed() -> None:
    shell = Mesh(vertices=BLOCK.vertices, faces=BLOCK.faces[2:])
    half = Pose(position=(0.2 - 0.0125, 0.1, 0.03))
    out = mass(
        with_shapes(shell, (Box(size=SIZE), Pose(position=(0.2, 0.1, 0.03))), (Box(size=(0.035, 0.07, 0.055)), half)),
        category("toaster"),
        CLAY,
        SLACK,
    ).inertial
    assert out is not None
    assert out.center_of_mass == pytest.approx((0.2, 0.1, 0.03))
    assert out.inertia == pytest.approx(box_inertia(out.mass, *SIZE), rel=1e-6, abs=1e-12)


def test_the_thinnest_bodies_have_a_tensor_that_can_be(subtests: pytest.Subtests) -> None:
    for needle in [False, True]:
        for tilt in [(1, 0, 0, 0), (0.9, 0.1, 0.2, 0.3)]:
            for thin in [1e-2, 1e-4, 1e-6]:
                with subtests.test(thin=thin, tilt=tilt, needle=needle):
                    size = (0.2, 0.2 * thin, 0.2 * thin) if needle else (0.2, 0.1, 0.2 * thin)
                    pose = Pose(quaternion=tilt)
                    mesh = moved(box(size), matrix=pose.rotation)
                    inertial = mass(with_shapes(mesh, (Box(size=size), pose)), category("fork"), CLAY, SLACK).inertial
                    assert inertial is not None
                    a, b, c = np.linalg.eigvalsh(inertial.tensor)
                    assert 0 < a <= b <= c <= a + b
                    assert c == pytest.approx(inertial.mass * (size[0] ** 2 + size[1] ** 2) / 12, rel=1e-3)
