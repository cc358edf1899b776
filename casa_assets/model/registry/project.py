"""The content of a project's `casa.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from casa_assets.model.record import Id, Record

# Words of a command, such as `ingest` or `scenes build`.
CommandName = Annotated[str, StringConstraints(pattern=r"^[a-z]+( [a-z-]+)?$")]
# Values of arguments and options of a command, by their names without `--`.
Values = Mapping[str, Any]


class Project(Record):
    """A folder with a user's plans, styles, categories and so on, merged over those of the package.

    Attributes:
        name: name in lists.
        about: one sentence.
        libraries: folders of libraries, relative to the project, whose assets styles may name as `library:<id>`.
        runs: steps of `casa-assets make`, in this order: a command -> the values of its arguments and options.
    """

    name: Id
    about: str = ""
    libraries: tuple[str, ...] = ()
    runs: tuple[Annotated[Mapping[CommandName, Values | None], Field(min_length=1, max_length=1)], ...] = ()
