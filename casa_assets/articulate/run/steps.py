"""Articulate one static mesh into a library; runs in a separate child process (see `run.py` beside it)."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter

from casa_assets import registry
from casa_assets.articulate.assemble import assemble
from casa_assets.articulate.decisions import DECISIONS_NAME
from casa_assets.articulate.frame import likely_frames
from casa_assets.articulate.plan import Articulation, PartKind
from casa_assets.articulate.run.acceptance import (
    doubts,
    explanation,
    limit_ranges,
    mend,
    unmet_checks,
    without_contract,
)
from casa_assets.articulate.run.build import ArticulateRequest, ArticulateResult, build, find_input
from casa_assets.articulate.run.interiors import add_interiors
from casa_assets.articulate.search.choose import choose_plan
from casa_assets.cache.cache_key import CodeRef, digest_of, key_of, versions_of
from casa_assets.cache.store import Store
from casa_assets.checks.motion.joints import JointTravel, joint_travels
from casa_assets.core.system import process_name
from casa_assets.errors import CasaError, Rejected
from casa_assets.formats import mjcf
from casa_assets.ingest.sources.discover import collect
from casa_assets.ingest.things import load
from casa_assets.library.clip import weights_digest
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import Identity, MadeBy, Producer, Refusal, write_files, write_refusal
from casa_assets.library.library import Library
from casa_assets.model import rejection_codes
from casa_assets.model.issue import Decision, Report
from casa_assets.model.source import Source, Word
from casa_assets.projects import read_once
from casa_assets.runs.asset_package import WRITING, certify, check_package, write_package
from casa_assets.runs.engine import NOTHING_KNOWN, KeptAsset, NewResult, cached_outcome, kept_before, kept_instead
from casa_assets.runs.engine import RETRIED_CODES as RETRIED_BY_INGEST
from casa_assets.runs.outcome import Outcome, RunAborted, first_error, writing
from casa_assets.show.stills.opengl import NoRenderer
from casa_assets.show.stills.still import CannotDraw, MovingJoint, joint_strip, render_model

if TYPE_CHECKING:
    from casa_assets.library.library import Library

# It is no part of what is certified: it can be drawn later, and its absence changes no other file of the entry.
NAME = "strip.png"
# Parts whose motion is too small to see, or that look the same all the way round, have no picture of their own.
_WITHOUT_PICTURE = frozenset({PartKind.KNOB, PartKind.BUTTON})
# The limits of ingest are options of a run; those of `articulate` stand in the registry and so in the key of an entry.
# What broke one of them breaks it again.
RETRIED_CODES = RETRIED_BY_INGEST - {"RUN001", "RUN002", rejection_codes.TOO_LARGE}
# Times that an asset is mended and checked again: shapes fitted again may touch others, which is mended next.
MAX_MENDS = 2
# The code that turns a mesh into an asset, by the name under which certificates list its version.
STEPS: Mapping[str, CodeRef] = {
    "load": load,
    "frame": likely_frames,
    "plan": choose_plan,
    "complete": add_interiors,
    "assemble": assemble,
    "travel": limit_ranges,
}


def _strip(outcome: ArticulateOutcome, folder: Path) -> bytes:
    """Draw the strip of an outcome whose model is in a folder. Raises CannotDraw, NoRenderer."""
    assert outcome.articulation is not None
    sure = outcome.articulation.frame.confidence
    heading = f"{outcome.mesh}: {outcome.category}; frame {sure:.0%} sure"
    return joint_strip(folder / "model.xml", moving_joints(outcome), heading)


def is_missing(outcome: ArticulateOutcome) -> bool:
    """Return whether an entry that an earlier run made has moving parts and no strip."""
    return bool(outcome.travels) and outcome.folder is not None and not (outcome.folder / NAME).exists()


def add(outcome: ArticulateOutcome, library: Library) -> None:
    """Draw the strip of an entry that an earlier run made, and put it there by one rename. Raises as `_strip`."""
    assert outcome.folder is not None
    picture = _strip(outcome, outcome.folder)
    fresh = library.staging / f"{outcome.folder.name}.{process_name()}.png"
    fresh.write_bytes(picture)
    fresh.replace(outcome.folder / NAME)


def moving_joints(outcome: ArticulateOutcome) -> list[MovingJoint]:
    """Return the joints of the moving parts, in their order, with their captions."""
    found = []
    for part in outcome.articulation.parts if outcome.articulation is not None else ():
        joint, travel = part.joint, outcome.travels[part.name]
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        other = f", else {joint.runner_up}" if joint.runner_up else ""
        stops = "" if travel.free_share >= 1.0 else f"; runs into {travel.blocked_by}"
        message = f"{how}, {part.confidence:.0%} sure{other}{stops}"
        found.append(MovingJoint(travel.joint, part.name, message, alone=part.kind not in _WITHOUT_PICTURE))
    return found


@dataclass(frozen=True)
class ArticulateOutcome:
    """The outcome for one mesh.

    Attributes:
        mesh: the input. folder: of the entry, under `rejected` if a check found an error; None if there is no entry.
        articulation: the decisions. category, size: the chosen ones, and why. report: of all checks.
        travels: of each part, by its name. contract: the one it meets. unmet_checks: if it does not meet one, a
            sentence on what that means, then each failed check.
        code, message: of a refusal; empty for an asset in review. kept: an earlier run made it, and either nothing
            has changed, or it is better than the result of this run and `reason_kept`, empty otherwise, says why.
        sha256: of the mesh with all its files; empty if it could not be read.
        total: inputs of the run. count: number of inputs it covers: one outcome may report many rows of a manifest.
    """

    mesh: Path
    folder: Path | None = None
    articulation: Articulation | None = None
    category: str = ""
    size: str = ""
    report: Report | None = None
    travels: Mapping[str, JointTravel] = field(default_factory=dict)
    contract: str = ""
    unmet_checks: tuple[str, ...] = ()
    code: str = ""
    message: str = ""
    kept: bool = False
    reason_kept: str = ""
    sha256: str = ""
    total: int = 1
    count: int = 1

    @property
    def decision(self) -> Decision:
        """Return whether it was accepted, is in review, or was rejected."""
        if self.folder is None or self.code:
            return Decision.REJECTED
        return Decision.REVIEW if self.to_decide else Decision.ACCEPTED

    @property
    def accepted(self) -> bool:
        """Return whether there is an asset and nothing about it is for a person to decide."""
        return self.decision is Decision.ACCEPTED

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Return what a person has to decide: `frame`, `plan`, `contacts`."""
        return self.report.to_decide if self.report is not None else ()


