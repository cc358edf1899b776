"""Objects of registry/objects/ in MuJoCo: what is put in stays in, a mug hangs by its handle, lids come off."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.checks.motion.simulation import collision_spec
from casa_assets.formats import mjcf
from casa_assets.kitchenware.objects.closures import LID, LID_JOINT
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, JointKind
from tests.unit.families.test_objects import member, params_of

STEP_S = 0.002
MEMBERS = range(3)


class World:
    """A floor, and things on it; bodies of an asset are called `<its name>_<link>`."""

    def __init__(self, *, ball: float = 0.0, peg: float = 0.0, **assets: Asset) -> None:
        """A ball and a fixed peg along y through the origin, of a radius, metres, and assets by name."""
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP_S
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], pos=[0, 0, -1 if peg else 0])
        if peg:
            spec.worldbody.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[peg, 0.1, 0], quat=[np.sqrt(0.5), np.sqrt(0.5), 0, 0]
            )
        if ball:
            body = spec.worldbody.add_body(name="ball")
            body.add_freejoint(name="ball_free")
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[ball, 0, 0], mass=0.02, condim=6)
        for name, asset in assets.items():
            thing = collision_spec(mjcf.write(asset))
            thing.worldbody.first_body().add_freejoint(name="free")
            spec.attach(thing, prefix=f"{name}_", frame=spec.worldbody.add_frame())
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)

    def put(self, name: str, at: tuple[float, float, float], turn: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)) -> None:
        """Place an asset or a ball; turn is a quaternion (w, x, y, z)."""
        self.data.joint(f"{name}_free").qpos[:] = (*at, *turn)
        mujoco.mj_forward(self.model, self.data)

    def run(self, seconds: float) -> None:
        mujoco.mj_step(self.model, self.data, nstep=int(seconds / STEP_S))

    def at(self, body: str) -> np.ndarray:
        """Where the centre of mass of a body is."""
        return np.array(self.data.body(body).xipos)

    def speed(self, body: str) -> float:
        """Largest of the speeds of a body, m/s and rad/s."""
        return float(np.abs(self.data.body(body).cvel).max())


@pytest.mark.content("object", "{category}", keep=2)
@pytest.mark.parametrize("category", ["bowl", "mug", "cup", "pot", "saucepan", "colander", "basket"])
def test_a_ball_that_falls_into_a_vessel_stays_in_it(category: str) -> None:
    for index in MEMBERS:
        vessel = member(category, index)
        touched = link_bounds(vessel.root)
        assert touched is not None
        beyond = float(np.abs(touched - vessel.bounds)[:, 1].max())
        # Strands of baskets go out and in.
        assert category == "basket" or beyond < 0.0025, "walls are touched where they are seen"
        world = World(ball=0.015, vessel=vessel)
        # Open things have their handles at one side: the middle of what collides is not that of the mouth.
        world.put("ball", (world.at("vessel_object")[0] * 0.5, 0.01, float(vessel.bounds[1, 2]) + 0.05))
        world.run(3.0)
        low, high = vessel.bounds
        assert (world.at("ball") > (*low[:2], max(low[2], 0.002))).all()
        assert (world.at("ball") < high).all()


@pytest.mark.content("object", "mug", keep=1)
@pytest.mark.parametrize("index", MEMBERS)
def test_a_mug_hangs_by_its_handle_on_a_peg(index: int) -> None:
    params, mug, peg = params_of("mug", index), member("mug", index), 0.004
    hole = np.array([float(mug.bounds[1, 0]) - params.handle_thick - peg - 0.001, 0.0])
    hole[1] = params.height * (params.handle_top + params.handle_low) / 2
    world = World(peg=peg, mug=mug)
    # Its handle upwards: x of the mug to z, z of it to -x.
    world.put("mug", (hole[1], 0.0, -hole[0]), (np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0))
    start = world.at("mug_object")
    world.run(4.0)
    assert abs(world.at("mug_object")[2] - start[2]) < 0.03
    assert world.speed("mug_object") < 4.0


@pytest.mark.content("object", "spoon", keep=1)
@pytest.mark.content("object", "bowl")
@pytest.mark.parametrize("index", MEMBERS)
def test_a_spoon_comes_to_rest_in_a_bowl(index: int) -> None:
    bowl, spoon = member("bowl", index), member("spoon", index)
    world = World(bowl=bowl, spoon=spoon)
    # Steeply leaning, its head a little above the floor of the bowl.
    half, long = 0.45, float(spoon.bounds[1, 0])
    at = (np.cos(2 * half) * long - 0.02, 0.0, np.sin(2 * half) * long + 0.02)
    world.put("spoon", at, (np.cos(half), 0.0, -np.sin(half), 0.0))
    world.run(4.0)
    assert world.speed("spoon_object") < 0.05
    assert np.hypot(*world.at("spoon_object")[:2]) < float(bowl.bounds[1, 0])
    bodies = [{world.model.body(world.model.geom_bodyid[g]).name for g in c.geom} for c in world.data.contact]
    assert {"bowl_object", "spoon_object"} in bodies


def opening(category: str, kind: JointKind | None = None, empty: bool = False) -> Asset:
    """The first member whose lid comes off."""
    for index in range(120):
        params = params_of(category, index)
        opens = getattr(params, "opens", False) or getattr(params, "lid_opens", False)
        if opens and (not empty or params.fill < 0.02):
            asset = member(category, index)
            if kind in (None, asset.joints[0].kind):
                return asset
    raise AssertionError(f"no {category} opens")


@pytest.mark.content("object", "{category}", keep=2)
@pytest.mark.parametrize(
    "category", ["jar", "jam", "peanut_butter", "bottled_water", "thermos", "teapot", "saucepan_with_lid"]
)
def test_a_lid_is_lifted_off_what_nobody_holds(category: str) -> None:
    asset = opening(category, JointKind.SLIDE)
    (joint,) = asset.joints
    assert {s.value for s in asset.states} == {"closed", "open"}
    world = World(it=asset)
    world.run(0.5)
    start = world.at("it_object")
    lid = world.model.body(f"it_{LID}").id
    world.data.xfrc_applied[lid, 2] = joint.frictionloss + (world.model.body_mass[lid] * 9.81) + 0.7
    world.run(3.0)
    assert world.data.joint(f"it_{LID_JOINT}").qpos[0] > 0.9 * joint.range[1]
    assert np.abs(world.at("it_object") - start).max() < 0.001
    world.data.xfrc_applied[lid] = 0.0
    world.run(1.0)
    assert world.data.joint(f"it_{LID_JOINT}").qpos[0] > 0.85 * joint.range[1], "it stays where the hand let it go"


@pytest.mark.content("object", "jar", keep=1)
@pytest.mark.parametrize("kind", [JointKind.SLIDE, JointKind.HINGE])
def test_an_open_jar_takes_a_ball_and_a_closed_one_does_not(kind: JointKind) -> None:
    jar = opening("jar", kind, empty=True)
    (joint,) = jar.joints
    mouth = float(jar.link(LID).pose.position[2])
    for share, enters in ((1.0, True), (0.0, False)):
        world = World(ball=0.01, jar=jar)
        world.data.joint(f"jar_{LID_JOINT}").qpos[0] = share * joint.range[1]
        world.put("ball", (0.0, -0.005, (mouth if enters else float(jar.bounds[1, 2])) + 0.02))
        world.run(2.0)
        is_within = world.at("ball")[2] < 0.5 * mouth and np.hypot(*world.at("ball")[:2]) < jar.bounds[1, 0]
        assert bool(is_within) is enters
