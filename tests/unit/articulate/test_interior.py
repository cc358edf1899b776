"""What a door opens onto: cavities that are found or built, what slides behind a door, and what goes with a front."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.articulate.decisions import CavityDecision, Decisions
from casa_assets.articulate.interior.cavities import find_cavities
from casa_assets.articulate.interior.inner_parts import _is_lining, with_pieces_in_the_way
from casa_assets.articulate.plan import Articulation, HingeEdge, InteriorKind, JointPlan, PartKind
from casa_assets.articulate.run.build import ArticulateRequest, ArticulateResult, build
from casa_assets.articulate.segment.fragments import WeldedMesh, weld_triangles
from casa_assets.articulate.segment.orthographic import cross_rays
from casa_assets.checks.motion.joints import joint_travels
from casa_assets.errors import Rejected
from casa_assets.formats import mjcf
from casa_assets.library.mesh_decisions import read_decisions
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import (
    AS_IT_IS,
    Floats,
    Ints,
    Part,
    articulate_fragmentation,
    box,
    carcass,
    disc,
    fragments_of,
    in_its_frame,
    microwave,
    pieces_in,
    plan_of,
    slides,
    together,
)
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate", keep=0)

Mesh = tuple[Floats, Ints, Ints]
MADE: dict[tuple[bytes, bytes, str, bool], ArticulateResult] = {}


def block(*fronts: Part) -> Mesh:
    """A solid block with what is put before it."""
    return together(box((0.0, 0.0, 0.0), (0.6, 0.6, 0.8)), *fronts)


def door() -> list[Part]:
    """A leaf over the whole front, with an upright handle at its right."""
    return [box((0.0, -0.03, 0.0), (0.6, -0.001, 0.8)), box((0.54, -0.07, 0.3), (0.56, -0.03, 0.5))]


def front(low: float, high: float) -> list[Part]:
    """A low board with a level handle: a drawer's front."""
    middle = (low + high) / 2
    return [box((0.0, -0.02, low), (0.6, -0.001, high)), box((0.2, -0.06, middle - 0.01), (0.4, -0.02, middle + 0.01))]


def made(
    mesh: Mesh, folder: Path, category: str, decisions: Decisions | None = None, complete: bool = True
) -> ArticulateResult:
    """A mesh through everything, its axes given; once where nothing is decided."""
    key = mesh[0].tobytes(), mesh[1].tobytes(), category, complete
    if decisions is None and key in MADE:
        return MADE[key]
    path, axes = obj(folder / "thing.obj", mesh[0], mesh[1]), ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
    wish = ArticulateRequest(path, folder, category, *axes, decisions=decisions or Decisions(), complete=complete)
    built = build(wish)
    return built if decisions is not None else MADE.setdefault(key, built)


def reach(built: ArticulateResult, spot: tuple[float, float]) -> float:
    """How far behind the front one can put something at a place (x, z) with the door open, metres."""
    points, faces, _ = together(*(tessellate(c.shape, c.pose) for c in built.asset.root.colliders))
    line = cross_rays(points, faces, 1, np.array([spot]))
    return float(line.first()[0] - built.asset.bounds[0][1])


def test_a_solid_block_gets_a_cavity_behind_its_door(tmp_path: Path) -> None:
    built = made(block(*door()), tmp_path, "base_cabinet")
    (room,) = built.articulation.cavities
    assert room.built
    assert room.cut is not None
    assert room.interior is InteriorKind.CABINET
    metres = built.articulation.frame.metres or 1.0
    whole = np.ptp(built.asset.bounds, axis=0)
    size = (np.array(room.upper) - np.array(room.lower)) * metres
    assert (size > 0.75 * whole).all()
    assert reach(built, (0.0, 0.25 * float(whole[2]))) > 0.8 * float(whole[1])
    low, high = plain = made(block(*door()), tmp_path, "base_cabinet", complete=False).asset.bounds
    assert built.asset.bounds == pytest.approx(plain, abs=1e-6)
    seen = [v.mesh.vertices for v in built.asset.root.visuals if "added" in v.name]
    assert seen
    for points in seen:  # it stays within the skin
        assert (points[:, [0, 2]] > low[[0, 2]] + 1e-4).all()
        assert (points < high - 1e-4).all()


