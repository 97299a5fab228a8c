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
# # 05 · A finger with antagonists
#
# Make the beak of a duck: knuckles bent, fingers straight. Now make a claw: knuckles straight, fingers bent. The same three joints,
# each time in opposite directions. Feel at your palm and at your forearm: where does it get hard?
#
# After this lesson you can
#
# - find the posture in which a finger comes to rest, and say what holds it there;
# - explain why the extensor of the fingers does not open the finger, and who does;
# - compute how stiff a joint is, and what contracting both sides does to it;
# - find a posture that is a balance and yet does not last, and a hand with two rests;
# - say what a table of constant lever arms cannot do.

# %%
import handlab as hl
import matplotlib.pyplot as plt
import numpy as np
from handlab.check import lesson
from handlab.show.figures import STYLE, line
from scipy.optimize import nnls

plt.rcParams.update(STYLE)
check = lesson("05")
hand = hl.load_hand()

# %% [markdown]
# ## 1 The idea
#
# A muscle only pulls. What bends a finger cannot straighten it, so every joint needs at least two muscles, one against the other:
# antagonists. A finger comes to rest where all that pulls at it adds up to nothing, at each of its joints at once.
#
# In the picture small muscles of the palm contract, and they alone. Nobody told an extensor to do anything. Who opens the fingers?

# %%
small = ["DI2", "DI3", "DI4", "PI1", "PI2", "PI3"]
hl.view(hand, hl.simulate(hand, {name: [(0, 0), (1, 0.3), (2, 0.3)] for name in small}, hold=["wrist"]))

# %% [markdown]
# ## 2 The equation
#
# $$ \ell_i = \ell_{0i} - \sum_k R_{ik}\,(\varphi_k - \bar\varphi_k) \qquad
# T_k = \sum_i R_{ik}\,F_i(\ell_i) - \kappa_k\,(\varphi_k - \bar\varphi_k) \qquad \text{at rest:}\;\; T_k = 0 $$
#
# | symbol | meaning | in code | unit |
# |---|---|---|---|
# | $\varphi_k$ | angle of joint $k$ | `angle` | rad |
# | $\bar\varphi_k$ | its angle in the relaxed hand, where fibres and joints are at rest | `relaxed` | rad |
# | $R_{ik}$ | lever arm of muscle $i$ at joint $k$, flexion positive | `R` | m |
# | $\ell_i,\ \ell_{0i}$ | fibre length, and at rest | `l0` | m |
# | $F_i$ | force, as in lesson 01: active between 0.6 and 1.6 of $\ell_0$, passive beyond 1 | `Fmax` | N |
# | $\kappa_k$ | stiffness of the joint itself | `kappa` | N m/rad |
#
# ### Exercise: the equation in your own lines
#
# For MCP, PIP and DIP of the middle finger. `contraction` has six values, in the order of `muscles`; the wrist stays where it is.

# %%
muscles = ["FDP3", "FDS3", "EDC3", "LUM2", "DI2", "DI3"]
rows = [hand.muscle_names.index(hand.muscles[name].name) for name in muscles]
joints = [hand.dof_names.index(f"{joint}3.flexion_extension") for joint in ("mcp", "pip", "dip")]
R, l0, Fmax = hand.lever_arm[np.ix_(rows, joints)], hand.rest_length[rows], hand.max_force[rows]
relaxed, kappa = hand.relaxed[joints], hand.stiffness[joints]
print(f"{'':6}   MCP    PIP    DIP  (mm)")
for name, arms in zip(muscles, 1000 * R, strict=True):
    print(f"{name:<6}" + "".join(f"{arm:+7.1f}" for arm in arms))


# %%
def own_torque(angle, contraction):
    # solution: return ...
    ratio = 1 - R @ (angle - relaxed) / l0
    active = np.maximum(0, 1 - 4 * (ratio - 1.1) ** 2)
    passive = 2.77 * np.maximum(0, ratio - 1) ** 2
    return R.T @ (Fmax * (contraction * active + passive)) - kappa * (angle - relaxed)
    # end solution


check("torque", own_torque)

# %% [markdown]
# ## 3 One muscle alone
#
# `hl.settle` finds where the hand comes to rest. Every joint has a say in it: also those that the muscle does not pass.
#
# ### Exercise: predict, then measure
#
# Each of these muscles contracts alone with 0.3, wrist held. Does it flex (`"+"`) or extend (`"-"`) MCP, PIP and DIP, compared with
# the relaxed hand? Guess from the lever arms above, before you run the cell after this one.

