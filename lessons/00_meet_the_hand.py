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
# # 00 · Meet the hand
#
# Hold your own hand in front of you. You will need it: everything on this page can be felt on it.
#
# After this lesson you can
#
# - name the bones and the 20 joints of a hand, and say which of them move together;
# - read and set a joint angle, with the right sign and the right unit;
# - say what stops a joint, and measure it;
# - tell extrinsic from intrinsic muscles, and predict what one of them moves;
# - compute the length of a muscle fibre from the joint angles, in one line.
#
# Run a cell with **Shift+Enter**. Where you see `...`, an answer of yours is missing; the check in the same cell says whether it is
# right, and never stops you.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.show.panels import MusclePanel, Postures

check = lesson("00")
hand = hl.load_hand()
hand

# %% [markdown]
# ## 1 The idea
#
# Nobody in this laboratory sets a finger into place. Muscles contract, their tendons pull at lever arms, and the joints turn until
# all torques balance. You give contractions between 0 (slack) and 1 (as hard as it can); posture is what comes out.

# %%
fist = hl.simulate(hand, hl.keyframes("fist"), hold=["wrist"])
hl.view(hand, fist)

# %% [markdown]
# ## 2 Bones
#
# A hand has 27 bones: 8 in the carpus, 5 metacarpals and 14 phalanges (the thumb has two, every finger three). The model adds the
# ends of radius and ulna, so that the wrist has something to move against: 29.
#
# Bones that hardly move against each other are one **rigid body** here. The eight carpal bones glide on one another in a real
# wrist; the model moves them as one, together with metacarpals II and III, which strong ligaments bind to them: the steady
# pillar of the hand.

# %%
for body in hand.body_names:
    names = [bone.name for bone in hand.bones.values() if bone.body == body]
    print(f"{body:<20} {', '.join(names)}")

# %% [markdown]
# ### Exercise: the big knuckle
#
# Make a fist and look at the big knuckles, in the row where the fingers leave the hand. Which joint have you bent to bring out the one
# of the middle finger, and which bone is the bump? Bend and stretch the finger slowly, and feel with the other hand what stays and
# what glides. Write `joint` like `"ip1"` and `bone` like `"distal_phalanx_1"`.

# %%
# solution: joint, bone = ..., ...
joint, bone = "mcp3", "metacarpal_3"
# end solution
check("knuckles", joint, bone)

# %% [markdown]
# ## 3 Joints, angles, signs
#
# Digits count from the thumb: 1 thumb, 2 index, 3 middle, 4 ring, 5 little finger. `mcp2` is the metacarpophalangeal joint of the
# index finger. A rotation of a joint is a *degree of freedom*; its name says which: `mcp2.flexion_extension`.
#
# Of the 31 rotations, 23 move by themselves. The other 8 follow one of these: a thumb that flexes also pronates, and the metacarpal
# of the ring finger goes along with the little finger's when you cup your palm.

# %%
for joint in hand.joints.values():
    print(f"{joint.name:<6} {joint.english:<55} {', '.join(dof.name.split('.')[1] for dof in joint.dofs) or 'held by ligaments'}")
print()
for dof in hand.dofs.values():
    if dof.driver is not None:
        print(f"{dof.name} follows {dof.driver}: {dof.ratio:+.2f} degrees for each of its degrees")

# %% [markdown]
# All angles are zero when the hand lies flat and straight: the **zero posture**, the anatomists' reference. From there
#
# | rotation | plus | minus |
# |---|---|---|
# | flexion and extension | flexion, towards the palm | extension, towards the back |
# | deviation | radial, to the side of the thumb | ulnar, to the side of the little finger |
# | abduction and adduction of the thumb | palmar abduction, away from the palm | adduction, back to it |
# | axial rotation | pronation | supination |
#
# Nobody's hand hangs that way. In the **relaxed posture** the fingers are half flexed, and in this model every muscle fibre has its
# resting length there. Let your arm hang, look at your fingers, and compare.

# %%
zero = hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))
relaxed = hl.rest(hand)
Postures(hand, {"zero": zero, "relaxed": relaxed}, view="radial")

# %% [markdown]
# ### Exercise: repair
#
# Someone wants the middle joint (PIP) of the index finger at a right angle, and everything else relaxed. Read the last line of the
# complaint.

# %% tags=["raises-exception"]
hl.pose(hand, {"pip2.flexion_extension": 90})

# %%
# solution: bent = ...
bent = hl.pose(hand, {"pip2.flexion_extension": np.deg2rad(90)})
# end solution
check("radians", bent)

# %% [markdown]
# ## 4 Limits, and who sets them
#
# A joint does not stop because a muscle says so. It stops because a ligament comes taut, or because bone meets bone:
#
# | stop | what holds |
# |---|---|
# | a finger joint in extension | the palmar plate, fibrocartilage across the front of the joint |
# | sideways motion of a flexed MCP joint | the collateral ligaments: slack when straight, taut when flexed |
# | CMC 2 and 3 in every direction | tight ligaments between interlocking bones |
# | the thumb's saddle joint (CMC 1) | the ligaments around a loose capsule, shaped by the saddle |
# | ulnar and radial deviation of the wrist | ligaments; radially also the carpus at the tip of the radius |
#
# The bars are the ranges of this hand; the dots are the relaxed posture. Ranges differ from person to person: `hand.dofs[...].sources`
# says where each one comes from, and `CHOICE` marks what somebody had to decide.

