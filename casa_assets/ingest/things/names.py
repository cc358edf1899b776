"""Signs in names and titles that a mesh is no single household object: plurals, figures, places, parts of something."""

from __future__ import annotations

import posixpath
from collections.abc import Iterable, Sequence

from casa_assets.ingest.things.signs import Sign
from casa_assets.model.ingest.source import Source
from casa_assets.model.registry.rows import OtherThingsWords
from casa_assets.model.registry.vocabulary import Vocabulary, VocabularyMatch, singulars, split_words

# Probabilities are choices, fitted like those of signs.py. A category told less sure than this is told by a weak word.
ALWAYS, OTHER, PART, PLURAL, MANY_KINDS, OWN_KINDS = 0.65, 0.6, 0.65, 0.4, 0.7, 0.2
WEAKLY_TOLD = 0.62
# Nodes named after so many categories are several things.
MIN_KINDS = 3
_WHAT = {
    "figures": "a person or an animal",
    "places": "a place",
    "shapes": "a shape to test with",
    "outdoors": "something from outdoors",
    "arms": "a weapon",
}
# What exporters and authors put behind a name, besides single letters.
_ENDINGS = frozenset({"low", "high", "lod", "visual", "mesh", "model", "obj", "textured", "simple", "left", "right"})


def signs_of_words(source: Source, vocabulary: Vocabulary, words: OtherThingsWords) -> list[Sign]:
    """Signs in the name of the file, or of the node, and in the title; each kind of sign once."""
    found: dict[str, Sign] = {}
    for text in _texts(source):
        match = vocabulary.find([text])
        for key, sign in _signs_of(text, match, vocabulary, words):
            found.setdefault(key, sign)
    return list(found.values())


def sign_of_nodes(nodes: Iterable[Sequence[str]], source: Source, vocabulary: Vocabulary) -> Sign | None:
    """A sign if nodes are named after several categories: a table, a lamp and a vase are no parts of one thing.

    It says little where the file itself is named after a category: a hamburger is made of a bun, cheese and tomatoes.
    """
    kinds: dict[str, str] = {}
    for name in sorted({name for path in nodes for name in path}):
        match = vocabulary.find([name])
        if match is not None and not match.weak and match.confidence >= WEAKLY_TOLD:
            kinds.setdefault(match.id, name)
    if len(kinds) < MIN_KINDS:
        return None
    named = ", ".join(repr(name[:40]) for name in list(kinds.values())[:4])
    own = [vocabulary.find([text]) for text in _texts(source)]
    is_named = any(match is not None and not match.weak and match.confidence >= WEAKLY_TOLD for match in own)
    return Sign(
        OWN_KINDS if is_named else MANY_KINDS, f"its nodes are named after {len(kinds)} kinds of things ({named})"
    )


def _texts(source: Source) -> list[str]:
    """Texts that name the object: the node of a file taken apart, else the name of the file and the title."""
    if source.node:
        return [source.node]
    stem = posixpath.splitext(posixpath.basename(source.path))[0]
    return [text for text in (stem, source.title) if text]


def _signs_of(
    text: str, match: VocabularyMatch | None, vocabulary: Vocabulary, words: OtherThingsWords
) -> list[tuple[str, Sign]]:
    every = split_words(text)
    while len(every) > 1 and (len(every[-1]) == 1 or every[-1] in _ENDINGS):
        every.pop()
    if not every:
        return []
    found: list[tuple[str, Sign]] = []
    stems = {singular for word in every for singular in singulars(word)}
    if hit := sorted(stems & set(words.always)):
        found.append(("always", Sign(ALWAYS, f"{hit[0]!r} in {text[:60]!r} is no household object")))
    last = every[-1]
    covers_last = vocabulary.find([last]) is not None
    if not covers_last and last in words.parts and len(every) > 1:
        found.append(("part", Sign(PART, f"{last!r} in {text[:60]!r} is a part of something")))
    if _is_plural(last, vocabulary):
        found.append(("plural", Sign(PLURAL, f"{text[:60]!r} speaks of several things")))
    if match is None or match.weak or match.confidence < WEAKLY_TOLD:
        for group, what in _WHAT.items():
            if hit := sorted(stems & set(getattr(words, group))):
                found.append(("other", Sign(OTHER, f"{hit[0]!r} in {text[:60]!r} speaks of {what}")))
                break
    return found


def _is_plural(word: str, vocabulary: Vocabulary) -> bool:
    """True for the plural of a word that names a category or a portion; False for names that are plurals themselves."""
    if word in vocabulary.words:
        return False
    return any(one != word and one in vocabulary.words for one in singulars(word))
