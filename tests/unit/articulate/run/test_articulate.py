"""A static mesh into an entry of a library: accepted, in review or rejected; what is mended.

What somebody says in a sidecar goes before the guesses; what repeats them changes nothing.
"""

from __future__ import annotations

import dataclasses
import io
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.articulate.decisions import DECISIONS_NAME, CavityDecision, Decisions, PartDecision
from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, calibrate_parts
from casa_assets.articulate.run import acceptance
from casa_assets.articulate.run import build as building
from casa_assets.articulate.run import steps as running
from casa_assets.articulate.run.build import (
    NAMING_CONFIDENCE,
    ArticulateRequest,
    ArticulateResult,
    build,
    guess_category,
    with_override,
)
from casa_assets.articulate.run.steps import NAME as STRIP
from casa_assets.articulate.run.steps import ArticulateOutcome, articulate_one
from casa_assets.checks.motion.joints import joint_travels
from casa_assets.errors import RegistryError, Rejected, UnknownId
from casa_assets.formats import mjcf
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.places import Found
from casa_assets.library import review
from casa_assets.library.clip import NO_WEIGHTS
from casa_assets.library.entry_files import file_digests, read_asset, read_certificate, read_refusal
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.mesh_decisions import read_decisions
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.issue import REVIEW_CODE, Decision, Issue, Report, Severity
from casa_assets.model.record import Vec3
from casa_assets.model.registry.rows import Bars, Curve
from casa_assets.model.source import Word
from casa_assets.runs.outcome import RunAborted
from casa_assets.show.stills.still import CELL_PX
from tests.support.asset.asset_parts import box_collider
from tests.support.asset.assets import category
from tests.support.asset.contract_fixtures import hob, oven
from tests.support.asset.cupboard import cupboard
from tests.support.asset.packages import packed
from tests.unit.articulate.blocks import Part, box, carcass, drawers, found_on, microwave, together
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)

AXES = {"up": (0.0, 0.0, 1.0), "front": (0.0, -1.0, 0.0)}


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return obj(tmp_path_factory.mktemp("mesh") / "microwave.obj", *microwave()[:2])


def _articulate(request: ArticulateRequest) -> ArticulateOutcome:
    done = articulate_one(request)
    assert isinstance(done, ArticulateOutcome), done
    return done


def test_an_entry_is_whole(mesh: Path, tmp_path: Path) -> None:
    accept = Decisions(decision=Word.ACCEPT)
    done = _articulate(ArticulateRequest(mesh, tmp_path / "lib", decisions=accept, preview=True, **AXES))
    assert done.accepted, done.message
    assert done.folder.parent.name == "microwave"
    assert done.folder.parents[1].name == "lib"
    names = {p.name for p in done.folder.iterdir()}
    assert {"asset.json", "model.xml", "usd", "preview.png", "decisions.yaml", STRIP} <= names
    certificate = read_certificate(done.folder)
    assert certificate.report.passed
    assert {"MJC009", "PAR001", "USD002", "KIN009"} <= {r.code for r in certificate.report.results}
    # A runtime finds all that it looks for, and a hand moves it: the rows for that have looked at it.
    assert done.contract == read_asset(done.folder).contract == "microwave"
    judged = {r.code: r.number for r in certificate.report.results if r.number is not None}
    assert {"CON001", "CON005", "BEH003", "KIN001", "HOL001"} <= set(judged)
    assert judged["KIN009"] == 1.0
    kept = file_digests(done.folder)
    assert {n: kept[n] for n in certificate.files} == certificate.files
    assert read_asset(done.folder).digest == certificate.asset_digest
    assert [t.is_full for t in done.travels.values()] == [True] * 6
    with Image.open(io.BytesIO((done.folder / STRIP).read_bytes())) as picture:
        # Closed, coloured, apart, and the door; knobs and buttons have no picture of their own.
        assert picture.width > 4 * CELL_PX
        assert np.asarray(picture).std() > 20


