"""Moments of inertia of this hand in tables, as in section 4.1.2, and how far they are off.

The paper computes J of a chain of bones once for all angles in steps of five degrees and looks it up while the hand moves: three
levels at most, the wrist constant. What a table leaves out stands at the relaxed posture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.anatomy.terms import find
from handlab.physics.inertia import composite_tensor
from handlab.simulation.inertia_kernel import look_up
from handlab.simulation.kinematics import transforms, tree
from handlab.simulation.mechanics import coupled, mechanics, moments_of_inertia
from handlab.simulation.per_hand import per_hand

STEP = np.deg2rad(5.0)  # the paper's
# Tables go this far beyond the limits of a joint: soft stops give way by up to so much.
MARGIN = np.deg2rad(2.0)

# Moments of inertia (flexion, deviation) of a whole hand about the wrist, kg m^2: masses, centres of mass and radii of gyration
# of de Leva 1996 with a hand of 160 mm and 0.347 kg, and of 174 mm and 0.445 kg.
DE_LEVA = {"de leva female": (1.427e-3, 1.572e-3), "de leva male": (2.515e-3, 2.888e-3)}
# A plain fist with the thumb across the fingers, degrees (an assumption: finger angles of an unloaded fist, thumb by eye).
FIST_DEG = {"mcp": 90.0, "pip": 100.0, "dip": 67.0, "cmc1.flexion": 25.0, "cmc1.abduction": 30.0, "mcp1": 40.0, "ip1": 50.0}


class InertiaTables(NamedTuple):
    """Tables of all moving coordinates k, one after the other in ``values``; every field can go into a compiled function.

    J_k depends on y[inner[k]] and y[outer[k]], or on fewer where these are -1. Table k has ``entries[k]`` rows and columns; its entry
    (i, j) is ``values[start[k] + i * entries[k, 1] + j]`` and stands at the angles ``low[k] + step * (i, j)``; radians, kg m^2.
    """

    inner: Index
    outer: Index
    low: Array
    entries: Index
    start: Index
    step: float
    values: Array


def inertia_tables(hand: Hand, *, step: float = STEP, wrist: str = "relaxed") -> InertiaTables:
    """Tables of J_k = sum over d of C_dk^2 J_d in steps of ``step`` radians, computed once per hand.

    An MCP joint depends on its PIP and DIP joints, a PIP joint on its DIP joint, the CMC joints of thumb and little finger on
    the two joints that follow: three levels at most, so the last joint of the little finger is left out of CMC 5. The last
    joint of every digit is constant, and so is the wrist: ``wrist`` names the constant (see ``wrist_constant``).
    """
    step = float(step)
    if not 0.0 < step <= np.pi / 4:
        raise ValueError(f"step is {step:g} rad; give an angle between 0 and 45 degrees in radians, such as np.deg2rad(5)")
    kept = _kept(hand)
    if (step, wrist) not in kept:
        kept[step, wrist] = _filled(hand, step, wrist)
    return kept[step, wrist]


@per_hand
def _kept(hand: Hand) -> dict[tuple[float, str], InertiaTables]:
    """Tables of one hand by step and name of the wrist's constant."""
    return {}


def levels(hand: Hand) -> tuple[Index, Index]:
    """Columns (k,) of the moving coordinates on which J_k is made to depend: the first rotations of the next two joints, or -1."""
    column = {name: k for k, name in enumerate(hand.moving_names)}

    def following(joint: str | None) -> str | None:
        """The one joint that hangs on what ``joint`` moves; none after the wrist, where the hand branches."""
        moved = [body.name for body in hand.bodies.values() if body.joint == joint]
        after = [body.joint for body in hand.bodies.values() if body.parent in moved]
        return after[0] if joint is not None and len(after) == 1 else None

    def first(joint: str | None) -> int:
        moving = [] if joint is None else [column[dof.name] for dof in hand.joints[joint].dofs if dof.name in column]
        return moving[0] if moving else -1

    joints = [hand.dofs[name].joint for name in hand.moving_names]
    inner = [first(following(joint)) for joint in joints]
    outer = [first(following(following(joint))) for joint in joints]
    return frozen(inner, np.int64), frozen(outer, np.int64)


def _filled(hand: Hand, step: float, wrist: str) -> InertiaTables:
    m = mechanics(hand)
    inner, outer = levels(hand)
    low, entries = np.zeros((len(inner), 2)), np.ones((len(inner), 2), dtype=np.int64)
    for k, pair in enumerate(zip(inner, outer, strict=True)):
        for side, other in enumerate(pair):
            if other >= 0:
                first = np.floor((m.limits[other, 0] - MARGIN) / step + 1e-9)
                low[k, side] = step * first
                entries[k, side] = np.ceil((m.limits[other, 1] + MARGIN) / step - 1e-9) - first + 1
    blocks: dict[tuple[int, int], Array] = {}
    values: list[Array] = []
    for k, pair in enumerate(zip(inner.tolist(), outer.tolist(), strict=True)):
        if pair not in blocks:  # rotations of one joint depend on the same angles
            blocks[pair] = _block(hand, pair, [low[k, side] + step * np.arange(entries[k, side]) for side in (0, 1)])
        values.append(blocks[pair][:, k])
    for k, constant in zip(_wrist(hand), wrist_constant(hand, wrist), strict=True):
        values[k] = np.array([constant])
    start = np.concatenate([[0], np.cumsum([len(block) for block in values])[:-1]])
    return InertiaTables(
        inner=inner,
        outer=outer,
        low=frozen(low),
        entries=frozen(entries, np.int64),
        start=frozen(start, np.int64),
        step=step,
        values=frozen(np.concatenate(values)),
    )


