"""Read and write files of plans."""

from __future__ import annotations

from pathlib import Path

from casa_assets.errors import OutputError, RegistryError


def read_plan_text(path: Path) -> str:
    """The text of a file. Raises RegistryError where it is not UTF-8 or cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RegistryError(path.name, 1, "", "YAML in UTF-8", str(error)) from None
    except OSError as error:
        raise RegistryError(path.name, 1, "", "a readable file", error.strerror or str(error)) from None


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet. Raises OutputError where it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise OutputError(str(path), "is there already; name another file") from None
