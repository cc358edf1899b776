"""Entries of a library appear whole or not at all, and replace what their own producer made of their input alone."""

from __future__ import annotations

from pathlib import Path
from unittest.mock import Mock

import pytest

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.places import utf8_escaped
from casa_assets.library.entry import entries
from casa_assets.library.entry_files import REFUSAL, Identity, Producer, Refusal, read_refusal
from casa_assets.library.library import Library, identity_of
from casa_assets.model.issue import Decision
from casa_assets.model.source import Source, SourceKind
from casa_assets.runs.engine import NewResult

HOSTILE = 'new\nline "quoted" <b>bold</b> [red]red[/] | \x1b[31m \u202e'
ONE, OTHER = Identity(Producer.INGEST, "a" * 64), Identity(Producer.INGEST, "a" * 10 + "b" * 54)
OPENED = Identity(Producer.ARTICULATE, ONE.sha256)
RESULTS = (
    (NewResult(Decision.ACCEPTED, moving_parts=0), "microwave_12 has 15 moving parts, the new result has 0"),
    (NewResult(Decision.REVIEW, moving_parts=14), "microwave_12 has 15 moving parts, the new result has 14"),
    (NewResult(Decision.REVIEW, "", ("plan", "frame"), 15), "is accepted, the new result is in review (plan, frame)"),
    (NewResult(Decision.REJECTED, "ART001"), "is accepted, the new result was rejected (ART001)"),
    (NewResult(Decision.ACCEPTED, moving_parts=15), ""),
    (NewResult(Decision.ACCEPTED, moving_parts=16), ""),
    (NewResult(Decision.ACCEPTED), ""),  # a person took parts away
    (NewResult(Decision.REJECTED, "REV002"), ""),  # a person rejected it
)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library(tmp_path / "library")
    with made.locked():
        made.sweep()
    return made


def refusal(identity: Identity = ONE, category: str = "mug", message: str = "broken", path: str = "mug.glb") -> Refusal:
    return Refusal(
        producer=identity.producer,
        id=identity.asset_id(category),
        code="SRC001",
        message=message,
        category=category,
        cache_key="r",
        sha256=identity.sha256,
        source=Source(kind=SourceKind.FOLDER, path=path),
    )


def publish(library: Library, *what: Identity | str, **words: str) -> Path:
    record = refusal(*what, **words)  # type: ignore[arg-type]
    target = library.refusal_folder(record.id)
    library.publish(library.stage_refusal(record), target)
    return target


def test_one_writer_at_a_time_in_a_folder(library: Library, tmp_path: Path) -> None:
    with library.locked(), pytest.raises(OutputError, match="another run"), Library(library.root).locked():
        pass
    (tmp_path / "file").touch()
    for place in ("file", "file/below"):
        with pytest.raises(OutputError, match="cannot be written to"), Library(tmp_path / place).locked():
            pass


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"id": 3}', "[" * 100_000])
def test_a_damaged_refusal_is_named_and_replaced(library: Library, text: str) -> None:
    target = publish(library)
    (target / REFUSAL).write_text(text, encoding="utf-8")
    assert identity_of(target) is None
    with pytest.raises(OutputError, match=r"mug_aaaaaaaaaa/reject\.json.*remove its folder and run again"):
        list(entries(library))
    publish(library, message="new")
    assert read_refusal(target).message == "new"


def test_hostile_words_survive(library: Library) -> None:
    target = publish(library, message=HOSTILE, path=HOSTILE)
    assert read_refusal(target) == refusal(message=HOSTILE, path=HOSTILE)
    assert [entry.message for entry in entries(library)] == [HOSTILE]
    assert utf8_escaped("mug_\udcff.glb") == "mug_\\udcff.glb"
    assert utf8_escaped("Tässe") == "Tässe"


def test_producers_never_share_an_id() -> None:
    ids = [identity.asset_id("microwave") for identity in (ONE, OPENED)]
    assert ids == ["microwave_aaaaaaaaaa", "microwave_articulated_aaaaaaaaaa"]
    known = registry.load()
    assert not [name for name in (*known.categories, *known.fixtures) if name.endswith("articulated")]


def test_an_entry_goes_that_the_producer_made_under_another_category(library: Library) -> None:
    publish(library, ONE, "bowl")
    target = publish(library, ONE, "mug")
    assert list(library.refused()) == [target]
    assert list(library.staging.iterdir()) == []


def test_what_another_producer_made_and_another_input_with_the_same_first_digits_stay(library: Library) -> None:
    opened, other = publish(library, OPENED, "bowl"), publish(library, OTHER, "bowl", message="of the other")
    own = publish(library, ONE, "mug")
    assert set(library.refused()) == {own, opened, other}
    again = publish(library, OPENED, "mug")
    assert set(library.refused()) == {own, again, other}
    with pytest.raises(OutputError, match="what ingest made of another input"):
        publish(library, ONE, "bowl")
    assert read_refusal(other).message == "of the other"


def test_an_entry_is_there_at_every_moment(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    """The old one is taken away, or exchanged, after the new one has its place: whatever stops the run."""
    publish(library, message="old")
    with monkeypatch.context() as patch:
        rename = Mock()
        patch.setattr(Path, "rename", rename)
        assert read_refusal(publish(library, message="new")).message == "new"
        assert not rename.called, "two renames would leave a moment without an entry"
    publish(library, ONE, "bowl")
    monkeypatch.setattr(library, "forget", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        publish(library, ONE, "mug")
    assert [folder.name[:4] for folder in library.entries_of(ONE)] == ["bowl", "mug_"]


def test_a_worse_result_replaces_nothing(subtests: pytest.Subtests) -> None:
    for new, reason in RESULTS:
        with subtests.test(new=new, reason=reason):
            found = new.reason_to_keep("microwave_12", 15)
            assert reason in found
            assert bool(reason) is bool(found)
