"""Files that the documents name exist: a document that was left behind by a move is found."""

from __future__ import annotations

import re

import pytest

from tests.documents import ROOT, pages

# Where a path of a document may start, beside the root of the repository.
STARTS = ("", "casa_assets/", "tests/")
NAMED = re.compile(r"`([\w./]+/[\w.]+\.(?:py|yaml|md|txt|toml))`")


def missing(text: str) -> list[str]:
    """Paths in backquotes that lead to no file; names with a placeholder and files of an output folder are left out."""
    found = [path for path in NAMED.findall(text) if not path.startswith(("out/", "rejected/", "usd/", "meshes/"))]
    return [path for path in found if not any((ROOT / start / path).is_file() for start in STARTS)]


@pytest.mark.parametrize("page", [*pages(), "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"])
def test_every_file_that_is_named_exists(page: str) -> None:
    assert missing((ROOT / page).read_text(encoding="utf-8")) == []


def test_a_file_that_does_not_exist_is_found() -> None:
    assert missing("see `pipeline/nothing_here.py` and `checks/run.py`") == ["pipeline/nothing_here.py"]
