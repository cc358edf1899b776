"""Builder of articulated assets: collects links, solids, joints, sites, regions and a state machine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.asset.family import Supplies
from casa_assets.asset.solid import Solid
from casa_assets.core import hand_dynamics
from casa_assets.core.numeric import Floats
from casa_assets.mesh.surface import solid_moments
from casa_assets.model.asset.asset import Base, Collider, JointKind, JointValue, Keyframe, Region, Site, State
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3, Vec4
from casa_assets.model.registry.category import Portion


@dataclass(frozen=True)
class RigidMass:
    """A mass (kg) at `center` ((3,) metres, link frame) with its inertia ((3, 3) kg*m^2) about that point."""

    mass: float
    center: Floats
    inertia: Floats


def solid_mass(solid: Solid, density: float) -> RigidMass:
    """Mass properties of a closed solid of a density in kg/m^3. Raises ValueError where its volume is not positive."""
    volume, center, inertia = solid_moments(solid.points, solid.faces)
    if volume <= 0:
        raise ValueError(f"a solid of volume {volume:.3g} m^3 has no weight")
    return RigidMass(volume * density, np.array(center), np.array(inertia) * density)


def combine_masses(masses: list[RigidMass]) -> RigidMass:
    """Combine masses into one rigid body. Raises ValueError where the total is not positive."""
    mass = sum(m.mass for m in masses)
    if mass <= 0:
        raise ValueError("nothing that weighs anything")
    center: Floats = sum((m.mass * m.center for m in masses), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for m in masses:
        offset = m.center - center
        tensor += m.inertia + m.mass * (float(offset @ offset) * np.eye(3) - np.outer(offset, offset))
    return RigidMass(mass, center, tensor)


@dataclass
class BehaviorBuilder:
    """Variables, rules and effects in the order in which they were added."""

    variables: list[Variable] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    effects: list[Effect] = field(default_factory=list)

    def variable(self, name: str, *values: str) -> None:
        """Add a variable; its first value is the one at the start. Without values it is `off` and `on`."""
        values = values or ("off", "on")
        self.variables.append(Variable(name=name, values=values, initial=values[0]))

    def rule(self, variable: str, to: str, *when: Condition, before: str = "", after_s: float = 0.0) -> None:
        """Set a variable to a value where all conditions hold; `before`: only where it has that value, else any."""
        from_values = (before,) if before else ()
        self.rules.append(Rule(variable=variable, from_values=from_values, to=to, when=when, after_s=after_s))

    def follow_joint(self, name: str, joint: str, intervals: Mapping[str, Vec2]) -> None:
        """Add a variable with the value whose interval (rad, m) contains the joint's position; the first: at first."""
        self.variable(name, *intervals)
        for value, interval in intervals.items():
            self.rule(name, value, Condition(joint=joint, interval=interval))

    def effect(
        self,
        kind: EffectKind,
        variable: str,
        target: str,
        *,
        value: str = "on",
        color: Vec4 = (1.0, 1.0, 1.0, 1.0),
        strength: float = 1.0,
    ) -> None:
        """Add what happens to a target while a variable has a value."""
        effect = Effect(variable=variable, value=value, kind=kind, target=target, color=color, strength=strength)
        self.effects.append(effect)

    def light(self, variable: str, target: str, color: Vec4) -> None:
        """Let a target glow in a colour while a variable is `on`."""
        self.effect(EffectKind.LIGHT, variable, target, color=color)

    def build(self) -> Behavior | None:
        """The state machine, or None if there are no variables."""
        if not self.variables:
            return None
        return Behavior(variables=tuple(self.variables), rules=tuple(self.rules), effects=tuple(self.effects))


def negated(condition: Condition) -> Condition:
    """A condition that holds where the given one does not."""
    return condition.replace(negated=not condition.negated)


ROOT = "object"
# Directions that the grain of a finish runs along: across the front, from front to back, and upright.
ACROSS: Vec3 = (1.0, 0.0, 0.0)
ALONG: Vec3 = (0.0, 1.0, 0.0)
UPRIGHT: Vec3 = (0.0, 0.0, 1.0)


@dataclass
class VisualPart:
    """A solid of a link with its finish, label, mesh name and direction of the grain."""

    solid: Solid
    finish: str
    label: str | None
    name: str | None
    grain: Vec3


@dataclass
class JointBuilder:
    """A joint whose friction and damping are chosen by `assemble`, once the masses are known."""

    name: str
    child: str
    kind: JointKind
    axis: Vec3
    anchor: Vec3
    range: Vec2
    grip: str | None
    start_n: float
    spring: hand_dynamics.Spring | None
    lever: float | None
    push_n: float
    feel: hand_dynamics.Feel | None
    behind: str | None = None


