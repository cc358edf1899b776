"""Read registry/ and the project laid over it: YAML into frozen records; errors name file, line and pointer."""

from casa_assets.model.registry.category import FALLBACK as FALLBACK
from casa_assets.projects import data_root as data_root
from casa_assets.registry.load import FILES as FILES
from casa_assets.registry.load import Registry as Registry
from casa_assets.registry.load import learned_forest as learned_forest
from casa_assets.registry.load import load as load
from casa_assets.registry.load import load_confidence as load_confidence
from casa_assets.registry.read import read_document as read_document
from casa_assets.registry.read import read_record as read_record
