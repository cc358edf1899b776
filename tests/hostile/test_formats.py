"""Broken and hostile files of the formats that libraries read, and archives: each ends as it should, soon and small."""

from __future__ import annotations

import resource
import time
from collections import Counter
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.clean import clean
from casa_assets.ingest.load import load
from casa_assets.ingest.sources import Found, Refused, collect, discover
from tests.access_audit import Watch
from tests.hostile_formats import SOUND, Hostile, hostile_inputs
from tests.hostile_set import Said
from tests.libraries import casa, input_rows

INPUTS = hostile_inputs()
SECONDS = 10.0
MEMORY_BYTES = 2_500_000_000


def put(one: Hostile, folder: Path) -> Path:
    """The input on disk, with what lies beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in {one.name: one.data, **one.beside}.items():
        (folder / name).write_bytes(data)
    return folder / one.name


def verdicts(path: Path) -> list[str]:
    """What becomes of all inputs in a file."""
    limits = registry.load().limits
    out = []
    for found in discover([path], Counter()):
        if isinstance(found, Refused):
            out.append(found.code)
            continue
        assert isinstance(found, Found)
        try:
            load(collect(found, limits), limits)
            out.append(SOUND)
        except Rejected as error:
            out.append(error.code)
    return out


def test_there_are_enough_of_them() -> None:
    assert len(INPUTS) >= 60


@pytest.mark.parametrize("one", INPUTS, ids=lambda one: one.name)
def test_a_hostile_input_ends_as_it_should(tmp_path: Path, one: Hostile) -> None:
    path = put(one, tmp_path)
    begin = time.process_time()
    said = verdicts(path)
    assert time.process_time() - begin < SECONDS
    assert set(said) <= set(one.wanted), said
    assert said or not one.wanted
    assert set(said) - {SOUND} <= registry.load().rejections.keys()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 < MEMORY_BYTES


@pytest.mark.slow
@pytest.mark.parametrize("step", [9, pytest.param(1, marks=pytest.mark.certify)])
def test_many_of_them_in_one_run(tmp_path: Path, step: int) -> None:
    """Nobody goes beyond the folders, no worker dies, and every input is told."""
    inputs = INPUTS[::step]
    for one in inputs:
        put(one, tmp_path / "in" / one.name.replace(".", "_"))
    watch = Watch(tmp_path / "watch")
    done = casa(
        "ingest", tmp_path / "in", "--library", tmp_path / "library", "--json", "--memory", 2, **watch.environment
    )
    assert done.returncode == 1, done.stderr[-2000:]
    said = [Said.of(row) for row in input_rows(done.stdout)]
    assert not [one for one in said if one.code in ("RUN001", "RUN002", "RUN003", "RUN004")]
    told = {one.path.split("!")[0].rpartition("/")[2] for one in said}
    assert told >= {one.name for one in inputs if one.wanted}
    assert watch.escapes([tmp_path / "in"], [tmp_path / "library"]) == []


def test_sound_files_are_sound(tmp_path: Path) -> None:
    """The specimens that the hostile ones are made from: else their rejections would mean nothing."""
    from tests.fuzz_corpus import packed_specimens, specimens

    limits = registry.load().limits
    for name, files in {**specimens(), **packed_specimens()}.items():
        folder = tmp_path / name
        folder.mkdir()
        for file, data in files.items():
            (folder / file).write_bytes(data)
        for found in discover([folder / next(iter(files))]):
            assert isinstance(found, Found)
            assert clean(load(collect(found, limits), limits)).parts
