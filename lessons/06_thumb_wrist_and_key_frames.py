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
# # 06 · Thumb, wrist and key frames
#
# Let your hand hang from your forearm, then raise it by bending the wrist back. Watch your fingers: nobody told them to do anything.
#
# After this lesson you can
#
# - say in which direction the thumb abducts, and which muscle opposition cannot do without;
# - move fingers with the wrist alone (tenodesis), and say which muscle did it;
# - explain why a flexed wrist makes a weak fist (active insufficiency);
# - keep a wrist in place that its own fingers pull away;
# - write a motion as key frames, and know what lies between them.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.physics.muscle import active_force_length
from handlab.show.figures import STYLE, line
from handlab.studies import measures
from scipy.interpolate import CubicSpline

plt.rcParams.update(STYLE)
check = lesson("06")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# Most tendons of the fingers come from the forearm, so they cross the wrist on their way. Whatever the wrist does changes the length
# of their fibres, and whatever they do turns the wrist. A hand that works is a conversation between wrist and fingers, and **key
# frames** are how you write it down: contractions at a few times, with smooth curves between them.

# %%
opposition = hl.simulate(hand, hl.keyframes("opposition-little"), hold=["wrist"])
hl.view(hand, opposition)

# %% [markdown]
# ## 2 The thumb
#
# The thumb stands across the other fingers, so its words have their own directions. Lay the back of your hand on the table and point
# the thumb at the ceiling. That is **palmar abduction**. It is not the same as spreading the thumb along the table.
#
# ### Exercise: predict, then measure
#
# In which direction does the pulp of the thumb go when `cmc1.abduction_adduction` grows by 10 degrees, and in which when
# `cmc1.flexion_opposition` does? Guess. Then measure with `shift`: it gives millimetres along x (distal), y (palmar) and z (radial).
# Answer with one of `"distal"`, `"proximal"`, `"palmar"`, `"dorsal"`, `"radial"`, `"ulnar"`.


# %%
def shift(rotation):
    start = hl.rest(hand)
    angle = start.angle[hand.dof_names.index(rotation)] + np.deg2rad(10)
    pulp = measures.pulps(hand)[1]  # skin points of the thumb's pulp
    return 1000 * (hl.pose(hand, {rotation: angle}).skin[pulp] - start.skin[pulp]).mean(axis=0)


# solution: directions = {"abduction": ..., "flexion": ...}
words = (("proximal", "distal"), ("dorsal", "palmar"), ("ulnar", "radial"))
moves = {"abduction": shift("cmc1.abduction_adduction"), "flexion": shift("cmc1.flexion_opposition")}
directions = {name: words[k][int(by[k] > 0)] for name, by in moves.items() for k in [np.abs(by).argmax()]}
# end solution
check("directions", directions)

# %% [markdown]
# ### Exercise: a name is no promise
#
# *Abductor pollicis longus*, the long abductor of the thumb, comes from the forearm. Let it pull with 0.2 and leave the wrist free.
# Which rotation do you expect to turn most? Then measure: simulate 2 s, without `hold`, and take the largest change of all 31
# angles. Answer like `"ip1.flexion_extension"`.

# %%
clip = hl.simulate(hand, {"APL": 0.2}, seconds=2)
# solution: most = ...
most = hand.dof_names[np.abs(clip.angle[-1] - clip.angle[0]).argmax()]
# end solution
check("name", most)

# %% [markdown]
# **Opposition** brings the pulp of the thumb to the pulp of another finger. The picture above shows it with the little finger, the
# longest way. Look at the thumb's nail: it turns as well. No muscle of this model has a lever arm for that turning; the shape of the
# saddle joint couples it to flexion.
#
# ### Exercise: break it
#
# Play `opposition-little` again and again, each time with another muscle of thumb or little finger gone silent. The loss of which one
# leaves the widest gap between the two pulps? And by how many degrees does the thumb turn about its long axis
# (`cmc1.axial_rotation`) in the whole clip?

# %%
keys = hl.keyframes("opposition-little")
tracks = {hand.muscles[name].abbreviation: keys.contraction[:, keys.muscle_names.index(name)] for name in keys.keyed}
asked = [name for name in tracks if hand.muscles[name].region in ("thenar", "long thumb muscles", "hypothenar")]
gaps = {}
for silent in asked:
    clip = hl.simulate(hand, {"time": keys.time} | tracks | {silent: 0 * keys.time}, hold=["wrist"])
    gaps[silent] = 1000 * measures.pulp_gap(hand, clip.skin(-1), 1, 5)  # mm
