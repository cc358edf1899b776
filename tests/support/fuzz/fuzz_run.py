"""A fuzz run: mutants in worker processes of the program's own pool, findings as files, for a given time."""

from __future__ import annotations

import json
import os
import resource
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.formats.read.formats import SUFFIXES
from casa_assets.ingest.clean import clean
from casa_assets.ingest.run.inputs import Job, Survey, survey
from casa_assets.ingest.run.steps import work
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused
from casa_assets.library.library import Library
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import Outcome, RunAborted
from casa_assets.runs.pool import Pool
from tests.support.fuzz.fuzz_corpus import Files, packed_specimens, specimens
from tests.support.fuzz.fuzz_mutations import mutate
from tests.support.mesh.meshes import some

SLOW_S = 10.0  # processor seconds that reading a file of a few kilobytes may take
LARGE_BYTES = 1_000_000_000
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


@dataclass(frozen=True)
class Finding:
    """Something that should not be: the case, which makes its files again with the seed; of what kind; its trace."""

    number: int
    kind: str
    message: str


@dataclass(frozen=True)
class Plan:
    """What to do.

    `seed`: all that follows hangs on it. `seconds`: how long. `folder`: empty, for files and findings. `wholes`: how
    many of the sound cases of a batch go through everything, checks included. `seeds`: folder of more specimens, or
    empty. `first`: number of the first case. `only`: beginnings of the names of the specimens that are mutated,
    separated by commas; empty: all.
    """

    seed: int
    seconds: float
    folder: Path
    wholes: int = 0
    seeds: str = ""
    first: int = 0
    only: str = ""


@dataclass
class Result:
    """What came of a batch or a run.

    `cases`: how many were read. `wholes`: how many went through everything. `verdicts`, `findings`: of both. `sound`:
    the cases of a batch that were read and make a mesh. `peak_bytes`: our own memory.
    """

    cases: int = 0
    wholes: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    findings: list[Finding] = field(default_factory=list)
    sound: list[int] = field(default_factory=list)
    peak_bytes: int = 0


def warm() -> None:
    registry.load()


def case(plan: Plan, number: int) -> tuple[str, Files]:
    """Name of the specimen, and the files of a case, its main file first."""
    rng = Random(f"{plan.seed}:{number}")
    stock = _stock(plan.seeds)
    name = rng.choice(sorted(name for name in stock if name.startswith(tuple(plan.only.split(",")))))
    files = dict(stock[name])
    victim = rng.choice([f for f in files if not f.endswith((".png", ".jpg"))])
    others = tuple(data for other in ("glb_rich", "obj", "dae", "stl_binary") for data in specimens()[other].values())
    files[victim] = mutate(files[victim], victim.rpartition(".")[2].lower(), rng, others)
    return name, files


@cache
def _stock(seeds: str) -> dict[str, Files]:
    """Specimens, and the files of a folder that are small enough to be read thousands of times."""
    stock = {**specimens(), **packed_specimens()}
    for path in sorted(Path(seeds).rglob("*")) if seeds else ():
        suffix = path.suffix.lower()
        if suffix in SUFFIXES and path.is_file() and path.stat().st_size < 300_000:
            stock[f"{path.stem}{suffix}"] = {f"a{suffix}": path.read_bytes()}
    return stock


def read_batch(job: tuple[Plan, int, int]) -> Result:
    """Find, collect, read and clean every case; the number of the one under way is on disk, for whoever survives us.

    The job is the plan, the number of the first case, and how many there are.
    """
    plan, first, count = job
    tally, folder = Result(), plan.folder / "work"
    _stock(plan.seeds)  # read before the watch begins
    escapes = _watch(folder)
    tempfile.tempdir = str(folder)
    now = os.open(folder / "now", os.O_WRONLY | os.O_CREAT, 0o600)
    for number in range(first, first + count):
        os.pwrite(now, f"{number:>20}".encode(), 0)
        _, files = case(plan, number)
        begin = time.process_time()
        try:
            found = [_verdict(one) for one in discover([_put(files, folder / "in")])]
            verdict = found[0] if found else "nothing"
        except Exception:  # noqa: BLE001  this is what is looked for
            tally.findings.append(Finding(number, "error", traceback.format_exc()[-4000:]))
            verdict = "error"
        spent = time.process_time() - begin
        tally.verdicts[verdict] += 1
        if verdict == "sound":
            tally.sound.append(number)
        if spent > SLOW_S:
            told = f"{spent:.1f} s to read {sum(map(len, files.values()))} bytes"
            tally.findings.append(Finding(number, "slow", told))
        if escapes:
            tally.findings.append(Finding(number, "escape", "\n".join(escapes)))
            escapes.clear()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if peak > LARGE_BYTES:
        tally.findings.append(Finding(first, "large", f"{peak} bytes in a batch of {count} from here"))
    return tally


def _put(files: Mapping[str, bytes], place: Path) -> Path:
    """Files in a folder of their own; the main one."""
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    for name, data in files.items():
        (place / name).write_bytes(data)
    return place / next(iter(files))


def _verdict(found: Found | Refused) -> str:
    if isinstance(found, Refused):
        return found.code
    limits = registry.load().limits
    try:
        clean(load(collect(found, limits), limits))
    except Rejected as error:
        if error.code not in registry.load().rejections:
            raise ValueError(f"nothing explains {error.code}") from error
        return error.code
    return "sound"


