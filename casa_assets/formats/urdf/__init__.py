"""Asset -> URDF package: one module per concept, the same names as in the other two writers.

In URDF the axis of a joint passes through the origin of the link that it moves. So the frame of a URDF link is at the
anchor of its joint, and the content of the link is shifted accordingly; if the anchor is zero, both frames are equal.
"""

from casa_assets.formats.urdf.document import write

__all__ = ["write"]
