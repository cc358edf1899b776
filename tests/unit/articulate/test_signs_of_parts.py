"""What speaks for moving parts of a mesh in which none was found: its kind, names, handles, lines and small pieces."""

from __future__ import annotations

import pytest

from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.unfound_parts import signs_of_parts
from tests.unit.articulate.blocks import Part, box, disc, together
from tests.unit.articulate.fragmented import in_its_frame

pytestmark = pytest.mark.content("code", "articulate", keep=0)


def signs(*parts: Part, kind: str = "", names: tuple[str, ...] = ()) -> str:
    return "; ".join(signs_of_parts(in_its_frame(*together(*parts)[:2])[0], kind, names, load_models()))


CASE = box((0.0, 0.0, 0.0), (0.6, 0.5, 0.8))


def test_a_plain_box_has_none() -> None:
    assert signs(CASE) == ""
    assert signs(CASE, kind="table", names=("Cube.001", "Material")) == ""


@pytest.mark.parametrize(
    ("kind", "names", "word"), [("wardrobe", (), "wardrobe"), ("", ("Door_L", "DoorKnobs"), "door, knob")]
)
def test_its_kind_and_names_in_the_file_are_signs(kind: str, names: tuple[str, ...], word: str) -> None:
    assert word in signs(CASE, kind=kind, names=names)


def test_a_bar_that_stands_out_of_any_side_is_one() -> None:
    side = box((0.6, 0.2, 0.3), (0.64, 0.22, 0.55))
    assert "right side stands out like a handle" in signs(CASE, side)


def test_what_is_not_boxy_has_no_sign_but_its_name() -> None:
    mug = disc((0.0, 0.0, 0.0), 0.04, 0.1, 48)
    handle = box((0.04, 0.03, -0.005), (0.07, 0.07, 0.005))
    assert signs(mug, handle, names=("mug_handle",)) == ""


def test_a_lever_on_the_end_of_a_round_post_is_one() -> None:
    post, hub = disc((0.0, 0.0, 0.0), 0.04, 0.3), disc((0.0, -0.08, 0.0), 0.08, 0.08)
    stick = box((-0.02, -0.06, 0.07), (0.02, -0.02, 0.45))
    assert "a lever stands out" in signs(post, hub, stick)
    assert signs(post, hub) == ""


def test_the_handle_of_a_pan_is_none() -> None:
    foot, rim = disc((0.0, 0.0, 0.0), 0.12, 0.01), disc((0.0, -0.05, 0.0), 0.14, 0.05)
    handle = box((-0.015, -0.04, 0.139), (0.015, -0.02, 0.35))
    assert signs(foot, rim, handle) == ""


def window(*sashes: tuple[float, float]) -> list[Part]:
    """A frame 0.8 wide and 1.2 high, and panes over its width from one height to another."""
    return [
        box((0.0, 0.0, 0.0), (0.8, 0.06, 1.2)),
        *(box((0.06, -0.01, low), (0.74, 0.02, high)) for low, high in sashes),
    ]


def test_sashes_side_by_side_in_a_frame_are_one_and_a_picture_in_its_frame_is_not() -> None:
    assert "sashes of a window" in signs(*window((0.05, 0.6), (0.62, 1.15)))
    assert "sashes" not in signs(*window((0.05, 1.15)))
