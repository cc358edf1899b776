"""Guess whether a file holds one household object, from all signs that it does not."""

from __future__ import annotations

import math

from casa_assets.ingest.things.names import sign_of_nodes, signs_of_words
from casa_assets.ingest.things.signs import Sign, signs_of_form
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.ingest.source import RawModel, Source
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.rows import OtherThingsWords
from casa_assets.model.registry.vocabulary import Vocabulary, split_words

SUBJECT = "things"
ONE = "one object"
# Below this probability nothing is said.
MIN_PROBABILITY = 0.25
# Bones from which on a rig is that of a figure, and how probable that is; a choice.
MIN_JOINTS, FIGURE = 5, 0.8
MANY_COPIES = 0.95
# A category whose name has one of these words is several things, and rightly so.
COLLECTIVE = frozenset({"stack", "set", "bunch", "pack", "pile", "pair"})


def guess_of_things(
    model: RawModel, source: Source, category: Category, vocabulary: Vocabulary, words: OtherThingsWords
) -> Guess | None:
    """The guess that a file holds one object, with the signs against it; None if they hardly speak against it.

    Args:
        model: as read. source: its name and title. category: what it is taken for.
        vocabulary: names of categories. words: names of things that are not household objects.
    """
    signs = signs_of_words(source, vocabulary, words)
    if model.instances > 1:
        signs.append(Sign(MANY_COPIES, f"a list of places puts {model.instances} copies of meshes"))
    elif not COLLECTIVE & set(split_words(category.id)):
        signs += signs_of_form(model)
    if model.joints >= MIN_JOINTS:
        signs.append(Sign(FIGURE, f"a rig of {model.joints} bones moves it, as it does a figure"))
    named = sign_of_nodes([part.nodes or (part.name,) for part in model.parts], source, vocabulary)
    if named is not None:
        signs.append(named)
    alone = math.prod(1 - sign.probability for sign in signs)
    if 1 - alone < MIN_PROBABILITY:
        return None
    ordered = sorted(signs, key=lambda sign: -sign.probability)
    return Guess(
        subject=SUBJECT, value=ONE, confidence=round(alone, 2), reason="; ".join(sign.reason for sign in ordered)
    )