# %%
shown = [k for k, name in enumerate(hand.dof_names) if name in hand.moving_names and name[:4] not in ("mcp3", "mcp4", "mcp5")]
low, high = np.rad2deg(hand.limits[shown]).T
figure, axes = plt.subplots(figsize=(11, 7), layout="constrained")
axes.barh([hand.dof_names[k] for k in shown], high - low, left=low, color="#56B4E9")
axes.plot(np.rad2deg(hand.fibre_rest[shown]), range(len(shown)), "o", color="black", label="relaxed posture")
axes.axvline(0, color="black", linewidth=1)
axes.set_xlabel("angle (degrees); flexion, radial, palmar abduction are positive", fontsize=15)
axes.tick_params(labelsize=13)
axes.invert_yaxis()
axes.legend(fontsize=14)
plt.close(figure)
figure

# %% [markdown]
# ### Exercise: predict, then measure
#
# Spread your straight fingers. Now make a fist, and try to spread them again.
#
# Guess first: how much of the sideways range of the index finger is left at 90 degrees of MCP flexion? Then measure it, in degrees:
# an examiner holds the wrist and the flexion, and the first dorsal interosseus (`DI1`), which spreads the index finger, pulls.
# Read `mcp2.deviation` at the end. Once with `mcp2` straight, once at 90 degrees.


# %%
def widest(flexion_deg):
    start = hl.pose(hand, {"mcp2.flexion_extension": np.deg2rad(flexion_deg)})
    clip = hl.simulate(hand, {"DI1": 0.5}, seconds=1, hold=["wrist", "mcp2.flexion_extension"], start=start)
    # solution: return ...
    return np.rad2deg(clip.angle[-1, hand.dof_names.index("mcp2.deviation")])
    # end solution


straight, in_fist = widest(0), widest(90)
check("spread", straight, in_fist)

# %% [markdown]
# ## 5 Muscles
#
# **Extrinsic** muscles have their bellies in the forearm and send tendons across the wrist; put a hand around your forearm, wiggle
# your fingers, and feel them. **Intrinsic** muscles begin and end in the hand. The model has 42 pull lines: a muscle with several
# tendons counts once for each. (The table of the model puts the adductor of the thumb with the thenar muscles.)

# %%
for group in ("extrinsic", "intrinsic"):
    own = [muscle for muscle in hand.muscles.values() if muscle.group == group]
    print(f"\n{group}: {len(own)}")
    for region in dict.fromkeys(muscle.region for muscle in own):
        print(f"  {region:<20} {' '.join(muscle.abbreviation for muscle in own if muscle.region == region)}")
hand.muscles["FDP2"]

# %% [markdown]
# Below the list stands one of them with its sources. Its signed **lever arms** say what it does: a tendon that runs on the palmar side
# of a joint's axis flexes it (plus), one on the dorsal side extends it (minus). The deep flexor of the index finger (`FDP2`) crosses
# the wrist, then MCP, PIP and DIP: it is the only muscle that flexes the last joint of that finger.
#
# ## 6 One equation
#
# A fibre shortens by exactly what its tendon takes up on its way around the joints:
#
# $$ \ell = \ell_0 - R\,(\varphi - \varphi_0) $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\ell$ | fibre lengths of the 42 muscles | `state.fibre_length` | m |
# | $\ell_0$ | their lengths at rest | `hand.rest_length` | m |
# | $R$ | lever arms, a row per muscle, a column per rotation | `hand.lever_arm` | m |
# | $\varphi$ | the 31 angles | `state.angle` | rad |
# | $\varphi_0$ | the angles of the relaxed posture | `hand.fibre_rest` | rad |
#
# ### Exercise: the equation in your own lines
#
# The paper prints this update with a length $\lVert r\rVert$ that has lost its sign, so that an extensor would get shorter when the
# finger flexes. Write it with the sign. `@` multiplies a matrix by a vector.


# %%
def own_length(hand, angle):
    # solution: return ...
    turned = angle - hand.fibre_rest
    taken_up = hand.lever_arm @ turned
    return hand.rest_length - taken_up
    # end solution


check("own_length", own_length)

# %% [markdown]
# ## 7 One slider, several joints
#
# ### Exercise: predict, then name
#
# Three muscles, with the wrist held:
#
# - `FDP2`, the deep flexor of the index finger, from the forearm to the last phalanx;
# - `ODM`, the opponens of the little finger, from the hamate to metacarpal V;
# - `LUM1`, the first lumbrical, from the tendon of FDP2 to the extensor hood of the index finger.
#
# **Before you touch a slider**, write down which joints each of them will move. A wrong guess costs nothing; no guess costs the fun.

