"""``to_mjcf``: a hand as a model for MuJoCo, in one file that needs no other.

Bodies, hinges and tendons are exact: MuJoCo's mass matrix and bias are ours. What MuJoCo's own laws cannot hold is listed in
``DIFFERENCES``, which every file repeats at its top.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Body, Hand
from handlab.physics.muscle import ACTIVE_CURVATURE, ACTIVE_PEAK, PASSIVE_CURVATURE
from handlab.simulation.kinematics import tree
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.mjcf_meshes import add_bones, add_skin, body_origins, numbers

ABOUT = """
A hand of handlab. World and bodies: x distal, y palmar, z radial (of a right hand); metres, kilograms, radians, newtons.
All angles zero is the straight hand; key frame "relaxed" is the hand at rest. Each actuator is a muscle: ctrl = contraction, 0 to 1.
A tendon's length is the fibre's length less a constant: its coefficients are the lever arms, negative because what flexes shortens.
Bones lie under the skin: switch off Skin in the viewer. Needs MuJoCo 3.7 or later. What differs from handlab's own laws:
"""

# What MuJoCo's laws cannot hold.
DIFFERENCES = (
    "Active force: exact from 0.75 to 1.45 rest lengths; farther out MuJoCo's bell fades to nothing at 0.39 and 1.81 "
    "instead of 0.6 and 1.6, up to 0.18 of the maximum force too strong.",
    "Limits: soft constraints with a time constant of two steps at the limit itself; handlab lets a strong muscle press a joint "
    "up to two degrees past it into its capsule.",
    "Capsules: their torque is exact where no collateral ligament narrows the range; their damping is missing.",
    "Collateral ligaments: MCP flexion narrows the range of deviation in proportion, not smoothly, and does not stiffen its spring.",
    "Couplings: equality constraints; when strong muscles jerk, a follower may lag by up to a degree for a few hundredths of a second.",
    "Friction: viscous and against the motion in every reading; the printed friction law has no counterpart.",
    "Skin: blended linearly instead of by dual quaternions, without texture.",
)

# s. MuJoCo takes springs explicitly, and followers weigh next to nothing: with 1 ms, half of all muscles at full contraction blow the
# hand up; with 0.2 ms joints stay within 0.7 degrees of their limits, and followers within 0.01 degrees once the jerk is over.
TIMESTEP = 0.0002
# The shortest time constant that MuJoCo holds stable is two steps.
STIFF = {"solref": f"{2.0 * TIMESTEP:g} 1", "solimp": "0.99 0.9999 0.0001"}
# In its middle half MuJoCo's bell-shaped force-length curve is the parabola 1 - 0.5 ((L - 1) / w)^2, w a quarter of the base:
# this w makes it 1 - 4 (ratio - 1.1)^2, with L = ratio / 1.1.
QUARTER = float(np.sqrt(0.5 / ACTIVE_CURVATURE)) / ACTIVE_PEAK
# A muscle's force does not depend on its speed: MuJoCo's largest speed, in lengths per second, is out of reach.
NO_SPEED_EFFECT = 1e9
FAR = 10.0  # rad or m: farther than any tendon goes slack


def to_mjcf(hand: Hand, *, gravity: ArrayLike = (0.0, 0.0, 0.0), laws: bool = True, bones: bool = True, skin: bool = True) -> str:
    """The hand as MJCF text for MuJoCo 3.7 or later: ``mujoco.MjModel.from_xml_string(hl.to_mjcf(hand))``.

    Bodies, tendons and actuators bear the names of ``body_names`` and ``muscle_names`` and stand in their order; joints bear those of
    ``dof_names`` but stand digit by digit (``model.joint(name).qposadr``). ``gravity`` (3,) m/s^2 in the hand's frame, such as
    ``(-9.81, 0, 0)`` for fingers that point up; MuJoCo's viewer draws z upwards. ``laws=False``: joints, masses and tendons alone, without
    limits, springs, friction, couplings and force-length curves; each actuator then pulls with as many newtons as its ``ctrl`` says.
    ``bones``, ``skin``: meshes for the eye, without mass or contact.

    Raises ``ValueError`` for what MuJoCo cannot hold: a body without mass or with an inertia that no body has, a muscle
    without any lever arm, a gravity that is not three numbers. What it holds differently: ``DIFFERENCES``.
    """
    if not isinstance(hand, Hand):
        raise TypeError(f"to_mjcf takes a hand, not {type(hand).__name__}; a clip's hand is clip.hand")
    pull = checked_gravity(gravity)
    root = Element("mujoco", model=hand.name)
    known = "\n".join(f"- {line}" for line in DIFFERENCES) if laws else "all of them: this file was made with laws=False."
    root.append(Comment(f"{ABOUT}{known}\n".replace("--", "-")))
    SubElement(root, "compiler", angle="radian", autolimits="true", boundmass="0", balanceinertia="false", inertiafromgeom="false")
    SubElement(root, "option", timestep=f"{TIMESTEP:g}", integrator="implicitfast", gravity=numbers(pull))
    origin = body_origins(hand)
    add_looks(root)
    asset, world = SubElement(root, "asset"), SubElement(root, "worldbody")
    add_scenery(asset, world)
    elements = add_bodies(world, hand, origin, laws)
    if bones:
        add_bones(asset, elements, hand, origin)
    if skin:
        add_skin(SubElement(root, "deformable"), hand, origin)
    tendons, actuators = SubElement(root, "tendon"), SubElement(root, "actuator")
    add_muscles(tendons, actuators, hand, laws)
    if laws:
        add_capsules(tendons, hand)
        add_couplings(SubElement(root, "equality"), hand)
    relaxed = dict(zip(hand.dof_names, coupled(hand, mechanics(hand).relaxed), strict=True))
    digit_by_digit = [relaxed[hinge.get("name", "")] for element in elements.values() for hinge in element.findall("joint")]
    SubElement(SubElement(root, "keyframe"), "key", name="relaxed", qpos=numbers(digit_by_digit))
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def checked_gravity(gravity: ArrayLike) -> Array:
    """Three finite numbers, or an error."""
    try:
        values = np.array(gravity, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ValueError(f"gravity is {gravity!r}; give three numbers in m/s^2 in the hand's frame, such as (-9.81, 0, 0)")
    return values


def add_looks(root: Element) -> None:
    """Size of the scene, picture size, colour of bones."""
    SubElement(root, "statistic", center="0.055 0.01 0", extent="0.2")
    visual = SubElement(root, "visual")
    SubElement(visual, "global", offwidth="1280", offheight="960", azimuth="60", elevation="-20")
    SubElement(visual, "headlight", ambient="0.35 0.35 0.35", diffuse="0.55 0.55 0.55", specular="0.1 0.1 0.1")
    kind = SubElement(SubElement(root, "default"), "default", {"class": "bone"})
    # bones are for the eye: their mass is in the bodies, and skin, not bone, would touch
    SubElement(kind, "geom", type="mesh", contype="0", conaffinity="0", group="1", rgba="0.93 0.89 0.78 1")


def add_scenery(asset: Element, world: Element) -> None:
    """Sky, light, and cameras that look at palm and back, fingers up."""
    SubElement(asset, "texture", type="skybox", builtin="gradient", rgb1="0.85 0.9 0.95", rgb2="0.45 0.5 0.58", width="64", height="384")
    for side in ("1", "-1"):
        SubElement(world, "light", type="directional", dir=f"-0.2 {side} -0.5", diffuse="0.25 0.25 0.25", castshadow="false")
    SubElement(world, "camera", name="palm", pos="0.055 0.33 0.005", xyaxes="0 0 1 1 0 0", fovy="40")
    SubElement(world, "camera", name="back", pos="0.055 -0.33 0.005", xyaxes="0 0 -1 1 0 0", fovy="40")


def add_bodies(world: Element, hand: Hand, origin: Mapping[str, Array], laws: bool) -> dict[str, Element]:
    """Rigid bodies in the zero posture, each with its origin in the centre of its joint and axes along the hand's; by name."""
    m, axis = mechanics(hand), dict(zip(hand.dof_names, tree(hand).axis, strict=True))
    elements: dict[str, Element] = {}
    for row, (name, body) in enumerate(hand.bodies.items()):
        check_body(body)
        above = world if body.parent is None else elements[body.parent]
        shift = origin[name] - (0.0 if body.parent is None else origin[body.parent])
        element = elements[name] = SubElement(above, "body", name=name, pos=numbers(shift))
        i = m.inertia[row]
        SubElement(
            element,
            "inertial",
            pos=numbers(m.centre[row] - origin[name]),
            mass=numbers(body.mass),
            fullinertia=numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]),
        )
        for dof in () if body.joint is None else hand.joints[body.joint].dofs:
            hinge = SubElement(element, "joint", name=dof.name, type="hinge", axis=numbers(axis[dof.name]))
            hinge.set("pos", numbers(dof.anchor - origin[name]))
            if laws:
                add_joint_laws(hinge, hand, hand.dof_names.index(dof.name))
    return elements


