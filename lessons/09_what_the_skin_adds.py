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
# # 09 · What the skin adds
#
# Straighten your index finger. With a pen, draw a line of 20 mm on its back, lengthwise, with the middle joint (PIP) in the middle. Draw
# one on the palm side as well. Bend the joint to a right angle and look: one line has grown, the other is gone in a fold.
#
# After this lesson you can
#
# - measure the volume of a piece of a hand from its surface, and say how much of it a way to draw skin loses at a knuckle;
# - say what springs do better than blending, and what they do no better;
# - find where a model hides what it cannot do;
# - measure how far a muscle lifts the skin above it.

# %%
import handlab as hl
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.show.figures import STYLE, line
from handlab.show.knuckle_panel import KnucklePanel
from handlab.simulation.soft_skin import soft_skin
from handlab.studies import knuckle, measures

# %%
plt.rcParams.update(STYLE)
check = lesson("09")
hand = hl.load_hand()

# %% [markdown]
# ### Exercise: your own finger
#
# How many millimetres long is the line on the back when the joint is bent to a right angle? Lay a strip of paper along it. Any honest
# number is right.

# %%
# solution: mine_mm = ...
mine_mm = 27
# end solution
check("mine", mine_mm)

# %% [markdown]
# ## 1 The idea
#
# The simplest way to move skin is to **blend**: each point of the skin follows the bones near it, one more, the other less. That is quick,
# but a point knows nothing of its neighbours, nor of the flesh below. With **springs** (lesson 07) the points pull at each other, and the
# flesh resists.

# %%
straight = dict.fromkeys(hand.moving_names, 0.0)
fingers = {f"{joint}{k}.flexion_extension": np.deg2rad(80) for joint in ("mcp", "pip") for k in (2, 3, 4, 5)}
flat = hl.pose(hand, straight)
bent = hl.pose(hand, straight | {"pip2.flexion_extension": np.deg2rad(90)})
fist = hl.pose(hand, straight | fingers)
ways = ("linear", "blend", "springs")
states = {"flat": flat, "bent": bent, "fist": fist}
skin = {way: {name: knuckle.worn(hand, state, way) for name, state in states.items()} for way in ways}

# %% [markdown]
# `skin["springs"]["bent"]` are the points of the skin with springs when the index finger is bent at its PIP joint. `"linear"` is the
# oldest way to blend: it averages where each bone would carry the point. `"blend"` averages turns instead (dual quaternions); it is the
# quick way of this laboratory.

# %%
worn = {way: replace(fist, skin=skin[way]["fist"]) for way in ("blend", "springs")}
hl.sheet(hand, worn, view=["back", "radial"], skin="solid", tile=(280, 280))

# %% [markdown]
# ## 2 Volume from a surface
#
# How much is inside a closed surface of triangles? Join every triangle $\mathbf a,\mathbf b,\mathbf c$ with one fixed point, say the
# origin. That gives a slim pyramid with the volume
#
# $$ V_i = \tfrac16\;\mathbf a\cdot(\mathbf b\times\mathbf c) $$
#
# If the triangle looks away from the origin, $V_i$ counts as positive; if it looks towards it, as negative. All together give the volume
# inside, wherever the origin is.
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\mathbf a, \mathbf b, \mathbf c$ | corners of a triangle, counter-clockwise from outside | `points[faces[:, 0]]`, ... | m |
# | $\times$, $\cdot$ | cross product, dot product | `np.cross(b, c)`, `(a * b).sum(axis=1)` | |
# | $V$ | volume | | m³ |
#
# ### Exercise: the equation in your own lines
#
# `points` (N, 3), `faces` (M, 3). The check compares with the package, for the skin and for bones.


# %%
def volume(points, faces):
    # solution: return ...
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return (a * np.cross(b, c)).sum() / 6
    # end solution


check("volume", volume)

# %% [markdown]
# ## 3 The knuckle
#
# `knuckle.piece(hand, "pip2")` is the skin around the PIP joint of the index finger, 12 mm to either side, and
# `knuckle.piece_volume(points, part)` its volume; the two open ends get lids.
#
# **A question first.** The joint bends to 90 degrees. Which way to draw skin loses most of the knuckle: `linear`, `blend` or `springs`?
# And which side of the finger does it lose it from?
#
# Then move the slider. (`panel.set(bend_deg=90)` does the same.)

