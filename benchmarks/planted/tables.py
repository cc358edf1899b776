"""Results: lines of JSON that a later run goes on from, and the table of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.planted.faults import Fault
from benchmarks.planted.trial import Failure, Verdict

APPLIES_NOT = "does not apply"
COLUMNS = ("nearest", "others", "not caught", "not caught within the budget", APPLIES_NOT)
HEADS = ("by nearest", "by others", "not caught", "not in budget", "no such text")


@dataclass(frozen=True)
class Results:
    """A file of results of one checkout; others' results in it stay. path: of the file. checkout: its name."""

    path: Path
    checkout: str

    def verdicts(self, faults: Sequence[Fault], budget_s: float) -> dict[str, Verdict]:
        """What is known of faults, by id; what did not end within a smaller budget is to be tried again."""
        digests = {fault.id: fault.digest for fault in faults}
        found = {}
        for row in self._rows("fault"):
            if digests.get(row["fault"]) == row["digest"]:
                failure = Failure(**row["failure"]) if row["failure"] else None
                verdict = Verdict(row["outcome"], row["seconds"], row["files"], failure, row["steps"])
                if not (verdict.outcome == COLUMNS[3] and row["budget_s"] < budget_s):
                    found[row["fault"]] = verdict
        return found

    def clean_fails(self) -> dict[str, bool]:
        """Tests, by whether they fail without a fault."""
        return {row["test"]: row["fails"] for row in self._rows("test")}

    def add(self, fault: Fault, verdict: Verdict, budget_s: float) -> None:
        """Append what became of a fault."""
        own = {"checkout": self.checkout, "fault": fault.id, "digest": fault.digest, "budget_s": budget_s}
        self._append(own | asdict(verdict))

    def add_clean(self, tests: Mapping[str, bool]) -> None:
        """Append what is known of tests without a fault."""
        known = self.clean_fails()
        for test, fails in tests.items():
            if test not in known:
                self._append({"checkout": self.checkout, "test": test, "fails": fails})

    def _append(self, row: Mapping[str, object]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")

    def _rows(self, field: str) -> list[dict[str, Any]]:
        """Rows of the checkout that have a field; a last line that was cut off is none."""
        lines = self.path.read_text(encoding="utf-8").split("\n")[:-1] if self.path.is_file() else []
        rows = [json.loads(line) for line in lines]
        return [row for row in rows if row["checkout"] == self.checkout and field in row]


def line_of(fault: Fault, verdict: Verdict) -> str:
    """One line about a fault, for whoever watches."""
    test = verdict.failure.test if verdict.failure else ""
    way = "" if not test else f" ({'starts the program' if verdict.steps is None else f'{verdict.steps} steps'})"
    words = f"{fault.id:32} {verdict.outcome:28} {verdict.seconds:6.1f} s  {verdict.files:3} files  {test}{way}"
    return words.rstrip()


def summary(faults: Sequence[Fault], verdicts: Mapping[str, Verdict]) -> str:
    """Counts per package and per kind, and the list of faults that no test caught."""
    parts = [_table("package", faults, verdicts, lambda fault: fault.package)]
    parts.append(_table("kind", faults, verdicts, lambda fault: fault.kind))
    missed = [fault for fault in faults if fault.id in verdicts and verdicts[fault.id].outcome in COLUMNS[2:4]]
    if missed:
        parts.append("\n".join(["Not caught:", *(_missed(fault, verdicts[fault.id]) for fault in missed)]))
    return "\n\n".join(parts)


def _missed(fault: Fault, verdict: Verdict) -> str:
    return f"  {fault.id} ({fault.file}): {fault.what} [{verdict.outcome}, {verdict.files} files]"


def _table(head: str, faults: Sequence[Fault], verdicts: Mapping[str, Verdict], group: Callable[[Fault], str]) -> str:
    tried = [fault for fault in faults if fault.id in verdicts]
    rows: list[tuple[str, ...]] = [(head, "faults", *HEADS)]
    for name in (*sorted({group(fault) for fault in tried}), "all"):
        own = [verdicts[fault.id].outcome for fault in tried if name in {group(fault), "all"}]
        rows.append((name, str(len(own)), *(str(own.count(column)) for column in COLUMNS)))
    return "\n".join(f"{row[0]:16}" + "".join(f"{cell:>15}" for cell in row[1:]) for row in rows)
