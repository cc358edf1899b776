"""Find the moving parts of a mesh in its frame, and choose the best of several ways to split it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from casa_assets.articulate.controls.classify import ControlClassifier, classify_by_forest, classify_with_dials
from casa_assets.articulate.controls.controls import (
    Control,
    classify_control,
    control_normal,
    find_controls,
    has_finger_room,
)
from casa_assets.articulate.controls.faucets import find_faucet_parts
from casa_assets.articulate.controls.levers_and_buttons import (
    Lever,
    drop_burner_caps,
    find_bar_levers,
    find_levers,
    find_single_button,
    find_switch_parts,
)
from casa_assets.articulate.fronts.joints import (
    DRAWER_TRAVEL_SHARE,
    FrontView,
    choose_drawer,
    choose_hinge,
    kind_log_odds,
    share_with_fronts,
    sliding_direction,
    view_fronts,
)
from casa_assets.articulate.fronts.opening_panels import (
    DOUBTFUL,
    find_round_door,
    fragments_around,
    select_opening_panels,
)
from casa_assets.articulate.fronts.panel_parts import attach_to_panels, find_box_boards, find_handle_spots
from casa_assets.articulate.fronts.panels import (
    Panel,
    find_panels,
    find_slats,
    merge_bridged_panels,
    merge_framed_panels,
)
from casa_assets.articulate.interior.inner_parts import InnerPart, find_inner_parts
from casa_assets.articulate.interior.lids import Lid, find_box_lid, find_lids, is_chest
from casa_assets.articulate.kinds import FORM_TRAITS, kinds_known
from casa_assets.articulate.plan import (
    Articulation,
    Frame,
    HingeEdge,
    JointPlan,
    PartKind,
    PartPlan,
    hinge,
    slide,
    to_vec3,
)
from casa_assets.articulate.segment.fragments import (
    MeasuredFragments,
    corners_from_side,
)
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP
from casa_assets.articulate.segment.shell_segments import (
    MIN_BOXINESS,
    NO_FRONTS,
    KnownFronts,
    boxiness,
)
from casa_assets.articulate.side_views import count_slots
from casa_assets.core.numeric import Floats, Forest
from casa_assets.model.record import Vec3

# Width to height of a wide front, and of a tall one; share of the side that one covering front has at least.
MIN_WIDE_RATIO, MAX_TALL_RATIO, MIN_COVERING_SHARE = 1.2, 0.8, 0.4
# Knobs in a row, and keys of a key pad, at least.
MIN_ROW, MIN_KEYS = 3, 6
# Fronts that differ by less in size and height are a pair, diagonals.
PAIR_TOLERANCE = 0.015
# A thing stands on legs where, in the stretch of its height between these shares, at most so much of its width is seen.
LEGS_STRETCH, MAX_LEGS_SHARE = (0.03, 0.1), 0.5
# Travel of a button in diagonals, capped by its protrusion. Ref: 2 to 5 mm on an object of 0.8 m.
MAX_BUTTON_TRAVEL = 0.004
# Slots for bread that a toaster has at least.
MIN_BREAD_SLOTS = 2
# A front that is a drawer with this probability does not run sideways, whatever is beside it.
SURE_DRAWER = 0.9
# A kind that is less likely by its form is not tried. A choice.
MIN_KIND_SHARE = 0.03
# A round thing within this share of the middle of the top is its cap and no control.
TOP_CENTRE_SHARE = 0.1


def traits_of_views(measured: MeasuredFragments, views: list[FrontView], seen: FrontLook) -> dict[str, bool]:
    """Return traits of KIND_TRAITS that the form of some fronts and the controls next to them show: whether each is."""
    panels = [v.panel for v in views]
    extent = np.ptp(measured.mesh.points, axis=0)
    largest = max(views, key=lambda v: v.panel.width * v.panel.height, default=None)
    widest = None if largest is None else largest.panel
    ratio = widest.width / max(widest.height, 1e-9) if widest is not None else 1.0
    share = widest.width * widest.height / float(extent[0] * extent[2]) if widest is not None else 0.0
    controls = [seen.classify(c, seen.controls)[0] for c in seen.controls]
    knobs, buttons = controls.count(PartKind.KNOB), controls.count(PartKind.BUTTON)
    has_top_knobs = PartKind.KNOB in [seen.classify_top(c, seen.top_controls)[0] for c in seen.top_controls]
    heights = [(p.lower[1], p.upper[1], p.width) for p in panels]
    return {
        **({"fronts": len(panels) > 1} if panels else {"door": False, "drawer": False}),
        "knobs": knobs > 0 or has_top_knobs,
        "above": has_top_knobs,
        "buttons": buttons > 0,
        "beside": largest is not None and largest.controls_beside > 0.5,
        "row": knobs >= MIN_ROW,
        "keys": buttons >= MIN_KEYS,
        "pair": any(float(np.abs(np.subtract(a, b)).max()) < PAIR_TOLERANCE for a, b in combinations(heights, 2)),
        "wide": widest is not None and ratio > MIN_WIDE_RATIO,
        "tall": widest is not None and ratio < MAX_TALL_RATIO,
        "covers": share > MIN_COVERING_SHARE,
        "legs": stands_on_legs(measured),
        "round": any(p.is_round for p in panels),
    }


def stands_on_legs(measured: MeasuredFragments) -> bool:
    """Return whether one sees past a thing near the floor, between its legs."""
    seen = measured.depth_images[FRONT].face >= 0
    rows = np.flatnonzero(seen.any(axis=1))
    columns = np.flatnonzero(seen.any(axis=0))
    if not len(rows):
        return False
    high = len(rows)
    first, last = (rows[-1] + 1 - round(s * high) for s in reversed(LEGS_STRETCH))
    band = seen[first : max(last, first + 1), columns[0] : columns[-1] + 1]
    return bool(band.mean() < MAX_LEGS_SHARE) if band.size else False


@dataclass
class PartCollector:
    """Parts found so far, the fragments that they use, and the fragments that are known for fronts from the start."""

    measured: MeasuredFragments
    known: KnownFronts = NO_FRONTS
    parts: list[PartPlan] = field(default_factory=list)
    taken: set[int] = field(default_factory=set)
    fronts: list[tuple[str, Panel, HingeEdge | None]] = field(default_factory=list)

    def copied(self) -> PartCollector:
        """Return a copy that parts can be added to."""
        return replace(self, parts=list(self.parts), taken=set(self.taken), fronts=list(self.fronts))

    def add(
        self,
        kind: PartKind,
        fragments: list[int],
        grip: list[int],
        joint: JointPlan,
        parent: str = "",
        sure: tuple[float, str] | None = None,
    ) -> str:
        """Add a part made of these fragments, as sure as stated, with a reason, else as its joint; return its name."""
        confidence, reason = sure or (joint.confidence, joint.reason)
        name = f"{kind.value}_{sum(p.kind is kind for p in self.parts)}"
        self.taken |= set(fragments)
        self.parts.append(
            PartPlan(
                name=name,
                kind=kind,
                parent=parent,
                faces=self.measured.faces_of(fragments),
                grip=self.measured.faces_of(grip),
                joint=joint,
                confidence=round(confidence, 2),
                reason=reason,
            )
        )
        return name


@dataclass(frozen=True)
class KindHypothesis:
    """The moving parts of a mesh that is split in one way, if it is of one kind.

    Attributes:
        kind: id, empty where no kind is assumed. share: probability of that kind by its form; 1 where none is assumed.
        spare_panels: area of the panels of its front that stay shut, by that of the front. spare_controls: number of
            things that look like controls and are none.
    """

    articulation: Articulation
    kind: str = ""
    share: float = 1.0
    spare_panels: float = 0.0
    spare_controls: int = 0


def articulate_fragments(
    measured: MeasuredFragments,
    frame: Frame,
    category: str = "",
    control_forest: Forest | None = None,
    known: KnownFronts = NO_FRONTS,
) -> Articulation:
    """Find the moving parts of a mesh among its fragments, whatever its kind.

    Args:
        measured: the fragments, in the frame: z up, the front faces -y, a diagonal of 1, the middle at the origin.
        category: id of its category if known, otherwise empty.
        control_forest: distinguishes knobs from keys; None for a quick look, at each control alone.
        known: fragments that are fronts; they are not merged with others.
    """
    return articulate_by_kind(measured, frame, category, control_forest, known, 0)[0].articulation


def articulate_by_kind(
    measured: MeasuredFragments,
    frame: Frame,
    category: str,
    control_forest: Forest | None,
    known: KnownFronts,
    most_kinds: int,
) -> list[KindHypothesis]:
    """Find the moving parts under each of several assumptions on the kind; those that change nothing are left out.

    Args:
        most_kinds: number of likely kinds that are tried, after none; others as for `articulate_fragments`.
    """
    collector = PartCollector(measured, known)
    if measured.count <= 1 or _add_all(collector, find_switch_parts(measured)):
        return [KindHypothesis(_articulation(collector, frame, category, {}))]
    seen = look_at_front(collector, control_forest)
    chosen = select_opening_panels(measured, seen.panels, seen.controls, known)
    views = view_fronts(measured, [p for p, _, _ in chosen], seen.panels, seen.controls)
    traits = traits_of_views(measured, views, seen)
    x, y, z = (float(v) for v in np.ptp(measured.mesh.points, axis=0))
    odds = kind_log_odds(views)
    shares = kinds_known((x, y, z), traits, odds, category)
    likely = sorted(shares, key=lambda kind: (-round(shares[kind], 9), kind))[:most_kinds]
    out: list[KindHypothesis] = []
    decided: list[list[tuple[bool, HingeEdge | None]]] = []
    for kind in ("", *(k for k in likely if shares[k] >= MIN_KIND_SHARE)):
        kinds = kinds_known((x, y, z), traits, odds, kind) if kind else shares
        ways = [_way_to_open(measured, view, panel, kinds) for view, (panel, _, _) in zip(views, chosen, strict=True)]
        told = [(way.is_drawer, way.edge) for way in ways]
        if told in decided:
            continue
        decided.append(told)
        copied = collector.copied()
        panels = {id(p): copy(p) for p in seen.panels}
        look = replace(seen, panels=list(panels.values()))
        fronts = [(panels[id(p)], sure, why) for p, sure, why in chosen]
        _fronts(copied, look, fronts, ways, share_with_fronts(kinds))
        _other_parts(copied, look)
        found = _articulation(copied, frame, category, traits)
        still = [p for p in look.panels if not copied.taken.intersection(p.members)]
        area = sum(p.width * p.height for p in still) / max(x * z, 1e-12)
        loose = sum(copied.taken.isdisjoint(c.fragments) for c in (*look.controls, *look.top_controls))
        out.append(KindHypothesis(found, kind, shares[kind] if kind else 1.0, area, loose))
    return out


def _other_parts(collector: PartCollector, seen: FrontLook) -> None:
    """Add what is no front: faucets, controls, what lies behind fronts, and lids."""
    measured = collector.measured
    loose_controls, top_controls = seen.controls, seen.top_controls
    if not collector.parts and _add_all(collector, find_faucet_parts(measured, collector.taken), gripped=False):
        loose_controls, top_controls = [], []
    _controls(collector, FRONT, loose_controls, seen.classify)
    for _, panel, edge in list(collector.fronts):
        for tray in find_inner_parts(measured, panel, edge, sorted(collector.taken)):
            _tray(collector, panel, tray)
    on_top = [c for c in top_controls if seen.classify_top(c, top_controls)[0] is PartKind.KNOB]
    _lids(collector, on_top)
    _controls(collector, TOP, top_controls, seen.classify_top)


def _articulation(collector: PartCollector, frame: Frame, category: str, traits: Mapping[str, bool]) -> Articulation:
    """Return what was found; nothing where the object is of unknown category and its walls are not flat."""
    measured = collector.measured
    button = find_single_button(measured) if category and measured.count > 1 and not collector.parts else None
    if button is not None:
        middle, travel = (button.lower + button.upper) / 2, min(MAX_BUTTON_TRAVEL, 0.5 * button.protrusion)
        why = "round, and all that stands out of its front"
        joint = slide(to_vec3(SIDES[FRONT][2]), _point(FRONT, middle), travel, 0.45, why)
        collector.add(PartKind.BUTTON, button.fragments, button.fragments, joint)
    # An object of unknown category with doors, buttons or knobs has flat walls, or a lid or a lever besides; otherwise
    # lids of jars, seeds of a melon and plates in a rack would pass for them.
    telling = any(p.kind in (PartKind.LID, PartKind.LEVER, PartKind.SPOUT) for p in collector.parts)
    may_move = category or telling or boxiness(measured.mesh, measured.depth_images) >= MIN_BOXINESS
    parts = tuple(collector.parts) if may_move else ()
    shown = tuple(t for t in FORM_TRAITS if traits.get(t))
    return Articulation(frame=frame, parts=parts, category=category, traits=shown)


@dataclass(frozen=True)
class FrontLook:
    """Panels and controls on the front and the top of an object, before any joint is decided.

    Attributes:
        panels: of the front, with their handles, trims and boxes. controls: of the front, on none of its panels.
        top_controls: of the top. classify, classify_top: classifiers for controls of the front and of the top.
    """

    panels: list[Panel]
    controls: list[Control]
    classify: ControlClassifier
    top_controls: list[Control]
    classify_top: ControlClassifier


def look_at_front(collector: PartCollector, control_forest: Forest | None = None) -> FrontLook:
    """Return what is on the front; its levers are added as parts at once."""
    measured = collector.measured
    round_door = find_round_door(measured)
    held = [] if round_door is None else [*round_door.members, *fragments_around(measured, round_door)]
    # A toaster has no fronts: its levers and knobs stand on plates that look like some.
    slots = count_slots(measured.depth_images[TOP])
    is_toaster = slots >= MIN_BREAD_SLOTS
    panels = [] if is_toaster else find_panels(measured, held)
    controls = find_controls(measured, FRONT, [*held, *(f for p in panels for f in p.members)])
    # A lever may be as large as a small panel.
    control_fragments = {f for c in controls for f in c.fragments}
    blocks = [c for c in find_controls(measured, FRONT, []) if control_fragments.isdisjoint(c.fragments)]
    levers = find_levers(measured, controls)
    controls = [c for c in controls if not any(lever.control is c for lever in levers)]
    bars = find_bar_levers(measured, controls) if is_toaster else []
    controls = [c for c in controls if not any(bar.control is c for bar in bars)]
    levers += [*find_levers(measured, blocks), *bars]
    classify_front = _classifier(measured, FRONT, controls, panels, control_forest)
    if slots:
        classify_front = classify_with_dials(classify_front)
    _levers(collector, levers)
    panels = [p for p in panels if collector.taken.isdisjoint(p.members)]
    found = find_controls(measured, TOP, sorted(collector.taken))
    classify_top = _classifier(measured, TOP, found, [], control_forest)
    if control_forest is None:
        top_controls, controls = _controls_by_look(measured, found, controls)
    else:
        # What both sides show is of the surer one.
        sure = {f: classify_front(c, controls)[1] for c in controls for f in c.fragments}
        kept = [
            c for c in found if classify_top(c, found)[1] > max((sure.get(f, 0.0) for f in c.fragments), default=0.0)
        ]
        taken = {f for c in kept for f in c.fragments}
        controls = [c for c in controls if taken.isdisjoint(c.fragments)]
        top_controls = drop_burner_caps(kept, found, controls)
    if len(top_controls) == 1 and _is_in_middle(measured, top_controls[0]):
        top_controls = []  # the cap of a bottle
    panels = _merge_panels(collector, panels, controls)
    panels += [] if round_door is None else [round_door]
    panel_fragments = {f for p in panels for f in p.members}
    controls = [c for c in controls if panel_fragments.isdisjoint(c.fragments)]
    loose_controls = attach_to_panels(measured, panels, controls, classify_front)
    for panel in panels:
        boxes = {collector.known.boxes[f] for f in panel.members if f in collector.known.boxes}
        if boxes:
            panel.box = sorted(boxes - {f for p in panels if p is not panel for f in p.everything})
    return FrontLook(panels, loose_controls, classify_front, top_controls, classify_top)


def _merge_panels(collector: PartCollector, panels: list[Panel], controls: list[Control]) -> list[Panel]:
    """Return the panels with those merged that are one front; fronts that are known stay as they are."""
    known, measured = collector.known.chances.keys(), collector.measured
    fronts = [p for p in panels if not known.isdisjoint(p.members)]
    panels = merge_bridged_panels(measured, [p for p in panels if known.isdisjoint(p.members)])
    handle_spots = find_handle_spots(measured, [*fronts, *panels], controls)
    return [*fronts, *merge_framed_panels(panels, handle_spots, find_slats(measured, panels))]


def _classifier(
    measured: MeasuredFragments, side: int, controls: list[Control], panels: list[Panel], forest: Forest | None
) -> ControlClassifier:
    """Return a classifier for the controls of a side."""
    if forest is None:
        return classify_control
    return classify_by_forest(measured, side, controls, [(p.lower[:2], p.upper[:2]) for p in panels], forest)


def _controls_by_look(
    measured: MeasuredFragments, top: list[Control], front: list[Control]
) -> tuple[list[Control], list[Control]]:
    """Return the knobs of the top, and the controls of the front without what is seen as round from the top alone."""
    # What protrudes like a knob, not like a foot or a burner.
    far_out = [c for c in top if c.is_round and c.protrusion >= 0.3 * float(c.across.max())]
    knobs = drop_burner_caps([c for c in far_out if has_finger_room(measured, TOP, c)], top, front)
    round_there = {f for c in knobs for f in c.fragments}
    return knobs, [c for c in front if c.is_round or round_there.isdisjoint(c.fragments)]


def _is_in_middle(measured: MeasuredFragments, control: Control) -> bool:
    """Return whether a control of the top is in the middle of the top."""
    lower, upper = measured.lower.min(axis=0)[:2], measured.upper.max(axis=0)[:2]
    return bool((np.abs(control.middle - (lower + upper) / 2) < TOP_CENTRE_SHARE * (upper - lower)).all())


def _levers(collector: PartCollector, levers: list[Lever]) -> None:
    """Add levers that slide in a slot."""
    for lever in levers:
        middle = _point(FRONT, (lever.control.lower + lever.control.upper) / 2)
        joint = slide(_unit_vec3(lever.way @ SIDES[FRONT]), middle, lever.length, 0.8, "it stands in a slot")
        collector.add(PartKind.LEVER, lever.control.fragments, lever.control.fragments, joint)


@dataclass(frozen=True)
class WayToOpen:
    """How a front opens: as a drawer, to the side (`slides`: 1 right, -1 left), or about an edge; how sure, and why."""

    is_drawer: bool
    confidence: float
    reason: str
    slides: float | None = None
    hinge: JointPlan | None = None

    @property
    def edge(self) -> HingeEdge | None:
        """Return the edge that it is hinged at, if it is."""
        return None if self.hinge is None else self.hinge.edge


def _way_to_open(measured: MeasuredFragments, view: FrontView, panel: Panel, kinds: Mapping[str, float]) -> WayToOpen:
    """Return how a front opens, given the probability of each kind."""
    is_drawer, confidence, reason = choose_drawer(view, kinds)
    is_sure = is_drawer and confidence >= SURE_DRAWER
    slides = None if panel.box or is_sure else sliding_direction(measured, panel, view.handle)
    is_drawer &= slides is None
    hinged = None if is_drawer or slides is not None else choose_hinge(view, kinds)
    return WayToOpen(is_drawer, confidence, reason, slides, hinged)


def _fronts(
    collector: PartCollector,
    seen: FrontLook,
    chosen: Sequence[tuple[Panel, float, str]],
    ways: Sequence[WayToOpen],
    share_of_kinds: float,
) -> None:
    """Add the doors and drawers among the panels, each with its joint.

    Args:
        share_of_kinds: probability that the object is of a kind that has fronts.
    """
    measured = collector.measured
    lower, upper = corners_from_side(measured, FRONT)
    depth_of_all = float(upper[:, 2].max() - lower[:, 2].min())
    for way, (panel, confidence, reason) in zip(ways, chosen, strict=True):
        if confidence <= DOUBTFUL and share_of_kinds < 0.5:
            continue
        grip_fragments = sorted(f for g in panel.grips for f in g)
        middle = _point(FRONT, (panel.lower + panel.upper) / 2)
        if way.is_drawer:
            if not panel.box:
                others = {f for p in seen.panels if p is not panel for f in p.everything}
                panel.box = find_box_boards(measured, panel, collector.taken | others)
            depth = float(measured.upper[panel.everything, 1].max() - panel.lower[2])
            travel = DRAWER_TRAVEL_SHARE * depth if depth > 0.15 * depth_of_all else 0.7 * depth_of_all
            joint = slide(_unit_vec3(-SIDES[FRONT][2]), middle, float(travel), way.confidence, way.reason)
        elif way.slides is not None:
            panel.box = []
            axis = _unit_vec3(way.slides * SIDES[FRONT][0])
            joint = slide(axis, middle, 0.95 * panel.width, 0.6, "its niche goes on beside it")
        else:
            panel.box = []
            assert way.hinge is not None
            joint = way.hinge
        sure = confidence * way.confidence, reason
        kind = PartKind.DRAWER if way.is_drawer else PartKind.DOOR
        name = collector.add(kind, panel.everything, grip_fragments, joint, sure=sure)
        collector.fronts.append((name, panel, joint.edge))


def _controls(collector: PartCollector, side: int, controls: list[Control], classify: ControlClassifier) -> None:
    """Add the knobs and buttons of a side; other controls stay with what they sit on."""
    for control in controls:
        if set(control.fragments) & collector.taken:
            continue
        width = float(control.across.max())
        kind, confidence, reason = classify(control, controls)
        if kind is None:
            continue
        normal, middle = control_normal(collector.measured, side, control), (control.lower + control.upper) / 2
        if kind is PartKind.KNOB:
            joint = hinge(_unit_vec3(normal), _point(side, middle), None, confidence, reason)
        else:
            travel = min(MAX_BUTTON_TRAVEL, max(0.5 * control.protrusion, 0.1 * width))
            joint = slide(_unit_vec3(-normal), _point(side, middle), travel, confidence, reason)
        parent = next(
            (n for n, p, _ in collector.fronts if side == FRONT and p.holds(control.lower, control.upper)), ""
        )
        collector.add(kind, control.fragments, control.fragments, joint, parent)


def _add_all(
    collector: PartCollector, found: list[tuple[PartKind, list[int], JointPlan]], gripped: bool = True
) -> bool:
    """Add parts, each gripped anywhere or not at all; return whether there are any."""
    for kind, fragments, joint in found:
        collector.add(kind, fragments, fragments if gripped else [], joint)
    return bool(found)


def _tray(collector: PartCollector, door: Panel, tray: InnerPart) -> None:
    """Add something that slides or turns behind a door."""
    lower, upper = collector.measured.box(tray.fragments)
    middle = to_vec3((lower + upper) / 2)
    if tray.turns:
        joint = hinge((0.0, 0.0, 1.0), middle, None, tray.confidence, tray.reason)
    else:
        travel = DRAWER_TRAVEL_SHARE * float(upper[1] - lower[1])
        joint = slide((0.0, -1.0, 0.0), middle, travel, tray.confidence, tray.reason)
    kind = PartKind.DRAWER if tray.is_drawer else PartKind.TRAY
    collector.add(kind, list(tray.fragments), list(tray.fragments), joint)


def _lids(collector: PartCollector, knobs: list[Control]) -> None:
    """Add the lids that nothing keeps shut.

    Args:
        knobs: of the top. A plate that bears several is that of a hob, and no lid.
    """
    for lid in find_lids(collector.measured, collector.taken):
        if lid.opening_angle > 0.0:
            _lid(collector, lid, f"a round cover {'on top, with a knob' if lid.knob else 'over an open vessel'}")
    # What is taken for plain fronts or for what lies behind them may be the walls and the floor of a box.
    walls = (PartKind.DOOR, PartKind.DRAWER, PartKind.TRAY)
    box_lid = find_box_lid(collector.measured) if all(p.kind in walls for p in collector.parts) else None
    if box_lid is None or sum(not set(c.fragments).isdisjoint(box_lid.fragments) for c in knobs) > 1:
        return
    own = collector.measured.faces_of(box_lid.fragments)
    # A handle speaks for a front, but for the catch of the lid itself.
    has_handles = any(len(p.grip) and not np.isin(p.grip, own).all() for p in collector.parts)
    if not has_handles and (not collector.parts or is_chest(collector.measured, box_lid)):
        collector.parts, collector.fronts, collector.taken = [], [], set()
        _lid(collector, box_lid, "all that covers a box")


def _lid(collector: PartCollector, lid: Lid, reason: str) -> None:
    """Add a lid that opens upwards about its edge at the handle, or at the back."""
    axis, anchor = lid.hinge
    why = "hinged at the handle, or where nothing is in its way"
    joint = hinge(_unit_vec3(axis), to_vec3(anchor), (0.0, lid.opening_angle), 0.5, why)
    collector.add(PartKind.LID, lid.fragments, lid.knob, joint, sure=(0.6, reason))


def _unit_vec3(v: Floats) -> Vec3:
    return to_vec3(v / np.linalg.norm(v))


def _point(side: int, uvw: Floats) -> Vec3:
    """Convert a point given as (right, up, depth) of a side to the frame."""
    return to_vec3(uvw @ SIDES[side])
