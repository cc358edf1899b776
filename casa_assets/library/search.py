"""Search a library for assets that words or conditions describe, by their metadata, or with CLIP by their pictures.

    CONDITION  = FIELD OPERATOR VALUE [ "," VALUE ... ]      such as `category=mug`, `size<=0.3` or `reason=FLT005`
    OPERATOR   = "=" | "!=" | ">" | ">=" | "<" | "<="

Values of words are compared as they are written; several are alternatives.
"""

from __future__ import annotations

import difflib
import heapq
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from casa_assets import registry
from casa_assets.cache.store import Store
from casa_assets.errors import CasaError
from casa_assets.library.clip import ClipModel, image_embeddings, text_embedding
from casa_assets.library.entry import ROWS_NAME, Entry
from casa_assets.library.entry_table import EntryTable, stream_entries
from casa_assets.library.library import Library
from casa_assets.model.issue import Decision
from casa_assets.model.registry.category import PICTURE_PROMPTS

if TYPE_CHECKING:
    from casa_assets.library.entry import Entry

# Field of a condition -> the words of an entry that it is about.
WORDS: Mapping[str, Callable[[Entry], Sequence[str]]] = {
    "category": lambda entry: (entry.category,),
    "verdict": lambda entry: (entry.decision.value,),
    "reason": lambda entry: (entry.code, *entry.advice),
    "decide": lambda entry: entry.to_decide,
    "source": lambda entry: (entry.source,),
    "licence": lambda entry: (entry.licence,),
    "author": lambda entry: (entry.author,),
    "split": lambda entry: (entry.split,),
    "producer": lambda entry: (entry.producer,),
    "id": lambda entry: (entry.id,),
}
# Field of a condition -> the number of an entry that it is about; None where it has none.
NUMBERS: Mapping[str, Callable[[Entry], float | None]] = {
    "size": lambda entry: max(entry.summary.extents) if entry.summary else None,
    "mass": lambda entry: entry.summary.mass if entry.summary else None,
    "faces": lambda entry: entry.summary.faces if entry.summary else None,
    "colliders": lambda entry: entry.summary.colliders if entry.summary else None,
    "warnings": lambda entry: len(entry.warnings),
}
# Fields whose values are codes or subjects, and have no blanks.
CODES = frozenset({"reason", "decide"})
COMPARE: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
}
# Fields whose conditions look among rejected inputs, too; all others are about assets.
OF_REJECTED = frozenset({"verdict", "reason", "id"})
_FORM = re.compile(r"\s*([a-z]+)\s*(!=|>=|<=|=|>|<)\s*(.*\S)\s*", re.DOTALL)
GRAMMAR = (
    f"write a field, =, !=, >, >=, < or <=, and a value; fields of words are {', '.join(WORDS)} (values after commas "
    f"are alternatives), of numbers {', '.join(NUMBERS)} (size: longest side in metres, mass in kg)"
)


class BadCondition(CasaError):
    """A condition that is not of the grammar."""


@dataclass(frozen=True)
class Condition:
    """One condition. field: of WORDS or NUMBERS. compare: the operator. values: text, or one number."""

    field: str
    compare: str
    values: tuple[str | float, ...]


