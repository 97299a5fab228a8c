"""The hand as a MuJoCo model: joints and rigid bodies only."""

import mujoco
import numpy as np


def numbers(values):
    return " ".join(repr(float(v)) for v in np.ravel(values))


def model(hand, masses=None):
    """A model with one hinge per degree of freedom, all written in the zero posture.

    ``masses``: centre (body, 3) and inertia (body, 3, 3) in the zero posture; points of no mass are not allowed there.
    """
    children = {name: [] for name in hand.bodies}
    for name, body in hand.bodies.items():
        if body.parent is not None:
            children[body.parent].append(name)

    def element(name):
        body = hand.bodies[name]
        dofs = () if body.joint is None else hand.joints[body.joint].dofs
        hinges = "".join(f'<joint name="{d.name}" type="hinge" axis="{numbers(d.axis)}" pos="{numbers(d.anchor)}"/>' for d in dofs)
        centre, inertia = (np.zeros(3), 1e-6 * np.eye(3)) if masses is None else (m[hand.body_names.index(name)] for m in masses)
        i = inertia
        full = numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
        mass = f'<inertial pos="{numbers(centre)}" mass="{body.mass!r}" fullinertia="{full}"/>'
        return f'<body name="{name}">{mass}{hinges}{"".join(element(child) for child in children[name])}</body>'

    root = next(name for name, body in hand.bodies.items() if body.parent is None)
    text = f'<mujoco><compiler angle="radian" boundmass="0" balanceinertia="false"/><worldbody>{element(root)}</worldbody></mujoco>'
    return mujoco.MjModel.from_xml_string(text)


def at(model, hand, angle):
    """Data of the model with its joints at ``angle`` (dof,)."""
    data = mujoco.MjData(model)
    for name, value in zip(hand.dof_names, angle, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    return data


def address(model, hand):
    """Where each degree of freedom stands in MuJoCo's velocity vector."""
    return [model.joint(name).dofadr[0] for name in hand.dof_names]


def mass_matrix(model, data):
    """The whole mass matrix, column by column: it is stored differently from version to version."""
    columns = np.empty((model.nv, model.nv))
    for column, unit in zip(columns, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    return columns
