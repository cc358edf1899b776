"""Search a library for assets that words describe: by their pictures with CLIP, or by their metadata alone."""

from __future__ import annotations

import heapq
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.cache.store import Store
from casa_assets.library import library as disk
from casa_assets.library.analysis.clip import ClipModel
from casa_assets.library.analysis.clip_embeddings import image_embeddings, text_embedding
from casa_assets.library.entry import Entry
from casa_assets.library.refused_rows import NAME as ROWS
from casa_assets.library.table.conditions import Condition, meets, with_default
from casa_assets.library.table.entry_table import EntryTable, stream_entries
from casa_assets.model.registry.category import PICTURE_PROMPTS

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
        id, category: of the asset. folder: of its entry.
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


def search_by_picture(query: str, library: disk.Library, eye: ClipModel, most: int) -> list[SearchHit]:
    """The assets whose pictures fit words best, best first.

    Raises:
        OutputError: an entry is damaged. CannotDraw, NoRenderer: pictures cannot be made.
    """
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


def entries_that(library: disk.Library, conditions: Sequence[Condition]) -> Iterator[Entry]:
    """The entries that meet all conditions, one after the other. Raises OutputError: an entry is damaged."""
    return (entry for entry in stream_entries(library) if meets(entry, conditions))


def search_by_words(query: str, library: disk.Library, most: int) -> list[SearchHit]:
    """The assets whose category, title, path or colours have most of the words, best first.

    Raises:
        OutputError: an entry is damaged.
    """
    return search_entries(entries_that(library, with_default(())), library.root, query, most).hits


def search_entries(found: Iterable[Entry], root: Path, query: str, most: int) -> Found:
    """The entries whose category, title, path or colours have most of the words, best first; without words all, by id.

    However many entries there are, no more than `most` are kept in memory.

    Args:
        found: entries of a library. root: its folder.
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
        folder = folder.parent if folder.name == ROWS else folder  # many rows that were refused share a file
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
