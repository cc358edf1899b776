"""Parse sizes from titles and prompts: lengths, volumes, and words such as `mini` or `family`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_NUMBER = r"(?<![\w.])(\d{1,4}(?:[.,]\d{1,3})?)"
# Ref: exact definitions of the inch (25.4 mm), the US fluid ounce, quart and gallon.
_LENGTHS = {
    "mm": (0.001, r"mm|millimet(?:er|re)s?"),
    "cm": (0.01, r"cm|centimet(?:er|re)s?"),
    "inch": (0.0254, r"\"|''|”|″|in|inch(?:es)?"),
    "foot": (0.3048, r"ft|foot|feet"),
}
_VOLUMES = {
    "millilitre": (1e-6, r"ml|millilit(?:er|re)s?"),
    "centilitre": (1e-5, r"cl"),
    "litre": (1e-3, r"l|lit(?:er|re)s?"),
    "ounce": (2.957353e-5, r"(?:fl\.?\s*)?oz|(?:fluid )?ounces?"),
    "quart": (9.463529e-4, r"qt|quarts?"),
    "gallon": (3.785412e-3, r"gal|gallons?"),
}
# Standard deviations by which a word shifts the usual size; choices.
_SHIFTS = {
    "tiny": -1.5,
    "mini": -1.3,
    "miniature": -1.3,
    "small": -0.8,
    "little": -0.8,
    "travel": -0.8,
    "kids": -0.6,
    "espresso": -1.2,
    "demitasse": -1.2,
    "large": 0.8,
    "big": 0.8,
    "family": 0.8,
    "jumbo": 1.3,
    "giant": 1.5,
    "huge": 1.3,
    "xl": 1.0,
}


@dataclass(frozen=True)
class StatedSize:
    """Size that titles and prompts state.

    Attributes:
        lengths: of any side, metres. volumes: capacities, m^3.
        shift: in standard deviations of the usual size. words: phrases that these come from.
    """

    lengths: tuple[float, ...] = ()
    volumes: tuple[float, ...] = ()
    shift: float = 0.0
    words: tuple[str, ...] = ()


def parse_size_phrases(texts: Sequence[str]) -> StatedSize:
    """Parse titles and prompts, such as `Frypan 8"` or `a large 1.5 l pitcher`."""
    lengths: list[float] = []
    volumes: list[float] = []
    words: list[str] = []
    shift = 0.0
    for text in texts:
        lowered = text.lower()
        for values, table in ((lengths, _LENGTHS), (volumes, _VOLUMES)):
            for unit_size, pattern in table.values():
                for match in re.finditer(rf"{_NUMBER}[\s-]?(?:{pattern})(?!\w)", lowered):
                    values.append(float(match[1].replace(",", ".")) * unit_size)
                    words.append(match[0].strip())
        for word in re.findall(r"[a-z]+", lowered):
            if word in _SHIFTS and abs(_SHIFTS[word]) > abs(shift):
                shift = _SHIFTS[word]
                words.append(word)
    return StatedSize(
        tuple(v for v in dict.fromkeys(lengths) if v > 0),
        tuple(v for v in dict.fromkeys(volumes) if v > 0),
        shift,
        tuple(dict.fromkeys(words)),
    )
