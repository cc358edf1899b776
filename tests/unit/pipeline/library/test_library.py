"""Entries of a library appear whole or not at all; damaged ones are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.ingest.sources.places import utf8_escaped
from casa_assets.model.source import Source, SourceKind
from casa_assets.pipeline.ingest import inputs
from casa_assets.pipeline.library.identity import Producer
from casa_assets.pipeline.library.library import Library, Refusal, read_refusal, write_refusal
from casa_assets.pipeline.reports.entry import entries

HOSTILE = 'new\nline "quoted" <b>bold</b> [red]red[/] | \x1b[31m \u202e'


def refusal(name: str = "mug_0123456789", message: str = "broken", path: str = "mug.glb") -> Refusal:
    source = Source(kind=SourceKind.FOLDER, path=path)
    return Refusal(
        id=name,
        code="SRC001",
        message=message,
        category="mug",
        producer=Producer.INGEST,
        cache_key="r",
        sha256="0" * 64,
        source=source,
    )


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library(tmp_path / "library")
    with made.locked():
        made.sweep()
    return made


def publish(library: Library, record: Refusal) -> Path:
    staged = library.stage(record.id)
    write_refusal(staged, record)
    target = library.refusal_folder(record.id)
    library.publish(staged, target)
    return target


def test_what_is_published_replaces_what_was_there(library: Library) -> None:
    publish(library, refusal(message="old"))
    target = publish(library, refusal(message="new"))
    assert read_refusal(target).message == "new"
    assert list(library.staging.iterdir()) == []
    assert list(library.refused()) == [target]


def test_the_last_entry_takes_its_folder_along(library: Library) -> None:
    target = publish(library, refusal())
    library.forget(target)
    assert not target.parent.exists()
    assert list(library.staging.iterdir()) == []
    library.forget(target)


def test_sweep_leaves_entries_and_cache(library: Library) -> None:
    target = publish(library, refusal())
    (library.cache / "ab").mkdir(parents=True)
    (library.private / "review.csv.77").write_bytes(b"half")
    library.stage("mug_0123456789")
    library.sweep()
    assert sorted(p.name for p in library.private.iterdir()) == ["cache", "lock", "staging"]
    assert list(library.staging.iterdir()) == []
    assert target.exists()


def test_one_writer_at_a_time(library: Library) -> None:
    with library.locked(), pytest.raises(OutputError, match="another run"), Library(library.root).locked():
        pass


def test_a_library_must_be_a_folder(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for place in ["file", "file/below"]:
        with subtests.test(place=place):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / "file").touch()
            with pytest.raises(OutputError, match="cannot be written to"), Library(tmp_path / place).locked():
                pass


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"id": 3}', "[" * 100_000])
def test_a_damaged_refusal_is_named(library: Library, text: str) -> None:
    target = publish(library, refusal())
    (target / "reject.json").write_text(text, encoding="utf-8")
    with pytest.raises(OutputError, match=r"mug_0123456789/reject\.json.*remove its folder and run again"):
        list(entries(library))


def test_hostile_words_survive(library: Library) -> None:
    target = publish(library, refusal(message=HOSTILE, path=HOSTILE))
    assert read_refusal(target) == refusal(message=HOSTILE, path=HOSTILE)
    assert [entry.message for entry in entries(library)] == [HOSTILE]


def test_bytes_that_are_no_text_are_escaped() -> None:
    assert utf8_escaped("mug_\udcff.glb") == "mug_\\udcff.glb"
    assert utf8_escaped("Tässe") == "Tässe"


def test_a_refusal_that_stands_already_is_not_written_again(library: Library) -> None:
    assert inputs.write_if_changed(library, refusal("unread_0123456789"))
    assert not inputs.write_if_changed(library, refusal("unread_0123456789"))
    assert inputs.write_if_changed(library, refusal("unread_0123456789", message="for another reason"))
    assert list(library.staging.iterdir()) == []