# %%
panel = KnucklePanel(hand, "pip2", bend_deg=30)
panel

# %% [markdown]
# ### Exercise: measure the loss
#
# How many percent of its volume does the piece lose from `"flat"` to `"bent"`, for `"linear"` and for `"blend"`?

# %%
part = knuckle.piece(hand, "pip2")


def loss_percent(way):
    # solution: return ...
    before, after = (knuckle.piece_volume(skin[way][name], part) for name in ("flat", "bent"))
    return 100 * (1 - after / before)
    # end solution


check("loss", loss_percent("linear"), loss_percent("blend"))

# %%
figure, axes = plt.subplots(figsize=(12, 6))
degrees = np.array([0, 30, 60, 90])
for k, way in enumerate(ways):
    bends = [hl.pose(hand, straight | {"pip2.flexion_extension": np.deg2rad(bend)}) for bend in degrees]
    volumes = [knuckle.piece_volume(knuckle.worn(hand, state, way), part) for state in bends]
    axes.plot(degrees, 100 * np.array(volumes) / volumes[0], label=way, marker="o^s"[k], markersize=11, **line(k))
axes.set(xlabel="flexion of the PIP joint (degrees)", ylabel="volume of the piece (percent)")
axes.legend()
plt.close(figure)
figure

# %% [markdown]
# ### Exercise: and with springs?
#
# The same for `"springs"`. Then the **whole** hand in the fist: its volume in percent of `hand.skin.volume`, blended and with springs. Your
# function `volume` knows how.

# %%
# solution: piece_percent, whole_blend, whole_springs = ..., ..., ...
piece_percent = loss_percent("springs")
whole_blend, whole_springs = (100 * volume(skin[way]["fist"], hand.skin.faces) / hand.skin.volume for way in ("blend", "springs"))
# end solution
check("springs", piece_percent, whole_blend, whole_springs)

# %% [markdown]
# Flesh is mostly water: it can be moved, but hardly pressed together. So the hand as a whole must not lose volume. The piece may: it is
# open at both ends, and what is squeezed out of the fold can go along the finger.
#
# ## 4 How does it do that?
#
# Nothing in the springs of the skin knows about volume. After every picture the package measures the volume of the hand, and makes **all**
# columns of tissue between skin and bone a little longer, by the same part, until the volume is right again.
#
# ### Exercise: break it
#
# `net.compliance` says how much volume is gained if all columns double. A net in which it is infinite never makes any column longer. What
# is the volume of the fist then, in percent of `hand.skin.volume`?

# %%
net = soft_skin(hand)
broken = replace(net, compliance=np.inf)
# solution: broken_percent = ...
broken_percent = 100 * volume(knuckle.worn(hand, fist, "springs", network=broken), hand.skin.faces) / hand.skin.volume
# end solution
check("broken", broken_percent)

# %% [markdown]
# ### Exercise: doubt it
#
# All columns, everywhere: also where nothing bends. The wrist is straight in the flat hand and in the fist. By how many percent does the
# piece around the wrist grow from `"flat"` to `"fist"`, with springs? And blended?
#
# Then close your own fist and look at your wrist. Where should the flesh of a real fist go?

# %%
wrist = knuckle.piece(hand, "wrist", girth=0.05)
# solution: springs_grow, blend_grow = ..., ...
grow = {}
for way in ("springs", "blend"):
    before, after = (knuckle.piece_volume(skin[way][name], wrist) for name in ("flat", "fist"))
    grow[way] = 100 * (after / before - 1)
springs_grow, blend_grow = grow["springs"], grow["blend"]
# end solution
check("wrist", springs_grow, blend_grow)

# %% [markdown] tags=["solution"]
# *For the lecturer.* A number that is exactly right (the whole volume) can hide one that is wrong (where it is). Flesh flows to its
# neighbours: into the web, the ball of the thumb, the pulps. A model that keeps volume prism by prism, or lets it flow along the finger,
# costs more. Ask what it is needed for: a picture of a fist does not show the error; a pressure in the carpal tunnel would be nothing else.

