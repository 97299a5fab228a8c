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
# # 07 · Springs and the stable step
#
# Pinch the skin on the back of your hand, lift it, and let go. It is flat again before you can see how. On this page your skin becomes
# 1,500 little masses on springs, and you compute how fast it is, and how often a computer must look so as not to lose it.
#
# After this lesson you can
#
# - write the force of a spring, and let a mass swing on it by the **leapfrog** rule;
# - say how long a step of time may be, without trying;
# - say which swing of a net of springs explodes first, and find it in the skin of a hand;
# - predict what stiffer skin, a finer net, damping and a heavy node do to the number of steps, and be right within 2 percent.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.physics import springs
from handlab.show.figures import STYLE, line
from handlab.show.spring_panel import SpringPanel
from handlab.simulation.soft_skin import soft_skin
from handlab.studies import shaking

plt.rcParams.update(STYLE)
check = lesson("07")

# %% [markdown]
# ## 1 The idea
#
# Skin is elastic: pull it, and it pulls back. So we put a small **mass** at every corner of the mesh and a **spring** along every edge.
# Two more springs for each mass tie it to what lies below, bone or muscle. Then the masses move as Newton says.

# %%
hand = hl.load_hand()
net = soft_skin(hand)
figure, axes = plt.subplots(figsize=(12, 7))
axes.triplot(1000 * net.points[:, 0], 1000 * net.points[:, 2], net.faces, linewidth=0.7, color="#0072B2")
axes.set(aspect="equal", xlabel="mm, towards the fingertips", ylabel="mm, towards the thumb")
axes.set_title(f"{len(net.mass)} masses, {len(net.stiffness)} springs along edges, {1000 * net.mass.sum():.0f} g of skin")
plt.close(figure)
figure

# %% [markdown]
# ### Exercise: guess
#
# A film has 60 pictures a second. How many steps of time does the skin need from one picture to the next? One? Ten? A thousand?
# A guess is all that is asked.

# %%
# solution: guess_steps = ...
guess_steps = 10
# end solution
check("guess", guess_steps)

# %% [markdown]
# ## 2 The equation
#
# $$ \mathbf F = k\,(\ell-\ell_0)\,\mathbf n \qquad\qquad m\,\frac{d\mathbf v}{dt} = \mathbf F \qquad\qquad
# \frac{d\mathbf x}{dt} = \mathbf v $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $k$ | stiffness of the spring: force for each metre | `k` | N/m |
# | $\ell, \ell_0$ | its length now, and at rest | `rest` | m |
# | $\mathbf n$ | direction from the mass to the other end, length 1 | | 1 |
# | $\mathbf x, \mathbf v$ | place and velocity of the mass | `x`, `v` | m, m/s |
# | $m$ | mass | `m` | kg |
# | $\Delta t$ | step of time | `dt` | s |
# | $\omega$ | how fast it swings: $2\pi$ times swings per second | `omega` | rad/s |
#
# ### Exercise: the force in your own lines
#
# `node` and `other` are the two ends, each an array of three numbers. Hand back the force on `node`. Think of the sign: a stretched spring
# pulls its mass **towards** the other end. `np.linalg.norm(a)` is the length of `a`.


# %%
def force(node, other, k, rest):
    # solution: return ...
    way = other - node
    length = np.linalg.norm(way)
    return k * (length - rest) * way / length
    # end solution


check("force", force)

# %% [markdown]
# ## 3 The leapfrog
#
# Places and velocities jump over each other, like children: places are known at full steps, velocities half a step behind.
#
# $$ \mathbf v_{n+1/2}=\mathbf v_{n-1/2}+\Delta t\,\mathbf a(\mathbf x_n),\qquad\mathbf x_{n+1}=\mathbf x_n+\Delta t\,\mathbf v_{n+1/2} $$
#
# ### Exercise: the step in your own lines
#
# `acceleration` is a function of the place. Hand back the new place, then the new velocity. The check compares with `springs.leapfrog`.


# %%
def leap(x, v, acceleration, dt):
    # solution: return ...
    v = v + dt * acceleration(x)
    return x + dt * v, v
    # end solution


check("leap", leap)

# %% [markdown]
# ## 4 How long may a step be?
#
# One mass of 0.1 g hangs between two springs, 1 N/m each, so the stiffness is $k$ = 2 N/m in all. `swings` makes 3,000 leapfrog steps and
# tells whether the mass is still near.
#
# ### Exercise: break it, then predict
#
# Find the longest step, in milliseconds, with which the mass does not fly away; within 2 percent.
#
# Theory says: $\Delta t < 2/\omega$ with $\omega=\sqrt{k/m}$. Compare. Then predict, **without trying**: how long is the longest step, in
# milliseconds, if the spring is twice as stiff?

# %%
m, k = 1e-4, 2.0


def swings(step_ms, damping=0.0):
    x, v = 0.001, 0.0
    for _ in range(3000):
        x, v = springs.leapfrog(x, v, lambda x: -k * x / m, step_ms / 1000, damping)
        if abs(x) > 0.1:
            return False
    return True


