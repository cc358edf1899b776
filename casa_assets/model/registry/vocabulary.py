"""Find names from the registry in free text (file names, titles, tags), by whole words only."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

LONGEST_PHRASE = 5  # words
# How often what a text names in such a way is what the thing is; measured on names of files and titles, rounded down.
IS_THE_ID, IS_A_NAME, HAS_A_PHRASE, ENDS_WITH_A_WORD, HAS_A_WORD, HAS_A_COMPOUND, IS_WEAK = (
    0.97,
    0.93,
    0.9,
    0.85,
    0.8,
    0.65,
    0.45,
)


class VocabularyEntry(NamedTuple):
    """Meaning of a phrase: the id that it names, and whether it yields to any other phrase of a text."""

    id: str
    weak: bool


class VocabularyMatch(NamedTuple):
    """Id found in a text, with confidence 0..1, the words that are evidence, and whether they are weak."""

    id: str
    confidence: float
    evidence: str
    weak: bool


@dataclass(frozen=True)
class Vocabulary:
    """Names and the ids that they refer to.

    Attributes:
        phrases: joined words of every name (`coffeemug`) -> entry.
        words: the single words that names are made of.
        separators: words such as `with`, which end the part of a text that names the object.
    """

    phrases: Mapping[str, VocabularyEntry]
    words: frozenset[str]
    separators: frozenset[str]

    @classmethod
    def of(cls, names: Iterable[tuple[str, str]], weak: Iterable[str], separators: Iterable[str]) -> Self:
        """Build from (name, id) pairs. Raises ValueError(name) if two ids claim a name or it has no letter."""
        yields = {"".join(split_words(word)) for word in weak}
        phrases: dict[str, VocabularyEntry] = {}
        words: set[str] = set()
        for name, target in names:
            parts = split_words(name)
            joined = "".join(parts)
            known = phrases.get(joined, VocabularyEntry(target, False))
            if not joined or known.id != target:
                raise ValueError(name)
            phrases[joined] = VocabularyEntry(target, joined in yields)
            words.update(parts)
        return cls(phrases, frozenset(words), frozenset(separators))

    def find(self, hints: Sequence[str]) -> VocabularyMatch | None:
        """The match of the first hint that has one; a weak match only if no hint has a better one."""
        found = [match for rank, hint in enumerate(hints) if (match := self._match(hint, 0.95**rank))]
        return next((match for match in found if not match.weak), found[0] if found else None)

    def _match(self, hint: str, trust: float) -> VocabularyMatch | None:
        """The best match in one hint: the whole hint, else its longest phrase (the last one of equal length)."""
        whole = self._phrase(split_words(hint))
        if whole:
            confidence = IS_THE_ID if hint == whole.id else IS_A_NAME
            return VocabularyMatch(whole.id, round(confidence * trust, 3), f"it is called {hint!r}", whole.weak)
        for tokens in self._parts(hint):
            spans = [(i, j) for j in range(1, len(tokens) + 1) for i in range(max(0, j - LONGEST_PHRASE), j)]
            hits = [(not e.weak, j - i, j, e) for i, j in spans if (e := self._phrase(tokens[i:j]))]
            if hits:
                _, size, end, entry = max(hits)
                of_one = ENDS_WITH_A_WORD if end == len(tokens) else HAS_A_WORD
                confidence = IS_WEAK if entry.weak else HAS_A_PHRASE if size > 1 else of_one
                evidence = f"{' '.join(tokens[end - size : end])!r} in {hint!r}"
                return VocabularyMatch(entry.id, round(confidence * trust, 3), evidence, entry.weak)
            for word in reversed(tokens):
                if head := self._compound(word):
                    return VocabularyMatch(head, round(HAS_A_COMPOUND * trust, 3), f"{word!r} in {hint!r}", False)
        return None

    def _parts(self, hint: str) -> list[list[str]]:
        """The words of the hint, split at punctuation and separators: the part that names the object comes first."""
        parts: list[list[str]] = []
        for clause in re.split(r"[,;:|()\[\]{}]|\s[-–—]\s", hint):
            parts.append([])
            for word in split_words(clause):
                if word in self.separators:
                    parts.append([])
                else:
                    parts[-1].append(word)
        return [part for part in parts if part]

    def _phrase(self, tokens: Sequence[str]) -> VocabularyEntry | None:
        """Return the entry for these words, with the last one in singular or plural, or None if unknown."""
        if not tokens:
            return None
        stem = "".join(tokens[:-1])
        return next((self.phrases[stem + last] for last in singulars(tokens[-1]) if stem + last in self.phrases), None)

    def _compound(self, word: str) -> str | None:
        """Return the id named by the second part of a compound of two known words (`teajar`), or None."""
        for cut in range(3, len(word) - 2):
            head = self._phrase([word[cut:]])
            if head and not head.weak and word[:cut] in self.words:
                return head.id
        return None


def split_words(text: str) -> list[str]:
    """Lower-case words of a text: cut at capitals, digits and signs, accents removed."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    plain = re.sub(r"['’]", "", plain)
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", plain)
    return [word.casefold() for word in re.findall(r"[^\W\d_]+", plain)]


def singulars(word: str) -> list[str]:
    """The word itself, then the words that it may be the plural of."""
    forms = [word]
    if len(word) > 3 and word.endswith("s") and not word.endswith(("ss", "us")):
        forms.append(word[:-1])
        if word.endswith("ves"):
            forms += [word[:-3] + "f", word[:-3] + "fe"]
        if word.endswith("ies"):
            forms.append(word[:-3] + "y")
        if word.endswith("es"):
            forms.append(word[:-2])
    return forms