# solution: culprit, turned_deg = ..., ...
culprit = max(gaps, key=gaps.get)
turned_deg = np.rad2deg(np.ptp(opposition.angle[[0, -1], hand.dof_names.index("cmc1.axial_rotation")]))
# end solution
check("opposition", culprit, turned_deg)

# %% [markdown]
# ## 3 The wrist moves the fingers
#
# ### Exercise: tenodesis
#
# No muscle contracts. An examiner holds the wrist at 60 degrees of flexion, then at 60 degrees of extension. In which of the two are
# the fingers more bent? Guess, and watch your own.
#
# Then measure the middle finger: the sum of `mcp3`, `pip3` and `dip3` flexion, in degrees. `hl.settle` finds where the joints come to
# rest.

# %%
flexions = [hand.dof_names.index(f"{joint}3.flexion_extension") for joint in ("mcp", "pip", "dip")]


def at_rest(wrist_deg, contraction):
    start = hl.pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg)})
    return hl.settle(hand, contraction, start, hold=["wrist"], look_for_others=False).state


# solution: flexed_deg, extended_deg = ..., ...
flexed_deg, extended_deg = (np.rad2deg(at_rest(wrist, {}).angle[flexions].sum()) for wrist in (60, -60))
# end solution
check("tenodesis", flexed_deg, extended_deg)

# %% [markdown]
# A fibre that is stretched beyond its rest length pulls back, even if nobody commands it: that is the passive part of its force.
# People whose fingers are paralysed but who can still raise the wrist use it to grip.
#
# ### Exercise: who did it?
#
# Name the muscle that pulls hardest at the middle finger in each of the two postures (`"FDP3"`, `"FDS3"`, `"EDC3"`, `"LUM2"`,
# `"DI2"` or `"DI3"`). `clip.force` has the forces of all muscles in newtons.

# %%
middle = ["FDP3", "FDS3", "EDC3", "LUM2", "DI2", "DI3"]
rows = [hand.muscle_names.index(hand.muscles[name].name) for name in middle]
for wrist in (60, -60):
    clip = hl.simulate(hand, {"FDP3": 0.0}, seconds=0.1, hold=["wrist"], start=at_rest(wrist, {}))
    # the forces of these muscles are clip.force[-1, rows]
    # solution
    print(wrist, dict(zip(middle, clip.force[-1, rows].round(2), strict=True)))
    # end solution
# solution: with_wrist_flexed, with_wrist_extended = ..., ...
with_wrist_flexed, with_wrist_extended = "EDC3", "FDS3"
# end solution
check("who", with_wrist_flexed, with_wrist_extended)

# %% [markdown]
# ### Exercise: active insufficiency
#
# Now all eight finger flexors from the forearm pull as hard as they can. How strong are the two of the middle finger together
# (`FDP3` + `FDS3`, in newtons) with the wrist at +60 degrees, and at -30? And at +60, is the fibre of `FDP3` `"too short"` or
# `"too long"` to pull?
#
# Forces in this model hang on one assumption, 20 N for each percent of tension; their ratio does not.

# %%
strongest = {f"{muscle}{digit}": 1.0 for muscle in ("FDP", "FDS") for digit in (2, 3, 4, 5)}


def pull(wrist_deg):
    clip = hl.simulate(hand, strongest, seconds=2, hold=["wrist"], start=at_rest(wrist_deg, strongest))
    return clip.force[-1, rows[:2]].sum(), clip.fibre_length[-1, rows[0]] / hand.rest_length[rows[0]]


# solution: flexed_force, extended_force, fibre = ..., ..., ...
flexed_force, extended_force, fibre = pull(60)[0], pull(-30)[0], "too short"
# end solution
check("insufficient", flexed_force, extended_force, fibre)

# %%
wrist_deg = np.arange(-65, 75, 10)
found = np.array([(*pull(wrist), np.rad2deg(at_rest(wrist, strongest).angle[flexions].sum())) for wrist in wrist_deg])
figure, axes = plt.subplots(1, 3, figsize=(19, 6))
titles = ("FDP3 + FDS3: force (N)", "fibre of FDP3 / rest length", "flexion of the finger (degrees)")
for k, (panel, title) in enumerate(zip(axes, titles, strict=True)):
    panel.plot(wrist_deg, found[:, k], marker="o", **line(k))
    panel.set(title=title, xlabel="wrist: extension  <  degrees  >  flexion")
axes[1].axhline(0.6, color="0.45", linewidth=1.5)
plt.close(figure)
figure

# %% [markdown]
# Below 0.6 of its rest length a fibre cannot pull. With a flexed wrist it gets there before the fist is closed. Try it with your own
# hand, and with something to squeeze.

