"""A clip as animated glTF 2.0: bones that move, a skin that follows them, in one ``.glb`` that any 3D program opens.

The skin is always the blended one, also of a clip with a soft skin: springs and muscles are not in the file.

glTF blends matrices, which loses girth at bent joints; here the skin is blended by dual quaternions. The difference, seen from the
stored posture, goes into a few corrective shapes ("morph targets") with weights over time: p = sum_b w_b T_b (x + sum_k a_k d_k).
They come from a singular value decomposition, as many as it takes to stay below ``TOLERANCE``.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.glb import ARRAY_BUFFER
from handlab.anatomy.records import Array, Hand
from handlab.anatomy.store import seams
from handlab.show.colours import IVORY
from handlab.show.gltf_document import Document
from handlab.show.moments import Story
from handlab.show.surface import Normals
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.skin import binding, blend, fine_points
from handlab.simulation.writing import whole_file

FPS = 30.0
TOLERANCE = 1e-4  # metres: a tenth of a millimetre cannot be seen
MOST_SHAPES = 24
ROUGHNESS = {"skin": 0.55, "bone": 0.5}


def glb(story: Story, fps: float = FPS) -> bytes:
    """The file of a clip at ``fps`` frames per second (at most its own), or of a state, which does not move."""
    hand = story.hand
    document = Document(f"reference data as stated in handlab's assets; hand {hand.name!r}, {hand.side}")
    angles, time = sampled(story, fps)
    motion = np.stack([relative_transforms(hand, angle) for angle in angles])  # (T, body, 4, 4)
    joints = [document.node({"name": name, **still(motion[0, k])}) for k, name in enumerate(hand.body_names)]
    add_bones(document, hand, joints)
    skin_node, skin_mesh, weights = add_skin(document, hand, joints, angles, motion)
    if len(time) > 1:
        animate(document, time, motion, joints, skin_node, weights, str(getattr(story.clip, "name", "")) or "clip")
    elif weights.shape[1]:
        document.json["meshes"][skin_mesh]["weights"] = weights[0].tolist()
    return document.file()


def sampled(story: Story, fps: float) -> tuple[list[Array], Array]:
    """Angles (dof,) at times (T,) from 0 to the end of the story."""
    if story.clip is None or story.seconds <= 0.0:
        return [story.at(0.0).angle], np.zeros(1)
    count = int(np.ceil(story.seconds * min(fps, float(story.clip.fps)) - 1e-6)) + 1
    time = np.linspace(0.0, story.seconds, count)
    return [story.at(float(t)).angle for t in time], time


def add_bones(document: Document, hand: Hand, joints: list[int]) -> None:
    """One mesh a bone, below the node of its body."""
    ivory = [*(linear(int(IVORY[k : k + 2], 16)) for k in (1, 3, 5)), 1.0]
    material = document.add("materials", matter("bone", ivory))
    for name, bone in hand.bones.items():
        attributes = {"POSITION": document.points(bone.points), "NORMAL": normals(document, bone.points, bone.faces)}
        primitive = {"attributes": attributes, "indices": document.faces(bone.faces), "material": material}
        mesh = document.add("meshes", {"name": name, "primitives": [primitive]})
        document.node({"name": name, "mesh": mesh}, joints[hand.body_names.index(bone.body)])


def add_skin(document: Document, hand: Hand, joints: list[int], angles: list[Array], motion: Array) -> tuple[int, int, Array]:
    """The fine skin: its node, its mesh, and the weights (T, shapes) of its corrective shapes."""
    fine = hand.skin_fine
    bodies, share = fine_weights(hand)
    shapes, weights = corrections(hand, angles, motion, bodies, share)
    faces, point, colours, material = coloured(document, hand)
    directions = np.asarray(Normals(fine.faces, len(fine.points)).of(fine.points), dtype="<f4")
    attributes = {
        "POSITION": document.points(fine.points[point]),
        "NORMAL": document.accessor(directions[point], target=ARRAY_BUFFER),
        "JOINTS_0": document.accessor(bodies[point].astype("u1"), target=ARRAY_BUFFER),
        "WEIGHTS_0": document.accessor(share[point].astype("<f4"), target=ARRAY_BUFFER),
        **colours,
    }
    primitive: dict[str, Any] = {
        "attributes": attributes,
        "indices": document.faces(faces),
        "material": document.add("materials", material),
    }
    mesh: dict[str, Any] = {"name": "skin", "primitives": [primitive]}
    if len(shapes):
        primitive["targets"] = [{"POSITION": document.points(shape[point])} for shape in shapes]
        mesh |= {"weights": [0.0] * len(shapes), "extras": {"targetNames": [f"corrective {k + 1}" for k in range(len(shapes))]}}
    number = document.add("meshes", mesh)
    skin = document.add("skins", {"name": "skin", "joints": joints, "skeleton": 0})
    return document.node({"name": "skin", "mesh": number, "skin": skin}), number, weights


def coloured(document: Document, hand: Hand) -> tuple[Any, Any, dict[str, int], dict[str, Any]]:
    """Faces of the stored skin, the point (K,) of each stored one, attributes that colour it, and its material.

    A hand with a picture shows that: points along the seams of the texture then stand there more than once. Others have a tone per point.
    """
    from handlab.show.complexion import complexion

    fine, white = hand.skin_fine, matter("skin", [1.0, 1.0, 1.0, 1.0])
    if hand.picture is None:
        tone = np.column_stack([np.array([linear(v) for v in range(256)])[complexion(hand)] * 255, np.full(len(fine.points), 255)])
        tones = document.accessor(np.rint(tone).astype("u1"), target=ARRAY_BUFFER, normalized=True)
        return fine.faces, np.arange(len(fine.points)), {"COLOR_0": tones}, white
    faces, point, place = seams(fine.faces, fine.texture)
    document.add("images", {"bufferView": document.view(png(hand.picture)), "mimeType": "image/png"})
    white["pbrMetallicRoughness"]["baseColorTexture"] = {"index": document.add("textures", {"source": 0})}
    return faces, point, {"TEXCOORD_0": document.accessor(place.astype("<f4"), target=ARRAY_BUFFER)}, white


def png(picture: Any) -> bytes:
    """Pixels as a PNG file."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, format="PNG", optimize=True)
    return stream.getvalue()


