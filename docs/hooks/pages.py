"""What changes in a page before it becomes HTML: why a block is not run, files of the root, fields of JSON files."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
# Pages that show a file of the root of the repository, which is written there for those who read it in the checkout.
SHOWN = {"explanation/how_it_is_built.md": "ARCHITECTURE.md", "explanation/contributing.md": "CONTRIBUTING.md"}
_NOT_RUN = re.compile(r"^```(\w+) no-run: ([^\n`]+)$", re.MULTILINE)
_LINK = re.compile(r"\]\(docs/")
_FIELDS = re.compile(r"^<!-- fields of (\w+)\.json -->$", re.MULTILINE)


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Markdown of a page as the site shows it; called by MkDocs for each page."""
    name = page.file.src_uri
    if name in SHOWN:
        markdown = _LINK.sub("](../", (ROOT / SHOWN[name]).read_text(encoding="utf-8"))
    markdown = _FIELDS.sub(lambda found: fields(found[1]), markdown)
    return _NOT_RUN.sub(r'```\1 title="No test runs this: it \2"', markdown)


def fields(name: str) -> str:
    """Tables of all fields of a JSON file, one for each kind of row, from its published schema."""
    path = ROOT / "docs" / "reference" / "schemas" / f"{name}.schema.json"
    schema = json.loads(path.read_text(encoding="utf-8"))
    records = [(schema["title"], schema), *schema["$defs"].items()]
    lines = []
    for title, record in records:
        rows = record.get("properties", {})
        if not rows:
            continue
        lines += [f"### {title}\n", f"{record.get('description', '')}\n", "| field | type | meaning |", "|---|---|---|"]
        needed = record.get("required", [])
        for field, row in sorted(rows.items(), key=lambda item: (item[0] not in needed, item[0])):
            mark = "" if field in needed else " (may be left out)"
            said = [row.get("description", "").replace("|", "\\|") + mark, kind(row).replace("|", "\\|")]
            lines.append(f"| `{field}` | {said[1]} | {said[0]} |")
        lines.append("")
    return "\n".join(lines)


def kind(row: dict[str, Any]) -> str:
    """Type of a value in words; a record is a link to its table."""
    if "$ref" in row:
        return row["$ref"].rsplit("/", 1)[-1]
    if "anyOf" in row or "oneOf" in row:
        return " or ".join(kind(one) for one in row.get("anyOf", row.get("oneOf")))
    if "enum" in row or "const" in row:
        return ", ".join(f"`{value}`" for value in row.get("enum", [row.get("const")]))
    if row.get("type") == "array":
        if "prefixItems" in row:
            return f"{len(row['prefixItems'])} values: {kind(row['prefixItems'][0])}"
        return f"list of {kind(row.get('items', {}))}"
    if row.get("type") == "object" and "additionalProperties" in row:
        inner = row["additionalProperties"]
        return f"name -> {kind(inner)}" if isinstance(inner, dict) else "object"
    return str(row.get("type", "any"))
