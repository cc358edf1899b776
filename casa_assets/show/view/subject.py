"""Subjects that `casa-assets view` shows: a folder, a file, an id, a kitchen's id, a preset or a category."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from casa_assets.core.system import cache_dir, cache_for
from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.families.build import FamilyRequest, params_of
from casa_assets.formats.mjcf.kitchen import FILE as SCENE_XML
from casa_assets.formats.read.formats import SUFFIXES
from casa_assets.layouts.run.recipe import SceneRecipe, recipe_of
from casa_assets.library.entry_files import CERTIFICATE
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.files import SCENE_JSON
from casa_assets.registry.families import family, family_names, object_names
from casa_assets.registry.kitchens import plan_names, style_names

# The libraries that the commands write where no other is named, in the order in which an id is looked for.
LIBRARIES = tuple(Path("out") / name for name in ("library", "articulated", "families", "objects"))
ASSET_XML = "model.xml"
# Of a folder with more assets than this some are named.
MAX_NAMED = 6


@dataclass(frozen=True)
class AssetFolder:
    """An asset on disk, with its record in asset.json."""

    folder: Path

    @property
    def id(self) -> str:
        """Name of the folder: the asset's id."""
        return self.folder.absolute().name


@dataclass(frozen=True)
class Loaded:
    """An asset in memory."""

    asset: Asset

    @property
    def id(self) -> str:
        """Its id."""
        return self.asset.id


@dataclass(frozen=True)
class Member:
    """A preset of a family, or a draw of a category of objects; it has no folder."""

    request: FamilyRequest

    @property
    def id(self) -> str:
        """Such as `microwave/steel` or `apple/#0`."""
        return self.request.title


@dataclass(frozen=True)
class Kitchen:
    """A kitchen by its recipe, in a folder of scenes or to be built there.

    `is_named_by_path`: its files were named instead of its id, so that MuJoCo shows them whoever made them.
    """

    recipe: SceneRecipe
    place: Path
    is_named_by_path: bool = False

    @property
    def id(self) -> str:
        """Its id."""
        return self.recipe.scene_id

    @property
    def folder(self) -> Path:
        """Its folder, which need not exist."""
        return self.place / self.id


@dataclass(frozen=True)
class ModelFile:
    """An MJCF file without a record of this program: MuJoCo can show it, the page cannot. `why`: reason, in words."""

    path: Path
    why: str = f"no {SCENE_JSON} of a scene and no {CERTIFICATE} of an asset stands beside it"

    @property
    def id(self) -> str:
        """Its path."""
        return str(self.path)


Subject = AssetFolder | Loaded | Member | Kitchen | ModelFile


def find(what: str, scenes: Path, libraries: Sequence[Path] = LIBRARIES) -> Subject:
    """The subject with that name: a path that exists, else an id in a library, a kitchen, a family or an object.

    Args:
        what: also `microwave/steel`, a preset (else the first), and `apple/3`, a draw of a category (else 0).
        scenes: folder of kitchens. libraries: folders; those that do not exist are skipped.
    Raises:
        OutputError: the path holds no asset and no scene. UnknownId: nothing has this name; it names the nearest.
        CasaError: the finishes of a kitchen's id cannot be found.
    """
    path = Path(what).expanduser()
    if path.is_dir():
        return _in_folder(path)
    if path.is_file():
        return _of_file(path)
    if path.is_absolute() or what.startswith(("./", "../", "~")):
        raise OutputError(what, "there is no such file or folder")
    ids = {folder.name: folder for root in reversed(libraries) for folder in _assets_of(root)}
    if what in ids:
        return AssetFolder(ids[what])
    if "__" in what:
        return Kitchen(recipe_of(what, (scenes,)), scenes)
    name, _, member = what.partition("/")
    if name in family_names():
        request = FamilyRequest(name, preset=member or next(iter(family(name).presets)))
        params_of(request)  # raises UnknownId
        return Member(request)
    if name in object_names():
        number = re.fullmatch(r"#?(\d{1,6})", member or "0")
        if number is None:
            raise UnknownId(f"member of {name}", what, [f"{name}/{i}" for i in range(3)])
        return Member(FamilyRequest(name, index=int(number[1]), is_object=True))
    kitchens = [f"{plan}__{style}" for plan in plan_names() for style in style_names()]
    names = [*ids, *kitchens, *family_names(), *object_names()]
    raise UnknownId(
        "kitchen, asset or file", what, names, "`casa-assets scenes list` and `casa-assets find` list what there is"
    )


def cache_of(subject: Subject) -> Path:
    """Folder of the store of built assets, which a run that writes kitchens to the same place uses, too."""
    return cache_for(subject.place) if isinstance(subject, Kitchen) else cache_dir()


def _in_folder(folder: Path) -> Subject:
    if (folder / SCENE_JSON).is_file():
        return _scene(folder)
    if (folder / CERTIFICATE).is_file():
        return AssetFolder(folder)
    for name in (SCENE_XML, ASSET_XML):
        if (folder / name).is_file():
            return ModelFile(folder / name)
    found = list(_assets_of(folder))
    if len(found) == 1:
        return AssetFolder(found[0])
    if found:
        some = ", ".join(sorted(f.name for f in found)[:MAX_NAMED])
        more = f" and {len(found) - MAX_NAMED} more" if len(found) > MAX_NAMED else ""
        raise OutputError(str(folder), f"is a library; name one of its assets: {some}{more}")
    scenes = sorted(path.parent.name for path in folder.glob(f"*/{SCENE_JSON}"))
    if scenes:
        raise OutputError(str(folder), f"is a folder of scenes; name one of them: {', '.join(scenes[:MAX_NAMED])}")
    raise OutputError(str(folder), f"holds no asset and no scene; name a folder with {ASSET_XML} or {SCENE_XML}")


def _scene(folder: Path) -> Subject:
    """A scene by its folder, whose name is its id; its MJCF alone where that names no recipe of this version."""
    place = folder.absolute().parent
    try:
        return Kitchen(recipe_of(folder.absolute().name, (place,)), place, is_named_by_path=True)
    except CasaError as error:
        if (folder / SCENE_XML).is_file():
            return ModelFile(folder / SCENE_XML, str(error))
        raise


def _of_file(path: Path) -> Subject:
    suffix = path.suffix.lower()
    if suffix == ".xml":
        beside = path.parent
        is_ours = (beside / SCENE_JSON).is_file() or (beside / CERTIFICATE).is_file()
        return _in_folder(beside) if is_ours else ModelFile(path)
    if suffix in SUFFIXES:
        raise OutputError(
            str(path),
            "is a mesh; make an asset of it first: "
            f"casa-assets ingest {shlex.quote(str(path))} (or casa-assets articulate)",
        )
    raise OutputError(str(path), "is no MJCF; name the folder of an asset or of a scene, or its XML file")


def _assets_of(root: Path) -> Iterator[Path]:
    return Library(root).accepted() if root.is_dir() else iter(())
