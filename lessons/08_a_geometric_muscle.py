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
# # 08 · A geometric muscle
#
# Lay two fingers on the ball of your thumb. Now press the thumb hard against the index finger. The ball rises and gets hard, though it
# weighs what it weighed before: a muscle that gets shorter must get thicker.
#
# After this lesson you can
#
# - say how an ellipsoid gets thicker when it gets shorter, and check a formula that somebody only remembers;
# - paint a muscle on the skin, and say how it is fitted between skin and bone;
# - find the lever arm of any path, without a lever;
# - measure how a belly swells while the volume stays;
# - say what layers are, and what this model leaves out.

# %%
import handlab as hl
import numpy as np
from PIL import Image
from handlab.anatomy.grids import as_text
from handlab.check import lesson
from handlab.physics import bulge
from handlab.show import figures, muscle_layer, paint_panel, scene
from handlab.simulation import geometric_muscle, grid_rows, kinematics, muscle_below, muscle_fit, soft_frame, soft_skin
from handlab.studies import fibre_arm

check = lesson("08")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# The pseudo muscles of the lessons before are numbers: they pull, but nobody can see them. A **geometric muscle** is a shape: fibres
# made of ellipsoids, between skin and bone. It pulls at nothing. It takes the contraction of a pseudo muscle and swells.
#
# Here are the intrinsic muscles of the hand. Their origins and insertions are pale, their bellies red.

# %%
muscles = geometric_muscle.geometric_muscles(hand)
with scene.Scene(hand, skin="translucent", size=(560, 640), quality="film") as drawn:
    muscle_layer.MuscleLayer(drawn, sinews=False)
    picture = Image.fromarray(drawn.picture())
print(f"{len(muscles.names)} shapes of {len(muscles.owner)} ellipsoids")
picture

# %% [markdown]
# ## 2 One ellipsoid
#
# $$ V = \tfrac43\,\pi\,a\,b\,c \qquad\qquad b' = b\,q^{-1/2},\quad c' = c\,q^{-1/2} $$
#
# | symbol | meaning | unit |
# |---|---|---|
# | $a$ | half its length, along the fibre | m |
# | $b$, $c$ | half its width and half its height, across the fibre | m |
# | $q$ | its length now, divided by its length at rest | 1 |
# | $V$ | its volume | m³ |
#
# The length becomes $a' = q\,a$. Multiply the three: the volume stays.
#
# ### Exercise: the equation in your own lines
#
# `half` has one row $(a, b, c)$ for each ellipsoid. `own_thicker(q)` is the factor for width and height.


# %%
def own_volume(half):
    # solution: return ...
    return 4 / 3 * np.pi * half.prod(axis=1)
    # end solution


def own_thicker(q):
    # solution: return ...
    return q**-0.5
    # end solution


check("ellipsoid", own_volume, own_thicker)

# %% [markdown]
# ### Exercise: doubt a formula
#
# The shapes were invented for faces, in 2001. That text could not be read again when this package was written. What somebody remembers
# of it is another law: the height alone grows, by the factor $1 + 2\,(1 - q)$. It is here by name, as `law="recalled"`.
#
# By how many percent does the volume grow with it at $q = 0.7$? And at which $q$, apart from 1, does it hold exactly what it held at rest?

# %%
# solution: gain_percent, same_at = ..., ...
gain_percent = 100 * (0.7 * (1 + 2 * (1 - 0.7)) - 1)
same_at = min(np.roots([-2, 3, -1]))
# end solution
check("recalled", gain_percent, same_at)

# %% [markdown]
# ## 3 Between skin and bone
#
# A painter clicks points on the skin, in rows. **Rows** run across the fibres, the first one along the origin, the last one along the
# insertion. Below each point the muscle gets a thickness:
#
# $$ h = \mathrm{clamp}(d - o - g,\; h_{\min},\; h_{\max}) $$
#
# | symbol | meaning | unit |
# |---|---|---|
# | $d$ | from the skin to the bone below it | m |
# | $o$ | skin distance: from the skin to the muscle | m |
# | $g$ | gap between muscle and bone | m |
# | $h_{\min}$, $h_{\max}$ | the least and the most that it may be thick | m |
#
# `clamp` means: not less than the second number, and not more than the third. (At rest the package takes a part of $h_{\max}$ only, so
# that there is room to swell.)


