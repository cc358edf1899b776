"""Assets, kitchens and their batch form -> MJCF; the same names as in the USD writer."""

from casa_assets.formats.mjcf.document import write

__all__ = ["write"]
