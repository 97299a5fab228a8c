"""A second engine for the same hand: MuJoCo's mass matrix, bias and tendons; our force laws, written here once more.

MuJoCo has neither our capsules nor exact couplings, so these go in as applied forces: with q = C y + c0 the accelerations q'' = C y''
solve C'M C y'' = C'(torque - bias), M and bias from MuJoCo (C is constant, so there is no further term). Many hands march together.
"""

import mujoco
import numpy as np

from handlab.simulation.to_mjcf import to_mjcf

TAUT_AT = np.pi / 2


def moving_limits(hand):
    """(moving, 2) rad: the tightest of a coordinate's own limits and those of what follows it."""
    found = []
    for k, name in enumerate(hand.moving_names):
        low, high = hand.limits[hand.dof_names.index(name)]
        for row in np.flatnonzero(hand.coupling[:, k]):
            ends = np.sort((hand.limits[row] - hand.coupling_offset[row]) / hand.coupling[row, k])
            low, high = max(low, ends[0]), min(high, ends[1])
        found.append((low, high))
    return np.array(found)


class Passive:
    """Springs, capsules, collateral ligaments and drag of many hands at once: every argument ``y`` is (hands, moving)."""

    def __init__(self, hand):
        moving = [hand.dof_names.index(name) for name in hand.moving_names]
        self.relaxed = hand.relaxed[moving]
        self.stiffness = (hand.coupling**2).T @ hand.stiffness
        self.friction = (hand.coupling**2).T @ np.broadcast_to(hand.friction, len(hand.dof_names))
        self.limits = moving_limits(hand)
        capsule = hand.capsule
        self.width, self.time = capsule.width[moving], capsule.time[moving]
        self.at_limit, self.hard_stop = capsule.torque[moving], capsule.hard_stop
        names = hand.moving_names
        self.deviation = [names.index(f"mcp{n}.deviation") for n in range(2, 6)]
        self.flexion = [names.index(f"mcp{n}.flexion_extension") for n in range(2, 6)]
        self.narrower = hand.collateral["range_fraction_at_90"] - 1.0
        self.stiffer = hand.collateral["stiffness_factor_at_90"] - 1.0

    def scales(self, y):
        """Range and stiffness relative to the slack ligament (hands, moving), and their slopes by flexion (hands, 4)."""
        u = np.clip(y[:, self.flexion] / TAUT_AT, 0.0, 1.0)
        taut, rise = 3.0 * u**2 - 2.0 * u**3, 6.0 * (u - u**2) / TAUT_AT
        span, stiff = np.ones_like(y), np.ones_like(y)
        span[:, self.deviation] += self.narrower * taut
        stiff[:, self.deviation] += self.stiffer * taut
        return span, stiff, self.narrower * rise, self.stiffer * rise

    def strains(self, y, span):
        """Lower and upper strain of the capsules (hands, moving): 1 at the limit."""
        inner = self.limits - self.width[:, None] * [-1.0, 1.0]
        low = np.maximum(0.0, span * inner[:, 0] - y) / (span * self.width)
        high = np.maximum(0.0, y - span * inner[:, 1]) / (span * self.width)
        return low, high

    def energy(self, y):
        """Joules (hands,)."""
        span, stiff, _, _ = self.scales(y)
        low, high = self.strains(y, span)
        spring = 0.5 * self.stiffness * stiff * (y - self.relaxed) ** 2
        return np.sum(spring + span * self.width / 4.0 * (self.at_limit[:, 0] * low**4 + self.at_limit[:, 1] * high**4), axis=1)

    def torque_and_drag(self, y):
        """Torque without drag, and the viscous coefficient (hands, moving)."""
        span, stiff, span_slope, stiff_slope = self.scales(y)
        low, high = self.strains(y, span)
        t_low, t_high = self.at_limit.T
        spring = self.stiffness * (y - self.relaxed)
        torque = t_low * low**3 - t_high * high**3 - stiff * spring
        drag = self.friction + self.time * 3.0 * (t_low * low**2 + t_high * high**2) / (span * self.width)
        # energy depends on flexion through stiffness, limits and width: d(strain)/d(span) = -+ y / (span^2 width)
        d = self.deviation
        by_span = self.width / 4.0 * (t_low * low**4 + t_high * high**4) + (t_low * low**3 - t_high * high**3) * y / span
        torque[:, self.flexion] -= stiff_slope * 0.5 * (spring * (y - self.relaxed))[:, d] + span_slope * by_span[:, d]
        return torque, drag

    def beyond(self, y):
        """How far (hands, moving) past a limit, in radians; negative inside."""
        span = self.scales(y)[0]
        return np.maximum(span * self.limits[:, 0] - y, y - span * self.limits[:, 1])


