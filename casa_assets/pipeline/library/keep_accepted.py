"""Keep an accepted asset of a library where a run would replace it by a worse result of the same input.

A result is worse if it is in review, was rejected, or has fewer moving parts. Kitchens and exports name assets by their
ids, so such a result replaces the accepted asset only where the user asks for it (`--force`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.model.issue import Decision
from casa_assets.pipeline.cache.cache_key import digest_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Identity
from casa_assets.pipeline.library.review import REJECTED_CODE


@dataclass(frozen=True)
class AcceptedAsset:
    """An accepted asset of a library.

    Attributes:
        folder: of its entry. moving_parts: number of its joints.
        cache_key: of the run that made it.
    """

    folder: Path
    cache_key: str
    moving_parts: int


@dataclass(frozen=True)
class NewResult:
    """The result of a run for an input that has an entry already.

    Attributes:
        decision: accepted, in review or rejected. code: of a rejection. to_decide: subjects of review.
        moving_parts: number of its joints; None where it does not matter how many there are.
    """

    decision: Decision
    code: str = ""
    to_decide: tuple[str, ...] = ()
    moving_parts: int | None = None


def find_accepted(entries: Iterable[Path], cache_key: str) -> AcceptedAsset | None:
    """Return the accepted asset among the entries of one input; None where there is none.

    Damaged entries, and one that was made under the same key, are passed over.
    """
    for folder in entries:
        if folder.parent.name == disk.REJECTED:
            continue
        try:
            manifest = disk.read_manifest(folder)
        except OutputError:
            continue
        certificate = manifest.certificate
        is_accepted = certificate.report.passed and not certificate.report.to_decide
        if is_accepted and certificate.cache_key != cache_key and disk.is_whole(folder, certificate):
            return AcceptedAsset(folder, certificate.cache_key, len(manifest.asset.get("joints", ())))
    return None


def reason_to_keep(accepted: AcceptedAsset, new: NewResult) -> str:
    """Return why an accepted asset is kept in place of a new result; empty where the new result replaces it."""
    if new.code == REJECTED_CODE:  # a person rejects it
        return ""
    name, advice = accepted.folder.name, "--force replaces it"
    if new.decision is Decision.REJECTED:
        return f"{name} is accepted, the new result was rejected ({new.code}); {advice}"
    if new.moving_parts is not None and new.moving_parts < accepted.moving_parts:
        parts = f"{accepted.moving_parts} moving part{'s' if accepted.moving_parts > 1 else ''}"
        return f"{name} has {parts}, the new result has {new.moving_parts}; {advice}"
    if new.decision is Decision.REVIEW:
        return f"{name} is accepted, the new result is in review ({', '.join(new.to_decide)}); {advice}"
    return ""


def remember(library: disk.Library, identity: Identity, cache_key: str, accepted: AcceptedAsset, reason: str) -> None:
    """Note that the result under a key is worse than an accepted asset, so that the next run need not make it again."""
    Store(library.cache).put(_note_key(identity, cache_key, accepted), reason.encode())


def remembered(library: disk.Library, identity: Identity, cache_key: str, accepted: AcceptedAsset) -> str:
    """Return the reason that an earlier run noted for keeping an accepted asset; empty where there is none."""
    return (Store(library.cache).get(_note_key(identity, cache_key, accepted)) or b"").decode()


def _note_key(identity: Identity, cache_key: str, accepted: AcceptedAsset) -> str:
    """Return the key of the note on a result and the asset that was kept in its place."""
    made_from = identity.producer.value, identity.sha256
    return digest_of("kept accepted", *made_from, cache_key, accepted.folder.name, accepted.cache_key)
