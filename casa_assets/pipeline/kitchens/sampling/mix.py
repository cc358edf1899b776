"""Mix styles: a style of which parts are those of other styles, drawn by a seed.

Every part stands in some style as it is, so that it was looked at and checked there: nothing new is put together within
a part. Which parts go together is data, registry/mixing.yaml.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from casa_assets.core.sampling import rng_for
from casa_assets.model.kitchen.style import PresetChoice, Style
from casa_assets.projects import read_once
from casa_assets.registry.kitchens import load_style, style_names
from casa_assets.registry.mixing import load_mixing

GROUPS = ("base", "upper", "tall", "island")  # of cabinets
LANE = "scene/mix"


def mixed_style(style: Style, seed: int, turn: int = 0) -> Style:
    """A style with fronts, worktop edges, woodwork, models and props of other styles; its finishes stay.

    Args:
        style: whose name, description and light stay, and the finishes of walls, floor, worktops and cabinets.
        seed: of the draws; every part has a lane of its own.
        turn: another one draws anew, where what was drawn does not fit into a plan.
    """
    parts = {part: _drawn(style, _styles(), seed, turn, part) for part in ("fronts", "worktops", "woodwork", "props")}
    fronts, tops, room, props = parts.values()
    faces = {name: getattr(style.cabinets, name).face for name in GROUPS}
    groups = {name: getattr(fronts.cabinets, name).replace(face=face) for name, face in faces.items()}
    return style.replace(
        cabinets=fronts.cabinets.replace(**groups),
        counter=tops.counter.replace(face=style.counter.face),
        island=tops.island.replace(face=style.island.face),
        backsplash=tops.backsplash,
        room=room.room.replace(wall=style.room.wall, floor=style.room.floor, turn_deg=style.room.turn_deg),
        models=_models(style, seed, turn, parts),
        props=props.props,
    )


def models_of_roles() -> dict[str, tuple[str, ...]]:
    """Every model that a mixed kitchen may have, by role: `family/preset`, sorted, each once."""
    roles = sorted({role for style in _styles() for role in style.models})
    return {role: tuple(sorted({s.models[role].preset for s in _styles() if role in s.models})) for role in roles}


def kinds_of_fronts() -> tuple[tuple[str | None, str | None], ...]:
    """Kinds of fronts and handles of base units that a mixed kitchen may have, sorted, each once."""
    bases = (style.cabinets.base for style in _styles())
    return tuple(sorted({(base.front, base.handle) for base in bases}, key=str))


def _models(style: Style, seed: int, turn: int, parts: Mapping[str, Style]) -> Mapping[str, PresetChoice]:
    """The models of a mixed style: the roles of the style itself, suite by suite and else one by one.

    Args:
        parts: name of a part -> style that it comes from; a suite of that name comes from it too.
    """
    suites = dict(load_mixing().suites)
    in_suites = {role for roles in suites.values() for role in roles}
    suites |= {role: (role,) for role in style.models if role not in in_suites}
    source: dict[str, Style] = {}
    for name, roles in suites.items():
        wanted = [role for role in roles if role in style.models]
        whole = [other for other in _styles() if all(role in other.models for role in wanted)]
        drawn = parts.get(name)
        if drawn not in whole:
            drawn = _drawn(style, whole, seed, turn, f"models/{name}")
        source |= dict.fromkeys(wanted, drawn)
    return {role: source[role].models[role] for role in style.models}


def _drawn(style: Style, others: Sequence[Style], seed: int, turn: int, part: str) -> Style:
    """The style that a part is taken from."""
    rng = rng_for(seed, f"{LANE}/{part}/{turn}")
    if float(rng.random()) < load_mixing().own_share or not others:
        return style
    return others[int(rng.integers(len(others)))]


@read_once
def _styles() -> tuple[Style, ...]:
    """Every style, by name."""
    return tuple(load_style(name)[0] for name in style_names())