def fine_weights(hand: Hand) -> tuple[NDArray[np.int64], Array]:
    """Bodies and weights (Nf, 4) of the fine skin: those of the even skin's triangle beneath each point, the heaviest four."""
    bound, fine = binding(hand), hand.skin_fine
    dense = np.zeros((len(hand.skin.points), len(hand.body_names)))
    np.put_along_axis(dense, bound.index.astype(np.int64), bound.weight, axis=1)
    mixed = np.einsum("ni,nib->nb", fine.barycentric, dense[bound.corners.astype(np.int64)])
    order = np.argsort(-mixed, axis=1, kind="stable")[:, :4]
    heaviest = np.take_along_axis(mixed, order, axis=1)
    heaviest = (heaviest / heaviest.sum(axis=1, keepdims=True)).astype("<f4").astype(np.float64)  # as the file has them
    return np.where(heaviest > 0.0, order, 0), heaviest / heaviest.sum(axis=1, keepdims=True)


def corrections(hand: Hand, angles: list[Array], motion: Array, bodies: Any, share: Array) -> tuple[Array, Array]:
    """Shapes (k, Nf, 3) and weights (T, k), each weight at most 1 in size, that turn the blend of matrices into the hand's own skin."""
    stored = hand.skin_fine.points
    dense = np.zeros((len(stored), motion.shape[1]))
    for k in range(share.shape[1]):
        dense[np.arange(len(stored)), bodies[:, k]] += share[:, k]
    wanted = np.empty((len(angles), *stored.shape))
    for t, angle in enumerate(angles):
        mixed = (dense @ motion[t, :, :3].reshape(-1, 12)).reshape(-1, 3, 4)
        target = fine_points(hand, blend(hand, angle))
        wanted[t] = unmixed(mixed, target) - stored
    flat = wanted.reshape(len(angles), -1)
    # Few times, many points: the small side first.
    values, vectors = np.linalg.eigh(flat @ flat.T)
    vectors = vectors[:, np.argsort(-values)]
    count, rest = 0, flat.copy()
    while count < min(MOST_SHAPES, len(angles)) and np.einsum("ni,ni->n", *[rest.reshape(-1, 3)] * 2).max() > TOLERANCE**2:
        direction = vectors[:, count : count + 1]
        rest -= direction @ (direction.T @ flat)
        count += 1
    weights = vectors[:, :count]
    shapes = weights.T @ flat
    size = np.maximum(np.abs(weights).max(axis=0), 1e-12)
    result: Array = (shapes * size[:, None]).reshape(count, *stored.shape)
    return result, weights / size


