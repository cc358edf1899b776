"""Guess the category of a mesh: by the user's word, by CLIP, by its name, else by its shape and parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from casa_assets import registry
from casa_assets.articulate.decisions import GIVEN_REASON
from casa_assets.articulate.frame.kind import kind_by_parts, kind_named
from casa_assets.articulate.plan import Articulation
from casa_assets.ingest.sources.found import Found
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category
from casa_assets.pipeline.clip import NO_WEIGHTS

# A guess that is no surer than this names nothing: sizes and names stay those of any thing.
MIN_CONFIDENCE = 0.2
# Parts of a thing whose kind is no surer than this keep their own names.
NAMING_CONFIDENCE = 0.5
# Id of a kind or nothing, how sure, and why.
ImageClassifier = Callable[[], tuple[str, float, str]]


@dataclass(frozen=True)
class CategoryGuess:
    """A category with confidence and reason."""

    category: Category
    confidence: float
    reason: str

    @property
    def id(self) -> str:
        """Return the id of the category; empty where the guess is too uncertain."""
        return self.category.id if self.confidence > MIN_CONFIDENCE else ""


def guess_category(
    one: Found,
    extent: Vec3,
    articulation: Articulation,
    stated: str = "",
    classify_by_image: ImageClassifier | None = None,
) -> CategoryGuess:
    """Return the category of an input.

    A category given by the user that repeats a confident guess leaves it a guess: the same decisions make the same
    asset.

    Args:
        extent: width, depth, height, any unit. articulation: its moving parts.
        stated: category given by the user, or empty. classify_by_image: classifier by appearance, where there is one.
    Raises:
        UnknownId: there is no such category.
    """
    guessed = _guess_without_user(one, extent, articulation, classify_by_image)
    if not stated or (stated == guessed.category.id and guessed.confidence >= NAMING_CONFIDENCE):
        return guessed
    known = registry.load()
    return CategoryGuess(known.fixtures.get(stated) or known.category(stated), 1.0, GIVEN_REASON)


def stated_category(one: Found, stated: str = "") -> str:
    """Return the category that the user or the file name states; empty where neither does."""
    if stated:
        return stated
    named = kind_named([h for h in (one.source.category, *one.source.hints) if h])
    return named.id if named is not None and named.confidence >= NAMING_CONFIDENCE else ""


def _guess_without_user(
    one: Found, extent: Vec3, articulation: Articulation, classify_by_image: ImageClassifier | None
) -> CategoryGuess:
    """Guess the category without the user's word."""
    known = registry.load()
    look = NO_WEIGHTS
    if classify_by_image is not None:
        kind, confidence, look = classify_by_image()
        if kind:
            return CategoryGuess(known.fixtures[kind], confidence, look)
    hints = [h for h in (one.source.category, *one.source.hints) if h]
    named = kind_named(hints)
    if named is not None:
        return CategoryGuess(known.fixtures[named.id], named.confidence, f"by its name: {named.evidence}")
    kind, confidence = kind_by_parts(extent, articulation)
    if confidence > MIN_CONFIDENCE:
        return CategoryGuess(known.fixtures[kind], confidence, f"by its shape and parts; nothing names it, and {look}")
    message = f"nothing names it, {look}, and its shape and parts are like no one kind's"
    return CategoryGuess(known.category(registry.FALLBACK), 0.1, message)
