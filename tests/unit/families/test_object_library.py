"""A library of objects out of numbers: made once, gone on with, read by what reads any library."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from casa_assets.addons.robocasa.run import ExportResult, export
from casa_assets.families.build import (
    PROPORTION_STEP,
    FamilyResult,
    build_all,
    build_asset,
    family_of,
    object_requests,
    params_of,
    shape_digest,
)
from casa_assets.library.entry_files import read_asset
from casa_assets.library.library import Library
from casa_assets.library.search import entries_that
from casa_assets.model.asset.asset import Asset
from casa_assets.show.reports.library_page import write as write_page
from tests.support.library.libraries import tree

pytestmark = pytest.mark.content("code", "families", keep=0)

NAMES, COUNT = ("candy", "saucepan_lid"), 2


def build(library: Path) -> list[FamilyResult]:
    return list(build_all(object_requests(NAMES, COUNT, 0), library, jobs=1, drawn=False))


def entries(library: Path) -> dict[str, bytes | None]:
    """All files of a library but those of its cache."""
    return {name: data for name, data in tree(library).items() if not name.startswith(".casa/")}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("objects") / "lib"
    results = build(folder)
    assert [r.problems for r in results if not r.passed] == []
    assert not any(r.is_kept for r in results)
    return folder


def test_every_member_is_an_entry_and_a_row_and_pages_and_exports_read_it(library: Path, tmp_path: Path) -> None:
    folders = list(Library(library).accepted())
    assert Counter(f.parent.name for f in folders) == dict.fromkeys(NAMES, COUNT)
    rows = list(entries_that(Library(library), ()))
    assert sorted(row.id for row in rows) == sorted(f.name for f in folders)
    assert {row.producer for row in rows} == {"family"}
    assert {row.split for row in rows} <= {"train", "test"}
    assert json.loads((library / "library.json").read_text())["report"]["subject"]
    write_page(library, tmp_path / "report.html")
    assert NAMES[0] in (tmp_path / "report.html").read_text(encoding="utf-8")
    done = [one for one in export(library, tmp_path / "out") if isinstance(one, ExportResult)]
    assert all(one.model for one in done)
    assert {one.id: one.split for one in done} == {f.name: str(read_asset(f).labels.split) for f in folders}


def test_what_is_missing_is_made_again_to_the_same_bytes(library: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(library, tmp_path / "lib")
    before = entries(copy)
    lost, broken = list(Library(copy).accepted())[:2]
    shutil.rmtree(lost)
    (broken / "model.xml").unlink()
    results = build(copy)
    assert {Path(r.folder) for r in results if not r.is_kept} == {lost, broken}
    assert all(r.passed for r in results)
    assert entries(copy) == before
    assert all(r.is_kept for r in build(copy))


def member(name: str, index: int, cache: Path, **changes: Any) -> tuple[Asset, str]:
    """An asset, and the digest of its shape."""
    request = object_requests([name], index + 1, 0)[index]
    params = params_of(request).replace(**changes)
    asset = build_asset(family_of(request), params, cache)
    return asset, shape_digest(asset, params)


def test_shapes_differ_by_proportions_and_design_alone(tmp_path: Path) -> None:
    """Colours and seeds have no part in them."""
    (_, can), (_, apple) = member("can", 0, tmp_path), member("apple", 0, tmp_path)
    assert member("can", 0, tmp_path, label=None, body="foil_gold")[1] == can
    assert member("apple", 0, tmp_path, seed=7_777)[1] == apple
    height = params_of(object_requests(["can"], 1, 0)[0]).model_dump()["height"]
    assert member("can", 0, tmp_path, height=float(height * np.exp(2 * PROPORTION_STEP)))[1] != can
    assert member("can", 0, tmp_path, grooves=5)[1] != can


def test_one_shape_is_never_on_both_sides_of_a_split(tmp_path: Path) -> None:
    sides: dict[str, set[str]] = {}
    for index in range(12):
        asset, digest = member("candy", index, tmp_path)
        sides.setdefault(digest, set()).add(str(asset.labels.split))
    assert len(sides) < 12  # some are alike
    assert all(len(found) == 1 for found in sides.values())


def test_a_mug_is_taken_by_its_handle_and_fingers_close_on_things_within_their_opening(tmp_path: Path) -> None:
    mug, _ = member("mug", 0, tmp_path)
    handle = next(site for site in mug.sites if site.name == "grasp_handle")
    assert (handle.size or (1.0,))[0] < 0.03
    assert handle.pose.position[0] > 0.35 * float(np.ptp(mug.bounds, axis=0)[0])
    for name in ("apple", "can", "bowl"):
        asset, _ = member(name, 1, tmp_path)
        sites = [site for site in asset.sites if site.name.startswith("grasp_")]
        assert sites, name
        assert all(site.size and 0 < site.size[0] <= 0.08 for site in sites)
        places = np.array([site.pose.position for site in sites])
        assert (np.abs(places - asset.bounds.mean(axis=0)) <= np.ptp(asset.bounds, axis=0) / 2 + 0.002).all()