# %%
# solution: guess = {"FDP3": ..., "FDS3": ..., "EDC3": ..., "LUM2": ..., "DI2": ...}
guess = {"FDP3": "+++", "FDS3": "++0", "EDC3": "---", "LUM2": "+--", "DI2": "+--"}
# end solution
check("guess", guess)


# %%
def flexions(contraction, hold=("wrist",)):
    return np.rad2deg(hl.settle(hand, contraction, hold=hold, look_for_others=False).state.angle[joints])


# solution: alone = {"FDP3": ..., "FDS3": ..., "EDC3": ..., "LUM2": ..., "DI2": ...}
changes = {name: flexions({name: 0.3}) - np.rad2deg(relaxed) for name in guess}
alone = {name: "".join("+" if by > 0 else "-" for by in change) for name, change in changes.items()}
# end solution
check("alone", alone)

# %%
values = np.linspace(0, 1, 9)
figure, axes = plt.subplots(1, 3, figsize=(19, 7), sharey=True)
titles = {"deep flexor (FDP3)": ["FDP3"], "extensor (EDC3)": ["EDC3"], "interossei (DI2, DI3)": ["DI2", "DI3"]}
for panel, (title, names) in zip(axes, titles.items(), strict=True):
    ends = np.array([flexions(dict.fromkeys(names, value)) for value in values])
    for k, joint in enumerate(("MCP", "PIP", "DIP")):
        panel.plot(values, ends[:, k], label=joint, marker="os^"[k], **line(k))
    panel.set(title=title, xlabel="contraction"), panel.axhline(0, color="0.45", linewidth=1.5)
axes[0].set_ylabel("flexion at rest (degrees)"), axes[2].legend(), plt.close(figure)
figure

# %% [markdown]
# ## 4 The extensor that does not extend
#
# The extensor has a lever arm at the PIP. And yet, as hard as it pulls, the PIP stays bent.
#
# ### Exercise: measure
#
# `EDC3` at full contraction. At which angle does the PIP come to rest, in degrees? And at which one if an examiner holds the knuckle
# as well, `hold=["wrist", "mcp3"]`? (Hand surgeons do just this: Bouvier's test.)

# %%
# solution: knuckle_free, knuckle_held = ..., ...
knuckle_free = flexions({"EDC3": 1})[1]
knuckle_held = flexions({"EDC3": 1}, hold=["wrist", "mcp3"])[1]
# end solution
check("bouvier", knuckle_free, knuckle_held)

# %% [markdown]
# ### Exercise: who holds it?
#
# Somebody bends the PIP while the knuckle is extended. Name the two muscles, and the torque of both together at the PIP in N m.
# Solid bars are active, hatched ones passive.

# %%
extended = hl.simulate(hand, {"EDC3": 1.0}, seconds=4, hold=["wrist"])
# solution: holders, torque = ..., ...
torques = R[:, 1] * extended.force[-1, rows]
holders = {name for name, value in zip(muscles, torques, strict=True) if value > 0.01}
torque = torques[torques > 0.01].sum()
# end solution
check("who", holders, torque)
hl.torque_balance(extended, "pip3")

# %% [markdown]
# ## 5 Opening the finger
#
# ### Exercise: without its extensor
#
# `EDC3` keeps silent. Open PIP and DIP to less than 5 degrees each, with muscles of the middle finger. Hand over your contractions,
# and what it costs: the flexion of the MCP, in degrees.

# %%
# solution: opening, mcp_deg = {"DI2": ...}, ...
opening = {"DI2": 0.4, "DI3": 0.4}
mcp_deg = flexions(opening)[0]
# end solution
check("open", opening, mcp_deg)

# %% [markdown]
# ### Exercise: straight
#
# **A question first.** The extensor opens the knuckle and leaves the rest bent; the interossei do the opposite. Which of the two has to
# work harder if the whole finger is to be straight? Say it, then move the sliders.
#
# All three joints within 5 degrees of straight, and the finger no more than 6 degrees to one side.

# %%
panel = hl.MusclePanel(hand, muscles, hold=["wrist"], seconds=2)
panel

# %%
# solution: straight = ...
panel.set(EDC3=1.0)
panel.set(DI2=0.29, DI3=0.32)
straight = panel.contraction
# end solution
check("straight", straight)

