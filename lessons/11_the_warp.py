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
# # 11 · The warp
#
# Put a rubber glove on a larger hand: fingertips, creases and webs go where they must, and the rubber between them finds its own way. On
# this page you write the rubber: a map that takes 26 points of one hand to those of another, and carries skin, bones and joints along.
#
# After this lesson you can
#
# - write the biharmonic warp of section 5.2 in ten lines, and say what each of its parts is for;
# - show what goes wrong without side conditions, and when all points lie in one plane;
# - make a bone fold, and find the fold with a determinant;
# - find the one wrong click among 26;
# - say what 26 points cannot tell, and how the outline of a hand tells it.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.check.misclick import misplaced
from handlab.fitting.landmarks import NAMES, source_points
from handlab.physics import rbf
from handlab.show.figures import STYLE, line
from handlab.show.warp_panel import WarpPanel
from handlab.studies.table_photo import table_photo

# %%
plt.rcParams.update(STYLE)
check = lesson("11")
hand = hl.load_hand()
child = hl.load_hand("child")

# %% [markdown]
# ## 1 The idea
#
# The skin of the reference hand is tagged with 26 feature points $\mathbf s_i$. On the hand of a child the same points are at
# $\mathbf t_i$. We look for a map $\mathbf f$ of space with $\mathbf f(\mathbf s_i)=\mathbf t_i$ that is as smooth as can be. Then
# everything is sent through it: 6,825 points of bones, 1,500 of skin, all joints. Places are in metres, in the frame of the hand: x to the
# fingertips, y out of the palm, z to the thumb.

# %%
source = source_points(hand, "palmar", NAMES, "exact")
target = source_points(child, "palmar", NAMES, "exact")
bones = np.concatenate([bone.points for bone in hand.bones.values()])
figure, axes = plt.subplots(figsize=(8, 9))
axes.plot(1000 * bones[:, 2], 1000 * bones[:, 0], ".", color="#D5DBE1", markersize=2)
for s, t in zip(1000 * source, 1000 * target, strict=True):
    axes.annotate("", (t[2], t[0]), (s[2], s[0]), arrowprops={"arrowstyle": "-|>", "linewidth": 2.5, "color": "#0072B2"})
axes.set(aspect="equal", xlabel="mm, towards the thumb", ylabel="mm, towards the fingertips", title="reference hand to child")
plt.close(figure)
figure

# %% [markdown]
# ### Exercise: guess
#
# The paper uses 26 points, and finds 16 enough. How many would **you** need to tell one hand from another? A guess is all that is asked.

# %%
# solution: guess_points = ...
guess_points = 20
# end solution
check("guess", guess_points)

# %% [markdown]
# ## 2 The equation
#
# $$ \mathbf f(\mathbf x)=\sum_{i=1}^N\mathbf w_i\,\lVert\mathbf x-\mathbf s_i\rVert+\mathbf A\mathbf x+\mathbf b \qquad
# \sum_i\mathbf w_i=\mathbf 0 \qquad \sum_i\mathbf w_i\,\mathbf s_i^{\mathsf T}=\mathbf 0 $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\mathbf s_i, \mathbf t_i$ | feature points before and after | `source`, `target` (N, 3) | m |
# | $\mathbf w_i$ | how much point $i$ bends space around itself | `weight` (N, 3) | 1 |
# | $\mathbf A, \mathbf b$ | affine part: turning, stretching, shearing; shifting | `linear` (3, 3), `shift` (3,) | 1, m |
# | $\Phi_{ij}=\lVert\mathbf s_i-\mathbf s_j\rVert$ | distances of all points from each other | (N, N) | m |
# | $P$ | a one and the place of each point | (N, 4) | 1, m |
#
# N equations $\mathbf f(\mathbf s_i)=\mathbf t_i$ are too few for N weights and 4 more unknowns (in each direction). The **side
# conditions** are the 4 missing ones. All together is one symmetric system with three right-hand sides:
#
# $$ \begin{pmatrix}\Phi&P\\P^{\mathsf T}&0\end{pmatrix}\begin{pmatrix}W\\B\end{pmatrix}=\begin{pmatrix}T\\0\end{pmatrix} $$
#
# ### Exercise: the system in your own lines
#
# Hand back the square matrix (N + 4, N + 4). A row of $P$ is $(1, x, y, z)$. Useful: `a[:, None] - a` are all differences of points,
# `np.hstack` puts side by side, `np.block([[a, b], [c, d]])` builds from four.


