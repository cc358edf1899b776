"""registry/roles.yaml: which assets of libraries a plan may use as its range, fridge, toaster and so on."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.model.registry.role import RoleRule
from casa_assets.projects import read_once
from casa_assets.registry.layered import read_table_file
from casa_assets.registry.read import read_table

FILE = "roles.yaml"


@read_once
def load_roles() -> Mapping[str, RoleRule]:
    """Rules of the roles by id, those of the project over those of the package. Raises RegistryError."""
    return read_table(RoleRule, read_table_file(FILE))
