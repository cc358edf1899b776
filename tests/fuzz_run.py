"""A fuzz run: mutants in worker processes of the program's own pool, findings as files, for a given time."""

from __future__ import annotations

import json
import resource
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from casa_assets.pipeline.workers.limits import Limits, WorkerFailure
from casa_assets.pipeline.workers.pool import Pool
from tests.fuzz_jobs import Batch, Finding, Tally, case

BATCH = 200
READ_LIMITS = Limits(cpu_s=120, memory_bytes=2_000_000_000)
WHOLE_LIMITS = Limits(cpu_s=300, memory_bytes=4_000_000_000)
KINDS = {
    "timeout": "hang",
    "stuck": "hang",
    "memory": "memory",
    "signal": "crash",
    "killed": "crash",
    "error": "error",
}


@dataclass(frozen=True)
class Plan:
    """What to do.

    Attributes:
        seed: all that follows hangs on it. seconds: how long. folder: empty, for files and findings.
        wholes: how many of the sound cases of a batch go through everything, checks included.
        seeds: folder of more specimens, or empty. first: number of the first case.
        only: beginnings of the names of the specimens that are mutated, separated by commas; empty: all.
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
    """What came of it: cases read, cases that went through everything, verdicts of both, findings, our own memory."""

    cases: int = 0
    wholes: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    findings: list[Finding] = field(default_factory=list)
    peak_bytes: int = 0


def fuzz(plan: Plan) -> Iterator[Result]:
    """The result so far, after every batch; the last one is that of the whole run."""
    result = Result()
    end = time.monotonic() + plan.seconds
    number = plan.first
    (plan.folder / "work").mkdir(parents=True, exist_ok=True)
    warm = "casa_assets.pipeline.ingest.worker:warm" if plan.wholes else "tests.fuzz_jobs:warm"
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
            result.peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            yield result


def _batch(pool: Pool, plan: Plan, first: int, count: int) -> Tally:
    """A batch; where its process died, the case that killed it is a finding and the rest goes on behind it."""
    total = Tally()
    while count > 0:
        job = Batch(plan.seed, first, count, plan.folder / "work", plan.seeds, plan.only)
        ((_, answer),) = pool.run("tests.fuzz_jobs:read_batch", [job])
        if isinstance(answer, Tally):
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
    folder = plan.folder / "whole"
    shutil.rmtree(folder, ignore_errors=True)
    ((_, answer),) = pool.run("tests.fuzz_jobs:whole", [(plan.seed, number, folder, plan.seeds, plan.only)])
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
        specimen, files = case(plan.seed, one.number, plan.seeds, plan.only)
        for name, data in files.items():
            (folder / name).write_bytes(data)
        told = {"seed": plan.seed, "number": one.number, "specimen": specimen, "kind": one.kind, "message": one.message}
        (folder / "finding.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
