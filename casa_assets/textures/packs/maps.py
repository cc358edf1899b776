"""Recognise by file names which maps of a material a folder holds: `brick_color.jpg`, `brick_normal.png` and so on."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from types import MappingProxyType


class MapRole(StrEnum):
    """Quantity that a map gives for a surface; its file's name ends with it. Normals have y up, as in OpenGL."""

    COLOR = "color"
    NORMAL = "normal"
    ROUGHNESS = "roughness"
    METALNESS = "metalness"
    HEIGHT = "height"


_SUFFIX = re.compile(rf"^(.+)_({'|'.join(MapRole)})$")


@dataclass(frozen=True)
class MaterialFiles:
    """The files of one material.

    Attributes:
        name: of the material, or of a picture that is a single file.
        maps: role -> file.
    """

    name: str
    maps: Mapping[MapRole, str]


def name_and_role(path: str) -> tuple[str, MapRole] | None:
    """The material that a file is a map of, in lower case, and which map; None if its name does not say so."""
    found = _SUFFIX.match(PurePosixPath(path).stem.lower())
    return (found[1], MapRole(found[2])) if found else None


def group_maps(paths: Iterable[str]) -> tuple[MaterialFiles, ...]:
    """Materials that files belong to, in the order of their first files.

    Files of one folder are maps of one material if their names say so and at least two do. Any other file is a separate
    picture. A material without a colour map has no entry for it.

    Args:
        paths: POSIX; sorted.
    """
    listed = list(paths)
    found: dict[tuple[str, str], dict[MapRole, str]] = {}
    for path in listed:
        if named := name_and_role(path):
            found.setdefault((_folder(path), named[0]), {}).setdefault(named[1], path)
    out: dict[str, MaterialFiles] = {}
    for path in listed:
        named = name_and_role(path)
        maps = found[_folder(path), named[0]] if named else {}
        if named and len(maps) > 1:
            out[next(iter(maps.values()))] = MaterialFiles(named[0], MappingProxyType(maps))
        else:
            out[path] = MaterialFiles(PurePosixPath(path).stem, MappingProxyType({MapRole.COLOR: path}))
    return tuple(out[path] for path in listed if path in out)


def _folder(path: str) -> str:
    return PurePosixPath(path).parent.as_posix()