# Records an outcome for the next run.
_OUTCOMES = TypeAdapter(ArticulateOutcome)


def articulate_one(request: ArticulateRequest) -> ArticulateOutcome | RunAborted:
    """Read, articulate, write, render and check one mesh; runs in the child process.

    Returns RunAborted where the user has to change the command.
    """
    try:
        with writing(request.out):
            key = _key_of_file(request)
            entries = list(Library(request.out).entries_of(key.identity))
            kept = None if request.force else kept_outcome(request, key, entries)
            if kept is None:
                return _made(request, key)
            if request.preview and is_missing(kept):
                add(kept, Library(request.out))
            return kept
    except Rejected as error:
        return ArticulateOutcome(request.mesh, code=error.code, message=error.message)
    except (CasaError, NoRenderer) as error:
        return RunAborted(str(error))


@dataclass(frozen=True)
class EntryKey:
    """Identity of an entry, and the cache key of everything else that decides it."""

    identity: Identity
    cache_key: str


def _key_of_file(request: ArticulateRequest) -> EntryKey:
    """Return the key of a request. Raises Rejected where the file cannot be read."""
    one = find_input(request)
    return entry_key(request, collect(one, registry.load().limits).sha256, one.source)


def entry_key(request: ArticulateRequest, sha256: str, source: Source) -> EntryKey:
    """Return the key of a request for an input.

    Args:
        sha256: of the input with all its files. source: what is stated of it, which may name its category.
    """
    options = {
        "category": request.category,
        "up": request.up,
        "front": request.front,
        "size_m": request.size_m,
        "decisions": request.decisions.digest,
        "clip": "" if request.clip is None else weights_digest(str(request.clip)),
        "complete": request.complete,
    }
    return EntryKey(Identity(Producer.ARTICULATE, sha256), digest_of("articulate", _code_key(), options, source.digest))


@read_once
def _code_key() -> str:
    return key_of(build, limit_ranges, mend, with_contract, _write_and_check, certify)


def kept_outcome(
    request: ArticulateRequest, key: EntryKey, entries: Sequence[Path], known: Mapping[Path, Entry] = NOTHING_KNOWN
) -> ArticulateOutcome | None:
    """Return the result or refusal of an earlier run under the same key, or None if the mesh must be processed.

    Args:
        entries: folders of all entries made of the same bytes.
        known: entries that were read already, by their folder: their files are not opened again.
    """
    library = Library(request.out)
    found = cached_outcome(entries, None, key.cache_key, known, RETRIED_CODES)
    if found is None:
        better = kept_before(library, key.identity, key.cache_key, entries)
        return None if better is None else _outcome_of_accepted(request, key, better)
    current, kept = found
    outcome = _recorded(library, key, request.mesh, current, kept)
    if outcome is None or bool(outcome.code) == kept.accepted:
        return None
    for folder in entries:
        if folder != current:  # a run was killed after it had put the current one in place
            library.forget(folder)
    return outcome


