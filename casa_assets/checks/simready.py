"""Validate USD files by SimReady, in this process or by another Python, faster than it does and with its verdict.

Other Pythons import this module too: what it imports needs numpy, usd-core and, within functions, SimReady's packages.
"""

from __future__ import annotations

import importlib.metadata
import inspect
import json
import logging
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np
from pxr import Ar, Usd, UsdGeom

from casa_assets.checks.simready_python import NEEDED, NoVerdict, run_program, validator_python
from casa_assets.core.numeric import Floats
from casa_assets.errors import CasaError

if TYPE_CHECKING:
    from usd_validation_nvidia import BaseRuleChecker, ComplianceChecker, ComplianceCheckerEvent

PROFILE = "Robotics-Prop"
PROFILE_VERSION = "4.0.0"
# Whether a file passes, and code -> message of each requirement that the profile demands and that is not met.
Verdict = tuple[bool, dict[str, str]]
CHILD_LIMIT_S = 600.0  # a large kitchen takes seconds
# Names of folders, and lengths of paths, that no rule of SimReady refuses; its own limit is 260 characters.
_PLAIN = re.compile(r"(?!(?:CON|PRN|AUX|NUL|COM[1-9]|LPT[1-9])$)[A-Z0-9._-]+", re.IGNORECASE)
_LONGEST = 200
# Makes casa_assets, whose folder is the first argument, importable without its neighbours, packages that were built for
# another Python, and runs `answer` with the others.
_PROGRAM = """
import importlib.util as imports, sys
place = sys.argv[1]
found = imports.spec_from_file_location("casa_assets", place + "/__init__.py", submodule_search_locations=[place])
sys.modules["casa_assets"] = package = imports.module_from_spec(found)
found.loader.exec_module(package)
from casa_assets.checks import simready
simready.answer(*sys.argv[2:])
"""


def validate_simready(path: Path, folder: Path, without: frozenset[str] = frozenset()) -> Verdict:
    """Validate a USD file as SimReady's command line does, wherever it lies.

    Args:
        path: of the root layer. folder: of its asset or scene. Names of folders above it, and how long their path is,
            have no part in the verdict.
        without: codes of requirements that need not be run, since the caller does not count them.
    Returns:
        Whether it passes, and code -> message of each requirement that the profile demands and that is not met.
    Raises:
        NoVerdict: the validator is not installed, or it failed.
    """
    python = validator_python()
    with _at_plain_path(path.absolute(), folder.absolute()) as seen:
        if python:
            found = _by_child(python, seen, without)
        else:
            try:
                found = validate(seen, without)
            except ImportError as error:
                raise NoVerdict(f"SimReady's validator cannot be imported: {error}", is_missing=True) from error
    if found is None:
        raise NoVerdict("the validator of SimReady gave no verdict")
    return found


def warm() -> None:
    """Load what validates, where that is done in this process, so that processes forked from it need not."""
    with suppress(NoVerdict, ImportError):
        if not validator_python():
            load_rules()


@contextmanager
def _at_plain_path(path: Path, folder: Path) -> Iterator[Path]:
    """The same file by a path of which only `folder` and what is below it can break a rule on names or lengths."""
    above = folder.parent
    lengths = len(str(path)), len(os.path.relpath(path))
    if max(lengths) <= _LONGEST and all(_PLAIN.fullmatch(name) for name in above.parts[1:]):
        yield path
        return
    place = "/tmp" if os.access("/tmp", os.W_OK) else None  # noqa: S108  the user's own may have any name
    with tempfile.TemporaryDirectory(prefix="casa_simready_", dir=place) as root:
        link = Path(root, "above")
        link.symlink_to(above, target_is_directory=True)
        yield link / path.relative_to(above)


def _by_child(python: str, path: Path, without: frozenset[str]) -> Verdict | None:
    try:
        arguments = (str(Path(__file__).parents[1]), str(path), *sorted(without))
        done = run_program(python, _PROGRAM, arguments, CHILD_LIMIT_S)
    except subprocess.TimeoutExpired:
        raise NoVerdict(f"the validator of SimReady did not end within {CHILD_LIMIT_S:g} s") from None
    except OSError as error:
        raise NoVerdict(f"the validator of SimReady cannot be started: {error}", is_missing=True) from error
    try:
        answered = json.loads(done.stdout) if done.returncode == 0 else None
    except ValueError:
        answered = None
    if answered is None:
        words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or ["it said nothing"]
        raise NoVerdict(f"the validator of SimReady ended with {done.returncode}: {words[0][:200]}")
    if "missing" in answered:
        raise NoVerdict(f"SimReady's validator cannot be imported: {answered['missing']}", is_missing=True)
    verdict = answered["verdict"]
    return None if verdict is None else (bool(verdict[0]), dict(verdict[1]))


