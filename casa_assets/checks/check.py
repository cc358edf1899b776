"""Checks: the row type of their table, what a check function returns, a written asset, running rows, what they fit."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from casa_assets.core.numeric import Floats, Ints, significant
from casa_assets.model.asset.asset import UNFOUND_PARTS, Asset, Collider, Link, Visual
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.contract import Contract
from casa_assets.model.source import SourceKind

# Where a fault is, as a path such as `links/door/colliders`, and what is wrong there.
Problem = tuple[str, str]
Row = tuple[str, float, str]  # pointer, number, and what is wrong if the number is beyond the limit
# Reasons as reports give them.
NOT_BUILT = "it came as a mesh, and built things alone are held to this"
NO_JOINTS = "it has no joints"
NO_COLLIDERS = "none of its links has a collision shape"
NO_VISUALS = "nothing of it is seen"
NO_COMPILE = "model.xml does not compile"
NO_WAIVERS: Mapping[str, str] = {}  # what is waived where nothing is; shared and never written to


@dataclass(frozen=True)
class Package:
    """A written asset.

    Attributes:
        asset: what the writers were given.
        category: its category in the registry.
        root: its folder, with `model.xml`, `scene.xml`, the USD file at `usd/<id>.usda`, and `usd/nested/<id>.usda`
            if there are several links.
        contract: what runtimes expect of it, None if the registry has no contract of the name that the asset gives.
    """

    asset: Asset
    category: Category
    root: Path
    contract: Contract | None = None

    @property
    def mjcf(self) -> Path:
        """The model file: one body `object`, no floor, no free joint."""
        return self.root / "model.xml"

    @property
    def scene(self) -> Path:
        """The model on a floor under a light, free to move where its base is free."""
        return self.root / "scene.xml"

    @property
    def usd(self) -> Path:
        """The USD package's root layer."""
        return self.root / "usd" / f"{self.asset.id}.usda"

    @property
    def usd_files(self) -> tuple[Path, ...]:
        """The root layer, and where there are several links the layer that nests their bodies."""
        nested = self.usd.parent / "nested" / self.usd.name
        return (self.usd, nested) if len(self.asset.links) > 1 else (self.usd,)


@dataclass(frozen=True)
class Measurement:
    """Result of a check function: the (worst) number with its problems, or the reason why there is no number.

    `status`: NOT_APPLICABLE or NOT_RUN if nothing was measured, PASSED if there is no fault and no number to report;
    None if the problems decide. `waived`: that it was not run is not held against the subject.
    """

    number: float | None = None
    problems: tuple[Problem, ...] = ()
    status: Status | None = None
    reason: str = ""
    waived: bool = False

    def __post_init__(self) -> None:
        """A check that measured nothing and found nothing has to say why: it does not pass by silence."""
        if self.status is None:
            assert self.number is not None or self.problems, "say no_fault, not_applicable or not_run"
        else:
            assert self.number is None, "a number belongs to what was measured"
            assert not self.problems, "problems belong to what was measured"


def no_fault() -> Measurement:
    """Result for a subject that was examined and has no fault, if there is no number to report."""
    return Measurement(status=Status.PASSED)


def not_applicable(reason: str) -> Measurement:
    """The subject has nothing of the kind that the check is about; `reason` is a part of a sentence."""
    return Measurement(status=Status.NOT_APPLICABLE, reason=reason)


def not_run(reason: str, waived: bool = False) -> Measurement:
    """The check applies, but could not look. `reason`: part of a sentence. `waived`: as without an optional package."""
    return Measurement(status=Status.NOT_RUN, reason=reason, waived=waived)


class Unmeasured(Exception):
    """Ends a check that does not apply or could not look, from within what several checks share."""

    def __init__(self, measurement: Measurement) -> None:
        super().__init__(measurement.reason)
        self.measurement = measurement


def at_most(number: float, limit: float, pointer: str, message: str) -> Measurement:
    """A number, with a problem where it exceeds the limit or is not a number."""
    return Measurement(number, () if number <= limit else ((pointer, message),))


def at_least(number: float, limit: float, pointer: str, message: str) -> Measurement:
    """A number, with a problem where it is below the limit or not a number."""
    return Measurement(number, () if number >= limit else ((pointer, message),))