def test_a_mesh_that_has_its_cavity_keeps_it(tmp_path: Path) -> None:
    vertices, faces, owner = microwave()
    built = made((vertices, faces, owner), tmp_path, "microwave")
    (room,) = built.articulation.cavities
    assert not room.built
    assert not built.articulation.added
    assert sum(len(v.mesh.faces) for k in built.asset.links for v in k.visuals) == len(faces)
    metres = built.articulation.frame.metres or 1.0
    size = (np.array(room.upper) - np.array(room.lower)) * metres / float(np.ptp(built.asset.bounds[:, 0]))
    assert size == pytest.approx(np.array([0.35, 0.34, 0.26]) / 0.5, abs=0.04)


def test_a_hollow_shell_gets_walls_but_is_not_cut(tmp_path: Path) -> None:
    # A box of no thickness, open at the front: from inside one looks through it.
    points, faces = box((0.0, 0.0, 0.0), (0.6, 0.6, 0.8))
    sheet = points, faces[np.abs(points[faces][:, :, 1]).max(axis=1) > 0]
    built = made(together(sheet, *door()), tmp_path, "base_cabinet")
    (room,) = built.articulation.cavities
    assert room.built
    assert room.cut is None
    assert "0 of 5" in room.reason


def test_each_kind_is_furnished_as_it_is_and_racks_meet_nothing(tmp_path: Path) -> None:
    links = {}
    for kind in ("wall_oven", "dishwasher", "microwave", "refrigerator"):
        built = made(block(*door()), tmp_path, kind)
        links[kind] = [p.name for p in built.articulation.parts if p.added]
        looks = {m.id: m for m in built.asset.materials}
        assert len(looks) > 1
        assert all("added" in v.name for v in built.asset.root.visuals[1:])
    assert len(links["wall_oven"]) >= 1
    assert len(links["dishwasher"]) >= 1
    assert links["microwave"] == links["refrigerator"] == []
    built = made(block(*door()), tmp_path, "wall_oven")
    found = {t.joint: t for t in joint_travels(built.asset, mjcf.write(built.asset))}
    racks = [p.name for p in built.articulation.parts if p.kind is PartKind.TRAY]
    assert racks
    for joint in map(built.asset.joint_of, racks):
        assert joint.behind == "door_0_joint"
        assert found[joint.name].free_share == 1.0
    assert found["door_0_joint"].free_share == 1.0


def test_a_drawer_front_before_a_block_gets_a_box_that_slides(tmp_path: Path) -> None:
    mesh = block(*front(0.0, 0.26), *front(0.265, 0.525), *front(0.53, 0.79))
    built = made(mesh, tmp_path, "drawer_stack")
    assert len(built.articulation.parts) == 3
    assert all(r.built and r.cut is not None and r.interior is InteriorKind.DRAWER for r in built.articulation.cavities)
    for travel in joint_travels(built.asset, mjcf.write(built.asset)):
        assert travel.is_full, travel
    for part in built.articulation.parts:
        region = next(r for r in built.asset.regions if r.link == part.name)
        assert min(region.size) > 0.05
        shapes = [tessellate(c.shape, c.pose)[0] for c in built.asset.link(part.name).colliders if c.label == "drawer"]
        low, high = (np.array(region.pose.position) + s * np.array(region.size) / 2 for s in (-0.98, 0.98))
        # Nothing fills the box: it is open at the top, and closed below.
        assert not any((c.min(axis=0) < low).all() and (c.max(axis=0) > high).all() for c in shapes)


def test_a_sidecar_with_cavities_makes_the_same_asset(tmp_path: Path) -> None:
    first = made(block(*door()), tmp_path, "wall_oven")
    path = tmp_path / "d.yaml"
    path.write_text(first.decisions_text(Decisions()), encoding="utf-8")
    decisions = read_decisions(path)
    assert decisions.cavities["door_0"].build is True
    assert made(block(*door()), tmp_path, "wall_oven", decisions).asset.digest == first.asset.digest
    now = path.read_text(encoding="utf-8")
    former = now.replace("\ncavities:", "\nrooms:").replace("    interior:", "    filling:")
    assert former != now
    path.write_text(former, encoding="utf-8")
    assert read_decisions(path) == decisions, "the keys of older files are read"
    bare = made(block(*door()), tmp_path, "wall_oven", complete=False)
    path.write_text(bare.decisions_text(Decisions()), encoding="utf-8")
    assert made(block(*door()), tmp_path, "wall_oven", read_decisions(path)).asset.digest == bare.asset.digest