# %%
def system(source):
    # solution: return ...
    distance = np.linalg.norm(source[:, None] - source, axis=2)
    p = np.hstack([np.ones((len(source), 1)), source])
    return np.block([[distance, p], [p.T, np.zeros((4, 4))]])
    # end solution


check("system", system)

# %% [markdown]
# ### Exercise: the warp in your own lines
#
# Solve the system with `np.linalg.solve`, and hand back where `points` (M, 3) go: also (M, 3). The first N rows of the solution are the
# weights, then comes $\mathbf b$, then the three rows of $\mathbf A^{\mathsf T}$.


# %%
def warp(points, source, target):
    # solution: return ...
    solved = np.linalg.solve(system(source), np.vstack([target, np.zeros((4, 3))]))
    weight, shift, linear = solved[:-4], solved[-4], solved[-3:].T
    distance = np.linalg.norm(points[:, None] - source, axis=2)
    return distance @ weight + points @ linear.T + shift
    # end solution


check("warp", warp)

# %% [markdown]
# The package has the same as `rbf.fitted(source, target)`, compiled: a warp that you can call, with `weight`, `linear` and `shift`.
#
# ## 3 What the affine part is for
#
# ### Exercise: predict
#
# A hand of the same shape, 0.7 times as large and 50 mm farther on: `target = 0.7 * source + [0.05, 0, 0]`. Before you compute: how large
# is the largest of all weights? Think of what $\mathbf A$ and $\mathbf b$ can do alone.

# %%
# solution: largest_weight = ...
largest_weight = 0
print(np.abs(rbf.fitted(source, 0.7 * source + np.array([0.05, 0, 0])).weight).max())
# end solution
check("affine", largest_weight)

# %% [markdown]
# ### Exercise: break it
#
# Leave everything off but the sum: $\Phi W = T$, no $\mathbf A$, no $\mathbf b$, no side conditions. Now take the simplest task of all:
# `target = source`, **nothing** moves. How many millimetres does the worst point of the bones move all the same? In which bone is it?
# `owner` has the name of the bone for each row of `bones`.

# %%
owner = np.repeat(list(hand.bones), [len(bone.points) for bone in hand.bones.values()])


def sum_alone(points, source, target):
    # solution: return np.full(points.shape, np.nan)
    weight = np.linalg.solve(np.linalg.norm(source[:, None] - source, axis=2), target)
    return np.linalg.norm(points[:, None] - source, axis=2) @ weight
    # end solution


# solution: worst_mm, bone = ..., ...
moved = 1000 * np.linalg.norm(sum_alone(bones, source, source) - bones, axis=1)
worst_mm, bone = moved.max(), owner[moved.argmax()]
# end solution
check("without", worst_mm, bone)

# %%
along = np.linspace(-0.15, 0.25, 200)
points = np.column_stack([along, np.full(200, source[:, 1].mean()), np.zeros(200)])
whole = rbf.fitted(source, source)
figure, axes = plt.subplots(figsize=(12, 6))
for k, (label, after) in enumerate((("sum alone", sum_alone(points, source, source)), ("with affine part", whole(points)))):
    axes.plot(1000 * along, 1000 * np.linalg.norm(after - points, axis=1).round(9), label=label, **line(k))
axes.axvspan(1000 * source[:, 0].min(), 1000 * source[:, 0].max(), color="#D5DBE1", label="where the feature points are")
axes.set(xlabel="mm along the hand (0: wrist)", ylabel="moved by (mm)", title="when nothing should move")
axes.legend()
plt.close(figure)
figure

# %% [markdown]
# Without the affine part the warp is right at 26 points and wrong everywhere else, most of all where no point is near: in the forearm. With
# it, what is simple stays simple, and far away the sum dies out, because the side conditions keep it from growing.
#
# ## 4 All in one plane
#
# A hand on a table is nearly flat. Press it quite flat: all points get y = 0.
#
# ### Exercise: break it, and see how the package mends it
#
# What is the rank of the system for `flat` (`np.linalg.matrix_rank`)? It has 30 rows. Then: the flat points are shrunk to `0.7 * flat`.
# Nothing in the points says what happens to bones **above** the plane. Where does the package put a point that was 20 mm above it: how many
# millimetres above? (`rbf.fitted(...)`; y is up.) Which choice is that?

# %%
flat = source * [1, 0, 1]
# solution: rank, height_mm = ..., ...
rank = np.linalg.matrix_rank(system(flat))
height_mm = 1000 * rbf.fitted(flat, 0.7 * flat)(np.array([[0.08, 0.02, 0]]))[0, 1]
# end solution
check("flat", rank, height_mm)

