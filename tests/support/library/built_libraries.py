"""Libraries of assets built in code, as ingest would leave them, without the time that ingest takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from casa_assets.cache.store import Store
from casa_assets.checks.library import ShapePair
from casa_assets.formats import mjcf
from casa_assets.formats.usd.document import write as write_usd
from casa_assets.library.entry_files import MadeBy, Producer, write_certificate, write_files
from casa_assets.library.library import Library
from casa_assets.library.pairs import AssetRow, measure_pair, nearby_pairs
from casa_assets.model.asset.asset import Asset, Link, Visual, split_of
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Report
from casa_assets.runs.asset_package import certificate
from tests.support.asset.asset_parts import CARDBOARD, PROVENANCE, box_collider, box_inertial, labels
from tests.support.asset.assets import ball, microwave, rigid_mug, textured_box
from tests.support.mesh.meshes import box_mesh, texture

MADE_BY = MadeBy(Producer.INGEST, "0" * 64, {"tool:numpy": "2.0"})
SLICE_SIZE = (0.12, 0.11, 0.014)
TRAIN, TEST = "00000001" * 8, "00000005" * 8  # digests of sources on either side


def flat(width: float, height: float) -> Mesh:
    """Two triangles in the plane z = 0.0145 that look up."""
    x, y = width / 2, height / 2
    corners = np.array([(-x, -y, 0.0145), (x, -y, 0.0145), (x, y, 0.0145), (-x, y, 0.0145)])
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    return Mesh(vertices=corners, faces=faces, normals=np.tile((0.0, 0.0, 1.0), (4, 1)))


def slice_of_bread(digest: str = TRAIN) -> Asset:
    """It lies, and has a flat print on top."""
    center = (0.0, 0.0, SLICE_SIZE[2] / 2)
    return Asset(
        id=f"sandwich_bread_{digest[:10]}",
        links=(
            Link(
                name="object",
                inertial=box_inertial(0.04, SLICE_SIZE, center),
                visuals=(
                    Visual(name="crumb", mesh=box_mesh(SLICE_SIZE, center), material="crumb"),
                    Visual(name="print", mesh=flat(0.03, 0.02), material="ink"),
                ),
                colliders=(box_collider("crumb_0", SLICE_SIZE, center),),
            ),
        ),
        materials=(Material(id="crumb"), Material(id="ink", base_color=(0.1, 0.0, 0.0, 1.0))),
        substances=(CARDBOARD,),
        labels=labels("sandwich_bread", ("sandwich_bread", "bakery", "food"), "Q7802").replace(split=split_of(digest)),
        provenance=PROVENANCE.replace(sha256=digest),
    )


def loose_and_fixed() -> tuple[Asset, ...]:
    """A mug, an orange, a carton and two slices of bread (one to train, one to test with); and a microwave."""
    plain = [slice_of_bread(TRAIN), slice_of_bread(TEST), rigid_mug(), ball(), textured_box()]
    return (*plain, microwave().replace(contract="microwave"))


def keep(root: Path, assets: Sequence[Asset]) -> Path:
    """A library at `root` that holds these, as checked; returns the root."""
    library = Library(root)
    picture = texture("picture", np.zeros((8, 8, 3), dtype=np.uint8)).png
    with library.locked():
        for asset in assets:
            staged = library.stage(asset.id)
            write_files(staged, mjcf.write(asset))
            write_files(staged, write_usd(asset, picture))
            (staged / "preview.png").write_bytes(picture)
            certified = certificate(asset, Report(subject=asset.id), staged, MADE_BY)
            write_certificate(staged, asset, certified)
            library.publish(staged, library.folder(asset.labels.category, asset.id))
        library.sweep()
    return root


def similar_pairs(rows: Sequence[AssetRow], store: Store) -> Iterator[ShapePair]:
    """Every pair of assets with similar shape descriptors, measured, in the order of the rows."""
    shaped = [(row, row.signature.shape) for row in rows if row.signature is not None]
    for i, j in nearby_pairs([shape for _, shape in shaped]):
        yield measure_pair(shaped[i][0], shaped[j][0], store)