def test_a_cavity_is_fixed_in_a_line(tmp_path: Path) -> None:
    def said(wanted: CavityDecision, name: str = "door_0") -> ArticulateResult:
        return made(block(*door()), tmp_path, "wall_oven", Decisions(cavities={name: wanted}))

    assert not said(CavityDecision(build=False)).articulation.added
    assert said(CavityDecision(interior=InteriorKind.PLAIN)).articulation.cavities[0].interior is InteriorKind.PLAIN
    assert not any(p.added for p in said(CavityDecision(furnish=False)).articulation.parts)
    small = said(CavityDecision(box_m=((-0.1, -0.2, 0.1), (0.1, 0.0, 0.3))))
    region = next(r for r in small.asset.regions if r.name == "door_0_int")
    assert region.size == pytest.approx((0.2, 0.2, 0.2), abs=1e-4)
    with pytest.raises(Rejected, match=r"ART002.*door_7"):
        said(CavityDecision(build=True), "door_7")


def test_two_doors_that_meet_close_one_room() -> None:
    left = [box((0.0, -0.03, 0.0), (0.298, -0.001, 0.8)), box((0.26, -0.07, 0.3), (0.275, -0.03, 0.5))]
    right = [box((0.302, -0.03, 0.0), (0.6, -0.001, 0.8)), box((0.325, -0.07, 0.3), (0.34, -0.03, 0.5))]
    mesh, found = _inferred(*block(*left, *right)[:2])
    (room,) = find_cavities(mesh, found, "base_cabinet")
    assert len(room.parts) == 2
    cavities = find_cavities(mesh, found, "refrigerator")
    assert [len(r.parts) for r in cavities] == [1, 1]


def _inferred(vertices: Floats, faces: Ints) -> tuple[WeldedMesh, Articulation]:
    placed, frame = in_its_frame(vertices, faces)
    return placed, articulate_fragmentation(fragments_of(placed), frame.replace(metres=1.0))


def test_an_inside_out_mesh_is_measured_as_the_same() -> None:
    parts = [*carcass(0.6, 0.6, 0.8), *door()]
    right, wrong = (
        find_cavities(*_inferred(*together(*p)[:2]), "base_cabinet")
        for p in (parts, [(points, faces[:, ::-1]) for points, faces in parts])
    )
    assert [r.built for r in right] == [r.built for r in wrong] == [False]


def by_hand(edges: dict[int, HingeEdge], *parts: Part) -> tuple[WeldedMesh, Articulation]:
    """Solids of which some are doors, without anything being guessed: place in `parts` -> edge of its hinge."""
    vertices, faces, owner = together(*parts)
    placed, frame = in_its_frame(vertices, faces)
    joint = JointPlan(kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), anchor=(0.0, 0.0, 0.0), range=(0.0, 1.5))
    doors = (
        plan_of(f"door_{i}", PartKind.DOOR, np.flatnonzero(owner == i), joint.replace(edge=edge))
        for i, edge in edges.items()
    )
    return placed, Articulation(frame=frame.replace(metres=1.0), parts=tuple(doors))


BLOCK = box((0.0, 0.0, 0.0), (0.6, 0.6, 0.8))


def test_behind_a_round_door_the_front_stays_whole() -> None:
    mesh, found = by_hand({1: HingeEdge.LEFT}, BLOCK, disc((0.3, -0.03, 0.4), 0.25, 0.029, 48))
    (room,) = find_cavities(mesh, found, "washing_machine")
    assert room.fronts == ()
    scale, middle = found.frame.scale, np.array(found.frame.origin)
    corners = [np.array([room.cut[i][0], room.cut[j][2]]) / scale + middle[[0, 2]] for i in (0, 1) for j in (0, 1)]
    assert all(float(np.linalg.norm(c - (0.3, 0.4))) < 0.25 for c in corners)