# %%
def own_thickness(d, o, g, least, most):
    # solution: return ...
    return np.clip(d - o - g, least, most)
    # end solution


check("fit", own_thickness)

# %% [markdown]
# ## 4 Paint
#
# Here is the short abductor of the thumb (APB), painted from code. It runs from the radial side of the wrist to the base of the thumb's
# first phalanx, just below the skin. You can feel it when you lift the thumb off a table, palm up.
#
# `middles` are places inside the hand; `skin_over` finds the skin in front of each, as seen by somebody who looks at the palm.

# %%
inside = {name: bone.points.mean(axis=0) for name, bone in hand.bones.items()}
phalanx = hand.bones["proximal_phalanx_1"].points
inside["base of phalanx"] = phalanx[phalanx[:, 0].argsort()[:50]].mean(axis=0)


def over(middles, half_widths):
    across = np.array([-0.6, 0, 0.8])  # a direction across the fibres
    both = [[m - w * across, m + w * across] for m, w in zip(middles, half_widths, strict=True)]
    return grid_rows.skin_over(hand, both)


# %%
origin = 0.4 * inside["scaphoid"] + 0.6 * inside["trapezium"]
rows = over([origin, inside["metacarpal_1"], inside["base of phalanx"]], half_widths=(4e-3, 6e-3, 3e-3))
panel = paint_panel.PaintPanel(hand, "my_abductor", "APB", columns=2, thickness_mm=(1.5, 7), skin_distance_mm=1.5)
panel.set(bones=("trapezium", "metacarpal_1", "proximal_phalanx_1"), skin="mesh")
panel.add(rows)
panel

# %% [markdown]
# The grid is blue. Green dots are the points of the skin that this muscle influences: those above it. Drag a blue point, and the muscle is
# fitted anew. Drag beside the points to turn the hand. Watch it swell: `panel.set(contraction=1)`.
#
# ### Exercise: paint the short flexor of the thumb (FPB)
#
# It begins at the wrist, on the trapezium and the strong band beside it: **further into the palm** than the abductor. It runs along the
# palm side of the metacarpal and ends at the base of the phalanx. Bend your thumb at its MCP joint, fingertip straight, to feel it.
#
# Click three or four rows of two points below, from the wrist to the phalanx; then write `mine = own_panel.grid` in the next cell. Or do
# it in code, as above.

# %%
own_panel = paint_panel.PaintPanel(hand, "my_flexor", "FPB", columns=2, thickness_mm=(1.5, 7), skin_distance_mm=(6, 3, 2))
# solution
own_panel.set(bones=("trapezium", "metacarpal_1", "proximal_phalanx_1"))
origin = (inside["trapezium"] + inside["capitate"]) / 2
belly, end = inside["metacarpal_1"] + [4e-3, 0, -12e-3], inside["base of phalanx"] + [3e-3, 0, -3e-3]
own_panel.add(over([origin, belly, end], half_widths=(3e-3, 5e-3, 3e-3)))
# end solution
own_panel

# %%
# solution: mine = ...
mine = own_panel.grid
# end solution
check("paint", mine)

# %% [markdown]
# ### Exercise: break it
#
# Take the rows of the abductor, swap the first two, and give them to a new panel: `broken.add(...)`. Nothing is drawn. What does
# `broken.problem` say? Think about what a program would do that does not ask.

# %%
broken = paint_panel.PaintPanel(hand, "broken", "APB", columns=2)
# solution: message = ...
broken.add([rows[1], rows[0], rows[2]])
message = broken.problem
# end solution
check("refused", message)

