"""What somebody says in a sidecar goes before the guesses; what repeats them changes nothing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from casa_assets.articulate.decisions import CavityDecision, Decisions, PartDecision
from casa_assets.articulate.plan import HingeEdge, PartKind
from casa_assets.articulate.run.build import ArticulateRequest, ArticulateResult, build
from casa_assets.errors import RegistryError, Rejected
from casa_assets.library.review import read_decisions
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.source import Word
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate", keep=0)


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return obj(tmp_path_factory.mktemp("mesh") / "microwave.obj", *microwave()[:2])


def made(mesh: Path, decisions: Decisions) -> ArticulateResult:
    """The microwave with decisions, axes given."""
    return build(ArticulateRequest(mesh, mesh.parent, up=(0.0, 0.0, 1.0), front=(0.0, -1.0, 0.0), decisions=decisions))


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
    box = ((0.15, -0.3, 0.03), (0.23, -0.14, 0.11))
    built = made(mesh, one("my_lever", PartDecision(kind=PartKind.LEVER, box_m=box, axis="-y", opens_deg=40)))
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


def test_a_mesh_is_rejected_by_a_person_or_where_decisions_do_not_fit_it_or_name_nothing(
    mesh: Path,
) -> None:
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
