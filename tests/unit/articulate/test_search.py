"""A mesh is followed to plans in several frames, ways and kinds; each is measured, and the best is chosen."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.frame import likely_frames
from casa_assets.articulate.infer import KindHypothesis, articulate_by_kind
from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PlanModels, hinge
from casa_assets.articulate.run.build import load_models, load_plan_models
from casa_assets.articulate.search.choose import choose_plan, frame_confidences
from casa_assets.articulate.search.plan_features import (
    PART_FEATURES,
    PLAN_FEATURES,
    PlanMeasures,
    measure_plans,
    whole_features,
)
from casa_assets.articulate.search.plans import Plan, follow_plans
from casa_assets.articulate.segment.fragments import measure_fragments, weld_triangles
from casa_assets.articulate.segment.segmentations import (
    Segmentation,
    find_flat_sheets,
    joined_small_pieces,
)
from casa_assets.articulate.segment.shell_segments import NO_FRONTS
from casa_assets.core.numeric import Forest, forest_from_dict
from tests.unit.articulate.blocks import (
    Ints,
    box,
    carcass,
    drawers,
    fragments_of,
    in_its_frame,
    microwave,
    plan_of,
    slides,
    together,
)

pytestmark = pytest.mark.content("code", "articulate", keep=0)


def plan_with(*parts: tuple[str, PartKind, Ints, object], way: Segmentation = Segmentation.WELDED) -> Plan:
    """A plan of the drawers whose parts are these: name, kind, numbers of solids, joint."""
    mesh, frame = in_its_frame(*drawers()[:2])
    owner = drawers()[2]
    plans = tuple(plan_of(n, kind, np.flatnonzero(np.isin(owner, solids)), joint) for n, kind, solids, joint in parts)
    fragmentation = fragments_of(mesh)
    measured = measure_fragments(mesh, fragmentation.labels)
    return Plan(frame, way, fragmentation, measured, KindHypothesis(Articulation(frame=frame, parts=plans)))


def values(measures: PlanMeasures, name: str) -> list[float]:
    return [float(v) for v in measures.parts[:, PART_FEATURES.index(name)]]


def test_a_drawer_with_its_box_is_free_and_a_front_that_turns_into_its_box_is_blocked() -> None:
    upper, lower = np.arange(5, 11), np.arange(11, 17)
    out = slides((0.0, -0.2, 0.1))
    free = plan_with(("drawer_0", PartKind.DRAWER, upper, out), ("drawer_1", PartKind.DRAWER, lower, out))
    # The whole drawer turned about a line through its middle sweeps through the walls beside it.
    turning = hinge((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.5)).replace(edge=HingeEdge.LEFT)
    stuck = plan_with(("door_0", PartKind.DOOR, upper, turning), ("drawer_0", PartKind.DRAWER, lower, out))
    one, other = measure_plans([free])[0], measure_plans([stuck])[0]
    assert max(values(one, "blocked")) < 0.01
    assert values(other, "blocked")[0] > 0.02
    assert (other.whole["worst_blocked"], one.whole["none_found"]) == (values(other, "blocked")[0], 0.0)


def test_parts_are_measured_in_shares_of_the_object_and_by_how_far_other_ways_agree() -> None:
    out = slides((0.0, -0.2, 0.1))
    parts = [
        ("drawer_0", PartKind.DRAWER, np.arange(5, 11), out),
        ("drawer_1", PartKind.DRAWER, np.arange(11, 17), out),
    ]
    both, first = plan_with(*parts), plan_with(*parts[:1], way=Segmentation.PIECES)
    first = Plan(both.frame, first.way, first.fragmentation, first.measured, first.hypothesis)
    measures = measure_plans([both, first])
    assert values(measures[0], "width") == pytest.approx([0.996 * 0.5 / 0.5] * 2, abs=0.01)
    assert values(measures[0], "up") == pytest.approx([0.75, 0.25], abs=0.02)
    assert values(measures[0], "agreed_in_frame") == [1.0, 0.5]
    assert values(measures[1], "agreed_in_frame") == [1.0]
    assert measures[0].whole["fronts_cover"] > 0.9 > measures[1].whole["fronts_cover"]
    row = whole_features(measures[0], np.array([0.9, 0.4]))
    told = dict(zip(PLAN_FEATURES, row.tolist(), strict=True))
    assert told["weakest"] == pytest.approx(0.4)
    assert told["all_right"] == pytest.approx(0.36)
    assert told["expected"] == pytest.approx(np.log1p(1.3))


def test_kinds_that_decide_otherwise_are_plans_of_their_own() -> None:
    """One plain front without a handle: a door to the side, a flap, or a drawer, whatever the thing is."""
    front = box((0.005, -0.02, 0.005), (0.595, -0.0005, 0.595))
    mesh, frame = in_its_frame(*together(*carcass(0.6, 0.55, 0.6), front)[:2])
    labels = fragments_of(mesh).labels
    measured = measure_fragments(mesh, labels)
    found = articulate_by_kind(measured, frame, "", load_models().controls, NO_FRONTS, 6)
    opens = [[(p.kind, p.joint.edge) for p in h.articulation.parts] for h in found]
    assert found[0].kind == ""
    assert len(opens) > 1
    assert all(a != b for k, a in enumerate(opens) for b in opens[:k])
    assert all(0.0 < h.share <= 1.0 for h in found)
    alone = articulate_by_kind(measured, frame, "", load_models().controls, NO_FRONTS, 0)
    assert [h.articulation.parts[0].joint for h in alone] == [found[0].articulation.parts[0].joint]


def test_frames_that_are_hardly_likely_are_not_followed() -> None:
    mesh = weld_triangles(*microwave()[:2])
    frames = likely_frames(mesh)
    assert [f.confidence for f in frames] == sorted((f.confidence for f in frames), reverse=True)
    sure = [frames[0].replace(confidence=0.99), frames[1].replace(confidence=0.01)]
    assert {id(p.frame) for p in follow_plans(mesh, sure, "", load_models())} == {id(sure[0])}
    torn = [frames[0].replace(confidence=0.5), frames[1].replace(confidence=0.5)]
    assert {id(p.frame) for p in follow_plans(mesh, torn, "", load_models())} == {id(f) for f in torn}


def stump(feature: str, features: tuple[str, ...], classes: tuple[str, str], threshold: float = 0.5) -> Forest:
    """A forest that says no below a threshold of one feature, and yes above."""
    tree = [[features.index(feature), threshold, 1, 2], [[100, 0]], [[0, 100]]]
    return forest_from_dict({"features": list(features), "classes": list(classes), "trees": [tree]})


def test_the_plan_that_the_forest_prefers_is_chosen_in_whatever_frame() -> None:
    mesh = weld_triangles(*microwave()[:2])
    frames = [f.replace(confidence=c) for f, c in zip(likely_frames(mesh), (0.5, 0.3, 0.2), strict=True)]
    parts = stump("sure", PART_FEATURES, ("wrong", "right"))
    second = PlanModels(parts, stump("frame_rank", PLAN_FEATURES, ("bad", "good")))
    choice = choose_plan(mesh, frames, "", load_models(), second)
    assert choice.plan.frame is not frames[0]
    assert (choice.value, len(choice.parts)) == (1.0, len(choice.plan.articulation.parts))
    assert frame_confidences([0.5, 0.5], [0.9, 0.1])[0] > 0.95
    assert frame_confidences([0.9, 0.1], [0.5, 0.5])[0] == pytest.approx(0.9)


def test_drawers_and_a_microwave_come_out_right_in_any_turn() -> None:
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    for make, kinds in (
        (drawers, [PartKind.DRAWER] * 2),
        (microwave, [PartKind.BUTTON] * 4 + [PartKind.DOOR, PartKind.KNOB]),
    ):
        vertices, faces, _ = make()
        for rotation in (np.eye(3), turn):
            mesh = weld_triangles(vertices @ rotation.T, faces)
            choice = choose_plan(mesh, likely_frames(mesh), "", load_models(), load_plan_models())
            assert sorted(p.kind for p in choice.plan.articulation.parts) == kinds


def test_small_pieces_are_joined_also_where_copies_of_faces_left_numbers_that_no_face_has() -> None:
    """The last piece joins an earlier one, and the number between them belongs to copies alone."""
    knob = box((1.0, 0.4, 0.4), (1.05, 0.45, 0.45))
    vertices, faces, owner = together(box((0, 0, 0), (1, 1, 1)), knob)
    mesh = weld_triangles(vertices, faces)
    pieces = np.where(owner == 0, 0, np.where(np.arange(len(faces)) % 2, 1, 3))
    found = joined_small_pieces(mesh, pieces, find_flat_sheets(mesh))
    assert len(np.unique(found)) == 2
    assert np.ptp(found[owner == 1]) == 0
