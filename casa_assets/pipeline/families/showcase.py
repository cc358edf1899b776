"""Pictures of a built member: closed, in each of its named poses, and as it is touched."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from casa_assets.preview.still import poses, render
from casa_assets.preview.studio import View


def pictures(folder: Path, out: Path, stem: str, size_px: int) -> Iterator[Path]:
    """Write `<stem>_closed.png`, one picture for each named pose, and `<stem>_touch.png`.

    Args:
        folder: of the asset. out: for the pictures. size_px: width and height.
    """
    model = folder / "model.xml"
    view = View(size_px=size_px, passes=12)
    shots = [("closed", "", False), *((p, p, False) for p in poses(model) if p != "closed"), ("touch", "", True)]
    for name, pose, touched in shots:
        path = out / f"{stem}_{name}.png"
        path.write_bytes(render(model, view, touched, pose))
        yield path
