"""`./dev certify`: run every proof that a release needs, and keep a table of them.

    ./dev certify                 all parts, from the first
    ./dev certify --resume        go on: parts that have passed since the run began are kept, whatever was mended since
    ./dev certify --only NAME ... some parts
    ./dev certify --list          the table, and nothing is run

Each part that ends is recorded at once in certified.json, with its result, seconds, date and commit, and the table in
docs/reference/certified.md is written anew. One that fails ends with 1, after the others were run.
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from tests.certify.parts import CONSUMERS, OUT, ROOT, SHARED, Part, environment, parts

RECORDED = Path(__file__).with_name("certified.json")
PAGE = ROOT / "docs" / "reference" / "certified.md"
KEYS = (ROOT / "tests" / "content_keys.json", ROOT / "tests" / "consumers" / "watched.json")
PASSED, FAILED = "passed", "FAILED"
HEAD = """# What was certified

`./dev certify` runs the proofs that take hours, before a release, and writes this table. CI runs none of them; what
stands in for each there is in [How to contribute](../explanation/contributing.md).

| part | proves | result | tests | seconds | date | commit |
|---|---|---|---|---|---|---|
"""
# Of the last line of pytest.
COUNT = re.compile(r"(\d+) passed")


@dataclass(frozen=True)
class Record:
    """How a part ended.

    Attributes:
        seconds: on the clock. date: of its end, UTC. commit: short, with `+` where files differed from it.
        tests: cases of pytest that passed; None where it runs none.
    """

    result: str
    seconds: int
    date: str
    commit: str
    tests: int | None = None


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="./dev certify", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--resume", action="store_true", help="keep what has passed, also of an older commit")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="these parts")
    parser.add_argument("--list", action="store_true", help="print the table")
    arguments = parser.parse_args()
    every = parts()
    if unknown := sorted(set(arguments.only) - {part.name for part in every}):
        parser.error(f"there is no part {', '.join(unknown)}; there are {', '.join(part.name for part in every)}")
    known = read()
    if arguments.list:
        print(table(every, known))
        return 0
    if not SHARED.is_dir():
        print(f"The shared data is missing: '{SHARED}' is not a folder. Name it: CASA_SHARED=<folder>", file=sys.stderr)
        return 1
    wanted = [part for part in every if not arguments.only or part.name in arguments.only]
    if arguments.resume:
        wanted = [part for part in wanted if part.name not in known or known[part.name].result != PASSED]
    elif not arguments.only:
        known = {}
    OUT.mkdir(parents=True, exist_ok=True)
    for part in wanted:
        known[part.name] = run(part)
        write(every, known)
    print(table(every, known))
    if _programs_passed(known, every):
        subprocess.run([sys.executable, "-m", "tests.consumers.watched", "--write"], cwd=ROOT, check=True)
    return int(any(known[part.name].result != PASSED for part in wanted))


def _programs_passed(known: Mapping[str, Record], every: Sequence[Part]) -> bool:
    """True if all tests of other programs have passed at this commit, so that their keys may be recorded."""
    names = [p.name for p in every if any(word.startswith(CONSUMERS) for command in p.commands for word in command)]
    ends = {(known[name].result, known[name].commit) if name in known else None for name in names}
    return ends == {(PASSED, _commit())}


def run(part: Part) -> Record:
    """Run a part; what its commands print is shown and kept in a file."""
    begin, commit = time.monotonic(), _commit()
    log = OUT / f"{part.name.replace(' ', '_')}.txt"
    print(f"=== certify: {part.name} ({part.proves}); what it prints is kept in {log}", flush=True)
    with log.open("w", encoding="utf-8") as kept:
        passed = all(_passes(command, part.limit_s, kept.fileno()) for command in (*part.commands, *part.after))
    text = log.read_text(encoding="utf-8", errors="replace")
    print(text[-4000:] if passed else text[-20_000:])
    runs_tests = any("pytest" in command for command in part.commands)
    counts = [int(count) for count in COUNT.findall(text)] if runs_tests else []
    date = datetime.datetime.now(datetime.UTC).date().isoformat()
    result = PASSED if passed else FAILED
    done = Record(result, round(time.monotonic() - begin), date, commit, sum(counts) if counts else None)
    print(f"=== {part.name}: {done.result} after {done.seconds} s", flush=True)
    return done


def _passes(command: Sequence[str], limit_s: int, output: int) -> bool:
    try:
        ran = subprocess.run(
            command, cwd=ROOT, env=environment(), stdout=output, stderr=subprocess.STDOUT, timeout=limit_s, check=False
        )
    except subprocess.TimeoutExpired:
        print(f"stopped after {limit_s} s: {' '.join(command)}", flush=True)
        return False
    return ran.returncode == 0


def _commit() -> str:
    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()

    # What the parts themselves write is no change.
    own = [f":!{path.relative_to(ROOT)}" for path in (RECORDED, PAGE, *KEYS)]
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", *own)
    return git("rev-parse", "--short=8", "HEAD") + ("+" if changed else "")


def read() -> dict[str, Record]:
    """What was recorded, by name of the part."""
    found = json.loads(RECORDED.read_text(encoding="utf-8")) if RECORDED.is_file() else {}
    return {name: Record(**record) for name, record in found.items()}


def write(every: Sequence[Part], known: dict[str, Record]) -> None:
    text = json.dumps({name: asdict(record) for name, record in sorted(known.items())}, indent=1)
    RECORDED.write_text(f"{text}\n", encoding="utf-8")
    PAGE.write_text(f"{HEAD}{rows(every, known)}\n", encoding="utf-8")


def rows(every: Sequence[Part], known: dict[str, Record]) -> str:
    """Rows of the table in Markdown, one a part."""
    lines = []
    for part in every:
        done = known.get(part.name)
        told = ("not run", "", "", "", "")
        if done is not None:
            told = (done.result, str(done.tests or ""), f"{done.seconds:,}", done.date, done.commit)
        lines.append(f"| {' | '.join((part.name, part.proves, *told))} |")
    return "\n".join(lines)


def table(every: Sequence[Part], known: dict[str, Record]) -> str:
    lines = []
    for part in every:
        done = known.get(part.name)
        told = f"{done.result:8} {done.seconds:>7,} s  {done.date}  {done.commit}" if done else "not run"
        lines.append(f"{part.name:12} {told}")
    return "\n".join(lines)


if __name__ == "__main__":
    raise SystemExit(main())
