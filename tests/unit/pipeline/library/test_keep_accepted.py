"""Which results replace an accepted asset of the same input, and which do not."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.model.issue import Decision
from casa_assets.pipeline.library.identity import Identity, Producer
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.library.resume import AcceptedAsset, NewResult, reason_to_keep, remember, remembered

ASSET = AcceptedAsset(Path("microwave") / "microwave_12", "key", 15)
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


def test_a_worse_result_replaces_nothing(subtests: pytest.Subtests) -> None:
    for new, reason in RESULTS:
        with subtests.test(new=new, reason=reason):
            found = reason_to_keep(ASSET, new)
            assert reason in found
            assert bool(reason) is bool(found)


def test_a_reason_is_remembered_for_this_asset_and_this_key(tmp_path: Path) -> None:
    library, identity = Library(tmp_path), Identity(Producer.ARTICULATE, "1" * 64)
    remember(library, identity, "new key", ASSET, "because")
    assert remembered(library, identity, "new key", ASSET) == "because"
    assert remembered(library, identity, "other key", ASSET) == ""
    assert remembered(library, identity, "new key", AcceptedAsset(ASSET.folder, "remade", 15)) == ""
