"""Sashes: a frame of stiles and rails round panes of glass, divided by bars."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.solids.blocks import board

GLASS_THICKNESS = 0.004  # metres
GLAZING_BAR_WIDTH = 0.02


def add_sash(
    builder: AssetBuilder,
    link: str,
    size: tuple[float, float, float],
    *,
    stile: float,
    grid: tuple[int, int],
    finish: str,
    glass: str,
    name: str,
    label: str = "window",
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> None:
    """Put a sash on a link: its lower left front corner at `at`, with one box as collider.

    Args:
        size: width, depth (towards +y), height, metres. stile: width of the frame's boards.
        grid: columns and rows of panes. name: of its collider and of its mesh.
    """
    w, d, h = size
    e = 0.002
    sides = [board((0, 0, 0), (stile, d, h), e), board((w - stile, 0, 0), (w, d, h), e)]
    for solid in sides:
        builder.add(link, solid.translated(*at), finish, label=label, collider=False)
    for z in (0.0, h - stile):
        rail = board((stile - 5e-4, 2e-4, z), (w - stile + 5e-4, d - 2e-4, z + stile), e)
        builder.add(link, rail.translated(*at), finish, label=label, collider=False, grain=(1.0, 0.0, 0.0))
    pane = board(
        (stile - 0.004, d / 2 - GLASS_THICKNESS / 2, stile - 0.004),
        (w - stile + 0.004, d / 2 + GLASS_THICKNESS / 2, h - stile + 0.004),
        0.0,
    )
    builder.add(link, pane.translated(*at), glass, label="glass", collider=False)
    columns, rows = grid
    y0, y1 = d / 2 - 0.011, d / 2 + 0.011
    for k in range(1, columns):
        x = stile + (w - 2 * stile) * k / columns
        bar = board((x - GLAZING_BAR_WIDTH / 2, y0, stile - 5e-4), (x + GLAZING_BAR_WIDTH / 2, y1, h - stile + 5e-4), e)
        builder.add(link, bar.translated(*at), finish, label=label, collider=False)
    for k in range(1, rows):
        z = stile + (h - 2 * stile) * k / rows
        bar = board(
            (stile - 5e-4, y0 + 4e-4, z - GLAZING_BAR_WIDTH / 2),
            (w - stile + 5e-4, y1 - 4e-4, z + GLAZING_BAR_WIDTH / 2),
            e,
        )
        builder.add(link, bar.translated(*at), finish, label=label, collider=False, grain=(1.0, 0.0, 0.0))
    builder.add_collider(link, board((0, 0, 0), (w, d, h), 0.0).translated(*at), finish, label, name)
