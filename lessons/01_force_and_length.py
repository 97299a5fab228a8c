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
# # 01 · How hard can a muscle pull?
#
# Make a fist, as hard as you can. Now flex your wrist as far as it goes, and try again. Where has your strength gone?
#
# After this lesson you can
#
# - compute the force of a muscle from its contraction and its fibre length;
# - say why a contraction is neither a force nor a shortening nor an angle;
# - find the muscles that have no force left in a fist, and say what the straight hand has to do with it;
# - add what the model leaves out: the speed of shortening, the delay of activation, the stretch of the tendon.
#
# Where you see `...`, an answer of yours is missing.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.show.panels import MusclePanel

check = lesson("01")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# A muscle fibre is a chain of tiny telescopes: filaments that slide into one another and pull where they overlap. Pulled far apart,
# they hardly overlap. Pushed far together, they are in each other's way. In between there is a length at which the fibre is strongest.
#
# Besides, a stretched fibre pulls back like a rubber band, without being told to. Every dot below is one of the 42 muscles in a fist.

# %%
fist = hl.simulate(hand, hl.keyframes("fist"))
hl.force_length(hand, fist.states[-1])

# %% [markdown]
# ## 2 The equation
#
# $$ F = c\,F_\text{contr}(\ell) + F_\text{stretch}(\ell) $$
#
# $$ F_\text{contr} = \Big[1 - 4\,(\ell/\ell_0 - 1.1)^2\Big] F_\text{max}, \qquad
# F_\text{stretch} = 2.77\,(\ell/\ell_0 - 1)^2\,F_\text{max} \;\;\text{if}\;\; \ell \ge \ell_0,\;\text{else}\; 0 $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $c$ | contraction, 0 slack to 1 as hard as it can | `clip.contraction` | 1 |
# | $\ell,\ \ell_0$ | fibre length, and its length at rest | `state.fibre_length`, `hand.rest_length` | m |
# | $F_\text{max}$ | maximum force | `hand.max_force` | N |
# | $F$ | force of the muscle | `clip.force` | N |
#
# The paper has forces only relative to one another. The newtons here rest on an assumption: 20 N for each percent of tension.
#
# ### Exercise: the equation in your own lines
#
# Give the force in parts of $F_\text{max}$. `ratio` is $\ell/\ell_0$. A muscle can pull but never push: keep the active part from
# going below 0.


# %%
def own_force(contraction, ratio):
    # solution: return ...
    active = max(0.0, 1 - 4 * (ratio - 1.1) ** 2)
    passive = 2.77 * (ratio - 1) ** 2 if ratio >= 1 else 0.0
    return contraction * active + passive
    # end solution


check("own_force", own_force)

# %% [markdown]
# ### Exercise: break it
#
# The paper prints the active curve without a guard. Take a muscle with $F_\text{max} = 50$ N at full contraction whose fibre is down to
# half its rest length. What force does the printed formula give, and what does yours? In newtons, with sign.

# %%
# solution: printed, guarded = ..., ...
printed = (1 - 4 * (0.5 - 1.1) ** 2) * 50
guarded = own_force(1, 0.5) * 50
# end solution
check("push", printed, guarded)

# %% [markdown]
# ## 3 Where is a muscle strongest?
#
# ### Exercise: predict, then look
#
# "The force of a muscle is greatest at its rest length", says the text of the paper. Guess: at which $\ell/\ell_0$ does the fully
# contracted muscle pull hardest, if you count its passive part as well?

# %%
# solution: my_guess = ...
my_guess = 1.0
# end solution
check("guess_peak", my_guess)

# %% [markdown]
# Now look between 0.6 and 1.6: once for the active part alone, once for the whole force. `np.argmax` gives the place of the largest
# value in an array.

# %%
ratios = np.linspace(0.6, 1.6, 1001)
# solution: active_peak, total_peak = ..., ...
active_peak = ratios[np.argmax(1 - 4 * (ratios - 1.1) ** 2)]
total_peak = ratios[np.argmax([own_force(1, ratio) for ratio in ratios])]
# end solution
check("peak", active_peak, total_peak)

# %% [markdown]
# ## 4 Contraction is not force
#
# A question before you touch a slider: the deep flexor of the index finger (`FDP2`) contracts with 0.1, then with 0.2. What becomes
# twice as large: its force? The shortening of its fibre? The angle of the joint? All of them, or none?

# %%
panel = MusclePanel(hand, ["FDP2", "EDC2"], hold=["wrist"])
panel

# %% [markdown]
# The same by program, with plots of contraction, fibre lengths and joint angles over time:

# %%
panel.reset()
for contraction in (0.1, 0.2, 0.4):
    panel.set(FDP2=contraction)
hl.curves(panel.clip, muscles=["FDP2", "EDC2"], joints=["mcp2", "pip2"])

# %% [markdown]
# ### Exercise: measure
#
# Measure three factors, 0.2 against 0.1 (strong divided by weak), at the end of two seconds:
#
# - `held`: force of `FDP2` while an examiner holds the wrist and the finger, `hold=["wrist", "mcp2", "pip2", "dip2"]`;
# - `free`: its force while only the wrist is held;
# - `angle`: how far `mcp2` has turned meanwhile, with only the wrist held.

# %%
row = hand.muscle_names.index(hand.muscles["FDP2"].name)
mcp2 = hand.dof_names.index("mcp2.flexion_extension")
# solution: held, free, angle = ..., ..., ...
clips = {}
for contraction in (0.1, 0.2):
    for hold in (("wrist", "mcp2", "pip2", "dip2"), ("wrist",)):
        clips[contraction, len(hold)] = hl.simulate(hand, {"FDP2": contraction}, seconds=2, hold=hold)
held = clips[0.2, 4].force[-1, row] / clips[0.1, 4].force[-1, row]
free = clips[0.2, 1].force[-1, row] / clips[0.1, 1].force[-1, row]
angle = np.ptp(clips[0.2, 1].angle[[0, -1], mcp2]) / np.ptp(clips[0.1, 1].angle[[0, -1], mcp2])
# end solution
check("twice", held, free, angle)

# %% [markdown] tags=["solution"]
# *For the lecturer.* The free finger moves until the torques balance again. On the way the fibre gets shorter, which costs it force:
# the muscle gives up by itself. Ask for 0.4 as well: four times the contraction, about twice the force.

# %% [markdown]
# ## 5 In which posture are fibres at rest?
#
# The paper starts with the straight hand and gives every fibre its rest length there. It sounds harmless. Here is the same fist once
# more, as the paper would have it, beside the flat hand:

# %%
flat_rest = hand.with_fibre_rest("flat")
angles = {name: float(value) for name, value in zip(hand.dof_names, fist.angle[-1], strict=True) if name in hand.moving_names}
flat_hand = hl.pose(flat_rest, dict.fromkeys(hand.moving_names, 0.0))
hl.force_length(flat_rest, {"flat hand: all at rest": flat_hand, "fist": hl.pose(flat_rest, angles)})

# %% [markdown]
# In a living hand the rest length lies near the posture in which the hand hangs by itself, fingers half flexed. `load_hand()` has it so.
#
# ### Exercise: who has gone slack?
#
# Take a fist with a straight wrist: `closed` below. Name the muscles whose fibres are at 0.6 of their rest length or below, once with
# fibres at rest in the flat hand, once in the relaxed hand. Give two sets of abbreviations; an empty one is `set()`.

# %%
closed = {"wrist.flexion_extension": 0.0}
for finger in range(2, 6):
    for joint, degrees in (("mcp", 75), ("pip", 95), ("dip", 45)):
        closed[f"{joint}{finger}.flexion_extension"] = np.deg2rad(degrees)


def too_short(one_hand):
    # solution: return ...
    ratio = hl.pose(one_hand, closed).fibre_length / one_hand.rest_length
    return {muscle.abbreviation for muscle, value in zip(hand.muscles.values(), ratio, strict=True) if value <= 0.6}
    # end solution


check("closed", too_short(flat_rest), too_short(hand))

# %% [markdown]
# And now your own fist from the beginning of this lesson: the force of the long finger flexors against the angle of the wrist.

# %%
hl.wrist_plot({"fibres at rest in the relaxed hand": hand, "fibres at rest in the flat hand": flat_rest})

# %% [markdown]
# ### Exercise: doubt the data
#
# "The range 0.6 to 1.6 is usually never left, because the joints are limited", says the paper. Is it so, with fibres at rest in the
# flat hand?
#
# Let every joint go to that limit to which the muscle pulls. How short does the wrist flexor `FCR` get (in parts of its rest length)?
# And how many of the 42 muscles can fall below 0.6?
#
# A rotation with lever arm $r$ shortens the fibre by $r\varphi$. `hand.lever_arm @ hand.coupling` has the arms at the 23 rotations that
# move by themselves; `limits` has their ends.

