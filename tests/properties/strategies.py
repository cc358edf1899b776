"""What hypothesis draws from: poses, point clouds, closed meshes; and the settings that keep this folder quick."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.model.pose import Pose

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

quick = settings(
    max_examples=25, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
seeds = st.integers(0, 10**6)
lengths = st.floats(1e-3, 10.0)


@st.composite
def quaternions(draw: st.DrawFn) -> tuple[float, float, float, float]:
    numbers = st.floats(-1, 1)
    w, x, y, z = draw(st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 1e-3))
    return (w, x, y, z)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    meters = st.floats(-10, 10)
    return Pose(position=draw(st.tuples(meters, meters, meters)), quaternion=draw(quaternions()))


def turn(seed: int) -> Floats:
    """A (3, 3) rotation."""
    matrix: Floats = Rotation.random(random_state=seed).as_matrix()
    return matrix


def cloud(seed: int, count: int) -> Floats:
    """(count, 3) points of uneven spread."""
    draw = np.random.default_rng(seed)
    spread: Floats = draw.normal(size=(count, 3)) * draw.uniform(0.1, 2.0, 3) @ turn(seed).T + draw.normal(size=3)
    return spread


def closed(seed: int, count: int = 24) -> tuple[Floats, Ints]:
    """A closed, outward, convex surface."""
    return convex_hull(cloud(seed, count))


def torus(around: int = 24, across: int = 12, ring: float = 0.1, tube: float = 0.03) -> tuple[Floats, Ints]:
    """A closed, outward surface with a hole."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = u * 2 * np.pi / around, v * 2 * np.pi / across
    reach = ring + tube * np.cos(b)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3)
    here, next_u = u * across + v, (u + 1) % around * across + v
    next_v, both = u * across + (v + 1) % across, (u + 1) % around * across + (v + 1) % across
    faces = np.concatenate(
        [np.stack([here, next_u, both], axis=-1).reshape(-1, 3), np.stack([here, both, next_v], axis=-1).reshape(-1, 3)]
    )
    return points, faces
