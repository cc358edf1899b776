"""Categories of kitchen objects (rows of registry/categories.yaml), and the search for their names in free text."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, NamedTuple, Self

from pydantic import Field, StringConstraints, model_validator
from pydantic_core import PydanticCustomError

from casa_assets.model.record import Id, Record, Vec3
from casa_assets.model.registry.contract import RobocasaRelease

# Id of the category of what has no other; not found by name, since many nodes are called so.
FALLBACK = "object"
# How far `size_m` and `longest_m` may differ, of the length: rounding to a millimetre and no more.
SAME_SIZE = 0.02
# A phrase about a thing becomes one about a picture of an asset of ours.
# Ref: Radford et al. 2021, prompts of CLIP; the wording for renders is ours.
PICTURE_PROMPTS = ("a photo of {}.", "a 3D render of {} on a plain background.", "{}, isolated.")
LONGEST_PHRASE = 5  # words
# How often what a text names in such a way is what the thing is; measured on names of files and titles, rounded down.
IS_THE_ID, IS_A_NAME, HAS_A_PHRASE = 0.97, 0.93, 0.9
ENDS_WITH_A_WORD, HAS_A_WORD, HAS_A_COMPOUND, IS_WEAK = 0.85, 0.8, 0.65, 0.45


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
        phrases: joined words of every name (`coffeemug`) -> entry. words: the single words that names are made of.
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


class Certainty(StrEnum):
    """Confidence of the registry in a Q-code."""

    CERTAIN = "certain"
    LIKELY = "likely"
    PARENT = "parent"


class MatterFill(StrEnum):
    """Distribution of matter within an object's outline; decides volume, mass and whether cavities stay open."""

    SOLID = "solid"  # an apple, a cutting board: matter all through
    FILLED = "filled"  # a sealed can or carton: outline full, mixed density
    VESSEL = "vessel"  # a mug, bowl, pot: open cavity that must stay open in collision
    HOLLOW = "hollow"  # an appliance or basket: mostly air inside, mass from the prior


class RestingPose(StrEnum):
    """Usual pose of an object on a worktop."""

    STANDS = "stands"  # tallest or designed axis up: a bottle, a mug
    LIES = "lies"  # shortest axis up: a knife, a plate, a cutting board
    ANY = "any"  # no preferred pose: an orange


class FrontRule(StrEnum):
    """Rule for the yaw of an object, so that instances of a category face the same way."""

    ANY = "any"  # the same from all sides, or without a front
    FACE = "face"  # its printed or working face looks to -y
    HANDLE = "handle"  # its handle points to +x
    LENGTH = "length"  # its length lies along x


class Affordance(StrEnum):
    """Action that an object allows a robot or an appliance; a closed set."""

    GRASPABLE = "graspable"  # a hand of 0.08 m can take it as it rests
    WASHABLE = "washable"
    MICROWAVABLE = "microwavable"
    COOKABLE = "cookable"
    FREEZABLE = "freezable"
    FRIDGABLE = "fridgable"
    DISHWASHABLE = "dishwashable"
    CONTAINER = "container"  # something loose can be laid into it as it rests
    STACKABLE = "stackable"  # stands on another of its kind


class ObjectType(StrEnum):
    """Group of categories that tasks ask for; the closed set of the reference runtime (RoboCasa)."""

    ALCOHOL = "alcohol"
    BREAD_FOOD = "bread_food"
    CLEANER = "cleaner"
    CONDIMENT = "condiment"
    COOKED_FOOD = "cooked_food"
    DAIRY = "dairy"
    DECORATION = "decoration"
    DRINK = "drink"
    FRUIT = "fruit"
    ICED_ITEM = "iced_item"
    LID = "lid"
    MEAT = "meat"
    PACKAGED_FOOD = "packaged_food"
    PASTRY = "pastry"
    RECEPTACLE = "receptacle"
    SPICE = "spice"
    STACKABLE = "stackable"
    SWEETS = "sweets"
    TOOL = "tool"
    UTENSIL = "utensil"
    VEGETABLE = "vegetable"


class Portion(StrEnum):
    """Remaining part of an object that was cut; a closed set."""

    HALF = "half"  # one of two about equal parts, cut along or across
    WEDGE = "wedge"  # what lies between two cuts through the middle
    SLICE = "slice"  # what lies between two cuts side by side, or several of these on one another
    PIECE = "piece"  # any other part, such as a loaf of which the end is cut off


class NumberBasis(StrEnum):
    """Source of the numbers of a row."""

    USUAL = "usual"  # our estimate of common real ones
    TRADE = "trade"  # sizes and net weights that it is sold in
    PORTION = "portion"  # typical value near the portion weights of food composition tables
    REFERENCE = "reference"  # as the reference runtime has it


class CategoryBases(Record):
    """Source of the sizes, of the mass, and of `types` and `affords` of a category."""

    size: NumberBasis = NumberBasis.USUAL
    mass: NumberBasis = NumberBasis.USUAL
    uses: NumberBasis = NumberBasis.USUAL


