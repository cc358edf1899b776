"""Labels and origin of an asset, and the signature by which duplicates are found."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.model.record import BriefRecord, Id, Record, Sha256, Vec3
from casa_assets.model.registry.category import Portion, QCode

Confidence = Annotated[float, Field(ge=0.0, le=1.0)]
TEST_SHARE = 5  # one in so many inputs is kept for testing


class Split(StrEnum):
    """Dataset split of an instance: training or test."""

    TRAIN = "train"
    TEST = "test"


def split_of(sha256: str) -> Split:
    """Split of the asset made from an input with this digest, or of an object whose shape has this digest.

    It depends on nothing else, so that no instance changes its split when others are added or removed, or when it is
    made again.
    """
    return Split.TEST if int(sha256[:8], 16) % TEST_SHARE == 0 else Split.TRAIN


class Labels(BriefRecord):
    """Class labels of an asset, for segmentation and language.

    Attributes:
        category: id in registry/categories.yaml. classes: from the category upwards, such as (`mug`, `tableware`).
        qcode: Wikidata item and its certainty.
        split: `split_of` its input. For a procedural object, of its shape, so that two objects that differ only in
            colour are in the same split; None for fixtures and articulation.
        portion: portion of a cut object, or None for a whole one.
    """

    BLANKS = ("portion",)

    category: Id
    classes: tuple[Id, ...]
    qcode: QCode
    split: Split | None = None
    portion: Portion | None = None


# Subject of the guess on an asset that probably has moving parts, none of which was found.
UNFOUND_PARTS = "moving_parts"


class Guess(Record):
    """A decision that the source did not state.

    Attributes:
        subject: such as `scale` or `up_axis`. value: the decision, as text. confidence: 0..1. reason: the evidence.
    """

    subject: Id
    value: str
    confidence: Confidence
    reason: str


class Provenance(BriefRecord):
    """Origin of an asset: source, author, licence, digest, and the guesses that were made.

    Attributes:
        source: kind of source: folder, objaverse, objaverse_xl, text_to_3d, manifest, family.
        path: file, relative to the source's root.
        sha256: digest of the main source file and of all files that it refers to.
        title, author, licence, uri: as the source states them; licence is an SPDX id or `unknown`.
        uid: id within the source. prompt, generator: for generated meshes.
        node: name of the object within the file, for a file that was split; empty for a whole file.
        guesses: everything that was decided without being stated.
    """

    BLANKS = ("node",)

    source: Id
    path: str
    sha256: Sha256
    uid: str = ""
    title: str = ""
    author: str = ""
    licence: str = "unknown"
    uri: str = ""
    prompt: str = ""
    generator: str = ""
    node: str = ""
    guesses: tuple[Guess, ...] = ()

    @property
    def place(self) -> str:
        """The path, followed by `#` and the name of the object if the file was split."""
        return place_of(self.path, self.node)


def place_of(path: str, node: str) -> str:
    """A file, followed by `#` and the name of an object in it, unless the whole file is meant."""
    return f"{path}#{node}" if node else path


# Numbers per distribution: each is the mean of an equal share of the sorted values (a quantile function).
PAIR_SHARES, CENTER_SHARES, TONE_SHARES = 32, 16, 9
# Axes of colour: lightness, red-green, yellow-blue, and the two diagonals of the last two.
TONES = 5


class ShapeDescriptor(Record):
    """Shape of a surface as numbers that do not change with rotation, translation or triangulation.

    Attributes:
        radius: root mean square distance of the surface from its centre, metres.
        pair_distances: distances between two points of the surface over `radius`, as means of equal shares, ascending.
        center_distances: distances of points from the centre, likewise.
        axis_spread: root mean square spread along the principal axes over `radius`, the widest first.
    """

    radius: Annotated[float, Field(gt=0.0)]
    pair_distances: Annotated[tuple[float, ...], Field(min_length=PAIR_SHARES, max_length=PAIR_SHARES)]
    center_distances: Annotated[tuple[float, ...], Field(min_length=CENTER_SHARES, max_length=CENTER_SHARES)]
    axis_spread: Vec3


class ColorHistogram(Record):
    """Distribution of the colours of a surface, by area.

    Attributes:
        tones: means of equal shares along each axis of colour in turn, CIELAB units.
        names: plain colour names, each with its share of the surface, the largest first.
        stated: whether the source has colours; readers fill in uniform light grey and white if it has none.
    """

    tones: Annotated[tuple[float, ...], Field(min_length=TONES * TONE_SHARES, max_length=TONES * TONE_SHARES)]
    names: tuple[tuple[str, float], ...]
    stated: bool


class Signature(Record):
    """Shape descriptor and colours of one object."""

    shape: ShapeDescriptor
    color: ColorHistogram