# %% [markdown]
# ## 4 Six sliders, one fist
#
# **A question first.** At contraction 0.2 `FDP3` alone bends the middle finger a long way. How much of that way is done at 0.1?
#
# ### Exercise: contraction is not angle
#
# Measure it: the sum of the three flexions as change from the relaxed hand (`hl.rest(hand)`), wrist held, at 0.1 in percent of the
# change at 0.2.

# %%
# solution: percent = ...
relaxed = hl.rest(hand).angle[flexions].sum()
tenth, fifth = (hl.settle(hand, {"FDP3": value}, hold=["wrist"]).state.angle[flexions].sum() - relaxed for value in (0.1, 0.2))
percent = 100 * tenth / fifth
# end solution
check("half", percent)

# %% [markdown]
# ### Exercise: design a fist
#
# Six sliders, wrist held. Close it so that in every finger MCP, PIP and DIP flexion add up to 195 degrees or more, but to no more than
# 240: that would be cramp. The pulp of the thumb has to lie on the middle phalanx of the index or middle finger, within 6 mm.
#
# Skin may sink into skin: nothing in this model pushes back yet. Move the sliders, run the second cell, and look what `closed` says:
# the four sums in degrees, and the distances of the thumb in mm. Hand over your six values like `{"FDP2": 0.05, ...}`.


# %%
def closed(state):
    angle = dict(zip(hand.dof_names, np.rad2deg(state.angle), strict=True))
    sums = [round(sum(angle[f"{joint}{digit}.flexion_extension"] for joint in ("mcp", "pip", "dip"))) for digit in (2, 3, 4, 5)]
    return sums, [round(1000 * measures.pulp_to_bodies(hand, state.skin, 1, (f"middle_phalanx_{digit}",)), 1) for digit in (2, 3)]


panel = hl.MusclePanel(hand, ["FDP2", "FDP3", "FDP4", "FDP5", "FPL", "OPP"], hold=["wrist"], seconds=2)
panel

# %%
# solution: fist = ...
panel.set(FDP2=0.2, FDP3=0.2, FDP4=0.2, FDP5=0.2, FPL=0.1, OPP=0.1)
fist = panel.contraction
# end solution
print(closed(panel.state))
check("fist", fist)

# %% [markdown]
# ## 5 The wrist runs away
#
# So far an examiner held the wrist. Let it go, and grip with some strength: all eight flexors at 0.5, for 3 s.
#
# ### Exercise: measure
#
# Where does the wrist end (flexion in degrees; it starts at -15)? And how many percent of the force of `FDP3` + `FDS3` are lost,
# compared with the held wrist?

# %%
grip = dict.fromkeys(strongest, 0.5)
held = hl.simulate(hand, grip, seconds=3, hold=["wrist"])
free = hl.simulate(hand, grip, seconds=3)
# solution: wrist_end_deg, lost_percent = ..., ...
wrist_end_deg = np.rad2deg(free.angle[-1, hand.dof_names.index("wrist.flexion_extension")])
lost_percent = 100 * (1 - free.force[-1, rows[:2]].sum() / held.force[-1, rows[:2]].sum())
# end solution
check("runaway", wrist_end_deg, lost_percent)

# %% [markdown]
# ## 6 Mend it: two equations, two muscles
#
# The wrist stays where the torques about both of its axes add up to nothing. The grip gives the torque $T_k$ about axis $k$. Two
# extensors, on the radial and on the ulnar side (`ECRB` and `ECU`), have to give the opposite:
#
# $$ \sum_i R_{ik}\; c_i\, F_i^{full} = -T_k $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $T_k$ | torque of the grip about wrist axis $k$, wrist held | `clip.torque[frame, wrist]` | N m |
# | $R_{ik}$ | lever arm of extensor $i$ at axis $k$ | `hand.lever_arm[extensors][:, wrist]` | m |
# | $F_i^{full}$ | its force at contraction 1 at this fibre length | `full` | N |
# | $c_i$ | contraction: what you look for | what `brace` returns | 1 |
#
# ### Exercise: the equation in your own lines
#
# `np.linalg.solve(A, b)` solves $A\,c = b$; a row of $A$ is an axis, a column a muscle. `A.T` swaps rows and columns.

# %%
wrist = [hand.dof_names.index(f"wrist.{name}") for name in ("flexion_extension", "deviation")]
extensors = [hand.muscle_names.index(hand.muscles[name].name) for name in ("ECRB", "ECU")]