def worst_above(rows: Iterable[Row], limit: float, otherwise: str | None = None) -> Measurement:
    """The largest number of some rows, with a problem for each that exceeds the limit; `otherwise`: without rows.

    Without `otherwise`, 0 is the least that is measured, also without rows.
    """
    found = list(rows)
    numbers = [*([0.0] if otherwise is None else []), *(number for _, number, _ in found)]
    return largest(numbers, [(p, m) for p, number, m in found if number > limit], otherwise or "")


def worst_below(rows: Iterable[Row], limit: float, otherwise: str) -> Measurement:
    """The least number of some rows, with a problem for each below the limit; `otherwise`: without rows."""
    found = list(rows)
    return least((number for _, number, _ in found), [(p, m) for p, number, m in found if number < limit], otherwise)


def all_at_most(numbers: Mapping[str, float], limit: float, message: str, otherwise: str) -> Measurement:
    """The largest of several numbers by pointer, with a problem for each that exceeds the limit.

    `message`: a format with one field for the number. `otherwise`: why the check does not apply without numbers.
    """
    return worst_above(((pointer, n, message.format(n)) for pointer, n in numbers.items()), limit, otherwise)


def all_at_least(numbers: Mapping[str, float], limit: float, message: str, otherwise: str) -> Measurement:
    """The least of several numbers, with a problem for each below the limit. Arguments are as for `all_at_most`."""
    return worst_below(((pointer, n, message.format(n)) for pointer, n in numbers.items()), limit, otherwise)


def largest(numbers: Iterable[float], problems: Iterable[Problem], otherwise: str) -> Measurement:
    """The largest number with these problems; not applicable, for the reason `otherwise`, if there are no numbers."""
    values = list(numbers)
    return Measurement(float(max(values)), tuple(problems)) if values else not_applicable(otherwise)


def least(numbers: Iterable[float], problems: Iterable[Problem], otherwise: str) -> Measurement:
    """The least number with these problems; not applicable, for the reason `otherwise`, if there are no numbers."""
    values = list(numbers)
    return Measurement(float(min(values)), tuple(problems)) if values else not_applicable(otherwise)


def count(problems: Iterable[Problem], allowed: float = 0) -> Measurement:
    """The number of problems, which are reported where there are more than `allowed`."""
    found = tuple(problems)
    return Measurement(float(len(found)), found if len(found) > allowed else ())


# Takes the subject and the row's limits (`Check.limit` where it names one, then `Check.others`), measures, and changes
# nothing.
CheckFunction = Callable[..., Measurement]


@dataclass(frozen=True)
class Check:
    """One row of the table of checks.

    Attributes:
        code: such as `AST002`; never reused.
        severity: an error keeps the asset out of the library; a warning is advice.
        limit: key in registry/limits.yaml of the limit of the number, or None. others: keys of further limits.
        description: one sentence: what is measured, against which limit, and what to do if it fails. `{limit}` and
            `{mm}` (a thousand times the limit) are placeholders for the number, the keys of `others` for theirs.
    """

    code: str
    title: str
    severity: Severity
    subject: type
    function: CheckFunction
    limit: str | None
    unit: str
    description: str
    others: tuple[str, ...] = ()

    def run(self, subject: object, limits: Mapping[str, float]) -> Measurement:
        """Call the function with its limits. Raises KeyError where `limits` lacks one."""
        keys = self.others if self.limit is None else (self.limit, *self.others)
        try:
            return self.function(subject, *(limits[key] for key in keys))
        except Unmeasured as end:
            return end.measurement

    def describe(self, limits: Mapping[str, float]) -> str:
        """The description with its numbers. Raises KeyError where `limits` lacks one."""
        values = {key: limits[key] for key in self.others}
        if self.limit is not None:
            value = limits[self.limit]
            values |= {"limit": value, "mm": 1e3 * value, "mm2": 1e6 * value}
        return self.description.format(**values)


_MESHES = frozenset(kind.value for kind in SourceKind)


def is_from_family(asset: Asset) -> bool:
    """True if a family built it, so that its shape is known exactly."""
    return asset.provenance.source == "family"


