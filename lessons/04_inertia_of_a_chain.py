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
# # 04 · Inertia of a chain
#
# Hold a pencil at one end and wag it. Now hold it in the middle and wag again. Same pencil, same mass, and yet it turns much more
# easily: what counts is how far the mass is from the axis.
#
# After this lesson you can
#
# - compute the moment of inertia of a bone as a rod, as a cylinder, and exactly from its mesh;
# - say why a sum over the vertices of a mesh is no integral, and show it by experiment;
# - add up the moments of a chain of bones, and make a table of it as the paper does;
# - do without tables: turn inertia tensors, and carry them to another point;
# - say whether any of this changes the motion of a finger, because you have measured it.

# %%
import handlab as hl
import numpy as np
import time
from dataclasses import replace
from handlab.check import lesson
from handlab.physics import inertia, inertia_table, polyhedron
from handlab.show import chain_panel, inertia_plots, panels
from handlab.simulation import inertia_tables as tables
from handlab.simulation.kinematics import posed_axes

check = lesson("04")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# A torque turns a bone faster and faster: $T = J\,\dot\omega$. The **moment of inertia** $J$ says how much the bone resists, as mass does
# for a push. A finger is a chain: the joint at its root turns all of it, and a hooked finger resists less than a straight one, because
# its mass is nearer to the knuckle.

# %%
bends = {"straight": (0, 0), "hooked": (100, 60)}
states = {
    name: hl.pose(hand, {"mcp2.flexion_extension": 0, "pip2.flexion_extension": np.deg2rad(pip), "dip2.flexion_extension": np.deg2rad(dip)})
    for name, (pip, dip) in bends.items()
}
panels.Postures(hand, states, view="radial")

# %% [markdown]
# ## 2 One bone: rod and cylinder
#
# $$ J = \tfrac13\,m\,l^2 \qquad (5) $$
#
# | symbol | meaning | unit |
# |---|---|---|
# | $J$ | moment of inertia about an axis across the end of the bone | kg m² |
# | $m$ | mass of the bone and the tissue around it | kg |
# | $l$ | length | m |
# | $R$ | radius, which (5) does not have | m |
#
# The paper calls this a solid cylinder. It is a **thin rod**. A solid cylinder of radius $R$ has $\tfrac14 m R^2$ more, because its mass
# is also spread across its length.
#
# ### Exercise: the equation in your own lines


# %%
def own_rod(mass, length):
    # solution: return ...
    return mass * length**2 / 3
    # end solution


def own_cylinder(mass, length, radius):
    # solution: return ...
    return own_rod(mass, length) + mass * radius**2 / 4
    # end solution


check("bone", own_rod, own_cylinder)

# %% [markdown]
# ### Exercise: measure
#
# Here are the three phalanges of an index finger. By how many percent is the cylinder's moment larger than the rod's? Guess first for
# which bone the error of (5) is the largest.

# %%
mass = np.array([0.01192, 0.00556, 0.00304])  # kg: proximal, middle, distal phalanx
length = np.array([0.04259, 0.02514, 0.01798])  # m
radius = np.array([0.009, 0.008, 0.007])  # m
# solution: more_percent = ...
more_percent = 100 * (own_cylinder(mass, length, radius) / own_rod(mass, length) - 1)
# end solution
check("thickness", more_percent)

# %% [markdown]
# ## 3 One bone: its mesh
#
# A phalanx is neither rod nor cylinder. The paper takes the mesh of the bone: "the sum of the squared distances of the vertices to the
# rotation axis, multiplied by the mass of the bone". Below are three readings:
#
# | name | what it does |
# |---|---|
# | literal | $m \sum_k d_k^2$, word by word |
# | shared | $\tfrac mN \sum_k d_k^2$: each of the $N$ vertices carries an equal share of the mass |
# | exact | the integral over the inside. Each triangle spans a small pyramid with one point, and the pyramids add up |
#
# $d_k$ is the distance of vertex $k$ to the axis.

# %%
bone, kg = hand.bones["middle_phalanx_2"], hand.bodies["middle_phalanx_2"].mass
axis, anchor = (of[hand.dof_names.index("pip2.flexion_extension")] for of in posed_axes(hand, hand.bind))


def three_ways(points, faces):
    solid = polyhedron.mass_properties(points, faces, mass=kg)
    exact = axis @ solid.inertia @ axis + kg * np.sum(np.cross(solid.centre - anchor, axis) ** 2)
    return np.array([inertia.from_points(kg, points, axis, anchor, literal=True), inertia.from_points(kg, points, axis, anchor), exact])


# %% [markdown]
# ### Exercise: break it
#
# `polyhedron.refined(points, faces)` cuts every triangle into four flat ones. The bone keeps its shape to the last digit; only its
# description changes. Which of the three numbers should stay, which will not? Predict, then measure the factor new / old of each.

# %%
coarse = three_ways(bone.points, bone.faces)
print("literal, shared, exact (kg mm²):", np.round(1e6 * coarse, 3))
# solution: literal, shared, exact = ..., ..., ...
fine = three_ways(*polyhedron.refined(bone.points, bone.faces))
literal, shared, exact = fine / coarse
# end solution
check("vertices", literal, shared, exact)

