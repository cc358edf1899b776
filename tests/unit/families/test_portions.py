"""What is cut: bodies stay closed, faces lie on their planes, portions weigh what they should and say what they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.core.numeric import rng_for
from casa_assets.formats.mjcf import document
from casa_assets.kitchenware.objects.closed_surface import across, along, cut, sector, shell, smooth_profile, turned
from casa_assets.kitchenware.objects.produce import Face, Produce, rest_tilt
from casa_assets.model.registry.category import Portion
from casa_assets.registry.families import object_family
from tests.support.asset.family_members import available
from tests.unit.families.test_objects import is_closed, supplies

pytestmark = pytest.mark.content("code", "families", keep=0)

HEIGHT = 0.09
PROFILE = smooth_profile([(0.0, 0.0), (0.03, 0.01), (0.04, 0.05), (0.0, HEIGHT)], 17)
BODY = turned(PROFILE, 24)
MIDDLE = np.array([0.0, 0.0, HEIGHT / 2])


def test_halves_and_wedges_have_their_share_of_the_volume_and_stay_closed() -> None:
    for planes, share in (([along(0.4, MIDDLE)], 0.5), (sector(0.9, MIDDLE), 0.9 / (2 * np.pi))):
        kept, faces = cut(BODY, planes)
        assert kept.volume / BODY.volume == pytest.approx(share, rel=0.02)
        assert len(faces) == len(planes)
        assert all(is_closed(solid) and solid.volume > 0 for solid in (kept, *faces))


def test_a_face_lies_on_its_plane_within_the_outline_and_its_picture_fills_the_disc() -> None:
    kept, (face,) = cut(BODY, [across(0.04, below=True)])
    assert kept.points[:, 2].max() == pytest.approx(0.04)
    assert np.abs(face.points[:, 2] - 0.04).max() < 0.001
    assert np.hypot(*face.points[:, :2].T).max() < np.hypot(*kept.points[:, :2].T).max()
    assert face.picture_uv is not None
    off = np.hypot(*(face.picture_uv.reshape(-1, 2) - 0.5).T)
    assert off.max() == pytest.approx(0.49, abs=1e-3)
    assert off.min() == pytest.approx(0.0, abs=1e-6)


def test_a_hollow_leaves_a_ring_and_a_cut_that_misses_is_told() -> None:
    hollow = replace(BODY, points=MIDDLE + 0.8 * (BODY.points - MIDDLE))
    kept, (face,) = cut(BODY, [along(0.0, MIDDLE)], hollow)
    assert kept.volume == pytest.approx(0.5 * (BODY.volume - hollow.volume), rel=0.02)
    rim = np.linalg.norm(face.points - MIDDLE, axis=1)
    assert rim.min() > 0.015
    lining = shell(replace(BODY, points=MIDDLE + 0.81 * (BODY.points - MIDDLE)), hollow, [along(0.0, MIDDLE)])
    assert is_closed(lining)
    with pytest.raises(ValueError, match="leave nothing"):
        cut(BODY, [across(-0.01, below=True)])
    with pytest.raises(ValueError, match="does not meet"):
        cut(BODY, [across(0.2, below=True)])


def test_portions_lie_on_the_ground_and_say_what_they_are() -> None:
    pear = object_family("pear")
    whole = pear.draw(rng_for(0, "x"), available()).replace(bend=0.0, portion=None)
    mass = pear.build(whole, supplies("pear", whole)).mass
    for portion, crosswise in [*((p, False) for p in Portion), (Portion.HALF, True)]:
        for face in list(Face):
            cut_as = {"portion": portion, "crosswise": crosswise, "face": face}
            params = whole.replace(section="section_pear", **cut_as)
            asset = pear.build(params, supplies("pear", params))
            assert asset.mass < mass
            assert asset.labels.portion is portion
            assert asset.labels.to_json().count("portion") == 1
            assert document.label_texts(asset)["portion"] == portion.value
            assert abs(float(asset.bounds[0, 2])) < 1e-6


def test_a_half_that_lies_on_its_side_rolls_to_where_its_mass_is_lowest() -> None:
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 41)
    ball = turned(0.04 * np.column_stack([np.cos(tilt) * (np.abs(tilt) < 1.57), np.sin(tilt)]), 60)
    half, _ = cut(ball, [across(0.0, below=True)])
    level = replace(half, points=half.points[:, [2, 0, 1]])
    # A hemisphere comes to rest with its face up; its face looked to +x before.
    assert np.degrees(rest_tilt(level)) == pytest.approx(-90.0, abs=8.0)
    assert rest_tilt(half.rotated("x", np.pi)) == pytest.approx(0.0, abs=1e-6), "on its face it is at rest"


def test_a_portion_needs_a_picture_of_its_section_and_a_whole_thing_says_nothing() -> None:
    with pytest.raises(ValidationError, match="a section is expected"):
        Produce(profile=((0, 0), (1, 0.3), (1, 0.7), (0, 1)), length=0.1, width=0.1, skin="x", portion=Portion.HALF)
    params = object_family("lime").draw(rng_for(0, "objects/lime/0"), available()).replace(portion=None)
    asset = object_family("lime").build(params, supplies("lime", params))
    assert "portion" not in document.label_texts(asset)
    assert "portion" not in asset.labels.to_json()


def test_a_slice_on_a_slant_is_longer_and_as_thick() -> None:
    for slant in (0.0, 0.6):
        at = 0.05 * np.cos(slant)
        planes = [across(at + 0.003, below=True, slant=slant), across(at - 0.003, below=False, slant=slant)]
        kept, _ = cut(BODY, planes)
        normal = np.array([np.sin(slant), 0.0, np.cos(slant)])
        assert np.ptp(kept.points @ normal) == pytest.approx(0.006)
        assert is_closed(kept)
