"""What ingest makes of meshes as people publish them, against tables of what is true.

    ./dev bench ingest_wild folder_with_truth_csv ... [--jobs 2] [--library out/bench/ingest_wild]

Each folder holds meshes and truth.csv, which is for judging alone; either with the columns file, kind, good, why_not,
up_axis, longest_min_m, longest_max_m, mass_min_kg, mass_max_kg (several words for a kind or an axis are divided by a
bar), or with file, category, up_axis_in_file, plausible_min_m, plausible_max_m, where all inputs are good and nothing
is said of masses. Ingests each folder into a library of its own, which is kept and resumed; a thing that is there twice
is judged twice. Writes
out/bench/ingest_wild.json and .md, and prints the latter: shares, how often a guess is right that is told to be
so sure, and every disagreement.
"""

from __future__ import annotations

import argparse
import csv
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.ingest.inputs import publish
from casa_assets import registry
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.up_axis import UP_ROTATIONS
from casa_assets.library.entry import Entry, entries
from casa_assets.library.library import Library

OUT = Path("out/bench")
SUBJECTS = ("category", "up_axis", "scale", "mass")
BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.01)
SAME_DEG = 15.0  # two directions closer than this are one
TITLES = {"category": "kind", "up_axis": "up", "scale": "size", "mass": "mass"}


@dataclass(frozen=True)
class Truth:
    """What is true of one input; what is empty is not known, or not meant to be.

    Attributes:
        kinds: words for it, the best first. good: a curator would keep it. ups: directions in the axes of the file.
        longest_m, mass_kg: ranges.
    """

    file: str
    kinds: tuple[str, ...]
    good: bool
    why_not: str
    ups: tuple[str, ...]
    longest_m: tuple[float, float] | None
    mass_kg: tuple[float, float] | None


@dataclass(frozen=True)
class Row:
    """One input: what came of it, and of each subject that the truth knows what we say, how sure, and whether right."""

    file: str
    good: bool
    outcome: str
    code: str = ""
    says: str = ""
    said: Mapping[str, str] = field(default_factory=dict)
    true: Mapping[str, str] = field(default_factory=dict)
    sure: Mapping[str, float] = field(default_factory=dict)
    right: Mapping[str, bool] = field(default_factory=dict)

    @property
    def is_right(self) -> bool:
        """True if nothing of it contradicts the truth."""
        return all(self.right.values())


def truths(folder: Path) -> dict[str, Truth]:
    """The table of a folder by file."""
    with (folder / "truth.csv").open(encoding="utf-8") as lines:
        return {row["file"]: _truth(row) for row in csv.DictReader(lines)}


def _truth(row: Mapping[str, str]) -> Truth:
    def interval(low: str, high: str) -> tuple[float, float] | None:
        return (float(row[low]), float(row[high])) if row.get(low) and row.get(high) else None

    if "kind" in row:
        ups = tuple(row["up_axis"].split("|")) if row["up_axis"] else ()
        size, mass = interval("longest_min_m", "longest_max_m"), interval("mass_min_kg", "mass_max_kg")
        kinds = tuple(row["kind"].split("|"))
        return Truth(row["file"], kinds, row["good"] == "yes", row["why_not"], ups, size, mass)
    size = interval("plausible_min_m", "plausible_max_m")
    ups = (f"+{row['up_axis_in_file']}",) if row["up_axis_in_file"] else ()
    return Truth(row["file"], (row["category"],), True, "", ups, size, None)


def judge(truth: Truth, entry: Entry | None) -> Row:
    """Compare an input's entry with the truth; None: there is no outcome, which is the worst."""
    if entry is None:
        return Row(truth.file, truth.good, "none")
    if entry.summary is None:
        return Row(truth.file, truth.good, "rejected", entry.code, entry.message)
    guesses = {guess.subject: guess for guess in entry.guesses}
    longest, mass = max(entry.summary.extents), entry.summary.mass
    kinds = {found for kind in truth.kinds if (found := _category_of(kind))} or {registry.FALLBACK}
    said = {
        "category": entry.category,
        "up_axis": guesses["up_axis"].value,
        "scale": f"{longest:.4g} m",
        "mass": f"{mass:.4g} kg",
    }
    right = {"category": entry.category in kinds}
    true = {"category": " or ".join(truth.kinds)}
    if truth.ups:
        right["up_axis"] = "any" in truth.ups or any(_same(said["up_axis"], up) for up in truth.ups)
        true["up_axis"] = " or ".join(truth.ups)
    for subject, span, value, unit in (("scale", truth.longest_m, longest, "m"), ("mass", truth.mass_kg, mass, "kg")):
        if span:
            right[subject] = span[0] <= value <= span[1]
            true[subject] = f"{span[0]:g} to {span[1]:g} {unit}"
    sure = {subject: guesses[subject].confidence for subject in right if subject in guesses}
    return Row(truth.file, truth.good, entry.decision.value, "", "", said, true, sure, right)


