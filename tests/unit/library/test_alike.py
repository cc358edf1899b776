"""Copies in a library: which one stays, what is said of all assets together; colours by area, and search by words."""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.cache.store import Store
from casa_assets.errors import Rejected
from casa_assets.ingest.run.inputs import Job, Result, Survey, stage_refusal
from casa_assets.ingest.run.run import Deduplicator
from casa_assets.ingest.sources.places import Found
from casa_assets.library import library_report
from casa_assets.library.clip import VIEWS, ClipModel, image_embeddings
from casa_assets.library.entry_files import read_refusal
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.pairs import color_distance, color_histogram, read_rows
from casa_assets.library.search import search_by_picture, search_by_words, tokens
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from casa_assets.model.issue import Status
from casa_assets.model.pose import Pose
from casa_assets.model.source import Source, SourceKind
from casa_assets.runs.engine import NEAR_DUPLICATE_CODE, cached_outcome
from casa_assets.runs.outcome import Outcome
from tests.support.asset.assets import ball, rigid_mug, textured_box
from tests.support.library.built_libraries import keep, similar_pairs
from tests.support.mesh.meshes import texture

pytestmark = pytest.mark.content("code", "library", keep=0)

LIMIT = registry.load().limits["alike_form"]
COLORS = {"red": (1.0, 0.1, 0.1), "blue": (0.1, 0.1, 1.0)}
BLUE, RED = (0.02, 0.05, 0.6, 1.0), (0.6, 0.05, 0.02, 1.0)


def mug(name: str, color: tuple[float, float, float, float] = RED, factor: float = 1.0, turn: float = 0.0) -> Asset:
    """The mug of the tests under a name of its own, painted, scaled, turned about z."""
    asset = rigid_mug()
    pose = Pose(position=(0.0, 0.0, 0.0), quaternion=(float(np.cos(turn / 2)), 0.0, 0.0, float(np.sin(turn / 2))))
    (link,) = asset.links
    visuals = tuple(v.replace(mesh=v.mesh.with_vertices(pose.apply(v.mesh.vertices) * factor)) for v in link.visuals)
    looks = tuple(Material(id=m.id, base_color=color) for m in asset.materials)
    digest = name.rpartition("_")[2] + "0" * 54
    origin = asset.provenance.replace(path=f"{name}.glb", sha256=digest)
    return asset.replace(id=name, links=(link.replace(visuals=visuals),), materials=looks, provenance=origin)


FIRST, COPY = mug("mug_aaaaaaaaaa"), mug("mug_bbbbbbbbbb", turn=0.9)
OTHER, LARGE = mug("mug_cccccccccc", BLUE), mug("mug_dddddddddd", factor=1.4)


def library(root: Path, *assets: Asset) -> Library:
    return Library(keep(root / "library", assets))


def told(place: Library, order: Sequence[Asset], arrived: Sequence[Asset]) -> list[tuple[str, str, str]]:
    """Kind, id and code of a run whose inputs are done with in some order, each published as the run would.

    Args:
        place: a library; what it has of the inputs was kept from an earlier run, the others come from workers.
    """
    standing = {folder.name: folder for folder in place.accepted()}
    made = Library(keep(place.root.parent / "made", arrived))
    with place.locked():
        results = []
        for asset in arrived:
            old = standing.get(asset.id)
            folder = old or shutil.copytree(made.folder("mug", asset.id), place.stage(asset.id), dirs_exist_ok=True)
            outcome = Outcome(True, staged=None if old else folder)
            number = [one.id for one in order].index(asset.id)
            results.append(Result(number, job_of(place, asset, old), outcome, folder, is_kept=old is not None))
        digests = frozenset(asset.provenance.sha256 for asset in order)

        def publish(result: Result) -> tuple[str, str, str]:
            done, job = result.outcome, result.job
            if done.accepted and done.staged:
                place.publish(done.staged, place.folder("mug", job.asset_id))
            elif not done.accepted:
                staged = stage_refusal(place, job, Rejected(done.code, done.message), twin=result.twin)
                place.publish(staged, place.refusal_folder(job.asset_id))
            return "accepted" if done.accepted else "rejected", job.asset_id, done.code

        found = list(Deduplicator(place, LIMIT, digests).publish(results, publish))
        place.sweep()
    return found