def outcome_of_entry(library: Library, entry: Entry) -> ArticulateOutcome | None:
    """Return the outcome that led to an entry; None where the cache was deleted, or other code has made the entry."""
    key = EntryKey(Identity(Producer.ARTICULATE, entry.sha256), entry.cache_key)
    return _recorded(library, key, Path(entry.source_path), library.root / entry.path, entry)


def _recorded(
    library: Library, key: EntryKey, mesh: Path, folder: Path, made: Entry | Outcome
) -> ArticulateOutcome | None:
    """Return the recorded outcome of an entry in a folder, or its refusal; None if it is unknown what moves in it."""
    record, sha256 = Store(library.cache).get(_record_key(key)), key.identity.sha256
    if record is not None:
        return replace(_OUTCOMES.validate_json(record), mesh=mesh, folder=folder, sha256=sha256, kept=True)
    if made.accepted:
        return None
    return ArticulateOutcome(mesh, folder, code=made.code, message=made.message, sha256=sha256, kept=True)


def _kept_in_place_of(request: ArticulateRequest, key: EntryKey, new: NewResult) -> ArticulateOutcome | None:
    """Return the outcome of an accepted asset that is better than a new result, or None to publish the new one."""
    if request.force:
        return None
    library = Library(request.out)
    entries = library.entries_of(key.identity)
    better = kept_instead(library, key.identity, key.cache_key, entries, new, RETRIED_CODES)
    return None if better is None else _outcome_of_accepted(request, key, better)


def _outcome_of_accepted(request: ArticulateRequest, key: EntryKey, better: KeptAsset) -> ArticulateOutcome:
    """Return the outcome of an accepted asset that is kept; without its parts where the cache was deleted."""
    record = Store(Library(request.out).cache).get(_record_key(replace(key, cache_key=better.cache_key)))
    outcome = ArticulateOutcome(request.mesh) if record is None else _OUTCOMES.validate_json(record)
    return replace(
        outcome,
        mesh=request.mesh,
        folder=better.folder,
        sha256=key.identity.sha256,
        kept=True,
        reason_kept=better.reason,
    )


def _made(request: ArticulateRequest, key: EntryKey) -> ArticulateOutcome:
    try:
        return _publish(request, build(request), key)
    except Rejected as error:
        refused = error
    except CannotDraw as error:
        refused = Rejected("MJC001", str(error))
    return publish_refusal(request, key, find_input(request).source, refused, partial(_picture_of_input, request))


def _picture_of_input(request: ArticulateRequest) -> bytes:
    """Return a PNG of the mesh as it came; empty where it cannot be read or drawn."""
    limits = registry.load().limits
    try:
        return render_model(load(collect(find_input(request), limits), limits))
    except CasaError:
        return b""


def publish_refusal(
    request: ArticulateRequest, key: EntryKey, source: Source, error: Rejected, picture: Callable[[], bytes] = bytes
) -> ArticulateOutcome:
    """Publish why nothing was made of a mesh, so that the next run need not try again; return the outcome.

    An accepted asset of the mesh is kept instead.

    Args:
        source: what is stated of the input. picture: makes a PNG of it; empty where it cannot be drawn.
    """
    library = Library(request.out)
    kept = _kept_in_place_of(request, key, NewResult(Decision.REJECTED, error.code))
    if kept is not None:
        return kept
    refusal = _refusal(key, registry.FALLBACK, source, error)
    folder = library.refusal_folder(refusal.id)
    library.publish(library.stage_refusal(refusal, picture()), folder)
    return ArticulateOutcome(request.mesh, folder, code=error.code, message=error.message, sha256=key.identity.sha256)


def _refusal(key: EntryKey, category: str, source: Source, error: Rejected) -> Refusal:
    return Refusal(
        producer=Producer.ARTICULATE,
        id=key.identity.asset_id(category),
        code=error.code,
        message=error.message,
        category=category,
        cache_key=key.cache_key,
        sha256=key.identity.sha256,
        source=source,
    )


def _record_key(key: EntryKey) -> str:
    return digest_of("articulate/outcome", key.identity.sha256, key.cache_key, key_of(ArticulateOutcome))


def publish_result(request: ArticulateRequest, result: ArticulateResult) -> ArticulateOutcome:
    """Write, check and publish what was built, as `articulate_one` does; for callers that need the result too."""
    return _publish(request, result, _key_of_file(request))


