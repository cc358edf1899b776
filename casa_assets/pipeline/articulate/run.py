"""Articulate static meshes into a library; each is processed in a child process of its own."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from casa_assets import registry
from casa_assets.articulate.assemble import assemble
from casa_assets.articulate.frame.axes import guess_frame
from casa_assets.articulate.infer import infer_articulation
from casa_assets.articulate.plan import Articulation, PartKind
from casa_assets.checks.motion.joint_travel import JointTravel, joint_travels
from casa_assets.errors import CasaError, OutputError, Rejected
from casa_assets.export import mjcf
from casa_assets.ingest.load import load
from casa_assets.ingest.sources.bundle import collect
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.pipeline.articulate import sidecar
from casa_assets.pipeline.articulate.build import ArticulateRequest, ArticulateResult, build, find_input
from casa_assets.pipeline.articulate.contract import unmet_checks, without_contract
from casa_assets.pipeline.articulate.interiors import add_interiors
from casa_assets.pipeline.articulate.limit_ranges import limit_ranges
from casa_assets.pipeline.cache.cache_key import CodeRef, digest_of, key_of, versions_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.clip import weights_digest
from casa_assets.pipeline.ingest.job import RunAborted, writing
from casa_assets.pipeline.ingest.run import FAILURE_CODES
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.asset_package import WRITING, certify, check_package, write_package
from casa_assets.pipeline.library.identity import Identity, Producer
from casa_assets.pipeline.workers.limits import Limits, WorkerFailure
from casa_assets.pipeline.workers.pool import Pool
from casa_assets.preview.renderer import NoRenderer
from casa_assets.preview.strip import MovingJoint, joint_strip

STRIP = "strip.png"
# What moves a few millimetres, or looks the same all the way round, has no picture of its own.
_SMALL = frozenset({PartKind.KNOB, PartKind.BUTTON})


# What is done to a mesh, for the certificate.
STEPS: Mapping[str, CodeRef] = {
    "load": load,
    "frame": guess_frame,
    "infer": infer_articulation,
    "complete": add_interiors,
    "assemble": assemble,
    "travel": limit_ranges,
}


@dataclass(frozen=True)
class ArticulateOutcome:
    """The outcome for one mesh.

    Attributes:
        mesh: the input. folder: of the entry, under `rejected` where a check found an error; None where there is none.
        articulation: the decisions. category, size: what it was taken to be, and why. report: of all checks.
        travels: of each part, by its name. contract: that it holds. unmet_checks: why it does not hold one.
        code, message: of a refusal. kept: an earlier run made it, and nothing has changed.
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

    @property
    def accepted(self) -> bool:
        """Return whether it is in the library."""
        return self.folder is not None and not self.code


def articulate(requests: Sequence[ArticulateRequest], jobs: int = 1) -> Iterator[ArticulateOutcome]:
    """Articulate meshes, each in a child process with limits; yield outcomes in the order in which they finish.

    Args:
        requests: all with one `out`. jobs: children at once.
    Raises:
        CasaError: a file cannot be found, what is asked for does not exist, or this machine cannot start a worker.
    """
    limits = registry.load().limits
    bounds = Limits(limits["input_seconds"], int(limits["input_memory_bytes"]))
    library = disk.Library(requests[0].out)
    with library.locked(), writing(library.root):
        library.sweep()
        try:
            with Pool(jobs, bounds, "casa_assets.pipeline.ingest.worker:warm") as pool:
                for number, answer in pool.run("casa_assets.pipeline.articulate.run:articulate_one", list(requests)):
                    if isinstance(answer, WorkerFailure):
                        yield ArticulateOutcome(
                            requests[number].mesh, code=FAILURE_CODES[answer.reason], message=answer.text
                        )
                    elif isinstance(answer, RunAborted):
                        raise CasaError(answer.message)
                    else:
                        assert isinstance(answer, ArticulateOutcome)
                        yield answer
        finally:
            library.sweep()


