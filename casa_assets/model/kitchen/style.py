"""A style (fronts, finishes and models of any plan), and how kitchens are drawn at random."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.record import Id, Record, Vec2

# In place of a family: `library:<id>` names an asset of a library of the project, and is kept as `library/<id>`.
LIBRARY = "library"
LIBRARY_PARAMS = ("scale", "base", "reach")  # what may stand beside the name of an asset of a library
MAX_SCALE = 100.0
PresetName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*/[a-z][a-z0-9_]*$")]


class PresetChoice(Record):
    """A chosen preset of a family, with the parameters that differ from it.

    Attributes:
        preset: `family/preset`, such as `range/pro_six`; or `library:<id>`, an asset of a library of the project.
        params: numbers and choices of the family that differ from the preset's. For an asset of a library: `scale`, a
            size factor that replaces the one that fits it to its place; `base`, fixed or free; `reach`, how far its
            doors may reach out sideways as they turn, metres.
    """

    preset: PresetName
    params: Mapping[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        """Accept `range/pro_six`, `library:<id>`, or a mapping with `preset` and the params next to it."""
        if isinstance(value, str):
            return {"preset": _in_library(value)}
        if isinstance(value, Mapping) and "params" not in value:
            rest = {k: v for k, v in value.items() if k != "preset"}
            return {"preset": _in_library(value.get("preset")), "params": rest}
        return value

    @model_validator(mode="after")
    def _has_its_params(self) -> Self:
        if not self.is_library:
            return self
        if others := sorted(set(self.params) - set(LIBRARY_PARAMS)):
            known = ", ".join(LIBRARY_PARAMS)
            raise ValueError(f"an asset of a library has {known} to change and nothing else, got {', '.join(others)}")
        scale, base = self.params.get("scale", 1.0), self.params.get("base", Base.FREE)
        if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0 < scale <= MAX_SCALE:
            raise ValueError(f"scale is a number over 0 and up to {MAX_SCALE:g}, got {scale!r}")
        reach = self.params.get("reach", 0.0)
        if isinstance(reach, bool) or not isinstance(reach, int | float) or not 0 <= reach <= MAX_SCALE:
            raise ValueError(f"reach is metres, got {reach!r}")
        if base not in tuple(Base):
            raise ValueError(f"base is {' or '.join(Base)}, got {base!r}")
        return self

    @property
    def is_library(self) -> bool:
        """True if it is an asset of a library and not a member of a family."""
        return self.family == LIBRARY

    @property
    def family(self) -> str:
        """Name of the family."""
        return self.preset.split("/")[0]

    @property
    def name(self) -> str:
        """Name of the preset in its family."""
        return self.preset.split("/")[1]


def _in_library(preset: Any) -> Any:
    """`library:<id>` as `library/<id>`; anything else as it is."""
    marked = isinstance(preset, str) and preset.startswith(f"{LIBRARY}:")
    return preset.replace(":", "/", 1) if marked else preset


class FrontStyle(Record):
    """Look of a group of cabinets; None: as for the base cabinets. Fields as in CabinetLook of the families."""

    front: Id | None = None
    handle: Id | None = None
    length: Annotated[float | None, Field(ge=0.06, le=1.2)] = None
    face: Id | None = None
    inside: Id | None = None
    tray: Id | None = None
    metal: Id | None = None

    def filled_from(self, other: FrontStyle) -> FrontStyle:
        """Copy in which fields that are None have the value of `other`."""
        return FrontStyle(
            **{k: v if (v := getattr(self, k)) is not None else getattr(other, k) for k in FrontStyle.model_fields}
        )


class CabinetStyle(Record):
    """Fronts of the cabinets by group, with glass, shelves and cornice.

    Attributes:
        base: every field is required. upper, tall, island: fields that differ from it.
        glass: front of wall units that are glazed in the plan. shelf: finish of open shelves.
        cornice: profile above the wall units, or None for no cornice.
    """

    base: FrontStyle
    upper: FrontStyle = FrontStyle()
    tall: FrontStyle = FrontStyle()
    island: FrontStyle = FrontStyle()
    glass: Id = "glass_clear"
    shelf: Id
    cornice: Id | None = None

    @model_validator(mode="after")
    def _whole(self) -> Self:
        missing = [k for k in FrontStyle.model_fields if getattr(self.base, k) is None]
        if missing:
            raise ValueError(f"base needs {', '.join(missing)}")
        return self


class WorktopStyle(Record):
    """Style of a worktop: finish, edge profile, thickness in metres, height of the upstand (0 for none)."""

    face: Id
    edge: Id = "eased"
    thickness: Annotated[float, Field(ge=0.012, le=0.06)] = 0.03
    upstand: Annotated[float, Field(ge=0, le=0.12)] = 0.0
    support: Id = "none"


class RoomStyle(Record):
    """The room: finishes of walls, woodwork, floor and ceiling.

    Attributes:
        wall, floor, ceiling: finishes. trim: of skirting and casings.
        turn_deg: direction of floor boards: along the room's x axis (0) or its y axis (90).
        skirting: profile. wainscot: kind of panelling of the lower wall in place of skirting; None for none.
        beams: finish of beams under the ceiling, or None.
    """

    wall: Id
    floor: Id
    ceiling: Id = "paint_pure_white"
    trim: Id = "paint_pure_white"
    turn_deg: int = 0
    skirting: Id = "square"
    wainscot: Id | None = None
    beams: Id | None = None


class BacksplashStyle(Record):
    """Style of the wall covering between worktop and wall units, and up to the hood behind a cooktop."""

    face: Id


class Style(Record):
    """Style of a kitchen: finishes, fronts and fixture presets for a plan of any shape.

    Attributes:
        id: name of the style. title: name for people. description: what makes it recognisable, one line.
        counter, island: worktops along walls, and of islands. backsplash: None for no backsplash.
        models: role -> member of a family. Roles are the words of the plans: range, hob, oven, microwave,
            microwave_built_in, hood, sink, fridge, dishwasher, window, door, stool, and other items on surfaces and
            walls.
        props: members that may be scattered on worktops and shelves, the most likely first.
        lamp_kelvin, daylight_kelvin: colour temperature of the lamps, and of the sun.
    """

    id: Id
    title: str
    description: str
    cabinets: CabinetStyle
    counter: WorktopStyle
    island: WorktopStyle
    backsplash: BacksplashStyle | None = None
    room: RoomStyle
    models: Mapping[Id, PresetChoice]
    props: tuple[PresetChoice, ...] = ()
    lamp_kelvin: Annotated[float, Field(ge=2000, le=7000)] = 3000.0
    daylight_kelvin: Annotated[float, Field(ge=3000, le=9000)] = 5800.0

    @property
    def surfaces(self) -> dict[str, str]:
        """Main finish of each of the four surfaces."""
        finishes = (self.room.wall, self.room.floor, self.counter.face, self.cabinets.base.face or "")
        return dict(zip((surface.value for surface in Surface), finishes, strict=True))

    def with_surfaces(self, surfaces: Mapping[Surface, str]) -> Style:
        """Copy with other finishes of walls, floor, worktops and cabinets."""
        style = self
        named = {key: name for key in (Surface.WALL, Surface.FLOOR) if (name := surfaces.get(key))}
        if named:
            style = style.replace(room=style.room.replace(**named))
        if name := surfaces.get(Surface.COUNTER):
            style = style.replace(counter=style.counter.replace(face=name), island=style.island.replace(face=name))
        if name := surfaces.get(Surface.CABINET):
            cabinets = style.cabinets
            groups = {k: getattr(cabinets, k).replace(face=None) for k in ("upper", "tall", "island")}
            style = style.replace(cabinets=cabinets.replace(base=cabinets.base.replace(face=name), **groups))
        return style


Count = Annotated[int, Field(ge=1, le=4)]


class Harmony(Record):
    """Rules for finishes of the four surfaces that may be combined.

    Attributes:
        patterned, wooden: kinds of textures that count as patterned or wooden.
        most_patterned, most_wooden, most_dark: number of such surfaces.
        dark_below: mean lightness in Oklab below which a finish is dark.
        strong_from: mean chroma in Oklab from which a colour is strong.
        earth_hues_deg: lower and upper Oklab hue, degrees, of strong colours that count as neutral nevertheless.
        most_hue_deg: difference in hue between two strong colours.
    """

    patterned: tuple[Id, ...]
    wooden: tuple[Id, ...]
    most_patterned: Count
    most_wooden: Count
    dark_below: Annotated[float, Field(ge=0, le=1)]
    most_dark: Count
    strong_from: Annotated[float, Field(ge=0, le=0.4)]
    earth_hues_deg: Vec2
    most_hue_deg: Annotated[float, Field(ge=0, le=180)]


class Mixing(Record):
    """Rules for drawing a kitchen at random.

    Attributes:
        own_share: probability that a part is taken from the kitchen's own style; otherwise one of all styles is drawn.
        suites: name -> roles of styles that are drawn together. finishes: which finishes may be combined.
    """

    own_share: Annotated[float, Field(ge=0, le=1)]
    suites: Mapping[Id, tuple[Id, ...]]
    finishes: Harmony

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        roles = [role for suite in self.suites.values() for role in suite]
        twice = sorted({role for role in roles if roles.count(role) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)}: a role is in one suite at most")
        return self
