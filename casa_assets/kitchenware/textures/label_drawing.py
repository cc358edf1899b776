"""Drawing for labels: areas, letters, colours, and motifs: shapes in the square from -1 to 1, y down."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from casa_assets.ext.arrays import linear_from_srgb_array
from casa_assets.ext.records import Vec2
from casa_assets.ext.textures import rgb

LETTER_PX = 96  # letters are drawn this many pixels high and then fitted
# A colour for letters differs in lightness from what lies below it by at least this, and has at least this contrast
# ratio to it: somewhat more than the 3 of large print, as thin letters lose some. Ref: WCAG 2.1, criterion 1.4.3.
MIN_CONTRAST, MIN_RATIO = 0.32, 3.4
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB. Ref: ITU-R BT.709.
WHITE, BLACK = "#fbf9f4", "#211d1b"
# How the brand is written.
Lettering = Literal["plain", "bold", "wide", "narrow", "slanted", "arched", "spaced", "outlined"]


@dataclass(frozen=True)
class Area:
    """An upright rectangle of the picture, pixels, y down."""

    x: float
    y: float
    width: float
    height: float

    @property
    def middle(self) -> tuple[float, float]:
        """Its middle."""
        return self.x + self.width / 2, self.y + self.height / 2

    def part(self, left: float, top: float, right: float, bottom: float) -> Area:
        """A rectangle within it, by shares of its sides."""
        x, y = self.x + left * self.width, self.y + top * self.height
        return Area(x, y, (right - left) * self.width, (bottom - top) * self.height)

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom."""
        return self.x, self.y, self.x + self.width, self.y + self.height


def _lightness(color: str) -> float:
    return float(rgb(color) @ np.array([0.3, 0.59, 0.11], dtype=np.float32))


def seen_on(ground: str, *wanted: str) -> str:
    """The first of the colours that is seen on a ground, else white or black."""
    for color in wanted:
        if abs(_lightness(color) - _lightness(ground)) >= MIN_CONTRAST and _ratio(color, ground) >= MIN_RATIO:
            return color
    return max(WHITE, BLACK, key=lambda color: _ratio(color, ground))


def _ratio(one: str, other: str) -> float:
    """Contrast ratio of two colours, 1..21."""
    light = sorted(float(linear_from_srgb_array(rgb(c)) @ LUMINANCE) + 0.05 for c in (one, other))
    return light[1] / light[0]