def _watch(folder: Path) -> list[str]:
    """From here on this process tells, in the list, what it does beyond reading and writing in a folder."""
    own = os.path.realpath(folder)
    known = (own, *map(os.path.realpath, (sys.prefix, sys.base_prefix, Path(__file__).parents[3])))
    calls = ("socket.connect", "socket.getaddrinfo", "subprocess.Popen", "os.system", "os.posix_spawn", "os.exec")
    heard: list[str] = []

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes):
            place = os.path.realpath(os.fsdecode(arguments[0]))
            flags = arguments[2] if isinstance(arguments[2], int) else 0
            roots = (own,) if flags & _WRITES & ~os.O_CLOEXEC else known
            if not place.startswith(roots) and not place.startswith(("/dev/null", "/proc/self", "/sys", "/usr/share")):
                heard.append(f"open {arguments!r}")
        elif event in calls:
            heard.append(f"{event} {arguments!r}"[:500])

    sys.addaudithook(hook)
    return heard


def whole(job: tuple[Plan, int]) -> str:
    """A case, by its number, through all that `ingest` does to an input; `accepted` or a code."""
    plan, number = job
    folder = plan.folder / "whole"
    _, files = case(plan, number)
    found = next(iter(discover([_put(files, folder / "in")])))
    assert isinstance(found, Found)
    limits = dict(registry.load().limits)
    known = survey((found, "", limits))
    assert isinstance(known, Survey)
    library = Library(folder / "library")
    library.staging.mkdir(parents=True, exist_ok=True)
    outcome = work(Job(found, known, f"object_{number}", library.root, limits, "0" * 64))
    assert not isinstance(outcome, RunAborted), outcome.message
    assert isinstance(outcome, Outcome)
    if outcome.accepted:
        json.dumps(json.loads((some(outcome.staged) / "asset.json").read_text(encoding="utf-8")), allow_nan=False)
    shutil.rmtree(library.root)
    return "accepted" if outcome.accepted else outcome.code


BATCH = 200
READ_LIMITS = Limits(cpu_s=120, memory_bytes=2_000_000_000)
WHOLE_LIMITS = Limits(cpu_s=300, memory_bytes=4_000_000_000)
KINDS = {"timeout": "hang", "stuck": "hang", "memory": "memory", "signal": "crash", "killed": "crash", "error": "error"}


def fuzz(plan: Plan) -> Iterator[Result]:
    """The result so far, after every batch; the last one is that of the whole run."""
    result = Result()
    end = time.monotonic() + plan.seconds
    number, before = plan.first, _peak_bytes()
    (plan.folder / "work").mkdir(parents=True, exist_ok=True)
    warm = "casa_assets.ingest.run.steps:warm" if plan.wholes else "tests.support.fuzz.fuzz_run:warm"
    with Pool(1, READ_LIMITS, warm) as readers, Pool(1, WHOLE_LIMITS, warm) as makers:
        while time.monotonic() < end:
            tally = _batch(readers, plan, number, BATCH)
            result.cases += BATCH
            _add(result, tally.findings, plan)
            result.verdicts.update(tally.verdicts)
            for picked in tally.sound[:: max(1, len(tally.sound) // plan.wholes)][: plan.wholes] if plan.wholes else ():
                if time.monotonic() < end:
                    _whole(makers, plan, picked, result)
            number += BATCH
            result.peak_bytes = _peak_bytes() - before
            yield result


def _peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _batch(pool: Pool, plan: Plan, first: int, count: int) -> Result:
    """A batch; where its process died, the case that killed it is a finding and the rest goes on behind it."""
    total = Result()
    while count > 0:
        ((_, answer),) = pool.run("tests.support.fuzz.fuzz_run:read_batch", [(plan, first, count)])
        if isinstance(answer, Result):
            total.verdicts.update(answer.verdicts)
            total.findings += answer.findings
            total.sound += answer.sound
            return total
        assert isinstance(answer, WorkerFailure), answer
        died_at = first
        with suppress(OSError, ValueError):
            died_at = int((plan.folder / "work" / "now").read_text(encoding="ascii"))
        total.findings.append(Finding(died_at, KINDS[answer.reason], f"{answer.message}\n{answer.trace}"))
        count -= died_at + 1 - first
        first = died_at + 1
    return total


def _whole(pool: Pool, plan: Plan, number: int, result: Result) -> None:
    shutil.rmtree(plan.folder / "whole", ignore_errors=True)
    ((_, answer),) = pool.run("tests.support.fuzz.fuzz_run:whole", [(plan, number)])
    result.wholes += 1
    if isinstance(answer, WorkerFailure):
        found = Finding(number, f"whole_{KINDS[answer.reason]}", f"{answer.message}\n{answer.trace}")
        _add(result, [found], plan)
        answer = found.kind
    result.verdicts[f"whole {answer}"] += 1


def _add(result: Result, findings: list[Finding], plan: Plan) -> None:
    """Keep findings, each with its files in a folder of its own, named after the seed."""
    for one in findings:
        result.findings.append(one)
        folder = plan.folder / "findings" / f"{one.kind}_{plan.seed}_{one.number}"
        folder.mkdir(parents=True, exist_ok=True)
        specimen, files = case(plan, one.number)
        for name, data in files.items():
            (folder / name).write_bytes(data)
        told = {"seed": plan.seed, "number": one.number, "specimen": specimen, "kind": one.kind, "message": one.message}
        (folder / "finding.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
