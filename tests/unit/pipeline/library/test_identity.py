"""Ids name the producer; an entry replaces what its own producer made of its input and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.model.asset.provenance import CENTER_SHARES, PAIR_SHARES, TONE_SHARES, TONES
from casa_assets.model.source import Source, SourceKind
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Identity, Producer, suffix_of
from casa_assets.pipeline.library.library import Library, Refusal, Summary, identity_of

ONE, OTHER = "a" * 64, "a" * 10 + "b" * 54


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library(tmp_path / "library")
    with made.locked():
        made.sweep()
    return made


def staged(library: Library, identity: Identity, category: str = "mug", message: str = "broken") -> Path:
    """A finished refusal in the staging folder."""
    asset_id = identity.asset_id(category)
    folder = library.stage(asset_id)
    refusal = Refusal(
        producer=identity.producer,
        id=asset_id,
        code="SRC001",
        message=message,
        category=category,
        cache_key="0" * 64,
        sha256=identity.sha256,
        source=Source(kind=SourceKind.FOLDER, path="mug.glb"),
    )
    disk.write_refusal(folder, refusal)
    return folder


def publish(library: Library, identity: Identity, category: str = "mug", message: str = "broken") -> Path:
    target = library.refusal_folder(identity.asset_id(category))
    library.publish(staged(library, identity, category, message), target)
    return target


class TestIds:
    def test_producers_never_share_one(self) -> None:
        ids = [Identity(producer, ONE).asset_id("microwave") for producer in (Producer.INGEST, Producer.ARTICULATE)]
        assert ids == ["microwave_aaaaaaaaaa", "microwave_articulated_aaaaaaaaaa"]

    def test_no_category_ends_as_a_producer_is_called(self) -> None:
        known = registry.load()
        assert not [name for name in (*known.categories, *known.fixtures) if name.endswith("articulated")]

    @pytest.mark.parametrize("producer", list(Producer))
    def test_an_id_tells_its_own_producer_and_input(self, producer: Producer) -> None:
        own = Identity(producer, ONE)
        assert suffix_of(own.asset_id("cutting_board")) == own.suffix
        assert own.may_own(own.asset_id("cutting_board"))
        assert not own.may_own(Identity(producer, "b" * 64).asset_id("cutting_board"))
        assert not Identity(Producer.INGEST, ONE).may_own(Identity(Producer.ARTICULATE, ONE).asset_id("mug"))
        assert not Identity(Producer.ARTICULATE, ONE).may_own(Identity(Producer.INGEST, ONE).asset_id("mug"))


class TestPublish:
    def test_what_the_producer_made_under_another_category_goes(self, library: Library) -> None:
        own = Identity(Producer.INGEST, ONE)
        publish(library, own, "bowl")
        target = publish(library, own, "mug")
        assert list(library.refused()) == [target]
        assert list(library.staging.iterdir()) == []

    def test_what_was_rejected_before_may_be_named(self, library: Library) -> None:
        own = Identity(Producer.INGEST, ONE)
        before, stranger = publish(library, own, "bowl"), publish(library, Identity(Producer.INGEST, "c" * 64), "bowl")
        target = library.refusal_folder(own.asset_id("mug"))
        library.publish(staged(library, own), target, library.by_input()[own.suffix])
        assert list(library.refused()) == [stranger, target]
        library.publish(staged(library, own, "bowl"), before, [])
        assert list(library.refused()) == [before, stranger, target], "none is looked for"

    def test_what_another_producer_made_stays(self, library: Library) -> None:
        other = publish(library, Identity(Producer.ARTICULATE, ONE), "bowl")
        own = publish(library, Identity(Producer.INGEST, ONE), "mug")
        assert set(library.refused()) == {own, other}
        again = publish(library, Identity(Producer.ARTICULATE, ONE), "mug")
        assert set(library.refused()) == {own, again}

    def test_another_input_with_the_same_first_digits_stays(self, library: Library) -> None:
        other = publish(library, Identity(Producer.INGEST, OTHER), "bowl")
        own = publish(library, Identity(Producer.INGEST, ONE), "mug")
        assert set(library.refused()) == {own, other}

    def test_the_place_of_another_input_is_not_taken(self, library: Library) -> None:
        other = publish(library, Identity(Producer.INGEST, OTHER), message="of the other")
        with pytest.raises(OutputError, match="what ingest made of another input"):
            publish(library, Identity(Producer.INGEST, ONE))
        assert disk.read_refusal(other).message == "of the other"

    def test_an_entry_is_there_at_every_moment(self, library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
        """The old one is taken away after the new one has its place: whatever stops the run, one of them is there."""
        own = Identity(Producer.INGEST, ONE)
        publish(library, own, "bowl")
        monkeypatch.setattr(library, "forget", lambda folder: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            publish(library, own, "mug")
        assert [folder.name[:4] for folder in library.entries_of(own)] == ["bowl", "mug_"]

    def test_a_folder_is_exchanged_and_never_gone(self, library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
        own = Identity(Producer.INGEST, ONE)
        publish(library, own, message="old")
        renamed: list[Path] = []
        monkeypatch.setattr(Path, "rename", lambda self, target: renamed.append(self))
        target = publish(library, own, message="new")
        assert disk.read_refusal(target).message == "new"
        assert renamed == [], "two renames would leave a moment without an entry"

    def test_a_damaged_entry_of_that_name_is_replaced(self, library: Library) -> None:
        own = Identity(Producer.INGEST, ONE)
        target = publish(library, own)
        (target / disk.REFUSAL).write_text("{", encoding="utf-8")
        assert identity_of(target) is None
        publish(library, own, message="new")
        assert disk.read_refusal(target).message == "new"


@pytest.mark.parametrize(
    ("beside", "producer"),
    [("", Producer.INGEST), ("decisions.yaml", Producer.ARTICULATE), ("params.json", Producer.FAMILY)],
)
def test_an_entry_of_the_first_schema_is_still_read(library: Library, beside: str, producer: Producer) -> None:
    target = publish(library, Identity(Producer.INGEST, ONE))
    told = json.loads((target / disk.REFUSAL).read_text(encoding="utf-8"))
    old = {**{k: v for k, v in told.items() if k not in ("producer", "cache_key")}, "schema_version": 1, "recipe": "r"}
    old["says"] = old.pop("message")
    (target / disk.REFUSAL).write_text(json.dumps(old), encoding="utf-8")
    if beside:
        (target / beside).touch()
    read = disk.read_refusal(target)
    assert (read.producer, read.cache_key, read.message) == (producer, "r", told["message"])


def test_a_signature_of_the_first_schema_is_still_read(tmp_path: Path) -> None:
    shape = {"radius": 0.1, "pairs": [1.0] * PAIR_SHARES, "reach": [2.0] * CENTER_SHARES, "axes": [3.0, 2.0, 1.0]}
    color = {"tones": [0.5] * TONES * TONE_SHARES, "names": [["red", 1.0]], "stated": True}
    certificate = {
        "schema_version": 1,
        "asset_digest": "d",
        "recipe": "r",
        "versions": {},
        "files": {},
        "report": {"subject": "mug"},
        "summary": {**dict.fromkeys(Summary.model_fields, 1), "extents": [1, 1, 1]},
        "signature": {"form": shape, "tint": color},
    }
    (tmp_path / disk.CERTIFICATE).write_text(json.dumps({"asset": {}, "certificate": certificate}), encoding="utf-8")
    read = disk.read_certificate(tmp_path).signature
    assert read is not None
    assert (read.shape.pair_distances[0], read.shape.center_distances[0], read.shape.axis_spread) == (1, 2, (3, 2, 1))
    assert read.color.names == (("red", 1.0),)
