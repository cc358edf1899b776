"""Bombs are stopped by limits, each an option, and what a limit turned away is taken up once it is raised."""

from __future__ import annotations

import gzip
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from casa_assets.errors import Rejected
from casa_assets.formats.read import raw_parts
from casa_assets.formats.read.formats import sniff
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.sources import places
from casa_assets.ingest.sources.discover import collect
from casa_assets.ingest.sources.rows import MAX_BROKEN_ROWS
from casa_assets.model import rejection_codes
from casa_assets.runs.outcome import Event
from tests.support.hostile.access_audit import Watch
from tests.support.library.libraries import BOXES, box_obj, casa, casa_here, input_rows
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, Gltf, codes_of, inputs_of, load_bytes, png

PICTURE = np.full((64, 64, 3), 90, dtype=np.uint8)
PARENT_BYTES = 1_200_000_000


def make_box(folder: Path) -> Path:
    """A carton with a picture of 64 pixels."""
    folder.mkdir(parents=True)
    rows = box_obj(BOXES["milk_carton"]).splitlines()
    faces = [" ".join(["f", *(f"{v}/{n}" for n, v in enumerate(r.split()[1:], 1))]) for r in rows if r[0] == "f"]
    text = ["mtllib a.mtl", *(r for r in rows if r[0] == "v"), "vt 0 0", "vt 1 0", "vt 0 1", "usemtl m", *faces]
    (folder / "milk_carton.obj").write_text("\n".join(text) + "\n", encoding="ascii")
    (folder / "a.mtl").write_text("newmtl m\nmap_Kd a.png\n", encoding="ascii")
    (folder / "a.png").write_bytes(png(PICTURE))
    return folder


def run(folder: Path, library: Path, guards: Mapping[str, float], **options: Any) -> Event:
    """The event of the only input."""
    (event,) = ingest([folder], Options(library, guards=guards, jobs=1, **options))
    return event


@pytest.mark.slow
def test_a_limit_turns_away_and_raising_it_takes_up(tmp_path: Path) -> None:
    folder, library = make_box(tmp_path / "in"), tmp_path / "library"
    assert run(folder, library, {"input_bytes": 300}).code == rejection_codes.TOO_LARGE
    assert run(folder, library, {"input_faces": 11}).code == rejection_codes.TOO_LARGE
    assert run(folder, library, {}, memory_bytes=40_000_000).code == "RUN002"
    assert run(folder, library, {}, seconds=0.05).code == "RUN001"
    small = run(folder, library, {"input_texture_px": 63})
    assert small.kind == "accepted"
    assert rejection_codes.IMAGE_REFUSED in {w.code for w in small.warnings}
    whole = run(folder, library, {})
    assert whole.kind == "accepted", "a picture that was left out is taken in once it may be"
    assert rejection_codes.IMAGE_REFUSED not in {w.code for w in whole.warnings}
    assert run(folder, library, {"input_faces": 1e9, "input_bytes": 1e9}).kind == "kept", "nothing would change"


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--max-size", "0.0003"], "SRC015"),
        (["--max-faces", "11"], "SRC015"),
        (["--timeout", "0.05"], "RUN001"),
        pytest.param(["--max-texture", "63"], "SRC047", marks=pytest.mark.slow),
        pytest.param(["--max-pixels", "0.004"], "SRC047", marks=pytest.mark.slow),
    ],
)
def test_limits_are_options(tmp_path: Path, options: list[str], code: str) -> None:
    """Pictures that are too large are left out, with a warning."""
    done = casa_here("ingest", make_box(tmp_path / "in"), "--library", tmp_path / "library", "--json", *options)
    (row,) = input_rows(done.stdout)
    if code == "SRC047":
        assert row["status"] == "accepted"
        assert code in {w["code"] for w in row["warnings"]}
    else:
        assert (done.returncode, row["code"]) == (1, code), done.stderr