def test_a_room_keeps_off_what_tapers_towards_the_back() -> None:
    points, faces = BLOCK
    tapered = points.copy()
    back = tapered[:, 1] > 0.5
    tapered[back, 2] = 0.2 + 0.5 * tapered[back, 2]
    mesh, found = by_hand({1: HingeEdge.LEFT}, (tapered, faces), box((0.0, -0.03, 0.0), (0.6, -0.001, 0.8)))
    (room,) = find_cavities(mesh, found, "")
    skin = mesh.faces[: len(faces)]
    for x, z in ((room.outer[i][0], room.outer[k][2]) for i in (0, 1) for k in (0, 1)):
        up = cross_rays(mesh.points, skin, 2, np.array([[x, room.outer[1][1]]]))
        assert float(up.first()[0]) < z < float(up.last()[0])


@pytest.mark.parametrize(("back", "is_lining"), [(0.48, True), (0.44, False)])
def test_a_plate_that_meets_both_sides_and_the_back_is_lining(back: float, is_lining: bool) -> None:
    measured = pieces_in(*carcass(0.6, 0.5, 0.4), box((0.0205, 0.03, 0.1), (0.5795, back - 0.0005, 0.105)))
    assert _is_lining(measured, [int(measured.label[-1])]) is is_lining


DRAWER_FRONT, DRAWER_BACK = box((0.01, -0.02, 0.01), (0.49, 0.0, 0.29)), box((0.03, 0.4, 0.04), (0.47, 0.42, 0.2))
DRAWER_SIDES = [box((x, 0.01, 0.04), (x + 0.02, 0.39, 0.2)) for x in (0.03, 0.45)]
HANDLE = box((0.2, -0.06, 0.14), (0.3, -0.021, 0.16))
# Between the two side walls, over the back of the drawer and under the edge of its front.
RAIL = box((0.02, 0.005, 0.25), (0.48, 0.06, 0.27))


SLIDES = slides((0.25, 0.0, 0.15))
SWINGS = JointPlan(
    kind=JointKind.HINGE, axis=(0.0, 0.0, -1.0), anchor=(0.01, 0.0, 0.15), range=(0.0, 1.5), edge=HingeEdge.LEFT
)


def _carried(
    *loose: Part, sheets: tuple[Part, Part] = (DRAWER_FRONT, DRAWER_BACK), joint: JointPlan = SLIDES, taken: int = 0
) -> list[bool]:
    """Build a drawer or a door of two sheets in a carcass; return which of some pieces of the body it carries.

    Args:
        taken: faces of the first piece that it has before.
    """
    vertices, faces, owner = together(*carcass(0.5, 0.5, 0.3), *sheets, *loose)
    mesh = weld_triangles(vertices, faces)
    own: Ints = np.flatnonzero((owner == 5) | (owner == 6))
    own = np.concatenate([own, np.flatnonzero(owner == 7)[:taken]])
    kind = PartKind.DRAWER if joint is SLIDES else PartKind.DOOR
    part = plan_of("front_0", kind, own, joint)
    (found,) = with_pieces_in_the_way(Articulation(frame=AS_IT_IS, parts=(part,)), mesh).parts
    carried = np.isin(np.arange(len(faces)), found.faces)
    assert carried[own].all()
    assert not carried[owner < 5].any(), "walls of the body stay"
    return [bool(carried[owner == 7 + i].all()) for i in range(len(loose))]


def test_what_would_be_in_the_way_of_a_front_goes_with_it() -> None:
    assert _carried(*DRAWER_SIDES, HANDLE) == [True, True, True]
    assert _carried(*DRAWER_SIDES, taken=4) == [True, True], "what a drawer has not taken of a piece, too"
    assert _carried(RAIL) == [False], "the box passes under it"
    # What is between the sheets of a door goes with it, the room behind it stays.
    inner, core = box((0.01, 0.02, 0.01), (0.49, 0.03, 0.29)), box((0.1, 0.005, 0.1), (0.4, 0.015, 0.2))
    carried = _carried(core, *DRAWER_SIDES, HANDLE, sheets=(DRAWER_FRONT, inner), joint=SWINGS)
    assert carried == [True, False, False, True]
