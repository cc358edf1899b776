"""Code blocks of the documents, how a reader runs them, and what may be noted about those that no test runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
PAGES = ("README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "examples/README.md")
# Why a block is not run. Whoever adds one has to say so on the page, where the reader sees it too.
REASONS = frozenset(
    {
        *("needs a network", "needs a screen", "needs data of a benchmark", "needs files of your own"),
        *("needs weights of CLIP", "runs for minutes"),
        "needs a checkout",  # ./dev; CI runs it
        "needs Blender",  # tests/consumers/blender_kitchen.py does what docs/howto/use/blender.md says
        "needs Isaac Lab",  # nothing runs it; tests compile isaac_lab.py and compare its numbers
        "needs mujoco_warp",  # tests/consumers/batch_worlds.py does what docs/howto/use/batch.md says
        "needs Newton",  # tests/consumers/newton_kitchen.py does what docs/howto/use/newton.md says
        "needs RoboCasa",  # tests/consumers/robocasa/test_open_drawer.py runs docs/howto/use/robocasa.md
        "installs a package",  # tests/consumers/own/test_plugins.py builds it, installs it and uses it
        "needs yourdfpy or SAPIEN",  # tests/consumers/test_urdf.py runs them
        "runs until it is stopped",  # tests/unit/cli/test_kitchen_verbs.py runs what docs/howto/use/view.md shows
    }
)
# Languages that are run, read, or are no code.
LANGUAGES = frozenset({"sh", "python", "json", "sql", "yaml", "toml", "mermaid", "text"})
# First line of a block that the reader saves as a file below out/, where it says.
SAVED = re.compile(r"# (out/\S+\.(?:yaml|py|toml))\n")
_FENCE = re.compile(r"^```(?P<info>[^\n`]*)\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: page, line of its fence, language, why it is not run (or empty), code."""

    page: str
    line: int
    language: str
    reason: str
    code: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def commands(self) -> list[str]:
        """Lines of a shell block without comments, those that end in a backslash joined."""
        joined = self.code.replace("\\\n", " ")
        return [line for line in (re.sub(r"(^|\s)#.*", "", raw).strip() for raw in joined.splitlines()) if line]


def pages() -> list[str]:
    return [*PAGES, *(p.relative_to(ROOT).as_posix() for p in sorted((ROOT / "docs").rglob("*.md")))]


def blocks(page: str) -> list[Block]:
    text = (ROOT / page).read_text(encoding="utf-8")
    found = []
    for match in _FENCE.finditer(text):
        language, _, rest = match["info"].partition(" ")
        mark, _, reason = rest.partition(": ")
        assert mark in ("", "no-run"), f"{page}: {match['info']!r}"
        found.append(Block(page, text[: match.start()].count("\n") + 1, language, reason, match["code"]))
    return found


def saved(folder: str) -> dict[str, str]:
    """What the pages have a reader save below a folder such as `out/my_kitchens`: path in the folder -> text."""
    found: dict[str, str] = {}
    for block in (block for page in pages() for block in blocks(page)):
        match = SAVED.match(block.code)
        if match and match[1].startswith(f"{folder}/"):
            name = match[1].removeprefix(f"{folder}/")
            assert name not in found, f"{block}: {name} is shown twice"
            found[name] = block.code
    return found


def indented(page: str) -> list[str]:
    """Lines that are commands and stand in no fence, where no test would see them."""
    outside = _FENCE.sub("", (ROOT / page).read_text(encoding="utf-8"))
    return re.findall(r"^    (?:\w+=\S+ )?(?:\./dev|casa-assets|python|pip|import|from) .*", outside, re.MULTILINE)


def program() -> dict[str, str]:
    """The environment in which `casa-assets` and `python` are those of this checkout."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


def shell(line: str, place: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["bash", "-c", line], cwd=place, env=program(), capture_output=True, text=True, check=False)
