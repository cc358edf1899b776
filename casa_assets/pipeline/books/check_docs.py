"""docs/checks.md, printed from the table of checks and the registry."""

from __future__ import annotations

from casa_assets import registry
from casa_assets.checks.table import TABLE

HEAD = """# Checks and rejections

Printed by `./dev docs` from the table in `casa_assets/checks/table.py`, `registry/limits.yaml` and
`registry/rejections.yaml`. An asset with an error is not in the library; a warning is kept in its `asset.json`.

## Checks on every asset

| code | severity | looks at | limit | why it matters |
|---|---|---|---|---|
"""


def markdown() -> str:
    """The whole page."""
    known = registry.load()
    lines = [HEAD.rstrip("\n")]
    for row in TABLE:
        limit = f"{known.limits[row.limit]:g} {row.unit}".strip() if row.limit else ""
        lines.append(f"| {row.code} | {row.severity.value} | {row.subject.__name__} | {limit} | {row.why} |")
    lines += ["", "## Reasons for rejections and warnings of the stages", "", "| code | name | meaning | what to do |"]
    lines.append("|---|---|---|---|")
    for code, entry in sorted(known.rejections.items()):
        lines.append(f"| {code} | {entry.name} | {entry.meaning} | {entry.mend} |")
    return "\n".join(lines) + "\n"
