"""Files that the documents name exist: a document that was left behind by a move is found."""

from __future__ import annotations

import re
from pathlib import Path

from tests.support.program.documents import ROOT, blocks, pages

# Where a path of a document may start, beside the root of the repository.
STARTS = ("", "casa_assets/", "tests/")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
NAMED = re.compile(r"`([\w./]+/[\w.]+\.(?:py|yaml|md|txt|toml))`")


def missing(text: str) -> list[str]:
    """Paths in backquotes that lead to no file; names with a placeholder and files of an output folder are left out."""
    found = [path for path in NAMED.findall(text) if not path.startswith(("out/", "rejected/", "usd/", "meshes/"))]
    return [path for path in found if not any((ROOT / start / path).is_file() for start in STARTS)]


def dead_links(text: str, folder: str) -> list[str]:
    """Targets of links and pictures, relative to the folder of the page, that are no file or folder."""
    found = [target for target in LINK.findall(text) if "://" not in target]
    return [target for target in found if not (ROOT / folder / target).exists()]


def test_links_and_pictures_lead_somewhere() -> None:
    dead = {page: dead_links((ROOT / page).read_text(encoding="utf-8"), str(Path(page).parent)) for page in pages()}
    assert {page: targets for page, targets in dead.items() if targets} == {}


def missing_samples(page: str) -> list[str]:
    """Samples that commands of a page read, and that neither are there nor are made by a script of that page."""
    made = " ".join(block.code for block in blocks(page) if block.language == "python")
    shell = [line for block in blocks(page) if block.language == "sh" for line in block.commands]
    samples = [word.strip("'\"") for line in shell for word in line.split() if word.startswith("examples/")]
    return [sample for sample in samples if not list(ROOT.glob(sample)) and sample not in made]


def test_samples_that_commands_read_exist() -> None:
    assert {page: found for page in pages() if (found := missing_samples(page))} == {}


def test_every_file_that_is_named_exists() -> None:
    named = [*pages(), "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"]
    assert {p: found for p in named if (found := missing((ROOT / p).read_text(encoding="utf-8")))} == {}


def test_a_file_that_does_not_exist_is_found() -> None:
    assert missing("see `pipeline/nothing_here.py` and `checks/check.py`") == ["pipeline/nothing_here.py"]
    assert dead_links("[a](nothing.md#part), ![b](pictures/kit.jpg), [c](https://a.b)", "docs") == ["nothing.md"]