def _category_of(word: str) -> str:
    """The category that a word of a truth table names as a whole, such as `frying_pan`; empty where none does."""
    known = registry.load()
    found = known.vocabulary.find([word])
    return word if word in known.categories else found.id if found and found.evidence.endswith(f"is {found.id}") else ""


def _same(said: str, axis: str) -> bool:
    """Whether a direction as a guess tells it is an axis of a truth table, such as `+y`."""
    name = axis[1:] if axis.startswith("+") else f"minus_{axis[1:]}"
    ours = UP_ROTATIONS[said][2] if said in UP_ROTATIONS else np.array([float(v) for v in said.split()])
    return float(ours @ UP_ROTATIONS[name][2]) > np.cos(np.radians(SAME_DEG))


def rows_of(folder: Path, library: Path, jobs: int) -> Iterator[Row]:
    """Ingest a folder and judge every input of its table."""
    for event in ingest([folder], Options(library, jobs=jobs, keep_duplicates=True)):
        print(f"{event.kind:9} {event.path}", flush=True)
    # An input that lies in an archive is told by the archive and its name there.
    found = {entry.source_path.split("!")[0]: entry for entry in entries(Library(library))}
    for file, truth in truths(folder).items():
        yield judge(truth, found.get(file))


def report(folders: Mapping[str, Sequence[Row]]) -> str:
    """Markdown: shares per folder, reliability over all, disagreements."""
    lines = ["# Ingest of meshes as people publish them", ""]
    heads = ("share", "asked", *folders)
    lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for name, asked, which, counts in SHARES:
        cells = [_share([r for r in rows if which(r)], counts) for rows in folders.values()]
        lines.append(f"| {name} | {asked} | {' | '.join(cells)} |")
    every = [row for rows in folders.values() for row in rows]
    lines += ["", "## How often what is told so sure is right", "", *_reliability(every)]
    lines += ["", "## Every disagreement", "", "| folder | input | outcome | what |", "|---|---|---|---|"]
    for name, rows in folders.items():
        for row in rows:
            if text := disagreement(row):
                lines.append(f"| {name} | {row.file} | {row.outcome} | {text.replace('|', '/')} |")
    return "\n".join(lines) + "\n"


SHARES: tuple[tuple[str, str, Callable[[Row], bool], Callable[[Row], bool]], ...] = (
    ("of the good: accepted or in review", "95 %", lambda r: r.good, lambda r: r.outcome in ("accepted", "review")),
    ("of the good: accepted", "", lambda r: r.good, lambda r: r.outcome == "accepted"),
    (
        "of the good: accepted, and kind, up, size and mass right",
        "85 %",
        lambda r: r.good,
        lambda r: r.outcome == "accepted" and r.is_right,
    ),
    ("of the others: accepted", "at most 5 %", lambda r: not r.good, lambda r: r.outcome == "accepted"),
    ("of the accepted good: all right", "", lambda r: r.good and r.outcome == "accepted", lambda r: r.is_right),
    ("inputs with no outcome", "0", lambda _: True, lambda r: r.outcome == "none"),
)


def _share(rows: Sequence[Row], counts: Callable[[Row], bool]) -> str:
    count = sum(map(counts, rows))
    return f"{count} of {len(rows)}" + (f" ({count / len(rows):.0%})" if rows else "")


def _reliability(rows: Sequence[Row]) -> Iterator[str]:
    """Per subject and span of confidence: how many guesses, how sure on the average, how many right; of good inputs."""
    yield "| what | told sure | guesses | sure on the average | right |"
    yield "|---|---|---|---|---|"
    for subject in SUBJECTS:
        told = [(r.sure[subject], r.right[subject]) for r in rows if r.good and subject in r.sure]
        for low, high in itertools.pairwise(BINS):
            inside = [(sure, right) for sure, right in told if low <= sure < high]
            if inside:
                mean, right = np.mean(inside, axis=0)
                span = f"{low:.0%} to {min(high, 1):.0%}"
                yield f"| {TITLES[subject]} | {span} | {len(inside)} | {mean:.0%} | {right:.0%} |"


def disagreement(row: Row) -> str:
    """What of a row contradicts the truth; empty where nothing does."""
    if row.outcome == "none":
        return "no outcome at all"
    if row.outcome == "rejected":
        return f"good, and rejected: {row.code} {row.says}" if row.good else ""
    if not row.good:
        return "not good, and accepted" if row.outcome == "accepted" else ""
    wrong = [subject for subject, right in row.right.items() if not right]
    return "; ".join(f"{TITLES[s]} {row.said[s]} ({row.sure.get(s, 0):.0%} sure), true is {row.true[s]}" for s in wrong)


def main() -> None:
    """Ingest, judge, report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--jobs", type=int, default=0)
    parser.add_argument("--library", type=Path, default=OUT / "ingest_wild")
    options = parser.parse_args()
    found = {f.name: list(rows_of(f, options.library / f.name, options.jobs)) for f in options.folders}
    as_json = {name: [asdict(row) for row in rows] for name, rows in found.items()}
    publish(OUT / "ingest_wild", as_json, report(found))


if __name__ == "__main__":
    main()