# %% [markdown]
# ## 4 A chain
#
# The knuckle (MCP) turns three bones. Put three rods into a plane, the first along $x$. The PIP joint bends the second by $\alpha$, the
# DIP joint bends the third by $\beta$ more:
#
# $$ J = \sum_{i=1}^{3} \left( \tfrac1{12} m_i l_i^2 + m_i\,\lVert \mathbf c_i\rVert^2 \right) $$
#
# $\mathbf c_i$ is the middle of rod $i$, counted from the knuckle. The first part is the rod's own moment about its middle; the second
# comes from its distance: the **parallel axis theorem**. In the paper's words this is $J_1 + J_2^*[\alpha] + J_3^*[\alpha][\beta]$.
#
# ### Exercise: five lines
#
# A hint: a complex number `l * np.exp(1j * angle)` is an arrow of length `l` in the plane, and arrows add up.


# %%
def own_chain(mass, length, alpha, beta):
    # solution: return ...
    arrows = length * np.exp(1j * np.array([0, alpha, alpha + beta]))
    middles = np.cumsum(arrows) - arrows / 2
    return np.sum(mass * (length**2 / 12 + np.abs(middles) ** 2))
    # end solution


check("chain", own_chain)

# %% [markdown]
# ### Exercise: predict
#
# Before you touch the sliders: how many times is the moment of the straight index finger that of the hooked one (PIP 100, DIP 60
# degrees)? Write a number.

# %%
# solution: times = ...
times = 2
# end solution
check("hook", times)

# %%
panel = chain_panel.ChainPanel(hand)
panel

# %% [markdown]
# Without sliders: `panel.set(pip_deg=100, dip_deg=60)`. The black line comes from the present posture. The other two are read from a
# table: the steps are the paper's way.
#
# ## 5 A table
#
# In 2003 the paper computed $J$ once for all angles in steps of 5 degrees, and looked up the nearest entry while the hand moved. One
# can also draw a straight line between neighbouring entries (`np.interp`).
#
# ### Exercise: measure
#
# Below is a table for the PIP angle, with the DIP joint at 30 degrees. What is the largest error of each way of reading it, in
# percent of the true value? First predict: is the line twice as good, ten times, or a hundred times?

# %%
angles = np.deg2rad(np.arange(0, 111, 5))
table = inertia_table.three_levels(mass, length, angles, np.deg2rad(30))
fine_angles = np.linspace(0, angles[-1], 11001)
true = inertia_table.three_levels(mass, length, fine_angles, np.deg2rad(30))
# solution: nearest_percent, linear_percent = ..., ...
nearest = table[np.rint(fine_angles / angles[1]).astype(int)]
linear = np.interp(fine_angles, angles, table)
nearest_percent, linear_percent = (100 * np.abs(read / true - 1).max() for read in (nearest, linear))
# end solution
check("table", nearest_percent, linear_percent)

# %% [markdown]
# ## 6 No table at all: tensors
#
# A moment of inertia belongs to one axis. The **inertia tensor** $I$, three by three numbers, belongs to the body and knows every axis
# $\mathbf a$: $J = \mathbf a^{\mathsf T} I\, \mathbf a$. Two rules carry it anywhere:
#
# | rule | formula |
# |---|---|
# | turn the body by the rotation $R$ | $R\, I\, R^{\mathsf T}$ |
# | go $\mathbf d$ away from the centre of mass | $I + m\,(\lVert\mathbf d\rVert^2\,\mathbf 1 - \mathbf d\,\mathbf d^{\mathsf T})$ |
#
# Then tensors simply add up: any number of bones, any axis. The paper left this for later, as too slow.
#
# ### Exercise: in your own lines
#
# `centre` (3 bodies, 3) and `about` are where things are now; `tensors` (3, 3, 3) are written in each bone's own frame, and `rotation`
# (3, 3, 3) says how each bone is turned. `np.outer(d, d)` is $\mathbf d\,\mathbf d^{\mathsf T}$.


# %%
def own_tensor(mass, centre, tensors, rotation, about):
    # solution: return ...
    total = np.zeros((3, 3))
    for m, c, tensor, turn in zip(mass, centre, tensors, rotation, strict=True):
        d = c - about
        total += turn @ tensor @ turn.T + m * (d @ d * np.eye(3) - np.outer(d, d))
    return total
    # end solution


check("tensor", own_tensor)

# %% [markdown]
# ## 7 Doubt the tables
#
# Now tables for the whole hand, with at most three levels as in the paper, against the tensors, in random postures. Look at the rows
# where the two marks are together: there the steps of the table are not the trouble.

# %%
inertia_plots.inertia_table_errors(hand)

# %% [markdown]
# ### Exercise: what is missing?
#
# The table of `mcp2.flexion_extension` knows the angles of PIP and DIP, and is still off by several percent. Which third rotation
# changes this moment? Find its name. `moment(y)` gives the moment at the angles `y` (radians) of the 23 rotations in `hand.moving_names`.