@pytest.mark.slow
def test_indices_cannot_fill_the_memory_of_the_parent(tmp_path: Path) -> None:
    """They would take gigabytes if they were believed."""
    for name, data in {
        "values/manifest.json": b"[" + b"[]," * 30_000_000 + b"[]]",
        "rows/manifest.jsonl": b"1\n" * 20_000_000,
        "zipped/object-paths.json.gz": gzip.compress(b"[" * 300_000_000, 1),
        "deep/manifest.jsonl": b'{"id": "a", "file": ' + b"[" * 4_000_000,
        "huge/manifest.jsonl": b"",
    }.items():
        (tmp_path / "in" / name).parent.mkdir(parents=True)
        (tmp_path / "in" / name).write_bytes(data)
    (tmp_path / "in" / "zipped" / "glbs").mkdir()
    os.truncate(tmp_path / "in" / "huge" / "manifest.jsonl", 20_000_000_000)
    watch = Watch(tmp_path / "watch")
    done = casa("ingest", tmp_path / "in", "--library", tmp_path / "library", "--json", **watch.environment)
    assert done.returncode == 1, done.stderr
    rows = input_rows(done.stdout)
    said: dict[str, set[str]] = {}
    for row in rows:
        said.setdefault(row["path"].split("/")[0], set()).add(row["code"])
    assert said.keys() == {"values", "rows", "zipped", "deep", "huge"}
    assert all(code.startswith("MAN") or code == "SRC015" for found in said.values() for code in found), said
    assert len(rows) < MAX_BROKEN_ROWS + 10
    (peak,) = watch.peaks("casa_assets/cli/main.py")
    assert peak < PARENT_BYTES


def test_broken_rows_are_told_up_to_a_number(tmp_path: Path) -> None:
    (tmp_path / "manifest.jsonl").write_bytes(b"1\n" * (MAX_BROKEN_ROWS + 500))
    _, refused = inputs_of(tmp_path)
    assert len(refused) == MAX_BROKEN_ROWS + 1
    assert refused[-1].code == rejection_codes.BAD_MANIFEST
    assert str(MAX_BROKEN_ROWS) in refused[-1].message


def test_a_zip_is_never_unpacked() -> None:
    with pytest.raises(Rejected, match=f"{rejection_codes.WRONG_TYPE}: .*zip archive"):
        sniff(b"PK\x03\x04" + b"\0" * 100, "a.zip")


def test_numbers_of_a_row_that_are_none_are_told(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(OBJ_TRIANGLE, encoding="ascii")
    (tmp_path / "manifest.jsonl").write_text('{"id": "a", "file": "a.obj", "scale": 1e999}\n', encoding="ascii")
    ((one,), _) = inputs_of(tmp_path)
    assert [note.code for note in collect(one, LIMITS).notes] == [rejection_codes.NUMBER_IGNORED]


@pytest.mark.parametrize(("far", "is_told"), [(0.0, False), (100.0, False), (1e6, True)])
def test_single_precision_far_from_the_origin_is_told(far: float, is_told: bool) -> None:
    points = [(far, 0.0, 0.0), (far + 1.0, 0.0, 0.0), (far, 1.0, 0.0)]
    assert (rejection_codes.PRECISION_LOST in codes_of(load_bytes("a.glb", Gltf(points).glb()))) == is_told


def test_ear_clipping_has_a_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stars of a thousand corners: the first are cut rightly, all are cut, and what was cut as a fan is counted."""
    angles = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    reach = np.where(np.arange(1000) % 2, 1.0, 0.5)
    star = np.column_stack((reach * np.cos(angles), reach * np.sin(angles), np.zeros(1000)))
    monkeypatch.setattr(raw_parts, "MAX_TESTS", 5000)
    triangles, _, fanned = raw_parts.triangulate(np.tile(star, (8, 1, 1)))
    assert len(triangles) == 8 * 998
    assert 0 < fanned < 8


@pytest.mark.parametrize(
    ("owner", "name", "said"),
    [
        (places, "check_file", f"{rejection_codes.UNREADABLE}: .*exchanged"),
        (os, "lstat", f"{rejection_codes.UNREADABLE}|{rejection_codes.LINK_OUTSIDE}"),
    ],
)
def test_a_file_exchanged_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, owner: ModuleType, name: str, said: str
) -> None:
    """Checked as a whole, or by one call; then a link is put in its place: what that leads to is not taken for it."""
    place, secret = tmp_path / "in" / "a.obj", tmp_path / "secret.obj"
    place.parent.mkdir()
    for path in (place, secret):
        path.write_text(OBJ_TRIANGLE, encoding="ascii")
    look = getattr(owner, name)

    def exchange_once(path: str, *words: Path, **options: int) -> os.stat_result:
        found: os.stat_result = look(path, *words, **options)
        if os.fspath(path) == str(place) and not stat.S_ISLNK(found.st_mode):
            place.unlink()
            place.symlink_to(secret)
        return found

    monkeypatch.setattr(owner, name, exchange_once)
    with pytest.raises(Rejected, match=said):
        places.read_file(str(place), place.parent, 1e6)
