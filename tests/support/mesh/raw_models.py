"""Raw models built in code: what the stages of ingest start from."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets import registry
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.run.steps import STAGES, BuildContext
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Issue
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category
from casa_assets.model.source import RawModel, RawPart, Source, SourceKind, Up
from tests.support.mesh.meshes import box_mesh, lathe

Floats = npt.NDArray[np.float64]

MUG = [(0.0, 0.006), (0.036, 0.006), (0.036, 0.095), (0.04, 0.095), (0.04, 0.0), (0.0, 0.0)]
BOTTLE = [(0.0, 0.25), (0.013, 0.25), (0.013, 0.2), (0.035, 0.15), (0.035, 0.0), (0.0, 0.0)]
PLATE = [(0.0, 0.004), (0.08, 0.004), (0.125, 0.022), (0.13, 0.02), (0.085, 0.0), (0.0, 0.0)]


def turned(profile: list[tuple[float, float]], steps: int = 32) -> Mesh:
    """A closed surface of revolution, outward, without uv."""
    mesh = lathe(profile, steps)
    used, faces = np.unique(mesh.faces[:, ::-1] if volume(mesh) < 0 else mesh.faces, return_inverse=True)
    return Mesh(vertices=mesh.vertices[used], faces=faces.reshape(-1, 3))


def knife() -> Mesh:
    """A blade of 20 cm on a handle, lying on its side."""
    return joined(box_mesh((0.2, 0.03, 0.002), (0.1, 0, 0), True), box_mesh((0.11, 0.025, 0.014), (-0.055, 0, 0), True))


def volume(mesh: Mesh) -> float:
    """Signed volume of a closed mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - mesh.vertices.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def joined(*meshes: Mesh) -> Mesh:
    """Positions and faces of several meshes in one."""
    starts = np.cumsum([0] + [len(m.vertices) for m in meshes])
    return Mesh(
        vertices=np.concatenate([m.vertices for m in meshes]),
        faces=np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=False)]),
    )


def moved(mesh: Mesh, offset: Vec3 = (0.0, 0.0, 0.0), scale: float = 1.0, matrix: Floats | None = None) -> Mesh:
    """The mesh scaled, turned, then moved."""
    points = mesh.vertices * scale
    return mesh.with_vertices((points if matrix is None else points @ matrix.T) + np.array(offset))


def flipped(mesh: Mesh, share: float = 1.0) -> Mesh:
    """Some or all faces turned round."""
    some = np.random.default_rng(0).random(len(mesh.faces)) < share
    return Mesh(vertices=mesh.vertices, faces=np.where(some[:, None], mesh.faces[:, ::-1], mesh.faces))


def raw(*meshes: Mesh, up: Up | None = Up.Z, unit: float | None = 1.0, form: str = "obj") -> RawModel:
    """A model of one part per mesh."""
    parts = tuple(RawPart(name=f"part_{i}", mesh=m, material=Material(id=f"m{i}")) for i, m in enumerate(meshes))
    return RawModel(parts=parts, metres_per_unit=unit, up=up, format=form)


def draft(*meshes: Mesh, up: Up | None = Up.Z, unit: float | None = 1.0, form: str = "obj") -> Draft:
    """As `raw`, for the stages after the first."""
    return Draft(parts=raw(*meshes, up=up, unit=unit, form=form).parts, metres_per_unit=unit, up=up, format=form)


def category(name: str) -> Category:
    return registry.load().category(name)


def brief(name: str, **limits: float) -> BuildContext:
    """What the stages are told of a thing of that category."""
    known = registry.load()
    kind = known.category(name)
    return BuildContext(
        asset_id=f"{name}_0123456789",
        sha256="0" * 64,
        source=Source(kind=SourceKind.FOLDER, path=f"{name}.obj"),
        category=kind,
        classes=known.classes_of(kind),
        substance=known.substances[kind.substance],
        limits={**known.limits, **limits},
    )


def codes(notes: tuple[Issue, ...]) -> list[str]:
    return [n.code for n in notes]


def built(model: RawModel, name: str) -> tuple[Asset, tuple[Issue, ...]]:
    """The whole way from a raw model to an asset. Raises Rejected."""
    result: Any = model
    for stage in STAGES[1:]:
        result = stage.function(result, brief(name))
    asset, notes = result
    return asset, notes
