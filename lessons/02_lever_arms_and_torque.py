# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 02 · Lever arms and torque
#
# Lay a finger on the palmar side of your other wrist, flex that wrist against a table, and feel the tendons rise under the skin. How
# far such a tendon runs from the axis of the joint decides two things at once: how strongly it turns the joint, and how far.
#
# After this lesson you can
#
# - compute the torque of a muscle about an axis, and say what the bearing of the joint takes up;
# - read the direction of a muscle from its lever arms, and not from its name;
# - measure a lever arm with a ruler, without seeing the tendon;
# - list all that turns a joint, down to what is left;
# - say which muscles cannot serve all their joints at once.
#
# Where you see `...`, an answer of yours is missing.

# %%
import handlab as hl
import numpy as np
from handlab.check import lesson
from handlab.show.panels import MusclePanel

check = lesson("02")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# Push a door near its hinge, then at its handle: the same force, another effect. What turns is force times distance from the axis.
# A tendon is a rope that passes the axis of a joint at a distance of a few millimetres: its **lever arm**, with a sign.
#
# Below, every muscle is drawn at its lever arms for the two rotations of a joint: that is the direction in which it pulls. The area of
# the disc is its strength. Find the muscle that bends your wrist towards the little finger.

# %%
hl.pull_map(hand)

# %% [markdown]
# ## 2 The equation
#
# $$ T = \langle \mathbf a,\ \mathbf r \times \mathbf F \rangle \qquad\text{and for all muscles at once}\qquad T = R^{\mathsf T} F $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\mathbf a$ | axis of the rotation, length 1 | `dof.axis` | 1 |
# | $\mathbf r$ | arm: from the axis to the line of pull | `muscle.lever_arms` | m |
# | $\mathbf F$ | force of the tendon | `clip.force` | N |
# | $R$ | signed lever arms, a row per muscle, a column per rotation | `hand.lever_arm` | m |
# | $T$ | torque | `clip.torque` | N m |
#
# $\mathbf r \times \mathbf F$ is a vector. Only its part along the axis turns the bone; the rest presses on the joint, which holds.
#
# ### Exercise: the equation in your own lines
#
# `axis`, `arm` and `force` are arrays of three numbers. `np.cross` multiplies two vectors into a third, `a @ b` into a number.


# %%
def own_torque(axis, arm, force):
    # solution: return ...
    vector = np.cross(arm, force)
    return axis @ vector
    # end solution


check("own_torque", own_torque)

# %% [markdown]
# ### Exercise: break it
#
# The paper prints something else: the *length* of the vector, with the sign of its part along the axis (2''). For one tendon at right
# angles to the axis that is the same. Now take a flexor and an extensor of a joint with the axis (1, 0, 0). Their vectors
# $\mathbf r\times\mathbf F$ are given in N m. What is their net torque as printed, and about the axis?

# %%
axis, flexor, extensor = np.array([1.0, 0, 0]), np.array([0.3, 0.2, 0]), np.array([-0.2, 0.1, 0])
# solution: printed, about_axis = ..., ...
total = flexor + extensor
printed = np.sign(axis @ total) * np.linalg.norm(total)
about_axis = axis @ total
# end solution
check("antagonists", printed, about_axis)

# %% [markdown]
# ## 3 Names are not directions
#
# Spread your fingers, and close them again. *Abduction* leads away from the middle line of the hand, which runs through the middle
# finger, and *adduction* towards it. *Radial* is the side of the thumb, *ulnar* that of the little finger. These are not the same
# words: the index finger abducts to the radial side, the little finger to the ulnar side. In the model radial is plus.
#
# ### Exercise: which way?
#
# The three palmar interossei adduct: `PI1` the index finger, `PI2` the ring finger, `PI3` the little finger. Which way does each of them
# turn its finger, `"radial"` or `"ulnar"`?
#
# And the *abductor pollicis longus*, `APL`, the long abductor of the thumb: at which rotation does it have its longest lever arm?
# Give a name like `"cmc1.abduction_adduction"`.

# %%
# solution: directions, rotation = {"PI1": ..., "PI2": ..., "PI3": ...}, ...
directions = {"PI1": "ulnar", "PI2": "radial", "PI3": "radial"}
rotation = "wrist.deviation"
# end solution
check("words", directions, rotation)
hand.muscles["APL"]

