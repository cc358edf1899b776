"""Find the inputs under paths that the user names; libraries among them are left out, and names are made valid text."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.ingest.source import Source


def discover_inputs(roots: Sequence[Path], library: Path) -> Iterator[Found | Refused]:
    """Inputs under the roots, in an order that no machine changes.

    Args:
        library: what lies in it is output, not input; so is what lies in another library below a root.
    """
    own = Path(os.path.realpath(library))
    tops = {Path(os.path.realpath(root)) for root in roots}
    seen: dict[Path, bool] = {}
    for one in discover(roots):
        places = [one.root / one.main] if isinstance(one, Found) else [root / one.path for root in roots]
        if not any(_is_output(place, tops, own, seen) for place in places):
            yield replace(one, source=_as_text(one.source)) if isinstance(one, Found) else one


def _as_text(source: Source) -> Source:
    """The source's words as text that every file can hold."""
    words: dict[str, Any] = {
        name: tuple(map(utf8_escaped, value)) if isinstance(value, tuple) else utf8_escaped(value)
        for name, value in source
        if isinstance(value, str | tuple) and name != "kind"
    }
    same = all(getattr(source, name) == value for name, value in words.items())
    return source if same else source.replace(**words)


def _is_output(place: Path, tops: Set[Path], own: Path, seen: dict[Path, bool]) -> bool:
    """True if a file lies in our library, or in any library that lies below a root (a root may be one)."""
    for folder in Path(os.path.realpath(place)).parents:
        if folder == own:
            return True
        if folder in tops:
            # Above it only our own library counts: the user asked for what is in there.
            return own in folder.parents
        if folder not in seen:
            seen[folder] = (folder / ".casa" / "lock").is_file()
        if seen[folder]:
            return True
    return False