class QCode(Record):
    """A Wikidata item.

    Attributes:
        id: such as `Q89`. label: English label of the item.
        certainty: certain or likely for the category's own item, parent if the class above is used instead.
    """

    id: Annotated[str, StringConstraints(pattern=r"^Q[1-9][0-9]*$")]
    label: str
    certainty: Certainty


class SizeRange(Record):
    """A range with a typical value, `low <= typical <= high`, all > 0; it may be written `[low, typical, high]`."""

    low: Annotated[float, Field(gt=0)]
    typical: Annotated[float, Field(gt=0)]
    high: Annotated[float, Field(gt=0)]

    @model_validator(mode="before")
    @classmethod
    def _expand_shorthand(cls, value: Any) -> Any:
        if isinstance(value, list) and len(value) != 3:
            raise PydanticCustomError("span", "[low, typical, high]")
        return dict(zip(("low", "typical", "high"), value, strict=True)) if isinstance(value, list) else value

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.typical <= self.high:
            raise ValueError(f"{self.low} <= {self.typical} <= {self.high} does not hold")
        return self

    def beyond(self, value: float) -> float:
        """Ratio between a value > 0 and the nearer end of the range; below 1 inside the range."""
        return max(self.low / value, value / self.high)

    def scaled(self, factor: float) -> SizeRange:
        """Copy with all three values multiplied by a factor > 0."""
        return SizeRange(low=self.low * factor, typical=self.typical * factor, high=self.high * factor)


class PortionRange(Record):
    """Longest side of the bounding box and mass of a portion, if they differ from those of a whole one."""

    longest_m: SizeRange
    mass_kg: SizeRange


class Category(Record):
    """A kind of kitchen object.

    Attributes:
        parent: class above, such as `tableware`. qcode: used as a semantic label.
        longest_m: longest side of the bounding box of a real one. mass_kg: of a real one.
        shape: typical extents (x, y, z) as it rests, relative to the longest; z is up.
        size_m: extents along x, y and z as it rests, metres; None if they are `longest_m` times `shape`.
        substance: id of its main substance. aliases: other names that sources use.
        fixed: built in or too heavy to move (an oven): its base is welded to the world.
        types: groups by which tasks may ask for it instead of its name.
        runtime: releases of the reference runtime that have an object category of this name.
        lvis: its names in LVIS, and so in Objaverse's annotations.
        prompts: noun phrases for a vision-language model; if empty, see `phrases`.
        portions: for portions that are not listed, the size and mass of a whole one apply.
    """

    id: Id
    parent: Id
    qcode: QCode
    longest_m: SizeRange
    mass_kg: SizeRange
    shape: Vec3
    size_m: tuple[SizeRange, SizeRange, SizeRange] | None = None
    upright: RestingPose
    front: FrontRule = FrontRule.ANY
    build: MatterFill
    substance: Id
    aliases: tuple[str, ...] = ()
    fixed: bool = False
    types: tuple[ObjectType, ...] = ()
    affords: tuple[Affordance, ...] = ()
    runtime: tuple[RobocasaRelease, ...] = ()
    lvis: tuple[str, ...] = ()
    prompts: tuple[str, ...] = ()
    basis: CategoryBases = CategoryBases()
    portions: Mapping[Portion, PortionRange] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        for name in ("types", "affords", "runtime", "lvis", "prompts"):
            row = getattr(self, name)
            if len(set(row)) != len(row):
                raise ValueError(f"{name} says something twice")
        if self.size_m is not None:
            longest = max(side.typical for side in self.size_m)
            if abs(longest - self.longest_m.typical) > SAME_SIZE * longest:
                raise ValueError(f"size_m is {longest:g} m at most and longest_m {self.longest_m.typical:g} m")
        return self

    @property
    def extents(self) -> tuple[SizeRange, SizeRange, SizeRange]:
        """Size along x, y and z as it rests, metres."""
        if self.size_m is not None:
            return self.size_m
        x, y, z = (self.longest_m.scaled(share) for share in self.shape)
        return x, y, z

    @property
    def phrases(self) -> tuple[str, ...]:
        """Noun phrases for it, such as `a coffee mug`."""
        name = self.id.replace("_", " ")
        return self.prompts or (f"{'an' if name[0] in 'aeiou' else 'a'} {name}",)

    def called(self, portion: Portion | None) -> str:
        """Text for messages: `a bell_pepper`, or `a half of a bell_pepper` for a portion."""
        return f"a {self.id}" if portion is None else f"a {portion} of a {self.id}"

    def usual(self, portion: Portion | None) -> PortionRange:
        """Size and mass of a portion, or of a whole one if None."""
        whole = PortionRange(longest_m=self.longest_m, mass_kg=self.mass_kg)
        return whole if portion is None else self.portions.get(portion, whole)

    def can(self, use: Affordance) -> bool:
        """True if `use` is among the affordances."""
        return use in self.affords


def clip_prompts(category: Category) -> tuple[str, ...]:
    """Every phrase of a category in every prompt template, for a vision-language model (CLIP)."""
    return tuple(picture.format(phrase) for phrase in category.phrases for picture in PICTURE_PROMPTS)
