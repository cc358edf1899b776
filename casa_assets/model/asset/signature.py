"""Signatures for finding duplicates: a shape descriptor and a colour histogram per asset."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from casa_assets.model.record import Record, Vec3

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
