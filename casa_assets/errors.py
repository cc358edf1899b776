"""Error classes. Everything that the package raises on purpose descends from CasaError.

CasaError
+-- RegistryError      a file under registry/ is wrong: file, line, pointer, expected, got
+-- UnknownId          a name that does not exist: kind, wanted, nearest names that do
+-- Rejected           an input that a stage cannot accept: code, message
|   +-- DegenerateShape   points that span no volume (code GEO001)
+-- OutputError        the output folder cannot be used: path, message
+-- PluginFailure      code of a plug-in has failed: plug-in, message, trace
+-- PlanConflict       a plan and a style cannot be made into a kitchen: plan, pointer, expected, got
+-- StyleConflict      a style names a model that does not suit its role: style, pointer, expected, got

BatchFault stands beside the tree: some items of a batch met a fault of the program, the others are done.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class CasaError(Exception):
    """Root of all errors that are meant to be read by a person."""


class RegistryError(CasaError):
    """A registry file does not say what its schema asks for."""

    def __init__(self, file: str, line: int, pointer: str, expected: str, got: str) -> None:
        self.file, self.line, self.pointer, self.expected, self.got = (file, line, pointer, expected, got)
        super().__init__(f"{file}:{line}: {pointer or '(top)'}: expected {expected}, got {got}")


class UnknownId(CasaError):
    """A name that nothing answers to; carries the nearest names that exist.

    Args:
        advice: what to do where no name is known.
    """

    def __init__(self, kind: str, wanted: str, known: Iterable[str], advice: str = "") -> None:
        self.kind, self.wanted = kind, wanted
        names = sorted(known)
        self.nearest = tuple(difflib.get_close_matches(wanted, names, n=3, cutoff=0.5))
        hint = f"; did you mean {', '.join(self.nearest)}?" if self.nearest else _some(names)
        hint = f": {advice}" if advice and not names else hint
        super().__init__(f"unknown {kind} {wanted!r}{hint}")


def _some(names: list[str], count: int = 6) -> str:
    """What there is, for whoever asked for something like none of it."""
    if not names:
        return "; there are none"
    return f"; there are {', '.join(names[:count])}" + (f" and {len(names) - count} more" if len(names) > count else "")


class Rejected(CasaError):
    """A stage cannot accept its input. The pipeline records the code and the reason and goes on.

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
    """Points that span no volume where a volume is needed."""

    def __init__(self, message: str, code: str = "GEO001") -> None:
        super().__init__(code, message)

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return (type(self), (self.message, self.code))


class PluginFailure(CasaError):
    """Code of a plug-in has failed on one thing; the others go on.

    Attributes:
        plugin: its name. trace: where it failed, as Python prints it.
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
    """What a plan asks for does not go together, or not with the style.

    Args:
        plan: id of the plan.
        pointer: path inside the plan's file, such as `("runs", "main", "base", 2)`.
        expected: what would fit. got: what the plan has.
        wanted_m: the length that would fit, where a mend is made from it: of a height, a knee or a slope, metres.
    """

    def __init__(
        self, plan: str, pointer: tuple[str | int, ...], expected: str, got: str, wanted_m: float | None = None
    ) -> None:
        self.plan, self.pointer, self.expected, self.got, self.wanted_m = plan, pointer, expected, got, wanted_m
        super().__init__(f"{plan}: {'.'.join(map(str, pointer)) or '(top)'}: expected {expected}, got {got}")


class StyleConflict(CasaError):
    """A style names a model that does not suit its role.

    Args:
        style: id of the style.
        pointer: path inside the style's file, such as `("models", "range")`.
        expected: what would suit. got: what the style has.
    """

    def __init__(self, style: str, pointer: tuple[str | int, ...], expected: str, got: str) -> None:
        self.style, self.pointer, self.expected, self.got = style, pointer, expected, got
        super().__init__(f"{style}: {'.'.join(map(str, pointer))}: expected {expected}, got {got}")


class BatchFault(Exception):
    """Some items of a batch failed by a fault of the program; all the others were worked on.

    Args:
        items: names of those that failed. traces: of them, where they were not told as they failed.
    """

    def __init__(self, items: Iterable[str], traces: str = "") -> None:
        self.items, self.traces = tuple(items), traces
        few = ", ".join(self.items[:6]) + (f" and {len(self.items) - 6} more" if len(self.items) > 6 else "")
        super().__init__(f"{few}: a fault of the program; the others were worked on")