def _publish(request: ArticulateRequest, result: ArticulateResult, key: EntryKey) -> ArticulateOutcome:
    """Write, check and publish an entry; if a check finds an error, it goes to `rejected`, with all its files.

    A doubtful asset is published like an accepted one, with a warning for each question that a person has to decide. An
    accepted asset of the same mesh that is better is kept instead.
    """
    library = Library(request.out)
    if result.asset.provenance.sha256 != key.identity.sha256:
        raise Rejected("RUN005", "the file changed while it was being read; run again")
    staged, result, report, travel = _mended(request, limit_ranges(result))
    kept = _kept_in_place_of(request, key, _new_result(request, result, report))
    if kept is not None:
        shutil.rmtree(staged.parent)
        return kept
    category, asset = result.category.id, result.asset
    kind = f"{category}, {result.confidence[0]:.0%} sure: {result.confidence[1]}"
    outcome = ArticulateOutcome(
        mesh=request.mesh,
        articulation=result.articulation,
        category=kind,
        size=result.size[1],
        report=report,
        travels=travel,
        contract=asset.contract or "",
        unmet_checks=result.unmet_checks,
        sha256=key.identity.sha256,
    )
    if report.passed:
        made_by = MadeBy(Producer.ARTICULATE, key.cache_key, versions_of({**STEPS, **WRITING}))
        certify(asset, report, staged, made_by)
        outcome = replace(outcome, folder=library.folder(category, asset.id))
    else:
        worst = first_error(report)
        error = Rejected(worst.code, worst.message)
        write_refusal(staged, _refusal(key, category, result.source, error).replace(id=asset.id, report=report))
        outcome = replace(outcome, folder=library.refusal_folder(asset.id), code=worst.code, message=worst.message)
    assert outcome.folder is not None
    if request.preview:
        (staged / NAME).write_bytes(_strip(outcome, staged))
    # The record comes first: once the entry is in place, a run that was killed has nothing left to do for this mesh.
    record = replace(outcome, mesh=Path(), folder=None)  # which are others for the next run
    Store(library.cache).put(_record_key(key), _OUTCOMES.dump_json(record))
    library.publish(staged, outcome.folder)
    return outcome


def _new_result(request: ArticulateRequest, result: ArticulateResult, report: Report) -> NewResult:
    """Return what is compared with an accepted asset; parts that a person takes away are not counted as missing."""
    is_asked_for = any(part.taken_by is not None for part in request.decisions.parts.values())
    moving_parts = None if is_asked_for else len(result.asset.joints)
    if not report.passed:
        return NewResult(Decision.REJECTED, first_error(report).code)
    decision = Decision.REVIEW if report.to_decide else Decision.ACCEPTED
    return NewResult(decision, to_decide=report.to_decide, moving_parts=moving_parts)


def _mended(
    request: ArticulateRequest, built: ArticulateResult
) -> tuple[Path, ArticulateResult, Report, dict[str, JointTravel]]:
    """Write and check an asset, and again once what its checks complain of is mended, as far as it can be."""
    library = Library(request.out)
    for last in (*[False] * MAX_MENDS, True):
        staged = library.stage(built.asset.id)
        result = with_contract(built.with_runtime_names(), staged)
        report, travel = _write_and_check(request, result, staged)
        better = None if last or report.passed else mend(built, result, report)
        if better is None:
            break
        built = better
    return staged, result, report, travel


def with_contract(result: ArticulateResult, folder: Path) -> ArticulateResult:
    """Return the asset with the contract of its category where it meets it, else without, and what is missing.

    Args:
        folder: to write the model to for the checks of the contract.
    """
    known, asset = registry.load(), result.asset
    if asset.contract is None:
        return result
    write_files(folder, mjcf.write(asset))
    contract = known.contracts.get(asset.contract)
    faults = unmet_checks(asset, result.category, folder, contract, known.limits)
    if not faults:
        return result
    unmet = (explanation(asset.contract, contract), *faults)
    return replace(result, asset=without_contract(asset, faults), unmet_checks=unmet)


def _write_and_check(
    request: ArticulateRequest, result: ArticulateResult, staged: Path
) -> tuple[Report, dict[str, JointTravel]]:
    """Write both formats, a picture and decisions; return the report of every check, and the travel of each part."""
    asset = result.asset
    write_package(asset, staged)
    (staged / DECISIONS_NAME).write_text(result.decisions_text(request.decisions), encoding="utf-8")
    by_joint = {t.joint: t for t in joint_travels(asset, staged / "model.xml")}
    travel = {part: by_joint[joint] for part, joint in result.joints.items()}
    is_decided = request.decisions.decision is Word.ACCEPT
    stuck = tuple(f"{part} {way.message}" for part, way in travel.items() if not way.is_full)
    contacts = (*result.contacts, *stuck)
    notes = () if is_decided else doubts(result.articulation, registry.load_confidence(), contacts)
    return check_package(asset, staged, result.category, notes), travel