# %% [markdown]
# ## 4 Measure a lever arm with a ruler
#
# A tendon that passes an axis at distance $r$ moves by $r\,\varphi$ when the joint turns by $\varphi$: it winds up like a rope on a
# drum. So nobody has to see the tendon; it is enough to see how far its end moves.
#
# ### Exercise: measure
#
# Pose the hand twice, with `pip2.flexion_extension` at 20 and at 80 degrees and everything else the same. From the two fibre lengths
# of `FDP2` find its lever arm at this joint, in millimetres, with its sign.

# %%
row = hand.muscle_names.index(hand.muscles["FDP2"].name)
# solution: arm_mm = ...
angles = np.deg2rad([20, 80])
lengths = [hl.pose(hand, {"pip2.flexion_extension": angle}).fibre_length[row] for angle in angles]
arm_mm = 1000 * -(lengths[1] - lengths[0]) / (angles[1] - angles[0])
# end solution
check("measure", arm_mm)

# %% [markdown]
# ### Exercise: all torques at once
#
# The matrix $R$ that gives lengths from angles gives torques from forces. Write $T = R^{\mathsf T} F$: 42 forces in, 31 torques out.


# %%
def own_torques(hand, force):
    # solution: return ...
    return hand.lever_arm.T @ force
    # end solution


check("all_torques", own_torques)

# %% [markdown]
# ## 5 Who turns the joint?
#
# A question first: `FDP2` is to close the index finger to the fist. Which one muscle pulls most strongly against it at the knuckle
# `mcp2`? Write down a guess, as an abbreviation.

# %%
# solution: my_guess = ...
my_guess = "EDC2"
# end solution
check("guess_opponent", my_guess)

# %% [markdown]
# Here is everything that acts on this knuckle at the end of the clip `fist`, largest first. Each bar begins where the last one ends;
# what is left at the bottom would turn the joint. Filled: active. Hatched: nobody told it to, it is stretched.

# %%
fist = hl.simulate(hand, hl.keyframes("fist"))
hl.torque_balance(fist, "mcp2")

# %% [markdown]
# ### Exercise: read the list
#
# Which muscle extends `mcp2` most? And how much of the torque of `FDP2` does it take back, as a part of it, without sign?

# %%
# solution: opponent, share = ..., ...
k = hand.dof_names.index("mcp2.flexion_extension")
torques = {m.abbreviation: hand.lever_arm[i, k] * fist.force[-1, i] for i, m in enumerate(hand.muscles.values())}
opponent = min(torques, key=torques.get)
share = -torques[opponent] / torques["FDP2"]
# end solution
check("opponent", opponent, share)

# %% [markdown]
# Try it: with which of these three does the finger bend, with which does it go sideways? Say it first, then move the sliders.

# %%
panel = MusclePanel(hand, ["FDP2", "DI1", "EIP"], hold=["wrist"])
panel

# %% [markdown]
# Fibre lengths and joint angles while `FDP2` pulls, then `DI1` joins in, then `EIP`. To see who turns the finger sideways at the end:
# `hl.torque_balance(panel.clip, "mcp2.deviation")`.

# %%
panel.reset()
for more in ({"FDP2": 0.1}, {"DI1": 0.2}, {"EIP": 0.3}):
    panel.set(**more)
hl.curves(panel.clip, muscles=["FDP2", "DI1", "EIP"], joints=["mcp2", "pip2"])

# %% [markdown]
# ## 6 What a long arm costs
#
# A long lever arm gives torque. But the fibre must shorten more for the same angle, and it can shorten only from 1.6 to 0.6 of its
# rest length: by one rest length. This is its **potential excursion**. The **required excursion** is what its joints ask for.
#
# ### Exercise: the torn pulley
#
# Ligaments hold the flexor tendons close to the finger bones, like the rings of a fishing rod: the pulleys. A climber tears one. The
# arm of `FDP2` at `pip2` grows from 7.9 to 12 mm (say), and its fibre has 15 mm of shortening left for this joint.
#
# By which factor does the torque grow, if the force stays the same? How far can the joint bend before and after, in degrees?

# %%
# solution: torque_factor, before_deg, after_deg = ..., ..., ...
torque_factor = 12 / 7.9
before_deg = np.rad2deg(15 / 7.9)
after_deg = np.rad2deg(15 / 12)
# end solution
check("pulley", torque_factor, before_deg, after_deg)

