"""Pictures of assets: something is seen, in the middle, from the front, and always the same."""

from __future__ import annotations

import io
import itertools
import multiprocessing
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.formats import mjcf
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from casa_assets.show.stills import renderer, still
from casa_assets.show.stills.studio import View, fit
from tests.support.asset.assets import ball, drawer_unit, rigid_mug, textured_box, write_to

QUICK = View(size_px=160, passes=8)


def pixels(png: bytes) -> npt.NDArray[np.float64]:
    """(H, W, 3) pixels, 0..255."""
    with Image.open(io.BytesIO(png)) as opened:
        return np.asarray(opened.convert("RGB"), dtype=np.float64)


def outline(png: bytes) -> npt.NDArray[np.bool_]:
    """Where something coloured is; the floor and its shadows are grey."""
    seen = pixels(png)
    return np.asarray(np.ptp(seen, axis=2) > 30.0)


def spans(mask: npt.NDArray[np.bool_]) -> tuple[float, float, float, float]:
    """(left, right, top, bottom) of a mask as fractions of the frame."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    height, width = mask.shape
    return columns[0] / width, (columns[-1] + 1) / width, rows[0] / height, (rows[-1] + 1) / height


def painted(asset: Asset, **look: float | tuple[float, ...]) -> Asset:
    """The asset with every material replaced by one of that look."""
    return asset.replace(materials=tuple(Material.model_validate({"id": m.id, **look}) for m in asset.materials))


@pytest.fixture
def box(tmp_path: Path) -> Path:
    return write_to(mjcf.write(textured_box()), tmp_path / "box") / "model.xml"


@pytest.mark.parametrize("make", [rigid_mug, ball, textured_box, drawer_unit])
def test_something_is_seen_in_the_middle_and_fills_the_frame(make: type, tmp_path: Path) -> None:
    asset: Asset = painted(make(), base_color=(0.8, 0.1, 0.1, 1.0))
    png = still.render(write_to(mjcf.write(asset), tmp_path) / "model.xml", QUICK)
    left, right, top, bottom = spans(outline(png))
    assert 0.72 <= max(right - left, bottom - top) <= 0.88
    assert left + right == pytest.approx(1.0, abs=0.04)
    assert top + bottom == pytest.approx(1.0, abs=0.04)


def test_the_floor_is_nearly_white_and_the_thing_throws_a_shadow(tmp_path: Path) -> None:
    seen = pixels(still.render(write_to(mjcf.write(rigid_mug()), tmp_path) / "model.xml", QUICK))
    corners = np.array([seen[2, 2], seen[2, -3]])
    assert corners.min() > 225.0
    floor = seen[np.ptp(seen, axis=2) < 4.0]
    assert floor.min() < 190.0


def test_the_front_is_seen_which_faces_minus_y(tmp_path: Path) -> None:
    # A board, red where it faces -y and blue behind: mostly red is seen.
    model = tmp_path / "model.xml"
    front, back = (0.0, -0.004, 0.05), (0.0, 0.004, 0.05)
    plates = "".join(
        f'<geom type="box" group="1" size="0.05 0.004 0.05" pos="{x} {y} {z}" rgba="{rgba}"/>'
        for (x, y, z), rgba in ((front, "1 0 0 1"), (back, "0 0 1 1"))
    )
    model.write_text(f"<mujoco><worldbody><body><body name='object'>{plates}</body></body></worldbody></mujoco>")
    red, _, blue = pixels(still.render(model, QUICK)).transpose(2, 0, 1)
    assert np.count_nonzero(red - blue > 60.0) > 5 * np.count_nonzero(blue - red > 60.0) > 0
    # Its right side (+x) is nearer, so the front recedes to the left: the blue edge looks out on the right.
    assert (
        np.flatnonzero((blue - red > 60.0).any(axis=0)).mean() > np.flatnonzero((red - blue > 60.0).any(axis=0)).mean()
    )


def test_the_same_bytes_twice_and_in_another_process(box: Path) -> None:
    once = still.render(box, QUICK)
    assert still.render(box, QUICK) == once
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["mujoco"])
    with context.Pool(1) as pool:
        assert pool.apply(still.render, (box, QUICK)) == once


def test_a_child_of_a_process_that_has_drawn_is_told_and_does_not_hang(box: Path) -> None:
    still.render(box, QUICK)
    with multiprocessing.get_context("fork").Pool(1) as pool, pytest.raises(renderer.NoRenderer, match="forkserver"):
        pool.apply_async(still.render, (box, QUICK)).get(timeout=60)


def test_colliders_are_seen_in_colours_of_their_own(tmp_path: Path) -> None:
    model = write_to(mjcf.write(rigid_mug()), tmp_path) / "model.xml"
    plain, colliders = still.render(model, QUICK), still.render(model, QUICK, collision=True)
    assert plain != colliders
    seen = pixels(colliders)[outline(colliders)]
    hues = np.unique((seen // 48).astype(int), axis=0)
    assert len(hues) > len(np.unique((pixels(plain)[outline(plain)] // 48).astype(int), axis=0))


def test_a_broken_model_is_named(tmp_path: Path) -> None:
    model = tmp_path / "model.xml"
    model.write_text("<mujoco><worldbody/></mujoco>")
    with pytest.raises(still.CannotDraw, match=r"model\.xml: it has no geom"):
        still.render(model, QUICK)
    model.write_text("<mujoco>")
    with pytest.raises(still.CannotDraw):
        still.render(model, QUICK)


def test_the_turntable_turns_once(box: Path) -> None:
    animation = still.render_turntable(box, View(size_px=64, passes=4), frames=4)
    with Image.open(io.BytesIO(animation)) as opened:
        assert opened.format == "WEBP"
        assert getattr(opened, "n_frames", 1) == 4
        frames = []
        for i in range(4):
            opened.seek(i)
            frames.append(np.asarray(opened.convert("RGB"), dtype=float))
    assert all(np.abs(a - b).mean() > 1.0 for a, b in itertools.pairwise(frames))


@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (0.001, 0.2, 0.01), (3.0, 0.02, 2.0)])
def test_the_fit_is_tight_and_centred_for_any_shape(size: tuple[float, float, float]) -> None:
    grid = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    view = View(fill=0.7)
    x, y, depth = fit(grid, view).project(grid)
    assert max(np.ptp(x), np.ptp(y)) / 2.0 == pytest.approx(0.7, rel=0.02)
    assert x.max() == pytest.approx(-x.min(), abs=1e-6)
    assert y.max() == pytest.approx(-y.min(), abs=1e-6)
    assert depth.min() > 0.0


@pytest.fixture
def no_context(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if this process had not drawn, and could not."""

    def fails(name: str) -> None:
        raise OSError(f"lib{name}.so: cannot open shared object file")

    monkeypatch.setattr(renderer, "_open", fails)
    monkeypatch.setattr(renderer, "_opened", [])
    monkeypatch.setattr(renderer, "_context", renderer._context.__wrapped__)
    for name in ("MUJOCO_GL", "CASA_ASSETS_GL"):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.usefixtures("no_context")
def test_without_opengl_the_error_says_what_to_install(box: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CasaError, match=r"egl: OSError.*osmesa: OSError.*apt-get install -y libegl1"):
        still.render(box, QUICK)
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    with pytest.raises(CasaError, match=r"apt-get install -y libosmesa6.*leave MUJOCO_GL=osmesa out") as error:
        still.render(box, QUICK)
    assert "egl: " not in str(error.value)
