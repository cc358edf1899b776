"""Random members of a family by rules that are data, under `sample:` in registry/families/<name>.yaml.

Each row names a field and the rule by which its value is drawn; rows are drawn from top to bottom. A row whose name
begins with `_` is no field: later rules refer to it. CONTRIBUTING.md lists the rules.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from operator import attrgetter
from types import MappingProxyType
from typing import Annotated, Any, TypeVar, get_args

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from casa_assets.asset.family import AvailableFinishes, Params, between, pick
from casa_assets.model.registry.document import Document, KeyPath, expected_one_of
from casa_assets.model.registry.rows import Surface

P = TypeVar("P", bound=Params)
NOTHING_FIXED: Mapping[str, Any] = MappingProxyType({})
# (values drawn so far, rng, available) -> value
Draw = Callable[[Mapping[str, Any], np.random.Generator, AvailableFinishes], Any]


def read_sample_rules(
    params: type[P],
    rules: Mapping[str, Any],
    document: Document,
    path: KeyPath = ("sample",),
    fixed: Mapping[str, Any] = NOTHING_FIXED,
) -> Callable[[np.random.Generator, AvailableFinishes], P]:
    """The function that draws a member by the rules.

    params: the type of the member. rules: field -> rule, as written in the document below `path`. fixed: field -> value
    that all members share, already checked. Raises RegistryError: a field, a rule or a value that `params` does not
    take; it names file, line and pointer.
    """
    draws: dict[str, Draw] = {}
    for name, rule in rules.items():
        if name not in params.model_fields and not name.startswith("_"):
            expected = expected_one_of(tuple(params.model_fields), name)
            raise document.fault((*path, name), expected, repr(name))
        draws[name] = _RuleReader(document, params, name, tuple(draws)).read(rule, (*path, name))

    def sample(rng: np.random.Generator, available: AvailableFinishes) -> P:
        values: dict[str, Any] = dict(fixed)
        for name, draw in draws.items():
            values[name] = draw(values, rng, available)
        return params(**{name: value for name, value in values.items() if name in params.model_fields})

    return sample


def read_fixed(params: type[P], stated: Mapping[str, Any], document: Document, path: KeyPath) -> Mapping[str, Any]:
    """The values that all members have, as they are written. Raises RegistryError where `params` does not take one."""
    for name, value in stated.items():
        if name not in params.model_fields:
            raise document.fault((*path, name), expected_one_of(tuple(params.model_fields), name), repr(name))
        _RuleReader(document, params, name, ()).constant(value, (*path, name))
    return stated


@cache
def _type_of(params: type[Params], name: str) -> TypeAdapter[Any]:
    """The type of a field's values; Any if there is no such field. Cached: hundreds of rules ask for the same."""
    field = params.model_fields.get(name)
    annotation: Any = Annotated[field.annotation, field] if field else Any
    return TypeAdapter(annotation)


