"""Asset -> MJCF package: one module per concept, the same names as in the USD writer."""

from casa_assets.formats.mjcf.document import write

__all__ = ["write"]