def add_joint_laws(hinge: Element, hand: Hand, row: int) -> None:
    """Friction, stiffness about the relaxed posture, and limits; a follower has the limits of what it follows."""
    m, name = mechanics(hand), hand.dof_names[row]
    hinge.set("damping", numbers(np.broadcast_to(hand.friction, len(hand.dof_names))[row]))
    hinge.set("stiffness", numbers(hand.stiffness[row]))
    hinge.set("springref", numbers(coupled(hand, m.relaxed)[row]))
    if name in hand.moving_names:
        hinge.set("range", numbers(m.limits[hand.moving_names.index(name)]))
        hinge.set("solreflimit", STIFF["solref"])
        hinge.set("solimplimit", STIFF["solimp"])


def add_muscles(tendons: Element, actuators: Element, hand: Hand, laws: bool) -> None:
    """Fixed tendons with lever arms as coefficients, the stretched fibre's force as their spring, and the actuators that pull them."""
    m = mechanics(hand)
    bell = [1.0 - 2.0 * QUARTER, 1.0 + 2.0 * QUARTER]
    for i, name in enumerate(hand.muscle_names):
        crossed = np.flatnonzero(hand.lever_arm[i])
        if not len(crossed):
            raise ValueError(f"muscle {name!r} has no lever arm anywhere, and MuJoCo's tendons need one; leave that muscle out")
        tendon = SubElement(tendons, "fixed", name=name)
        for k in crossed:
            SubElement(tendon, "joint", joint=hand.dof_names[k], coef=numbers(-hand.lever_arm[i, k]))
        if not laws:
            SubElement(actuators, "general", name=name, tendon=name, gainprm="-1")
            continue
        rest, force = m.rest_length[i], m.max_force[i]
        # fibre length = tendon length + its length in the straight hand
        slack = rest - m.length_at_zero[i]
        tendon.set("stiffness", numbers([0.0, PASSIVE_CURVATURE * force / rest**2]))
        tendon.set("springlength", numbers([slack - FAR, slack]))
        ends = np.array(bell) * ACTIVE_PEAK * rest - m.length_at_zero[i]
        SubElement(
            actuators,
            "general",
            name=name,
            tendon=name,
            ctrlrange="0 1",
            dyntype="none",
            gaintype="muscle",
            biastype="none",
            lengthrange=numbers(ends),
            # range, force, scale (unused), shortest and longest length, largest speed, passive force (unused), effect of stretching
            gainprm=numbers([*bell, force, 1.0, *bell, NO_SPEED_EFFECT, 1.0, 1.0]),
        )