# %% [markdown]
# What happens on the way, with fibre lengths. First only the extensor, then the interossei join in with 0.1. Put your own values in.

# %%
panel.reset()
for more in ({"EDC3": 1.0}, {"DI2": 0.1, "DI3": 0.1}):
    panel.set(**more)
hl.curves(panel.clip, muscles=["FDP3", "FDS3", "EDC3", "DI2"], joints=["mcp3.flexion_extension", "pip3", "dip3"])

# %% [markdown]
# ## 6 Nobody pulls
#
# Let your hand hang and look at it from the side. From index to little finger each is a little more bent than its neighbour: the
# **cascade**. In this hand it is no result: fibres and joints are *given* their rest there. The paper gives fibres their rest length
# in the straight hand instead. The joints of this laboratory still pull to the relaxed posture.
#
# ### Exercise: measure
#
# No muscle contracts; the wrist is held where it is in the relaxed hand. By how many degrees is the middle finger straighter with the
# paper's choice (MCP, PIP and DIP together)? And which muscle of this finger pulls hardest there?

# %%
flat = hand.with_fibre_rest("flat")
at_rest = hl.settle(flat, {}, start=hl.rest(hand), hold=["wrist"], look_for_others=False).state
# solution: straighter_deg, puller = ..., ...
straighter_deg = np.rad2deg(relaxed - at_rest.angle[joints]).sum()
stretch = at_rest.fibre_length[rows] / flat.rest_length[rows] - 1
puller = muscles[np.argmax(np.maximum(0, stretch) ** 2 * Fmax)]
# end solution
check("cascade", straighter_deg, puller)

# %% [markdown]
# ## 7 Stiffness
#
# Hold your finger loosely and let someone tap it. Now tense all its muscles at once, without moving. What has changed is its
# **stiffness**: the torque that a small turn takes, $k = -\,\mathrm dT/\mathrm d\varphi$. With $\lambda = \ell/\ell_0$ and the
# other joints held:
#
# $$ k = \kappa + \sum_i \frac{R_i^2}{\ell_{0i}}\,F^{max}_i\,\big(c_i\,f_a'(\lambda_i) + f_p'(\lambda_i)\big) $$
#
# $f_a$ and $f_p$ are the curves of lesson 01, active and passive; a prime is their slope. Outside 0.6 to 1.6 the active slope is 0.
#
# ### Exercise: in your own lines
#
# Return the stiffness (N m/rad) of MCP, PIP and DIP, three values. `angle` and `contraction` as in `own_torque`.


# %%
def own_stiffness(angle, contraction):
    ratio = 1 - R @ (angle - relaxed) / l0
    # solution: return ...
    active = np.where(np.abs(ratio - 1.1) < 0.5, -8 * (ratio - 1.1), 0)
    passive = 5.54 * np.maximum(0, ratio - 1)
    return kappa + (R**2).T @ (Fmax / l0 * (contraction * active + passive))
    # end solution


check("stiffness", own_stiffness)

# %% [markdown]
# ### Exercise: predict, then measure
#
# An examiner holds the finger, and all six muscles contract fully. Does the knuckle get `"stiffer"` or `"softer"` in the relaxed
# finger, and in the straight one? Guess. Then measure by how much, in N m/rad: contraction 1 minus contraction 0, MCP.

# %%
# solution: guess_relaxed, guess_straight = ..., ...
guess_relaxed, guess_straight = "stiffer", "stiffer"
# end solution
check("guess_stiff", guess_relaxed, guess_straight)

# %%
# solution: added_relaxed, added_straight = ..., ...
added_relaxed, added_straight = (
    (own_stiffness(angle, np.ones(6)) - own_stiffness(angle, np.zeros(6)))[0] for angle in (relaxed, np.zeros(3))
)
# end solution
check("stiffen", added_relaxed, added_straight)

# %%
shares = np.linspace(-0.3, 1.5, 46)  # 0: straight finger, 1: relaxed
answered = own_stiffness(relaxed, np.ones(6)) is not ...
figure, axes = plt.subplots(figsize=(14, 7))
for k, much in enumerate((0.0, 0.5, 1.0) if answered else ()):
    curve = [own_stiffness(share * relaxed, np.full(6, much))[0] for share in shares]
    axes.plot(np.rad2deg(shares * relaxed[0]), curve, label=f"all muscles at {much:g}", **line(k))
    axes.legend(fontsize=17)