# %%
print([(step_ms, swings(step_ms)) for step_ms in (1, 5, 50)])
# solution: longest_ms, stiffer_ms = ..., ...
longest_ms = max(step_ms for step_ms in np.arange(10, 20, 0.1) if swings(step_ms))
stiffer_ms = 1000 * 2 / np.sqrt(2 * k / m)
# end solution
check("limit", longest_ms, stiffer_ms)

# %% [markdown]
# Where does the 2 come from? A mass at $x$ is pushed by $-\omega^2 x$. In a step that is too long it is thrown beyond its rest place,
# to the other side, and lands farther out than it was. At $\Delta t = 2/\omega$ it lands exactly as far out, every time.
#
# ### Exercise: does damping help?
#
# Skin swings like jelly, only shorter: it is damped. Before you try: with a damping of 200 per second, is the longest step `"longer"`,
# `"shorter"` or the `"same"`? Try with `swings(step_ms, damping=200)`.

# %%
# solution: with_damping = ...
damped_ms = max(step_ms for step_ms in np.arange(10, 20, 0.1) if swings(step_ms, damping=200))
print(f"{damped_ms:.1f} ms with damping, {longest_ms:.1f} ms without")
with_damping = "same"
# end solution
check("damping", with_damping)

# %% [markdown]
# ## 5 A row of masses
#
# Now masses in a row between two walls, joined by springs of 2 N/m each. They begin anywhere and swing.
#
# **Before you touch anything:** does a longer row need a shorter step? And when the step is too long, how will the masses lie just before
# they fly away: all on one side, in a gentle wave, or every neighbour on the other side?
#
# Then move the sliders: 1 mass, 2, 20. (`panel.set(masses=20, step_ms=7.2)` does the same.)

# %%
panel = SpringPanel(masses=20, mass=m, stiffness=k, step_ms=6.0)
panel

# %% [markdown]
# ### Exercise: the swing that explodes first
#
# The longest step of 1 mass and of 40 masses between the walls, in milliseconds (within 2 percent)? And in the swing that explodes first,
# do neighbours move `"together"` or `"against"` each other?
#
# `row` is a panel without a picture: `row.set(masses=1, step_ms=9)`, then `row.exploded` says `True` or `False`.

# %%
row = SpringPanel(masses=1, mass=m, stiffness=k)
# solution: one_ms, forty_ms, neighbours = ..., ..., ...
found = {}
for masses in (1, 40):
    for step_ms in np.arange(6.0, 11.0, 0.05):
        row.set(masses=masses, step_ms=step_ms)
        if row.exploded:
            break
        found[masses] = step_ms
one_ms, forty_ms, neighbours = found[1], found[40], "against"
# end solution
check("row", one_ms, forty_ms, neighbours)

# %% [markdown]
# Moving against its neighbours, a mass stretches every spring from both ends: that is the stiffest swing there is. It looks like noise and
# nobody wants to see it. It sets the step for all the others.
#
# ### Exercise: predict, a finer net
#
# A student cuts every edge of the skin's mesh in two, for more beautiful folds. An edge of skin keeps its stiffness (half as long, but half
# as wide); every mass becomes a quarter; there are four times as many of both. By which factor grows the number of steps in a picture? By
# which factor grows the work for it?

# %%
# solution: steps_factor, work_factor = ..., ...
steps_factor = np.sqrt(1 / (1 / 4))
work_factor = 4 * steps_factor
# end solution
check("finer", steps_factor, work_factor)

# %% [markdown]
# ## 6 The skin of a hand
#
# All forces together are one matrix: $\mathbf F = -K\mathbf x$ for small displacements $\mathbf x$ of all masses. The fastest swing has the
# largest $\omega^2$ for which $K\mathbf x = \omega^2 M\mathbf x$, an **eigenvalue**. There is a way to find it that fits into a few lines:
# take any displacement, let $M^{-1}K$ act on it again and again, and make its length 1 each time. The fastest swing wins. The factor by
# which it grows is $\omega^2$.
#
# ### Exercise: the fastest swing in your own lines
#
# `K @ x` works for the small matrix of the panel and for the large one of the skin. `mass` has one number for every row of `K`. Take 200
# rounds. Hand back $\omega$.


# %%
def fastest(K, mass):
    x = np.cos(np.arange(len(mass)) ** 2)  # any displacement will do
    # solution: return ...
    for _ in range(200):
        x = (K @ x) / mass
        square = np.linalg.norm(x)
        x = x / square
    return np.sqrt(square)
    # end solution


check("fastest", fastest)

# %% [markdown]
# ### Exercise: predict, then measure
#
# `shaking.stiffness(net)` is $K$ of the skin, `net.mass` the mass of every node in kg, `net.frequency` the $\omega$ that the package found.
# A picture lasts 1/60 s. How many steps does it need at least? Give the number with its decimals.
#
# Then measure. `shaking.grows(net, n)` moves every mass by a millionth of a millimetre, makes 800 steps, `n` to a picture, and tells
# whether that has grown. What is the smallest whole `n` with which the skin is stable?