def letters(text: str, lettering: Lettering = "plain") -> Image.Image:
    """The mask of a line of letters without a margin; mode L."""
    stroke = {"bold": 5, "arched": 5, "slanted": 4, "outlined": 6, "wide": 3}.get(lettering, 2)
    gap = {"spaced": 0.35, "wide": 0.12, "narrow": -0.02}.get(lettering, 0.0) * LETTER_PX
    font = ImageFont.load_default(LETTER_PX)
    edges = [0.0]
    for letter in text:
        edges.append(edges[-1] + font.getlength(letter) + gap + stroke * 0.7)
    mask = Image.new("L", (int(edges[-1]) + 2 * LETTER_PX, 2 * LETTER_PX), 0)
    draw = ImageDraw.Draw(mask)
    for letter, x in zip(text, edges, strict=False):
        draw.text((x + LETTER_PX // 2, LETTER_PX // 3), letter, fill=255, font=font, stroke_width=stroke)
    if lettering == "slanted":
        mask = mask.transform(mask.size, Image.Transform.AFFINE, (1, 0.22, -0.22 * LETTER_PX, 0, 1, 0), 3)
    box = mask.getbbox()
    mask = mask.crop(box) if box else mask
    factor = {"wide": 1.35, "narrow": 0.62}.get(lettering)
    if factor:
        mask = mask.resize((max(1, int(mask.width * factor)), mask.height), Image.Resampling.BICUBIC)
    return _arched(mask) if lettering == "arched" else mask


def _arched(mask: Image.Image) -> Image.Image:
    """Letters whose line rises towards the middle."""
    rise = int(0.5 * mask.height)
    out = np.zeros((mask.height + rise, mask.width), dtype=np.uint8)
    source = np.asarray(mask)
    for x in range(mask.width):
        down = round(rise * (2 * x / max(1, mask.width - 1) - 1) ** 2)
        out[down : down + mask.height, x] = source[:, x]
    return Image.fromarray(out)


def write(
    image: Image.Image,
    area: Area,
    text: str,
    color: str,
    lettering: Lettering = "plain",
    edge: str | None = None,
    upright: bool = False,
) -> None:
    """Letters as large as they can be within an area, in its middle; they are stretched by a fifth at most.

    `edge`: colour of an outline. `upright`: the line runs upwards.
    """
    if not text or area.width < 4 or area.height < 4:
        return
    mask = letters(text, lettering)
    if upright:
        mask = mask.transpose(Image.Transpose.ROTATE_90)
    scale = min(area.width / mask.width, area.height / mask.height)
    wide = min(area.width, 1.2 * scale * mask.width)
    high = min(area.height, 1.2 * scale * mask.height)
    fitted = mask.resize((max(1, round(wide)), max(1, round(high))), Image.Resampling.LANCZOS)
    at = (round(area.middle[0] - fitted.width / 2), round(area.middle[1] - fitted.height / 2))
    if edge is not None:
        step = max(1, round(0.045 * min(fitted.height, 3 * area.height)))
        for angle in range(12):
            dx, dy = round(step * math.cos(math.pi * angle / 6)), round(step * math.sin(math.pi * angle / 6))
            image.paste(edge, (at[0] + dx, at[1] + dy), fitted)
    image.paste(color, at, fitted)


Points = Sequence[Vec2]


class Pen:
    """Draws into a square of a picture.

    image: the picture. x, y: pixels of the square's middle. size: to a side. colors: of a drawing; the last: of the
    rest.
    """

    def __init__(self, image: Image.Image, x: float, y: float, size: float, colors: Sequence[str] = ()) -> None:
        self.draw = ImageDraw.Draw(image)
        self.x, self.y, self.size = x, y, size
        self.colors = tuple(colors)

    def tone(self, index: int, own: str) -> str:
        """The colour number `index` of a drawing, or `own` if no colours are given."""
        return self.colors[min(index, len(self.colors) - 1)] if self.colors else own

    def at(self, points: Points) -> list[Vec2]:
        """Pixels of points of the square."""
        return [(self.x + self.size * x, self.y + self.size * y) for x, y in points]

    def shape(self, points: Points, color: str) -> None:
        """A filled polygon."""
        self.draw.polygon(self.at(points), fill=color)

    def oval(self, x: float, y: float, wide: float, high: float, color: str, turn: float = 0.0) -> None:
        """A filled ellipse about (x, y), its half axes, turned by rad."""
        c, s = math.cos(turn), math.sin(turn)
        ring = [(wide * math.cos(t), high * math.sin(t)) for t in (2 * math.pi * k / 40 for k in range(40))]
        self.shape([(x + c * a - s * b, y + s * a + c * b) for a, b in ring], color)

    def line(self, points: Points, width: float, color: str) -> None:
        """A line of a width with round joints."""
        self.draw.line(self.at(points), fill=color, width=max(1, round(width * self.size)), joint="curve")
        for x, y in (points[0], points[-1]):
            self.oval(x, y, width / 2, width / 2, color)


def blade(x: float, y: float, length: float, width: float, turn: float) -> list[Vec2]:
    """Points of a pointed leaf that starts at (x, y) and grows along `turn`, rad from the right, y down."""
    c, s = math.cos(turn), math.sin(turn)
    along = [k / 12 for k in range(13)]
    side = [(length * t, width * math.sin(math.pi * t) ** 0.8) for t in along]
    ring = [*side, *[(a, -b) for a, b in side[::-1]]]
    return [(x + c * a - s * b, y + s * a + c * b) for a, b in ring]


def star(x: float, y: float, points: int, outer: float, inner: float, turn: float = -math.pi / 2) -> list[Vec2]:
    """Points of a star."""
    return [
        (x + r * math.cos(turn + math.pi * k / points), y + r * math.sin(turn + math.pi * k / points))
        for k in range(2 * points)
        for r in (outer if k % 2 == 0 else inner,)
    ]


def _tomato(p: Pen) -> None:
    red, green = p.tone(0, "#c8321f"), p.tone(1, "#3f7a35")
    p.oval(-0.3, 0.12, 0.6, 0.68, red)
    p.oval(0.3, 0.12, 0.6, 0.68, red)
    p.oval(-0.4, -0.05, 0.14, 0.22, p.tone(2, "#e4705a"), 0.5)
    p.shape(star(0.0, -0.5, 6, 0.5, 0.15), green)
    p.line([(0.0, -0.5), (0.08, -0.9)], 0.12, green)


def _olive(p: Pen) -> None:
    green, fruit = p.tone(0, "#6c7a35"), p.tone(1, "#4c5a24")
    p.line([(-0.95, 0.45), (-0.3, 0.1), (0.35, -0.15), (0.95, -0.55)], 0.06, green)
    for x, y, turn in ((-0.6, 0.25, -1.6), (-0.1, 0.02, -1.3), (0.4, -0.2, -1.4), (-0.3, 0.1, 0.9), (0.55, -0.28, 0.5)):
        p.shape(blade(x, y, 0.7, 0.13, turn), green)
    for x, y in ((0.02, 0.38), (-0.62, 0.66)):
        p.line([(x, y - 0.4), (x, y)], 0.04, green)
        p.oval(x, y, 0.2, 0.27, fruit, 0.2)
        p.oval(x - 0.07, y - 0.09, 0.04, 0.08, p.tone(2, "#a9b56a"), 0.3)


def _sun(p: Pen) -> None:
    p.shape(star(0.0, 0.0, 16, 0.95, 0.62), p.tone(0, "#e8a21c"))
    p.oval(0.0, 0.0, 0.52, 0.52, p.tone(1, "#f6cf4a"))


def _wave(p: Pen) -> None:
    for k, own in enumerate(("#2b6ea6", "#4a96c8", "#8cc4e0")):
        y = -0.45 + 0.42 * k
        line = [(-1 + t / 20, y + 0.16 * math.sin(2 * math.pi * t / 20 + 0.6 * k)) for t in range(41)]
        p.line(line, 0.17, p.tone(k, own))


def _bee(p: Pen) -> None:
    dark, gold, wing = p.tone(0, "#33271a"), p.tone(1, "#e8b021"), p.tone(2, "#cfdfe4")
    p.oval(-0.2, -0.5, 0.24, 0.5, wing, -0.5)
    p.oval(0.28, -0.5, 0.24, 0.5, wing, 0.5)
    p.oval(0.0, 0.15, 0.72, 0.44, gold)
    for x in (-0.3, 0.02, 0.34):
        high = 0.42 * math.sqrt(max(0.0, 1 - (x / 0.72) ** 2))
        p.line([(x, 0.15 - high), (x, 0.15 + high)], 0.15, dark)
    p.oval(-0.72, 0.1, 0.24, 0.24, dark)
    p.line([(-0.8, -0.08), (-0.95, -0.35)], 0.05, dark)
    p.line([(-0.66, -0.08), (-0.66, -0.4)], 0.05, dark)
    p.shape([(0.66, 0.05), (0.95, 0.17), (0.66, 0.27)], dark)


def _leaf(p: Pen) -> None:
    p.shape(blade(-0.7, 0.7, 1.95, 0.42, -math.pi / 4), p.tone(0, "#4f8c3c"))
    p.line([(-0.92, 0.92), (0.35, -0.35)], 0.06, p.tone(1, "#cfe2a8"))
    for t in (0.0, 0.35, 0.7):
        x = -0.45 + t
        p.line([(x, -x), (x + 0.36, -x + 0.02)], 0.04, p.tone(1, "#cfe2a8"))
        p.line([(x, -x), (x - 0.02, -x - 0.36)], 0.04, p.tone(1, "#cfe2a8"))


def _cow(p: Pen) -> None:
    white, dark, pink = p.tone(1, "#f4f0e8"), p.tone(0, "#2f2a28"), p.tone(2, "#e2a79c")
    p.oval(0.0, -0.2, 0.6, 0.63, dark)
    p.oval(0.0, 0.25, 0.47, 0.65, dark)
    for side in (-1, 1):
        p.oval(0.72 * side, -0.3, 0.3, 0.16, dark, 0.4 * side)
        p.line([(0.3 * side, -0.62), (0.42 * side, -0.92)], 0.13, p.tone(2, "#c9b48a"))
    p.oval(0.0, -0.2, 0.55, 0.58, white)
    p.oval(0.0, 0.25, 0.42, 0.6, white)
    p.oval(0.34, -0.32, 0.25, 0.33, dark)
    p.oval(0.0, 0.55, 0.5, 0.33, pink)
    for side in (-1, 1):
        p.oval(0.2 * side, 0.55, 0.07, 0.1, dark)
        p.oval(0.24 * side, -0.18, 0.09, 0.11, dark if side < 0 else white)


def _grain(p: Pen) -> None:
    gold = p.tone(0, "#c99a34")
    for foot, top, lean in ((-0.1, -0.5, -0.6), (0.1, -0.5, 0.6), (0.0, -0.72, 0.0)):
        p.line([(foot * 0.4, 0.95), (foot + lean * 0.5, 0.2), (lean, top)], 0.045, gold)
        for k in range(5):
            x, y = lean * (0.55 + 0.1 * k), 0.2 - 0.2 * k + (0.05 if lean else 0.0)
            for side in (-1, 1):
                p.shape(blade(x, y, 0.32, 0.06, -math.pi / 2 + 0.7 * side + 0.4 * lean), gold)
        p.shape(blade(lean, top + 0.08, 0.34, 0.085, -math.pi / 2 + 0.5 * lean), gold)


def _cup(p: Pen) -> None:
    body, drink = p.tone(0, "#7a4a2c"), p.tone(1, "#f3ead8")
    p.oval(0.62, 0.22, 0.32, 0.3, body)
    p.oval(0.62, 0.22, 0.19, 0.17, drink)
    p.shape([(-0.75, -0.12), (0.6, -0.12), (0.52, 0.4), (0.25, 0.72), (-0.4, 0.72), (-0.67, 0.4)], body)
    p.oval(-0.08, 0.86, 0.9, 0.1, body)
    for x in (-0.38, -0.05, 0.28):
        p.line(_steam(x, -0.28, 0.62), 0.07, p.tone(2, "#b79a80"))


def _steam(x: float, y: float, rise: float) -> list[Vec2]:
    return [(x + 0.08 * math.sin(5 * t), y - rise * t) for t in (k / 10 for k in range(11))]


def _citrus(p: Pen, rind: str, flesh: str) -> None:
    p.oval(0.0, 0.0, 0.9, 0.9, p.tone(0, rind))
    p.oval(0.0, 0.0, 0.77, 0.77, p.tone(1, "#fbf3d8"))
    for k in range(8):
        a, b = math.pi / 4 * k + 0.06, math.pi / 4 * (k + 1) - 0.06
        arc = [(0.7 * math.cos(a + (b - a) * t), 0.7 * math.sin(a + (b - a) * t)) for t in (0, 0.25, 0.5, 0.75, 1)]
        middle = (a + b) / 2
        p.shape([(0.08 * math.cos(middle), 0.08 * math.sin(middle)), *arc], p.tone(2, flesh))


def _lemon(p: Pen) -> None:
    yellow = p.tone(0, "#eac52b")
    p.oval(0.0, 0.15, 0.8, 0.56, yellow, -0.4)
    p.oval(0.74, -0.17, 0.2, 0.13, yellow, -0.4)
    p.oval(-0.72, 0.46, 0.18, 0.14, yellow, -0.4)
    p.oval(-0.22, -0.02, 0.3, 0.12, p.tone(2, "#f7e48a"), -0.5)
    p.shape(blade(0.3, -0.42, 0.75, 0.2, -0.6), p.tone(1, "#4f8c3c"))


def _apple(p: Pen) -> None:
    red = p.tone(0, "#bb2a27")
    p.oval(-0.28, 0.18, 0.5, 0.64, red, 0.12)
    p.oval(0.28, 0.18, 0.5, 0.64, red, -0.12)
    p.line([(0.0, -0.35), (0.06, -0.85)], 0.09, p.tone(2, "#6a4527"))
    p.shape(blade(0.05, -0.5, 0.65, 0.17, -0.5), p.tone(1, "#4f8c3c"))


def _cherry(p: Pen) -> None:
    red = p.tone(0, "#a3142a")
    p.line([(0.2, -0.85), (-0.1, -0.4), (-0.42, 0.25)], 0.07, p.tone(1, "#4f7a35"))
    p.line([(0.2, -0.85), (0.4, -0.3), (0.42, 0.35)], 0.07, p.tone(1, "#4f7a35"))
    p.shape(blade(0.2, -0.85, 0.8, 0.2, 0.25), p.tone(1, "#4f7a35"))
    for x, y in ((-0.45, 0.45), (0.42, 0.55)):
        p.oval(x, y, 0.37, 0.37, red)
        p.oval(x - 0.12, y - 0.13, 0.08, 0.08, p.tone(2, "#dd6a78"))


def _strawberry(p: Pen) -> None:
    red = p.tone(0, "#c4202b")
    p.shape([(-0.68, -0.3), (-0.3, -0.55), (0.3, -0.55), (0.68, -0.3), (0.5, 0.3), (0.0, 0.95), (-0.5, 0.3)], red)
    p.oval(-0.36, -0.2, 0.36, 0.4, red)
    p.oval(0.36, -0.2, 0.36, 0.4, red)
    p.oval(0.0, 0.5, 0.3, 0.42, red)
    seeds = ((-0.4, -0.1), (0.0, -0.15), (0.4, -0.1), (-0.2, 0.2), (0.2, 0.2), (0.0, 0.5), (-0.22, 0.5), (0.22, 0.5))
    for x, y in seeds:
        p.oval(x, y, 0.05, 0.07, p.tone(2, "#f0cf6a"))
    for k in range(5):
        p.shape(blade(0.0, -0.62, 0.6, 0.14, 0.15 + 0.71 * k), p.tone(1, "#4f8c3c"))


def _berry(p: Pen) -> None:
    p.shape(blade(0.0, -0.5, 0.8, 0.2, -0.4), p.tone(1, "#4f8c3c"))
    p.shape(blade(0.0, -0.5, 0.8, 0.2, -2.6), p.tone(1, "#4f8c3c"))
    for x, y in ((-0.42, 0.0), (0.42, 0.0), (0.0, 0.45), (0.0, -0.3)):
        p.oval(x, y, 0.38, 0.38, p.tone(0, "#3d4a86"))
        p.oval(x, y - 0.08, 0.13, 0.1, p.tone(2, "#7f8cc0"))


def _grape(p: Pen) -> None:
    p.line([(0.0, -0.6), (0.1, -0.95)], 0.09, p.tone(1, "#6a5a2f"))
    p.shape(blade(0.0, -0.6, 0.85, 0.25, -0.3), p.tone(1, "#5d7f3a"))
    for row, count in enumerate((4, 3, 2, 1)):
        for k in range(count):
            x, y = 0.38 * (k - (count - 1) / 2), -0.35 + 0.34 * row
            p.oval(x, y, 0.22, 0.22, p.tone(0, "#5a2a4f"))
            p.oval(x - 0.06, y - 0.07, 0.05, 0.05, p.tone(2, "#a47f9c"))


def _mountain(p: Pen) -> None:
    p.shape([(-1, 0.7), (-0.42, -0.35), (0.1, 0.7)], p.tone(1, "#6f93ad"))
    p.shape([(-0.5, 0.7), (0.25, -0.8), (1, 0.7)], p.tone(0, "#3d6786"))
    p.shape([(0.0, -0.3), (0.25, -0.8), (0.5, -0.3), (0.36, -0.15), (0.25, -0.3), (0.12, -0.12)], p.tone(2, "#f2f6f8"))


def _drop(p: Pen) -> None:
    color = p.tone(0, "#3f93c4")
    p.oval(0.0, 0.3, 0.56, 0.58, color)
    p.shape([(-0.51, 0.08), (0.0, -0.95), (0.51, 0.08)], color)
    p.oval(-0.22, 0.4, 0.1, 0.22, p.tone(1, "#cfe8f3"), 0.4)


def _star(p: Pen) -> None:
    p.shape(star(0.0, 0.05, 5, 0.95, 0.4), p.tone(0, "#c9302c"))


def _flower(p: Pen) -> None:
    for k in range(7):
        a = 2 * math.pi * k / 7
        p.oval(0.52 * math.cos(a), 0.52 * math.sin(a), 0.4, 0.22, p.tone(0, "#b78bc4"), a)
    p.oval(0.0, 0.0, 0.26, 0.26, p.tone(1, "#e8b82f"))


def _chili(p: Pen) -> None:
    body = [(-0.75, 0.75), (-0.2, 0.72), (0.3, 0.4), (0.62, -0.15), (0.62, -0.5), (0.22, -0.55)]
    p.shape([*body, (0.05, -0.1), (-0.25, 0.35)], p.tone(0, "#c4231c"))
    p.oval(0.42, -0.45, 0.22, 0.2, p.tone(0, "#c4231c"))
    p.oval(0.42, -0.55, 0.25, 0.13, p.tone(1, "#4f7a35"))
    p.line([(0.42, -0.55), (0.55, -0.95)], 0.11, p.tone(1, "#4f7a35"))


def _bean(p: Pen) -> None:
    for x, y, turn in ((-0.35, -0.3, 0.6), (0.4, 0.0, -0.5), (-0.25, 0.5, -0.2)):
        p.oval(x, y, 0.5, 0.28, p.tone(0, "#a8542e"), turn)
        p.oval(x, y - 0.2, 0.2, 0.11, p.tone(1, "#e9d9b8"), turn)


def _pea(p: Pen) -> None:
    p.shape(blade(-0.95, 0.35, 2.0, 0.42, -0.35), p.tone(0, "#4f8c3c"))
    for k in range(4):
        p.oval(-0.5 + 0.35 * k, 0.19 - 0.13 * k, 0.19, 0.19, p.tone(1, "#a8cf6a"))


def _fish(p: Pen) -> None:
    p.shape([(0.45, 0.0), (0.95, -0.45), (0.85, 0.0), (0.95, 0.45)], p.tone(0, "#3f6f94"))
    p.shape(blade(-0.95, 0.0, 1.6, 0.48, 0.0), p.tone(0, "#3f6f94"))
    p.shape(blade(-0.85, 0.12, 1.35, 0.26, 0.0), p.tone(1, "#c8d9e2"))
    p.oval(-0.62, -0.08, 0.08, 0.08, p.tone(1, "#f4f6f6"))


def _corn(p: Pen) -> None:
    p.oval(0.0, -0.1, 0.42, 0.85, p.tone(0, "#e8bd2f"))
    for row in range(7):
        for k in range(3):
            p.oval(-0.22 + 0.22 * k, -0.72 + 0.2 * row, 0.09, 0.08, p.tone(2, "#f6dc72"))
    p.shape(blade(-0.05, 0.95, 1.35, 0.3, -2.05), p.tone(1, "#5d8f3a"))
    p.shape(blade(0.05, 0.95, 1.35, 0.3, -1.1), p.tone(1, "#5d8f3a"))


def _peanut(p: Pen) -> None:
    shell, line = p.tone(0, "#c9974f"), p.tone(1, "#8f6330")
    p.oval(-0.35, 0.32, 0.5, 0.42, shell, -0.7)
    p.oval(0.32, -0.35, 0.46, 0.4, shell, -0.7)
    p.oval(0.0, 0.0, 0.42, 0.27, shell, -0.75)
    for d in (-0.16, 0.04, 0.24):
        p.line([(-0.6 + d, 0.48 + d), (0.0 + d, -0.06 + d), (0.46 + d * 0.8, -0.6 + d)], 0.035, line)


def _maple(p: Pen) -> None:
    half = [(0.0, -0.98), (0.18, -0.6), (0.36, -0.7), (0.32, -0.2), (0.6, -0.48), (0.68, -0.3), (0.98, -0.32)]
    half += [(0.84, -0.05), (0.96, 0.08), (0.5, 0.38), (0.55, 0.55), (0.06, 0.45)]
    p.shape([*half, *[(-x, y) for x, y in half[::-1]]], p.tone(0, "#b8401f"))
    p.line([(0.0, 0.4), (0.0, 0.95)], 0.08, p.tone(0, "#b8401f"))


def _hop(p: Pen) -> None:
    p.line([(0.0, -0.6), (0.0, -0.98)], 0.07, p.tone(1, "#4f7a35"))
    for row, wide in enumerate((1, 2, 3, 3, 2, 1)):
        for k in range(wide):
            x, y = 0.36 * (k - (wide - 1) / 2), -0.62 + 0.24 * row
            p.oval(x, y, 0.23, 0.27, p.tone(1, "#6f9a3e"))
            p.oval(x, y - 0.03, 0.18, 0.22, p.tone(0, "#8fb655"))


def _anchor(p: Pen) -> None:
    color = p.tone(0, "#24405c")
    p.oval(0.0, -0.75, 0.2, 0.2, color)
    p.line([(0.0, -0.7), (0.0, 0.8)], 0.15, color)
    p.line([(-0.4, -0.4), (0.4, -0.4)], 0.13, color)
    arc = [(0.72 * math.cos(t), 0.15 + 0.68 * math.sin(t)) for t in (math.pi * k / 16 for k in range(17))]
    p.line(arc, 0.14, color)
    for side in (-1, 1):
        p.shape([(0.95 * side, 0.25), (0.72 * side, -0.08), (0.48 * side, 0.25)], color)


def _crown(p: Pen) -> None:
    gold = p.tone(0, "#c39a3a")
    top = [(-0.9, -0.45), (-0.45, 0.1), (0.0, -0.7), (0.45, 0.1), (0.9, -0.45)]
    p.shape([(-0.72, 0.55), *top, (0.72, 0.55)], gold)
    p.shape([(-0.72, 0.62), (0.72, 0.62), (0.72, 0.78), (-0.72, 0.78)], gold)
    for x, y in (top[0], top[2], top[4]):
        p.oval(x, y - 0.08, 0.12, 0.12, gold)


def _bubbles(p: Pen) -> None:
    for x, y, r in ((-0.35, 0.2, 0.52), (0.45, -0.2, 0.4), (0.35, 0.6, 0.26), (-0.25, -0.65, 0.24), (0.85, 0.4, 0.13)):
        p.oval(x, y, r, r, p.tone(0, "#6fb4d4"))
        p.oval(x, y, 0.84 * r, 0.84 * r, p.tone(1, "#d6edf5"))
        p.oval(x - 0.35 * r, y - 0.35 * r, 0.2 * r, 0.2 * r, p.tone(2, "#ffffff"))


def _sticks(p: Pen) -> None:
    for k, (x, turn) in enumerate(((-0.3, 0.12), (0.25, -0.2), (0.0, -0.05))):
        c, s = math.cos(turn), math.sin(turn)
        ring = [(a * c - b * s + x, a * s + b * c) for a, b in ((-0.17, -0.9), (0.17, -0.9), (0.17, 0.9), (-0.17, 0.9))]
        p.shape(ring, p.tone(0, ("#8a5431", "#7a4727", "#9c643c")[k]))
        p.line([(x - s * -0.8, -0.8 * c), (x - s * 0.8, 0.8 * c)], 0.05, p.tone(1, "#4f2c16"))
    p.line([(-0.6, 0.1), (0.6, 0.0)], 0.12, p.tone(2, "#d8c49a"))


def _pepper(p: Pen) -> None:
    red, green = p.tone(0, "#b5281c"), p.tone(1, "#4f7a35")
    for x, high in ((-0.38, 0.6), (0.38, 0.6), (0.0, 0.7)):
        p.oval(x, 0.2, 0.38, high, red)
    p.oval(-0.4, 0.0, 0.08, 0.24, p.tone(2, "#dd6f57"), 0.1)
    p.oval(0.0, -0.42, 0.42, 0.13, green)
    p.line([(0.0, -0.42), (0.02, -0.72), (0.2, -0.92)], 0.13, green)


def _root(p: Pen) -> None:
    gold = p.tone(0, "#d08f22")
    p.oval(-0.1, 0.12, 0.72, 0.27, gold, -0.25)
    p.oval(0.35, -0.35, 0.22, 0.48, gold, 0.5)
    p.oval(-0.4, 0.5, 0.2, 0.4, gold, 0.4)
    p.oval(0.5, 0.3, 0.18, 0.36, gold, -0.7)
    for x in (-0.5, -0.25, 0.0, 0.25):
        p.line([(x, 0.05 - 0.2 * x), (x + 0.06, 0.35 - 0.25 * x)], 0.04, p.tone(1, "#8f5c14"))


def _comb(p: Pen) -> None:
    for x, y in ((-0.5, -0.29), (0.5, -0.29), (0.0, 0.0), (0.0, -0.6), (-0.5, 0.29), (0.5, 0.29), (0.0, 0.6)):
        for k, (size, own) in enumerate(((0.32, "#dd9f1f"), (0.22, "#f4cd5a"))):
            turns = [math.pi * i / 3 for i in range(6)]
            p.shape([(x + size * math.cos(t), y + size * math.sin(t)) for t in turns], p.tone(k, own))


def _carrot(p: Pen) -> None:
    for turn in (-2.0, -1.57, -1.1):
        p.shape(blade(0.3, -0.35, 0.68, 0.12, turn + 0.4), p.tone(1, "#4f8c3c"))
    p.shape([(0.05, -0.5), (0.5, -0.2), (0.25, 0.25), (-0.85, 0.9), (-0.3, 0.0)], p.tone(0, "#dd7a22"))
    p.oval(0.25, -0.25, 0.32, 0.26, p.tone(0, "#dd7a22"), 0.6)


def _egg(p: Pen) -> None:
    p.oval(0.0, 0.25, 0.6, 0.62, p.tone(0, "#d9a878"))
    p.oval(0.0, -0.05, 0.5, 0.82, p.tone(0, "#d9a878"))
    p.oval(-0.2, -0.25, 0.1, 0.24, p.tone(1, "#f2d6b4"), 0.25)


def _cookie(p: Pen) -> None:
    p.oval(0.0, 0.0, 0.88, 0.88, p.tone(0, "#c08a4c"))
    for x, y in ((-0.4, -0.35), (0.1, -0.55), (0.45, -0.1), (-0.1, 0.05), (-0.5, 0.25), (0.15, 0.5), (0.55, 0.4)):
        p.oval(x, y, 0.12, 0.11, p.tone(1, "#4f2e1c"))


def _bowl(p: Pen) -> None:
    half = [(0.82 * math.cos(t), 0.1 + 0.75 * math.sin(t)) for t in (math.pi * k / 20 for k in range(21))]
    p.shape(half, p.tone(0, "#c23f2c"))
    p.oval(0.0, 0.1, 0.86, 0.17, p.tone(1, "#f0d9a0"))
    p.shape([(-0.3, 0.78), (0.3, 0.78), (0.36, 0.92), (-0.36, 0.92)], p.tone(0, "#c23f2c"))
    for x in (-0.3, 0.05, 0.4):
        p.line(_steam(x, -0.15, 0.65), 0.07, p.tone(2, "#c9b7a0"))


def _chicken(p: Pen) -> None:
    body, red = p.tone(0, "#b5702f"), p.tone(1, "#c4231c")
    p.oval(0.1, 0.2, 0.6, 0.45, body)
    p.shape([(0.5, 0.3), (0.98, -0.5), (0.85, 0.3), (0.5, 0.5)], body)
    p.oval(-0.42, -0.25, 0.27, 0.42, body, -0.3)
    p.oval(-0.52, -0.5, 0.24, 0.22, body)
    for x in (-0.66, -0.5, -0.34):
        p.oval(x, -0.75, 0.1, 0.14, red)
    p.shape([(-0.72, -0.55), (-0.98, -0.43), (-0.72, -0.38)], p.tone(2, "#e0a52e"))
    p.oval(-0.66, -0.28, 0.08, 0.15, red)
    for x in (0.0, 0.25):
        p.line([(x, 0.6), (x, 0.95)], 0.07, p.tone(2, "#e0a52e"))


def _mint(p: Pen) -> None:
    green = p.tone(0, "#3f9a5f")
    p.line([(0.0, 0.95), (0.0, -0.3)], 0.06, green)
    for y, size in ((0.55, 0.8), (0.1, 0.65), (-0.3, 0.5)):
        for side in (-1, 1):
            p.shape(blade(0.0, y, size, 0.2, -math.pi / 2 + 0.95 * side), green)
    p.shape(blade(0.0, -0.3, 0.6, 0.18, -math.pi / 2), green)


def _clove(p: Pen) -> None:
    p.oval(0.0, 0.3, 0.62, 0.55, p.tone(0, "#efe9dc"))
    p.shape([(-0.45, 0.0), (0.0, -0.95), (0.45, 0.0)], p.tone(0, "#efe9dc"))
    for x in (-0.25, 0.05, 0.3):
        p.line([(0.02, -0.7), (x, 0.0), (1.1 * x, 0.7)], 0.04, p.tone(1, "#b79fae"))


def _ship(p: Pen) -> None:
    color = p.tone(0, "#24405c")
    p.shape([(-0.85, 0.35), (0.85, 0.35), (0.6, 0.75), (-0.6, 0.75)], color)
    p.line([(0.0, 0.35), (0.0, -0.95)], 0.07, color)
    p.shape([(0.08, -0.85), (0.75, 0.2), (0.08, 0.2)], p.tone(1, "#b5472f"))
    p.shape([(-0.08, -0.6), (-0.6, 0.2), (-0.08, 0.2)], p.tone(1, "#b5472f"))


def _tree(p: Pen) -> None:
    for k, y in enumerate((-0.9, -0.45, 0.0)):
        w = 0.42 + 0.18 * k
        p.shape([(0.0, y), (w, y + 0.65), (-w, y + 0.65)], p.tone(0, "#2f6b45"))
    p.line([(0.0, 0.6), (0.0, 0.92)], 0.16, p.tone(1, "#6a4527"))


def _orange(p: Pen) -> None:
    _citrus(p, "#e07c1e", "#f0a03a")


def _lime(p: Pen) -> None:
    _citrus(p, "#5f8f2c", "#b4cf6a")


MOTIFS: Mapping[str, Callable[[Pen], None]] = {
    maker.__name__.removeprefix("_"): maker
    for maker in (
        *(_tomato, _olive, _sun, _wave, _bee, _leaf, _cow, _grain, _cup, _lemon, _orange, _lime, _apple),
        *(_cherry, _strawberry, _berry, _grape, _mountain, _drop, _star, _flower, _chili, _bean, _pea, _fish),
        *(_corn, _peanut, _maple, _hop, _anchor, _crown, _bubbles, _sticks, _pepper, _root, _comb, _carrot),
        *(_egg, _cookie, _bowl, _chicken, _mint, _clove, _ship, _tree),
    )
}