class _RuleReader:
    """Reads the rule of one row, which may refer to the rows before it."""

    def __init__(self, document: Document, params: type[Params], name: str, earlier: tuple[str, ...]) -> None:
        field = params.model_fields.get(name)
        self.document = document
        self.params = params
        self.kinds = _kinds(field)
        self.type = _type_of(params, name)
        self.earlier = earlier

    def read(self, rule: Any, path: KeyPath) -> Draw:
        """The rule as a function. Raises RegistryError."""
        match rule:
            case "any":
                return self._any(path)
            case list() if rule:
                options = [self.read(option, (*path, i)) for i, option in enumerate(rule)]
                return lambda values, rng, available: pick(rng, options)(values, rng, available)
            case {"range": [low, high], "step": float(step), **rest} if not rest:
                low, high = self.constant(low, path), self.constant(high, path)
                return lambda values, rng, available: between(rng, low, high, step)
            case {"one_of": [_, *_] as options, **rest} if not rest:
                chosen = [self.constant(option, (*path, i)) for i, option in enumerate(options)]
                return lambda values, rng, available: pick(rng, chosen)
            case {"integers": [int(first), int(last)], **rest} if not rest:
                return lambda values, rng, available: int(rng.integers(first, last + 1))
            case {"chance": float(share), **branches} if branches.keys() <= {"then", "else"}:
                hit = self.read(branches.get("then", True), path)
                miss = self.read(branches.get("else", False), path)
                return lambda values, rng, available: (hit if rng.random() < share else miss)(values, rng, available)
            case {"surface": str(name), **rest} if not rest and name in tuple(Surface):
                return lambda values, rng, available: available.draw(rng, Surface(name))
            case {"sum": [_, _, *_] as terms, **rest} if not rest:
                return self._rounded(sum, terms, path)
            case {"product": [_, _, *_] as terms, **rest} if not rest:
                return self._rounded(math.prod, terms, path)
            case {"same_as": str(name), **rest} if not rest:
                value_of = self._earlier(name, path)
                return lambda values, rng, available: value_of(values)
            case {"by": str(name), **cases} if cases:
                return self._cases(name, cases, path)
            case dict() | list():
                raise self.document.fault(path, "a rule of a random member", repr(rule)[:80])
        constant = self.constant(rule, path)
        return lambda values, rng, available: constant

    def _any(self, path: KeyPath) -> Draw:
        """Any member of the field's enumeration, or a drawn look of cabinets or appliances."""
        for kind in self.kinds:
            if issubclass(kind, Params):
                return lambda values, rng, available: available.draw_look(rng, kind)
            if issubclass(kind, Enum):
                members = tuple(kind)
                return lambda values, rng, available: pick(rng, members)
        raise self.document.fault(path, "a rule: the field is neither an enumeration nor a look", "'any'")

    def _rounded(self, combine: Callable[[list[float]], float], terms: list[Any], path: KeyPath) -> Draw:
        """Sum or product of numbers, to a millimetre; the terms need not be values that the field takes."""
        reader = _RuleReader(self.document, self.params, "", self.earlier)
        draws = [reader.read(term, (*path, i)) for i, term in enumerate(terms)]
        return lambda values, rng, available: round(combine([draw(values, rng, available) for draw in draws]), 3)

    def _cases(self, name: str, cases: Mapping[Any, Any], path: KeyPath) -> Draw:
        """The rule for the value of an earlier row; the case `a or b` covers two values, `else` all others."""
        value_of = self._earlier(name, path)
        draws = {value: self.read(rule, (*path, key)) for key, rule in cases.items() for value in key.split(" or ")}
        kinds = _kinds(self.params.model_fields.get(name))
        known = [str(member.value) for kind in kinds if issubclass(kind, Enum) for member in kind]
        for value in draws.keys() - {*known, "else"} if known else ():
            raise self.document.fault((*path, value), expected_one_of((*known, "else"), value), repr(value))
        missing = [value for value in known or ["else"] if value not in draws]
        if missing and "else" not in draws:
            raise self.document.fault(path, f"also a rule for {', '.join(missing)}", ", ".join(cases))

        def draw(values: Mapping[str, Any], rng: np.random.Generator, available: AvailableFinishes) -> Any:
            value = value_of(values)
            text = str(value).lower() if isinstance(value, bool) else str(value)
            return draws[text if text in draws else "else"](values, rng, available)

        return draw

    def _earlier(self, name: str, path: KeyPath) -> Callable[[Mapping[str, Any]], Any]:
        """The value of an earlier row, such as `form`, or a field of it, such as `look.form`."""
        row, _, field = name.partition(".")
        if row not in self.earlier:
            raise self.document.fault(path, f"an earlier row, {expected_one_of(self.earlier, row)}", repr(name))
        return (lambda values: attrgetter(field)(values[row])) if field else (lambda values: values[row])

    def constant(self, value: Any, path: KeyPath) -> Any:
        """A value that the field takes, as it is written."""
        try:
            self.type.validate_python(value)
        except ValidationError as error:
            message = error.errors()[0]["msg"].removeprefix("Input should be ")
            raise self.document.fault(path, message, repr(value)[:80]) from None
        return value


def _kinds(field: FieldInfo | None) -> tuple[type, ...]:
    """Classes that a field's annotation names: one, or those of a union."""
    annotation = field.annotation if field else None
    return tuple(kind for kind in (annotation, *get_args(annotation)) if isinstance(kind, type))