def job_of(place: Library, asset: Asset, old: Path | None = None) -> Job:
    source = Source(kind=SourceKind.FOLDER, path=f"{asset.id}.glb")
    survey = Survey(asset.provenance.sha256, "mug", 1.0, "")
    return Job(Found(place.root, source.path, source), survey, asset.id, place.root, {}, "0" * 64)


@pytest.mark.parametrize("arrived", [(FIRST, COPY, OTHER), (OTHER, COPY, FIRST), (COPY, FIRST, OTHER)])
def test_the_first_of_the_inputs_stays_whoever_is_done_first(tmp_path: Path, arrived: tuple[Asset, ...]) -> None:
    place = library(tmp_path)
    assert told(place, (FIRST, COPY, OTHER), arrived) == [
        ("accepted", FIRST.id, ""),
        ("rejected", COPY.id, NEAR_DUPLICATE_CODE),
        ("accepted", OTHER.id, ""),
    ]
    assert [f.name for f in place.accepted()] == [FIRST.id, OTHER.id]
    (folder,) = place.refused()
    refusal = read_refusal(folder)
    assert (refusal.code, refusal.twin) == (NEAR_DUPLICATE_CODE, f"mug/{FIRST.id}")
    assert refusal.message.startswith(f"duplicate of {FIRST.id}.glb ({FIRST.id}): 95 % of the surface within")


def test_what_stands_there_gives_way_to_an_earlier_input(tmp_path: Path) -> None:
    place = library(tmp_path, COPY)
    assert told(place, (FIRST, COPY), (COPY, FIRST)) == [
        ("accepted", FIRST.id, ""),
        ("rejected", COPY.id, NEAR_DUPLICATE_CODE),
    ]
    assert [f.name for f in place.accepted()] == [FIRST.id]
    assert [f.name for f in place.refused()] == [COPY.id]


def test_an_input_of_which_nothing_is_heard_holds_nobody_up(tmp_path: Path) -> None:
    """The number 0 never comes: the others are judged all the same, in their order."""
    place = library(tmp_path, FIRST, COPY, OTHER)
    folders = {one.id: place.folder("mug", one.id) for one in (FIRST, COPY, OTHER)}
    results = [
        Result(number, job_of(place, one), Outcome(True), folders[one.id], is_kept=True)
        for number, one in ((3, OTHER), (2, COPY), (1, FIRST))
    ]
    digests = frozenset(one.provenance.sha256 for one in (FIRST, COPY, OTHER))
    judged = Deduplicator(place, LIMIT, digests).publish(results, lambda result: result)
    assert [(one.job.asset_id, one.outcome.code) for one in judged] == [
        (FIRST.id, ""),
        (COPY.id, NEAR_DUPLICATE_CODE),
        (OTHER.id, ""),
    ]


def test_what_the_library_had_comes_first(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, COPY)
    assert told(place, (FIRST,), (FIRST,)) == [("rejected", FIRST.id, NEAR_DUPLICATE_CODE)]
    assert [f.name for f in place.accepted()] == [COPY.id]


def test_a_refusal_holds_as_long_as_its_twin_stands(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, COPY)
    told(place, (FIRST, COPY), (FIRST, COPY))
    (folder,) = place.refused()
    key = read_refusal(folder).cache_key
    known = cached_outcome([folder], COPY.id, key)
    assert known is not None
    assert known[1].code == NEAR_DUPLICATE_CODE
    with place.locked():
        place.forget(place.folder("mug", FIRST.id))
    assert cached_outcome([folder], COPY.id, key) is None, "it is due again"


