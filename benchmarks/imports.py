"""Print who imports whom in casa_assets, as a flowchart in Mermaid's language.

    python -m benchmarks.imports

Reads the source files and imports none of them. The boxes and their order are those of `BOXES`; that imports lead down
is held by [tool.importlinter] in pyproject.toml. An arrow says how many import statements lead from one box to another,
rounded to tens. It is drawn if there are many, or if it is the strongest of its box. With --write the picture in
ARCHITECTURE.md is replaced.
"""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "casa_assets"
PAGE = ROOT / "ARCHITECTURE.md"
START, END = "<!-- python -m benchmarks.imports -->\n\n", "\n<!-- end -->\n"
# What each box of the picture holds, from the top to the bottom; of nested names the longest counts. `projects` and
# `errors` are left out, since all others may import them.
BOXES = {
    "cli and api": ("cli", "api"),
    "show: pages and views": ("show", "layouts.check_plan"),
    "addons": ("addons",),
    "ext for addons": ("ext.libraries", "ext.scene_checks", "ext.scenes"),
    "export, runs of subjects": ("export", "articulate.run", "ingest.run", "layouts.run", "families", "textures.run"),
    "runs, library, cache": ("runs", "library", "cache", "show.page"),
    "registry": ("registry",),
    "kitchenware": ("kitchenware",),
    "ext": ("ext",),
    "subjects: articulate, ingest, layouts, textures": ("articulate", "ingest", "layouts", "textures"),
    "checks": ("checks",),
    "formats, show.stills": ("formats", "show.stills"),
    "asset, mesh": ("asset", "mesh"),
    "core, model": ("core", "model"),
}
MANY = 50


def box_of(module: str) -> int | None:
    """Number of the box that holds a module, by its name without the package; None if none does."""
    found = [
        (len(name), number)
        for number, names in enumerate(BOXES.values())
        for name in names
        if f"{module}.".startswith(f"{name}.")
    ]
    return max(found)[1] if found else None


def imported(text: str) -> Iterator[set[str]]:
    """For each import statement of a source file, the modules of casa_assets that it names, without the package."""
    for node in ast.walk(ast.parse(text)):
        names: list[str] = []
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{one.name}" for one in node.names]
        elif isinstance(node, ast.Import):
            names = [one.name for one in node.names]
        yield {name.partition(".")[2] for name in names if name.startswith(f"{PACKAGE.name}.")}


def arrows() -> Counter[tuple[int, int]]:
    """Number of import statements from a box to another."""
    found: Counter[tuple[int, int]] = Counter()
    for path in PACKAGE.rglob("*.py"):
        start = box_of(".".join(path.relative_to(PACKAGE).with_suffix("").parts))
        if start is None:
            continue
        for names in imported(path.read_text(encoding="utf-8")):
            ends = {end for name in names if (end := box_of(name)) is not None}
            found.update((start, end) for end in ends if end != start)
    return found


def shown(found: Mapping[tuple[int, int], int]) -> list[tuple[int, int]]:
    """Arrows that are drawn: many statements, or the strongest of a layer."""
    strongest = {start: max((n, -end) for (first, end), n in found.items() if first == start) for start, _ in found}
    return sorted(arrow for arrow, n in found.items() if n >= MANY or (n, -arrow[1]) == strongest[arrow[0]])


def about(number: int) -> str:
    """A number rounded to tens, so that a single import leaves the picture as it is."""
    return str(round(number, -1)) if number >= 10 else "a few"


def picture() -> str:
    """The flowchart, as a block of Markdown."""
    found = arrows()
    lines = ["```mermaid", "flowchart TD"]
    lines += [f'    {number}["{box}"]' for number, box in enumerate(BOXES)]
    lines += [f"    {start} -->|{about(found[start, end])}| {end}" for start, end in shown(found)]
    return "\n".join([*lines, "```"]) + "\n"


def embedded(text: str) -> str:
    """The picture that a page holds."""
    return text.partition(START)[2].partition(END)[0]


def main() -> None:
    """Print the picture, or put it into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="replace the picture in ARCHITECTURE.md")
    new = picture()
    if parser.parse_args().write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(START)
        PAGE.write_text(before + START + new + END + rest.partition(END)[2], encoding="utf-8")
    else:
        print(new, end="")


if __name__ == "__main__":
    main()