def brace(clip, frame):
    ratio = clip.fibre_length[frame, extensors] / hand.rest_length[extensors]
    full = hand.max_force[extensors] * active_force_length(ratio)
    # solution: return ...
    A = hand.lever_arm[extensors][:, wrist].T * full
    return np.linalg.solve(A, -clip.torque[frame, wrist])
    # end solution


check("brace", brace)

# %% [markdown]
# ### Exercise: repair
#
# Give the grip (all eight flexors at 0.5) its two extensors, so that the free wrist ends within 3 degrees of where it began, about
# both axes. Hand over `{"ECRB": ..., "ECU": ...}`.

# %%
# solution: mended = {"ECRB": ..., "ECU": ...}
mended = dict(zip(("ECRB", "ECU"), brace(held, -1).tolist(), strict=True))
# end solution
check("mend", mended)

# %% [markdown]
# ## 7 Key frames
#
# A curve through the keys must not leave the range from 0 to 1, and a muscle that has the same value at two keys must not wobble
# between them. The paper only says "a smooth spline". This laboratory takes a **monotone cubic**: between two keys it never leaves
# their values.
#
# ### Exercise: doubt the spline
#
# Keys at 0, 0.5, 1 and 1.5 s have the values 0, 1, 0.2 and 0.2. What are a natural cubic spline and the curve of this laboratory at
# 1.25 s?

# %%
key_time, key_value = [0, 0.5, 1, 1.5], [0, 1, 0.2, 0.2]
natural = CubicSpline(key_time, key_value, bc_type="natural")  # natural(t) is its value
monotone = hl.keyframes({"FDP3": list(zip(key_time, key_value, strict=True))})  # .at(t) has the values of all 42 muscles
# solution: natural_value, own_value = ..., ...
natural_value, own_value = natural(1.25), monotone.at(1.25)[rows[0]]
# end solution
check("between", natural_value, own_value)

# %% [markdown]
# ### Exercise: extend
#
# A grip that closes and opens again. Write the key frames of `ECRB` and `ECU`, so that the free wrist *never* leaves its place by more
# than 5 degrees, about neither axis: not while the hand closes, and not while it opens.
#
# First try the same four times as the flexors. Why is that not enough? Look at `moving.torque[:, wrist]` over time, where an examiner
# holds the wrist; a few more keys follow from `brace(moving, frame)`.

# %%
closing = {name: [(0, 0), (1.5, 0.3), (2, 0.3), (3.5, 0)] for name in strongest}
moving = hl.simulate(hand, closing, seconds=4, hold=["wrist"])
# solution: wrist_keys = {"ECRB": ..., "ECU": ...}
frames = np.arange(0, len(moving), 12)
values = np.clip([brace(moving, frame) for frame in frames], 0, 1)
wrist_keys = {name: list(zip(moving.time[frames], values[:, k], strict=True)) for k, name in enumerate(("ECRB", "ECU"))}
# end solution
check("keys", wrist_keys)

# %% [markdown]
# Contraction, fibre length and joint angles of the grip without any wrist muscle. After you have solved the exercise, put
# `closing | wrist_keys` in, and compare.

# %%
hl.curves(
    hl.simulate(hand, closing, seconds=4), muscles=["FDS3", "FDP3", "EDC3", "ECRB"], joints=["wrist", "mcp3.flexion_extension", "pip3"]
)

# %% [markdown]
# ## 8 Doubt the data
#
# Five tendons on the palmar side of the wrist, as the table of the model prints them. `FDS2`, `FDP2` and `FPL` go through the carpal
# tunnel side by side, a narrow channel in the middle of the wrist. Which muscles cannot have the two arms that are printed? Feel at
# your own wrist while you close a strong fist: does it jerk to the side? Answer with a set of abbreviations.

# %%
for name in ("FCR", "FDS2", "FDP2", "FPL", "FCU"):
    arms = {arm.dof: 1000 * arm.printed for arm in hand.muscles[name].lever_arms}
    print(f"{name:<5} flexion {arms['wrist.flexion_extension']:+5.1f} mm   radial {arms['wrist.deviation']:+6.1f} mm")
# solution: suspects = ...
suspects = {"FDP2", "FPL"}
# end solution
check("doubt", suspects)

# %% [markdown]
# ## Summary
#
# - Palmar abduction lifts the thumb out of the palm's plane; flexion sweeps it across the palm. A muscle's name is no promise.
# - The wrist moves the fingers through stretched fibres (tenodesis), and starves them when they get too short (active insufficiency).
# - Contraction is neither angle nor force: half of it can be most of the way.
# - A grip needs the wrist extensors. Two axes, two torques, two muscles; and the brace has to come *with* the grip.
# - Between key frames lies a curve. Know which one.

# %%
check.summary()