def test_pairs_are_found_whatever_size_and_colour_and_measured_once(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, COPY, OTHER, LARGE, ball())
    store = Store(tmp_path / "store")
    found = list(similar_pairs(list(read_rows(place)), store))
    mugs = [FIRST.id, COPY.id, OTHER.id, LARGE.id]
    assert [(p.one, p.other) for p in found] == [(a, b) for i, a in enumerate(mugs) for b in mugs[i + 1 :]]
    assert all(p.same_form(LIMIT) for p in found)
    assert {(p.one, p.other) for p in found if p.twins(LIMIT)} == {(FIRST.id, COPY.id)}
    assert found[2].size == pytest.approx(1.4, rel=1e-3)
    for folder in place.accepted():
        (folder / "model.xml").unlink()
        for mesh in (folder / "meshes").iterdir():
            mesh.unlink()
    assert list(similar_pairs(list(read_rows(place)), store)) == found


class Painter:
    """Stands in for a model: a picture is its mean colour, and so is every word that names one."""

    def __init__(self) -> None:
        self.shown = 0

    def encode_images(self, pictures: Sequence[bytes]) -> npt.NDArray[np.float64]:
        self.shown += len(pictures)
        found = []
        for png in pictures:
            with Image.open(io.BytesIO(png)) as image:
                pixels = np.asarray(image.convert("RGB"), dtype=np.float64).reshape(-1, 3)
            vivid = pixels[np.ptp(pixels, axis=1) > 60]
            found.append(vivid.mean(axis=0) if len(vivid) else np.ones(3))
        rows = np.array(found)
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def encode_text(self, sentences: Sequence[str]) -> npt.NDArray[np.float64]:
        named = [[COLORS[w] for w in COLORS if w in s] for s in sentences]
        rows = np.array([n[0] if n else (0.3, 1.0, 0.3) for n in named])
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def eye(self, mark: str = "f" * 64) -> ClipModel:
        return ClipModel("painter.pt", mark, 10.0, self.encode_images, self.encode_text)


def test_pictures_are_looked_at_once_for_each_content_and_weights(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, OTHER)
    painter = Painter()
    hits = search_by_picture("red mug", place, painter.eye(), 5)
    assert [hit.id for hit in hits] == [FIRST.id, OTHER.id]
    assert hits[0].score > hits[1].score + 0.2
    assert painter.shown == 2 * len(VIEWS)
    assert [hit.id for hit in search_by_picture("blue mug", place, painter.eye(), 1)] == [OTHER.id]
    assert painter.shown == 2 * len(VIEWS), "kept beside the library"
    store = Store(place.cache)
    numbers = image_embeddings(next(read_rows(place)), painter.eye("e" * 64), store)
    assert painter.shown == 3 * len(VIEWS), "other weights look anew"
    assert numbers.shape == (len(VIEWS), 3)


def test_the_whole_says_when_nobody_looked_and_remembers_who_did(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, COPY, OTHER)
    blind = library_report.compare_library(place, EntryTable(place))
    assert [i.code for i in blind.report.issues] == ["LIB001"] * 3
    unseen = {r.code: r.reason for r in blind.report.results if r.status is Status.NOT_RUN}
    assert unseen == dict.fromkeys(("LIB002", "LIB003"), "no weights of CLIP were given (--clip-weights)")
    assert (blind.weights, blind.seen, blind.looks) == ("", {}, ())
    seen = library_report.compare_library(place, EntryTable(place), Painter().eye())
    assert seen.weights == "painter.pt"
    assert seen.seen[FIRST.id].category == "mug"
    assert len(seen.seen[FIRST.id].others) == 3
    assert seen.looks[0][:2] == (FIRST.id, COPY.id)
    assert [i.pointer for i in seen.report.issues if i.code == "LIB002"] == [COPY.id]
    assert library_report.compare_library(place, EntryTable(place)) == seen, "what is still the same is not forgotten"
    assert library_report.read_library_report(place.root) == seen
    with place.locked():
        place.forget(place.folder("mug", COPY.id))
    keep(place.root, [LARGE])
    later = library_report.compare_library(place, EntryTable(place))
    (reason,) = {r.reason for r in later.report.results if r.status is Status.NOT_RUN}
    assert "1 of 3 assets were not there when somebody looked" in reason
    assert set(later.seen) == {FIRST.id, OTHER.id}
    (place.root / library_report.NAME).write_text("{", encoding="utf-8")
    assert library_report.read_library_report(place.root) is None
    library_report.compare_library(place, EntryTable(place))
    assert json.loads((place.root / library_report.NAME).read_text())["schema_version"] == 2