class Engine:
    """MuJoCo hands without any law of their own, one per gravity (hands, 3)."""

    def __init__(self, hand, gravities):
        self.hand, self.passive = hand, Passive(hand)
        self.models = {}
        for gravity in map(tuple, gravities):
            if gravity not in self.models:
                text = to_mjcf(hand, gravity=gravity, laws=False, bones=False, skin=False)
                self.models[gravity] = mujoco.MjModel.from_xml_string(text)
        self.lanes = [(model, mujoco.MjData(model)) for model in (self.models[tuple(g)] for g in gravities)]
        model, data = self.lanes[0]
        self.address = [model.joint(name).dofadr[0] for name in hand.dof_names]
        self.coupling, self.offset = np.empty_like(hand.coupling), np.empty_like(hand.coupling_offset)
        self.coupling[self.address], self.offset[self.address] = hand.coupling, hand.coupling_offset
        # fixed tendons: length = moment q; MuJoCo's own matrix, one column per joint
        self.moment = np.empty((model.ntendon, model.nv))
        for column in range(model.nv):
            data.qpos[:] = np.arange(model.nv) == column
            mujoco.mj_fwdPosition(model, data)
            self.moment[:, column] = data.ten_length
        self.straight = hand.rest_length + hand.lever_arm @ hand.fibre_rest

    def equation(self, y, speed):
        """M and bias of MuJoCo in moving coordinates: (hands, moving, moving) and (hands, moving)."""
        count = len(self.offset)
        q, v = y @ self.coupling.T + self.offset, speed @ self.coupling.T
        whole, bias = np.empty((len(y), count, count)), np.empty((len(y), count))
        for lane, (model, data) in enumerate(self.lanes):
            data.qpos[:], data.qvel[:] = q[lane], v[lane]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_makeM(model, data)
            mujoco.mj_fullM(model, data, whole[lane])
            mujoco.mj_comVel(model, data)
            mujoco.mj_rne(model, data, 0, bias[lane])
        return self.coupling.T @ whole @ self.coupling, bias @ self.coupling

    def pull(self, y, contraction):
        """Forces of all fibres in newtons (hands, muscle) and their lengths, from MuJoCo's tendons: (1')."""
        length = self.straight + (y @ self.coupling.T + self.offset) @ self.moment.T
        ratio = length / self.hand.rest_length
        active = np.maximum(0.0, 1.0 - 4.0 * (ratio - 1.1) ** 2)
        return self.hand.max_force * (contraction * active + 2.77 * np.maximum(0.0, ratio - 1.0) ** 2), length

    def torque(self, y, contraction):
        """Torque of all muscles (hands, moving)."""
        return -self.pull(y, contraction)[0] @ self.moment @ self.coupling

    def stop(self, y, speed, mass, dt):
        """No hand goes past a hard stop: plastic impacts, each found with all that touch at once, change ``speed`` (hands, moving)."""
        span = self.passive.scales(y)[0]
        low, high = (span * limit + sign * self.passive.hard_stop for limit, sign in zip(self.passive.limits.T, (-1, 1), strict=True))
        for lane in np.flatnonzero(np.any((y + dt * speed < low) | (y + dt * speed > high), axis=1)):
            touching, allowed = np.zeros(y.shape[1], dtype=bool), (np.array([low[lane], high[lane]]) - y[lane]) / dt
            inverse, free = np.linalg.inv(mass[lane]), speed[lane].copy()
            while (new := ((speed[lane] < allowed[0] - 1e-9) | (speed[lane] > allowed[1] + 1e-9)) & ~touching).any():
                touching |= new
                target = np.clip(free, *allowed)[touching]
                impulse = np.linalg.solve(inverse[np.ix_(touching, touching)], target - free[touching])
                speed[lane] = free + inverse[:, touching] @ impulse

    def march(self, y, speed, contraction, dt, every=1):
        """Angles and speeds (steps // every + 1, hands, moving) under ``contraction`` (steps, hands, muscle), drag at the step's end.

        Also the largest angle past any limit, in radians.
        """
        path, rate, farthest = [y], [speed], -np.inf
        diagonal = np.arange(y.shape[1])
        for step, now in enumerate(contraction):
            mass, bias = self.equation(y, speed)
            passive, drag = self.passive.torque_and_drag(y)
            mass[:, diagonal, diagonal] += dt * drag
            push = self.torque(y, now) + passive - bias - drag * speed
            speed = speed + dt * np.linalg.solve(mass, push[..., None])[..., 0]
            self.stop(y, speed, mass, dt)
            y = y + dt * speed
            if (step + 1) % every == 0:
                farthest = max(farthest, self.passive.beyond(y).max())
                path.append(y)
                rate.append(speed)
        return np.array(path), np.array(rate), farthest
