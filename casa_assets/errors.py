"""Error classes: all that the package raises on purpose, below CasaError, and BatchFault for its own mistakes."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable


class CasaError(Exception):
    """Root of all errors that are meant to be read by a person."""


class RegistryError(CasaError):
    """The content of a registry file violates its schema."""

    def __init__(self, file: str, line: int, pointer: str, expected: str, got: str) -> None:
        self.file, self.line, self.pointer, self.expected, self.got = (file, line, pointer, expected, got)
        super().__init__(f"{file}:{line}: {pointer or '(top)'}: expected {expected}, got {got}")


class UnknownId(CasaError):
    """A name that does not exist; carries the nearest names that do.

    Args:
        kind: kind of the name. wanted: the name. known: the names that exist.
        listed_by: hint on how to list the names, shown if no name is similar and there are many or no names.
    """

    def __init__(self, kind: str, wanted: str, known: Iterable[str], listed_by: str = "") -> None:
        self.kind, self.wanted = kind, wanted
        names = sorted(known)
        self.nearest = _nearest(wanted, names)
        hint = f"did you mean {', '.join(self.nearest)}?" if self.nearest else _some(names, listed_by)
        super().__init__(f"unknown {kind} {wanted!r}; {hint}")


def _nearest(wanted: str, names: list[str], count: int = 3) -> tuple[str, ...]:
    if whole := difflib.get_close_matches(wanted, names, n=count, cutoff=0.6):
        return tuple(whole)
    words = {name: re.split("[_/]+", name) for name in names}
    near = difflib.get_close_matches(wanted, {word for parts in words.values() for word in parts}, n=1, cutoff=0.75)
    return tuple(name for name in names if near and near[0] in words[name])[:count]


def _some(names: list[str], listed_by: str) -> str:
    """Text that lists the names; for more than 12 names, how to list them, or only their number."""
    if not names:
        return listed_by or "there are none"
    if len(names) > 12:
        return listed_by or f"{len(names)} names are known"
    return f"there are {', '.join(names[:6])}" + (f" and {len(names) - 6} more" if len(names) > 6 else "")


class Rejected(CasaError):
    """A stage cannot accept its input. A run records the code and the reason and goes on.

    Args:
        code: code from registry/rejections.yaml, such as `SRC003`.
        message: one sentence for the person who has to fix the input.
    """

    def __init__(self, code: str, message: str) -> None:
        self.code, self.message = code, message
        super().__init__(f"{code}: {message}")

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return (type(self), (self.code, self.message))


class DegenerateShape(Rejected):
    """Points that span no volume although a volume is needed."""

    def __init__(self, message: str, code: str = "GEO001") -> None:
        super().__init__(code, message)

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return (type(self), (self.message, self.code))


class PluginFailure(CasaError):
    """The code of a plug-in failed on one item; the other items go on.

    Attributes:
        plugin: its name. trace: the Python traceback.
    """

    def __init__(self, plugin: str, message: str, trace: str) -> None:
        self.plugin, self.trace = plugin, trace
        super().__init__(f"plug-in {plugin}: {message}")


class OutputError(CasaError):
    """The output folder cannot be used as asked."""

    def __init__(self, path: str, message: str) -> None:
        self.path, self.message = path, message
        super().__init__(f"{path}: {message}")


class PlanConflict(CasaError):
    """The requirements of a plan contradict each other or the style.

    Args:
        plan: id of the plan. pointer: path inside the plan's file, such as `("runs", "main", "base", 2)`.
        expected: a value that would fit. got: the value in the plan.
        wanted_m: the length (m) of a height, a knee or a slope that would fit, if a correction can be made from it.
    """

    def __init__(
        self, plan: str, pointer: tuple[str | int, ...], expected: str, got: str, wanted_m: float | None = None
    ) -> None:
        self.plan, self.pointer, self.expected, self.got, self.wanted_m = plan, pointer, expected, got, wanted_m
        super().__init__(f"{plan}: {'.'.join(map(str, pointer)) or '(top)'}: expected {expected}, got {got}")


class StyleConflict(CasaError):
    """A style names a model that does not suit its role.

    Args:
        style: id of the style. pointer: path inside the style's file, such as `("models", "range")`.
        expected: a value that would suit. got: the value in the style.
    """

    def __init__(self, style: str, pointer: tuple[str | int, ...], expected: str, got: str) -> None:
        self.style, self.pointer, self.expected, self.got = style, pointer, expected, got
        super().__init__(f"{style}: {'.'.join(map(str, pointer))}: expected {expected}, got {got}")


class StopRequested(BaseException):
    """The user, or the system, asked the program to end; not an Exception, so that nothing on the way swallows it."""


class BatchFault(Exception):
    """Some items of a batch failed because of a bug in the program; all others were processed.

    Args:
        items: names of the failed items. traces: their tracebacks, if they were not reported when they occurred.
    """

    def __init__(self, items: Iterable[str], traces: str = "") -> None:
        self.items, self.traces = tuple(items), traces
        few = ", ".join(self.items[:6]) + (f" and {len(self.items) - 6} more" if len(self.items) > 6 else "")
        super().__init__(f"{few}: a fault of the program; the others were worked on")
