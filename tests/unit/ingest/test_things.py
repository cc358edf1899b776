"""One object is told from several things, and a file is taken apart into its things."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.things import guess_of_things, model_of_thing, things_of
from casa_assets.library.review import DOUBTFUL
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.asset import Guess
from casa_assets.model.asset.material import Material
from casa_assets.model.record import Vec3
from casa_assets.model.source import Bundle, RawModel, RawPart, Source, SourceKind, Up
from tests.support.mesh.mesh_files import Gltf, codes_of, load_bytes
from tests.support.mesh.meshes import box_mesh, some
from tests.support.mesh.raw_models import joined


def box(size: Vec3, center: Vec3, *nodes: str) -> RawPart:
    return RawPart(name="part", mesh=box_mesh(size, center, True), material=Material(id="grey"), nodes=nodes)


def model(*parts: RawPart) -> RawModel:
    named = tuple(part.replace(name=f"part_{number}") for number, part in enumerate(parts))
    return RawModel(parts=named, metres_per_unit=1.0, up=Up.Z, format="glb")


def guess(shown: RawModel, path: str = "thing.glb", category: str = "object") -> Guess | None:
    known = registry.load()
    source = Source(kind=SourceKind.FOLDER, path=path)
    return guess_of_things(shown, source, known.category(category), known.vocabulary, known.other_things)


def is_in_review(shown: RawModel, path: str = "thing.glb", category: str = "object") -> bool:
    found = guess(shown, path, category)
    return found is not None and found.confidence < DOUBTFUL


def stool(x: float = 0.0, name: str = "stool") -> list[RawPart]:
    """A seat on four legs."""
    legs = [box((0.04, 0.04, 0.4), (x + i * 0.15, j * 0.15, 0.2), "root", name) for i in (-1, 1) for j in (-1, 1)]
    return [box((0.4, 0.4, 0.05), (x, 0, 0.425), "root", name), *legs]


def test_one_object_of_many_parts_is_one(subtests: pytest.Subtests) -> None:
    for parts in [
        [box((0.1, 0.1, 0.2), (0, 0, 0.1))],
        stool(),
        [
            *(box((0.02, 0.3, 1.8), (x, 0, 0.9), "shelf") for x in (-0.4, 0.4)),
            *(box((0.78, 0.3, 0.02), (0, 0, z), "shelf") for z in (0.1, 0.6, 1.1, 1.6)),
        ],
        [box((0.2, 0.2, 0.02), (0, 0, 0.01)), box((0.02, 0.02, 0.4), (0, 0, 0.2)), box((0.3, 0.3, 0.2), (0, 0, 0.51))],
        [
            box((0.8, 0.8, 0.2), (0, 0, 0.4)),
            box((0.8, 0.1, 0.6), (0, 0.35, 0.8)),
            *(box((0.2, 0.2, 0.3), (x, y, 0.15)) for x in (-0.3, 0.3) for y in (-0.3, 0.3)),
        ],
        [
            box((0.6, 0.4, 0.3), (0, 0, 0.2)),
            *(box((0.1, 0.03, 0.1), (x, y, 0.05)) for x in (-0.2, 0.2) for y in (-0.23, 0.23)),
        ],
        [box((0.3, 0.3, 0.02), (0, 0, 0.01)), *(box((0.02, 0.02, 0.01), (x / 20, 0, 0.025)) for x in range(-5, 6))],
    ]:
        with subtests.test(parts=parts):
            assert not is_in_review(model(*parts))


def test_several_things_are_for_a_person(subtests: pytest.Subtests) -> None:
    for parts, reason in [
        ([*stool(), *stool(1.0, "other")], "stand apart"),
        (
            [
                box((1.0, 1.0, 0.01), (0, 0, 0)),
                *(box((0.1, 0.1, 0.2), (x, 0, 0.105)) for x in (-0.4, -0.2, 0, 0.2, 0.4)),
            ],
            "one ground",
        ),
        (
            [
                box((3, 3, 0.05), (0, 0, -0.03)),
                box((0.05, 3, 2.5), (-1.5, 0, 1.2)),
                box((3, 0.05, 2.5), (0, 1.5, 1.2)),
                *(part for x, name in ((0.0, "stool"), (0.8, "second"), (-0.8, "third")) for part in stool(x, name)),
            ],
            "walls stand around",
        ),
        (
            [
                box((0.4, 0.4, 0.06), (0, 0, 0.03)),
                box((0.03, 0.03, 0.06), (0.24, 0, 0.03)),
                box((0.06, 0.03, 0.03), (-0.26, 0.1, 0.015)),
                box((0.03, 0.06, 0.03), (-0.26, -0.1, 0.015)),
            ],
            "lie beside it",
        ),
    ]:
        with subtests.test(parts=parts, reason=reason):
            found = some(guess(model(*parts)))
            assert found.confidence < DOUBTFUL
            assert reason in found.reason


def test_names_of_what_is_no_household_object(subtests: pytest.Subtests) -> None:
    for path, category, expected in [
        ("fox.glb", "object", True),
        ("fox_mug.glb", "mug", False),
        ("Sword.glb", "object", True),
        ("office.glb", "object", True),
        ("shaderBall.glb", "ball", True),
        ("cabinet/IAIDrawerW60.glb", "cabinet", True),
        ("mug.glb", "mug", False),
    ]:
        with subtests.test(path=path, category=category, expected=expected):
            assert is_in_review(model(box((0.1, 0.1, 0.1), (0, 0, 0))), path, category) is expected


def test_a_set_is_taken_apart_by_contact_and_named_by_its_nodes() -> None:
    waste = box((0.2, 0.2, 0.6), (2, 0, 0.3), "root", "bin")
    things = things_of(model(*stool(0, "wooden_stool"), *stool(1.0, "metal_stool"), waste))
    assert [(one.name, len(one.parts), one.count) for one in things] == [("bin", 1, 1), ("wooden_stool", 5, 2)]


def test_things_on_a_ground_are_told_from_it_and_crumbs_belong_to_the_nearest() -> None:
    ground = box((2, 2, 0.02), (0, 0, -0.01), "root", "floor")
    crumb = box((0.01, 0.01, 0.01), (0.56, 0, 0.3), "root", "stool")
    things = things_of(model(ground, *stool(0.3), crumb, box((0.5, 0.3, 0.6), (-0.6, 0, 0.3), "root", "chest")))
    assert {one.name: len(one.parts) for one in things} == {"floor": 1, "stool": 6, "chest": 1}


def test_mirrored_things_are_not_equal() -> None:
    hook = joined(box_mesh((0.1, 0.3, 0.1), (0, 0, 0), True), box_mesh((0.3, 0.05, 0.07), (0.1, 0.1, 0.1), True))
    mirrored = hook.with_vertices(hook.vertices * (-1.0, 1.0, 1.0) + (2.0, 0.0, 0.0))
    turned = hook.with_vertices(hook.vertices * (-1.0, -1.0, 1.0) + (4.0, 0.0, 0.0))
    parts = [RawPart(name=f"p{i}", mesh=mesh, material=Material(id="m"), nodes=("root", f"hook_{i}"))
             for i, mesh in enumerate((hook, mirrored, turned))]  # fmt: skip
    assert [(one.name, one.count) for one in things_of(model(*parts))] == [("hook_0", 2), ("hook_1", 1)]


def test_a_thing_is_read_alone_and_its_id_hangs_on_file_and_node(tmp_path: Path) -> None:
    whole = model(*stool(0, "stool"), box((0.2, 0.2, 0.9), (2, 0, 0.45), "root", "bin"))
    alone = model_of_thing(whole, "bin", "set.glb")
    assert len(alone.parts) == 1
    assert codes_of(alone) == {codes.TAKEN_APART}
    with pytest.raises(Rejected, match="nothing called 'jar'"):
        model_of_thing(whole, "jar", "set.glb")
    files = {"set.glb": b"bytes"}
    digests = [Bundle(main="set.glb", files=files, thing=name).sha256 for name in ("", "bin", "stool")]
    assert len(set(digests)) == 3
    assert Bundle(main="other.glb", files={"other.glb": b"bytes"}, thing="bin").sha256 == digests[1]


def test_instances_are_expanded_and_are_several_things() -> None:
    # A cube-like tetrahedron that a node places thrice, ten units apart, each twice as large as in the mesh.
    made = Gltf([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3])
    places = made.add(np.array([(0, 0, 0), (10, 0, 0), (20, 0, 0)], dtype="<f4"), "VEC3")
    attributes = {"TRANSLATION": places, "SCALE": made.add(np.full((3, 3), 2, dtype="<f4"), "VEC3")}
    made.node["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    made.document["extensionsUsed"] = made.document["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    read = load_bytes("x.glb", made.glb())
    assert read.instances == 3
    assert [part.mesh.vertices.min(axis=0).tolist() for part in read.parts] == [[0, 0, 0], [10, 0, 0], [20, 0, 0]]
    assert read.parts[0].mesh.vertices.max() == 2
    assert is_in_review(read)
    (one,) = things_of(read)
    assert (one.name, one.count) == ("thing", 3)
