"""Read `casa.yaml` of the project in use, and find out whether rows and files come from it or from the package."""

from __future__ import annotations

from casa_assets.model.registry.document import Document
from casa_assets.model.registry.project import Project
from casa_assets.projects import SETTINGS, project_folder, read_once
from casa_assets.registry.layered import read_table_file, read_topmost
from casa_assets.registry.project_files import check_names
from casa_assets.registry.read import read_document, read_record

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


def origin_of_file(name: str) -> str:
    """Where a file that is one thing, such as `plans/galley.yaml`, comes from: see `origin`."""
    return origin(read_topmost(name).file)


def origin(file: str) -> str:
    """Where a thing comes from, by the name of the file that states it: the name of the project, or of this package."""
    loaded = load_project()
    return loaded[0].name if loaded is not None and file.startswith(f"{project_folder()}/") else PACKAGE
