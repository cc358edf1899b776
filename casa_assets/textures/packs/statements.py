"""What files beside pictures say of them: lists of prompts, and the JSON of ambientCG and Poly Haven with sizes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

from pydantic import ValidationError

from casa_assets.errors import CasaError
from casa_assets.textures.packs.entry import PictureDescription
from casa_assets.textures.packs.naming import slug

# Names of lists of prompts: as users of generators write them, and as data sets of pictures have them.
PROMPT_LISTS = ("prompts.txt", "prompts.json", "prompts.jsonl", "prompts.csv", "metadata.jsonl", "metadata.csv")
_FILE_KEYS = ("file", "file_name", "filename", "image", "path")
_PROMPT_KEYS = ("prompt", "text", "caption", "description")
_MAX_PROMPT = 4000
# Units of the sizes that two libraries of textures state, metres.
AMBIENTCG_M, POLYHAVEN_M = 0.01, 0.001


def read_prompts(name: str, text: str, pictures: Sequence[str]) -> dict[str, str]:
    """Prompts of a list by the file that they belong to.

    Args:
        name: of the list, one of PROMPT_LISTS.
        text: its content. Of a .txt each line is `file: prompt`, or each is a prompt alone, in the order of the files.
        pictures: files in its folder, sorted.
    Raises:
        CasaError: it is not of its format, or has prompts alone and not as many as there are pictures.
    """
    if name.endswith(".txt"):
        return _prompts_of_lines(name, text, pictures)
    try:
        rows = list(_rows(name, text))
        found = {_value(row, _FILE_KEYS): _value(row, _PROMPT_KEYS) for row in rows}
    except (ValueError, TypeError, AttributeError, csv.Error, RecursionError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise CasaError(f"{name}: cannot be read: {first}") from None
    if rows and not all(found):
        keys = f"{', '.join(_FILE_KEYS[:3])} ... and {', '.join(_PROMPT_KEYS[:2])} ..."
        raise CasaError(f"{name}: a row names no file; it has to have a key each of {keys}")
    return {file: prompt[:_MAX_PROMPT] for file, prompt in found.items() if prompt}


def read_sizes(name: str, text: str) -> dict[str, PictureDescription]:
    """Sizes and authors that a JSON of ambientCG or Poly Haven states, by the slug of the material; none of others.

    Ref: ambientCG API v2 (`dimensionX`, `dimensionY`, centimetres), Poly Haven API (`dimensions`, millimetres).
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    found: dict[str, PictureDescription] = {}
    for material, row in _materials(PurePosixPath(name).stem, data):
        x, y = row.get("dimensionX"), row.get("dimensionY")
        unit, sides = AMBIENTCG_M, [x, y]
        if isinstance(listed := row.get("dimensions"), list):
            unit, sides = POLYHAVEN_M, listed[:2]
        size = _size(sides, unit)
        authors = row.get("authors")
        author = ", ".join(str(one) for one in authors) if isinstance(authors, dict | list) and authors else None
        if size is not None:
            try:
                found[slug(material)] = PictureDescription(tile_m=size, author=author)
            except ValidationError:
                continue
    return found


def _materials(stem: str, data: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The rows of materials in a JSON, by name: a list of them, one, or several by their names."""
    if not isinstance(data, dict):
        return
    if isinstance(listed := data.get("foundAssets"), list):
        rows = [row for row in listed if isinstance(row, dict)]
        yield from ((str(row.get("assetId")), row) for row in rows)
    elif "assetId" in data:
        yield str(data["assetId"]), data
    elif "dimensions" in data or "dimensionX" in data:
        yield stem, data
    else:
        yield from ((str(name), row) for name, row in data.items() if isinstance(row, dict))


def _size(sides: Sequence[Any], unit: float) -> tuple[float, float] | None:
    """Width and height in metres; None where they are not two numbers above 0."""
    try:
        width, height = (round(float(side) * unit, 6) for side in sides)
    except (TypeError, ValueError):
        return None
    return (width, height) if 0 < width <= 100 and 0 < height <= 100 else None


def _prompts_of_lines(name: str, text: str, pictures: Sequence[str]) -> dict[str, str]:
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    named = dict(parts for line in lines if (parts := _named(line, pictures)) is not None)
    if named and len(named) == len(lines):
        return named
    if named:
        odd = next(line for line in lines if _named(line, pictures) is None)
        raise CasaError(f"{name}: begin each line with its file, `file.png: prompt`, or none; {odd[:60]!r} has none")
    if len(lines) != len(pictures):
        message = (
            f"{len(lines)} prompts for {len(pictures)} pictures; begin each line with its file, `file.png: prompt`"
        )
        raise CasaError(f"{name}: {message}")
    return dict(zip(pictures, lines, strict=True))


def _named(line: str, pictures: Sequence[str]) -> tuple[str, str] | None:
    """File and prompt of a line that begins with one of the pictures; None where it does not."""
    for mark in (":", "\t", "|"):
        file, found, prompt = line.partition(mark)
        if found and (file.strip() in pictures or PurePosixPath(file.strip()).suffix.lower() in (".png", ".jpg")):
            return file.strip(), prompt.strip()[:_MAX_PROMPT]
    return None


def _rows(name: str, text: str) -> Iterator[Mapping[str, Any]]:
    if name.endswith(".csv"):
        yield from csv.DictReader(io.StringIO(text))
    elif name.endswith(".jsonl"):
        yield from (json.loads(line) for line in text.splitlines() if line.strip())
    else:
        data = json.loads(text)
        if isinstance(data, dict):
            yield from ({"file": file, "prompt": prompt} for file, prompt in data.items())
        else:
            yield from data


def _value(row: Mapping[str, Any], keys: Sequence[str]) -> str:
    """The first value of a row under one of these keys, on one line; empty where it has none."""
    found = next((row[key] for key in keys if row.get(key)), "")
    if isinstance(found, dict):  # {"a.png": {"prompt": "..."}}
        return _value(found, keys)
    return " ".join(str(found).split())
