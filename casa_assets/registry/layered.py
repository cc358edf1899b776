"""Read registry files in layers: those of the package, and those of the project in use laid over them."""

from __future__ import annotations

from pathlib import Path

from casa_assets.model.registry.document import Document
from casa_assets.model.registry.rows import Project
from casa_assets.projects import SETTINGS, layers, project_folder, read_once
from casa_assets.registry.project_files import check_names
from casa_assets.registry.read import read_document, read_record

# Layered --------------------------------------------------------------------------------------------------------------
# Those of the package, and those of the project in use laid over them.
#
# Tables (a file that maps ids to rows) are joined key by key. A file that is one thing, such as a plan, is taken whole
# from the topmost layer that has it.


def read_table_file(name: str, root: Path | None = None) -> Document:
    """A table of all layers, such as `categories.yaml` or `families/hob.yaml`; a layer need not have it.

    Args:
        root: the only folder to read; None reads the package's and the project's.
    Raises:
        RegistryError: no layer has it, or one is no YAML.
    """
    return _table(name) if root is None else _read(root / name, name, in_project=False)


def read_topmost(name: str, below: Path | None = None) -> Document:
    """A file that is one thing, such as `plans/galley.yaml`, of the topmost layer that has it. Raises RegistryError.

    Args:
        below: a layer; only those below it are looked at.
    """
    folders = layers() if below is None else layers()[: layers().index(below)]
    found = [folder for folder in folders if (folder / name).is_file()] or [layers()[0]]
    return _read(found[-1] / name, name, in_project=found[-1] == project_folder())


def stated_in(name: str, root: Path | None = None) -> tuple[Path, ...]:
    """The files that state a table or a thing, of the lowest layer first."""
    places = layers() if root is None else (root,)
    return tuple(place / name for place in places if (place / name).is_file())


def names_in(folder: str, root: Path | None = None) -> tuple[str, ...]:
    """Stems of the YAML files in a folder of any layer, sorted."""
    places = layers() if root is None else (root,)
    return tuple(sorted({path.stem for place in places for path in (place / folder).glob("*.yaml")}))


@read_once
def _table(name: str) -> Document:
    found = [folder for folder in layers() if (folder / name).is_file()] or [layers()[0]]
    lowest, *above = (_read(folder / name, name, in_project=folder == project_folder()) for folder in found)
    for document in above:
        lowest = lowest.overlaid(document)
    return lowest


def _read(path: Path, name: str, *, in_project: bool) -> Document:
    """A file, under the name that messages give it: its path for a project, otherwise that below registry/."""
    return read_document(path, str(path) if in_project else name)


# Project --------------------------------------------------------------------------------------------------------------
# Read `casa.yaml` of the project in use, and find out whether rows and files come from it or from the package.

PACKAGE = "casa-assets"  # where what is of no project comes from


@read_once
def load_project() -> tuple[Project, Document] | None:
    """The project in use and its document; None if no project is in use.

    Raises:
        RegistryError: its `casa.yaml` is wrong, or a file has nearly the name of one that would be read.
    """
    folder = project_folder()
    if folder is None:
        return None
    check_names(folder)
    path = folder / SETTINGS
    document = read_document(path, str(path))
    return read_record(Project, document.value, document, ()), document


def origin_of_row(table: str, *path: str) -> str:
    """Where the row of a table comes from, or has been changed last: see `origin`."""
    return origin(read_table_file(table).file_of(path))


def origin(file: str) -> str:
    """Where a thing comes from, by the name of the file that states it: the name of the project, or of this package."""
    loaded = load_project()
    return loaded[0].name if loaded is not None and file.startswith(f"{project_folder()}/") else PACKAGE