@dataclass
class LinkBuilder:
    """A link with its visual parts, colliders and masses. `pose` is parent_from_link."""

    name: str
    parent: str | None
    pose: Pose
    parts: list[VisualPart] = field(default_factory=list)
    colliders: list[Collider] = field(default_factory=list)
    masses: list[RigidMass] = field(default_factory=list)


class AssetBuilder:
    """Collects links, joints, sites, regions, states and behaviour of one asset.

    Lengths are metres, z up, x right, the front faces -y. Everything may be built about any origin: `assemble` moves it
    to the middle of the footprint, on the ground.
    """

    def __init__(self, supplies: Supplies, base: Base = Base.FIXED) -> None:
        self.supplies = supplies
        self.base = base
        self.links: dict[str, LinkBuilder] = {ROOT: LinkBuilder(ROOT, None, Pose())}
        self.joints: list[JointBuilder] = []
        self.sites: list[Site] = []
        self.regions: list[Region] = []
        self.states: list[State] = []
        self.keyframes: list[Keyframe] = []
        self.behavior = BehaviorBuilder()
        self.contract: str | None = None
        self.portion: Portion | None = None

    def link(self, name: str, at: Vec3 | Pose = (0.0, 0.0, 0.0), parent: str = ROOT) -> str:
        """Add a link; `at` is parent_from_link. Returns its name. Raises ValueError where the name is taken."""
        if name in self.links:
            raise ValueError(f"link {name!r} occurs twice")
        self.links[name] = LinkBuilder(name, parent, at if isinstance(at, Pose) else Pose(position=at))
        return name

    def add(
        self,
        link: str,
        solid: Solid | Iterable[Solid],
        finish: str,
        label: str | None = None,
        name: str | None = None,
        grain: Vec3 = UPRIGHT,
        *,
        collider: str | bool = True,
        density: float | str | None = None,
        visible: bool = True,
    ) -> None:
        """Add a solid to a link: its mesh, its colliders and its mass.

        Args:
            solid: link frame; of several each is added in turn.
            finish: id of a finish in the supplies; its substance gives density and friction.
            label: what part it is; parts with the same finish and label are drawn as one mesh.
            name: of its mesh; a named part is drawn as a separate mesh called `<name>_visual`.
            grain: direction that the grain of its finish runs along, link frame.
            collider: False for no collider, a name for its (first) collider, True for a generated name.
            density: replaces the substance's density if a part is drawn solid but is not: a name in the supplies, or
                kg/m^3 if it is computed; 0 for no mass.
            visible: False for a solid with colliders and mass that is not drawn.
        """
        owner = self.links[link]
        chosen = self.supplies.finish(finish)
        if density is None:
            density = chosen.substance.density
        elif isinstance(density, str):
            density = self.supplies.density(density)
        for each in (solid,) if isinstance(solid, Solid) else solid:
            if visible:
                owner.parts.append(VisualPart(each, finish, label, name, grain))
            if density > 0:
                owner.masses.append(solid_mass(each, density))
            if collider is not False:
                shaped = each if each.shapes else each.with_hull_collider()
                first = collider if isinstance(collider, str) else name
                self._add_colliders(owner, shaped, chosen.substance.id, label, first)

    def draw(
        self,
        link: str,
        solid: Solid | Iterable[Solid],
        finish: str,
        label: str | None = None,
        name: str | None = None,
        grain: Vec3 = UPRIGHT,
        density: float | str | None = None,
    ) -> None:
        """Add a solid without colliders, with its mass; arguments as in `add`."""
        self.add(link, solid, finish, label, name, grain, collider=False, density=density)

    def add_collider(
        self,
        link: str,
        solid: Solid | Iterable[Solid],
        finish: str,
        label: str | None = None,
        name: str | None = None,
    ) -> None:
        """Add the colliders of a solid that is neither drawn nor weighed; arguments as in `add`."""
        self.add(link, solid, finish, label, name, density=0.0, visible=False)

    def _add_colliders(
        self, owner: LinkBuilder, solid: Solid, substance: str, label: str | None, name: str | None
    ) -> None:
        prefix = name or f"{owner.name}_{label or 'body'}"
        for i, (shape, pose) in enumerate(solid.shapes):
            collider_name = name if name and i == 0 else f"{prefix}_{len(owner.colliders):02d}"
            found = Collider(name=collider_name, shape=shape, pose=pose, substance=substance, label=label)
            owner.colliders.append(found)

    def ballast(self, link: str, mass: float, at: Vec3, size: Vec3) -> None:
        """Add a box of uniform mass in kg without mesh or collider: a motor, a compressor, a transformer."""
        x, y, z = size
        inertia = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) * mass / 12
        self.links[link].masses.append(RigidMass(mass, np.array(at), inertia))

    def hinge(
        self,
        name: str,
        child: str,
        axis: Vec3,
        span: Vec2,
        grip: str | None,
        *,
        anchor: Vec3 = (0.0, 0.0, 0.0),
        start_n: float = hand_dynamics.START_N,
        spring: hand_dynamics.Spring | None = None,
        lever: float | None = None,
        push_n: float = hand_dynamics.PULL_N,
        feel: hand_dynamics.Feel | None = None,
        behind: str | None = None,
    ) -> None:
        """Add a hinge that moves `child`; its friction and damping follow from the hand's force at the grip.

        Args:
            axis: child frame. span: (low, high) rad, one of them 0 (closed).
            grip: collider that the hand takes, on the child.
            anchor: a point of the axis, child frame.
            start_n: force at the grip that just moves it, N.
            spring: as `hand_dynamics.balance` and `hand_dynamics.press` make it.
            lever: metres from the axis to the hand; None measures it to the middle of the grip.
            push_n: strongest force that opens it, N.
            feel: instead of all that.
            behind: joint that has to be open before this one can move.
        """
        hinge = JointKind.HINGE
        self.joints.append(
            JointBuilder(name, child, hinge, axis, anchor, span, grip, start_n, spring, lever, push_n, feel, behind)
        )

    def slide(
        self,
        name: str,
        child: str,
        axis: Vec3,
        span: Vec2,
        grip: str | None,
        *,
        start_n: float = hand_dynamics.START_N,
        spring: hand_dynamics.Spring | None = None,
        push_n: float = hand_dynamics.PULL_N,
        feel: hand_dynamics.Feel | None = None,
        behind: str | None = None,
    ) -> None:
        """Add a slide that moves `child`; span in metres, one end 0. Arguments as in `hinge`."""
        kind, origin = JointKind.SLIDE, (0.0, 0.0, 0.0)
        self.joints.append(
            JointBuilder(name, child, kind, axis, origin, span, grip, start_n, spring, 1.0, push_n, feel, behind)
        )

    def site(self, name: str, at: Vec3 | Pose, link: str = ROOT, radius: float = 0.005) -> None:
        """Add a named point; `radius` in metres is the size it is shown with."""
        pose = at if isinstance(at, Pose) else Pose(position=at)
        self.sites.append(Site(name=name, link=link, pose=pose, radius=radius))

    def column(self, name: str, at: Vec3, size: Vec3, color: Vec4, link: str = ROOT) -> None:
        """Add a cylinder site about z that a runtime shows, such as a flame; size (diameter, diameter, height)."""
        self.sites.append(Site(name=name, link=link, pose=Pose(position=at), kind="cylinder", size=size, color=color))

    def region(self, name: str, lower: Vec3, upper: Vec3, link: str = ROOT) -> None:
        """Add a box region between two corners, link frame, metres."""
        middle = tuple((a + b) / 2 for a, b in zip(lower, upper, strict=True))
        size = tuple(b - a for a, b in zip(lower, upper, strict=True))
        self.regions.append(Region(name=name, link=link, pose=Pose(position=middle), size=size))

    def round_region(self, name: str, at: Vec3, diameter: float, height: float, link: str = ROOT) -> None:
        """Add a cylinder region about z; `at` is the centre of its floor, link frame, metres."""
        pose = Pose(position=(at[0], at[1], at[2] + height / 2))
        self.regions.append(Region(name=name, link=link, pose=pose, kind="cylinder", size=(diameter, diameter, height)))

    def state(self, joint: str, value: str, interval: Vec2) -> None:
        """Add a named interval of a joint, in fractions of its range from closed (0) to open (1)."""
        self.states.append(State(name=f"{joint}_{value}", joint=joint, value=value, interval=interval))

    def door_states(self, *joints: str) -> None:
        """Add the states `closed` and `open` of door joints. Ref: robocasa v1.0, is_closed 0.005, is_open 0.9."""
        for joint in joints:
            self.state(joint, "closed", (0.0, 0.005))
            self.state(joint, "open", (0.9, 1.0))

    def keyframe(self, name: str, **joints: float) -> None:
        """Add a named pose: joint name -> rad or m."""
        values = tuple(JointValue(joint=j, value=v) for j, v in joints.items())
        self.keyframes.append(Keyframe(name=name, joints=values))

    def joint_position(self, joint: str, share: float = 1.0) -> float:
        """Position of a joint at a share of its range from zero, rad or m."""
        return share * max(next(m.range for m in self.joints if m.name == joint), key=abs)