# %% [markdown]
# ### Exercise: what the joints ask for
#
# For every muscle, add up the sizes of arm times range over the 23 rotations that move by themselves, in metres. Below the check the
# package draws the same: bars are required, from the wrist outwards, and diamonds are what the fibre can give.


# %%
def required(hand):
    arms = hand.lever_arm @ hand.coupling
    low, high = np.array([hand.dofs[name].limits for name in hand.moving_names]).T
    # solution: return ...
    return np.abs(arms) @ (high - low)
    # end solution


check("required", required)
hl.excursion_plot(hand)

# %% [markdown]
# ### Exercise: one muscle for too many joints
#
# Almost every muscle that crosses wrist and finger is asked for more than it has. In everyday life the wrist helps: it extends when the
# fingers flex. Among the muscles of the *thumb* (`FPL`, `EPL`, `APL`, `EPB`, `APB`, `FPB`, `OPP`, `ADP`), which are asked for too much?

# %%
# solution: asked_too_much = ...
asked_too_much = {"FPL"}
# end solution
check("too_far", asked_too_much)

# %% [markdown]
# ## 7 Force or excursion
#
# Paul Brand, a surgeon who moved tendons of leprosy patients to new places, drew his muscles like this: strength upwards, fibre length
# to the right. A muscle can be replaced by one that is its neighbour here.

# %%
hl.brand_plot(hand)

# %% [markdown]
# ### Exercise: strongest, farthest, hardest working
#
# Which muscle has the largest force, which the longest fibres, and which can do the most work in one contraction? How much is that in
# joules? The force is not the same all the way: the area under the active curve from 1.6 to 0.6 is two thirds of $F_\text{max}\,\ell_0$.

# %%
# solution: strongest, farthest, hardest, joule = ..., ..., ..., ...
names = hand.muscle_names
strongest, farthest = names[np.argmax(hand.max_force)], names[np.argmax(hand.rest_length)]
hardest = names[np.argmax(hand.max_force * hand.rest_length)]
joule = 2 / 3 * np.max(hand.max_force * hand.rest_length)
# end solution
check("work", strongest, farthest, hardest, joule)

# %% [markdown]
# ## 8 Extend, and doubt
#
# ### Exercise: a muscle that hangs on a tendon
#
# A lumbrical does not begin at a bone: it begins at the tendon of the deep flexor. When it contracts it pulls that tendon towards the
# fingertip, and slackens it. While the tendon is taut, its arms are its own *minus* those of the deep flexor. Table 1 ignores this.
#
# Which arms does `LUM1` get against `FDP2` at `mcp2`, `pip2` and `dip2`, in millimetres?

# %%
joints = ["mcp2.flexion_extension", "pip2.flexion_extension", "dip2.flexion_extension"]
columns = [hand.dof_names.index(name) for name in joints]
# solution: effective_mm = ...
lum1 = hand.muscle_names.index(hand.muscles["LUM1"].name)
effective_mm = 1000 * (hand.lever_arm[lum1, columns] - hand.lever_arm[row, columns])
# end solution
check("lumbrical", effective_mm)

# %% [markdown]
# ### Exercise: doubt the data
#
# `hl.load_hand(reading="printed")` has the lever arms as the paper prints them. At some muscle one of them has the opposite sign of the
# one that is used here. Compare the two matrices and name all these muscles; `hand.muscles["..."]` gives sources and reasons.
#
# One of them you can test: hold your hand flat, and lift only the index finger against a resistance. Does your wrist want to flex
# along with it, or to extend?

# %%
printed_hand = hl.load_hand(reading="printed")
# solution: other_sign = ...
opposite = (np.sign(printed_hand.lever_arm) * np.sign(hand.lever_arm) < 0).any(axis=1)
other_sign = {muscle.abbreviation for muscle, differs in zip(hand.muscles.values(), opposite, strict=True) if differs}
# end solution
check("doubt", other_sign)

# %% [markdown]
# ## Summary
#
# - Torque is the part of $\mathbf r\times\mathbf F$ along the axis. Its length, as printed, counts what the joint's bearing takes up.
# - $R$ gives lengths from angles and torques from forces; a lever arm is excursion per radian.
# - Abduction is not radial, and a muscle's name is not its direction: look at its arms.
# - A posture is a balance of active and passive torques; the largest opponent is often nobody's command.
# - Torque and range are bought with the same millimetres. Muscles that pass many joints cannot serve all of them at once.

# %%
check.summary()
