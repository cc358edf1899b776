"""The faults: texts of the program, each with the mistake that takes its place; and copies of a checkout with one."""

from __future__ import annotations

import hashlib
import importlib
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import yaml

FAULTS = Path(__file__).with_name("faults.yaml")


@dataclass(frozen=True)
class Fault:
    """A mistake.

    Attributes:
        id: of the fault. file: relative to the checkout. old: text that stands there once. new: what replaces it.
        kind: of mistake, such as `sign`. what: what a user sees of it, in a sentence.
    """

    id: str
    file: str
    old: str
    new: str
    kind: str
    what: str

    @property
    def package(self) -> str:
        """The package under casa_assets/ that it is in."""
        return self.file.split("/")[1].removesuffix(".py")

    @property
    def digest(self) -> str:
        """Of what is changed: a result counts as long as this stays."""
        return hashlib.sha256(f"{self.file}\0{self.old}\0{self.new}".encode()).hexdigest()[:12]

    def applies(self, checkout: Path) -> bool:
        """Whether its text stands in its file once."""
        path = checkout / self.file
        return path.is_file() and path.read_text(encoding="utf-8").count(self.old) == 1

    def planted(self, checkout: Path) -> str:
        """The text of its file with the fault in it."""
        return (checkout / self.file).read_text(encoding="utf-8").replace(self.old, self.new)


def read_faults(path: Path = FAULTS, only: Sequence[str] = ()) -> list[Fault]:
    """All faults in the order of the file, or those with some ids; raises SystemExit where there is no such id."""
    found = [Fault(**row) for row in yaml.safe_load(path.read_text(encoding="utf-8"))]
    missing = set(only) - {fault.id for fault in found}
    if missing:
        raise SystemExit(f"there is no fault {', '.join(sorted(missing))}")
    return [fault for fault in found if not only or fault.id in only]


def mistakes(faults: Sequence[Fault], checkout: Path, importing: bool) -> list[str]:
    """What is wrong with the list itself: one line for each fault that cannot be used.

    Args:
        faults: to look at. checkout: folder whose files they are for.
        importing: also run each changed module; it has to be that of this process.
    """
    found = []
    ids = [fault.id for fault in faults]
    for fault in faults:
        if ids.count(fault.id) > 1:
            found.append(f"{fault.id}: there are two of this id")
        if fault.old == fault.new or not fault.applies(checkout):
            found.append(f"{fault.id}: its text does not stand in {fault.file} once")
            continue
        text = fault.planted(checkout)
        try:
            compile(text, fault.file, "exec")
            if importing:
                _run_module(fault.file, text)
        except Exception as error:  # noqa: BLE001 - whatever a module raises is what is looked for
            found.append(f"{fault.id}: {type(error).__name__}: {error}")
    return found


def _run_module(file: str, text: str) -> None:
    """Run the text of a module in the place of the module; nothing where this Python cannot import even the latter."""
    name = file.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    try:
        own = importlib.import_module(name)
    except ImportError:
        return
    planted = ModuleType(name)
    planted.__file__ = own.__file__
    sys.modules[name] = planted
    try:
        exec(compile(text, file, "exec"), planted.__dict__)
    finally:
        sys.modules[name] = own


# Copies ---------------------------------------------------------------------------------------------------------------


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
