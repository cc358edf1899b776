"""Read registry/ and the project laid over it: YAML into frozen records; errors name file, line and pointer."""

from casa_assets.model.registry.category import FALLBACK
from casa_assets.projects import data_root
from casa_assets.registry.load import FILES, Registry, learned_forest, load, load_confidence
from casa_assets.registry.read import read_document, read_record

__all__ = [
    "FALLBACK",
    "FILES",
    "Registry",
    "data_root",
    "learned_forest",
    "load",
    "load_confidence",
    "read_document",
    "read_record",
]
