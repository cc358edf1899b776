"""Tell from file names which maps of a material a folder or an archive holds, as ambientCG and Poly Haven call them.

`Bricks001_1K-JPG_Color.jpg`, `Bricks001_1K-JPG_NormalGL.jpg`; `brick_wall_diff_1k.jpg`, `brick_wall_nor_gl_1k.png`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from types import MappingProxyType


class MapRole(StrEnum):
    """What a map says of a surface.

    PACKED has the roughness in green and the metalness in blue: `arm` of Poly Haven, `orm`, metallic-roughness of glTF.
    OTHER is known and not used: ambient occlusion, opacity, emission, specular.
    """

    COLOR = "color"
    NORMAL_GL = "normal"
    NORMAL_DX = "normal_dx"
    ROUGHNESS = "roughness"
    METALNESS = "metalness"
    PACKED = "roughness_metalness"
    HEIGHT = "height"
    OTHER = "other"


_WORDS = {
    MapRole.COLOR: "color colour col albedo basecolor base_color diff diffuse",
    MapRole.NORMAL_GL: "normalgl normal_gl nor_gl normal nor nrm",
    MapRole.NORMAL_DX: "normaldx normal_dx nor_dx",
    MapRole.ROUGHNESS: "roughness rough",
    MapRole.METALNESS: "metalness metallic metal",
    MapRole.PACKED: "arm orm metallic_roughness metallicroughness",
    MapRole.HEIGHT: "displacement disp height bump",
    MapRole.OTHER: "ambientocclusion ambient_occlusion ao opacity emission emissive specular spec spec_ior preview",
}
_ROLES = {word: role for role, words in _WORDS.items() for word in words.split()}
_SUFFIX = re.compile(rf"^(.+?)[ _-]+({'|'.join(sorted(_ROLES, key=len, reverse=True))})$")
# A resolution, and the format that ambientCG writes behind it.
_RESOLUTION = re.compile(r"[ _-]\d{1,2}k(?:[ _-](?:jpe?g|png|exr|tiff?))?(?=$|[ _-])")


@dataclass(frozen=True)
class MaterialFiles:
    """The files of one material.

    Attributes:
        name: of the material, or of the picture that stands alone.
        maps: role -> file.
    """

    name: str
    maps: Mapping[MapRole, str]


def name_and_role(path: str) -> tuple[str, MapRole] | None:
    """The material that a file is a map of, in lower case, and which; None where its name does not say so."""
    stem = _RESOLUTION.sub("", PurePosixPath(path).stem.lower())
    found = _SUFFIX.match(stem)
    return (found[1], _ROLES[found[2]]) if found else None


def group_maps(paths: Iterable[str]) -> tuple[MaterialFiles, ...]:
    """Materials of files, in the order of their first files.

    Files of one folder are maps of one material where their names say so, and at least two do. Any other file is a
    picture of its own. A material without a colour has none among its maps. A picture that is called as a material and
    nothing else shows it on a ball, and is among the maps as OTHER.

    Args:
        paths: POSIX; sorted.
    """
    found: dict[tuple[str, str], dict[MapRole, str]] = {}
    listed = list(paths)
    for path in listed:
        if named := name_and_role(path):
            found.setdefault((_folder(path), named[0]), {}).setdefault(named[1], path)
    sets = {key: maps for key, maps in found.items() if len(maps) > 1}
    out: dict[str, MaterialFiles] = {}
    for path in listed:
        named = name_and_role(path)
        key = (_folder(path), named[0] if named else _RESOLUTION.sub("", PurePosixPath(path).stem.lower()))
        if key not in sets:
            name = PurePosixPath(path).stem
            out[path] = MaterialFiles(name, MappingProxyType({MapRole.COLOR: path}))
        else:
            first = next(iter(sets[key].values()))
            out[first] = MaterialFiles(key[1], MappingProxyType(sets[key]))
    return tuple(sorted(out.values(), key=lambda files: listed.index(next(iter(files.maps.values())))))


def _folder(path: str) -> str:
    return PurePosixPath(path).parent.as_posix()