# %%
omega = springs.largest_frequency(shaking.stiffness(net), net.mass)
print(f"the fastest swing: {omega / 2 / np.pi:.0f} times a second")
# solution: predicted_steps, stable_steps = ..., ...
predicted_steps = omega / 60 / 2
stable_steps = min(n for n in range(38, 60) if not shaking.grows(net, n))
# end solution
check("steps", predicted_steps, stable_steps)

# %%
parts = np.array([0.97, 0.98, 0.99, 0.995, 1.005, 1.01, 1.02, 1.03])
grown = [min(shaking.growth(net, part * shaking.predicted(net)), 1e6) for part in parts]
figure, axes = plt.subplots(figsize=(12, 5.5))
axes.semilogy(100 * parts, np.maximum(grown, 1e-6), marker="o", markersize=11, **line(0))
axes.axvline(100, color="black", linestyle="--", linewidth=2)
axes.axhline(1, color="0.45", linewidth=1.5)
axes.set(xlabel="steps to a picture (percent of the prediction)", ylabel="times the disturbance")
axes.set_title("stable to the right of the dashed line")
plt.close(figure)
figure

# %% [markdown]
# The prediction is good to a fraction of a percent. So nobody has to try. The package takes 0.7 of the longest step, because skin that
# is stretched or turned may be stiffer than skin at rest: `net.substeps(1 / 60)`.
#
# ### Exercise: predict double stiffness
#
# `soft_skin(hand, young=..., tissue=...)` makes another net: `young` is the stiffness of the skin, `tissue` that of what lies below it,
# both as Young's modulus in Pa (100,000 Pa and 15,000 Pa if nothing is given). **Predict first**, on paper: how many steps (with
# decimals) does a net need in which **both** are doubled? Then measure: the smallest stable whole number.
#
# And if **only** the tissue is doubled: by how many percent do the steps grow? (Measure with `shaking.predicted`.) Which springs, then, set
# the step?

# %%
# solution: double_steps, double_stable, tissue_percent = ..., ..., ...
double_steps = np.sqrt(2) * predicted_steps
double = soft_skin(hand, young=2e5, tissue=3e4)
double_stable = min(n for n in range(55, 80) if not shaking.grows(double, n))
tissue_percent = 100 * (shaking.predicted(soft_skin(hand, tissue=3e4)) / predicted_steps - 1)
# end solution
check("double", double_steps, double_stable, tissue_percent)

# %% [markdown]
# ### Exercise: repair, who sets the step?
#
# `shaking.worst_pattern(net)` says how far every node swings (x, y, z) in the fastest swing, the farthest by 1. How many of the 1,500
# nodes take part with more than a half?
#
# Then repair it: make **at most five** nodes twice as heavy, so that the whole net gets along with at least 2 percent fewer steps. Hand
# over the list of their numbers. `shaking.with_mass(net, mass)` is a net with other masses.

# %%
swing = np.linalg.norm(shaking.worst_pattern(net), axis=1)
# solution: many, heavier = ..., [...]
many = int((swing > 0.5).sum())
heavier = np.argsort(-swing)[:3].tolist()
mass = net.mass.copy()
mass[heavier] *= 2
print(f"{shaking.predicted(net):.2f} steps, then {shaking.predicted(shaking.with_mass(net, mass)):.2f}")
# end solution
check("repair", many, heavier)

# %% [markdown]
# A handful of light nodes at one short edge makes all others take shorter steps. That is why the meshes of this laboratory are even.
#
# ## 7 Doubt the data
#
# How stiff is skin? Kalra, Lowe and Al-Jumaily (2016) collected what others had measured, by pulling, pressing, sucking and twisting:
# Young's moduli from 5 kPa to 140 MPa. Pressing bends and squeezes soft layers; pulling stretches collagen fibres. One number for skin does
# not exist; this laboratory takes 100 kPa.
#
# ### Exercise: what does it cost?
#
# How many steps to a picture would the skin need, at least, at 5 kPa and at 140 MPa (`young=5e3` and `young=140e6`)? And how long may one
# step take at most, in microseconds, if a computer is to show 60 pictures a second at 140 MPa? The first cell measures what it takes on
# yours.

# %%
print(f"one step takes {1e6 * shaking.seconds_per_step(net):.0f} microseconds here")
# solution: soft_steps, stiff_steps, longest_us = ..., ..., ...
soft_steps, stiff_steps = (shaking.predicted(soft_skin(hand, young=young)) for young in (5e3, 140e6))
longest_us = 1e6 / 60 / stiff_steps
# end solution
check("doubt", soft_steps, stiff_steps, longest_us)

# %% [markdown]
# ## Summary
#
# - A spring pulls with $k(\ell-\ell_0)$ towards its other end; the leapfrog moves masses with velocities half a step behind.
# - A step must be shorter than $2/\omega$ of the **fastest** swing, in which neighbours move against each other. Damping does not help.
# - Twice the stiffness costs $\sqrt2$ times the steps; a net twice as fine twice the steps and eight times the work.
# - The number of steps comes from an eigenvalue, computed once for a hand, never from trial. It is right within 2 percent.
# - A single light node can set the step for all. And the stiffness of skin is known only to a factor of thousands.

# %%
check.summary()