def is_fixture_like(asset: Asset) -> bool:
    """True if a family built it, or if it represents a fixture that a runtime operates.

    Assets from meshes keep the joints, seams and faces that they came with; the checks for those have wider limits.
    """
    return asset.contract is not None or is_from_family(asset)


def is_loose_mesh(asset: Asset) -> bool:
    """True if it was ingested as one rigid mesh; the filters (FLT) apply to those.

    False for an asset that has one link only because its moving parts are still to be found.
    """
    is_one_link = asset.provenance.source in _MESHES and len(asset.links) == 1
    return is_one_link and all(g.subject != UNFOUND_PARTS for g in asset.provenance.guesses)


def visuals_of(asset: Asset) -> Iterator[tuple[str, Link, Visual]]:
    """(pointer, link, visual) of all that is seen."""
    for link in asset.links:
        for visual in link.visuals:
            yield f"links/{link.name}/visuals/{visual.name}", link, visual


def colliders_of(asset: Asset) -> Iterator[tuple[str, Link, Collider]]:
    """(pointer, link, collider) of all collision shapes."""
    for link in asset.links:
        for collider in link.colliders:
            yield f"links/{link.name}/colliders/{collider.name}", link, collider


def merged_mesh(visuals: Sequence[Visual]) -> tuple[Floats, Ints]:
    """(P, 3) vertices and (F, 3) faces of several visuals of one link, in their order; metres, link frame."""
    starts = np.cumsum([0, *(len(v.mesh.vertices) for v in visuals)])
    faces = np.concatenate([v.mesh.faces + s for v, s in zip(visuals, starts, strict=False)]).astype(np.int64)
    return np.concatenate([v.mesh.vertices for v in visuals]), faces


def run(
    subject: object,
    name: str,
    limits: Mapping[str, float],
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] | None = None,
) -> Report:
    """Report, under a name, of every check whose subject type is that of `subject`.

    Args:
        waived: code -> reason of the checks that are not run on this subject; the report lists them as not run.
        table: rows to run; None: all. The rows of libraries alone need neither MuJoCo nor USD, which take a second
            to import.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    results: list[CheckResult] = []
    issues: list[Issue] = []
    for check in _rows(table):
        if not isinstance(subject, check.subject):
            continue
        if check.code in waived:
            results.append(_result(check, not_run(waived[check.code], waived=True), limits))
            continue
        with _mujoco_warnings():
            measured = check.run(subject, limits)
        results.append(_result(check, measured, limits))
        issues += [Issue(code=check.code, severity=check.severity, pointer=p, message=s) for p, s in measured.problems]
    return Report(subject=name, results=tuple(results), issues=tuple(issues))


def report_not_run(
    kinds: tuple[type, ...],
    name: str,
    limits: Mapping[str, float],
    reason: str,
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] | None = None,
) -> Report:
    """Report of checks of some types of subjects that could not be run, all for one reason (part of a sentence)."""
    results = tuple(
        _result(check, not_run(waived.get(check.code, reason), waived=check.code in waived), limits)
        for check in _rows(table)
        if check.subject in kinds
    )
    return Report(subject=name, results=results)


def load_table() -> Iterable[Check]:
    """Every check there is; the first call imports them all, which takes a quarter of a second."""
    from casa_assets.checks.table import TABLE

    return TABLE


def _rows(table: Iterable[Check] | None) -> Iterable[Check]:
    return load_table() if table is None else table


def _mujoco_warnings() -> AbstractContextManager[object]:
    """Listens to MuJoCo, whose warnings while it simulates or reads a file again would else be written to a log.

    Where no row has imported MuJoCo, none will be warned by it.
    """
    if "mujoco" not in sys.modules:
        return nullcontext()
    from casa_assets.checks.readers.mujoco_facts import native_warnings

    return native_warnings()


def _result(check: Check, measured: Measurement, limits: Mapping[str, float]) -> CheckResult:
    return CheckResult(
        code=check.code,
        status=measured.status or (Status.FAILED if measured.problems else Status.PASSED),
        severity=check.severity,
        reason=measured.reason,
        waived=measured.waived,
        # More than six digits would carry the noise of the machine's arithmetic into the library.
        number=None if measured.number is None else significant(measured.number, 6),
        limit=None if check.limit is None else limits[check.limit],
        unit=check.unit,
    )
