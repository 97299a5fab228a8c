"""Checks of lesson 05, "A finger with antagonists". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check import antagonists
from handlab.check.answers import listing, number, reference
from handlab.check.antagonists import FINGER, PROBES, arms, at, chosen, columns, everything, finger_part, flexions, rows
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.trials import column, pulls
from handlab.check.verdict import Wrong
from handlab.simulation.balance import total_torque
from handlab.simulation.settle import settle
from handlab.simulation.skeleton import rest

EXERCISES = Exercises("05")

ALONE, ASKED = 0.3, ("FDP3", "FDS3", "EDC3", "LUM2", "DI2")
OPEN_DEG, ASIDE_DEG = 5.0, 6.0


@EXERCISES.register("torque")
def torque(own: Callable[..., Any]) -> str:
    """A function (angle (3,) rad, contraction (6,)) that gives the torque of muscles and joints (3,)."""
    hand = reference()
    for degrees, contraction in PROBES:
        theirs = values(own, np.deg2rad(degrees), np.array(contraction))
        right = finger_part(total_torque(hand, at(degrees), everything(contraction)))
        spring = hand.stiffness[columns()] * (np.deg2rad(degrees) - hand.relaxed[columns()])
        resting = finger_part(total_torque(hand, at(degrees), everything(np.zeros(6))))
        slips = {
            "The stiffness of the joints is missing, or has the wrong sign: it pulls back to the relaxed angle.": right + spring,
            "The stiffness of the joints pushes away from the relaxed angle. Which sign pulls back?": right + 2.0 * spring,
            "The passive part of the fibres is missing: a stretched one pulls without contraction.": right - resting - spring,
            "The sign is the other way round.": -right,
        }
        compare(theirs, right, slips, "The torque of MCP, PIP and DIP", "N m")
    return "Your lines and the package agree at every joint, with all muscles of the finger."


def signs(answer: Any) -> dict[str, str]:
    """Three signs for each of the muscles that are asked for. Raises ``Wrong``."""
    if not isinstance(answer, Mapping) or set(answer) != set(ASKED):
        raise Wrong(f"Give a dictionary with the keys {listing(ASKED)}.")
    for name, text in answer.items():
        if not isinstance(text, str) or len(text) != 3 or set(text) - set("+-0"):
            raise Wrong(f"{name}: give three signs in quotes, for MCP, PIP and DIP, like '+-+'.")
    return dict(answer)


@EXERCISES.register("guess", guess=True)
def guess(answer: Any) -> str:
    """Any signs: being wrong here is the point."""
    signs(answer)
    return "Now let each of them pull."


@cache
def alone_changes() -> Mapping[str, Array]:
    """How far (3,) each muscle alone turns the three joints, degrees."""
    relaxed = np.rad2deg(reference().relaxed[columns()])
    return {name: flexions({name: ALONE}) - relaxed for name in ASKED}


@EXERCISES.register("alone")
def alone(answer: Any) -> str:
    """Measured signs of what each muscle alone does to the joints."""
    given = signs(answer)
    for name, change in alone_changes().items():
        for joint, sign, by in zip(("MCP", "PIP", "DIP"), given[name], change, strict=True):
            if sign != ("+" if by > 0.0 else "-"):
                side = "its lever arm says so, but others pull too" if sign == "0" or "EDC" in name or "FDS" in name else "compare signs"
                raise Wrong(f"{name}: the {joint} does not do that. Subtract the relaxed angle from the angle at rest ({side}).")
    bent = alone_changes()["EDC3"][1]
    return f"Look at EDC3: its arm at the PIP extends, and yet the PIP ends {bent:.1f} degrees more bent than before."


@EXERCISES.register("bouvier")
def bouvier(knuckle_free: Any, knuckle_held: Any) -> str:
    """PIP angles in degrees under the full extensor, with the knuckle free and held."""
    right = flexions({"EDC3": 1.0})[1], flexions({"EDC3": 1.0}, ("wrist", "mcp3"))[1]
    given = number(knuckle_free, "The first angle", "degrees"), number(knuckle_held, "The second angle", "degrees")
    if all(abs(a - b) < 1.0 for a, b in zip(given, right[::-1], strict=True)):
        raise Wrong("These two are swapped: first the free knuckle.")
    for value, expected in zip(given, right, strict=True):
        if abs(value - expected) > 1.0 and abs(np.rad2deg(value) - expected) < 1.0:
            raise Wrong(f"{value:.3g} is in radians. Give degrees.")
        if abs(value - expected) > 1.0:
            raise Wrong(f"The PIP does not rest at {value:.1f} degrees. Only EDC3 contracts, with 1, and the wrist is held both times.")
    return f"{right[0] - right[1]:.0f} degrees, for nothing but a knuckle that does not give way."


@cache
def holders() -> Mapping[str, float]:
    """Torques at the PIP in N m by muscle, for those that bend it under the full extensor."""
    contraction = {"EDC3": 1.0}
    force = pulls(settle(reference(), contraction, hold=("wrist",), look_for_others=False).state, contraction)
    turn = arms()[:, 1] * force[rows()]
    return {name: float(value) for name, value in zip(FINGER, turn, strict=True) if value > 1e-3}


@EXERCISES.register("who")
def who(names: Any, newton_metre: Any) -> str:
    """The muscles that hold the PIP bent under the full extensor, and their torque in N m."""
    named, right = chosen(names), holders()
    if named - set(right):
        raise Wrong(f"{listing(named - set(right))} does not bend the PIP here. What flexes has a plus sign.")
    if set(right) - named:
        raise Wrong("There is another one, hatched, with a plus sign.")
    total, value = sum(right.values()), number(newton_metre, "The torque", "N m")
    if abs(abs(value) - total) > 0.03 * total:
        raise Wrong(f"{value:.3g} N m is not what both give together at the PIP: lever arm in metres times force, added up.")
    return f"{listing(right)}, stretched by the extended knuckle, bend the PIP with {1000 * total:.0f} mN m. Nobody told them to."


def contractions(answer: Any) -> dict[str, float]:
    """Contractions by abbreviation, of the six muscles only. Raises ``Wrong``."""
    if not isinstance(answer, Mapping):
        raise Wrong("Give a dictionary like {'DI2': 0.1, ...}.")
    hand = reference()
    chosen(answer)
    values = {
        hand.muscles[str(name)].abbreviation: number(value, f"The contraction of {name}", "parts of 1") for name, value in answer.items()
    }
    if any(not 0.0 <= value <= 1.0 for value in values.values()):
        raise Wrong("Contractions lie between 0 and 1.")
    return values


@EXERCISES.register("open")
def opened(answer: Any, mcp_deg: Any) -> str:
    """Contractions that open PIP and DIP without the extensor, and the MCP flexion in degrees."""
    contraction = contractions(answer)
    if contraction.get("EDC3", 0.0) > 0.0:
        raise Wrong("The extensor has to keep silent.")
    found = flexions(contraction)
    for name, angle in zip(("PIP", "DIP"), found[1:], strict=True):
        if angle > OPEN_DEG + 0.2:
            raise Wrong(f"The {name} still rests at {angle:.0f} degrees. Who has an extending arm there, and some strength?")
    if abs(number(mcp_deg, "The flexion of the MCP", "degrees") - found[0]) > 1.0:
        raise Wrong("PIP and DIP are open. The MCP does not rest where you say, in degrees.")
    return f"Open, without any extensor, and the knuckle pays with {found[0]:.0f} degrees: the beak of the duck."


@EXERCISES.register("straight")
def straight(answer: Any) -> str:
    """Contractions that straighten the whole finger."""
    state = settle(reference(), contractions(answer), hold=("wrist",), look_for_others=False).state
    for name, angle in zip(("MCP", "PIP", "DIP"), np.rad2deg(state.angle[columns()]), strict=True):
        if abs(angle) > OPEN_DEG + 0.2:
            more = "bent" if angle > 0.0 else "extended"
            raise Wrong(f"The {name} rests at {angle:.0f} degrees: too far {more}. Which muscle has the arm that it needs?")
    aside = float(np.rad2deg(state.angle[column("mcp3.deviation")]))
    if abs(aside) > ASIDE_DEG + 0.2:
        raise Wrong(f"Straight, but {abs(aside):.0f} degrees to the {'thumb' if aside > 0.0 else 'little finger'}: balance DI2 and DI3.")
    return "A straight finger: the extensor holds the knuckle, the interossei open what is beyond it."


@EXERCISES.register("cascade")
def cascade(straighter_deg: Any, puller: Any) -> str:
    """How much straighter the middle finger rests with fibres at rest in the flat hand, in degrees, and what pulls hardest there."""
    hand = reference().with_fibre_rest("flat")
    state = settle(hand, {}, rest(reference()), hold=("wrist",), look_for_others=False).state
    right = float(np.rad2deg(hand.relaxed[columns()] - state.angle[columns()]).sum())
    value = number(straighter_deg, "The difference", "degrees")
    if abs(np.rad2deg(value) - right) < 1.0:
        raise Wrong(f"{value:.3g} is in radians. Give degrees.")
    if abs(value + right) < 1.0:
        raise Wrong("The size is right. Straighter counts as positive here.")
    if abs(value - right) > 1.0:
        raise Wrong(f"{value:.1f} degrees is not the difference. Add up MCP, PIP and DIP, relaxed minus where the hand rests now.")
    force = dict(zip(FINGER, (np.maximum(0.0, state.fibre_length / hand.rest_length - 1.0) ** 2 * hand.max_force)[rows()], strict=True))
    given = chosen(puller)
    strongest = max(FINGER, key=lambda name: float(force[name]))
    if given != {strongest}:
        raise Wrong(f"{listing(given)} does not pull hardest. Whose fibre is stretched beyond its rest length?")
    return f"In the paper's hand {strongest} is stretched even in the relaxed posture, and opens the finger by {right:.0f} degrees."


EXERCISES.register("stiffness")(antagonists.stiffness)


@EXERCISES.register("guess_stiff", guess=True)
def guess_stiff(relaxed: Any, straight: Any) -> str:
    """Any of both words, twice."""
    for answer in (relaxed, straight):
        if answer not in ("stiffer", "softer"):
            raise Wrong('Answer "stiffer" or "softer", twice.')
    return "Now measure it."


for _name in ("stiffen", "culprits", "newtons", "doubt", "two"):
    EXERCISES.register(_name)(getattr(antagonists, _name))