def add_capsules(tendons: Element, hand: Hand) -> None:
    """T u^3 toward the middle near each limit, u = 1 at the limit: a cubic spring that is slack elsewhere.

    Where flexion narrows the range of a deviation, spring and limit act on deviation + slope * flexion: they narrow in proportion.
    """
    m, capsule = mechanics(hand), hand.capsule
    for k, name in enumerate(hand.moving_names):
        flexion = int(m.tightened_by[k])
        left = 1.0 if flexion < 0 else m.range_fraction
        for side, sign, limit in (("lower", -1.0, -m.limits[k, 0]), ("upper", 1.0, m.limits[k, 1])):
            if capsule is None and left == 1.0:
                continue
            # from here on as if the limit were an upper one
            spring = SubElement(tendons, "fixed", name=f"{name}.{side}")
            SubElement(spring, "joint", joint=name, coef=numbers(sign))
            if left < 1.0:
                slope = (1.0 - left) * limit / m.taut_at
                SubElement(spring, "joint", joint=hand.moving_names[flexion], coef=numbers(slope))
                spring.set("range", numbers([limit - FAR, limit]))
                spring.set("solreflimit", STIFF["solref"])
                spring.set("solimplimit", STIFF["solimp"])
            if capsule is not None:
                width = m.width[k] * (1.0 + left) / 2.0  # the mean of straight and flexed
                at_limit = m.torque_at_limit[k, int(sign > 0.0)]
                spring.set("springlength", numbers([limit - width - FAR, limit - width]))
                spring.set("stiffness", numbers([0.0, 0.0, at_limit / width**3]))


def add_couplings(equality: Element, hand: Hand) -> None:
    """Each follower as a joint equality, angle = ratio * driver + offset; one that follows a follower is tied to the first driver."""
    for row, (name, dof) in enumerate(hand.dofs.items()):
        driver = dof
        while driver.driver is not None:
            driver = hand.dofs[driver.driver]
        if driver is not dof:
            ratio = hand.coupling[row, hand.moving_names.index(driver.name)]
            line = numbers([hand.coupling_offset[row], ratio, 0.0, 0.0, 0.0])
            SubElement(equality, "joint", {**STIFF, "joint1": name, "joint2": driver.name, "polycoef": line})


def check_body(body: Body) -> None:
    """Refuse a mass or an inertia that MuJoCo does not take, by name."""
    moments = np.linalg.eigvalsh(body.inertia)
    if not body.mass > 0.0 or not moments[0] > 0.0:
        raise ValueError(f"body {body.name!r} has mass {body.mass:g} kg and moments {moments} kg m^2; MuJoCo needs positive ones")
    if moments[0] + moments[1] < moments[2]:
        raise ValueError(f"body {body.name!r} has moments of inertia {moments} kg m^2: of no solid body, one exceeds the sum of the others")
