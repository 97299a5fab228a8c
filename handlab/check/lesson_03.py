"""Checks of lesson 03, "One bone turns". What is right is computed on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np

from handlab.check.answers import joints, listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.verdict import Open, Wrong, is_open
from handlab.physics.one_bone import Rule, march
from handlab.physics.rotation import explicit_step, implicit_speed, largest_step, printed_step, turned
from handlab.physics.torque import friction_printed
from handlab.simulation.mechanics import moments_of_inertia
from handlab.simulation.skeleton import pose

EXERCISES = Exercises("03")

FINGER, TIP, WRIST = "mcp2.flexion_extension", "dip2.flexion_extension", "wrist.flexion_extension"
FLICK = 10.0  # rad/s, speed of the exercises "guess" and "coast"
PROBES = ((0.3, 2.0, 0.05, 1e-4), (0.3, -2.0, 0.05, 1e-4), (-0.1, 5.0, -0.02, 5e-4), (0.0, 4.0, 0.0, 2e-3))  # angle, speed, torque, dt
FRAME = 1.0 / 60.0  # s
BRAKE_SPEED, BRAKE_TORQUE, BRAKE_SECONDS, BRAKE_STEP = 5.0, -0.02, 0.01, 1e-5  # of the exercise "runaway"
CASES = {"A": (0.1, 2.0), "B": (0.1, -2.0), "C": (-0.1, 2.0), "D": (0.01, 2.0), "E": (0.0, 2.0)}  # torque, speed of "push"
PULL = 0.05  # N m, of the exercises "matters" and "order"
MATTERS_SECONDS, ORDER_SECONDS = 0.1, 3e-3
COARSE, FINE = 1e-4, 1e-5  # steps of the exercise "order", s
BY_HAND = 0.03  # an answer found by trying may be off by this part


@cache
def inertia(dof: str) -> float:
    """J in kg m^2 of all that a degree of freedom carries in the straight hand."""
    hand = reference()
    straight = pose(hand, dict.fromkeys(hand.moving_names, 0.0))
    return float(moments_of_inertia(hand, straight.angle)[hand.dof_names.index(dof)])


@cache
def friction() -> float:
    """Mu in N m s/rad as the paper has it, one number for every joint; the fingers of the default reading have it too."""
    return float(np.max(reference("printed").friction))


Step = Callable[[float, float, float, float], tuple[Any, Any]]


def explicit(angle: float, speed: float, torque: float, dt: float) -> tuple[Any, Any]:
    """The step of the exercise "step"."""
    return explicit_step(angle, speed, torque, inertia(FINGER), dt, friction())


def implicit(angle: float, speed: float, torque: float, dt: float) -> tuple[Any, Any]:
    """The step of the exercise "repair"."""
    after = implicit_speed(speed, torque, inertia(FINGER), dt, friction())
    return turned(angle, after, dt), after


def slips(angle: float, speed: float, torque: float, dt: float) -> dict[str, tuple[Any, Any]]:
    """What common mistakes give, by the sentence that helps."""
    J, mu = inertia(FINGER), friction()
    bare = speed + dt * torque / J
    pushed = speed + dt * (torque + mu * speed) / J
    right = speed + dt * (torque - mu * speed) / J
    held = (speed + dt * torque / J) / (1.0 + dt * mu / J)
    times = speed + dt * (torque - mu * speed) * J
    printed = printed_step(angle, speed, torque, J, dt, mu)
    return {
        "Friction is missing.": (angle + dt * bare, bare),
        "Here friction pushes. It has to act against the speed.": (angle + dt * pushed, pushed),
        "The torque is divided by the moment of inertia, not multiplied by it.": (angle + dt * times, times),
        "The angle is moved with the old speed. The rule takes the new one.": (angle + dt * speed, right),
        "The angle is moved with the old speed; take the new one.": (angle + dt * speed, held),
        "The angle stands still: it has to move by dt times the new speed.": (angle, right),
        "The change of the angle came back. Add it to the old angle.": (dt * right, right),
        "The speed came first. Hand back the angle, then the speed.": (right, angle + dt * right),
        "That is the printed friction, along the torque. Let it act against the speed.": printed,
        "Here friction still takes the old speed, so a long step explodes. Let it take the new one.": (angle + dt * right, right),
        "That is the implicit step, which comes later. Take friction from the old speed.": (angle + dt * held, held),
    }


def compare_steps(theirs: Step, right: Step) -> None:
    """Raise ``Wrong`` with the likely slip unless a function makes the right steps."""
    if not callable(theirs):
        raise Wrong("Hand over the function itself, without brackets: step, not step(...).")
    answers = []
    for probe in PROBES:
        answer = theirs(*probe)
        if is_open(answer):
            raise Open
        try:
            angle, speed = (float(np.asarray(value)) for value in answer)
        except (TypeError, ValueError):
            raise Wrong(f"The function has to hand back two numbers, the angle and the speed; it gave {answer!r}.") from None
        answers.append((angle, speed))
    if all(same(answer, right(*probe)) for answer, probe in zip(answers, PROBES, strict=True)):
        return
    for text in slips(*PROBES[0]):
        if all(same(answer, slips(*probe)[text]) for answer, probe in zip(answers, PROBES, strict=True)):
            raise Wrong(text)
    for answer, probe in zip(answers, PROBES, strict=True):
        wanted = right(*probe)
        if not same(answer, wanted):
            given = "angle {:g}, speed {:g}, torque {:g}, dt {:g}".format(*probe)
            raise Wrong(
                f"For {given} the speed comes out as {answer[1]:.6g} rad/s and the angle as {answer[0]:.6g} rad; "
                f"the package has {float(wanted[1]):.6g} and {float(wanted[0]):.6g}."
            )


def same(one: tuple[Any, Any], other: tuple[Any, Any]) -> bool:
    """Whether angle and speed agree."""
    return all(abs(float(a) - float(b)) <= 1e-9 * max(1.0, abs(float(b))) for a, b in zip(one, other, strict=True))


def near(answer: Any, right: float, what: str, unit: str, part: float = BY_HAND) -> bool:
    """Whether a number is right to a part of itself."""
    return abs(number(answer, what, unit) - right) <= part * abs(right)


@EXERCISES.register("guess", guess=True)
def guess(degrees: Any) -> str:
    """Any number of degrees."""
    number(degrees, "The guess", "degrees")
    return "You will measure it soon."


@EXERCISES.register("step")
def step(own: Step) -> str:
    """A function (angle, speed, torque, dt) that returns the new angle and the new speed."""
    compare_steps(own, explicit)
    return "Your lines and the package agree to nine digits."


@EXERCISES.register("coast")
def coast(degrees: Any) -> str:
    """Degrees that the straight index finger turns on after it is let go at ``FLICK``."""
    right = float(np.rad2deg(FLICK * inertia(FINGER) / friction()))
    if near(np.deg2rad(1.0) * right, float(number(degrees, "The way", "degrees")), "The way", "degrees"):
        raise Wrong(f"{degrees:.3g} is in radians. Give degrees.")
    if not near(degrees, right, "The way", "degrees", 0.02):
        raise Wrong(f"{float(degrees):.3g} degrees is not what a fresh hand does. Start at 10 rad/s, torque 0, tiny steps, 0.05 s.")
    time = 1e3 * inertia(FINGER) / friction()
    return f"It stops within one degree: friction eats the speed with the time constant J/mu = {time:.2g} ms."


@EXERCISES.register("limit")
def limit(finger_ms: Any, tip_ms: Any) -> str:
    """The longest step of the explicit rule that does not blow up, in milliseconds: of the finger (tried), of its tip (computed)."""
    for answer, dof, what in ((finger_ms, FINGER, "The longest step of the finger"), (tip_ms, TIP, "The longest step of its last bone")):
        right = 1e3 * float(largest_step(inertia(dof), friction()))
        value = number(answer, what, "milliseconds")
        if abs(value - right) <= BY_HAND * right:
            continue
        if abs(1e3 * value - right) <= BY_HAND * right:
            raise Wrong(f"{what} is given in seconds. Give milliseconds.")
        if abs(2.0 * value - right) <= BY_HAND * right:
            raise Wrong(f"{what}: at J/mu the speed only begins to change its sign. It grows a good deal later.")
        if dof == TIP and abs(value - 1e3 * float(largest_step(inertia(FINGER), friction()))) <= BY_HAND * value:
            raise Wrong("The last bone has a moment of inertia of its own. Put it into the formula that your first number follows.")
        hint = (
            "Try steps until the speed neither grows nor shrinks."
            if dof == FINGER
            else "Which formula gives your first number? Put J_tip in."
        )
        raise Wrong(f"{what} is not {value:.4g} ms. {hint}")
    return "2J/mu, both times. A film has a frame every 16.7 ms: the last bone of a finger would need hundreds of steps for each."


@EXERCISES.register("repair")
def repair(own: Step) -> str:
    """The same function with friction at the end of the step."""
    compare_steps(own, implicit)
    _, after = own(0.0, FLICK, 0.0, FRAME)
    return f"No step is too long now: one frame of 16.7 ms takes 10 rad/s to {float(after):.2f}, and never past zero."


@EXERCISES.register("sixty")
def sixty(survivors: Any, wrist_degrees: Any) -> str:
    """Joints that the explicit rule can compute at 60 Hz, and how far the wrist coasts from 10 rad/s, in degrees."""
    named = joints(survivors)
    asked = ("wrist", "mcp1", "ip1", "mcp2", "pip2", "dip2", "mcp5")
    right = {joint for joint in asked if largest_step(inertia(f"{joint}.flexion_extension"), friction()) > FRAME}
    if named != right:
        wrong = min(named ^ right)
        raise Wrong(f"Compare 2J/mu with 1/60 s again: {wrong} is {'not one of them' if wrong in named else 'missing'}.")
    way = float(np.rad2deg(FLICK * inertia(WRIST) / friction()))
    if not near(wrist_degrees, way, "The way of the wrist", "degrees"):
        raise Wrong(f"The wrist does not coast {float(wrist_degrees):.3g} degrees. The finger went speed times J/mu; put in the wrist's J.")
    return (
        f"{way:.0f} degrees: the whole hand is heavy, and one mu for every joint, taken from cartilage, brakes it too little. A real wrist "
        f"does not swing on like a door. This laboratory gives it {np.max(reference().friction):g} N m s/rad: a choice, and no measurement."
    )


@cache
def pushing() -> tuple[frozenset[str], str]:
    """Cases in which the printed friction adds power, and the one in which it does nothing."""
    powers = {name: (float(friction_printed(T, w, friction())) - T) * w for name, (T, w) in CASES.items()}
    (idle,) = (name for name, power in powers.items() if power == 0.0)
    return frozenset(name for name, power in powers.items() if power > 0.0), idle


@EXERCISES.register("push")
def push(pushes: Any, never_stops: Any) -> str:
    """Letters of the cases in which friction pushes, and of the one in which nothing brakes."""
    right, idle = pushing()
    if not isinstance(pushes, Iterable):
        raise Wrong("Give the letters in quotes, like {'A', 'D'}.")
    named = {one(str(letter), CASES, "case") for letter in pushes}
    if named - right:
        wrong = min(named - right)
        raise Wrong(f"Case {wrong}: work out (printed friction part) times speed. Positive would be a push; here it is not.")
    if right - named:
        raise Wrong("There is another case in which friction has the sign of the speed.")
    if one(never_stops, CASES, "case") != idle:
        raise Wrong("A bone coasts when nothing pulls. In which case is that so, and what friction does the printed rule give it?")
    return f"Torque against speed, {listing(right)}: there friction feeds the motion. In {idle} the paper's reason for friction is lost."


@cache
def braked(rule: Rule) -> float:
    """Speed after the exercise "runaway"."""
    moved = march(rule, lambda time, angle: BRAKE_TORQUE, inertia(FINGER), friction(), BRAKE_STEP, BRAKE_SECONDS, speed=BRAKE_SPEED)
    return float(moved.speed[-1])


@EXERCISES.register("runaway")
def runaway(printed: Any, sound: Any) -> str:
    """Two speeds in rad/s after 10 ms of braking: friction as printed, and against the motion."""
    if near(printed, braked("explicit"), "The printed speed", "rad/s") and near(sound, braked("printed"), "The other speed", "rad/s"):
        raise Wrong("These two are swapped: first the printed rule.")
    for value, rule, what in ((printed, "printed", "The printed rule"), (sound, "explicit", "Friction against the motion")):
        if not near(value, braked(rule), what, "rad/s", 0.05):
            raise Wrong(f"{what} does not end at {float(value):.4g} rad/s. From +5 rad/s, torque -0.02 N m, steps of 0.01 ms, for 10 ms.")
    turns = braked("printed") / (2.0 * np.pi)
    return f"A muscle that should brake leaves the finger spinning {turns:.0f} times a second. With the sound rule it has turned back."


@cache
def changed(inertia_factor: float, friction_factor: float) -> float:
    """Percent by which the angle after the exercise "matters" changes."""
    first, other = (
        float(march("leapfrog", lambda time, angle: PULL, a * inertia(FINGER), b * friction(), 1e-4, MATTERS_SECONDS).angle[-1])
        for a, b in ((1.0, 1.0), (inertia_factor, friction_factor))
    )
    return 100.0 * (other / first - 1.0)


@EXERCISES.register("matters")
def matters(inertia_percent: Any, friction_percent: Any) -> str:
    """Change of the angle in percent with the inertia doubled, and with the friction doubled."""
    given = {"inertia": number(inertia_percent, "The first change", "percent")}
    given["friction"] = number(friction_percent, "The second change", "percent")
    right = {"inertia": changed(2.0, 1.0), "friction": changed(1.0, 2.0)}
    if abs(given["inertia"] - right["friction"]) < 2.0 and abs(given["friction"] - right["inertia"]) < 0.5:
        raise Wrong("These two are swapped: first the inertia.")
    for what, value in given.items():
        if abs(value + right[what]) < 0.3:
            raise Wrong(f"Twice the {what}: the size is right. Does the finger get further, or less far?")
        if abs(100.0 * value - right[what]) < 0.5:
            raise Wrong(f"Twice the {what}: {value:.3g} is a part of one. Give percent.")
        if abs(value - right[what]) > 0.3:
            raise Wrong(f"Twice the {what} does not change the angle by {value:.2f} percent. 0.1 s, 0.05 N m, from rest.")
    return (
        f"Twice the weight costs {-right['inertia']:.1f} percent, twice the friction {-right['friction']:.0f}: a finger is overdamped, "
        "and its inertia hardly matters."
    )


@cache
def shrinking(rule: Rule) -> float:
    """By which factor the error of the angle shrinks from ``COARSE`` to ``FINE`` steps."""
    J, mu = inertia(FINGER), friction()
    tau = J / mu
    exact = PULL / mu * (ORDER_SECONDS - tau * (1.0 - np.exp(-ORDER_SECONDS / tau)))
    coarse, fine = (march(rule, lambda time, angle: PULL, J, mu, dt, ORDER_SECONDS).angle[-1] - exact for dt in (COARSE, FINE))
    return float(coarse / fine)


@EXERCISES.register("order")
def order(implicit_factor: Any, leapfrog_factor: Any) -> str:
    """By which factors the errors shrink when the step is ten times shorter."""
    for value, rule in ((implicit_factor, "implicit"), (leapfrog_factor, "leapfrog")):
        right = shrinking(rule)
        if near(value, 1.0 / right, f"The factor of {rule}", "times", 0.1):
            raise Wrong(f"{rule}: that is the fine error over the coarse one. Turn it round.")
        if not near(value, right, f"The factor of {rule}", "times", 0.1):
            raise Wrong(f"{rule}: {float(value):.4g} is not the ratio of the errors at 0.1 ms and 0.01 ms, 3 ms after the start.")
    return "Ten times the work buys one digit with the implicit rule (order 1), two digits with the leapfrog (order 2)."