def test_what_does_not_move_and_what_cannot_be_are_told_apart(tmp_path: Path) -> None:
    mesh = obj(tmp_path / "cube.obj", *together(box((0, 0, 0), (1, 1, 1)))[:2])
    done = _articulate(ArticulateRequest(mesh, tmp_path / "lib"))
    assert (done.code, done.accepted) == ("ART001", False)
    assert read_refusal(done.folder).code == "ART001"
    decisions = articulate_one(ArticulateRequest(mesh, tmp_path / "lib", up=(0.0, 0.0, 1.0), front=(0.0, 0.0, 1.0)))
    assert isinstance(decisions, RunAborted)
    assert "not at a right angle" in decisions.message


def test_a_part_stops_where_it_runs_into_something(tmp_path: Path) -> None:
    # A drawer with a post that stands 0.1 m before it.
    front = [box((0.022, -0.0, 0.022), (0.478, 0.02, 0.278)), box((0.15, -0.04, 0.14), (0.35, 0.0, 0.155))]
    tub = [box((x, 0.02, 0.03), (x + 0.01, 0.45, 0.2)) for x in (0.03, 0.46)]
    tub += [box((0.04, 0.02, 0.03), (0.46, 0.45, 0.04)), box((0.04, 0.44, 0.04), (0.46, 0.45, 0.2))]
    post = [box((0.02, -0.16, -0.02), (0.48, -0.12, 0.28)), box((0.0, -0.16, -0.02), (0.5, 0.5, 0.0))]
    vertices, faces, _ = together(*carcass(0.5, 0.5, 0.3), *front, *tub, *post)
    part = PartDecision(kind=PartKind.DRAWER, box_m=((-0.24, -0.25, 0.03), (0.24, 0.33, 0.31)), travel_m=0.3)
    decisions = Decisions(parts={"mine": part})
    mesh = obj(tmp_path / "thing.obj", vertices, faces)
    built = build(ArticulateRequest(mesh, tmp_path, size_m=0.66, decisions=decisions, **AXES))
    mine = next(p for p in built.articulation.parts if p.name == "mine")
    assert len(mine.faces)
    after = acceptance.limit_ranges(built)
    joint = after.asset.joint_of("mine")
    (way,) = (t for t in joint_travels(after.asset, mjcf.write(after.asset)) if t.joint == joint.name)
    assert way.is_full
    assert not list(tmp_path.glob("**/model.xml")), "ranges are limited in memory"
    # The handle stands 0.08 m off the post, and poses are tried 6 mm apart.
    assert 0.073 <= joint.range[1] <= 0.081


def _complaint(code: str, pointer: str) -> Report:
    return Report(subject="a", issues=(Issue(code=code, severity=Severity.ERROR, pointer=pointer, message="m"),))


def test_shapes_that_do_not_fit_are_fitted_again(mesh: Path) -> None:
    built = made(mesh, Decisions())
    named = built.with_runtime_names()
    mended = acceptance.mend(built, named, _complaint("AST009", "links/door/colliders"))
    assert mended.spec.refit == {"door_0"}
    shapes = {link.name: link.colliders for link in built.asset.links}
    assert [k.name for k in mended.asset.links if k.colliders != shapes[k.name]] in (["door_0"], ["object", "door_0"])
    again = acceptance.mend(mended, mended.with_runtime_names(), _complaint("AST009", "links/door/colliders"))
    assert again is None, "what was fitted again is not fitted once more"
    assert acceptance.mend(built, named, _complaint("AST002", "links/door")) is None


def test_all_pairs_of_parts_that_are_in_each_other_are_left_out_of_contact(mesh: Path) -> None:
    """Of each joint the deepest contact is found, and the next one once that is left out."""
    post = box_collider("post", (0.1, 0.1, 0.3), (0.0, -0.25, 0.41))  # of the body, in the door and in the drawer
    flap = box_collider("flap", (0.1, 0.01, 0.1), (0.2, -0.215, 0.38))  # of the drawer, in the door
    more = {"object": (post,), "drawer": (flap,)}
    links = (k.replace(colliders=(*k.colliders, *more.get(k.name, ()))) for k in cupboard().links)
    built = dataclasses.replace(made(mesh, Decisions()), asset=cupboard().replace(links=tuple(links)))
    mended = acceptance.mend(built, built, _complaint("MJC009", "joints/drawer_slide"))
    assert mended is not None
    pairs = {frozenset((pair.first, pair.second)) for pair in mended.asset.exclusions}
    assert pairs == {frozenset(pair) for pair in (("object", "door"), ("object", "drawer"), ("door", "drawer"))}


