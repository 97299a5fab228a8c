"""Compiled torques on the moving coordinates: muscles (1'), (2''), and the passive structures. The laws of ``handlab.physics``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

if TYPE_CHECKING:
    from handlab.simulation.mechanics import Mechanics

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@compiled
def muscle_torque(y: Array, contraction: Array, m: Mechanics, pushing: bool, torque: Array) -> None:
    """Add C'R'F to ``torque`` (k,) at ``y`` (k,) with ``contraction`` (m,); ``pushing``: the fitted curve without its guard."""
    start, column, value = m.arm_start, m.arm_column, m.arm_value
    length_at_zero, rest_length, max_force = m.length_at_zero, m.rest_length, m.max_force
    peak, curvature, passive = m.curves
    for i in range(rest_length.shape[0]):
        length = length_at_zero[i]
        for j in range(start[i], start[i + 1]):
            length -= value[j] * y[column[j]]
        ratio = length / rest_length[i]
        active = 1.0 - curvature * (ratio - peak) ** 2
        force = 0.0
        if active > 0.0 or pushing:
            force = contraction[i] * active
        if ratio > 1.0:
            force += passive * (ratio - 1.0) ** 2
        force *= max_force[i]
        for j in range(start[i], start[i + 1]):
            torque[column[j]] += value[j] * force


@compiled
def passive_torque(y: Array, m: Mechanics, torque: Array, slope: Array, drag: Array, stop: Array) -> float:
    """Add springs, capsules and ligaments at ``y`` to ``torque`` (k,) and return the energy that they store.

    Fills ``slope`` (k,), minus the derivative of each torque by its own coordinate, ``drag`` (k,), the viscous coefficient of friction
    and capsule, and ``stop`` (k, 2), where nothing gives any more.
    """
    friction, stiffness, relaxed, tightened_by = m.friction, m.stiffness, m.relaxed, m.tightened_by
    limits, all_width, torque_at_limit, time, hard_stop = m.limits, m.width, m.torque_at_limit, m.time, m.hard_stop
    range_fraction, stiffness_factor, taut_at = m.range_fraction, m.stiffness_factor, m.taut_at
    energy = 0.0
    for k in range(y.shape[0]):
        range_left, range_slope, stiffer, stiffer_slope = 1.0, 0.0, 1.0, 0.0
        f = tightened_by[k]
        if f >= 0:
            u = min(1.0, max(0.0, y[f] / taut_at))
            taut, rise = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / taut_at
            range_left, range_slope = 1.0 + (range_fraction - 1.0) * taut, (range_fraction - 1.0) * rise
            stiffer, stiffer_slope = 1.0 + (stiffness_factor - 1.0) * taut, (stiffness_factor - 1.0) * rise
        away = y[k] - relaxed[k]
        spring = stiffness[k] * stiffer
        torque[k] -= spring * away
        slope[k] = spring
        drag[k] = friction[k]
        energy += 0.5 * spring * away * away
        if f >= 0:
            torque[f] -= 0.5 * stiffness[k] * stiffer_slope * away * away
        lower, upper, width = range_left * limits[k, 0], range_left * limits[k, 1], range_left * all_width[k]
        stop[k, 0], stop[k, 1] = lower - hard_stop, upper + hard_stop
        if width <= 0.0 or lower + width < y[k] < upper - width:
            continue
        for side in range(2):
            sign = 1.0 if side == 1 else -1.0
            inner = sign * limits[k, side] - all_width[k]
            stretch = sign * y[k] - range_left * inner
            if stretch <= 0.0:
                continue
            u = stretch / width
            pull = torque_at_limit[k, side] * u * u * u
            stiff = 3.0 * pull / stretch
            torque[k] -= sign * pull
            slope[k] += stiff
            drag[k] += time[k] * stiff
            energy += 0.25 * pull * stretch
            if f >= 0:
                torque[f] += range_slope * pull * (inner + 0.75 * stretch / range_left)
    return energy
