"""Signatures for finding duplicates: a shape descriptor and a colour histogram per asset."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from casa_assets.model.record import Record, Vec3

# Equal shares whose means are kept: of distances between two places, of distances from the middle, of each tone.
PAIR_SHARES, REACH_SHARES, TONE_SHARES = 32, 16, 9
# Tones of colour: lightness, red against green, yellow against blue, and the two diagonals between the last two.
TONES = 5


class ShapeDescriptor(Record):
    """Shape of a surface as numbers that do not change with rotation, translation or triangulation.

    Attributes:
        radius: root mean square distance of the surface from its centre, metres.
        pairs: means of equal shares of the distance between two places of the surface, ascending.
        reach: means of equal shares of the distance of a place from the centre, ascending.
        axes: root mean square spread along the three principal axes, the widest first.
    """

    radius: Annotated[float, Field(gt=0.0)]
    pairs: Annotated[tuple[float, ...], Field(min_length=PAIR_SHARES, max_length=PAIR_SHARES)]
    reach: Annotated[tuple[float, ...], Field(min_length=REACH_SHARES, max_length=REACH_SHARES)]
    axes: Vec3


class ColorHistogram(Record):
    """Distribution of the colours of a surface, by area.

    Attributes:
        tones: means of equal shares of each tone in turn, CIELAB units.
        names: plain words for the colours with the share of the surface that each has, the largest first.
        stated: whether somebody gave it a look; plain light grey and white all over is what readers fill in.
    """

    tones: Annotated[tuple[float, ...], Field(min_length=TONES * TONE_SHARES, max_length=TONES * TONE_SHARES)]
    names: tuple[tuple[str, float], ...]
    stated: bool


class Signature(Record):
    """Shape descriptor and colours of one thing."""

    form: ShapeDescriptor
    tint: ColorHistogram
