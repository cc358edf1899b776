"""Read what was meant: lengths in any unit, and words that are not those of the plan language."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

from casa_assets.projects import read_once
from casa_assets.registry.layered import read_topmost

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
_UNITS = {
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters", "mtr"), "m"),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), "cm"),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), "mm"),
    **dict.fromkeys(("in", "inch", "inches", '"', "''", "″"), "in"),
    **dict.fromkeys(("ft", "foot", "feet", "'", "′"), "ft"),
}
_NUMBER = r"(\d+(?:[.,]\d+)?(?:\s*/\s*\d+)?)"
_PART = re.compile(_NUMBER + r"\s*(" + "|".join(sorted(map(re.escape, _UNITS), key=len, reverse=True)) + r")?(?![a-z])")
_SUFFIX = re.compile(r"^(.*?)_?(?:in_)?(m|cm|mm|in|ft|meters|metres|inches|feet)$")


@read_once
def plan_words() -> Mapping[str, Any]:
    """Tables of registry/plan_words.yaml by their name. Raises RegistryError."""
    tables: Mapping[str, Any] = read_topmost("plan_words.yaml").value
    return tables


def spelt(word: str) -> str:
    """A word as ids are spelt: small letters, numbers and underscores."""
    parts = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", word.strip())
    return re.sub(r"_+", "_", re.sub(r"[^a-z0-9]+", "_", parts.lower())).strip("_")


def meant(word: str, known: Iterable[str], table: str = "", cutoff: float = 0.6) -> str | None:
    """The known word that is meant: spelt otherwise, another word for it, or the nearest; None where none is near."""
    names = list(known)
    same = spelt(word)
    for said in (same, same.removesuffix("s"), f"{same}s", re.sub(r"_\d+$", "", same)):
        if said in names:
            return said
        other = plan_words()[table].get(said) if table else None
        if other in names:
            return str(other)
    near = difflib.get_close_matches(same, names, n=1, cutoff=cutoff)
    if near:
        return near[0]
    others = {k: v for k, v in (plan_words()[table] if table else {}).items() if v in names}
    far = difflib.get_close_matches(same, list(others), n=1, cutoff=max(cutoff, 0.75))
    return str(others[far[0]]) if far else None


def length_of(text: str) -> float | None:
    """Metres of a length as people write it, such as `420 cm`, `4,2 m` or `13'9"`; None where it is none.

    A number without a unit is returned as it is; `plausible` guesses its unit.
    """
    said = re.sub(r"^(about|approx\.?|approximately|ca\.?|circa|~|≈|=)\s*", "", text.strip().lower())
    parts = list(_PART.finditer(said))
    if not parts or _PART.sub("", said).strip(" .,-") not in ("", "and", "wide", "long", "deep", "high"):
        return None
    total = 0.0
    for n, part in enumerate(parts):
        unit = _UNITS.get(part[2] or "", "in" if n and _UNITS.get(parts[0][2] or "") == "ft" else "")
        number, _, divisor = part[1].replace(",", ".").partition("/")
        value = float(number) / float(divisor) if divisor.strip() and float(divisor) else float(number)
        total += value * METRES.get(unit, 1.0)
    return round(total, 3)


def plausible(value: float, low: float, high: float) -> float | None:
    """Metres of a number that is too large for metres, as centimetres, millimetres or inches; None if none fits."""
    for unit in ("cm", "mm", "in"):
        metres = round(value * METRES[unit], 3)
        if low <= metres <= high and metres > 0:
            return metres
    return None


def key_and_unit(key: str) -> tuple[str, str] | None:
    """A key and the unit in its name, such as (`length`, `cm`) of `length_cm`; None where it names none."""
    found = _SUFFIX.match(spelt(key))
    if not found or not found[1]:
        return None
    return found[1].rstrip("_"), _UNITS[found[2]]