def articulate_one(request: ArticulateRequest) -> ArticulateOutcome | RunAborted:
    """Read, articulate, write, render and check one mesh; runs in the child process.

    Returns RunAborted where the user has to change the command.
    """
    try:
        with writing(request.out):
            asked = _asked(request)
            kept = None if request.anew else _kept(request, asked)
            return _entry(request, build(request), asked) if kept is None else kept
    except Rejected as error:
        return ArticulateOutcome(request.mesh, code=error.code, message=error.message)
    except (CasaError, NoRenderer) as error:
        return RunAborted(str(error))


@dataclass(frozen=True)
class _Asked:
    """Identity of an entry, and the cache key of everything else that decides it."""

    identity: Identity
    cache_key: str


def _asked(request: ArticulateRequest) -> _Asked:
    """Return identity and cache key of a request. Raises Rejected where the file cannot be read."""
    one = find_input(request.mesh)
    sha256 = collect(one, registry.load().limits).sha256
    options = {
        "category": request.category,
        "up": request.up,
        "front": request.front,
        "size_m": request.size_m,
        "decisions": request.decisions.digest,
        "preview": request.preview,
        "clip": "" if request.clip is None else weights_digest(str(request.clip)),
        "complete": request.complete,
    }
    code = key_of(build, limit_ranges, with_contract, _written, certify)
    return _Asked(Identity(Producer.ARTICULATE, sha256), digest_of("articulate", code, options, one.source.digest))


def _kept(request: ArticulateRequest, asked: _Asked) -> ArticulateOutcome | None:
    """Return the outcome of an earlier run with the same key, where its entry and record both exist; else None."""
    library = disk.Library(request.out)
    found = [(folder, key) for folder in library.entries_of(asked.identity) if (key := _key_in(folder))]
    current = next((folder for folder, key in found if key == asked.cache_key), None)
    told = Store(library.cache).get(_told_key(asked))
    if current is None or told is None:
        return None
    done = replace(from_json(told, request.mesh), folder=current, kept=True)
    if bool(done.code) != (current.parent.name == disk.REJECTED):
        return None
    for folder in list(library.entries_of(asked.identity)):
        if folder != current:  # a run was killed after it had put the current one in place
            library.forget(folder)
    return done


def _key_in(folder: Path) -> str:
    """Return the cache key of an entry; empty where it is damaged."""
    try:
        if folder.parent.name == disk.REJECTED:
            return disk.read_refusal(folder).cache_key
        return disk.read_certificate(folder).cache_key
    except OutputError:
        return ""


def _told_key(asked: _Asked) -> str:
    """Return the cache key of the record of an outcome."""
    return digest_of("articulate/told", asked.identity.sha256, asked.cache_key, key_of(to_json, from_json))


def to_json(done: ArticulateOutcome) -> bytes:
    """Serialise an outcome without its folder, for the next run."""
    told = {
        "found": None if done.articulation is None else done.articulation.to_json(),
        "report": None if done.report is None else done.report.to_json(),
        "travels": {part: vars(travel) for part, travel in done.travels.items()},
        "lacking": list(done.unmet_checks),
        **{name: getattr(done, name) for name in ("category", "size", "contract", "code", "message")},
    }
    return json.dumps(told).encode()


def from_json(data: bytes, mesh: Path) -> ArticulateOutcome:
    """Read an outcome that `to_json` wrote."""
    told = json.loads(data)
    return ArticulateOutcome(
        mesh=mesh,
        articulation=None if told["found"] is None else Articulation.from_json(told["found"]),
        report=None if told["report"] is None else Report.from_json(told["report"]),
        travels={part: JointTravel(**travel) for part, travel in told["travels"].items()},
        unmet_checks=tuple(told["lacking"]),
        **{name: told[name] for name in ("category", "size", "contract", "code", "message")},
    )