def _block(hand: Hand, pair: tuple[int, int], grids: list[Array]) -> Array:
    """J (entry, moving) over the grid of two coordinates (-1: none), all others relaxed."""
    y = np.array(mechanics(hand).relaxed)
    rows = []
    for inner in grids[0]:
        for outer in grids[1]:
            if pair[0] >= 0:
                y[pair[0]] = inner
            if pair[1] >= 0:
                y[pair[1]] = outer
            rows.append(tensor_inertia(hand, y))
    return np.array(rows)


def tensor_inertia(hand: Hand, y: ArrayLike) -> Array:
    """J_k (moving,) from the pose by composite inertia tensors: what the tables approximate. C_dk^2 J_d, kg m^2."""
    result: Array = moments_of_inertia(hand, coupled(hand, y)) @ hand.coupling**2
    return result


def carried_tensor(hand: Hand, dof: str, angle: ArrayLike) -> Array:
    """Inertia tensor (3, 3) about the anchor of ``dof`` of all that it carries, at ``angle`` (dof,), kg m^2.

    For any axis a through the anchor J = a' I a: four levels from the CMC joint of the little finger, the whole hand from the wrist.
    """
    joint = hand.dofs[dof].joint
    carried: list[str] = []
    for name, body in hand.bodies.items():  # parents come first
        if body.joint == joint or body.parent in carried:
            carried.append(name)
    rows = [hand.body_names.index(name) for name in carried]
    m = mechanics(hand)
    transform, _, anchor = transforms(tree(hand), angle)
    turn, shift = transform[rows, :3, :3], transform[rows, :3, 3]
    centre = np.einsum("bij,bj->bi", turn, m.centre[rows]) + shift
    return composite_tensor(m.mass[rows], centre, m.inertia[rows], anchor[hand.dof_names.index(hand.dofs[dof].name)], rotation=turn)


def from_tables(hand: Hand, y: ArrayLike, *, nearest: bool = False, tables: InertiaTables | None = None) -> Array:
    """J_k (moving,) looked up at moving coordinates ``y`` (moving,), kg m^2; linear between entries unless ``nearest``."""
    y = np.array(y, dtype=np.float64)
    if y.shape != (len(hand.moving_names),):
        raise ValueError(f"y has shape {y.shape}; give one angle in radians for each of the {len(hand.moving_names)} moving coordinates")
    out = np.empty(len(y))
    look_up(inertia_tables(hand) if tables is None else tables, y, nearest, out)
    return out


def table_errors(hand: Hand, *, samples: int = 1000, seed: int = 0, nearest: bool = False, tables: InertiaTables | None = None) -> Array:
    """Relative errors (samples, moving) of the tables against the tensors, in random postures within the limits."""
    low, high = mechanics(hand).limits.T
    postures = np.random.default_rng(seed).uniform(low, high, (samples, len(low)))
    return np.array([from_tables(hand, y, nearest=nearest, tables=tables) / tensor_inertia(hand, y) - 1.0 for y in postures])


def _wrist(hand: Hand) -> list[int]:
    """Moving coordinates of the wrist."""
    return [k for k, name in enumerate(hand.moving_names) if hand.dofs[name].joint == "wrist"]


def fist(hand: Hand) -> Array:
    """Moving coordinates (moving,) of a plain fist with a straight wrist, inside the limits of this hand."""
    wanted = np.zeros(len(hand.moving_names))
    for k, name in enumerate(hand.moving_names):
        starts = [start for start in FIST_DEG if name.startswith(start)]
        if starts and not name.endswith("deviation"):
            wanted[k] = np.deg2rad(FIST_DEG[max(starts, key=len)])  # mcp1 has an angle of its own
    return np.clip(wanted, *mechanics(hand).limits.T)


def wrist_constant(hand: Hand, name: str = "relaxed") -> Array:
    """The constant moments of inertia (2,) of the whole hand about the wrist, flexion and deviation, kg m^2 (section 4.1.2).

    ``name``: the posture of this hand in which they are taken, "relaxed", "open" or "fist", or published means,
    "de leva female" or "de leva male" (see ``DE_LEVA``).
    """
    postures = {"relaxed": mechanics(hand).relaxed, "open": np.zeros(len(hand.moving_names)), "fist": fist(hand)}
    chosen = find(name, (*postures, *DE_LEVA), kind="wrist constant")
    if chosen in DE_LEVA:
        return frozen(DE_LEVA[chosen][: len(_wrist(hand))])
    return frozen(tensor_inertia(hand, postures[chosen])[_wrist(hand)])


class WristInertia(NamedTuple):
    """From the open hand to the fist: ``closed`` (n,) from 0 to 1, ``inertia`` (n, 2) about the wrist's flexion and deviation axes,
    the ``constant`` (2,) that stands for it, and its relative ``error`` (n, 2); kg m^2.
    """  # fmt: skip

    closed: Array
    inertia: Array
    constant: Array
    error: Array


def wrist_inertia_error(hand: Hand, *, constant: str = "relaxed", postures: int = 41) -> WristInertia:
    """How wrong a constant moment of inertia of the wrist is while the hand closes: ``constant`` is a name of ``wrist_constant``.

    ``error`` is constant / inertia - 1: positive where the constant makes the hand too sluggish. The wrist stays straight.
    """
    closed = np.linspace(0.0, 1.0, postures)
    end = fist(hand)
    inertia = np.array([tensor_inertia(hand, part * end)[_wrist(hand)] for part in closed])
    value = wrist_constant(hand, constant)
    return WristInertia(frozen(closed), frozen(inertia), value, frozen(value / inertia - 1.0))
