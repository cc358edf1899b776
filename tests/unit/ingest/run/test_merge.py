"""Which shard an input belongs to; shards that are merged are the library of one run, byte for byte.

What is damaged, missing or foreign is told.
"""

from __future__ import annotations

import csv
import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from casa_assets.errors import CasaError, OutputError
from casa_assets.ingest.run import shards as record
from casa_assets.ingest.run.inputs import discover_inputs
from casa_assets.ingest.run.merge import merge
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.run.shards import SHARD_FILE, Recorder, Shard, ShardHeader, file_of, index_of
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.library import entry as refused_rows
from casa_assets.library import review
from casa_assets.library.entry import RefusedFile, RefusedRows
from casa_assets.library.entry_files import REFUSAL
from casa_assets.library.library import Library
from casa_assets.model.source import Source, SourceKind
from casa_assets.runs.outcome import Event
from tests.support.library.libraries import BOXES, ROOT, box_obj, casa_here, entries_of
from tests.support.library.sharded_inputs import make_sharded_inputs, public_differences, run_shards
from tests.unit.ingest.run.test_ingest import set_obj

pytestmark = pytest.mark.content("code", "ingest.run.shards", keep=0)


class Made(NamedTuple):
    """Inputs, the library of one run over them, and those of its three shards; only to read."""

    source: Path
    one: Path
    shards: Sequence[Path]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("shards")
    source = make_sharded_inputs(folder / "in")
    list(ingest([source], Options(folder / "one", jobs=1)))
    for index in (1, 2, 3):  # what the stages made once need not be made again
        shutil.copytree(folder / "one" / ".casa" / "cache", folder / f"{index}_of_3" / ".casa" / "cache")
    return Made(source, folder / "one", run_shards(source, folder, 3))


def codes(library: Path) -> dict[str, str]:
    """Code of each input that has a record of its own, by its place; empty where it was accepted."""
    found = {}
    for path in library.glob("*/*/*.json"):
        said = json.loads(path.read_text(encoding="utf-8"))
        source = said["source"] if path.name == REFUSAL else said["asset"]["provenance"]
        found[source["path"]] = said.get("code", "")
    return found


def test_the_inputs_are_what_shards_alone_would_decide_otherwise(made: Made) -> None:
    assert codes(made.one) == {
        "milk_carton.obj": "",
        "copies/milk.obj": "RUN007",
        "pack.zip!inner/milk_carton.obj": "RUN006",
        "pack.zip!inner/broken.glb": "SRC002",
        "pack.zip!qwxz.obj": "",
        "cutting_board.obj": "",
        "twins/plank.obj": "RUN006",
        "sheet.obj": "MSH002",
        "unread.obj": "SRC001",
        "rows/box.obj": "",
        "chain_0/cereal_box.obj": "",
        "chain_1/cereal_box.obj": "RUN007",
        "chain_2/cereal_box.obj": "",
    }
    (line,) = (made.one / "rejected" / "rows.jsonl").read_text(encoding="utf-8").splitlines()
    assert sum(json.loads(line)["counts"].values()) == 3
    for first, second in (
        ("milk_carton.obj", "copies/milk.obj"),
        ("milk_carton.obj", "pack.zip"),
        ("cutting_board.obj", "twins/plank.obj"),
        ("chain_1/cereal_box.obj", "chain_2/cereal_box.obj"),
    ):
        assert index_of(first, 3) != index_of(second, 3), "they are to be in different shards"
    assert "RUN007" not in {code for shard in made.shards for code in codes(shard).values()}
    assert (made.shards[0] / "review.csv").exists()


def test_three_shards_are_one_run(made: Made, tmp_path: Path) -> None:
    library = tmp_path / "library"
    events = list(merge(made.shards, library))
    assert public_differences(made.one, library) == []
    assert {event.total for event in events} == {len(events)} == {16}
    before = {path: path.stat().st_mtime_ns for path in library.rglob("*") if ".casa" not in path.parts}
    again = list(merge(made.shards[::-1], library))
    assert {event.kind for event in again} == {"kept"}
    assert {path: path.stat().st_mtime_ns for path in library.rglob("*") if ".casa" not in path.parts} == before
    assert {event.kind for event in ingest([made.source], Options(library, jobs=1))} == {"kept"}
    assert public_differences(made.one, library) == []


