"""Which shard an input belongs to, and the refused rows of shards put together again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from casa_assets.errors import CasaError
from casa_assets.ingest.run import shards as record
from casa_assets.ingest.run.inputs import discover_inputs
from casa_assets.ingest.run.shards import Recorder, Shard, ShardHeader, file_of, index_of
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.library import entry as refused_rows
from casa_assets.library.entry import RefusedFile, RefusedRows
from casa_assets.library.library import Library
from casa_assets.model.source import Source, SourceKind
from tests.support.library.sharded_inputs import make_sharded_inputs


def test_what_is_no_shard_is_refused(subtests: pytest.Subtests) -> None:
    for text in ["", "3", "0/4", "5/4", "-1/4", "1/0", "0/0", "1/4/2", "a/b", "1/4 ", "²/4"]:
        with subtests.test(text=text), pytest.raises(CasaError, match=r"i from 1 to n"):
            Shard.parse(text)


def test_the_shard_of_a_file_follows_from_its_path_alone() -> None:
    # Another number here would send every file of a user's shards elsewhere: what they have made would be made again.
    assert [index_of(f"meshes/{i}.glb", 16) for i in range(6)] == [14, 12, 12, 3, 14, 1]
    sizes = Counter(index_of(f"meshes/{i}.glb", 8) for i in range(8000))
    assert sorted(sizes) == list(range(1, 9))
    assert min(sizes.values()) > 900
    assert max(sizes.values()) < 1100


def test_each_input_is_in_one_shard_and_files_that_come_change_no_other(tmp_path: Path) -> None:
    source = make_sharded_inputs(tmp_path / "in")

    def shards() -> dict[str, list[int]]:
        found = list(discover_inputs([source], tmp_path / "library"))
        of: dict[str, list[int]] = {}
        for one in found:
            name = one.source.place if isinstance(one, Found) else f"{one.path} {one.message}"
            of[name] = [index for index in range(1, 6) if Shard(index, 5).has(one)]
        return of

    before = shards()
    assert {len(indices) for indices in before.values()} == {1}
    (source / "a_new_one.obj").write_text("v 0 0 0\n", encoding="ascii")
    after = shards()
    assert {name: after[name] for name in before} == before


def test_an_archive_stays_together(tmp_path: Path) -> None:
    source = make_sharded_inputs(tmp_path / "in")
    found = [one for one in discover_inputs([source], tmp_path / "library") if isinstance(one, Found)]
    assert {file_of(one) for one in found if one.archive} == {"pack.zip"}
    assert {file_of(one) for one in found if one.source.uid} == {"rows/box.obj"}


@given(
    rows=st.lists(st.tuples(st.sampled_from("abcdef"), st.sampled_from(["MAN001", "SRC020"])), max_size=60),
    count=st.integers(1, 4),
)
def test_refused_rows_of_shards_are_those_of_one_run(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str, str]], count: int
) -> None:
    library = Library(tmp_path_factory.getbasetemp() / "none")
    inputs = [Refused(path, code, f"row {number}") for number, (path, code) in enumerate(rows)]
    with pytest.MonkeyPatch.context() as patch:
        for module in (refused_rows, record):
            patch.setattr(module, "MAX_FILES", 4)
        patch.setattr(refused_rows, "MAX_ROWS_PER_FILE", 3)
        assert _put_together(library, inputs, count) == _of(library, inputs)


def _of(library: Library, inputs: Sequence[Found | Refused]) -> list[RefusedFile]:
    rows = RefusedRows(library)
    for one in inputs:
        assert isinstance(one, Refused)
        rows.add(one)
    return list(rows.files())


def recorder(library: Library, index: int, count: int) -> Recorder:
    words = {"category": "", "split": False, "keep_duplicates": False, "limits": {}, "cache_key": "", "made_by": ""}
    return Recorder(library, ShardHeader(index=index, count=count, is_complete=False, roots=(), **words))


def _put_together(library: Library, inputs: Sequence[Found | Refused], count: int) -> list[RefusedFile]:
    """The refused files of all shards, as a merge puts them together."""
    lines = []
    digests = set()
    for index in range(1, count + 1):
        discovery = recorder(library, index, count)
        assert list(discovery.own(inputs)) == [one for one in inputs if Shard(index, count).has(one)]
        assert discovery.count == len(inputs)
        digests.add(discovery.digest)
        lines += discovery.refused()
    assert len(digests) == 1
    lines.sort(key=lambda line: line.number)
    return _of(library, [one for line in lines for one in line.inputs])


def test_other_inputs_have_another_digest(tmp_path: Path) -> None:
    def digest(*inputs: Found | Refused) -> str:
        discovery = recorder(Library(tmp_path), 1, 2)
        list(discovery.own(inputs))
        return discovery.digest

    def found(**said: str) -> Found:
        return Found(tmp_path, "a.obj", Source(kind=SourceKind.FOLDER, path="a.obj", **said))  # type: ignore[arg-type]

    row = Refused("m.jsonl", "MAN001", "m.jsonl line 1")
    digests = [digest(found()), digest(found(title="mug")), digest(found(), row), digest(row, found()), digest()]
    assert len(set(digests)) == len(digests)
    assert digest(Found(tmp_path / "elsewhere", "a.obj", found().source)) == digests[0]
