"""The models learned from labelled cases, which the caller reads from the registry and hands in."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.core.forest import Forest


@dataclass(frozen=True)
class Models:
    """Decision forests, used where rules decide less well.

    Attributes:
        controls: distinguishes knobs, keys and neither, from CONTROL_FEATURES; None to look at each control alone.
        fronts_alone, fronts: decide whether a rectangle of a fused shell is a door or drawer, from FEATURES of
            fronts/front_hypotheses.py alone, and with CONTEXT; None if rules decide.
    """

    controls: Forest | None = None
    fronts_alone: Forest | None = None
    fronts: Forest | None = None

    @property
    def front_forests(self) -> tuple[Forest, Forest] | None:
        """Return the two forests of fronts, or None if one is missing."""
        return None if self.fronts_alone is None or self.fronts is None else (self.fronts_alone, self.fronts)