# %%
relaxed = hand.relaxed[[hand.dof_names.index(name) for name in hand.moving_names]]
row = hand.moving_names.index("mcp2.flexion_extension")


def moment(y):
    return tables.tensor_inertia(hand, y)[row]


# solution: missing = ...
change = {name: moment(relaxed + 0.2 * unit) / moment(relaxed) - 1 for name, unit in zip(hand.moving_names, np.eye(23), strict=True)}
missing = min((name for name in change if name[:3] not in ("pip", "dip")), key=change.get)
# end solution
check("left_out", missing)

# %% [markdown]
# ## 8 The wrist
#
# The wrist carries everything, so its moment depends on all the other angles of the hand. The paper takes a constant.

# %%
inertia_plots.wrist_inertia(hand)

# %% [markdown]
# ### Exercise: measure
#
# By how many percent is the constant of the relaxed hand, `tables.wrist_constant(hand, "relaxed")`, too large in a fist, about the flexion
# axis? `tables.fist(hand)` gives the 23 angles of a fist. The first two rotations are the wrist's flexion and deviation.

# %%
# solution: too_large_percent = ...
in_fist = tables.tensor_inertia(hand, tables.fist(hand))[0]
too_large_percent = 100 * (tables.wrist_constant(hand, "relaxed")[0] / in_fist - 1)
# end solution
check("wrist", too_large_percent)

# %% [markdown]
# ## 9 Does it matter?
#
# ### Exercise: predict
#
# Let the hand wave, wrist free, the fastest of the clips. Once with tensors, once with the paper's tables, whose wrist you have just
# measured. By how many degrees will the two motions differ at most, in any joint at any time?

# %%
# solution: guessed_degrees = ...
guessed_degrees = 5
# end solution
check("guess", guessed_degrees)

# %% [markdown]
# ### Exercise: measure
#
# Then make the whole hand twice as heavy, and compare again. `largest(one, other)` gives the largest difference of two clips in degrees.


# %%
def wave(hand, source):
    return hl.simulate(hand, hl.keyframes("wave"), laws=hl.Laws(dynamics="decoupled", inertia=source))


def largest(one, other):
    return np.rad2deg(np.abs(one.angle - other.angle).max())


heavy = hand.with_(bodies={name: replace(body, mass=2 * body.mass, inertia=2 * body.inertia) for name, body in hand.bodies.items()})
# solution: by_table, by_mass = ..., ...
by_table = largest(wave(hand, "nearest table"), wave(hand, "tensor"))
by_mass = largest(wave(heavy, "tensor"), wave(hand, "tensor"))
# end solution
check("motion", by_table, by_mass)

# %% [markdown] tags=["solution"]
# *For the lecturer.* Most students expect several degrees, because the wrist is off by half. What they miss is friction. $J/\mu$ is the
# time in which friction stops a bone: about a thousandth of a second at a knuckle, a hundred times less at a fingertip, some ten times
# more at the wrist. Contractions change in tenths of a second. The bone is always near the speed at which friction balances the muscles,
# and that speed does not contain $J$ at all.

# %% [markdown]
# ### Exercise: make it matter
#
# `hand.with_(friction=hand.friction / 10)` is a better oiled hand. By what must its friction be divided so that the tables change the
# wave by about one degree? Try some numbers.


# %%
def by_tables(divisor):
    oiled = hand.with_(friction=hand.friction / divisor)
    return largest(wave(oiled, "nearest table"), wave(oiled, "tensor"))


# solution: divisor = ...
tried = np.array([5, 10, 20, 30, 40, 50, 70])
divisor = np.interp(1, [by_tables(one) for one in tried], tried)
# end solution
check("friction", divisor)

# %% [markdown]
# What does the exact way cost? The same motion with tables and with tensors. Then the default: `coupled`, where
# bones also pull on one another, which no table of scalars can say.

# %%
clips = {}
for name, laws in {"nearest table": {"inertia": "nearest table"}, "tensor": {}, "coupled": {"dynamics": "coupled"}}.items():
    begin = time.perf_counter()
    clips[name] = hl.simulate(hand, hl.keyframes("wave"), laws=hl.Laws(**{"dynamics": "decoupled", **laws}))
    print(f"{name:<14} {1000 * (time.perf_counter() - begin):6.1f} ms for {clips[name].time[-1]:.1f} s of motion,", end=" ")
    print(f"{largest(clips[name], clips['nearest table']):.3f} degrees from the tables")

# %% [markdown]
# ## Summary
#
# - $J$ counts mass times distance squared. (5) is a thin rod; thickness adds most to the shortest bones.
# - A sum over vertices counts vertices. The integral over a closed mesh is exact, and as short.
# - A chain: own moment plus mass times distance squared, in the present posture.
# - A table in steps of 5 degrees errs by percents; a straight line between its entries is many times better.
# - What a table leaves out costs more than its steps: sideways motion, the thumb, a fourth level, the whole hand at the wrist.
# - Tensors turn ($R I R^{\mathsf T}$), move (parallel axis theorem) and add up. No table is needed.
# - In a finger friction wins, and inertia hardly matters. Before you improve a number, ask what it changes.

# %%
check.summary()
