"""An entry of the library, accepted or rejected, as tables and reports need it: read from its JSON alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.library import library as disk
from casa_assets.library import refused_rows
from casa_assets.model.asset.provenance import Guess, Provenance
from casa_assets.model.issue import CheckResult, Decision, Issue, Severity, Tally, subjects_to_decide

NO_CHECKS = Tally()
STATED = ("title", "author", "licence", "uri", "prompt", "generator")  # of an input, by its source


@dataclass(frozen=True)
class Entry:
    """One row.

    Attributes:
        id, category: of the asset. path: its folder, relative to the library.
        accepted: there is an asset, even if in review; if not, code and message.
        summary, warnings, results, guesses: of an accepted one (as far as known for a rejected one).
        checks: number of them by status; the results are left out if only the numbers are needed.
        source, source_path, sha256, title, author, licence, uri, prompt, generator: provenance.
        split: train or test, as the asset states; empty if not stated.
        portion: remaining part of an object that was cut, such as `half`; empty for a whole one.
        digest: of the asset, empty for rejected ones. producer: ingest, articulate or family. cache_key: of the entry.
        is_whole: False if a file of an accepted one is missing.
        colors: words for the colours of an accepted one, with the share of the surface that each has; empty if its
            source states no colours.
    """

    id: str
    category: str
    path: str
    accepted: bool
    code: str
    message: str
    summary: disk.Summary | None
    warnings: tuple[Issue, ...]
    results: tuple[CheckResult, ...]
    guesses: tuple[Guess, ...]
    source: str
    source_path: str
    sha256: str
    title: str
    author: str
    licence: str
    uri: str
    prompt: str
    generator: str
    split: str
    digest: str
    producer: str
    cache_key: str
    portion: str = ""
    checks: Tally = NO_CHECKS
    is_whole: bool = True
    colors: tuple[tuple[str, float], ...] = ()

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Return the subjects that a person has to decide about an asset, such as `scale`; see review.csv."""
        return subjects_to_decide(self.warnings)

    @property
    def decision(self) -> Decision:
        """Accepted, in review, or rejected."""
        if not self.accepted:
            return Decision.REJECTED
        return Decision.REVIEW if self.to_decide else Decision.ACCEPTED

    @property
    def advice(self) -> tuple[str, ...]:
        """Codes of the warnings, each once, sorted."""
        return tuple(sorted({issue.code for issue in self.warnings}))


def entries(library: disk.Library) -> Iterator[Entry]:
    """All entries, accepted first. Raises OutputError where one is damaged."""
    for folder in (*library.accepted(), *library.refused()):
        yield entry_at(folder, library.root)
    yield from row_entries(library)


def row_entries(library: disk.Library) -> Iterator[Entry]:
    """Entries for inputs that were refused without a mesh, see `refused_rows`."""
    blank: dict[str, Any] = {field.name: "" for field in fields(Entry)}
    blank |= {"accepted": False, "summary": None, "warnings": (), "results": (), "guesses": (), "checks": NO_CHECKS}
    for row in refused_rows.listed(library):
        yield Entry(**{**blank, **refused_rows.place_of(row["source_path"]), **row})


def entry_at(folder: Path, root: Path) -> Entry:
    """The entry in one folder of the library at `root`. Raises OutputError where it is damaged."""
    if folder.parent.name == disk.REJECTED:
        return _refused(folder, root)
    return entry_of(disk.read_manifest(folder), root)


def entry_of(manifest: disk.Manifest, root: Path) -> Entry:
    """The entry of an accepted asset whose manifest was read. Raises OutputError where it is damaged."""
    folder, certificate, data = manifest.folder, manifest.certificate, manifest.asset
    try:
        origin, category = Provenance.model_validate(data["provenance"]), str(data["labels"]["category"])
    except (ValidationError, KeyError, TypeError) as error:
        raise OutputError(str(folder / disk.CERTIFICATE), f"is damaged: {error}; run again without it") from error
    if data.get("id") != folder.name:
        message = f"holds the asset {data.get('id')!r}; move it to a folder of that name"
        raise OutputError(str(folder / disk.CERTIFICATE), message)
    signature = certificate.signature
    return Entry(
        id=folder.name,
        category=category,
        path=folder.relative_to(root).as_posix(),
        accepted=True,
        code="",
        message="",
        summary=certificate.summary,
        warnings=tuple(i for i in certificate.report.issues if i.severity is Severity.WARNING),
        results=certificate.report.results,
        guesses=origin.guesses,
        source=origin.source,
        source_path=origin.place,
        sha256=origin.sha256,
        **{name: getattr(origin, name) for name in STATED},
        split=str(data["labels"].get("split") or ""),
        portion=str(data["labels"].get("portion") or ""),
        digest=certificate.asset_digest,
        producer=certificate.producer.value,
        cache_key=certificate.cache_key,
        checks=certificate.report.tally,
        is_whole=disk.is_whole(folder, certificate),
        colors=signature.color.names if signature is not None and signature.color.stated else (),
    )


def _refused(folder: Path, root: Path) -> Entry:
    refusal = disk.read_refusal(folder)
    if refusal.id != folder.name:
        raise OutputError(str(folder / disk.REFUSAL), f"is that of {refusal.id!r}; move it to a folder of that name")
    source = refusal.source
    return Entry(
        id=refusal.id,
        category=refusal.category,
        path=folder.relative_to(root).as_posix(),
        accepted=False,
        code=refusal.code,
        message=refusal.message,
        summary=None,
        warnings=(),
        results=refusal.report.results if refusal.report else (),
        guesses=(),
        source=source.kind.value,
        source_path=source.place,
        sha256=refusal.sha256,
        **{name: getattr(source, name) for name in STATED},
        split="",
        digest="",
        producer=refusal.producer.value,
        cache_key=refusal.cache_key,
        checks=refusal.report.tally if refusal.report else NO_CHECKS,
    )