def _entry(request: ArticulateRequest, built: ArticulateResult, asked: _Asked) -> ArticulateOutcome:
    """Write an entry of the library; where a check finds an error, it goes to `rejected`, with all its files."""
    library = disk.Library(request.out)
    if built.asset.provenance.sha256 != asked.identity.sha256:
        raise Rejected("RUN005", "the file changed while it was being read; run again")
    staged = library.stage(built.asset.id)
    built = with_contract(limit_ranges(built).with_runtime_names(), staged)
    report, went = _written(request, built, staged)
    category, asset = built.category.id, built.asset
    kind = f"{category}, {built.confidence[0]:.0%} sure: {built.confidence[1]}"
    done = ArticulateOutcome(
        request.mesh,
        None,
        built.articulation,
        kind,
        built.size[1],
        report,
        went,
        asset.contract or "",
        built.unmet_checks,
    )
    accepted, refused = library.folder(category, asset.id), library.refusal_folder(asset.id)
    if report.passed:
        made_by = disk.MadeBy(Producer.ARTICULATE, asked.cache_key, versions_of({**STEPS, **WRITING}))
        certify(asset, report, staged, made_by)
        library.publish(staged, accepted)
        return _remembered(_at(done, accepted), library, asked)
    worst = report.errors[0]
    message = f"{worst.pointer}: {worst.message}" if worst.pointer else worst.message
    sha = asset.provenance.sha256
    disk.write_refusal(
        staged,
        disk.Refusal(
            producer=Producer.ARTICULATE,
            id=asset.id,
            code=worst.code,
            message=message,
            category=category,
            cache_key=asked.cache_key,
            sha256=sha,
            source=built.source,
            report=report,
        ),
    )
    library.publish(staged, refused)
    return _remembered(_at(done, refused, worst.code, message), library, asked)


def _remembered(done: ArticulateOutcome, library: disk.Library, asked: _Asked) -> ArticulateOutcome:
    """Store the record of an outcome for the next run; return the outcome."""
    Store(library.cache).put(_told_key(asked), to_json(done))
    return done


def _at(done: ArticulateOutcome, folder: Path, code: str = "", message: str = "") -> ArticulateOutcome:
    """Return the outcome with its folder, and with a rejection if any."""
    return ArticulateOutcome(**{**vars(done), "folder": folder, "code": code, "message": message})


def with_contract(built: ArticulateResult, folder: Path) -> ArticulateResult:
    """Return the asset with the contract of its category where it meets it, else without, and what is missing.

    Args:
        folder: to write the model to for the checks of the contract.
    """
    known, asset = registry.load(), built.asset
    if asset.contract is None:
        return built
    disk.write_files(folder, mjcf.write(asset))
    faults = unmet_checks(asset, built.category, folder, known.contracts.get(asset.contract), known.limits)
    if not faults:
        return built
    unmet = (f"contract {asset.contract} not met", *faults)
    return replace(built, asset=without_contract(asset, faults), unmet_checks=unmet)


def _written(
    request: ArticulateRequest, built: ArticulateResult, staged: Path
) -> tuple[Report, dict[str, JointTravel]]:
    """Write both formats, pictures and decisions; return the report of every check, and the travel of each part."""
    asset = built.asset
    write_package(asset, staged)
    (staged / sidecar.NAME).write_text(sidecar.text(built), encoding="utf-8")
    by_joint = {t.joint: t for t in joint_travels(asset, staged / "model.xml")}
    travel = {part: by_joint[joint] for part, joint in built.joints.items()}
    if request.preview:
        (staged / STRIP).write_bytes(joint_strip(staged / "model.xml", _moving(built, travel), _heading(built, asset)))
    return check_package(asset, staged, built.category), travel


def _moving(built: ArticulateResult, went: Mapping[str, JointTravel]) -> list[MovingJoint]:
    """Return the moving parts with their captions for the strip of pictures."""
    out = []
    for part in built.articulation.parts:
        joint, way = part.joint, went[part.name]
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        other = f", else {joint.runner_up}" if joint.runner_up else ""
        message = f"{how}, {part.confidence:.0%} sure{other}" + (
            "" if way.free_share >= 1.0 else f"; runs into {way.blocked_by}"
        )
        out.append(MovingJoint(built.joints[part.name], part.name, message, alone=part.kind not in _SMALL))
    return out


def _heading(built: ArticulateResult, asset: Asset) -> str:
    """Return the heading of the strip of pictures."""
    frame = built.articulation.frame
    x, y, z = (asset.bounds[1] - asset.bounds[0]).tolist()
    return f"{built.source.path}: {asset.id}, {x:.2f} x {y:.2f} x {z:.2f} m; frame {frame.confidence:.0%} sure"