def test_words_alone_find_by_category_and_colour(tmp_path: Path) -> None:
    place = library(tmp_path, FIRST, OTHER, ball())
    hits = search_by_words("a red mug", place, 5)
    assert [hit.id for hit in hits[:2]] == [FIRST.id, OTHER.id]
    assert hits[0].reason == "100% red, 'mug' is its category"
    assert search_by_words("blue mugs", place, 5)[0].id == OTHER.id
    assert [hit.id for hit in search_by_words("fruit", place, 5)] == [ball().id]
    assert search_by_words("bicycle", place, 5) == []
    assert tokens("Glasses, 2 red MUGS") == ["glasse", "2", "red", "mug"]


def painted(red: float, green: float, blue: float) -> Asset:
    """The ball in one colour, as displayed, 0..1."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
    asset = ball()
    looks = tuple(Material(id=m.id, base_color=(*linear, 1.0)) for m in asset.materials)
    return asset.replace(materials=looks)


def printed(*colors: tuple[int, int, int]) -> Asset:
    pixels = np.repeat(np.array(colors, dtype=np.uint8)[None], 8, axis=0).repeat(8, axis=1)
    asset = textured_box()
    skin = texture("stripes", pixels)
    looks = tuple(Material(id=m.id, base_color=(1.0, 1.0, 1.0, 1.0), base_color_texture=skin) for m in asset.materials)
    return asset.replace(materials=looks)


def test_colours_have_their_names(subtests: pytest.Subtests) -> None:
    for color, name in [
        ((0.8, 0.1, 0.1), "red"),
        ((1.0, 0.5, 0.0), "orange"),
        ((1.0, 0.9, 0.1), "yellow"),
        ((0.1, 0.6, 0.2), "green"),
        ((0.1, 0.7, 0.75), "turquoise"),
        ((0.1, 0.2, 0.8), "blue"),
        ((0.5, 0.1, 0.6), "purple"),
        ((1.0, 0.6, 0.7), "pink"),
        ((0.4, 0.22, 0.08), "brown"),
        ((0.87, 0.8, 0.68), "beige"),
        ((0.5, 0.5, 0.5), "grey"),
        ((0.05, 0.05, 0.05), "black"),
        ((0.97, 0.97, 0.97), "white"),
    ]:
        with subtests.test(color=color, name=name):
            assert color_histogram(painted(*color)).names == ((name, 1.0),)


def test_pictures_are_looked_up_and_shares_are_by_area() -> None:
    found = color_histogram(printed((255, 0, 0), (255, 255, 255), (255, 255, 255), (255, 255, 255)))
    assert [name for name, _ in found.names] == ["white", "red"]
    assert dict(found.names)["red"] == pytest.approx(0.25, abs=0.03)
    assert found.stated


def test_another_print_is_farther_than_another_order_of_the_same() -> None:
    one, same = printed((255, 0, 0), (255, 255, 255)), printed((255, 255, 255), (255, 0, 0))
    other = printed((0, 0, 255), (255, 255, 255))
    assert color_distance(color_histogram(one), color_histogram(same)) < 1.0
    assert color_distance(color_histogram(one), color_histogram(other)) > 10.0
