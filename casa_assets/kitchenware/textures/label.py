"""Labels of packages: an invented brand, words, a small drawing, bands and colours, small print at the back.

The picture is wound once round the package. Its middle is the front; its two ends meet behind.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageChops, ImageDraw
from pydantic import Field, model_validator
from scipy import ndimage

from casa_assets.ext.records import HexColor, Id, Record
from casa_assets.ext.textures import Canvas, Layers, PrintedLine, Share, TextureKind, rgb
from casa_assets.kitchenware.textures.label_drawing import (
    BLACK,
    MOTIFS,
    WHITE,
    Area,
    Lettering,
    Pen,
    seen_on,
    star,
    write,
)

FINER = 3  # a picture is drawn this many times larger than it is kept
WORDS_OF_SMALL_PRINT = (
    "Ingredients Keep cool and dry Best before see base Shake well Store upright Once open use within days"
)


# How the front is composed: BAND the brand on a band that runs round; BADGE an oval shield; PLATE a plate with rounded
# corners; SPLIT two fields that meet in a wave; DIAGONAL a slanted field and stripe; CLASSIC a frame of two lines;
# STRIPES upright stripes beside a quiet field; MINIMAL much ground, little print; UPRIGHT the brand runs upwards; BURST
# rays out of the middle; BLOCK a field of colour above, a drawing below; RIBBON the brand on a ribbon.
Layout = StrEnum("Layout", "BAND BADGE PLATE SPLIT DIAGONAL CLASSIC STRIPES MINIMAL UPRIGHT BURST BLOCK RIBBON")


# Pattern of the ground: CHECKS of a tablecloth; RINGS level lines; FADE from the first colour above to the second.
Pattern = StrEnum("Pattern", "NONE DOTS CHECKS STRIPES RINGS FADE")


class Label(Record):
    """A printed label; the picture's width runs once around the package, its height from its lower to its upper end."""

    brand: str = Field(min_length=1, max_length=20, description="name in large letters, invented")
    words: tuple[str, ...] = Field((), max_length=4, description="what the product is, a line each")
    small: str = Field("", description="a line at the foot, such as `330 ml`")
    layout: Layout = Field(Layout.BAND, description="of the front")
    lettering: Lettering = Field("bold", description="of the brand")
    pattern: Pattern = Field(Pattern.NONE, description="of the ground")
    ground: tuple[HexColor, ...] = Field(
        ("#f3efe4",), min_length=1, max_length=3, description="of most of it; of fields, plates and patterns"
    )
    ink: HexColor = Field("#2a2522", description="of words; illegible letters turn light or dark")
    accent: HexColor = Field("#a5281f", description="of bands, frames and the brand")
    brand_ink: HexColor | None = Field(None, description="None: the choice of the layout")
    motif: Id | None = Field(None, description="name of a drawing in label_drawing.py")
    motif_colors: tuple[HexColor, ...] = Field((), description="replace those of the drawing")
    front: float = Field(0.36, ge=0.15, le=1, description="share of the width that the front takes")
    side: float = Field(0.0, ge=0, le=0.4, description="share of each of the two sides next to the front; 0: round")
    twice: bool = Field(False, description="the front is printed at the back too")
    back: bool = Field(True, description="barcode, facts and small print at the back, or on the sides")
    lower: float = Field(0.0, ge=0, le=0.45, description="share of the height that stays ground, as a flap")
    upper: float = Field(0.0, ge=0, le=0.45, description="the same at the upper end")
    metallic: Share = 0.0
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.5

    @model_validator(mode="after")
    def _known_and_fitting(self) -> Label:
        if self.motif is not None and self.motif not in MOTIFS:
            raise ValueError(f"a motif of {', '.join(MOTIFS)} is expected, got {self.motif}")
        if self.front + 2 * self.side > 1.0 + 1e-9:
            raise ValueError(f"front and sides take {self.front + 2 * self.side:.2f} of the width, more than all of it")
        return self

    @property
    def second(self) -> str:
        """The colour of fields and plates."""
        return self.ground[1] if len(self.ground) > 1 else self.accent