# %% [markdown]
# ## 5 A lever arm without a lever
#
# Turn a joint by a small angle $\mathrm d\varphi$. A fibre that crosses it loses the length $-\mathrm dL$. Its work $F\,(-\mathrm dL)$ is
# the work of its torque $T\,\mathrm d\varphi$, and $T = r\,F$. So
#
# $$ r = -\frac{\mathrm dL}{\mathrm d\varphi} $$
#
# ### Exercise: in your own line
#
# `length(angle)` gives $L$ in metres at an angle in radians. Return $r$ at angle 0: look one `step` to either side.


# %%
def own_arm(length, step=1e-3):
    # solution: return ...
    return (length(-step) - length(step)) / (2 * step)
    # end solution


check("arm", own_arm)

# %% [markdown]
# ### Exercise: state your lever arms
#
# Here is the mean length of a muscle's fibres when one rotation of the hand is turned by `turn` from the posture of the picture. State the
# arms of **your** flexor about `cmc1.flexion_opposition` and `mcp1.flexion_extension`, in millimetres. What does the table of the paper
# say (`hand.muscles["FPB"]`)? Guess first: you can see how wide your thumb is.


# %%
def mean_length(of, name, rotation, turn):
    angle = hand.bind.copy()
    angle[hand.dof_names.index(rotation)] += turn
    return fibre_arm.fibre_lengths(hand, of, name, angle).mean()


# solution: cmc_mm, mcp_mm = ..., ...
own = geometric_muscle.muscles_of(hand, [mine])
both = ("cmc1.flexion_opposition", "mcp1.flexion_extension")
cmc_mm, mcp_mm = (1000 * own_arm(lambda turn, which=rotation: mean_length(own, mine.name, which, turn)) for rotation in both)
# end solution
check("state", mine, cmc_mm, mcp_mm)

# %% [markdown] tags=["solution"]
# *For the lecturer.* Let two students paint and compare. Whoever begins over the trapezium itself gets half the arm at the CMC joint of
# one who begins halfway to the capitate. The origin of a short muscle decides its arm.

# %% [markdown]
# ### Doubt the table
#
# The table has one number for each joint. In the posture of the pictures the arms of the flexor that comes with the hand are those of the
# table to half a millimetre. And in other postures?

# %%
dof = hand.dof_names.index("cmc1.flexion_opposition")
angles = np.linspace(*hand.limits[dof], 41)
turned = [hand.bind + (angle - hand.bind[dof]) * np.eye(len(hand.dof_names))[dof] for angle in angles]
arms = [fibre_arm.fibre_arms(hand, muscles, "flexor_pollicis_brevis", "cmc1.flexion_opposition", angle).mean() for angle in turned]
with figures.drawing(figsize=(11, 5.5)) as figure:
    axes = figure.subplots()
    axes.plot(np.rad2deg(angles), 1000 * np.array(arms), **figures.line(0), label="from the path of the shape")
    axes.axhline(1000 * hand.lever_arm[hand.muscle_names.index("flexor_pollicis_brevis"), dof], **figures.line(1), label="the table")
    axes.set(title="Lever arm of flexor pollicis brevis", xlabel="CMC flexion (degrees)", ylabel="mm", ylim=(0, 12))
    axes.legend()
figure

# %% [markdown]
# ### Exercise: measure
#
# How many times is the arm at one end of the range that at the other?

# %%
# solution: times = ...
times = max(arms[0], arms[-1]) / min(arms[0], arms[-1])
# end solution
check("constant", times)

# %% [markdown]
# ## 6 The belly
#
# Contraction moves volume: the middle of the fibre gets shorter and thicker, and the tendinous ends give what it takes. The bones may even
# stand still, as when you press the thumb against something that does not yield.
#
# ### Exercise: predict
#
# FPB contracts fully, all bones stand still. By how many percent does its thickest part get thicker?

# %%
# solution: guessed_percent = ...
guessed_percent = 30
# end solution
check("guess", guessed_percent)

# %% [markdown]
# ### Exercise: measure
#
# `halves(c)` gives half the length, half the width and half the height of every ellipsoid of the flexor that comes with the hand, at the
# contraction `c`. By how many percent does the largest height grow from 0 to 1, and the volume of the whole muscle?