def _crossing_drawers() -> list[Part]:
    """Two drawers side by side, and a bar on the left one that reaches before the right one."""
    fronts = [box((x, -0.02, 0.03), (x + 0.36, 0.0, 0.27)) for x in (0.03, 0.41)]
    floors = [box((x, 0.0, 0.03), (x + 0.36, 0.4, 0.04)) for x in (0.03, 0.41)]
    bar = [box((0.3, -0.08, 0.12), (0.6, -0.06, 0.18)), box((0.3, -0.06, 0.14), (0.32, -0.02, 0.16))]
    return [*carcass(0.8, 0.5, 0.3), *fronts, *floors, *bar]


# A bar of one drawer before the other; and a post of the body 20 mm before a drawer that is to open by 300 mm.
EACH_OTHER = {"left": ((-0.38, -0.36, 0.0), (0.21, 0.3, 0.3)), "right": ((0.005, -0.28, 0.0), (0.38, 0.3, 0.3))}
POST = [*_crossing_drawers()[:9], box((0.1, -0.08, 0.0), (0.3, -0.06, 0.3))]
IN_THE_WAY = ((_crossing_drawers(), EACH_OTHER), (POST, {"left": ((-0.38, -0.26, 0.0), (0.0, 0.3, 0.3))}))


@pytest.mark.parametrize(("parts", "boxes"), IN_THE_WAY, ids=["each other", "the body"])
def test_colliding_parts_are_reviewed(tmp_path: Path, parts: list[Part], boxes: dict[str, tuple[Vec3, Vec3]]) -> None:
    decided = {name: PartDecision(kind=PartKind.DRAWER, box_m=corners, travel_m=0.3) for name, corners in boxes.items()}
    mesh, kind = obj(tmp_path / "cabinet.obj", *together(*parts)[:2]), "base_cabinet"
    request = ArticulateRequest(mesh, tmp_path / "lib", kind, size_m=0.8, decisions=Decisions(parts=decided), **AXES)
    done = _articulate(dataclasses.replace(request, complete=False))
    assert done.decision is Decision.REVIEW, done.message
    if len(boxes) == 2:
        assert done.to_decide == ("contacts",), done.message
    else:
        (issue,) = (i for i in done.report.issues if i.pointer == "contacts")
        assert "of its range, then runs into object" in issue.message


def _strict(monkeypatch: pytest.MonkeyPatch, **bars: float) -> None:
    """Make the bars such that a good guess is not sure enough."""
    model = registry.load_confidence()
    strict = model.replace(bars=Bars(**{"frame": 0.0, "plan": 0.0, "front": 0.0, **bars}))
    monkeypatch.setattr(registry, "load_confidence", lambda: strict)


