"""One bone that turns about one axis, marched through time by a rule of choice: section 4.1.1 without a hand around it.

Torque in newton metres, inertia in kilogram square metres, friction in newton metre seconds per radian; radians and seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.physics.rotation import explicit_step, implicit_speed, leapfrog_first, leapfrog_speed, printed_step, turned

Array = NDArray[np.float64]
Rule = Literal["printed", "explicit", "implicit", "leapfrog"]
Torque = Callable[[float, float], float]  # of time and angle, friction not included

RULES: dict[Rule, str] = {
    "printed": "friction along the muscle, at the old speed: (2'), (3), (4) as printed",
    "explicit": "friction against the motion, at the old speed",
    "implicit": "friction against the motion, at the new speed",
    "leapfrog": "speeds halfway between the angles",
}
RUN_AWAY = 1e12  # rad/s; a bone as fast as this is given up, before its numbers overflow


class Motion(NamedTuple):
    """``time``, ``angle`` and ``speed`` (n,) of one bone; shorter than asked for if it ran away."""

    time: Array
    angle: Array
    speed: Array


def march(
    rule: Rule, torque: Torque, inertia: float, friction: float, dt: float, seconds: float, *, angle: float = 0.0, speed: float = 0.0
) -> Motion:
    """J d(omega)/dt = T - mu omega in steps of ``dt`` until ``seconds``, by a rule of ``RULES``.

    ``torque(time, angle)`` is asked at the beginning of every step. Stops early once the speed exceeds ``RUN_AWAY``. Raises
    ``ValueError`` for an unknown rule or a step that is no positive number.

    >>> moved = march("implicit", lambda time, angle: 0.03, 4e-5, 0.015, 1e-3, 0.1)
    >>> round(float(moved.speed[-1]), 3)
    2.0
    """
    if rule not in RULES:
        raise ValueError(f"rule is {rule!r}; choose one of {', '.join(RULES)}")
    for name, value in (("dt", dt), ("seconds", seconds), ("inertia", inertia)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value:g}; give a positive number")
    if not (np.isfinite(friction) and friction >= 0.0):
        raise ValueError(f"friction is {friction:g}; give 0 or a positive number")
    steps = max(1, round(seconds / dt))
    angles, speeds = np.full(steps + 1, float(angle)), np.full(steps + 1, float(speed))
    half = 0.0  # leapfrog only
    for n in range(steps):
        pull = torque(n * dt, angle)
        if rule == "printed":
            new_angle, new_speed = printed_step(angle, speed, pull, inertia, dt, friction)
        elif rule == "explicit":
            new_angle, new_speed = explicit_step(angle, speed, pull, inertia, dt, friction)
        elif rule == "implicit":
            new_speed = implicit_speed(speed, pull, inertia, dt, friction)
            new_angle = turned(angle, new_speed, dt)
        else:
            first = n == 0
            half = float(leapfrog_first(speed, pull, inertia, dt, friction) if first else leapfrog_speed(half, pull, inertia, dt, friction))
            new_angle = turned(angle, half, dt)
            next_half = leapfrog_speed(half, torque((n + 1) * dt, float(new_angle)), inertia, dt, friction)
            new_speed = 0.5 * (half + next_half)
        angle, speed = float(new_angle), float(new_speed)
        angles[n + 1], speeds[n + 1] = angle, speed
        if not abs(speed) < RUN_AWAY:
            steps = n + 1
            break
    time: Array = dt * np.arange(steps + 1, dtype=np.float64)
    return Motion(time, angles[: steps + 1], speeds[: steps + 1])