# %%
arms = flat_rest.lever_arm @ flat_rest.coupling
limits = np.array([flat_rest.dofs[name].limits for name in flat_rest.moving_names])
# solution: shortest_fcr, count = ..., ...
most = np.maximum(arms * limits[:, 0], arms * limits[:, 1]).sum(axis=1)
shortest = 1 - most / flat_rest.rest_length
shortest_fcr = shortest[hand.muscle_names.index(hand.muscles["FCR"].name)]
count = np.sum(shortest < 0.6)
# end solution
check("doubt", shortest_fcr, count)

# %% [markdown]
# ## 6 What the model leaves out
#
# Three things that every muscle does, and none of the paper's. You will add them.
#
# **Speed.** A fibre that shortens fast pulls less: the filaments have no time to grip. A common curve, with $v$ in rest lengths a second,
# $v_\text{max} = 10$ and $k = 0.25$ (typical figures, after Hill 1938 and Zajac 1989):
#
# $$ \text{factor} = \frac{1 - v/v_\text{max}}{1 + v/(k\,v_\text{max})} $$
#
# ### Exercise: extend
#
# Write the factor. Then find the largest speed, in rest lengths a second, at which `FDP2` shortens from one frame to the next in the
# clip `fist` above. `np.diff` gives differences of neighbours; shortening counts as positive.


# %%
def speed_factor(v):
    # solution: return ...
    share = v / 10
    return (1 - share) / (1 + share / 0.25)
    # end solution


# solution: fastest = ...
shortening = -np.diff(fist.fibre_length[:, row]) / np.diff(fist.time)
fastest = shortening.max() / hand.rest_length[row]
# end solution
check("speed", speed_factor, fastest)

# %% [markdown]
# **Tendon.** At the maximum force of its muscle a tendon is about 3.3 % longer than when slack (Zajac 1989). The fibre has to take up
# that much before anything moves.
#
# ### Exercise: measure on yourself
#
# The belly of the deep flexor ends about in the middle of your forearm. Measure from there to the last joint of your index finger,
# in millimetres. By how much does this tendon stretch at full force, in parts of the rest length of `FDP2`?

# %%
# solution: tendon_mm, loss = ..., ...
tendon_mm = 270
loss = 0.033 * tendon_mm / (1000 * hand.muscles["FDP2"].rest_length)
# end solution
check("tendon", tendon_mm, loss)

# %% [markdown]
# **Delay.** A nerve commands, and the muscle follows: its activation $a$ runs after the command $c$ with $\dot a = (c - a)/\tau$. Take
# $\tau = 40$ ms, an assumption that lies between the rise and the decay of real muscles.
#
# ### Exercise: extend
#
# Begin with $a = 0$. For every command keep the present $a$, then let it move on by $\Delta t\,(c - a)/\tau$. Return all the values.


# %%
def activation(command, dt, tau):
    # solution: return ...
    a, values = 0.0, []
    for c in command:
        values.append(a)
        a = a + dt * (c - a) / tau
    return np.array(values)
    # end solution


check("delay", activation)

# %% [markdown]
# What it does to a finger that closes and opens: the command as it is, and as the muscle feels it.

# %%
time = np.arange(0, 1.2, 0.002)
command = np.where((time > 0.1) & (time < 0.6), 0.3, 0.0)
late = activation(command, 0.002, 0.04)
figure, axes = plt.subplots(figsize=(14, 7), layout="constrained")
for label, look, c in (("command", "#0072B2", command), ("with delay", "#D55E00", late)):
    if c is not ...:
        clip = hl.simulate(hand, {"FDP2": list(zip(time, c, strict=True))}, seconds=1.19, hold=["wrist"])
        axes.plot(clip.time, np.rad2deg(clip.angle[:, mcp2]), "-" if c is command else "--", color=look, label=label, linewidth=4)
axes.set_xlabel("time (s)", fontsize=20), axes.set_ylabel("mcp2 flexion (degrees)", fontsize=20)
axes.tick_params(labelsize=17), axes.legend(fontsize=18), plt.close(figure)
figure

# %% [markdown]
# ## Summary
#
# - $F = c\,F_\text{contr} + F_\text{stretch}$: the contraction scales the active part, between 0.6 and 1.6 of the rest length.
# - The fitted curve is strongest beyond the rest length, not at it.
# - Contraction is not force, not shortening, not angle: these come out, together with everything else that pulls.
# - The posture of rest length decides who can still pull in a fist. In the straight hand it is a choice that costs the deep flexors.
# - A flexed wrist takes the grip's strength: *active insufficiency*.
# - Left out: the speed of shortening, the stretch of tendons, the delay of activation.

# %%
check.summary()
