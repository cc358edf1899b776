"""What can be judged of the documents without running them: code blocks, links, files that they name."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
from pathlib import Path

from tests.architecture.test_commands import unknown
from tests.support.program.documents import LANGUAGES, REASONS, ROOT, Block, blocks, indented, pages

BLOCKS = [block for page in pages() for block in blocks(page)]
BENCHMARKS = subprocess.check_output([ROOT / "dev", "bench"], text=True).split()


def test_every_block_says_what_it_is_and_most_are_run() -> None:
    assert [block for block in BLOCKS if block.language not in LANGUAGES] == []
    assert [(block, block.reason) for block in BLOCKS if block.reason and block.reason not in REASONS] == []
    assert [page for page in pages() if indented(page)] == []
    code = [block for block in BLOCKS if block.language in ("sh", "python")]
    ours = [block for block in code if block.page.startswith(("README", "docs/quick", "docs/howto"))]
    assert sum(not b.reason for b in ours) > 0.6 * len(ours) > 40
    python = [b for b in ours if b.page in ("README.md", "docs/howto/use/python.md") and b.language == "python"]
    assert [b for b in python if b.reason] == []


def wrong(command: str, block: Block) -> bool:
    """Whether a command of a page is none that the program, `./dev` or an environment has."""
    words = [w for w in shlex.split(command) if not re.fullmatch(r"\w+=.*", w)]
    if words[0] == "casa-assets":
        return bool(unknown(words[1:]))
    if words[0] == "./dev":
        known = f"\n  {words[1]} " in (ROOT / "dev").read_text(encoding="utf-8")
        return not known or (words[1] == "bench" and len(words) > 2 and words[2] not in BENCHMARKS)
    program = Path(words[0]).name  # of a separate environment, where a folder is named
    return program != "python" and not (
        block.reason and program in ("python3", "python3.11", "python3.12", "pip", "source")
    )


def test_commands_take_their_options() -> None:
    lines = [(block, command) for block in BLOCKS if block.language == "sh" for command in block.commands]
    assert [f"{block}: {command}" for block, command in lines if wrong(command, block)] == []


def test_what_no_reader_of_the_pages_runs_parses() -> None:
    for block in BLOCKS:
        if block.language == "python" and block.reason:
            ast.parse(block.code, filename=str(block))
        if block.language == "json":
            assert json.loads(block.code), block


# Where a path of a document may start, beside the root of the repository.
STARTS = ("", "casa_assets/", "tests/")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
NAMED = re.compile(r"`([\w./]+/[\w.]+\.(?:py|yaml|md|txt|toml))`")


def test_links_and_pictures_lead_somewhere() -> None:
    for page in pages():
        links = [link for link in LINK.findall((ROOT / page).read_text(encoding="utf-8")) if "://" not in link]
        assert [link for link in links if not (ROOT / Path(page).parent / link).exists()] == [], page


def test_files_that_are_named_and_samples_that_commands_read_exist() -> None:
    for page in pages():
        made = " ".join(block.code for block in blocks(page) if block.language == "python")
        words = [word for b in blocks(page) if b.language == "sh" for line in b.commands for word in line.split()]
        samples = [word.strip("'\"") for word in words if word.startswith("examples/")]
        assert [sample for sample in samples if not list(ROOT.glob(sample)) and sample not in made] == [], page
    for page in (*pages(), "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"):
        named = NAMED.findall((ROOT / page).read_text(encoding="utf-8"))
        found = [path for path in named if not path.startswith(("out/", "rejected/", "usd/", "meshes/"))]
        assert [path for path in found if not any((ROOT / start / path).is_file() for start in STARTS)] == [], page
