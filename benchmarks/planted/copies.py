"""Copies of a checkout: one that stays clean, and one for each fault that shares all other files with it."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

from benchmarks.planted.faults import Fault


def name_of(checkout: Path) -> str:
    """The commit of a checkout; with a digest of its files where they differ from it."""
    commit = _git(checkout, "rev-parse", "HEAD").strip()
    if not _git(checkout, "status", "--porcelain", "--", "casa_assets", "tests", "registry", "pyproject.toml"):
        return commit
    digest = hashlib.sha256()
    for name in _files(checkout):
        digest.update(f"{name}\0".encode() + (checkout / name).read_bytes())
    return f"{commit}+{digest.hexdigest()[:12]}"


def copy_clean(checkout: Path, folder: Path, jobs: int) -> Path:
    """Copy the files that git knows or would add, and compile them once for all copies of the copy."""
    for name in _files(checkout):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(checkout / name, folder / name, follow_symlinks=False)
    command = [sys.executable, "-m", "compileall", "-q", "-j", str(jobs), "casa_assets", "tests"]
    subprocess.run(command, cwd=folder, check=False, stdout=subprocess.DEVNULL)
    return folder


def copy_linked(clean: Path, folder: Path, fault: Fault | None = None) -> Path:
    """Another copy, of hard links to a clean one, in which the file of a fault is a file of its own."""
    shutil.copytree(clean, folder, copy_function=_link, symlinks=True)
    if fault is not None:
        place = folder / fault.file
        text = fault.planted(clean)
        place.unlink()
        place.write_text(text, encoding="utf-8")
        for compiled in (place.parent / "__pycache__").glob(f"{place.stem}.*.pyc"):
            compiled.unlink()
    return folder


def _link(source: str, target: str) -> None:
    os.link(source, target, follow_symlinks=False)


def _files(checkout: Path) -> list[str]:
    listed = _git(checkout, "ls-files", "-z", "--cached", "--others", "--exclude-standard").split("\0")
    return sorted({name for name in listed if name and (checkout / name).is_file()})


def _git(checkout: Path, *words: str) -> str:
    return subprocess.run(["git", *words], cwd=checkout, check=True, capture_output=True, text=True).stdout
