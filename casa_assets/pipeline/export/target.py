"""The folder of an export: staged beside its place, moved there by one rename, replaced only where it is an export."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from casa_assets.errors import OutputError


def check_apart(out: Path, source: Path, what: str = "the library") -> None:
    """Raise OutputError where `out` lies in `source` or `source` in it."""
    target, inside = out.resolve(), source.resolve()
    if target == inside or target in inside.parents or inside in target.parents:
        raise OutputError(str(out), f"and {what} {source} are one inside the other; name another folder")


def check_replaceable(out: Path, required: Collection[str], allowed: Collection[str] = ()) -> None:
    """Raise OutputError unless `out` is missing, empty or an earlier export.

    Args:
        required: names that every export of this kind holds. allowed: names that it may hold besides; a folder with
            any other is left alone.
    """
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise OutputError(str(out), "is no folder; name another")
    inside = {path.name for path in out.iterdir()} if out.is_dir() else set()
    needed = set(required)
    if inside and not (inside >= needed):
        lacking = min(needed - inside)
        raise OutputError(str(out), f"is neither empty nor an earlier export (it has no {lacking}); name another")
    if strange := sorted(inside - needed - set(allowed)):
        raise OutputError(
            str(out / strange[0]), "was not written by an export, which would remove it; name another OUT"
        )


@contextmanager
def staging(out: Path) -> Iterator[Path]:
    """A staging folder beside `out`, removed at the end; what killed runs have left there is removed first."""
    out.parent.mkdir(parents=True, exist_ok=True)
    for leftover in sorted(out.parent.iterdir()):
        match = re.fullmatch(re.escape(f".{out.name}.") + r"(\d+)(\.old)?", leftover.name)
        if match and not Path(f"/proc/{match[1]}").exists():
            if match[2] and not out.exists():
                leftover.rename(out)  # the run was killed between its two renames
            else:
                shutil.rmtree(leftover, ignore_errors=True)
    staged = out.with_name(f".{out.name}.{os.getpid()}")
    shutil.rmtree(staged, ignore_errors=True)
    staged.mkdir()
    try:
        yield staged
    finally:
        shutil.rmtree(staged, ignore_errors=True)


def replace_target(staged: Path, out: Path) -> None:
    """Move an export to `out`; an earlier one there is put back where that fails."""
    older = staged.with_name(f"{staged.name}.old")
    shutil.rmtree(older, ignore_errors=True)
    has_older = out.exists()
    if has_older:
        out.rename(older)
    try:
        staged.rename(out)
    except OSError:
        if has_older:
            older.rename(out)
        raise
    shutil.rmtree(older, ignore_errors=True)
