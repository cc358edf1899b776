"""Every record of the spine: JSON round trip, digest, and what it refuses."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.model.asset.asset import Drive, Inertial, Joint, JointKind, Region, Site
from casa_assets.model.asset.material import Material, Substance, Texture
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Mesh, MeshShape, Sphere
from casa_assets.model.asset.provenance import Guess, Labels, Provenance
from casa_assets.model.files import Files
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status
from casa_assets.model.kitchen.scene import Camera, JointValue, Light, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record
from casa_assets.model.registry.category import Certainty, QCode, SizeRange
from casa_assets.model.source import Bundle, RawModel, RawPart, Source, SourceKind, Up
from tests.assets import PROVENANCE, ball, category, drawer_unit, microwave, rigid_mug, textured_box
from tests.meshes import box_mesh, texture

BOX = box_mesh((0.1, 0.2, 0.3), (0.0, 0.0, 0.15))
CORNERS = box_mesh((0.1, 0.2, 0.3), (0.0, 0.0, 0.15), shared=True)
CHECKER = texture("checker", np.arange(48, dtype=np.uint8).reshape(4, 4, 3))


def colored_mesh() -> Mesh:
    colors = np.arange(32, dtype=np.uint8).reshape(8, 4)
    return Mesh(vertices=CORNERS.vertices, faces=CORNERS.faces, colors=colors)


def kitchen() -> Scene:
    oven = microwave()
    joint = oven.joints[0]
    return Scene(
        id="corner",
        assets=(oven, rigid_mug()),
        placements=(
            Placement(
                name="oven",
                asset=oven.id,
                pose=Pose(position=(1.0, -2.0, 0.9), quaternion=(0.5, 0.5, -0.5, 0.5)),
                joints=(JointValue(joint=joint.name, value=sum(joint.range) / 3),),
            ),
            Placement(name="first_mug", asset="mug_0123456789"),
            Placement(name="second_mug", asset="mug_0123456789", pose=Pose(position=(0.1, 0.2, 1e-17))),
        ),
        cameras=(Camera(name="door", pose=Pose(position=(0.0, -3.0, 1.6)), fov_y_deg=60.0),),
        lights=(Light(name="lamp", position=(0.0, 0.0, 2.4), direction=(0.0, 0.0, -1.0), color=(3.0, 2.5, 0.1)),),
    )


ISSUE = Issue(code="AST002", severity=Severity.WARNING, pointer="links/object", message="Schwer: 5 kg – „zu viel“ 🍎")
RAW = RawPart(name="Körper 1", mesh=colored_mesh(), material=Material(id="m", base_color_texture=CHECKER))
RECORDS: list[Record] = [
    rigid_mug(),
    ball(),
    textured_box(),
    microwave(),
    drawer_unit(),
    kitchen(),
    BOX,
    CORNERS,
    colored_mesh(),
    Mesh(vertices=np.empty((0, 3)), faces=np.empty((0, 3))),
    Pose(position=(0.1, 1e-300, 3e17), quaternion=(0.1, -0.7, 0.3, 0.2)),
    Box(size=(0.1, 0.2, 0.3)),
    Sphere(radius=0.1),
    Cylinder(radius=0.1, height=1 / 3),
    Capsule(radius=0.1, height=1e-9),
    Hull(mesh=CORNERS),
    MeshShape(mesh=BOX),
    CHECKER,
    Material(id="glass", base_color=(0.1, 0.2, 0.3, 0.4), normal_texture=CHECKER),
    Substance(id="steel", density=7800.0, static_friction=0.6, dynamic_friction=0.4),
    Drive(stiffness=1.0, damping=0.0, target=-0.5),
    category(rigid_mug()),
    ISSUE,
    CheckResult(code="AST002", status=Status.FAILED, number=0.1 + 0.2, limit=1e-5, unit="kg"),
    Report(subject="mug", results=(CheckResult(code="AST001", status=Status.PASSED),), issues=(ISSUE,)),
    Guess(subject="scale", value="0.01", confidence=0.3, reason="usual size"),
    PROVENANCE,
    Labels(category="mug", classes=("mug",), qcode=QCode(id="Q1", label="x", certainty=Certainty.LIKELY)),
    Files(entries={"b/c.bin": bytes(range(256)), "a.txt": b""}),
    Source(kind=SourceKind.OBJAVERSE, path="a b/ü.glb", uid="u", hints=("mug", "Tasse")),
    Bundle(main="a.obj", files={"a.obj": b"\x00\xff", "a.mtl": b"x"}, notes=(ISSUE,)),
    RAW,
    RawModel(parts=(RAW,), metres_per_unit=0.0254, up=Up.Y, format="glb", notes=(ISSUE,)),
]


def test_json_reads_back_as_the_same_record() -> None:
    back = [(record, type(record).from_json(record.to_json())) for record in RECORDS]
    assert [
        a for a, b in back if a != b or a.to_json() != b.to_json() or a.digest != b.digest or hash(a) != hash(b)
    ] == []


def test_arrays_read_back_bit_for_bit() -> None:
    numbers = np.array([[0.1, 1 / 3, np.pi], [1e-308, 5e-324, 1.7e308], [np.nextafter(1, 2), -1e-9, 123456789.123456]])
    mesh = Mesh(vertices=numbers, faces=[[0, 1, 2]])
    assert (Mesh.from_json(mesh.to_json()).vertices == numbers).all()


class TestDigest:
    def test_is_the_same_in_other_processes(self) -> None:
        code = "from tests.unit.model.test_records import RECORDS; print([r.digest for r in RECORDS])"
        for seed in ("0", "1", "4711"):
            done = subprocess.run(
                [sys.executable, "-c", code],
                env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
                capture_output=True,
                text=True,
                check=True,
            )
            assert done.stdout.strip() == str([r.digest for r in RECORDS])

    def test_does_not_see_how_numbers_lie_in_memory(self, subtests: pytest.Subtests) -> None:
        for dtype in ["<f8", ">f8", "<f4", ">f4", "<i4", ">i8"]:
            with subtests.test(dtype=dtype):
                plain = np.array([[0, 0, 0], [4, 0, 0], [0, 8, 0], [0, 0, 16]], dtype="<f8")
                faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
                wanted = Mesh(vertices=plain, faces=faces).digest
                wide = np.zeros((8, 6), dtype=dtype)
                wide[::2, ::2] = plain
                for vertices in (plain.astype(dtype), np.asfortranarray(plain.astype(dtype)), wide[::2, ::2]):
                    assert Mesh(vertices=vertices, faces=np.asfortranarray(faces.astype(">i8"))).digest == wanted

    def test_minus_zero_is_zero(self) -> None:
        faces = [[0, 1, 2]]
        plus = Mesh(vertices=[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=faces)
        minus = Mesh(vertices=[[-0.0, 0, -0.0], [1, 0, 0], [0, 1, -0.0]], faces=faces)
        assert plus == minus
        assert Pose(quaternion=(1.0, -0.0, 0.0, -0.0)) == Pose()
        assert Pose(position=(-0.0, 0.0, -0.0)) == Pose()
        assert JointValue(joint="door", value=-0.0) == JointValue(joint="door", value=0.0)
        assert Drive(stiffness=-0.0, damping=0.0).to_json() == Drive(stiffness=0.0, damping=0.0).to_json()

    def test_order_of_files_does_not_matter(self) -> None:
        assert Files(entries={"b": b"1", "a": b"2"}) == Files(entries={"a": b"2", "b": b"1"})

    def test_every_bit_counts(self) -> None:
        moved = CORNERS.vertices.copy()
        moved[3, 1] = np.nextafter(moved[3, 1], np.inf)
        assert Mesh(vertices=moved, faces=CORNERS.faces) != CORNERS

    def test_records_of_two_kinds_are_never_equal(self) -> None:
        assert Capsule(radius=0.1, height=0.2) != Cylinder(radius=0.1, height=0.2)
        assert Hull(mesh=CORNERS) != MeshShape(mesh=CORNERS)


class TestFrozen:
    def test_fields_and_arrays_cannot_be_changed(self) -> None:
        with pytest.raises(ValidationError):
            BOX.uv = None  # type: ignore[misc]
        with pytest.raises(ValueError, match="read-only"):
            BOX.vertices[0, 0] = 1.0

    def test_a_record_does_not_see_later_changes_of_its_input(self) -> None:
        vertices = CORNERS.vertices.copy()
        mesh = Mesh(vertices=vertices, faces=CORNERS.faces)
        vertices[0, 0] = 99.0
        assert mesh == CORNERS

    def test_replace_validates_and_has_a_digest_of_its_own(self) -> None:
        mug = rigid_mug()
        before = mug.digest
        other = mug.replace(id="mug_9876543210")
        assert other.digest != before
        assert other.replace(id=mug.id) == mug
        with pytest.raises(ValidationError):
            mug.replace(id="Not An Id")
        with pytest.raises(ValidationError):
            mug.replace(materials=())
        with pytest.raises(ValidationError):
            mug.replace(colour="red")


GOOD_ID = ["a", "mug", "mug_2", "a1_b2_c3", "x" * 96]
BAD_ID = ["", "Mug", "1mug", "_mug", "mug_", "mug__two", "mug-two", "mug two", "mug/two", "mük", "mug\n", "x" * 97]


def test_good_ids(subtests: pytest.Subtests) -> None:
    for name in GOOD_ID:
        with subtests.test(name=name):
            assert Site(name=name).name == name


def test_bad_ids(subtests: pytest.Subtests) -> None:
    for name in BAD_ID:
        with subtests.test(name=name), pytest.raises(ValidationError):
            Site(name=name)


class TestAssetRefuses:
    def test_the_examples_are_good(self) -> None:
        assert microwave().replace() == microwave()

    def test_two_of_one_name(self, subtests: pytest.Subtests) -> None:
        for field in ["joints", "sites", "regions", "materials", "substances", "links"]:
            with subtests.test(field=field):
                asset = next(a for a in (microwave(), drawer_unit(), rigid_mug()) if getattr(a, field))
                items = getattr(asset, field)
                with pytest.raises(ValidationError, match=r"twice|alone is the root"):
                    asset.replace(**{field: (*items, items[-1])})

    def test_a_site_called_like_a_region(self) -> None:
        mug = rigid_mug()
        with pytest.raises(ValidationError, match="twice"):
            mug.replace(regions=(Region(name=mug.sites[0].name, size=(1, 1, 1)),))

    def test_a_collider_called_like_a_visual(self) -> None:
        link = rigid_mug().root
        twin = link.colliders[0].replace(name=link.visuals[0].name)
        with pytest.raises(ValidationError, match="twice"):
            rigid_mug().replace(links=(link.replace(colliders=(twin,)),))

    def test_names_that_nothing_answers_to(self) -> None:
        oven = microwave()
        link = oven.root
        wrong: list[dict[str, Any]] = [
            {"sites": (Site(name="new", link="nowhere"),)},
            {"regions": (Region(name="new", link="nowhere", size=(1, 1, 1)),)},
            {"joints": (oven.joints[0].replace(child="nowhere"),), "states": ()},
            {"joints": (oven.joints[0].replace(child="object"),), "states": ()},
            {"joints": ()} if oven.states else {"materials": ()},
            {"materials": ()},
            {"links": (link.replace(colliders=(link.colliders[0].replace(substance="unobtainium"),)), *oven.links[1:])},
            {"links": (link, *(k.replace(parent="nowhere") for k in oven.links[1:]))},
            {"links": oven.links[::-1]},
            {"links": (link.replace(name="base"), *oven.links[1:])},
        ]
        for changes in wrong:
            with pytest.raises(ValidationError):
                oven.replace(**changes)

    def test_inertia_of_no_body(self, subtests: pytest.Subtests) -> None:
        for inertia in [(1, 1, 2.1, 0, 0, 0), (1, 1, 0, 0, 0, 0), (1, 1, 1, 2, 0, 0), (-1, 1, 1, 0, 0, 0)]:
            with subtests.test(inertia=inertia), pytest.raises(ValidationError, match="not that of any body"):
                Inertial(mass=1.0, center_of_mass=(0, 0, 0), inertia=inertia)  # type: ignore[arg-type]

    def test_inertia_at_the_edge_of_the_possible(self) -> None:
        flat = Inertial(mass=1.0, center_of_mass=(0, 0, 0), inertia=(1, 1, 2, 0, 0, 0))
        assert np.linalg.eigvalsh(flat.tensor) == pytest.approx([1, 1, 2])

    def test_masses_that_are_none(self, subtests: pytest.Subtests) -> None:
        for mass in [0.0, -1.0, float("nan"), float("inf")]:
            with subtests.test(mass=mass), pytest.raises(ValidationError):
                Inertial(mass=mass, center_of_mass=(0, 0, 0), inertia=(1, 1, 1, 0, 0, 0))


class TestJointRefuses:
    def test_a_range_that_does_not_rise(self, subtests: pytest.Subtests) -> None:
        for span in [(0.0, 0.0), (1.0, 0.0), (float("nan"), 1.0), (0.0, float("inf"))]:
            with subtests.test(span=span), pytest.raises(ValidationError):
                Joint(name="j", child="door", kind=JointKind.HINGE, axis=(0, 0, 1), range=span)

    def test_an_axis_without_direction(self) -> None:
        with pytest.raises(ValidationError, match="direction"):
            Joint(name="j", child="door", kind=JointKind.HINGE, axis=(0, 0, 1e-12), range=(0, 1))

    def test_axis_is_normalised_once(self) -> None:
        joint = Joint(name="j", child="door", kind=JointKind.HINGE, axis=(1, 2, 2), range=(0, 1))
        assert joint.axis == pytest.approx((1 / 3, 2 / 3, 2 / 3))
        assert Joint.from_json(joint.to_json()) == joint


class TestMeshRefuses:
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_numbers_that_are_none(self, bad: float) -> None:
        for field in ("vertices", "uv", "normals"):
            values = np.zeros((3, 2 if field == "uv" else 3))
            values[1, 1] = bad
            with pytest.raises(ValidationError, match="NaN"):
                Mesh(**{"vertices": np.zeros((3, 3)), "faces": [[0, 1, 2]], field: values})

    def test_faces_that_are_none(self, subtests: pytest.Subtests) -> None:
        for faces in [[[0, 1, 3]], [[-1, 0, 1]], [[0, 1]], [0, 1, 2]]:
            with subtests.test(faces=faces), pytest.raises(ValidationError):
                Mesh(vertices=np.zeros((3, 3)), faces=faces)

    def test_columns_of_another_length(self, subtests: pytest.Subtests) -> None:
        for field in ["uv", "normals", "colors"]:
            with subtests.test(field=field):
                columns = {"uv": 2, "normals": 3, "colors": 4}[field]
                with pytest.raises(ValidationError, match="rows for 3 vertices"):
                    Mesh(**{"vertices": np.zeros((3, 3)), "faces": [[0, 1, 2]], field: np.zeros((2, columns))})

    def test_hulls_of_too_few_or_many_vertices(self, subtests: pytest.Subtests) -> None:
        for count in [3, 65]:
            with subtests.test(count=count), pytest.raises(ValidationError, match="4 to 64"):
                Hull(mesh=Mesh(vertices=np.random.default_rng(0).random((count, 3)), faces=[[0, 1, 2]]))


class TestOthersRefuse:
    def test_quaternions_without_direction(self, subtests: pytest.Subtests) -> None:
        for quaternion in [(0, 0, 0, 0), (1e-12, 0, 0, 0), (float("nan"), 0, 0, 1), (1, 0, 0)]:
            with subtests.test(quaternion=quaternion), pytest.raises(ValidationError):
                Pose(quaternion=quaternion)  # type: ignore[arg-type]

    def test_paths_that_are_not_safe_everywhere(self, subtests: pytest.Subtests) -> None:
        for path in [
            "",
            "/etc/passwd",
            "../a",
            "a/../../b",
            "a//b",
            "./a",
            "a/",
            "a\\b",
            "C:a",
            "a b",
            "ä",
            "a\n",
            "a?",
            "a*",
            "a\0b",
            "a\x07b",
            ".",
        ]:
            with subtests.test(path=path), pytest.raises(ValidationError):
                Files(entries={path: b""})

    def test_files_that_differ_in_case_or_content(self) -> None:
        with pytest.raises(ValidationError, match="differ only in case"):
            Files(entries={"Mug.obj": b"", "mug.OBJ": b""})
        with pytest.raises(ValueError, match="two contents"):
            Files(entries={"a": b"1"}) | Files(entries={"a": b"2"})
        assert (Files(entries={"a": b"1"}) | Files(entries={"a": b"1", "b": b""})).under("x").sums().keys() == {
            "x/a",
            "x/b",
        }

    def test_spans_that_do_not_rise(self, subtests: pytest.Subtests) -> None:
        for span in [(2, 1, 3), (1, 3, 2), (0, 1, 2), (-1, 1, 2)]:
            with subtests.test(span=span), pytest.raises(ValidationError):
                SizeRange(low=span[0], typical=span[1], high=span[2])

    def test_colours_sizes_and_pictures(self) -> None:
        with pytest.raises(ValidationError):
            Material(id="m", base_color=(0.0, 0.0, 1.1, 1.0))
        with pytest.raises(ValidationError):
            Box(size=(1.0, 0.0, 1.0))
        with pytest.raises(ValidationError):
            Sphere(radius=-1.0)
        with pytest.raises(ValidationError, match="PNG"):
            Texture(name="t", png=b"GIF89a", width_px=1, height_px=1)
        with pytest.raises(ValidationError):
            Provenance(source="folder", path="", sha256="0" * 63)
        with pytest.raises(ValidationError):
            Issue(code="A1", severity=Severity.ERROR, message="")

    def test_scenes_that_do_not_hang_together(self) -> None:
        scene = kitchen()
        joint = scene.assets[0].joints[0]
        oven = scene.placements[0]
        wrong: list[dict[str, Any]] = [
            {"assets": scene.assets[:1]},
            {"assets": (*scene.assets, scene.assets[0])},
            {"placements": (*scene.placements, oven)},
            {"cameras": (scene.cameras[0].replace(name=oven.name),)},
            {"placements": (oven.replace(joints=(JointValue(joint="handle_of_nothing", value=0.0),)),)},
            {"placements": (oven.replace(joints=(JointValue(joint=joint.name, value=joint.range[1] + 0.01),)),)},
        ]
        for changes in wrong:
            with pytest.raises(ValidationError):
                scene.replace(**changes)
