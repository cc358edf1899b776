"""Read what scripts in benchmarks/ have learned: the files of registry/learned/."""

from __future__ import annotations

import json
from functools import lru_cache

from casa_assets.core.forest import Forest, forest_from_dict
from casa_assets.errors import RegistryError
from casa_assets.projects import data_root
from casa_assets.registry.load import LEARNED


@lru_cache(maxsize=8)
def learned_forest(name: str) -> Forest:
    """Return the forest of `registry/learned/<name>.json`. Raises RegistryError where it is missing or unsound."""
    path = data_root() / LEARNED / f"{name}.json"
    try:
        return forest_from_dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise RegistryError(f"{LEARNED}/{path.name}", 1, "", "a forest", str(error)) from None