# %% [markdown]
# Points that are **nearly** flat are worse: the computer finds an answer, and it hangs on tenths of a millimetre. The condition number says
# by how much errors are blown up at most. Watch it grow as the heights shrink:

# %%
heights = np.array([1, 0.1, 0.01, 0.001])
numbers = [np.linalg.cond(system(source * [1, h, 1])) if system(source) is not ... else np.nan for h in heights]
figure, axes = plt.subplots(figsize=(12, 5))
axes.loglog(heights, numbers, marker="o", markersize=12, **line(0))
axes.set(xlabel="heights times", ylabel="condition number of the system", title="flat hands are ill-conditioned")
plt.close(figure)
figure

# %% [markdown]
# So the package does not trust the heights of clicks alone. It adds a second layer of points 20 mm behind the first, which moves as the
# hand does as a whole: thickness stays in proportion to size.
#
# ## 5 Make it fold
#
# Where $\mathbf f$ turns space inside out, left and right are exchanged, and a bone is pulled through itself. The **Jacobian** tells: the
# matrix of derivatives. Its determinant is how many times larger a small cube becomes; below zero the cube is turned inside out.
#
# $$ \frac{\partial\mathbf f}{\partial\mathbf x}=\mathbf A+\sum_i\mathbf w_i\,
# \frac{(\mathbf x-\mathbf s_i)^{\mathsf T}}{\lVert\mathbf x-\mathbf s_i\rVert} $$
#
# ### Exercise: the Jacobian in your own lines
#
# For one point `x` (3,): hand back the 3 x 3 matrix. `made.centre`, `made.weight`, `made.linear` are the $\mathbf s_i$, $\mathbf w_i$ and
# $\mathbf A$ of a warp of the package.


# %%
def jacobian(x, made):
    # solution: return ...
    way = x - made.centre
    unit = way / np.linalg.norm(way, axis=1, keepdims=True)
    return made.linear + made.weight.T @ unit
    # end solution


check("jacobian", jacobian)

# %% [markdown]
# **Before you touch anything:** you drag the PIP point of the index finger towards its tip. How far can you go before a bone folds? As far
# as the next point? Half of it? And sideways: farther or less far?
#
# Then drag. (`panel.set(point="pip_index", distal_mm=20)` does the same.) The grid was square.

# %%
panel = WarpPanel(hand, "pip_index", distal_mm=15)
panel

# %% [markdown]
# ### Exercise: find the limit
#
# By how many millimetres, in whole numbers, must `pip_index` be dragged distally so that a bone folds for the first time? Which bone? And
# how many millimetres is `dip_index` away from `pip_index`? (`panel.folded` and `panel.least` tell. Or write a loop: `rbf.jacobian(made,
# bones)` has all Jacobians at once.)

# %%
# solution: limit_mm, bone, apart_mm = ..., ..., ...
for limit_mm in range(80):
    dragged = source.copy()
    dragged[NAMES.index("pip_index"), 0] += limit_mm / 1000
    cubes = np.linalg.det(rbf.jacobian(rbf.fitted(source, dragged), bones))
    if cubes.min() < 0:
        break
bone = owner[cubes.argmin()]
apart_mm = 1000 * np.linalg.norm(source[NAMES.index("dip_index")] - source[NAMES.index("pip_index")])
# end solution
check("fold", limit_mm, bone, apart_mm)

# %% [markdown]
# A warp folds about where two points change their order. That is what a wrong click or a swapped name does.
#
# ## 6 Repair
#
# Somebody clicked the child's hand in a hurry: one of the 26 points is wrong. `misplaced()` has what was clicked, lifted to 3D.

# %%
hurried = misplaced()
made = rbf.fitted(source, hurried)
print(f"least determinant in all bones: {np.linalg.det(rbf.jacobian(made, bones)).min():.3f}")

# %% [markdown]
# ### Exercise: find the culprit
#
# Points may be left out. Leave out each in turn, warp with the other 25, and look at the least determinant in all bones. Which point's
# absence heals most? Hand back its name, and the least determinant without it. (`np.delete(source, i, axis=0)` leaves out row `i`.)

# %%
# solution: culprit, healed = ..., ...
least = {}
for i, name in enumerate(NAMES):
    others = rbf.fitted(np.delete(source, i, axis=0), np.delete(hurried, i, axis=0))
    least[name] = np.linalg.det(rbf.jacobian(others, bones)).min()
culprit = max(least, key=least.get)
healed = least[culprit]
# end solution
check("repair", culprit, healed)

