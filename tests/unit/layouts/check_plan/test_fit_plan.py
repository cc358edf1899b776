"""Plans in rooms of other sizes: what comes out fits, in the room that was asked for, or is refused with a size."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets.cli.main import app
from casa_assets.errors import CasaError
from casa_assets.layouts.check_plan.check import DoesNotFit, check_plan, fit_plan
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.projects import data_root
from casa_assets.registry.kitchens import load_plan, load_style, plan_names

pytestmark = pytest.mark.content("code", "layouts.check_plan", keep=0)

STYLE = "modern_1"
ROOMS = ((4.2, 3.1), (5.0, 4.2), (6.0, 5.0), (7.5, 6.5))
# Rooms in which a row is too short for its sink or its cooker, in which no mend lets doors open in corners and
# appliances keep off these, and in which nothing can be set down beside the microwave.
REFUSED = {
    (4.2, 3.1): ("u_dining", "wraparound"),
    (5.0, 4.2): ("u_dining", "g_small", "l_large", "one_wall_small", "wraparound"),
}
# One room of each plan that takes little time, two that are refused; the other rows are of a release.
QUICK = {
    (4.2, 3.1): ("g_small", "galley", "l_large", "l_small", "one_wall_large", "u_small"),
    (5.0, 4.2): ("l_bay", "l_large", "one_wall_small"),
    (6.0, 5.0): ("g_large", "l_columns", "pantry_island", "u_dining", "u_large"),
    (7.5, 6.5): ("attic", "double_island", "wraparound"),
}
ROWS = [
    pytest.param(name, room, id=f"{name}-{room}", marks=[pytest.mark.certify] * (name not in QUICK[room]))
    for room in ROOMS
    for name in plan_names()
]


def text_of(name: str) -> str:
    return (data_root() / "plans" / f"{name}.yaml").read_text(encoding="utf-8")


def fitted_kitchen(text: str, name: str, room: tuple[float, float]) -> KitchenRequest:
    fitted = fit_plan(text, f"{name}.yaml", load_style(STYLE)[0], *room)
    assert fitted.changes
    found = check_plan(fitted.text, f"{name}.yaml", load_style(STYLE)[0])
    assert found.fits
    assert found.kitchen is not None
    (x0, y0), (x1, y1) = found.kitchen.room.bounds()
    assert (x1 - x0, y1 - y0) == pytest.approx(room, abs=0.005)
    assert ("like:" in fitted.text) == ("like:" in text)
    return found.kitchen


@pytest.mark.parametrize(("name", "room"), ROWS)
def test_a_plan_in_a_room(name: str, room: tuple[float, float]) -> None:
    style, text = load_style(STYLE)[0], text_of(name)
    if any(wall.is_aslant for wall in load_plan(name)[0].walls):
        with pytest.raises(CasaError, match=r"its wall \w+ stands aslant"):
            fit_plan(text, f"{name}.yaml", style, *room)
        return
    if name in REFUSED.get(room, ()):
        with pytest.raises(DoesNotFit) as refused:
            fit_plan(text, f"{name}.yaml", style, *room)
        assert fit_plan(text, f"{name}.yaml", style, *refused.value.least).changes
        return
    kinds = {str(unit.kind) for unit in fitted_kitchen(text, name, room).plan.units.values()}
    assert {"sink", "fridge"} <= kinds
    assert kinds & {"range", "hob"}


def test_its_own_room_changes_nothing_and_a_plan_like_another_states_what_changes() -> None:
    fitted = fit_plan(text_of("galley"), "galley.yaml", load_style(STYLE)[0], 3.2, 5.6)
    assert (fitted.text, fitted.changes) == (text_of("galley"), ())
    fitted_kitchen("like: one_wall_small\ntitle: A shorter wall\n", "short", (5.4, 3.2))


def test_the_command(tmp_path: Path) -> None:
    plan, out = tmp_path / "galley.yaml", tmp_path / "small.yaml"
    plan.write_text(text_of("galley"), encoding="utf-8")
    run = CliRunner()
    words = ["scenes", "fit", str(plan), "--width", "3.1"]
    done = run.invoke(app, [*words, "--depth", "4.8", "--out", str(out)])
    assert done.exit_code == 0
    assert "# Write depth: [4.8, 4.8, 4.8]." in done.stdout
    assert check_plan(out.read_text(encoding="utf-8"), str(out), load_style(STYLE)[0]).fits
    plan.write_text(text_of("one_wall_small"), encoding="utf-8")
    small = run.invoke(app, ["scenes", "fit", str(plan), "--width", "5.0", "--depth", "4.2"])
    assert small.exit_code == 1
    assert "the least room for it is about" in small.stdout
