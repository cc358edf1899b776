"""Print who imports whom in casa_assets, as a flowchart in Mermaid's language.

    python -m benchmarks.imports

Reads the source files and imports none of them. The layers are those of [tool.importlinter] in pyproject.toml. An
arrow says how many import statements lead from one layer to another, rounded to tens. It is drawn if there are many,
or if it is the strongest of its layer. With --write the picture in ARCHITECTURE.md is replaced.
"""

from __future__ import annotations

import argparse
import ast
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "casa_assets"
PAGE = ROOT / "ARCHITECTURE.md"
START, END = "<!-- python -m benchmarks.imports -->\n\n", "\n<!-- end -->\n"
# Layers of one small file each, which any other may import: arrows to them would cover the picture.
EVERYWHERE = ("projects", "errors")
MANY = 40


def layers() -> list[tuple[str, ...]]:
    """Packages of each layer from the top to the bottom, without those that are used everywhere."""
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    contract = next(one for one in tools["importlinter"]["contracts"] if one["id"] == "layers")
    rows = (tuple(name.strip() for name in row.split("|")) for row in contract["layers"])
    return [row for row in rows if row[0] not in EVERYWHERE]


def imported(text: str) -> Iterator[set[str]]:
    """For each import statement of a source file, the packages of casa_assets that it names."""
    for node in ast.walk(ast.parse(text)):
        names: list[str] = []
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{one.name}" for one in node.names]
        elif isinstance(node, ast.Import):
            names = [one.name for one in node.names]
        parts = [name.split(".") for name in names]
        yield {part[1] for part in parts if part[0] == PACKAGE.name and len(part) > 1}


def arrows(rows: Sequence[tuple[str, ...]]) -> Counter[tuple[int, int]]:
    """Number of import statements from a layer to another."""
    layer = {name: number for number, row in enumerate(rows) for name in row}
    found: Counter[tuple[int, int]] = Counter()
    for path in PACKAGE.rglob("*.py"):
        start = layer.get(path.relative_to(PACKAGE).parts[0].removesuffix(".py"))
        if start is None:
            continue
        for names in imported(path.read_text(encoding="utf-8")):
            ends = {layer[name] for name in names if name in layer}
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
    rows = layers()
    found = arrows(rows)
    boxes = [row[0] if len(row) == 1 else "middle" for row in rows]
    lines = ["```mermaid", "flowchart TD"]
    for box, row in zip(boxes, rows, strict=True):
        if len(row) > 1:
            lines += [
                f"    subgraph {box}[these do not import each other]",
                *(f"        {name}" for name in row),
                "    end",
            ]
    lines += [f"    {boxes[start]} -->|{about(found[start, end])}| {boxes[end]}" for start, end in shown(found)]
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