# %%
# solution: prediction = {"FDP2": ..., "ODM": ..., "LUM1": ...}
prediction = {"FDP2": {"mcp2", "pip2", "dip2"}, "ODM": {"cmc5"}, "LUM1": {"mcp2", "pip2", "dip2"}}
# end solution
check("predict", prediction)

# %% [markdown]
# Now move one slider at a time, to about 0.3. **Relax** takes the hand back. The read-out names every rotation that has changed by
# more than half a degree; the line `panel.set(FDP2=0.3)` does the same as the slider.

# %%
panel = MusclePanel(hand, ["FDP2", "ODM", "LUM1"], hold=["wrist"])
panel

# %%
# solution: seen = {"FDP2": ..., "ODM": ..., "LUM1": ...}
seen = {}
for muscle in panel.muscles:
    panel.reset()
    panel.set(**{muscle: 0.3})
    seen[muscle] = {name.split(".")[0] for name in panel.moved}
# end solution
check("name", seen)

# %% [markdown] tags=["solution"]
# *For the lecturer.* Most students name `cmc5` alone for ODM: Table 1 has one lever arm for it. CMC 4 follows CMC 5, as in your own
# hand: cup your palm and watch the knuckle of the ring finger. LUM1 pulls at the palmar side of the MCP axis and ends on the dorsal
# side of the finger: it flexes the first joint and extends the other two.

# %% [markdown]
# What a muscle did, over time: contraction, fibre length (also relative to rest) and joint angles. A fibre pulls actively only between
# 0.6 and 1.6 of its resting length; passively, a stretched fibre pulls back. Look at `EDC2`, the extensor on the other side: nobody
# told it to do anything.

# %%
panel.reset()
for contraction in (0.1, 0.2, 0.3, 0.0):
    panel.set(FDP2=contraction)
hl.curves(panel.clip, muscles=["FDP2", "EDC2"], joints=["mcp2", "pip2", "dip2"])

# %% [markdown]
# ### Exercise: why a strong grip extends the wrist
#
# Make a tight fist. Keep it tight, and flex your wrist as far as you can. What do your fingers do?
#
# Measure why. Pose the index finger fully closed (`mcp2`, `pip2` and `dip2` at their upper limits), once with the wrist at +60 degrees
# (flexed), once at -40 (extended). What is the fibre length of `FDP2` in parts of its rest length? And with which wrist,
# `"flexed"` or `"extended"`, can it still pull?


# %%
def ratio(wrist_deg):
    closed = {name: hand.dofs[name].limits[1] for name in ("mcp2.flexion_extension", "pip2.flexion_extension", "dip2.flexion_extension")}
    # solution: return ...
    state = hl.pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg), **closed})
    k = hand.muscle_names.index(hand.muscles["FDP2"].name)
    return state.fibre_length[k] / hand.rest_length[k]
    # end solution


# solution: pulls_with_wrist = ...
pulls_with_wrist = "extended"
# end solution
check("fist", ratio(60), ratio(-40), pulls_with_wrist)

# %% [markdown]
# ## 8 Doubt the data
#
# This hand comes from a printed table of lever arms (Albrecht, Haber, Seidel 2003), and printed tables have slips.
# `hl.load_hand(reading="printed")` gives you the hand as printed.
#
# Four **dorsal interossei** spread the fingers, away from the midline of the hand, which runs through the middle finger. Let the
# printed hand try, one muscle after the other.

# %%
printed = hl.load_hand(reading="printed")
for muscle in ("DI1", "DI2", "DI3", "DI4", "ADM"):
    clip = hl.simulate(printed, {muscle: 0.2}, seconds=1, hold=["wrist"])
    turned = np.rad2deg(clip.angle[-1] - clip.angle[0])
    spread = [f"{name} {by:+.0f} degrees" for name, by in zip(hand.dof_names, turned, strict=True) if "deviation" in name and abs(by) > 1]
    print(f"{muscle:<4} {', '.join(spread)}")

# %% [markdown]
# Spread your fingers, and feel between the metacarpals on the back of your hand which fingers are being pulled, and to which side.
# Which muscle is printed at the wrong joint, and at which joint does it belong? `hand.muscles[...]` shows origin and insertion.

# %%
# solution: suspect, belongs_to = ..., ...
suspect, belongs_to = "DI4", "mcp4"
# end solution
check("doubt", suspect, belongs_to)

# %% [markdown]
# ## Summary
#
# - 29 bones in 19 rigid bodies, 20 joints with 31 rotations; 23 move by themselves, 8 follow.
# - Angles count from the straight hand; flexion, radial, palmar abduction and pronation are positive; radians inside.
# - Ligaments and bone set the limits, and a flexed MCP joint loses most of its sideways play.
# - Extrinsic muscles cross the wrist, so the wrist decides how well the fingers can grip.
# - One contraction moves several joints, some of them without a lever arm of their own.
# - $\ell = \ell_0 - R(\varphi - \varphi_0)$, with the sign.
# - A table can be wrong. A hand, yours, is a good witness.

# %%
check.summary()