def parse_condition(text: str) -> Condition:
    """The condition that a text states. Raises BadCondition."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise BadCondition(f"--where {text!r} is no condition; {GRAMMAR}")
    name, compare, said = found.groups()
    if name in NUMBERS:
        if name == "size" and compare in ("=", "!="):
            raise BadCondition(f"--where {text!r}: {name} is compared with >, >=, < or <=; {GRAMMAR}")
        return Condition(name, compare, (_number(text, said),))
    if name not in WORDS:
        near = difflib.get_close_matches(name, [*WORDS, *NUMBERS], n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise BadCondition(f"--where {text!r}: no field is called {name!r}{hint}; {GRAMMAR}")
    if compare not in ("=", "!="):
        raise BadCondition(f"--where {text!r}: {name} is a word, and is compared with = or !=; {GRAMMAR}")
    values = tuple(value.strip() for value in said.split(","))
    if name == "verdict" and (wrong := set(values) - set(Decision)):
        raise BadCondition(f"--where {text!r}: {min(wrong)!r} is no verdict; they are {', '.join(Decision)}")
    if name in CODES and (odd := [value for value in values if not re.fullmatch(r"[A-Za-z0-9_]+", value)]):
        raise BadCondition(f"--where {text!r}: {odd[0]!r} is no {name}; {GRAMMAR}")
    return Condition(name, compare, values)


def _number(text: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadCondition(f"--where {text!r}: {value!r} is no number; {GRAMMAR}")
    return number


def with_default(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """The conditions, and one that leaves rejected inputs out unless a condition is about these."""
    if any(one.field in OF_REJECTED for one in conditions):
        return tuple(conditions)
    return (*conditions, Condition("verdict", "!=", (Decision.REJECTED.value,)))


def meets(entry: Entry, conditions: Sequence[Condition]) -> bool:
    """True if an entry meets all conditions. A number that an entry lacks meets none."""
    return all(_holds(entry, one) for one in conditions)


def _holds(entry: Entry, one: Condition) -> bool:
    if one.field in NUMBERS:
        number = NUMBERS[one.field](entry)
        return number is not None and COMPARE[one.compare](number, one.values[0])
    return set(WORDS[one.field](entry)).isdisjoint(one.values) is (one.compare == "!=")


# Other words for the colours that tints are named by.
COLOR_SYNONYMS = {"gray": "grey", "silver": "grey", "cyan": "turquoise", "teal": "turquoise", "violet": "purple"}
# Words that are left out of a query.
STOP_WORDS = frozenset({"a", "an", "the", "of", "with", "and", "in", "for", "some"})
# Score of a word that is found in the category, in a class above it, and in what the source says.
BY_CATEGORY, BY_CLASS, BY_SOURCE = 1.0, 0.6, 0.5


@dataclass(frozen=True)
class SearchHit:
    """An asset that matches a search.

    Attributes:
        score: how well it matches: a cosine in searches by pictures, else a sum over the words, 0 without words.
        reason: why, in words. entry: of the asset, if the search was by words or conditions.
    """

    id: str
    category: str
    folder: Path
    score: float
    reason: str
    entry: Entry | None = None


@dataclass(frozen=True)
class Found:
    """Result of a search. hits: the best ones. count: number of all matches."""

    hits: list[SearchHit]
    count: int


def search_by_picture(query: str, library: Library, eye: ClipModel, most: int) -> list[SearchHit]:
    """The assets whose pictures fit words best, best first. Raises OutputError, CannotDraw, NoRenderer."""
    store = Store(library.cache)
    query_embedding = text_embedding([picture.format(query) for picture in PICTURE_PROMPTS], eye, store)
    hits = []
    for row in EntryTable(library).rows:
        cosines = image_embeddings(row, eye, store) @ query_embedding
        best = int(np.argmax(cosines))
        hits.append(
            SearchHit(row.id, row.category, row.folder, round(float(cosines.mean()), 4), f"best in view {best + 1}")
        )
    return sorted(hits, key=lambda hit: (-hit.score, hit.id))[:most]


def entries_that(library: Library, conditions: Sequence[Condition]) -> Iterator[Entry]:
    """The entries that meet all conditions, one after the other. Raises OutputError: an entry is damaged."""
    return (entry for entry in stream_entries(library) if meets(entry, conditions))


def search_by_words(query: str, library: Library, most: int) -> list[SearchHit]:
    """The assets whose category, title, path or colours have most of the words, best first. Raises OutputError."""
    return search_entries(entries_that(library, with_default(())), library.root, query, most).hits


def search_entries(found: Iterable[Entry], root: Path, query: str, most: int) -> Found:
    """The entries whose category, title, path or colours have most of the words, best first; without words all, by id.

    However many entries there are, no more than `most` are kept in memory.

    Raises:
        OutputError: an entry is damaged.
    """
    words = [COLOR_SYNONYMS.get(word, word) for word in tokens(query) if word not in STOP_WORDS]
    judge, count = _Judge(words), 0

    def judged() -> Iterator[tuple[tuple[int, float, str], Entry, str]]:
        nonlocal count
        for entry in found:
            matched, score, reason = judge(entry)
            if matched or not words:
                count += 1
                yield (-matched, -score, entry.id), entry, reason

    best = heapq.nsmallest(most, judged(), key=lambda one: one[0])
    hits = []
    for (_, score, _), entry, reason in best:
        folder = root / entry.path
        folder = folder.parent if folder.name == ROWS_NAME else folder  # many rows that were refused share a file
        hits.append(SearchHit(entry.id, entry.category, folder, round(-score, 3), reason, entry))
    return Found(hits, count)


class _Judge:
    """Scores entries by words. Callable with an entry: how many words it has, the score, and the reason."""

    def __init__(self, words: Sequence[str]) -> None:
        self._words, self._known = words, registry.load()
        # Category -> its words, and those of the classes above it.
        self._kinds: dict[str, tuple[frozenset[str], frozenset[str]]] = {}

    def __call__(self, entry: Entry) -> tuple[int, float, str]:
        if not self._words:
            return 0, 0.0, ""
        colors, said = dict(entry.colors), f"{entry.title} {entry.prompt} {entry.source_path}".lower()
        found = [self._word(word, entry.category, colors, said) for word in self._words]
        matched = [(value, why) for value, why in found if value > 0]
        return len(matched), sum(value for value, _ in matched), ", ".join(why for _, why in matched)

    def _word(self, word: str, category: str, colors: Mapping[str, float], said: str) -> tuple[float, str]:
        """Score of a word for an asset, and the reason."""
        if word in colors:
            return colors[word], f"{colors[word]:.0%} {word}"
        names, classes = self._kind(category)
        if word in names:
            return BY_CATEGORY, f"{word!r} is its category"
        if word in classes:
            return BY_CLASS, f"{word!r} is a class of it"
        if word in said and word in tokens(said):  # most texts have none of the words, which is told quickly
            return BY_SOURCE, f"its source says {word!r}"
        return 0.0, ""

    def _kind(self, category: str) -> tuple[frozenset[str], frozenset[str]]:
        if category not in self._kinds:
            kind = self._known.categories.get(category)
            names = _all((kind.id, *kind.aliases, *kind.lvis)) if kind else frozenset()
            self._kinds[category] = names, _all(self._known.classes_of(kind)) if kind else frozenset()
        return self._kinds[category]


def tokens(text: str) -> list[str]:
    """The words of a text in small letters, without the s of plurals."""
    found = re.findall(r"[a-z0-9]+", text.lower())
    return [word[:-1] if len(word) > 3 and word.endswith("s") and not word.endswith("ss") else word for word in found]


def _all(texts: Sequence[str]) -> frozenset[str]:
    return frozenset(word for text in texts for word in tokens(text))
