"""Speed up the validator of SimReady without changing its verdict.

It runs all requirements of a profile, but reports only those that the profile demands; failures of the others, which
are most of its findings in a kitchen, do not affect the verdict. Here the others are not run.

For every pair of a prim and a rule, the validator makes an object and asks, through several layers, whether the rule
looks at prims at all and how it wants to be called. A kitchen has some thousand prims and the profile some eighty
rules, most of which look at the stage once: that takes more time than the rules do. Here each rule is asked once.

The rule on visual materials covers twenty requirements and checks each prim for all of them, although the profile
demands four. Here it checks for those four. Data that it and the rules on labels read repeatedly from each prim is read
once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import cache
from types import TracebackType
from typing import Any

from pxr import Ar, Usd
from usd_validation_nvidia import (
    BaseRuleChecker,
    BaseRuleCheckerMetadata,
    ComplianceChecker,
    ComplianceCheckerEvent,
    ComplianceCheckerEventType,
    DelegateContextManager,
)

BATCH = 256  # events that are run together, as many as the validator itself runs
# The method by which the validator makes its runner, and the function by which SimReady sorts the requirements of a
# profile. They are not public: a version that has none is as slow as it is, and says the same.
MAKE_RUNNER, SORT_REQUIREMENTS = "_create_sync_runner", "_bucket_requirements_by_runtime"
# Methods of a rule that look for one requirement alone bear its code: check_vm_tex_001_texture_size is VM.TEX.001.
ONE_REQUIREMENT, OWNER = re.compile(r"check_([a-z]+_[a-z]+_\d{3})_"), "com.nvidia.simready."
# Methods that read a prim and are called more than once on it.
LABELS_OF, BINDING_OF = "_get_semantics_labels_api_instances", "_check_binding_mechanism"
Call = tuple[BaseRuleChecker, Callable[..., None]]
# Codes of the requirements that are looked for, while `only_demanded` is entered.
_demanded: ContextVar[frozenset[str] | None] = ContextVar("demanded", default=None)


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
        self._calls: dict[ComplianceCheckerEventType, list[Call]] = {}

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.flush()

    def append(self, event: ComplianceCheckerEvent) -> None:
        """Take an event in; those that wait are run where the validator asks for it, or there are many."""
        if event.type is ComplianceCheckerEventType.FLUSH:
            self.flush()
            return
        self._waiting.append(event)
        if len(self._waiting) >= BATCH:
            self.flush()

    def flush(self) -> None:
        """Run the events that wait."""
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

    def _calls_of(self, kind: ComplianceCheckerEventType) -> list[Call]:
        if kind not in self._calls:
            method = kind.value
            nothing = method(BaseRuleChecker)
            self._calls[kind] = [(rule, method(rule)) for rule in self._rules if method(type(rule)) is not nothing]
        return self._calls[kind]


def _leave_out(rule: BaseRuleChecker, demanded: frozenset[str]) -> None:
    """Let a rule that has a method for each of its requirements call those of the demanded ones alone."""
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
        # It makes an object of every property of a prim, twice, to tell of bindings by collection, and of bindings that
        # say how strong they are: where there are none of these it has nothing to tell.
        for bound in prim.GetPropertiesInNamespace("material"):
            if ":collection:" in bound.GetName() or bound.HasAuthoredMetadata("bindMaterialAs"):
                return list(their_check(prim, path))
        return []

    if their_labels is not None:
        setattr(rule, LABELS_OF, labels_of)
    if their_check is not None:
        setattr(rule, BINDING_OF, check_binding)


@cache
def run_rules_directly() -> None:
    """Let the validator of SimReady use the runner above, wherever it would work in this process alone."""
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
