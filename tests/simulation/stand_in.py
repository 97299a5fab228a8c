"""A hand of sticks, until the reference hand is built: facts as they are, bones as boxes, skin as tubes."""

import numpy as np

from handlab.anatomy import tables
from handlab.anatomy.records import Body, Bone, DegreeOfFreedom, FineSkin, Hand, Joint, Named, Skin, frozen
from handlab.anatomy.terms import BODIES, BONES



def box(a, b, r):
    a, b = np.asarray(a, float), np.asarray(b, float)
    d = (b - a) / np.linalg.norm(b - a)
    u = np.cross(d, [0.3, 0.5, 0.81])
    u /= np.linalg.norm(u)
    v = np.cross(d, u)
    ring = [u + v, -u + v, -u - v, u - v]
    points = np.array([p + r * q for p in (a, b) for q in ring])
    faces = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]] + [t for i in range(4) for t in ([i, (i + 1) % 4, i + 4], [(i + 1) % 4, (i + 1) % 4 + 4, i + 4])])
    return points, faces


def make():
    rad = np.deg2rad
    tip = {}
    seg = {1: [0.036, 0.032, 0.022], 2: [0.0426, 0.0251, 0.018], 3: [0.045, 0.029, 0.019], 4: [0.042, 0.027, 0.019], 5: [0.033, 0.02, 0.018]}
    mcp = {2: [0.085, 0, 0.022], 3: [0.085, 0, 0], 4: [0.08, 0, -0.018], 5: [0.073, 0, -0.035]}
    centre = {"wrist": [0, 0, 0], "cmc1": [0.02, 0.01, 0.025], "cmc2": [0.03, 0, 0.015], "cmc3": [0.03, 0, 0], "cmc4": [0.03, 0, -0.012], "cmc5": [0.028, 0, -0.022]}
    thumb = np.array([0.75, 0.25, 0.6])
    thumb /= np.linalg.norm(thumb)
    centre["mcp1"] = centre["cmc1"] + seg[1][0] * thumb
    centre["ip1"] = centre["mcp1"] + seg[1][1] * thumb
    tip[1] = centre["ip1"] + seg[1][2] * thumb
    for k in range(2, 6):
        centre[f"mcp{k}"] = np.array(mcp[k])
        centre[f"pip{k}"] = centre[f"mcp{k}"] + [seg[k][0], 0, 0]
        centre[f"dip{k}"] = centre[f"pip{k}"] + [seg[k][1], 0, 0]
        tip[k] = centre[f"dip{k}"] + np.array([seg[k][2], 0, 0])
    joints = {}
    for j in tables.joints_table().values():
        name = j.name
        dofs = []
        for d in j.dofs:
            kind = d.name.partition('.')[2]
            axis = {"flexion_extension": [0, 0, 1], "flexion_opposition": [0, 0, 1], "deviation": [0, -1, 0], "axial_rotation": [1, 0, 0], "abduction_adduction": [0, 0.2, 1]}[kind]
            if name in ("cmc1", "mcp1", "ip1"):
                flex = np.cross(thumb, [0.0, 1.0, 0.0])
                axis = {"flexion_opposition": [-0.3, 0.9, -0.2], "flexion_extension": [-0.3, 0.9, -0.2], "abduction_adduction": flex, "axial_rotation": thumb}[kind]
            axis = np.array(axis, float) / np.linalg.norm(axis)
            dofs.append(DegreeOfFreedom(d.name, name, d.positive, d.negative, frozen(axis), frozen(centre[name]), frozen(d.limits), d.sources, d.driver, d.ratio, d.offset))
        joints[name] = Joint(name, name, j.parent, j.child, frozen(centre[name]), tuple(dofs))
    muscles = tables.muscles()
    parent_joint = {"carpus": ("forearm", "wrist"), "metacarpal_1": ("carpus", "cmc1"), "metacarpal_4": ("carpus", "cmc4"), "metacarpal_5": ("carpus", "cmc5")}
    for k in range(1, 6):
        base = "carpus" if k in (2, 3) else f"metacarpal_{k}"
        parent_joint[f"proximal_phalanx_{k}"] = (base, f"mcp{k}")
        if k > 1:
            parent_joint[f"middle_phalanx_{k}"] = (f"proximal_phalanx_{k}", f"pip{k}")
        parent_joint[f"distal_phalanx_{k}"] = (f"middle_phalanx_{k}" if k > 1 else "proximal_phalanx_1", f"dip{k}" if k > 1 else "ip1")
    span = {"forearm": ([-0.06, 0, 0], [0, 0, 0]), "carpus": ([0, 0, 0], [0.08, 0, 0])}
    for name, (_, j) in parent_joint.items():
        if name != "carpus":
            k = int(name[-1])
            end = {"m": centre.get(f"mcp{k}"), "p": centre.get(f"pip{k}", centre["ip1"]), "i": centre.get(f"dip{k}"), "d": tip[k]}["i" if name.startswith("middle") else name[0]]
            span[name] = (centre[j], end)
    bodies, points, faces, weights = {}, [], [], []
    for b, name in enumerate(BODIES):
        p, q = map(np.asarray, span[name])
        r = 0.03 if name in ("forearm", "carpus") else 0.008
        length = np.linalg.norm(q - p)
        mass = 1100 * np.pi * r * r * length
        d = (q - p) / length
        along, across = mass * r * r / 2, mass * (3 * r * r + length**2) / 12
        bodies[name] = Body(name, *(parent_joint.get(name, (None, None))), mass, frozen((p + q) / 2), frozen(across * np.eye(3) + (along - across) * np.outer(d, d)))
        for f in np.linspace(0, 0.9, 10):
            pts, fcs = box(p + f * (q - p), p + (f + 0.1) * (q - p), r)
            faces.append(fcs + 8 * len(points))
            points.append(pts)
            w = np.zeros((8, 19))
            w[:, b] = 1.0
            if name in parent_joint and f < 0.3:
                up = BODIES.index(parent_joint[name][0])
                w[:, b], w[:, up] = 0.5 + f, 0.5 - f
            weights.append(w)
    points, faces, weights = np.concatenate(points), np.concatenate(faces), np.concatenate(weights)
    skin = Skin(frozen(points), frozen(faces, np.int64), frozen(weights))
    tri = np.arange(len(faces))
    bary = np.full((len(tri), 3), 1 / 3)
    fine = FineSkin(frozen(points[faces].mean(1)), frozen(tri[: len(tri) // 3 * 3].reshape(-1, 3), np.int64), frozen(np.zeros((len(tri) // 3, 3, 2))), frozen(tri, np.int64), frozen(bary), frozen(np.zeros(len(tri))))
    bones = {}
    for n, t in BONES.items():
        p, f = box(*span[t.body], 0.004)
        bones[n] = Bone(frozen(p), frozen(f, np.int64), n, t.latin, t.english, t.body)
    rest = np.array([d.fibre_rest for j in tables.joints_table().values() for d in j.dofs])
    stiff = np.array([d.stiffness for j in tables.joints_table().values() for d in j.dofs])
    return Hand(
        "stand-in", "right", "sound", skin, fine, Named("bone", bones), Named("body", bodies), Named("joint", joints),
        Named("muscle", muscles, tables.aliases()), {}, frozen(rest * 0.3), frozen(rest), frozen(stiff),
        {"range_fraction_at_90": 0.25, "stiffness_factor_at_90": 6.0}, 20.0, 0.015, {},
    )  # fmt: skip
