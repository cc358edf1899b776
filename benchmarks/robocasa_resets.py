"""Resets RoboCasa's pick-and-place tasks in our kitchens with our objects, and counts the resets that fail, and why.

    ./dev bench robocasa_resets                                   50 resets of each task, in one kitchen of each plan
    ./dev bench robocasa_resets --resets 5 --scenes 'l_*'         fewer; `--tasks` names some

Exports the kitchens, and a library of objects, which is made first where it is missing (`--library`, `--count` members
of each category, on all cores). Then RoboCasa itself, in its own environment (`.venv-robocasa`, which './dev consumers'
makes, or CASA_ROBOCASA), makes each task and resets it with `obj_registries=("casa",)`; it draws a kitchen and objects
each time. A reset fails where RoboCasa raises an error, where MuJoCo warns, or where a position is not finite. Each
reset is a line in `<out>/resets.jsonl`: killed and run again, what is in it is not run again. Prints a row for each
task and the reasons. The exit code is 1 where any reset failed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console
from rich.table import Table

from casa_assets.addons.robocasa.run import export
from casa_assets.families.build import build_all, object_requests
from casa_assets.layouts.run.recipe import recipes_matching

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "tests" / "consumers" / "robocasa" / "reset_tasks.py"
ROWS = "resets.jsonl"
# One of each floor plan, as in docs/numbers.md.
SCENES = (
    *("galley__scandinavian", "g_large__modern_1", "g_small__farmhouse", "l_large__mediterranean", "l_small__coastal"),
    *("one_wall_large__industrial", "one_wall_small__modern_2", "u_large__rustic", "u_small__traditional_1"),
    "wraparound__transitional_1",
)
FAMILY = "PickPlace"


def main() -> int:
    """Export, reset, print, and say whether all succeeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--resets", type=int, default=50, help="of each task")
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), help="ids or globs of kitchens")
    parser.add_argument("--tasks", nargs="*", default=[], help=f"all that begin with {FAMILY} where none is named")
    parser.add_argument("--library", type=Path, default=ROOT / "out" / "objects")
    parser.add_argument("--count", type=int, default=17, help="members of each category, where the library is made")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench" / "robocasa")
    parser.add_argument("--jobs", type=int, default=0, help="processes that build; RoboCasa runs in one")
    options = parser.parse_args()
    console, folder = Console(), options.out / "export"
    if not folder.exists():
        if not options.library.exists():
            for made in build_all(object_requests([], options.count, 0), options.library, options.jobs, drawn=False):
                if not made.passed:
                    console.print(f"left out: {made.request.title} {made.message}", highlight=False)
        recipes = recipes_matching(options.scenes)
        for _ in export(options.library, folder, recipes=recipes, jobs=options.jobs):
            pass
    found = list(kept_rows(options.out / ROWS))
    for row in resets(folder, list(jobs(folder, options.tasks, options.resets, found)), options.out):
        found.append(row)
        if row["error"]:
            console.print(f"{row['task']} #{row['number']} {row['kitchen']}: {row['error']}", highlight=False)
    console.print(table(found))
    for reason, count in Counter(row["error"] for row in found if row["error"]).most_common():
        console.print(f"{count} x {reason}", highlight=False)
    return int(any(row["error"] for row in found))


def jobs(folder: Path, names: Sequence[str], count: int, done: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """A job for each task that is not done, in all kitchens that afford it; those begun go on with another seed."""
    tasks: dict[str, list[str]] = {}
    for path in sorted(folder.glob("kitchens/*/kitchen.json")):
        for task in json.loads(path.read_text(encoding="utf-8"))["tasks"]:
            tasks.setdefault(task, []).append(path.parent.name)
    begun = Counter(row["task"] for row in done)
    for task in names or sorted(task for task in tasks if task.startswith(FAMILY)):
        if begun[task] < count:
            yield {"task": task, "kitchens": tasks[task], "seed": begun[task], "resets": count - begun[task]}


def kept_rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows that an earlier run wrote; a line that was cut is none."""
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        if line.startswith("{") and line.endswith("}"):
            yield json.loads(line)


def resets(folder: Path, due: list[dict[str, Any]], out: Path) -> Iterator[dict[str, Any]]:
    """The row of each reset as it comes, written down too. Raises SystemExit where RoboCasa's process ends early."""
    python = ROOT / os.environ.get("CASA_ROBOCASA", ".venv-robocasa/bin/python")
    if not python.is_file():
        raise SystemExit(f"{python} is missing; './dev consumers' makes it, or name one with CASA_ROBOCASA")
    (out / "jobs.json").write_text(json.dumps(due), encoding="utf-8")
    command = [str(python), str(SCRIPT), str(folder), str(out / "jobs.json")]
    with (
        (out / "robocasa.err").open("w") as errors,
        (out / ROWS).open("a", encoding="utf-8") as rows,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("{"):
                rows.write(line)
                rows.flush()
                yield json.loads(line)
    if process.returncode:
        raise SystemExit(f"RoboCasa's process ended with {process.returncode}; see {out / 'robocasa.err'}")


def table(rows: Sequence[dict[str, Any]]) -> Table:
    """A row for each task, and one for all."""
    heads = ("task", "resets", "failed", "kitchens", "kinds of objects", "attempts, median and most", "seconds, median")
    made = Table(*heads)
    for task in (*sorted({row["task"] for row in rows}), ""):
        own = [row for row in rows if task in ("", row["task"])]
        attempts = [row["attempts"] for row in own]
        made.add_row(
            task or "all",
            str(len(own)),
            str(sum(bool(row["error"]) for row in own)),
            str(len({row["kitchen"] for row in own} - {""})),
            str(len({kind for row in own for kind in row["categories"]})),
            f"{median(attempts):.0f}, {max(attempts)}" if attempts else "",
            f"{median(row['seconds'] for row in own):.1f}" if own else "",
        )
    return made


if __name__ == "__main__":
    raise SystemExit(main())
