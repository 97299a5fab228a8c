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
# # 10 · From pixels to millimetres to 3D
#
# Close one eye and hold your thumb up at arm's length: it covers a house. Bring it nearer, and it covers a street. A photograph is made by
# one eye. On this page you find out how large a photographed hand is, how far the answer may be off, and what no photograph can tell.
#
# After this lesson you can
#
# - predict where a camera sees a point, with similar triangles;
# - turn pixels into millimetres by two clicks on a ruler, and say what a ruler on a book of 2 cm does to the answer;
# - give flat points a height, as section 5.2 of the paper does;
# - say what a photograph does not know, and show it.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.fitting.landmarks import NAMES, source_points
from handlab.show.figures import STYLE, line
from handlab.show.ruler_panel import RulerPanel
from handlab.studies.table_photo import table_photo

# %%
plt.rcParams.update(STYLE)
check = lesson("10")
hand = hl.load_hand()
child = hl.load_hand("child")

# %% [markdown]
# ## 1 The idea
#
# A child lays a hand on the table, palm up, beside a ruler. A camera hangs 600 mm above the table. What is farther from the table is
# nearer to the camera, and looks larger: the fingers, but not the ruler.
#
# `table_photo` computes such a photograph. So here, for once, the truth is known: `photo.marks_mm` has the true place of every feature
# point, (x, y, height) in millimetres. `photo.marks_px` is where they are in the picture, as if you had clicked them, and `photo.ruler_px`
# has the two clicks on the ruler, at 0 and at 150 mm.

# %%
photo = table_photo(child, camera_mm=600)
figure, axes = plt.subplots(figsize=(8, 9))
axes.imshow(photo.pixels)
axes.plot(*np.array(list(photo.marks_px.values())).T, "o", color="white", markeredgecolor="black", markersize=9)
axes.set(xlabel="pixels, to the right", ylabel="pixels, DOWNWARDS", title="26 feature points and a ruler of 150 mm")
axes.grid(visible=False)
plt.close(figure)
figure

# %% [markdown]
# ### Exercise: guess
#
# The ruler does not lie on the table but on a book, 20 mm high. By how many percent will the size of the hand come out wrong? A guess is
# all that is asked.

# %%
# solution: guess_percent = ...
guess_percent = 1
# end solution
check("guess", guess_percent)

# %% [markdown]
# ## 2 Similar triangles
#
# The camera is a hole at the height $d$. A point at the place $(x, y)$, $h$ above the table, is seen where the ray from the camera through
# it meets the table. The triangle above the point (height $d-h$) and the one down to the table (height $d$) have the same angles:
#
# $$ x' = x\,\frac{d}{d-h} \qquad\qquad y' = y\,\frac{d}{d-h} $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $x, y$ | place, counted from straight below the camera | `point[0], point[1]` | mm |
# | $h$ | height above the table | `point[2]` | mm |
# | $d$ | height of the camera above the table | `camera_mm` | mm |
# | $x', y'$ | where on the table it is seen | | mm |
# | $k$ | size of a pixel on the table | `mm_per_px` | mm/px |
#
# ### Exercise: the equation in your own lines
#
# Hand back an array of two numbers. The check compares with the package.


# %%
def place(point, camera_mm):
    # solution: return ...
    return point[:2] * camera_mm / (camera_mm - point[2])
    # end solution


check("project", place)

# %% [markdown]
# ## 3 Two clicks on a ruler
#
# Click 0 and 150 mm. As many pixels as lie between the clicks are 150 mm, so
#
# $$ k = \frac{d_\text{ruler}}{\lVert\mathbf p_1-\mathbf p_2\rVert} $$
#
# ### Exercise: calibrate
#
# `first`, `second`: two clicks, arrays (x, y) in pixels. The ruler may lie at any angle. Hand back millimetres per pixel.


# %%
def mm_per_px(first, second, millimetres):
    # solution: return ...
    return millimetres / np.linalg.norm(second - first)
    # end solution


check("scale", mm_per_px)

# %% [markdown]
# ### Exercise: measure the child's knuckles
#
# How far is the knuckle of the index finger (`"mcp_index"`) from that of the little finger (`"mcp_little"`) in the photograph, in
# millimetres by the ruler? And by how many percent is that too long? The truth: the same two points in `photo.marks_mm`, seen from straight
# above, which means x and y alone.


# %%
def knuckles_mm(photo):
    # solution: return ...
    a, b = (np.array(photo.marks_px[name]) for name in ("mcp_index", "mcp_little"))
    return np.linalg.norm(b - a) * mm_per_px(*photo.ruler_px, 150)
    # end solution


