"""Accepted, in review, rejected: what is in doubt is never accepted unseen, and a person has the last word."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer

from casa_assets import registry
from casa_assets.articulate.decisions import DECISIONS_NAME
from casa_assets.articulate.plan import calibrate_parts
from casa_assets.articulate.run import build as building
from casa_assets.articulate.run import steps as running
from casa_assets.articulate.run.acceptance import doubts
from casa_assets.articulate.run.build import ArticulateRequest, build, with_override
from casa_assets.articulate.run.steps import ArticulateOutcome, articulate_one
from casa_assets.cli.batch_output import end_inputs
from casa_assets.library import library as disk
from casa_assets.library import review
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.review import read_decisions
from casa_assets.model.issue import REVIEW_CODE, Decision
from casa_assets.model.registry.rows import Bars, Curve
from casa_assets.model.source import Word
from tests.unit.articulate.blocks import box, microwave, together
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)

AXES = {"up": (0.0, 0.0, 1.0), "front": (0.0, -1.0, 0.0)}


def _strict(monkeypatch: pytest.MonkeyPatch, **bars: float) -> None:
    """Make the bars such that a good guess is not sure enough."""
    model = registry.load_confidence()
    strict = model.replace(bars=Bars(**{"frame": 0.0, "plan": 0.0, "front": 0.0, **bars}))
    monkeypatch.setattr(registry, "load_confidence", lambda: strict)


def _articulate(request: ArticulateRequest) -> ArticulateOutcome:
    done = articulate_one(request)
    assert isinstance(done, ArticulateOutcome), done
    return done


def test_a_plan_below_its_bar_is_in_review_until_a_person_accepts_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _strict(monkeypatch, plan=1.0)
    request = ArticulateRequest(obj(tmp_path / "microwave.obj", *microwave()[:2]), tmp_path / "lib", **AXES)
    done = _articulate(request)
    assert done.decision is Decision.REVIEW
    assert not done.accepted
    assert done.to_decide == ("plan",)
    assert done.folder is not None
    assert done.folder.parent == tmp_path / "lib" / "microwave", "an asset in review stands where accepted ones do"
    library = disk.Library(tmp_path / "lib")
    assert review.write(library, EntryTable(library).entries) == 1
    (cells,) = review.cells(library).values()
    assert cells["look_at"] == "plan"
    assert "all parts are right" in cells["reason"]
    (entry,) = EntryTable(library).entries
    review.decide(library, entry, {"decision": "accept"})
    override = review.read_overrides(library)[entry.sha256]
    accepted = _articulate(with_override(request, override))
    assert accepted.decision is Decision.ACCEPTED
    # Without the word of the person it would be in review again, so it is kept as it is; the second time at once.
    kept = _articulate(request)
    assert (kept.kept, kept.decision, kept.folder) == (True, Decision.ACCEPTED, accepted.folder)
    assert kept.reason_kept.endswith(" is accepted, the new result is in review (plan); --force replaces it")
    assert kept.articulation == accepted.articulation
    with monkeypatch.context() as patched:
        patched.setattr(running, "build", None)
        assert _articulate(request).reason_kept == kept.reason_kept
    refused = _articulate(with_override(request, override.replace(decision=Word.REJECT)))
    assert (refused.code, refused.decision) == ("REV002", Decision.REJECTED)


def test_a_guessed_frame_below_its_bar_is_in_review_with_the_runner_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = obj(tmp_path / "microwave.obj", *microwave()[:2])
    found = build(ArticulateRequest(mesh, tmp_path)).articulation
    unsure = found.replace(frame=found.frame.replace(confidence=0.33, runner_up="front +x, up +z"))
    (issue,) = (i for i in doubts(unsure, registry.load_confidence()) if i.pointer == "frame")
    assert issue.code == REVIEW_CODE
    assert "33% sure, else front +x" in issue.message
    _strict(monkeypatch, frame=1.0)
    assert "frame" in [i.pointer for i in doubts(unsure, registry.load_confidence())]
    given = build(ArticulateRequest(mesh, tmp_path, **AXES)).articulation
    assert "frame" not in [i.pointer for i in doubts(given, registry.load_confidence())], "a person said it"


def test_nothing_is_built_behind_a_front_in_doubt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = obj(tmp_path / "microwave.obj", *microwave()[:2])
    request = ArticulateRequest(mesh, tmp_path, **AXES)
    cavities = build(request).articulation.cavities
    model = registry.load_confidence()
    monkeypatch.setattr(
        building, "calibrate_parts", lambda found, _: calibrate_parts(found, model.replace(part=_never_right()))
    )
    doubtful = build(request).articulation
    assert [c.built for c in doubtful.cavities] == [False] * len(cavities)
    for before, after in zip(cavities, doubtful.cavities, strict=True):
        assert after.in_doubt is before.built
        assert not before.built or "not built: " in after.reason


def _never_right() -> Curve:
    return Curve(given=(0.0, 1.0), right=(0.0, 0.1))


def test_the_exit_code_tells_review_from_rejection(tmp_path: Path) -> None:
    bad = ArticulateOutcome(tmp_path, code="ART001", message="no moving part found")
    with pytest.raises(typer.Exit) as ended:
        end_inputs([bad], ["bad"])
    assert ended.value.exit_code == 1
    kept = ArticulateOutcome(tmp_path, tmp_path, kept=True, reason_kept="it has 15 moving parts, the new result has 0")
    with pytest.raises(typer.Exit) as ended:
        end_inputs([kept], ["kept"])
    assert ended.value.exit_code == 4
    end_inputs([], [])


@pytest.mark.representatives(2)
@pytest.mark.parametrize(
    ("points", "faces"),
    [
        ([(1, 1, 1)] * 3, [(1, 2, 3)]),
        ([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)], [(1, 2, 3), (1, 3, 4)]),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(1, 2, 3)]),
        ([(0, 0, 0), (1, 0, 0), (1, 0, 1)], [(1, 2, 3)]),
    ],
    ids=["point", "sheet", "line", "face"],
)
def test_of_nearly_nothing_nothing_moves(
    points: list[tuple[int, int, int]], faces: list[tuple[int, int, int]], tmp_path: Path
) -> None:
    mesh = tmp_path / "oven.obj"
    rows = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a} {b} {c}" for a, b, c in faces]
    mesh.write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert _articulate(ArticulateRequest(mesh, tmp_path / "lib")).code == "ART001"


def test_a_mesh_with_signs_of_parts_of_which_none_was_found_is_in_review(tmp_path: Path) -> None:
    mesh = obj(tmp_path / "oven.obj", *together(box((0, 0, 0), (0.6, 0.6, 0.6)))[:2])
    done = _articulate(ArticulateRequest(mesh, tmp_path / "lib", preview=True))
    assert done.decision is Decision.REVIEW, done.message
    assert "plan" in done.to_decide
    assert done.folder is not None
    assert read_decisions(done.folder / DECISIONS_NAME).parts == {}