# %% [markdown]
# ## 5 Ink on the skin
#
# `knuckle.ink(hand, "pip2", "dorsal")` is your line on the back of the finger: about 20 mm, on the skin of the model. It goes wherever the
# skin goes; `knuckle.ink_length(points, drawn)` is its length in metres.
#
# ### Exercise: measure
#
# By how many percent does the line get longer from `"flat"` to `"bent"`, blended and with springs? Which of the two is nearer to your own
# finger?

# %%
drawn = knuckle.ink(hand, "pip2", "dorsal")
# solution: blend_longer, springs_longer = ..., ...
lengths = {way: [knuckle.ink_length(skin[way][name], drawn) for name in ("flat", "bent")] for way in ("blend", "springs")}
blend_longer, springs_longer = (100 * (after / before - 1) for before, after in lengths.values())
# end solution
check("ink", blend_longer, springs_longer)

# %% [markdown]
# Blended skin is glued to its bone, so only the few millimetres over the joint can stretch. Springs share the stretch: the skin beside the
# joint is drawn in. Pinch the skin behind your knuckle and feel it slide when you bend.
#
# ### Exercise: how far does it slide?
#
# How far, in millimetres, is each end of the ink with springs from where blending would carry it, in the posture `"bent"`? First the
# proximal end (nearer to the wrist), then the distal one. `knuckle.ink_points(points, drawn)` are the points of the line, from proximal to
# distal.

# %%
# solution: proximal_mm, distal_mm = ..., ...
ends = {way: knuckle.ink_points(skin[way]["bent"], drawn)[[0, -1]] for way in ("blend", "springs")}
proximal_mm, distal_mm = 1000 * np.linalg.norm(ends["springs"] - ends["blend"], axis=1)
# end solution
check("slide", proximal_mm, distal_mm)

# %% [markdown]
# ## 6 And a muscle below
#
# Press the thumb against the side of your index finger, as if you held a key, and feel the back of the web between them. The first dorsal
# interosseus (`DI1`) swells there. With `"springs and muscles"` the skin lies on muscles with a shape, and they bulge.
#
# ### Exercise: measure the bulge
#
# Same posture, `DI1` off and on (contraction 0 and 1). How many millimetres does the skin rise at most, along its own normal? And how many
# with plain `"springs"`?

# %%
pinch = hl.simulate(hand, "key-pinch", hold=["wrist"]).states[-1]
off = np.zeros(len(hand.muscles))
on = np.where(np.array(hand.muscle_names) == hand.muscles["DI1"].name, 1.0, 0.0)


def rise_mm(way):
    # solution: return ...
    before, after = (knuckle.worn(hand, pinch, way, contraction=contraction) for contraction in (off, on))
    return 1000 * ((after - before) * measures.vertex_normals(before, hand.skin.faces)).sum(axis=1).max()
    # end solution


check("bulge", rise_mm("springs and muscles"), rise_mm("springs"))

# %% [markdown]
# ## 7 What does it cost?
#
# ### Exercise: count
#
# Blending moves 1,500 points once for every picture. With springs each step computes all springs along edges, and two more for each node.
# A picture takes `net.substeps(1 / 60)` steps, and there are 60 in a second. How many spring forces is that in a second?

# %%
# solution: forces_per_second = ...
forces_per_second = 60 * net.substeps(1 / 60) * (len(net.stiffness) + 2 * len(net.mass))
# end solution
check("count", forces_per_second)

# %% [markdown]
# ## Summary
#
# - The volume inside a closed surface is a sum of pyramids, one for each triangle.
# - Blending loses volume at a bent joint; averaging turns loses less than averaging places. Nothing tells it that flesh is there.
# - Springs share the stretch over the skin and let it slide over bone. They keep the volume of the hand only because it is asked for, and
#   the way in which it is asked for puts it in the wrong place.
# - A sum that is right proves little about its parts. Ask a model where it hides its errors.
# - Muscles lift the skin above them by millimetres: what your eye reads as effort.

# %%
check.summary()