def answer(path: str, *without: str) -> None:
    """Print what `_by_child` reads: {"verdict": [passed, {code: message}]}, of a null verdict, or {"missing": reason}.

    Args:
        without: codes of requirements that need not be run.
    """
    # Libraries print to standard output, which is kept for the answer.
    answers = os.dup(1)
    os.dup2(2, 1)
    try:
        load_rules()
        answered: dict[str, object] = {"verdict": validate(Path(path), frozenset(without))}
    except ImportError as error:
        answered = {"missing": str(error)}
    with os.fdopen(answers, "w", encoding="utf-8") as stream:
        json.dump(answered, stream)


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Nothing that happens inside reaches standard output, standard error or a log.

    Both copies of USD (that of usd-core and the one inside MuJoCo) and the validators print from C++, so the file
    descriptors themselves are turned away. For the whole process: for use where nothing else runs.

    Yields:
        A list that holds the lines that were printed once the block has ended.
    """
    lines: list[str] = []
    with tempfile.TemporaryFile() as sink, ExitStack() as stack:
        stack.enter_context(_descriptor(1, sink.fileno()))
        stack.enter_context(_descriptor(2, sink.fileno()))
        text = stack.enter_context(open(os.dup(sink.fileno()), "w", encoding="utf-8", buffering=1))  # noqa: PTH123
        stack.enter_context(redirect_stdout(text))
        stack.enter_context(redirect_stderr(text))
        stack.enter_context(_no_logging())
        try:
            yield lines
        finally:
            text.flush()
            sink.seek(0)
            lines.extend(line for line in sink.read().decode("utf-8", "replace").splitlines() if line.strip())
            sink.seek(0, os.SEEK_END)


@contextmanager
def _descriptor(number: int, target: int) -> Iterator[None]:
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    kept = os.dup(number)
    os.dup2(target, number)
    try:
        yield
    finally:
        os.dup2(kept, number)
        os.close(kept)


@contextmanager
def _no_logging() -> Iterator[None]:
    """Also undoes the handler that the first `logging.warning` of a process installs."""
    root = logging.getLogger()
    level, handlers = logging.root.manager.disable, list(root.handlers)
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(level)
        root.handlers[:] = handlers


# Rules ----------------------------------------------------------------------------------------------------------------


def validate(path: Path, without: frozenset[str] = frozenset()) -> Verdict | None:
    """Verdict on a USD file, or None if the validator returns no result; `without`: as for `validate_simready`.

    Raises:
        ImportError: SimReady's packages are not installed here.
    """
    load_rules()
    import simready.validate
    from simready.validate.api import features_summary_passed

    config = simready.validate.AssetValidationConfig(
        asset_path=str(path), profile_id=PROFILE, profile_version=PROFILE_VERSION
    )
    with only_demanded(without):
        result = simready.validate.validate_asset(config)
    if result is None:
        return None
    failures: dict[str, str] = {}
    for issue in result.issues:
        failures.setdefault(issue.requirement.code if issue.requirement else str(issue.rule), issue.message)
    # Not `passed` of the features: those that the profile calls optional say False where they are not used.
    return features_summary_passed(result.features_summary), failures


@cache
def load_rules() -> None:
    """Register the rules of SimReady, once per process (a second with their import). Raises ImportError, CasaError."""
    # `simready.validate.initialize` takes out all rules that were registered and registers them again, which takes
    # longer than all else; so the tier's plug-in, which does nothing but import them, is kept from registering them.
    # To find tests of the tier, which nobody runs here, it would read the list of files of every installed package.
    named = {"simready": [*NEEDED]}
    absent = suppress(AttributeError, ImportError)
    with patch.object(importlib.metadata, "packages_distributions", lambda: named), absent:
        plugin = importlib.import_module("simready.foundation.tier_core._plugin")
        plugin.SimReadyPlugin.on_startup = lambda _: None
    import simready.validate

    with quiet():
        simready.validate.initialize([], [], [])
        _compare_meshes_swiftly()
        run_rules_directly()
    # The validator asks for the caller's module when it warns of one of its names that is old; the first to ask looks
    # through all modules that are loaded.
    inspect.getmodule(inspect.currentframe())


# Only demanded --------------------------------------------------------------------------------------------------------
# The validator runs all requirements of a profile, but reports only those that the profile demands; failures of the
# others, which are most of its findings in a kitchen, do not affect the verdict. Here the others are not run.

# The method by which the validator makes its runner, and the function by which SimReady sorts the requirements of a
# profile. They are not public: a version that has none is as slow as it is, and says the same.
MAKE_RUNNER, SORT_REQUIREMENTS = "_create_sync_runner", "_bucket_requirements_by_runtime"
# Codes of the requirements that are looked for, while `only_demanded` is entered.
_demanded: ContextVar[frozenset[str] | None] = ContextVar("demanded", default=None)


@contextmanager
def only_demanded(without: frozenset[str]) -> Iterator[None]:
    """Within this context, SimReady runs only the requirements that decide a verdict.

    Args:
        without: codes of demanded requirements whose failures do not matter to the caller. They may still be reported,
            by rules that cover several requirements.
    """
    from simready.validate import api

    theirs = getattr(api, SORT_REQUIREMENTS, None)
    if theirs is None:
        yield
        return

    def sort(profile: Any) -> tuple[dict[str | None, list[Any]], set[str]]:
        by_runtime, runtimes = theirs(profile)
        demanded = getattr(profile, "mandatory_requirements", None)
        if demanded is None:
            return by_runtime, runtimes
        kept = {
            runtime: [r for r in requirements if r.code in demanded and r.code not in without]
            for runtime, requirements in by_runtime.items()
        }
        _demanded.set(frozenset(r.code for requirements in kept.values() for r in requirements))
        return {runtime: requirements for runtime, requirements in kept.items() if requirements}, runtimes

    setattr(api, SORT_REQUIREMENTS, sort)
    before = _demanded.set(None)
    try:
        yield
    finally:
        _demanded.reset(before)
        setattr(api, SORT_REQUIREMENTS, theirs)


# Direct runner --------------------------------------------------------------------------------------------------------
# For every pair of a prim and a rule, the validator makes an object and asks, through several layers, whether the rule
# looks at prims at all and how it wants to be called. A kitchen has some thousand prims and the profile some eighty
# rules, most of which look at the stage once: that takes more time than the rules do. Here each rule is asked once.

BATCH = 256  # events that are run together, as many as the validator itself runs
# Methods of a rule that look for one requirement alone bear its code: check_vm_tex_001_texture_size is VM.TEX.001.
ONE_REQUIREMENT, OWNER = re.compile(r"check_([a-z]+_[a-z]+_\d{3})_"), "com.nvidia.simready."
# Methods that read a prim and are called more than once on it.
LABELS_OF, BINDING_OF = "_get_semantics_labels_api_instances", "_check_binding_mechanism"
Call = tuple["BaseRuleChecker", Callable[..., None]]


@cache
def run_rules_directly() -> None:
    """Let the validator of SimReady use the runner below, wherever it would work in this process alone."""
    from usd_validation_nvidia import BaseRuleCheckerMetadata, ComplianceChecker

    theirs = getattr(ComplianceChecker, MAKE_RUNNER, None)
    if theirs is None:
        return

    def create(
        cls: type[ComplianceChecker], rules: list[Any], stats: Any, context: Any, *, processes: int = 0
    ) -> AbstractContextManager[Any]:
        waits = any(BaseRuleCheckerMetadata(type(rule)).has_async_implementations() for rule in rules)
        if processes or waits:
            runner: AbstractContextManager[Any] = theirs(rules, stats, context, processes=processes)
            return runner
        return DirectRunner(rules, context)

    setattr(ComplianceChecker, MAKE_RUNNER, classmethod(create))


class DirectRunner(AbstractContextManager["DirectRunner"]):
    """Runs the events of a validation in batches, in their order, each by the rules that implement its method.

    Args:
        rules: in the order in which they see an event. context: of the resolver of asset paths.
    """

    def __init__(self, rules: Sequence[BaseRuleChecker], context: Ar.ResolverContext) -> None:
        self._rules, self._context = rules, context
        demanded, labels = _demanded.get(), dict[Usd.Prim, list[str]]()
        for rule in rules:
            if demanded is not None:
                _leave_out(rule, demanded)
            _read_once(rule, labels)
        self._waiting: list[ComplianceCheckerEvent] = []
        self._calls: dict[Any, list[Call]] = {}

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.flush()

    def append(self, event: ComplianceCheckerEvent) -> None:
        """Take an event in; those that wait are run where the validator asks for it, or there are many."""
        is_end = event.type is type(event.type).FLUSH
        if not is_end:
            self._waiting.append(event)
        if is_end or len(self._waiting) >= BATCH:
            self.flush()

    def flush(self) -> None:
        """Run the events that wait."""
        from usd_validation_nvidia import DelegateContextManager

        waiting, self._waiting = self._waiting, []
        if not waiting:
            return
        with DelegateContextManager(), Ar.ResolverContextBinder(self._context), Ar.ResolverScopedCache():
            for event in waiting:
                args = event.args
                for rule, check in self._calls_of(event.type):
                    try:
                        check(*args)
                    except Exception as error:  # noqa: BLE001  as the validator does: it is a finding of the rule
                        rule._AddError(message=f"Uncaught error: {error}")

    def _calls_of(self, kind: Any) -> list[Call]:
        from usd_validation_nvidia import BaseRuleChecker

        if kind not in self._calls:
            method = kind.value
            nothing = method(BaseRuleChecker)
            self._calls[kind] = [(rule, method(rule)) for rule in self._rules if method(type(rule)) is not nothing]
        return self._calls[kind]


def _leave_out(rule: BaseRuleChecker, demanded: frozenset[str]) -> None:
    """Let a rule that has a method for each of its requirements call those of the demanded ones alone.

    That on visual materials covers twenty requirements and checks each prim for all of them; the profile demands four.
    """
    for name in dir(type(rule)):
        found = ONE_REQUIREMENT.match(name)
        if found is not None and OWNER + found[1].upper().replace("_", ".") not in demanded:
            setattr(rule, name, lambda *args: [])


def _read_once(rule: BaseRuleChecker, labels: dict[Usd.Prim, list[str]]) -> None:
    """Put swift forms of what takes most time in rules on labels and on materials into a rule that has them.

    Args:
        labels: what was read of prims so far; rules of one validation share it, in which nobody changes the stage.
    """
    their_labels: Any = getattr(rule, LABELS_OF, None)
    their_check: Any = getattr(rule, BINDING_OF, None)

    def labels_of(prim: Usd.Prim) -> list[str]:
        if prim not in labels:
            labels[prim] = list(their_labels(prim))
        return labels[prim]

    def check_binding(prim: Usd.Prim, path: object) -> list[str]:
        # It makes an object of every property of a prim, twice, to find bindings by collection, and bindings that
        # say how strong they are: where there are none of these it finds nothing.
        for bound in prim.GetPropertiesInNamespace("material"):
            if ":collection:" in bound.GetName() or bound.HasAuthoredMetadata("bindMaterialAs"):
                return list(their_check(prim, path))
        return []

    if their_labels is not None:
        setattr(rule, LABELS_OF, labels_of)
    if their_check is not None:
        setattr(rule, BINDING_OF, check_binding)


# Coincident meshes ----------------------------------------------------------------------------------------------------
# The rule VG.008 rounds every coordinate of a stage in Python, which takes 3 s for a large kitchen. Meshes that it
# finds have the same topology and points that agree within its rounding: if no two meshes do, which numpy determines in
# a tenth of a second, the rule would find none.

COINCIDENT = "com.nvidia.simready.VG.008"
# Numbers that the rule rounds to the same are no farther apart than the step of its rounding; 1 % for the floats' sake.
POINTS_TO, PLACES_TO = 1.01e-6, 1.01e-4


def _compare_meshes_swiftly() -> None:
    """Put the swift form of the rule into its place. The rules of SimReady have been registered."""
    from usd_validation_nvidia import RequirementsRegistry, register_requirements

    rules = RequirementsRegistry()
    requirement = rules.find_requirement(COINCIDENT)
    if requirement is None:
        raise CasaError(
            f"SimReady's rules did not load; a file that is called like one of its modules, such as usd.py, may be in "
            f"{sys.path[0] or Path.cwd()}: rename it"
        )
    theirs = rules.get_validator(requirement)

    def check_stage(rule: BaseRuleChecker, stage: Usd.Stage) -> None:
        if could_coincide(stage):
            theirs.CheckStage(rule, stage)

    swift = type("CoincidentMeshes", (theirs,), {"CheckStage": check_stage})
    register_requirements(requirement, override=True)(swift)


def could_coincide(stage: Usd.Stage) -> bool:
    """True if two meshes of a stage have the same faces and, within the rule's rounding, points and pose."""
    alike: dict[tuple[bytes, bytes], list[tuple[Floats, Floats]]] = defaultdict(list)
    cache, first = UsdGeom.XformCache(), Usd.TimeCode.EarliestTime()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        mesh = UsdGeom.Mesh(prim)
        counts, indices = mesh.GetFaceVertexCountsAttr().Get(first), mesh.GetFaceVertexIndicesAttr().Get(first)
        points = np.array(mesh.GetPointsAttr().Get(first) or (), dtype=np.float64).reshape(-1, 3)
        place = np.array(cache.GetLocalToWorldTransform(prim))
        alike[np.array(counts or ()).tobytes(), np.array(indices or ()).tobytes()].append((place, points))
    return any(_any_meet(group) for group in alike.values())


def _any_meet(meshes: Sequence[tuple[Floats, Floats]]) -> bool:
    """True if any two (4x4 place, points) are the same but for the rounding."""
    ordered = sorted((mesh for mesh in meshes if len(mesh[1])), key=lambda mesh: float(mesh[0][3, 0]))
    for i, (place, points) in enumerate(ordered):
        for place_2, points_2 in ordered[i + 1 :]:
            if place_2[3, 0] - place[3, 0] > PLACES_TO:
                break
            near = np.abs(place_2 - place).max() <= PLACES_TO and points_2.shape == points.shape
            if near and np.abs(points_2 - points).max() <= POINTS_TO:
                return True
    return False