def paint(p: Label, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one label."""
    rows, columns = canvas.size_px
    image, inside, face = front(p, canvas.size_px)
    wide = image.width
    others = (1.0 - p.front - 2 * p.side) * wide
    if p.twice:
        image = ImageChops.offset(image, wide // 2, 0)
        wiped = replace(face, width=min(face.width, others), x=(wide - min(face.width, others)) / 2)
        FACES[p.layout](image, p, wiped)
        image = ImageChops.offset(image, wide - wide // 2, 0)
    if p.back:
        image = _backs(image, p, inside, rng, others)
    albedo = np.asarray(image.resize((columns, rows), Image.Resampling.BOX), dtype=np.float32) / 255.0
    cloud = canvas.noise(0.03, 0.03, rng, 2)
    return Layers.of(albedo, np.zeros(canvas.size_px, dtype=np.float32), p.roughness + 0.015 * cloud, p.metallic)


def front(p: Label, size_px: tuple[int, int]) -> tuple[Image.Image, Area, Area]:
    """Draw the print around a package and on its front, before the picture is reduced.

    `size_px`: (H, W) after it. Returns the picture, `FINER` times as large, its printed area, the area of its front.
    """
    rows, columns = size_px
    image = Image.new("RGB", (FINER * columns, FINER * rows), p.ground[0])
    wide, high = image.size
    inside = Area(0.0, p.upper * high, wide, (1.0 - p.upper - p.lower) * high)
    _strew(image, p, inside)
    face = Area((0.5 - p.front / 2) * wide, inside.y, p.front * wide, inside.height)
    if p.layout in ROUND:
        ROUND[p.layout](image, p, inside, face)
    FACES[p.layout](image, p, face)
    return image, inside, face


def _motif(image: Image.Image, p: Label, area: Area, ground: str, size: float = 1.0) -> None:
    """The drawing of the label in the middle of an area."""
    if p.motif is not None:
        half = 0.5 * min(area.width, area.height) * size
        # A drawing of one colour would be lost on a ground like it; one of several keeps them.
        colors = tuple(seen_on(ground, c) for c in p.motif_colors) if len(p.motif_colors) == 1 else p.motif_colors
        MOTIFS[p.motif](Pen(image, *area.middle, half, colors))


def _brand(image: Image.Image, p: Label, area: Area, ground: str, *wanted: str) -> None:
    """The brand within an area."""
    color = seen_on(ground, *([p.brand_ink] if p.brand_ink else []), *wanted, p.accent, p.ink)
    edge = seen_on(color, p.accent, p.ink, p.second) if p.lettering == "outlined" else None
    write(image, area, p.brand, color, p.lettering, edge)


def _words(image: Image.Image, p: Label, area: Area, ground: str, lines: Sequence[str] | None = None) -> None:
    """The words within an area, the first line the largest."""
    lines = p.words if lines is None else lines
    if not lines:
        return
    color = seen_on(ground, p.ink, p.accent)
    shares = [1.0 if k == 0 else 0.62 for k in range(len(lines))]
    top, total = 0.0, sum(shares)
    for k, (line, share) in enumerate(zip(lines, shares, strict=True)):
        row = area.part(0.0, top / total, 1.0, (top + 0.78 * share) / total)
        write(image, row, line, color, "bold" if k == 0 else "plain")
        top += share


def _small(image: Image.Image, p: Label, area: Area, ground: str) -> None:
    write(image, area, p.small, seen_on(ground, p.ink))


def _strew(image: Image.Image, p: Label, inside: Area) -> None:
    """The pattern of the ground."""
    draw, color = ImageDraw.Draw(image), p.second
    wide, high = image.size
    count = max(4, 2 * round(wide / max(6.0, 0.055 * min(inside.height, 0.5 * wide)) / 2))
    step = wide / count
    rows = range(math.ceil(high / step) + 1)
    match p.pattern:
        case Pattern.DOTS:
            for row in rows:
                for k in range(count // 2 + 1):
                    x, y, r = (2 * k + row % 2) * step, row * step, 0.3 * step
                    draw.ellipse((x - r, y - r, x + r, y + r), fill=color)
        case Pattern.CHECKS:  # squares of a tablecloth
            blended = np.rint(255 * (rgb(p.ground[0]) + rgb(color)) / 2).astype(int)
            mixed = (int(blended[0]), int(blended[1]), int(blended[2]))
            columns = range(0, round(wide / step), 2)
            for k in columns:
                draw.rectangle((k * step, 0, (k + 1) * step, high), fill=mixed)
            for row in rows[::2]:
                draw.rectangle((0, row * step, wide, (row + 1) * step), fill=mixed)
                for k in columns:
                    draw.rectangle((k * step, row * step, (k + 1) * step, (row + 1) * step), fill=color)
        case Pattern.STRIPES:
            for k in range(0, count, 2):
                draw.rectangle((k * step, 0, (k + 1) * step, high), fill=color)
        case Pattern.RINGS:
            for row in rows:
                draw.rectangle((0, row * step, wide, row * step + 0.28 * step), fill=color)
        case Pattern.FADE:
            ramp = Image.linear_gradient("L").resize((wide, high))
            image.paste(Image.composite(Image.new("RGB", image.size, color), image, ramp))


def _backs(image: Image.Image, p: Label, inside: Area, rng: np.random.Generator, others: float) -> Image.Image:
    """The picture with what is printed away from the front: on both sides, else behind."""
    wide = image.width
    if p.side > 0:
        for way, painted in ((1, _facts_side), (-1, _words_side)):
            shift = round(way * (p.front + p.side) / 2 * wide)
            image, width = ImageChops.offset(image, -shift, 0), 0.86 * p.side * wide
            painted(image, p, Area((wide - width) / 2, inside.y, width, inside.height).part(0, 0.06, 1, 0.94), rng)
            image = ImageChops.offset(image, shift, 0)
    if not p.twice and others > 0.12 * wide:
        image = ImageChops.offset(image, wide // 2, 0)
        width = min(0.8 * others, 2.2 * inside.height)
        area = Area((wide - width) / 2, inside.y, width, inside.height).part(0, 0.1, 1, 0.9)
        if area.width > area.height:
            _facts_side(image, p, area.part(0.52, 0, 1, 1), rng)
            _words_side(image, p, area.part(0, 0, 0.46, 1), rng)
        else:
            _words_side(image, p, area.part(0, 0, 1, 0.42), rng)
            _facts_side(image, p, area.part(0.1, 0.46, 0.9, 1), rng)
        image = ImageChops.offset(image, wide - wide // 2, 0)
    return image


def _facts_side(image: Image.Image, p: Label, area: Area, rng: np.random.Generator) -> None:
    """A table of facts above and a barcode below, on white plates."""
    draw, width = ImageDraw.Draw(image), min(area.width, 0.75 * area.height)
    area = replace(area, x=area.middle[0] - width / 2, width=width)
    table, code = area.part(0.05, 0.0, 0.95, 0.62), area.part(0.05, 0.68, 0.95, 0.98)
    draw.rectangle(table.corners, fill=WHITE)
    write(image, table.part(0.06, 0.03, 0.94, 0.14), "Facts per 100 g", BLACK, "bold")
    names = ("Energy", "Fat", "of which x", "Carbs", "Sugars", "Protein", "Salt")
    for k, name in enumerate(names):
        row = table.part(0.06, 0.19 + 0.113 * k, 0.94, 0.27 + 0.113 * k)
        draw.line((row.x, row.y - 0.02 * table.height, row.x + row.width, row.y - 0.02 * table.height), BLACK, 1)
        write(image, row.part(0, 0, min(0.6, 0.085 * len(name)), 1), name, BLACK)
        write(image, row.part(0.76, 0, 1, 1), f"{rng.uniform(0.1, 90):.1f} g", BLACK)
    draw.rectangle(code.corners, fill=WHITE)
    bars = code.part(0.08, 0.1, 0.92, 0.78)
    edges = np.cumsum(rng.integers(1, 4, 58)).astype(float)
    edges = bars.x + edges / edges[-1] * bars.width
    for left, right in zip(edges[0::2], edges[1::2], strict=True):
        draw.rectangle((left, bars.y, max(left, right - 1), bars.y + bars.height), fill=BLACK)
    write(image, code.part(0.15, 0.82, 0.85, 0.97), "".join(str(d) for d in rng.integers(0, 10, 12)), BLACK)


def _words_side(image: Image.Image, p: Label, area: Area, rng: np.random.Generator) -> None:
    """The brand once more, the first word, and lines of small print."""
    ground = p.ground[0]
    if p.pattern is not Pattern.NONE or p.layout in ROUND:
        ImageDraw.Draw(image).rectangle(area.part(0.0, -0.03, 1.0, 1.03).corners, fill=ground)
    _brand(image, p, area.part(0.05, 0.0, 0.95, 0.22), ground)
    if p.words:
        write(image, area.part(0.1, 0.26, 0.9, 0.36), p.words[0], seen_on(ground, p.ink), "bold")
    words = WORDS_OF_SMALL_PRINT.split()
    for k in range(6):
        chosen = " ".join(words[i] for i in rng.integers(0, len(words), 5))
        write(image, area.part(0.05, 0.44 + 0.095 * k, 0.95, 0.5 + 0.095 * k), chosen, seen_on(ground, p.ink))


def _stack(image: Image.Image, p: Label, area: Area, ground: str, parts: str = "mbw", motif: float = 1.0) -> None:
    """Motif (m), brand (b), rule (r), words (w), small print (s), one below the other; in a wide area motif first."""
    draw = ImageDraw.Draw(image)
    parts = "".join(c for c in parts if (c != "m" or p.motif) and (c != "w" or p.words) and (c != "s" or p.small))
    if "m" in parts and area.width > 1.55 * area.height:
        share = min(0.38, 0.9 * area.height / area.width)
        _motif(image, p, area.part(0.0, 0.0, share, 1.0), ground, 0.92)
        area, parts = area.part(share + 0.03, 0.0, 1.0, 1.0), parts.replace("m", "")
    lines = [1.0 if k == 0 else 0.62 for k in range(len(p.words))]
    weight = {"m": 1.7 * motif, "b": 1.0, "r": 0.14, "w": 0.52 * sum(lines), "s": 0.26}
    total = sum(weight[c] for c in parts) + 0.12 * (len(parts) - 1)
    top = 0.0
    for c in parts:
        row = area.part(0.0, top / total, 1.0, (top + weight[c]) / total)
        match c:
            case "m":
                _motif(image, p, row, ground)
            case "b":
                _brand(image, p, row, ground)
            case "r":
                x, y = row.middle
                draw.line((x - 0.3 * row.width, y, x + 0.3 * row.width, y), p.accent, max(2, round(0.2 * row.height)))
            case "w":
                _words(image, p, row, ground)
            case _:
                _small(image, p, row.part(0.15, 0, 0.85, 1), ground)
        top += weight[c] + 0.12


def _cleared(image: Image.Image, p: Label, area: Area) -> str:
    """The colour below what is written there; where the ground is strewn, a plain field is laid first."""
    if p.pattern in (Pattern.NONE, Pattern.FADE):
        return p.ground[0]
    ImageDraw.Draw(image).rounded_rectangle(area.corners, 0.06 * min(area.width, area.height), fill=p.ground[0])
    return p.ground[0]


def _round_band(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    for top, bottom, color in ((0.3, 0.62, p.second), (0.32, 0.6, p.accent)):
        ImageDraw.Draw(image).rectangle(inside.part(0.0, top, 1.0, bottom).corners, fill=color)


def _band(image: Image.Image, p: Label, face: Area) -> None:
    if face.width > 1.9 * face.height:
        _brand(image, p, face.part(0.28, 0.36, 0.98, 0.56), p.accent, WHITE, p.ground[0])
        _motif(image, p, face.part(0.0, 0.1, 0.26, 0.9), p.accent)
        _words(image, p, face.part(0.3, 0.68, 0.96, 0.95), _cleared(image, p, face.part(0.28, 0.65, 0.98, 0.97)))
        return
    _brand(image, p, face.part(0.06, 0.37, 0.94, 0.55), p.accent, WHITE, p.ground[0])
    _motif(image, p, face.part(0.15, 0.04, 0.85, 0.28), p.ground[0], 1.0)
    rest = face.part(0.1, 0.66, 0.9, 0.96)
    ground = _cleared(image, p, rest.part(-0.03, -0.05, 1.03, 1.05)) if p.words else p.ground[0]
    _words(image, p, rest.part(0, 0, 1, 0.78 if p.small else 1), ground)
    _small(image, p, rest.part(0.2, 0.84, 0.8, 1), ground)


def _badge(image: Image.Image, p: Label, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    x, y = face.middle
    wide, high = min(0.49 * face.width, 0.72 * face.height), min(0.44 * face.height, 0.64 * face.width)
    y -= 0.02 * face.height
    for grow, color in ((1.0, p.accent), (0.94, WHITE), (0.9, p.second)):
        edge = (1 - grow) * min(wide, high)
        draw.ellipse((x - wide + edge, y - high + edge, x + wide - edge, y + high - edge), fill=color)
    _stack(image, p, Area(x - 0.66 * wide, y - 0.68 * high, 1.32 * wide, 1.4 * high), p.second, "mbw", 0.8)


def _plate(image: Image.Image, p: Label, face: Area) -> None:
    draw, plate = ImageDraw.Draw(image), face.part(0.04, 0.1, 0.96, 0.9)
    radius = 0.12 * min(plate.width, plate.height)
    draw.rounded_rectangle(plate.corners, radius, fill=p.accent)
    rim = 0.03 * min(plate.width, plate.height)
    inner = Area(plate.x + rim, plate.y + rim, plate.width - 2 * rim, plate.height - 2 * rim)
    draw.rounded_rectangle(inner.corners, radius - rim, fill=p.second)
    _stack(image, p, inner.part(0.08, 0.08, 0.92, 0.93), p.second, "bmws", 0.9)


def _round_split(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    places = [(inside.width * k / 120, 2 * math.pi * 2 * k / 120) for k in range(121)]
    line = [(x, inside.y + (0.55 + 0.05 * math.sin(turn)) * inside.height) for x, turn in places]
    high = 0.025 * inside.height
    bottom = [(inside.width, image.height), (0, image.height)]
    draw.polygon([*[(x, y - high) for x, y in line], *bottom], fill=p.accent)
    draw.polygon([*[(x, y + high) for x, y in line], *bottom], fill=p.second)


def _split(image: Image.Image, p: Label, face: Area) -> None:
    ground = p.ground[0]
    _brand(image, p, face.part(0.04, 0.08, 0.96, 0.32), ground)
    if p.words:
        write(image, face.part(0.1, 0.35, 0.9, 0.46), p.words[0], seen_on(ground, p.ink, p.accent), "bold")
    _motif(image, p, face.part(0.1, 0.52, 0.9, 0.84), p.second, 1.1)
    _words(image, p, face.part(0.12, 0.87, 0.88, 0.98), p.second, p.words[1:2])


def _round_diagonal(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    wide, reach = 0.5 * inside.width, 0.5 * min(face.width, face.height)
    for k in (-1, 0, 1, 2):
        x = k * wide + 0.25 * inside.width
        top, bottom = inside.y, inside.y + inside.height
        field = [(x + reach, top), (x + reach + 0.5 * wide, top), (x - reach + 0.5 * wide, bottom), (x - reach, bottom)]
        draw.polygon(field, fill=p.second)
        for shift in (-0.05, 0.02):
            a, b = shift * wide, (shift + 0.03) * wide
            edge = [(x + reach + a, top), (x + reach + b, top), (x - reach + b, bottom), (x - reach + a, bottom)]
            draw.polygon(edge, fill=p.accent)


def _diagonal(image: Image.Image, p: Label, face: Area) -> None:
    ground = p.ground[0]
    lean = face.part(0.0, 0.06, 1.0, 0.94)
    _motif(image, p, lean.part(0.1, 0.0, 0.9, 0.3), p.second)
    color = seen_on(p.second, *([p.brand_ink] if p.brand_ink else []), WHITE, p.accent)
    write(image, lean.part(0.02, 0.34, 0.98, 0.6), p.brand, color, p.lettering, seen_on(color, p.accent, ground, p.ink))
    plate = lean.part(0.12, 0.66, 0.88, 0.94)
    if p.words:
        ImageDraw.Draw(image).rectangle(plate.corners, fill=ground)
        _words(image, p, plate.part(0.06, 0.12, 0.94, 1.0), ground)


def _classic(image: Image.Image, p: Label, face: Area) -> None:
    draw, frame = ImageDraw.Draw(image), face.part(0.03, 0.05, 0.97, 0.95)
    unit, ground = 0.018 * min(frame.width, frame.height), _cleared(image, p, frame)
    for inset, line in ((0.0, 1.3), (2.6, 0.5)):
        d = inset * unit
        left, top, right, bottom = frame.corners
        draw.rectangle((left + d, top + d, right - d, bottom - d), outline=p.accent, width=max(1, round(line * unit)))
    _stack(image, p, frame.part(0.1, 0.1, 0.9, 0.92), ground, "mbrws", 0.8)


def _round_stripes(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    count = 2 * max(6, round(inside.width / face.width * 5))
    for k in range(0, count, 2):
        x, w = inside.width * k / count, inside.width / count
        draw.rectangle((x, inside.y, x + w, inside.y + inside.height), fill=p.second)


def _stripes(image: Image.Image, p: Label, face: Area) -> None:
    draw, field = ImageDraw.Draw(image), face.part(0.02, 0.14, 0.98, 0.86)
    draw.rectangle(face.part(0.02, 0.11, 0.98, 0.89).corners, fill=p.accent)
    draw.rectangle(field.corners, fill=p.ground[0])
    _stack(image, p, field.part(0.07, 0.08, 0.93, 0.93), p.ground[0], "mbw")


def _minimal(image: Image.Image, p: Label, face: Area) -> None:
    if p.motif is None and not p.words:
        _brand(image, p, face.part(0.33, 0.42, 0.67, 0.58), _cleared(image, p, face.part(0.25, 0.37, 0.75, 0.63)))
        return
    ground = _cleared(image, p, face.part(0.05, 0.05, 0.95, 0.95))
    _motif(image, p, face.part(0.2, 0.1, 0.8, 0.5), ground)
    _brand(image, p, face.part(0.12, 0.56, 0.88, 0.7), ground)
    ImageDraw.Draw(image).rectangle(face.part(0.35, 0.74, 0.65, 0.755).corners, fill=p.accent)
    _words(image, p, face.part(0.18, 0.79, 0.82, 0.95), ground)


def _round_upright(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    for a, b, color in ((-0.01, 1.01, p.accent), (0.02, 0.98, p.second)):
        ImageDraw.Draw(image).rectangle(face.part(a, 0.0, b, 1.0).corners, fill=color)


def _upright(image: Image.Image, p: Label, face: Area) -> None:
    ground = p.second
    color = seen_on(ground, *([p.brand_ink] if p.brand_ink else []), p.accent, WHITE)
    edge = seen_on(color, p.ink, p.ground[0]) if p.lettering == "outlined" else None
    write(image, face.part(0.1, 0.05, 0.62 if p.words else 0.9, 0.7), p.brand, color, p.lettering, edge, True)
    if p.words:
        write(image, face.part(0.7, 0.06, 0.86, 0.69), p.words[0], seen_on(ground, p.ink), "bold", None, True)
    _motif(image, p, face.part(0.12, 0.73, 0.88, 0.95), ground)


def _round_burst(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    x, y = face.middle
    far = inside.width + inside.height
    for k in range(0, 32, 2):
        turns = (2 * math.pi * k / 32, 2 * math.pi * (k + 1) / 32)
        tip = [(x + far * math.cos(t), y + far * math.sin(t)) for t in turns]
        draw.polygon([(x, y), *tip], fill=p.second)


def _burst(image: Image.Image, p: Label, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    x, y = face.middle
    size = min(0.5 * face.width, 0.46 * face.height)
    points = star(x, y, 22, size, 0.88 * size)
    draw.polygon([(x + (a - x) * 1.08, y + (b - y) * 1.08) for a, b in points], fill=p.ink)
    draw.polygon(points, fill=p.accent)
    _stack(image, p, Area(x - 0.68 * size, y - 0.68 * size, 1.36 * size, 1.36 * size), p.accent, "mbw", 0.8)


def _round_block(image: Image.Image, p: Label, inside: Area, face: Area) -> None:
    for top, bottom, color in ((0, 0.4, p.second), (0.4, 0.425, p.accent)):
        ImageDraw.Draw(image).rectangle(inside.part(0, top, 1, bottom).corners, fill=color)


def _block(image: Image.Image, p: Label, face: Area) -> None:
    _brand(image, p, face.part(0.04, 0.1, 0.96, 0.32), p.second, WHITE)
    ground = _cleared(image, p, face.part(0.02, 0.46, 0.98, 0.97))
    _stack(image, p, face.part(0.08, 0.48, 0.92, 0.96), ground, "wms", 1.2)


def _ribbon(image: Image.Image, p: Label, face: Area) -> None:
    draw = ImageDraw.Draw(image)
    _motif(image, p, face.part(0.15, 0.05, 0.85, 0.36), p.ground[0])
    ribbon = face.part(0.0, 0.4, 1.0, 0.62)
    left, top, right, bottom = ribbon.corners
    fold = 0.16 * ribbon.width
    for side, x in ((1, left), (-1, right)):
        tail = [(x, top + 0.22 * ribbon.height), (x + side * fold, top + 0.22 * ribbon.height)]
        tail += [(x + side * fold, bottom + 0.22 * ribbon.height), (x, bottom + 0.22 * ribbon.height)]
        draw.polygon([*tail, (x + side * 0.4 * fold, (top + bottom) / 2 + 0.22 * ribbon.height)], fill=p.ink)
    body = ribbon.part(0.07, 0.0, 0.93, 1.0)
    draw.rectangle(body.corners, fill=p.accent)
    _brand(image, p, body.part(0.06, 0.16, 0.94, 0.84), p.accent, WHITE)
    rest = face.part(0.1, 0.7, 0.9, 0.96)
    if p.words:
        _words(image, p, rest.part(0, 0, 1, 1), _cleared(image, p, rest.part(-0.04, -0.08, 1.04, 1.05)))


# Of each layout what draws the front, and of some what draws a print around the whole package.
FACES: Mapping[Layout, Callable[[Image.Image, Label, Area], None]] = {
    Layout(face.__name__.removeprefix("_")): face
    for face in (
        *(_band, _badge, _plate, _split, _diagonal, _classic),
        *(_stripes, _minimal, _upright, _burst, _block, _ribbon),
    )
}
ROUND: Mapping[Layout, Callable[[Image.Image, Label, Area, Area], None]] = {
    Layout(around.__name__.removeprefix("_round_")): around
    for around in (
        *(_round_band, _round_split, _round_diagonal, _round_stripes),
        *(_round_upright, _round_burst, _round_block),
    )
}


# A pixel belongs to a line where leaving the line out changes it by more than this, sRGB 0..255.
CHANGED = 24
# A pixel belongs to the letters themselves, and not to their outline, where it has their colour to this.
SAME_COLOR = 40
BLANK = " "


def lines_in_picture(p: Label, size_px: tuple[int, int]) -> tuple[PrintedLine, ...]:
    """Where the brand and the first word of a label are seen, without what covers them; `size_px`: (H, W)."""
    whole = np.asarray(front(p, size_px)[0], dtype=np.int16)
    without = {p.brand: p.replace(brand=BLANK)}
    if p.words:
        without[p.words[0]] = p.replace(words=(BLANK, *p.words[1:]))
    found = []
    for text, rest in without.items():
        letters = _letters(whole, np.asarray(front(rest, size_px)[0], dtype=np.int16))
        rows, columns = size_px
        cover = letters.reshape(rows, FINER, columns, FINER).mean(axis=(1, 3), dtype=np.float32)
        found.append(PrintedLine(text, cover, p.layout is Layout.UPRIGHT))
    return tuple(found)


def _letters(whole: npt.NDArray[np.int16], blank: npt.NDArray[np.int16]) -> npt.NDArray[np.bool_]:
    """(H, W) what has the colour of the letters among all that a line changes; an outline has another one."""
    changed: npt.NDArray[np.bool_] = np.abs(whole - blank).max(axis=2) > CHANGED
    letters = np.zeros_like(changed)
    if changed.any():
        box = ndimage.find_objects(changed.astype(np.int8))[0]  # a distance over all of the picture would take longer
        within, colors = np.pad(changed[box], 1), whole[box]
        deepest = np.unravel_index(int(ndimage.distance_transform_edt(within)[1:-1, 1:-1].argmax()), colors.shape[:2])
        letters[box] = changed[box] & (np.abs(colors - colors[deepest]).max(axis=2) <= SAME_COLOR)
    return letters


LABEL = TextureKind("label", Label, paint, lines_in_picture)
