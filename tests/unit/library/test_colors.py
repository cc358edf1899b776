"""Colours by area: names that a person would use, and gaps that tell prints apart but not copies."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.library.pairs import color_distance, color_histogram
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from tests.support.asset.assets import ball, textured_box
from tests.support.mesh.meshes import texture


def painted(red: float, green: float, blue: float) -> Asset:
    """The ball in one colour, as displayed, 0..1."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
    asset = ball()
    looks = tuple(Material(id=m.id, base_color=(*linear, 1.0)) for m in asset.materials)
    return asset.replace(materials=looks)


def printed(*colors: tuple[int, int, int]) -> Asset:
    """The box with stripes of these colours all over."""
    pixels = np.repeat(np.array(colors, dtype=np.uint8)[None], 8, axis=0).repeat(8, axis=1)
    asset = textured_box()
    skin = texture("stripes", pixels)
    looks = tuple(Material(id=m.id, base_color=(1.0, 1.0, 1.0, 1.0), base_color_texture=skin) for m in asset.materials)
    return asset.replace(materials=looks)


def test_colours_have_their_names(subtests: pytest.Subtests) -> None:
    for color, name in [
        ((0.8, 0.1, 0.1), "red"),
        ((1.0, 0.5, 0.0), "orange"),
        ((1.0, 0.9, 0.1), "yellow"),
        ((0.1, 0.6, 0.2), "green"),
        ((0.1, 0.7, 0.75), "turquoise"),
        ((0.1, 0.2, 0.8), "blue"),
        ((0.5, 0.1, 0.6), "purple"),
        ((1.0, 0.6, 0.7), "pink"),
        ((0.4, 0.22, 0.08), "brown"),
        ((0.87, 0.8, 0.68), "beige"),
        ((0.5, 0.5, 0.5), "grey"),
        ((0.05, 0.05, 0.05), "black"),
        ((0.97, 0.97, 0.97), "white"),
    ]:
        with subtests.test(color=color, name=name):
            assert color_histogram(painted(*color)).names == ((name, 1.0),)


def test_pictures_are_looked_up_and_shares_are_by_area() -> None:
    found = color_histogram(printed((255, 0, 0), (255, 255, 255), (255, 255, 255), (255, 255, 255)))
    assert [name for name, _ in found.names] == ["white", "red"]
    assert dict(found.names)["red"] == pytest.approx(0.25, abs=0.03)
    assert found.stated


def test_another_print_is_farther_than_another_order_of_the_same() -> None:
    one, same = printed((255, 0, 0), (255, 255, 255)), printed((255, 255, 255), (255, 0, 0))
    other = printed((0, 0, 255), (255, 255, 255))
    assert color_distance(color_histogram(one), color_histogram(same)) < 1.0
    assert color_distance(color_histogram(one), color_histogram(other)) > 10.0