def test_a_file_that_is_damaged_on_its_way_is_told(made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(*_: Any) -> None:
        raise OSError(errno.EXDEV, "Invalid cross-device link")

    monkeypatch.setattr(os, "link", no_links)
    shards = copies(made.shards, tmp_path)
    (model,) = (found for shard in shards for found in shard.glob("cutting_board/*/model.xml"))
    model.write_bytes(model.read_bytes()[:-1] + b" ")
    with pytest.raises(OutputError, match=r"model\.xml: is not what the certificate says"):
        list(merge(shards, tmp_path / "library"))


def copies(shards: Sequence[Path], folder: Path) -> list[Path]:
    """Shards to be changed."""
    return [Path(shutil.copytree(shard, folder / shard.name)) for shard in shards]


def test_a_merge_that_is_killed_by_a_signal_goes_on(made: Made, tmp_path: Path) -> None:
    library = tmp_path / "library"
    code = "import sys; from pathlib import Path; from casa_assets.ingest.run.merge import merge;"
    code += "paths = [Path(word) for word in sys.argv[1:]]; list(merge(paths[1:], paths[0]))"
    for published in (1, 5):
        run = subprocess.Popen([sys.executable, "-c", code, str(library), *map(str, made.shards)], cwd=ROOT)
        while run.poll() is None and len(list(library.glob("*/*/*.json"))) < published:
            time.sleep(0.001)
        run.kill()
        assert run.wait() == -signal.SIGKILL, "it had ended before"
    list(merge(made.shards, library))
    assert public_differences(made.one, library) == []
    assert list((library / ".casa" / "staging").iterdir()) == []


def test_shards_may_come_one_after_the_other(made: Made, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with pytest.raises(OutputError, match=r"one of 3 shards, and these are missing: 1/3, 3/3; name them too"):
        list(merge(made.shards[1:2], library))
    assert not library.exists()
    list(merge(made.shards[1:], library, is_partial=True))
    assert "pack.zip!qwxz.obj" not in codes(library)
    assert codes(library)["copies/milk.obj"] == "RUN007"
    rows = (library / "rejected" / "rows.jsonl").read_bytes()
    list(merge([made.shards[0]], library, is_partial=True))
    assert (library / "rejected" / "rows.jsonl").read_bytes() == rows, "those of a shard that is not named stay"
    list(merge(made.shards, library))
    assert public_differences(made.one, library) == []


def test_a_merge_adds_to_a_library_as_a_run_does(made: Made, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "cereal_box_of_before.obj").write_text("# older\n" + box_obj((0.19, 0.29, 0.06)), encoding="ascii")
    (other / "gone.jsonl").write_text('{"id": "x", "file": "gone_too.glb"}\n', encoding="ascii")
    source = tmp_path / "in"
    shutil.copytree(made.source / "chain_0", source / "chain_0")
    shutil.copytree(made.source / "rows", source / "rows", ignore=shutil.ignore_patterns("*.obj"))
    shards = run_shards(source, tmp_path, 2)
    # What the stages made once need not be made again.
    shutil.copytree(made.one / ".casa" / "cache", tmp_path / "base" / ".casa" / "cache")
    list(ingest([other], Options(tmp_path / "base", jobs=1)))
    for name in ("by_run", "by_merge"):
        shutil.copytree(tmp_path / "base", tmp_path / name)
    list(ingest([source], Options(tmp_path / "by_run", jobs=1)))
    list(merge(shards, tmp_path / "by_merge"))
    assert public_differences(tmp_path / "by_run", tmp_path / "by_merge") == []
    assert codes(tmp_path / "by_merge")["chain_0/cereal_box.obj"] == "RUN007", "the copy of an older one"


@pytest.mark.certify
def test_files_that_are_taken_apart(tmp_path: Path) -> None:
    source = tmp_path / "in"
    source.mkdir()
    (source / "breakfast.obj").write_text(set_obj(), encoding="ascii")
    (source / "milk_carton.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    assert index_of("breakfast.obj", 2) != index_of("milk_carton.obj", 2)
    list(ingest([source], Options(tmp_path / "one", jobs=1, split=True)))
    shards = run_shards(source, tmp_path, 2, split=True)
    list(merge(shards, tmp_path / "library"))
    assert public_differences(tmp_path / "one", tmp_path / "library") == []
    assert len(codes(tmp_path / "library")) == 2
    assert len(entries_of(tmp_path / "library")) == 3
    with pytest.raises(OutputError, match=r"another --split; give the same"):
        list(ingest([source], Options(shards[0], jobs=1, shard=Shard(1, 2))))


def decide(library: Path, **words: str) -> None:
    """Fill in the rows of review.csv as a person would."""
    path = library / review.NAME
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows({**row, **{f"set_{name}": value for name, value in words.items()}} for row in rows)


def test_decisions_of_people_are_those_of_one_run(tmp_path: Path) -> None:
    source, library = tmp_path / "in", tmp_path / "library"
    source.mkdir()
    (source / "qwxz.obj").write_text(box_obj((0.11, 0.12, 0.13)), encoding="ascii")
    (source / "cut.glb").write_bytes(b"glTF\x02\0\0\0\xff\0\0\0")
    assert index_of("qwxz.obj", 2) != index_of("cut.glb", 2)
    list(ingest([source], Options(tmp_path / "one", jobs=1)))
    shards = run_shards(source, tmp_path, 2)
    list(merge(shards, library))
    assert public_differences(tmp_path / "one", library) == []
    for place in (tmp_path / "one", library):
        decide(place, category="bread", mass_kg="0,5")
    with pytest.raises(OutputError, match=r"a person decided about it in review\.csv; copy .*library/review\.csv"):
        list(merge(shards, library))
    for shard in shards:
        shutil.copy(library / review.NAME, shard / review.NAME)
    list(ingest([source], Options(tmp_path / "one", jobs=1)))
    run_shards(source, tmp_path, 2)
    list(merge(shards, library))
    assert public_differences(tmp_path / "one", library) == []
    assert list(library.glob("bread/*/asset.json"))
    list(merge(shards, tmp_path / "fresh"))
    assert public_differences(library, tmp_path / "fresh") == [], "decisions come along with the shards"
    decide(shards[0], category="mug")
    with pytest.raises(OutputError, match=r"decides otherwise about qwxz\.obj than .*; change one"):
        list(merge(shards, library))


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Two shards of files that are no meshes, which cost nothing."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "in").mkdir()
    for number in range(4, 8):
        (folder / "in" / f"{number}.glb").write_bytes(b"glTF" + bytes([number]))
    assert [index_of(f"{number}.glb", 2) for number in range(4, 8)] == [1, 1, 2, 2]
    return Made(folder / "in", folder / "none", run_shards(folder / "in", folder, 2))


def edit(shard: Path, line: int = 0, **changes: Any) -> None:
    """Change a line of the record of a shard."""
    lines = (shard / SHARD_FILE).read_text(encoding="utf-8").splitlines()
    lines[line] = json.dumps(json.loads(lines[line]) | changes)
    (shard / SHARD_FILE).write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        ({"category": "mug"}, 0, "was made with another --category than .*run all shards again"),
        ({"keep_duplicates": True}, 0, "was made with another --keep-duplicates"),
        ({"limits": {"input_bytes": 1.0}}, 0, "was made with other limits on inputs"),
        ({"cache_key": "0" * 64}, 0, "was made by another version of casa-assets"),
        ({"made_by": "0" * 64}, 0, "was made by another version of casa-assets"),
        ({"inputs_digest": "0" * 64}, 0, "found other inputs, because the sources have changed in between"),
        ({"count": 3}, 0, "is one of another number of shards"),
        ({"index": 1}, 0, "holds shard 1/2, as .*1_of_2 does; name one of them"),
        ({"is_complete": False}, 0, "the run of shard 2/2 has not ended; run the same command again"),
        ({"index": 0}, 0, "line 1 is damaged"),
        ({"lines": 77}, 0, "has . of 77 lines"),
        ({"number": -1}, 1, r"line 2 is damaged \(number"),
        ({"number": 0, "source": None}, 1, r"line 2 is damaged \(it is neither"),
        ({"surveys": []}, 1, r"line 2 is damaged \(0 surveys"),
        ({"surveys": [{"sha256": "0" * 64, "category": "../../x"}]}, 1, r"line 2 is damaged \(there is no category"),
        ({"surveys": [{"category": "mug"}]}, 1, r"line 2 is damaged \(a digest is missing"),
    ],
)
def test_shards_of_two_runs_are_told(bare: Made, tmp_path: Path, change: dict[str, Any], line: int, words: str) -> None:
    shards = copies(bare.shards, tmp_path)
    edit(shards[1], line, **change)
    with pytest.raises(OutputError, match=words):
        list(merge(shards, tmp_path / "library"))
    assert not (tmp_path / "library").exists()


def test_sources_that_change_between_shards_are_told(bare: Made, tmp_path: Path) -> None:
    shards, source = copies(bare.shards, tmp_path / "old"), tmp_path / "in"
    for shard in shards:
        edit(shard, cache_key="0" * 64)
    with pytest.raises(OutputError, match="another version of casa-assets; merge with that one, or run all"):
        list(merge(shards, tmp_path / "library"))
    shards = copies(bare.shards, tmp_path)
    shutil.copytree(bare.source, source)
    (source / "new.glb").write_bytes(b"glTF")
    list(ingest([source], Options(shards[1], jobs=1, shard=Shard(2, 2))))
    with pytest.raises(OutputError, match="found other inputs"):
        list(merge(shards, tmp_path / "library"))
    list(ingest([source], Options(shards[0], jobs=1, shard=Shard(1, 2))))
    assert len(list(merge(shards, tmp_path / "library"))) == 5


def test_a_folder_stays_what_it_is(bare: Made, tmp_path: Path) -> None:
    shards = copies(bare.shards, tmp_path)

    def run(library: Path, **options: Any) -> list[Event]:
        return list(ingest([bare.source], Options(library, jobs=1, **options)))

    with pytest.raises(OutputError, match=r"holds shard 1/2; name another folder for 1/3"):
        run(shards[0], shard=Shard(1, 3))
    with pytest.raises(OutputError, match=r"another --category, --keep-duplicates; give the same"):
        run(shards[0], shard=Shard(1, 2), keep_duplicates=True, category="mug")
    with pytest.raises(OutputError, match=r"holds shard 1/2; add --shard 1/2, or name another folder"):
        run(shards[0])
    with pytest.raises(OutputError, match=r"holds shard 1/2; add"):
        list(merge(shards, shards[0]))
    list(merge(shards, tmp_path / "library"))
    with pytest.raises(OutputError, match=r"holds a library that is no shard; name another folder for 1/2"):
        run(tmp_path / "library", shard=Shard(1, 2))
    with pytest.raises(OutputError, match=r"holds no shard\.jsonl, so it is no shard"):
        list(merge([*shards, tmp_path / "library"], tmp_path / "another"))
    before = (shards[0] / SHARD_FILE).read_bytes()
    assert {event.kind for event in run(shards[0], shard=Shard(1, 2), guards={"input_bytes": 1e9})} == {"kept"}
    assert (shards[0] / SHARD_FILE).read_bytes() != before, "limits may change; a merge compares them"


def test_a_shard_whose_run_was_cut_off_goes_on(bare: Made, tmp_path: Path) -> None:
    shards = [tmp_path / "1", bare.shards[1]]
    running = ingest([bare.source], Options(shards[0], jobs=1, shard=Shard(1, 2)))
    next(running)
    running.close()
    with pytest.raises(OutputError, match="the run of shard 1/2 has not ended"):
        list(merge(shards, tmp_path / "library"))
    list(ingest([bare.source], Options(shards[0], jobs=1, shard=Shard(1, 2))))
    assert public_differences(bare.shards[0], shards[0]) == []
    assert len(list(merge(shards, tmp_path / "library"))) == 4
    dry = list(ingest([bare.source], Options(tmp_path / "dry", jobs=1, shard=Shard(1, 2), dry_run=True)))
    assert len(dry) == len(list(shards[0].glob("rejected/*/reject.json")))
    assert not (tmp_path / "dry").exists()


def test_entries_that_a_shard_lacks_are_told_before_anything_is_written(made: Made, tmp_path: Path) -> None:
    shards = copies(made.shards, tmp_path)
    (entry,) = (found.parent for shard in shards for found in shard.glob("cutting_board/*/asset.json"))
    (entry / "preview.png").unlink()
    with pytest.raises(OutputError, match=r"holds no whole entry of cutting_board\.obj; run this shard again"):
        list(merge(shards, tmp_path / "library"))
    assert not list((tmp_path / "library").glob("*/*/asset.json"))
    (entry / "preview.png").symlink_to("/etc/hostname")
    with pytest.raises(OutputError, match=r"preview\.png.* leaves the folder"):
        list(merge(shards, tmp_path / "library"))


def test_the_command_line(bare: Made, tmp_path: Path) -> None:
    places = [tmp_path / "one", tmp_path / "two", tmp_path / "library"]
    for index, place in enumerate(places[:2], 1):
        done = casa_here("ingest", bare.source, "--shard", f"{index}/2", "--library", place, "--jobs", 1)
        assert done.returncode == 1, done.stdout + done.stderr
    done = casa_here("library", "merge", places[0], "--library", places[2])
    assert (done.returncode, "2/2" in done.stderr) == (2, True)
    done = casa_here("library", "merge", *places[:2], "--library", places[2], "--json")
    assert done.returncode == 1, done.stderr
    assert sorted(json.loads(line)["path"] for line in done.stdout.splitlines()) == [f"{i}.glb" for i in range(4, 8)]
    done = casa_here("ingest", bare.source, "--shard", "3/2", "--library", tmp_path / "x")
    assert done.returncode == 2
    assert "i from 1 to n" in done.stderr
    many = next(f"{i}/50" for i in range(1, 51) if all(index_of(f"{n}.glb", 50) != i for n in range(4, 8)))
    done = casa_here("ingest", bare.source, "--shard", many, "--library", tmp_path / "x", "--jobs", 1)
    assert (done.returncode, f"shard {many} has none of the inputs" in done.stdout) == (0, True), done.stderr


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


def test_each_input_is_in_one_shard_with_its_archive_and_files_that_come_change_no_other(tmp_path: Path) -> None:
    source = make_sharded_inputs(tmp_path / "in")
    inputs = [one for one in discover_inputs([source], tmp_path / "library") if isinstance(one, Found)]
    assert {file_of(one) for one in inputs if one.archive} == {"pack.zip"}
    assert {file_of(one) for one in inputs if one.source.uid} == {"rows/box.obj"}

    def shards() -> dict[str, list[int]]:
        of: dict[str, list[int]] = {}
        for one in discover_inputs([source], tmp_path / "library"):
            name = one.source.place if isinstance(one, Found) else f"{one.path} {one.message}"
            of[name] = [index for index in range(1, 6) if Shard(index, 5).has(one)]
        return of

    before = shards()
    assert {len(indices) for indices in before.values()} == {1}
    (source / "a_new_one.obj").write_text("v 0 0 0\n", encoding="ascii")
    after = shards()
    assert {name: after[name] for name in before} == before


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


def _of(library: Library, inputs: Sequence[Refused]) -> list[RefusedFile]:
    rows = RefusedRows(library)
    for one in inputs:
        rows.add(one)
    return list(rows.files())


def recorder(library: Library, index: int, count: int) -> Recorder:
    words = {"category": "", "split": False, "keep_duplicates": False, "limits": {}, "cache_key": "", "made_by": ""}
    return Recorder(library, ShardHeader(index=index, count=count, is_complete=False, roots=(), **words))


def _put_together(library: Library, inputs: Sequence[Refused], count: int) -> list[RefusedFile]:
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
    return _of(library, [one for line in lines for one in line.inputs if isinstance(one, Refused)])


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