# solution: too_long_percent = ...
true_mm = np.linalg.norm((photo.marks_mm["mcp_index"] - photo.marks_mm["mcp_little"])[:2])
too_long_percent = 100 * (knuckles_mm(photo) / true_mm - 1)
# end solution
check("knuckles", knuckles_mm(photo), too_long_percent)

# %% [markdown]
# Every ruler on the table makes every hand too large: the hand is nearer to the camera than the table is.
#
# ## 4 A ruler lifted by 2 cm
#
# ### Exercise: predict, then measure
#
# Now the ruler lies on the book, 20 mm high; the camera is at 600 mm, the hand stays. A higher ruler looks longer. By how many percent
# does every size come out **smaller** than with the ruler on the table? First predict, with similar triangles. Then measure, with
# `knuckles_mm` in both photographs.

# %%
lifted = table_photo(child, camera_mm=600, ruler_mm=20)
# solution: predicted_percent, measured_percent = ..., ...
predicted_percent = 100 * (1 - (600 - 20) / 600)
measured_percent = 100 * (1 - knuckles_mm(lifted) / knuckles_mm(photo))
# end solution
check("lifted", predicted_percent, measured_percent)

# %% [markdown]
# ### Exercise: closer and farther
#
# The same book. How many percent are lost if the camera is at 300 mm? And how high must the camera be, in millimetres, so that only
# 1 percent is lost?

# %%
# solution: near_percent, far_mm = ..., ...
near_percent = 100 * 20 / 300
far_mm = 20 / 0.01
# end solution
check("camera", near_percent, far_mm)

# %%
figure, axes = plt.subplots(figsize=(12, 6))
heights = np.linspace(0, 60, 61)
for k, camera in enumerate((300, 600, 2000)):
    axes.plot(heights, -100 * heights / camera, label=f"camera at {camera} mm", **line(k))
axes.plot(20, -measured_percent if measured_percent is not ... else np.nan, "o", color="black", markersize=14, label="measured")
axes.set(xlabel="height of the ruler above the table (mm)", ylabel="error of every size (percent)")
axes.legend()
plt.close(figure)
figure

# %% [markdown]
# ## 5 The best place for the ruler
#
# One error makes the hand too large, the other too small.
#
# **Before you touch anything:** at which height of the ruler do the two cancel for the knuckles? Does that height change when the camera
# goes up? Then move the sliders. (`panel.set(ruler_mm=20, camera_mm=1000)` does the same.)

# %%
panel = RulerPanel(child, ruler_mm=20)
panel

# %% [markdown]
# ### Exercise: repair
#
# At which height of the ruler, in millimetres, is the distance of the knuckles right? One millimetre more or less does not matter. And
# which is the rule: measure a point with a ruler that lies ... `"on the table"`, `"as high as the point"` or `"as high as possible"`?

# %%
# solution: best_mm, rule = ..., ...
best_mm = np.mean([photo.marks_mm[name][2] for name in ("mcp_index", "mcp_little")])
rule = "as high as the point"
# end solution
check("repair", best_mm, rule)

# %% [markdown]
# ## 6 From flat to 3D
#
# The warp of lesson 11 needs points in space, but clicks are flat. The paper (section 5.2) gives each click the height that its feature
# point has on the reference hand, above the plane that fits all of them best, times the ratio of the two sizes:
#
# $$ h_i = \langle\mathbf s_i-\bar{\mathbf s},\,\mathbf n\rangle \qquad\qquad h_i' = h_i\,\frac{D_t}{D_s} $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\mathbf s_i, \bar{\mathbf s}$ | feature points of the reference hand, their mean | `source` (N, 3) | m |
# | $\mathbf n$ | direction in which they spread least, length 1 | last row of `np.linalg.svd(...)[2]` | 1 |
# | $D_t/D_s$ | size of the photographed hand over that of the reference hand | `ratio` | 1 |
#
# ### Exercise: heights in your own lines
#
# `np.linalg.svd(a)[2]` has three rows of length 1: the directions in which the rows of `a` spread, the largest spread first. They must be
# counted from their mean. The sign of the normal is free.


# %%
def scaled_heights(source, ratio):
    # solution: return ...
    away = source - source.mean(axis=0)
    normal = np.linalg.svd(away)[2][-1]
    return ratio * away @ normal
    # end solution


check("heights", scaled_heights)

# %%
high = scaled_heights(source_points(hand, "palmar"), 0.7)
high = np.zeros(26) if high is ... else np.asarray(high)
figure, axes = plt.subplots(figsize=(12, 7))
axes.barh(range(26), 1000 * high, color="#0072B2")
axes.set(yticks=range(26), xlabel="height over the fitting plane (mm)", title="what 26 clicks get for a hand 0.7 times as large")
axes.set_yticklabels(NAMES, fontsize=11)
axes.invert_yaxis()
plt.close(figure)
figure