# %%
def halves(c):
    contraction = np.where(np.array(hand.muscle_names) == "flexor_pollicis_brevis", c, 0.0)
    shapes = geometric_muscle.shape(muscles, kinematics.relative_transforms(hand, hand.bind), contraction)
    return shapes.half[muscles.of("flexor_pollicis_brevis")]


# solution: thicker_percent, volume_percent = ..., ...
thicker_percent = 100 * (halves(1)[:, 2].max() / halves(0)[:, 2].max() - 1)
volume_percent = 100 * (own_volume(halves(1)).sum() / bulge.ellipsoid_volume(halves(0)).sum() - 1)
# end solution
check("belly", thicker_percent, volume_percent)

# %% [markdown]
# ## 7 Layers
#
# On the other side of the palm three muscles of the little finger lie on each other. The skin distance puts each into its layer. There are
# no springs between muscles: layers slide.
#
# ### Exercise: measure
#
# `first` is the number of the muscle that lies first below each point of the skin, -1 where there is none. `above` are the points above
# the deep one. Above how many of them lies another muscle in between? And by how many millimetres do the ellipsoids of the deep one move
# when the abductor (ADM), which lies over it, contracts fully?

# %%
deep, adm = "opponens_digiti_minimi", "abductor_digiti_minimi"
first = np.append(muscles.owner, -1)[muscle_below.below(hand, muscles)[1]]
above = muscle_below.influenced(hand, muscles, deep)
places = {c: geometric_muscle.ellipsoids(hand, hand.bind, np.where(np.array(hand.muscle_names) == adm, c, 0.0)).centre for c in (0.0, 1.0)}
# solution: between, moved_mm = ..., ...
between = np.count_nonzero(first[above] != muscles.index(deep))
moved_mm = 1000 * np.linalg.norm(places[1.0] - places[0.0], axis=1)[muscles.of(deep)].max()
# end solution
check("layers", between, moved_mm)

# %% [markdown]
# Do the layers of your own hand feel nothing of each other? They do: a belly that swells pushes its neighbour aside. In this model two
# muscles can even be in the same place, and nobody complains. It is made to move the skin, and for that the upper one counts.
#
# ## 8 Use it
#
# Springs tie every point of the skin to what lies below (lesson 07). Give the network your muscle, and see what it does.
#
# ### Exercise: measure
#
# `soft_skin.soft_skin(hand, muscles=...)` makes the network for your muscle alone (`geometric_muscle.muscles_of(hand, [mine])`), and
# `skin(c, network)` gives the points of the skin at rest, with the flexor at the contraction `c`. By how many millimetres does the skin
# rise, where it rises most? Measure along the `normals` (1500, 3), which point outwards.

# %%
normals = muscle_fit.checked_skin(hand)


def skin(c, network):
    contraction = np.where(np.array(hand.muscle_names) == "flexor_pollicis_brevis", c, 0.0)
    return soft_frame.begin(hand, network, hand.bind, contraction).points


# solution: rise_mm = ...
network = soft_skin.soft_skin(hand, muscles=geometric_muscle.muscles_of(hand, [mine]))
rise_mm = 1000 * np.sum((skin(1, network) - skin(0, network)) * normals, axis=1).max()
# end solution
check("skin", mine, rise_mm)

# %% [markdown]
# A painted muscle is data. `panel.save("muscles")` writes it into a folder, and `load_grids("muscles")` reads it. Points are kept as places
# on triangles of the skin: a hand of another shape takes the muscle along.

# %%
print(as_text(panel.grid))

# %% [markdown]
# ## Summary
#
# - A geometric muscle is a shape that follows bones and contraction. It pulls at nothing.
# - Shorter means thicker: $q^{-1/2}$ both ways keeps the volume. A remembered formula may not.
# - Rows and columns on the skin, a thickness between least and most, bones for every row: that is a painted muscle.
# - $r = -\mathrm dL/\mathrm d\varphi$: the path alone says the lever arm, and it changes with the posture.
# - Contraction moves volume into the belly and creates none.
# - Layers slide, and do not push each other. That is what the model leaves out.

# %%
check.summary()
