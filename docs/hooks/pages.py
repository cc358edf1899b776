"""What changes in a page before it becomes HTML: why a block is not run, and files of the root that are shown."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

# Pages that show a file of the root of the repository, which is written there for those who read it in the checkout.
SHOWN = {"explanation/how_it_is_built.md": "ARCHITECTURE.md", "explanation/contributing.md": "CONTRIBUTING.md"}
_NOT_RUN = re.compile(r"^```(\w+) no-run: ([^\n`]+)$", re.MULTILINE)
_LINK = re.compile(r"\]\(docs/")


def on_page_markdown(markdown: str, *, page: Any, config: Any, **_: Any) -> str:
    """Markdown of a page as the site shows it; called by MkDocs for each page."""
    shown = SHOWN.get(page.file.src_uri)
    if shown:
        text = (Path(config.config_file_path).parent / shown).read_text(encoding="utf-8")
        markdown = _LINK.sub("](../", text)
    return _NOT_RUN.sub(r'```\1 title="No test runs this: it \2"', markdown)