# %% [markdown]
# ### Exercise: extend it
#
# Another medicine: a warp that need not hit its points exactly. Take `relax` times the unit matrix **off** the distances,
# $\Phi-\lambda I$ (off, because distances grow where other kernels fall), and solve as before. With $\lambda$ = 0.005 m: by how many
# millimetres does the warp miss the wrong click, and by how many the other 25 on average?

# %%
relax = 0.005
# solution: culprit_mm, others_mm = ..., ...
softer = system(source) - relax * np.diag([1] * 26 + [0] * 4)
solved = np.linalg.solve(softer, np.vstack([hurried, np.zeros((4, 3))]))
reached = system(source)[:26] @ solved
missed = 1000 * np.linalg.norm(reached - hurried, axis=1)
culprit_mm, others_mm = missed[NAMES.index(culprit)], np.delete(missed, NAMES.index(culprit)).mean()
# end solution
check("extend", culprit_mm, others_mm)

# %% [markdown] tags=["solution"]
# *For the lecturer.* The softened warp does not fold any more, and it is still wrong: the culprit is far from where the joint is, and all
# its neighbours have been pulled along. A warp that forgives hides the error; a warp that hits every point shows it. Ask which of the two
# a radiologist should use, and which a maker of games.

# %% [markdown]
# ## 7 What the outline adds
#
# Twenty-six points tell how long a finger is; how broad it is, they hardly tell. The picture does: where the hand ends. `hl.fit_photo`
# looks where the edge of the warped skin lies beside the edge of the hand in the picture, and takes points of it into the same system,
# with a $\lambda$ of their own as in the last exercise: 2 mm for them, because pixels are rough, and none for the clicks.
#
# ### Exercise: measure
#
# `fit.iou` is the overlap of the two hands in the picture, drawn and photographed: what they share over what either covers. What is it
# without and with the outline? And by how many millimetres on average does the warp `both.warped.rbf` miss the points that came from the
# outline, `both.edge.source`, on their way to `both.edge.target`? The next cell makes both hands.

# %%
photo = table_photo(child, px_per_mm=4.0)
asked = {"landmarks": photo.marks_px, "scale": photo.scale, "view": "palmar", "side": "right", "camera_mm": photo.camera_mm}
alone, both = (hl.fit_photo(photo.pixels, outline=used, centre_px=photo.centre_px, **asked) for used in (False, True))
figure, axes = plt.subplots(figsize=(8, 9))
axes.imshow(photo.pixels)
for fit, colour, name in ((alone, "#E69F00", "26 points alone"), (both, "#56B4E9", "and the outline")):
    axes.plot(*np.vstack([fit.outline, fit.outline[:1]]).T, color=colour, linewidth=2.5, label=name)
axes.set(xticks=[], yticks=[], title="a child's hand, photographed")
axes.legend(loc="lower right", facecolor="white", framealpha=1.0)
plt.close(figure)
figure

# %%
# solution: alone_iou, both_iou, missed_mm = ..., ..., ...
alone_iou, both_iou = alone.iou, both.iou
missed_mm = 1000 * np.linalg.norm(both.warped.rbf(both.edge.source) - both.edge.target, axis=1).mean()
# end solution
check("outline", alone_iou, both_iou, missed_mm)

# %% [markdown]
# ## 8 Doubt the data
#
# The warp believes every click. On the child's finger, let `pip_index` and `dip_index` be clicked 1 mm wrong each, towards each other.
#
# ### Exercise: predict
#
# By how many percent does the bone between them come out too short? (`target` has the true places.) And with clicks that are equally
# wrong, which segment suffers more: a `"long"` or a `"short"` one?

# %%
# solution: short_percent, suffers = ..., ...
between = target[NAMES.index("dip_index")] - target[NAMES.index("pip_index")]
short_percent = 100 * 2 / (1000 * np.linalg.norm(between))
suffers = "short"
# end solution
check("doubt", short_percent, suffers)

# %% [markdown]
# ## Summary
#
# - The warp is a sum of distances and an affine map, solved from one small system. It hits every feature point.
# - The affine part does what is simple; the side conditions keep the sum from doing it too, and from growing far away.
# - Flat points leave one direction open. The package goes on as a similarity, and adds a second layer behind the points.
# - A negative determinant is a fold. It comes where two points change their order.
# - Points tell lengths, outlines tell breadths, and neither tells what lies across the picture.
# - What folds is found by computing; what is wrong is found by leaving out. To smooth is not to repair.

# %%
check.summary()
