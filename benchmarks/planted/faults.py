"""The faults: texts of the program, each with the mistake that takes its place."""

from __future__ import annotations

import hashlib
import importlib
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
