"""Copies of entries, outcomes of earlier runs, and accepted assets that a worse result must not replace."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from casa_assets.cache.cache_key import digest_of
from casa_assets.cache.store import Store
from casa_assets.errors import OutputError
from casa_assets.ingest.run.deduplicator import NEAR_DUPLICATE_CODE
from casa_assets.library import library as disk
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import PICTURE, file_inside, picture_of
from casa_assets.library.library import Identity
from casa_assets.library.review import REJECTED_CODE
from casa_assets.model import rejection_codes
from casa_assets.model.issue import Decision, Severity
from casa_assets.runs.outcome import Outcome

# Copy entry -----------------------------------------------------------------------------------------------------------
# Copy an entry of one library into the staging folder of another, by hard links where the file system has them.


def copy_accepted(folder: Path, certificate: disk.Certificate, library: disk.Library) -> Path:
    """The staged copy of an accepted asset: what its certificate names, and nothing else.

    A file that is copied byte by byte is compared with the digest in the certificate; one that is linked is not read.

    Raises:
        OutputError: a file is missing, damaged, or no regular file inside the entry.
    """
    staged = library.stage(folder.name)
    _copy(folder, staged, {disk.CERTIFICATE: "", **certificate.files})
    return staged


def copy_refused(folder: Path, library: disk.Library) -> Path:
    """The staged copy of a rejected input. Raises OutputError where a file of it is damaged or leads elsewhere."""
    staged = library.stage(folder.name)
    _copy(folder, staged, {disk.REFUSAL: "", **({PICTURE: ""} if picture_of(folder) else {})})
    return staged


def _copy(folder: Path, staged: Path, digests: Mapping[str, str]) -> None:
    """Link or copy files of an entry.

    Args:
        digests: sha256 of the files by their path in the entry; empty where it is not known.
    """
    for name, digest in digests.items():
        source = file_inside(folder, name, folder, "files")
        if source.is_symlink():  # within the entry: it becomes a file
            source = source.resolve()
        target = staged / name
        if "/" in name:
            target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(source, target)
        except OSError:  # another file system, one without hard links, or a file of somebody else
            data = source.read_bytes()
            if digest and hashlib.sha256(data).hexdigest() != digest:
                message = "is not what the certificate says; copy the shard again, or run it again"
                raise OutputError(str(folder / name), message) from None
            target.write_bytes(data)


# Resume ---------------------------------------------------------------------------------------------------------------
# Find the outcome of an earlier run for an input under the same cache key.

# Codes of refusals whose reason is the run (its limits, the machine, a bug) and not the input; the next run tries the
# input again.
RETRIED_CODES = frozenset(
    {
        "RUN001",  # timeout
        "RUN002",  # out of memory
        "RUN003",  # a native library crashed
        "RUN004",  # the program failed
        "RUN005",  # the file changed while it was being read
        "RUN008",  # the work made no progress
        rejection_codes.TOO_LARGE,
        rejection_codes.STORE_FAILED,
    }
)
NOTHING_KNOWN: Mapping[Path, Entry] = MappingProxyType({})


def cached_outcome(
    entries: Sequence[Path],
    asset_id: str | None,
    cache_key: str,
    known: Mapping[Path, Entry] = NOTHING_KNOWN,
    retried: Set[str] = RETRIED_CODES,
) -> tuple[Path, Outcome] | None:
    """Return the entry of an earlier run under the same key and its outcome; None if the input must be processed.

    Args:
        entries: folders of all that the producer made of the same bytes. cache_key: of this run.
        asset_id: of this run; None if it is known only once the work is done.
        known: entries that were read already, by their folder: their files are not opened again.
        retried: codes of refusals whose input is tried again.
    """
    for folder in entries:
        if asset_id not in (None, folder.name):
            continue  # made under another category
        entry = known.get(folder)
        try:
            if entry is not None and entry.code != NEAR_DUPLICATE_CODE:
                is_due = entry.cache_key != cache_key or entry.code in retried or not entry.is_whole
                outcome = None if is_due else Outcome(entry.accepted, entry.code, entry.message, entry.warnings)
            else:  # of a copy only the file tells which asset it is a copy of, and that may be gone
                is_refused = folder.parent.name == disk.REJECTED
                outcome = _refused(folder, cache_key, retried) if is_refused else _accepted(folder, cache_key)
        except OutputError:
            continue  # damaged, or a copy of what is gone: it is made anew
        if outcome is not None:
            return folder, outcome
    return None


def _accepted(folder: Path, cache_key: str) -> Outcome | None:
    certificate = disk.read_certificate(folder)
    if certificate.cache_key != cache_key or not disk.is_whole(folder, certificate):
        return None
    return Outcome(True, warnings=tuple(i for i in certificate.report.issues if i.severity is Severity.WARNING))


def _refused(folder: Path, cache_key: str, retried: Set[str]) -> Outcome | None:
    refusal = disk.read_refusal(folder)
    if refusal.cache_key != cache_key or refusal.code in retried:
        return None
    if refusal.twin:  # raises where the asset that it was a copy of is gone
        file_inside(folder.parent.parent, f"{refusal.twin}/{disk.CERTIFICATE}", folder / disk.REFUSAL, "twin")
    return Outcome(False, refusal.code, refusal.message)


# Keep accepted --------------------------------------------------------------------------------------------------------
# Keep an accepted asset of a library where a run would replace it by a worse result of the same input.
#
# A result is worse if it is in review, was rejected, or has fewer moving parts. Kitchens and exports name assets by
# their ids, so such a result replaces the accepted asset only where the user asks for it (`--force`).


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
        moving_parts: number of its joints; None if that number does not matter.
    """

    decision: Decision
    code: str = ""
    to_decide: tuple[str, ...] = ()
    moving_parts: int | None = None


def find_accepted(entries: Iterable[Path], cache_key: str) -> AcceptedAsset | None:
    """Return the accepted asset among the entries of one input, or None if no entry is accepted.

    Damaged entries, and one that was made under the same key, are skipped.
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
    """Return the reason that an earlier run noted for keeping an accepted asset; empty if it noted no reason."""
    return (Store(library.cache).get(_note_key(identity, cache_key, accepted)) or b"").decode()


def _note_key(identity: Identity, cache_key: str, accepted: AcceptedAsset) -> str:
    """Return the key of the note on a result and the asset that was kept in its place."""
    made_from = identity.producer.value, identity.sha256
    return digest_of("kept accepted", *made_from, cache_key, accepted.folder.name, accepted.cache_key)