axes.axvline(0, color="0.45", linewidth=1.5), axes.axvline(np.rad2deg(relaxed[0]), color="0.45", linewidth=1.5, linestyle=":")
axes.set(xlabel="MCP flexion (degrees), PIP and DIP in proportion", ylabel="stiffness of MCP (N m/rad)")
axes.set_title("Straight finger: solid grey line. Relaxed finger: dotted."), plt.close(figure)
figure

# %% [markdown]
# ### Exercise: whose fault is it?
#
# Which of the six make the straight knuckle softer when they contract? Give a set of abbreviations.

# %%
# solution: culprits = ...
each = [own_stiffness(np.zeros(3), one)[0] - own_stiffness(np.zeros(3), np.zeros(6))[0] for one in np.eye(6)]
culprits = {name for name, added in zip(muscles, each, strict=True) if added < 0}
# end solution
check("culprits", culprits)

# %% [markdown]
# Try it with your own straight finger: it does *not* get softer. The curve was fitted to muscles that hold still at one length after
# another. A contracting muscle that is stretched a little, and fast, resists much more than this (short-range stiffness: Rack and
# Westbury 1974). The model knows nothing of it.
#
# ## 8 Doubt the data: three joints, one tendon
#
# A living finger can be tensed in the relaxed posture without moving. Can this one?
#
# ### Exercise: two muscles
#
# `FDP3` pulls with 10 N. With how many newtons would `EDC3` have to pull, so that their torques cancel at the MCP? At the PIP? At the
# DIP? Three numbers. (Then think: a tendon has one force. Extend the knuckle, bend the PIP: which shape of the finger is that?)

# %%
# solution: newtons = ...
newtons = -10 * R[0] / R[2]
# end solution
check("newtons", newtons)

# %% [markdown]
# ### Exercise: all six
#
# `EDC3` pulls with 1 N. The other five may pull as they like, but never push: `nnls(A, b)` gives the forces $x \ge 0$ that bring
# $A\,x$ nearest to $b$, and what is left (the length of $A\,x - b$). How much torque is left, in mN m? Which muscles joined in?

# %%
others = [0, 1, 3, 4, 5]  # rows of R without EDC3
# solution: left_mnm, helpers = ..., ...
forces, left = nnls(R[others].T, -R[2])
left_mnm = 1000 * left
helpers = {muscles[k] for k, force in zip(others, forces, strict=True) if force > 0}
# end solution
check("doubt", left_mnm, helpers)

# %% [markdown]
# ## 9 Break it: a hand with two rests
#
# Hold your forearm upright, fingers to the ceiling. Imagine that nothing holds your wrist but muscles at rest, and let the hand tip
# over. `loose` has no stiffness in its joints; gravity points to the forearm; only the wrist can move.
#
# ### Exercise: measure
#
# Where does the wrist come to rest if it begins at -40 degrees, and where if it begins at +20? Compare with `hand`, whose joints resist.

# %%
loose = hand.without_passive()
hold = [name for name in hand.moving_names if name != "wrist.flexion_extension"]


def end(one_hand, begin_deg):
    start = hl.pose(one_hand, {"wrist.flexion_extension": np.deg2rad(begin_deg)})
    return hl.settle(one_hand, {}, start, hold=hold, gravity=(-9.81, 0, 0))


# solution: from_extension, from_flexion = ..., ...
from_extension, from_flexion = (np.rad2deg(end(loose, begin).state.angle[0]) for begin in (-40, 20))
# end solution
check("two", from_extension, from_flexion)
print(f"rests besides the one that is found: {len(end(loose, 20).others)} of the loose hand, {len(end(hand, 20).others)} of the hand")

# %% [markdown]
# ## Summary
#
# - A finger rests where torques cancel at all its joints. `hl.settle` finds it, says whether it lasts (`.stable`) and what else it found.
# - The extensor alone makes a claw: the knuckle gives way and stretches the flexors, which bend the PIP. Interossei make the duck's
#   beak. A straight finger takes both.
# - Contracting both sides stiffens a relaxed finger. In the straight one the fitted curve says the opposite; your finger does not.
# - Three joints, six muscles, constant lever arms: not everything that a living finger does can be balanced.
# - A balance need not last, and there may be more than one.

# %%
check.summary()