# %% [markdown]
# ## 7 What a photograph cannot know
#
# Look at the heights again: not one of them comes from the photograph.
#
# ### Exercise: a thick hand
#
# `table_photo(child, thickness=1.3)` photographs a hand that is 1.3 times as thick, and as long and broad as before. The camera is far away
# (20 m, or a scanner), so perspective says nothing. Both photographs become hands. Predict: will the hand from the second picture be
# `"thicker"` or the `"same"`? Then measure: volume of the second hand over that of the first.


# %%
def fitted(photo, camera_mm=None):
    """The hand that the package makes of a photograph."""
    where = {"view": "palmar", "side": "right", "camera_mm": camera_mm, "centre_px": photo.centre_px}
    return hl.fit_photo(photo.pixels, landmarks=photo.marks_px, scale=photo.scale, **where)


thin, thick = (table_photo(child, camera_mm=20_000, thickness=times) for times in (1.0, 1.3))
# solution: word, ratio = ..., ...
word = "same"
ratio = fitted(thick).hand.skin.volume / fitted(thin).hand.skin.volume
# end solution
check("thick", word, ratio)

# %% [markdown] tags=["solution"]
# *For the lecturer.* The mass of the thick hand is off by 30 percent and nobody can see it. Ask what would help: a second photograph from
# the side, a glass of water and a balance (lesson 04), a caliper for one finger. Perspective from 60 cm does hold a trace of the heights,
# but a click that is one pixel off drowns it.

# %% [markdown]
# ### Exercise: twins
#
# A ruler of 150 mm lies 20 mm above the table; the camera is at 600 mm. Another ruler lies **on** the table and looks exactly the same. How
# long is it, in millimetres? And can you tell the two photographs apart: `"yes"` or `"no"`?

# %%
# solution: twin_mm, apart = ..., ...
twin_mm = 150 * 600 / (600 - 20)
apart = "no"
# end solution
check("twins", twin_mm, apart)

# %% [markdown]
# ## 8 Repair what can be repaired
#
# The heights of the reference hand are not the child's, but they are near. So if the distance of the camera is known, perspective can be
# taken out: every click is moved to where a camera far away would see it.
#
# ### Exercise: what does it cost not to know?
#
# Make hands of `photo` with `camera_mm=600` and without (`None`). By how many percent is the hand too large without: its length
# (`fit.growth`, the size over that of the reference hand) and its volume (`fit.hand.skin.volume`)?

# %%
# solution: length_percent, volume_percent = ..., ...
known, unknown = fitted(photo, 600), fitted(photo)
length_percent = 100 * (unknown.growth / known.growth - 1)
volume_percent = 100 * (unknown.hand.skin.volume / known.hand.skin.volume - 1)
# end solution
check("known", length_percent, volume_percent)

# %% [markdown]
# ## 9 Doubt the data
#
# Nobody clicks exactly. Say each click is off by 1 pixel (standard deviation, in each direction). The distance of two clicks is then off
# by $\sqrt2$ pixels, because two errors add like the sides of a right angle.
#
# ### Exercise: which error is the largest?
#
# By how many percent is the scale uncertain if you click 0 and 150 mm of the ruler in `photo`? And if you click 0 and 20 mm? Then: what
# does most harm in this photograph: the `"clicks"` (0 and 150 mm), the `"book"` below the ruler, or the `"hand"`, whose knuckles lie
# above a ruler on the table?

# %%
# solution: long_percent, short_percent, worst = ..., ..., ...
pixels = np.linalg.norm(photo.ruler_px[1] - photo.ruler_px[0])
long_percent = 100 * np.sqrt(2) / pixels
short_percent = 100 * np.sqrt(2) / (pixels * 20 / 150)
worst = "hand"
# end solution
check("doubt", long_percent, short_percent, worst)

# %% [markdown]
# ## Summary
#
# - A camera sees a point $h$ above the table larger by $d/(d-h)$. The error is $h/d$: small heights and far cameras make good rulers.
# - A ruler lifted by 2 cm makes everything smaller by 3.3 percent at 60 cm. A hand above the ruler comes out larger.
# - The best ruler lies as high as what it measures.
# - Heights come from the reference hand, scaled. A photograph knows nothing of thickness, nor of what is not in it.
# - Long before your clicks matter, the geometry of the scene does. Look for the largest error first.

# %%
check.summary()
