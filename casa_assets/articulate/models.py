"""What was learned from labelled cases, handed in by whoever reads the registry."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.core.forest import Forest


@dataclass(frozen=True)
class Models:
    """Forests that decide where rules decide worse.

    Attributes:
        controls: tells knobs, keys and neither, from CONTROL_FEATURES; None to look at each control alone.
    """

    controls: Forest | None = None
