"""A static mesh into an entry of a library: certificate, decisions, strip, review; or a reason why not."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets.articulate.decisions import Decisions, PartDecision
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.acceptance import limit_ranges
from casa_assets.articulate.run.build import ArticulateRequest, build
from casa_assets.articulate.run.steps import NAME as STRIP
from casa_assets.articulate.run.steps import ArticulateOutcome, articulate_one
from casa_assets.checks.motion.joints import joint_travels
from casa_assets.formats import mjcf
from casa_assets.library import library as disk
from casa_assets.model.source import Word
from casa_assets.runs.outcome import RunAborted
from casa_assets.show.stills.still import CELL_PX
from tests.unit.articulate.blocks import Part, box, carcass, microwave, together
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)

AXES = {"up": (0.0, 0.0, 1.0), "front": (0.0, -1.0, 0.0)}


def boxed_in() -> list[Part]:
    """A drawer with a post that stands 0.1 m before it."""
    return [
        *carcass(0.5, 0.5, 0.3),
        box((0.022, -0.0, 0.022), (0.478, 0.02, 0.278)),
        box((0.15, -0.04, 0.14), (0.35, 0.0, 0.155)),
        box((0.03, 0.02, 0.03), (0.04, 0.45, 0.2)),
        box((0.46, 0.02, 0.03), (0.47, 0.45, 0.2)),
        box((0.04, 0.02, 0.03), (0.46, 0.45, 0.04)),
        box((0.04, 0.44, 0.04), (0.46, 0.45, 0.2)),
        box((0.02, -0.16, -0.02), (0.48, -0.12, 0.28)),
        box((0.0, -0.16, -0.02), (0.5, 0.5, 0.0)),
    ]


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> ArticulateOutcome:
    """A microwave that a person accepts, with its pictures, in a library of its own."""
    folder = tmp_path_factory.mktemp("entry")
    mesh = obj(folder / "microwave.obj", *microwave()[:2])
    accept = Decisions(decision=Word.ACCEPT)
    done = articulate_one(ArticulateRequest(mesh, folder / "lib", decisions=accept, preview=True, **AXES))
    assert isinstance(done, ArticulateOutcome)
    return done


def test_an_entry_is_whole(entry: ArticulateOutcome) -> None:
    done = entry
    assert done.accepted, done.message
    assert done.folder is not None
    assert done.folder.parent.name == "microwave"
    assert done.folder.parents[1].name == "lib"
    names = {p.name for p in done.folder.iterdir()}
    assert {"asset.json", "model.xml", "usd", "preview.png", "decisions.yaml", STRIP} <= names
    certificate = disk.read_certificate(done.folder)
    assert certificate.report.passed
    assert {"MJC009", "PAR001", "USD002", "KIN009"} <= {r.code for r in certificate.report.results}
    # A runtime finds all that it looks for, and a hand moves it: the rows for that have looked at it.
    assert done.contract == disk.read_asset(done.folder).contract == "microwave"
    judged = {r.code: r.number for r in certificate.report.results if r.number is not None}
    assert {"CON001", "CON005", "BEH003", "KIN001", "HOL001"} <= set(judged)
    assert judged["KIN009"] == 1.0
    kept = disk.file_digests(done.folder)
    assert {n: kept[n] for n in certificate.files} == certificate.files
    assert disk.read_asset(done.folder).digest == certificate.asset_digest
    assert [t.is_full for t in done.travels.values()] == [True] * 6
    with Image.open(io.BytesIO((done.folder / STRIP).read_bytes())) as picture:
        # Closed, coloured, apart, and the door; knobs and buttons have no picture of their own.
        assert picture.width > 4 * CELL_PX
        assert np.asarray(picture).std() > 20


def test_what_does_not_move_and_what_cannot_be_are_told_apart(tmp_path: Path) -> None:
    mesh = obj(tmp_path / "cube.obj", *together(box((0, 0, 0), (1, 1, 1)))[:2])
    done = articulate_one(ArticulateRequest(mesh, tmp_path / "lib"))
    assert isinstance(done, ArticulateOutcome)
    assert (done.code, done.accepted) == ("ART001", False)
    assert done.folder is not None
    assert disk.read_refusal(done.folder).code == "ART001"
    decisions = articulate_one(ArticulateRequest(mesh, tmp_path / "lib", up=(0.0, 0.0, 1.0), front=(0.0, 0.0, 1.0)))
    assert isinstance(decisions, RunAborted)
    assert "not at a right angle" in decisions.message


def test_a_part_stops_where_it_runs_into_something(tmp_path: Path) -> None:
    vertices, faces, _ = together(*boxed_in())
    part = PartDecision(kind=PartKind.DRAWER, box_m=((-0.24, -0.25, 0.03), (0.24, 0.33, 0.31)), travel_m=0.3)
    decisions = Decisions(parts={"mine": part})
    mesh = obj(tmp_path / "thing.obj", vertices, faces)
    built = build(ArticulateRequest(mesh, tmp_path, size_m=0.66, decisions=decisions, **AXES))
    mine = next(p for p in built.articulation.parts if p.name == "mine")
    assert len(mine.faces)
    after = limit_ranges(built)
    joint = after.asset.joint_of("mine")
    assert joint is not None
    (way,) = (t for t in joint_travels(after.asset, mjcf.write(after.asset)) if t.joint == joint.name)
    assert way.is_full
    assert not list(tmp_path.glob("**/model.xml")), "ranges are limited in memory"
    # The handle stands 0.08 m off the post.
    assert 0.06 <= joint.range[1] <= 0.081
