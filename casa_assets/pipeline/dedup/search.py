"""Search a library for assets that words describe: by their pictures with CLIP, or by their metadata alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.model.registry.category import PICTURE_PROMPTS
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.clip import ClipModel
from casa_assets.pipeline.dedup.clip_embeddings import image_embeddings, text_embedding
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.reports.entry import Entry

# Other words for the colours that tints are named by.
COLOR_SYNONYMS = {"gray": "grey", "silver": "grey", "cyan": "turquoise", "teal": "turquoise", "violet": "purple"}
# Words that are left out of a query.
STOP_WORDS = frozenset({"a", "an", "the", "of", "with", "and", "in", "for", "some"})
# Score of a word that is found in the category, in a class above it, and in what the source says.
BY_CATEGORY, BY_CLASS, BY_SOURCE = 1.0, 0.6, 0.5


@dataclass(frozen=True)
class SearchHit:
    """An asset that fits.

    Attributes:
        id, category: of the asset. folder: where it stands.
        score: how well it fits; a cosine by pictures, a sum over the words else. reason: why, in words.
    """

    id: str
    category: str
    folder: Path
    score: float
    reason: str


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


def search_by_words(query: str, library: disk.Library, most: int) -> list[SearchHit]:
    """The assets whose category, title, path or colours have most of the words, best first.

    Raises:
        OutputError: an entry is damaged.
    """
    words = [COLOR_SYNONYMS.get(word, word) for word in tokens(query) if word not in STOP_WORDS]
    known, table = registry.load(), EntryTable(library)
    signatures = {row.id: row.signature for row in table.rows}
    hits = []
    for entry in table.entries:
        if not entry.accepted:
            continue
        signature = signatures[entry.id]
        colors = dict(signature.color.names) if signature is not None and signature.color.stated else {}
        found = [_word(word, entry, colors, known) for word in words]
        score = sum(value for value, _ in found)
        if score > 0:
            reason = ", ".join(why for value, why in found if value > 0)
            matched_count = sum(value > 0 for value, _ in found)
            hits.append(
                (matched_count, SearchHit(entry.id, entry.category, library.root / entry.path, round(score, 3), reason))
            )
    hits.sort(key=lambda pair: (-pair[0], -pair[1].score, pair[1].id))
    return [hit for _, hit in hits[:most]]


def tokens(text: str) -> list[str]:
    """The words of a text in small letters, without the s of plurals."""
    found = re.findall(r"[a-z0-9]+", text.lower())
    return [word[:-1] if len(word) > 3 and word.endswith("s") and not word.endswith("ss") else word for word in found]


def _word(word: str, entry: Entry, colors: dict[str, float], known: registry.Registry) -> tuple[float, str]:
    """Score of a word for an asset, and the reason."""
    if word in colors:
        return colors[word], f"{colors[word]:.0%} {word}"
    kind = known.categories.get(entry.category)
    if kind is not None and word in _all((kind.id, *kind.aliases, *kind.lvis)):
        return BY_CATEGORY, f"{word!r} is its category"
    if kind is not None and word in _all(known.classes_of(kind)):
        return BY_CLASS, f"{word!r} is a class of it"
    if word in _all((entry.title, entry.prompt, entry.source_path)):
        return BY_SOURCE, f"its source says {word!r}"
    return 0.0, ""


def _all(texts: Sequence[str]) -> frozenset[str]:
    return frozenset(word for text in texts for word in tokens(text))