def test_a_plan_below_its_bar_is_reviewed(mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _strict(monkeypatch, plan=1.0)
    request = ArticulateRequest(mesh, tmp_path / "lib", **AXES)
    done = _articulate(request)
    assert done.decision is Decision.REVIEW
    assert not done.accepted
    assert done.to_decide == ("plan",)
    assert done.folder.parent == tmp_path / "lib" / "microwave", "an asset in review stands where accepted ones do"
    library = Library(tmp_path / "lib")
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


def test_a_guessed_frame_below_its_bar_is_reviewed(mesh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = build(ArticulateRequest(mesh, mesh.parent)).articulation
    unsure = found.replace(frame=found.frame.replace(confidence=0.33, runner_up="front +x, up +z"))
    (issue,) = (i for i in acceptance.doubts(unsure, registry.load_confidence()) if i.pointer == "frame")
    assert issue.code == REVIEW_CODE
    assert "33% sure, else front +x" in issue.message
    _strict(monkeypatch, frame=1.0)
    assert "frame" in [i.pointer for i in acceptance.doubts(unsure, registry.load_confidence())]
    given = made(mesh, Decisions()).articulation
    assert "frame" not in [i.pointer for i in acceptance.doubts(given, registry.load_confidence())], "a person said it"


def test_nothing_is_built_behind_a_front_in_doubt(mesh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cavities = made(mesh, Decisions()).articulation.cavities
    model, never = registry.load_confidence(), Curve(given=(0.0, 1.0), right=(0.0, 0.1))
    monkeypatch.setattr(building, "calibrate_parts", lambda found, _: calibrate_parts(found, model.replace(part=never)))
    doubtful = made(mesh, Decisions()).articulation
    assert [c.built for c in doubtful.cavities] == [False] * len(cavities)
    for before, after in zip(cavities, doubtful.cavities, strict=True):
        assert after.in_doubt is before.built
        assert not before.built or "not built: " in after.reason


NEARLY_NOTHING = {
    "point": [(1, 1, 1)] * 3,
    "sheet": [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
    "line": [(0, 0, 0), (1, 0, 0), (2, 0, 0)],
    "face": [(0, 0, 0), (1, 0, 0), (1, 0, 1)],
}


@pytest.mark.representatives(2)
@pytest.mark.parametrize("name", NEARLY_NOTHING)
def test_of_nearly_nothing_nothing_moves(name: str, tmp_path: Path) -> None:
    points = np.array(NEARLY_NOTHING[name], dtype=np.float64)
    mesh = obj(tmp_path / "oven.obj", points, np.array([(0, 1, 2), (0, 2, 3)][: len(points) - 2]))
    assert _articulate(ArticulateRequest(mesh, tmp_path / "lib")).code == "ART001"


def test_a_mesh_with_signs_of_parts_of_which_none_was_found_is_in_review(tmp_path: Path) -> None:
    mesh = obj(tmp_path / "oven.obj", *together(box((0, 0, 0), (0.6, 0.6, 0.6)))[:2])
    done = _articulate(ArticulateRequest(mesh, tmp_path / "lib", preview=True))
    assert done.decision is Decision.REVIEW, done.message
    assert "plan" in done.to_decide
    assert read_decisions(done.folder / DECISIONS_NAME).parts == {}


def found_at(folder: Path, name: str) -> Found:
    (found,) = discover([obj(folder / name, *drawers()[:2])])
    assert isinstance(found, Found)
    return found


@pytest.fixture(scope="module")
def chest() -> tuple[Vec3, Articulation]:
    vertices, faces, _ = drawers()
    x, y, z = (float(v) for v in np.ptp(vertices, axis=0))
    return (x, y, z), found_on(vertices, faces)


def test_the_user_goes_before_a_look_a_name_and_the_shape(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    def toaster() -> tuple[str, float, str]:
        return "toaster", 0.8, "CLIP says a toaster"

    def nothing() -> tuple[str, float, str]:
        return "", 0.2, "CLIP says a kettle at 20%, which names nothing"

    fridge, unnamed = found_at(tmp_path, "fridge.obj"), found_at(tmp_path, "mesh_0042.obj")
    kind = guess_category(fridge, *chest, stated="dishwasher", classify_by_image=toaster)
    assert (kind.id, kind.confidence) == ("dishwasher", 1.0)
    with pytest.raises(UnknownId):
        guess_category(fridge, *chest, stated="spaceship")
    kind = guess_category(fridge, *chest, classify_by_image=toaster)
    assert (kind.id, kind.confidence, kind.reason) == ("toaster", 0.8, "CLIP says a toaster")
    for seen in (None, nothing):
        named = guess_category(fridge, *chest, classify_by_image=seen)
        assert (named.id, named.reason[:11]) == ("refrigerator", "by its name")
    assert named.confidence >= NAMING_CONFIDENCE
    assert guess_category(fridge, *chest, stated="refrigerator") == guess_category(fridge, *chest), "it stays a guess"
    kind = guess_category(unnamed, *chest)
    assert kind.id == "drawer_stack"
    assert 0.2 < kind.confidence <= 0.6
    assert "by its shape and parts" in kind.reason
    assert NO_WEIGHTS in kind.reason
    assert "names nothing" in guess_category(unnamed, *chest, classify_by_image=nothing).reason


def faults(asset: Asset, folder: Path) -> tuple[str, ...]:
    known, root = registry.load(), packed(asset, folder).root
    return acceptance.unmet_checks(asset, category(asset), root, known.contracts.get(asset.contract), known.limits)


def test_an_asset_lacks_nothing_of_its_contract_or_says_what(tmp_path: Path) -> None:
    assert faults(hob(), tmp_path / "whole") == ()
    renamed = tuple(c.replace(name="key") if c.name == "start_button" else c for c in oven().root.colliders)
    nameless = oven().replace(links=(oven().root.replace(colliders=renamed), *oven().links[1:]), behavior=None)
    assert any(f.startswith("CON003 colliders/start_button") for f in faults(nameless, tmp_path / "nameless"))
    stiff = hob().replace(joints=tuple(j.replace(damping=500.0) for j in hob().joints))
    found = faults(stiff, tmp_path / "stiff")
    assert found
    assert all(f.startswith("KIN") for f in found), "what does not move is said once the names are right"
    many = tuple(f"CON001 joints/k{i}: is not there" for i in range(acceptance.MAX_LISTED_FAULTS + 2))
    asset = acceptance.without_contract(hob(), many)
    guess = asset.provenance.guesses[-1]
    assert (asset.contract, guess.subject, guess.value) == (None, "contract", "not stovetop")
    assert guess.reason.endswith("and 2 more")


def made(mesh: Path, decisions: Decisions) -> ArticulateResult:
    """The microwave with decisions, axes given."""
    return build(ArticulateRequest(mesh, mesh.parent, decisions=decisions, **AXES))


def one(name: str, decision: PartDecision) -> Decisions:
    return Decisions(parts={name: decision})


def test_a_hinge_is_fixed_in_a_line(mesh: Path) -> None:
    built = made(mesh, one("door_0", PartDecision(hinge=HingeEdge.BOTTOM)))
    assert built.asset.joint_of("door_0").axis == pytest.approx((1.0, 0.0, 0.0))
    at = built.asset.asset_from_link("door_0").position
    assert at[2] == pytest.approx(0.0, abs=1e-6)
    door = next(p for p in built.articulation.parts if p.name == "door_0")
    assert door.joint.edge is HingeEdge.BOTTOM
    assert door.joint.confidence == 1.0


MANY = Decisions(
    decision=Word.ACCEPT,
    parts={
        "door_0": PartDecision(flip=True),
        "knob_0": PartDecision(remove=True),
        "button_0": PartDecision(merge="button_1"),
        "mine": PartDecision(kind=PartKind.LEVER, box_m=((0.15, -0.3, 0.15), (0.19, -0.14, 0.19)), axis="-y"),
    },
)


@pytest.mark.parametrize("decisions", [Decisions(), MANY], ids=["none", "many"])
def test_a_sidecar_repeats_what_was_decided(mesh: Path, tmp_path: Path, decisions: Decisions) -> None:
    first = build(ArticulateRequest(mesh, tmp_path, decisions=decisions))
    path = tmp_path / "d.yaml"
    path.write_text(first.decisions_text(decisions), encoding="utf-8")
    again = build(ArticulateRequest(mesh, tmp_path, decisions=read_decisions(path)))
    assert again.asset.digest == first.asset.digest


def test_a_part_that_is_a_piece_of_another_moves_with_it(mesh: Path) -> None:
    plain, bare = made(mesh, Decisions()), made(mesh, one("knob_0", PartDecision(remove=True)))
    assert [k.name for k in bare.asset.links] == [k.name for k in plain.asset.links if k.name != "knob_0"]
    faces = [sum(len(v.mesh.faces) for k in b.asset.links for v in k.visuals) for b in (plain, bare)]
    assert faces[0] == faces[1], "what is removed stays with the body"
    before = {p.name: p for p in plain.articulation.parts}
    decisions = Decisions(parts={"knob_0": PartDecision(merge="button_0"), "button_0": PartDecision(merge="button_1")})
    parts = {p.name: p for p in made(mesh, decisions).articulation.parts}
    assert before.keys() - parts.keys() == {"knob_0", "button_0"}
    pieces = [before[name].faces for name in ("knob_0", "button_0", "button_1")]
    assert parts["button_1"].faces.tolist() == sorted(np.concatenate(pieces).tolist())
    assert parts["button_1"].joint == before["button_1"].joint
    circle = Decisions(parts={"knob_0": PartDecision(merge="door_0"), "door_0": PartDecision(merge="knob_0")})
    with pytest.raises(Rejected, match="circle"):
        made(mesh, circle)


def test_a_part_that_was_missed_is_given_by_a_box(mesh: Path) -> None:
    # The knob, as a lever of its own name; asset frame: origin under the middle, 0.05 m of handle in front.
    knob = next(p for p in made(mesh, Decisions()).articulation.parts if p.kind is PartKind.KNOB)
    corners = ((0.15, -0.3, 0.03), (0.23, -0.14, 0.11))
    built = made(mesh, one("my_lever", PartDecision(kind=PartKind.LEVER, box_m=corners, axis="-y", opens_deg=40)))
    lever = next(p for p in built.articulation.parts if p.name == "my_lever")
    assert lever.faces.tolist() == knob.faces.tolist()
    assert all(p.kind is not PartKind.KNOB for p in built.articulation.parts)
    joint = built.asset.joint_of("my_lever")
    assert joint.axis == (0.0, -1.0, 0.0)
    assert joint.range[1] == pytest.approx(math.radians(40), abs=1e-5)


def test_kind_range_and_carrier_are_changed(mesh: Path) -> None:
    decisions = Decisions(
        parts={
            "door_0": PartDecision(kind=PartKind.DRAWER, travel_m=0.2),
            "knob_0": PartDecision(endless=False, opens_deg=270, on="door_0"),
        }
    )
    built = made(mesh, decisions)
    door, knob = (built.asset.joint_of(name) for name in ("door_0", "knob_0"))
    assert door.kind is JointKind.SLIDE
    assert door.axis == (0.0, -1.0, 0.0)
    assert door.range == pytest.approx((0.0, 0.2))
    assert knob.range[1] == pytest.approx(math.radians(270), abs=1e-5)
    assert built.asset.link("knob_0").parent == "door_0"
    x, _, z = built.asset.asset_from_link("knob_0").position
    assert (x, z) == pytest.approx((0.19, 0.07), abs=0.01), "it stays where it is"


def test_a_mesh_is_rejected_by_a_person_or_where_decisions_do_not_fit_it_or_name_nothing(mesh: Path) -> None:
    unfit = Decisions(cavities={"drawer_9": CavityDecision(build=True)}), Decisions(front="+z")
    for code, decisions in (("REV002", Decisions(decision=Word.REJECT)), *(("ART002", one) for one in unfit)):
        with pytest.raises(Rejected) as caught:
            build(ArticulateRequest(mesh, mesh.parent, up=(0.0, 0.0, 1.0), decisions=decisions))
        assert caught.value.code == code
    with pytest.raises(Rejected, match="did you mean door_0"):
        made(mesh, one("door_9", PartDecision(hinge=HingeEdge.LEFT)))
    with pytest.raises(Rejected, match="nobody"):
        made(mesh, one("door_0", PartDecision(on="nobody")))


def test_a_fault_in_the_file_has_a_line(tmp_path: Path) -> None:
    path = tmp_path / "d.yaml"
    path.write_text("parts:\n  door_0:\n    hinge: middle\n", encoding="utf-8")
    with pytest.raises(RegistryError, match=r"d.yaml:3: parts.door_0.hinge"):
        read_decisions(path)
    path.write_text("up: sideways\n", encoding="utf-8")
    with pytest.raises(RegistryError, match="sideways"):
        read_decisions(path)
