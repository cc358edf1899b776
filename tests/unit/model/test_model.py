"""Every record of the spine, of scenes and of the registry: JSON round trip, digest, and what they refuse."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.model.asset.asset import TEST_SHARE, Drive, Inertial, Joint, Region, Site, Split, split_of
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Hull, Mesh
from casa_assets.model.issue import CheckResult, Files, Issue, Report, Severity, Status
from casa_assets.model.kitchen.scene import JointValue, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record
from casa_assets.model.registry.category import Category, SizeRange
from casa_assets.model.registry.contract import NamePattern, Threshold
from casa_assets.model.source import Bundle, RawModel, RawPart, Source, SourceKind, Up
from tests.support.asset.asset_parts import Z, hinge
from tests.support.asset.assets import PROVENANCE, category, drawer_unit, microwave, rigid_mug, textured_box
from tests.support.kitchen.scenes import corner
from tests.support.mesh.meshes import box_mesh, texture

CORNERS = box_mesh((0.1, 0.2, 0.3), (0.0, 0.0, 0.15), shared=True)
COLORED = CORNERS.replace(colors=np.arange(32, dtype=np.uint8).reshape(8, 4))
CHECKER = texture("checker", np.arange(48, dtype=np.uint8).reshape(4, 4, 3))


ISSUE = Issue(code="AST002", severity=Severity.WARNING, pointer="links/object", message="Schwer: 5 kg – „zu viel“ 🍎")
RAW = RawPart(name="Körper 1", mesh=COLORED, material=Material(id="m", base_color_texture=CHECKER))
RECORDS: list[Record] = [
    rigid_mug(),
    textured_box(),
    drawer_unit(),
    corner(),
    CORNERS,
    COLORED,
    Mesh(vertices=np.empty((0, 3)), faces=np.empty((0, 3))),
    Pose(position=(0.1, 1e-300, 3e17), quaternion=(0.1, -0.7, 0.3, 0.2)),
    Hull(mesh=CORNERS),
    CHECKER,
    Material(id="glass", base_color=(0.1, 0.2, 0.3, 0.4), normal_texture=CHECKER),
    category(rigid_mug()),
    CheckResult(code="AST002", status=Status.FAILED, number=0.1 + 0.2, limit=1e-5, unit="kg"),
    Report(subject="mug", results=(CheckResult(code="AST001", status=Status.PASSED),), issues=(ISSUE,)),
    PROVENANCE,
    Files(entries={"b/c.bin": bytes(range(256)), "a.txt": b""}),
    Source(kind=SourceKind.OBJAVERSE, path="a b/ü.glb", uid="u", hints=("mug", "Tasse")),
    Bundle(main="a.obj", files={"a.obj": b"\x00\xff", "a.mtl": b"x"}, notes=(ISSUE,)),
    RawModel(parts=(RAW,), metres_per_unit=0.0254, up=Up.Y, format="glb", notes=(ISSUE,)),
]


def test_json_reads_back_as_the_same_record() -> None:
    back = [(record, type(record).from_json(record.to_json())) for record in RECORDS]
    assert [a for a, b in back if a != b or a.to_json() != b.to_json() or hash(a) != hash(b)] == []


def test_the_digest_is_the_same_in_other_processes() -> None:
    code = "from tests.unit.model.test_model import RECORDS; print([r.digest for r in RECORDS])"
    for seed in ("0", "1", "4711"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.strip() == str([r.digest for r in RECORDS])


def test_the_digest_does_not_see_how_numbers_lie_in_memory_and_minus_zero_is_zero() -> None:
    plain = np.array([[0, 0, 0], [4, 0, 0], [0, 8, 0], [0, 0, 16]], dtype="<f8")
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    wanted = Mesh(vertices=plain, faces=faces)
    for dtype in ["<f8", ">f8", "<f4", ">f4", "<i4", ">i8"]:
        wide = np.zeros((8, 6), dtype=dtype)
        wide[::2, ::2] = plain
        for vertices in (plain.astype(dtype), np.asfortranarray(plain.astype(dtype)), wide[::2, ::2]):
            assert Mesh(vertices=vertices, faces=np.asfortranarray(faces.astype(">i8"))).digest == wanted.digest
    minus = plain.copy()
    minus[plain == 0] = -0.0
    assert Mesh(vertices=minus, faces=faces) == wanted
    assert Pose(quaternion=(1.0, -0.0, 0.0, -0.0)) == Pose()
    assert Pose(position=(-0.0, 0.0, -0.0)) == Pose()
    assert JointValue(joint="door", value=-0.0) == JointValue(joint="door", value=0.0)
    assert Drive(stiffness=-0.0, damping=0.0).to_json() == Drive(stiffness=0.0, damping=0.0).to_json()


def test_nothing_can_be_changed_and_replace_validates_and_has_a_digest_of_its_own() -> None:
    with pytest.raises(ValidationError):
        CORNERS.uv = None  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        CORNERS.vertices[0, 0] = 1.0
    mug = rigid_mug()
    before = mug.digest
    other = mug.replace(id="mug_9876543210")
    assert other.digest != before
    assert other.replace(id=mug.id) == mug
    for changes in ({"id": "Not An Id"}, {"materials": ()}, {"colour": "red"}):
        with pytest.raises(ValidationError):
            mug.replace(**changes)


GOOD_ID = ["a", "mug", "mug_2", "a1_b2_c3", "x" * 96]
BAD_ID = ["", "Mug", "1mug", "_mug", "mug_", "mug__two", "mug-two", "mug two", "mug/two", "mük", "mug\n", "x" * 97]
BAD_PATH = ["", "/etc/passwd", "../a", "a/../../b", "a//b", "./a", "a/", "a\\b", "C:a", "a b", "ä", "a\n", "a?", "a*"]
BAD_PATH += ["a\0b", "a\x07b", "."]
NAN, INF, TWO = float("nan"), float("inf"), np.zeros((2, 4))
MUG, OVEN, DRAWERS, SCENE = rigid_mug(), microwave(), drawer_unit(), corner()
LINK, PLACED, JOINT = MUG.root, SCENE.placements[0], OVEN.joints[0]
TWIN = LINK.colliders[0].replace(name=LINK.visuals[0].name)
LAMP, UNTOUCHABLE = SCENE.lights[0], OVEN.root.colliders[0].replace(substance="unobtainium")


def mesh(**columns: Any) -> Mesh:
    return Mesh(**{"vertices": np.zeros((3, 3)), "faces": [[0, 1, 2]], **columns})


def spoilt(field: str, bad: float) -> Mesh:
    values = np.zeros((3, 2 if field == "uv" else 3))
    values[1, 1] = bad
    return mesh(**{field: values})


def inertial(mass: float = 1.0, inertia: tuple[float, ...] = (1, 1, 1, 0, 0, 0)) -> Inertial:
    return Inertial(mass=mass, center_of_mass=(0, 0, 0), inertia=inertia)  # type: ignore[arg-type]


def mug(changes: dict[str, Any]) -> Category:
    row = category(rigid_mug()).model_dump(mode="json")
    return Category.model_validate({**row, "shape": (1.0, 0.5, 0.25), **changes})


def placed(name: str) -> Scene:
    """A scene of an oven whose joint has that name."""
    freed = OVEN.replace(joints=(JOINT.replace(name=name),), states=())
    return Scene(id="one", assets=(freed,), placements=(Placement(name="oven", asset=freed.id),))


def twice(field: str) -> Record:
    asset = next(one for one in (OVEN, DRAWERS, MUG) if getattr(one, field))
    items = getattr(asset, field)
    return asset.replace(**{field: (*items, items[-1])})


# What is refused: how it is made, values that it is made of, and what is said.
REFUSED: list[tuple[Callable[[Any], Any], list[Any], str | None]] = [
    (lambda name: Site(name=name), BAD_ID, None),
    (lambda path: Files(entries={path: b""}), BAD_PATH, None),
    (twice, ["joints", "sites", "regions", "materials", "substances", "links"], "twice"),
    (lambda region: MUG.replace(regions=(region,)), [Region(name=MUG.sites[0].name, size=(1, 1, 1))], "twice"),
    (lambda twin: MUG.replace(links=(LINK.replace(colliders=(twin,)),)), [TWIN], "twice"),
    (
        lambda changes: OVEN.replace(**changes),
        [
            {"sites": (Site(name="new", link="nowhere"),)},
            {"regions": (Region(name="new", link="nowhere", size=(1, 1, 1)),)},
            {"joints": (JOINT.replace(child="nowhere"),), "states": ()},
            {"joints": (JOINT.replace(child="object"),), "states": ()},
            {"joints": ()},
            {"materials": ()},
            {"links": (OVEN.root.replace(colliders=(UNTOUCHABLE,)), *OVEN.links[1:])},
            {"links": (OVEN.root, *(link.replace(parent="nowhere") for link in OVEN.links[1:]))},
            {"links": OVEN.links[::-1]},
            {"links": (OVEN.root.replace(name="base"), *OVEN.links[1:])},
        ],
        None,
    ),
    (
        lambda numbers: inertial(inertia=numbers),
        [(1, 1, 2.1, 0, 0, 0), (1, 1, 0, 0, 0, 0), (1, 1, 1, 2, 0, 0), (-1, 1, 1, 0, 0, 0)],
        "not that of any body",
    ),
    (inertial, [0.0, -1.0, NAN, INF], None),
    (lambda span: hinge("j", "door", Z, span), [(0.0, 0.0), (1.0, 0.0), (NAN, 1.0), (0.0, INF)], None),
    (lambda axis: hinge("j", "door", axis, (0, 1)), [(0, 0, 1e-12)], "direction"),
    *((partial(spoilt, field), [NAN, INF, -INF], "NaN") for field in ("vertices", "uv", "normals")),
    (lambda faces: mesh(faces=faces), [[[0, 1, 3]], [[-1, 0, 1]], [[0, 1]], [0, 1, 2]], None),
    (lambda row: mesh(**row), [{"uv": TWO[:, :2]}, {"normals": TWO[:, :3]}, {"colors": TWO}], "rows for 3 vertices"),
    (lambda count: Hull(mesh=mesh(vertices=np.random.default_rng(0).random((count, 3)))), [3, 65], "4 to 64"),
    (lambda numbers: Pose(quaternion=numbers), [(0, 0, 0, 0), (1e-12, 0, 0, 0), (NAN, 0, 0, 1), (1, 0, 0)], None),
    (lambda names: Files(entries=dict.fromkeys(names, b"")), [("Mug.obj", "mug.OBJ")], "differ only in case"),
    (lambda ends: SizeRange.model_validate(list(ends)), [(2, 1, 3), (1, 3, 2), (0, 1, 2), (1, 2)], None),
    (lambda data: Texture(name="t", png=data, width_px=1, height_px=1), [b"GIF89a"], "PNG"),
    (
        lambda changes: LAMP.replace(**changes),
        [{"direction": (0.0, 0.0, 0.0)}, {"color": (-1.0, 0.0, 0.0)}, {"attenuation": (0.0, 0.0, 0.0)}],
        None,
    ),
    (
        lambda changes: SCENE.replace(**changes),
        [
            {"assets": SCENE.assets[:1]},
            {"assets": (*SCENE.assets, SCENE.assets[0])},
            {"placements": (*SCENE.placements, PLACED)},
            {"placements": (PLACED.replace(name="world"),)},
            {"placements": (PLACED.replace(asset="plate_0123456789"),)},
            {"placements": (PLACED.replace(joints=(JointValue(joint="handle_of_nothing", value=0.0),)),)},
            {"placements": (PLACED.replace(joints=(JointValue(joint=JOINT.name, value=JOINT.range[1] + 0.01),)),)},
            {"cameras": (SCENE.cameras[0].replace(name=PLACED.name),)},
            {"lights": (LAMP, LAMP)},
            {"ambient": (-0.1, 0.0, 0.0)},
        ],
        None,
    ),
    (placed, ["free"], "free"),
    (lambda sizes: mug({"size_m": sizes}), [[[0.9 * t, t, 1.1 * t] for t in (0.2, 0.15, 0.3)]], "longest_m"),
    (lambda words: mug({"affords": words}), [["washable", "washable"]], "twice"),
    (lambda name: NamePattern(name=name), ["(open", "*", ""], None),
    (lambda at: Threshold(name="on", joint="knob", **at), [{}, {"at": 0.4, "share": 0.5}], "position or at a share"),
]


def test_what_is_no_sound_record_is_refused(subtests: pytest.Subtests) -> None:
    for number, (make, values, message) in enumerate(REFUSED):
        for value in values:
            with subtests.test(number=number, value=value), pytest.raises(ValidationError, match=message):
                make(value)


def test_what_is_at_the_edge_is_taken() -> None:
    assert [Site(name=name).name for name in GOOD_ID] == GOOD_ID
    assert OVEN.replace() == OVEN
    tip = OVEN.links[-1].replace(name="tip", parent=JOINT.child, visuals=(), colliders=())
    assert OVEN.replace(links=(*OVEN.links, tip)).is_moved("tip")
    for turn in ((0.1, 0.9, 0.3, 0.2), (0.1, 0.2, 0.9, 0.3), (0.1, 0.3, 0.2, 0.9), (0.9, 0.1, 0.2, 0.3)):
        pose = Pose(position=(1.0, 2.0, 3.0), quaternion=turn)
        assert Pose.from_matrix(pose.matrix).quaternion == pytest.approx(pose.quaternion)
    flat = inertial(inertia=(1, 1, 2, 0, 0, 0))
    assert np.linalg.eigvalsh(flat.tensor) == pytest.approx([1, 1, 2])
    joint = hinge("j", "door", (1, 2, 2), (0, 1))
    assert joint.axis == pytest.approx((1 / 3, 2 / 3, 2 / 3))
    assert Joint.from_json(joint.to_json()) == joint


def test_a_split_is_told_from_the_digest_and_a_share_counts_from_the_end_nearer_to_zero() -> None:
    for digits, split in (("00000000", Split.TEST), (f"{TEST_SHARE:08x}", Split.TEST), ("00000001", Split.TRAIN)):
        assert split_of(digits + "f" * 56) is split
    for span, share, at in [
        ((0.0, 2.0), 0.9, 1.8),
        ((-1.5, 0.0), 0.9, -1.35),
        ((-1.5, 0.0), 0.0, 0.0),
        ((-0.8, 0.8), 0.5, 0.0),
        ((-0.8, 0.8), 0.25, -0.4),
    ]:
        assert Threshold(name="x", joint="x", share=share).position(span) == pytest.approx(at)
    assert Threshold(name="x", joint="x", at=0.35).position((0.0, 3.0)) == 0.35