def unmixed(mixed: Array, points: Array) -> Array:
    """The points (n, 3) that transforms ``mixed`` (n, 3, 4) move to ``points``: Cramer's rule, faster here than a solver."""
    a, b, c, shift = (mixed[:, :3, k] for k in range(4))
    target = points - shift
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    result: Array = np.einsum("nij,nj->ni", rows, target) / np.einsum("ni,ni->n", a, rows[:, 0])[:, None]
    return result


def animate(document: Document, time: Array, motion: Array, joints: list[int], skin: int, weights: Array, name: str) -> None:
    """Turn and shift every body, and fade the corrective shapes."""
    clock = document.accessor(time.astype("<f4"), bounds=True)
    animation: dict[str, Any] = {"name": name, "samplers": [], "channels": []}

    def channel(node: int, path: str, values: Any) -> None:
        output = document.accessor(np.ascontiguousarray(values, dtype="<f4"))
        animation["samplers"].append({"input": clock, "output": output, "interpolation": "LINEAR"})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})

    for k, node in enumerate(joints):
        if np.ptp(motion[:, k], axis=0).max() > 0.0:
            channel(node, "rotation", continuous(np.stack([quaternion(turn) for turn in motion[:, k, :3, :3]])))
            channel(node, "translation", motion[:, k, :3, 3])
    if weights.shape[1]:
        channel(skin, "weights", weights.ravel())
    if animation["channels"]:
        document.add("animations", animation)


def still(transform: Array) -> dict[str, Any]:
    """Rotation and translation of a node."""
    return {"rotation": quaternion(transform[:3, :3]).tolist(), "translation": transform[:3, 3].tolist()}


def quaternion(turn: Array) -> Array:
    """Unit quaternion (x, y, z, w) of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    result: Array = Rotation.from_matrix(turn).as_quat()
    return result


def continuous(quaternions: Array) -> Array:
    """Quaternions (T, 4), each on the side of the one before: between q and -q a viewer would spin."""
    flips = np.sign(np.einsum("ti,ti->t", quaternions[1:], quaternions[:-1]))
    signs = np.concatenate([[1.0], np.cumprod(np.where(flips == 0.0, 1.0, flips))])
    result: Array = quaternions * signs[:, None]
    return result


def normals(document: Document, points: Array, faces: Any) -> int:
    """Vertex normals."""
    return document.accessor(np.asarray(Normals(faces, len(points)).of(points), dtype="<f4"), target=ARRAY_BUFFER)


def matter(name: str, colour: list[float]) -> dict[str, Any]:
    """A material."""
    return {"name": name, "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS[name]}}


def linear(value: int) -> float:
    """An 8-bit sRGB value as linear light, which glTF asks for in factors and vertex colours."""
    v = value / 255.0
    return v / 12.92 if v <= 0.04045 else float(((v + 0.055) / 1.055) ** 2.4)


def write_glb(story: Story, out: Path, fps: float = FPS) -> None:
    """Write the file of a story, whole or not at all."""
    with whole_file(out) as temporary:
        temporary.write_bytes(glb(story, fps))
