"""Animated glTF, read back by another library and skinned here as its specification says."""

import numpy as np
import pytest

import handlab as hl
from handlab.show.gltf import TOLERANCE
from handlab.simulation.kinematics import posed_bone
from handlab.simulation.skin import blend, fine_points

pygltflib = pytest.importorskip("pygltflib")
KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
SINGLE = 2e-7  # metres: float32 at a hand's size, through a quaternion


class Reader:
    """A file as a viewer sees it."""

    def __init__(self, path):
        self.file = pygltflib.GLTF2().load(str(path))
        self.block = self.file.binary_blob()

    def array(self, number):
        entry = self.file.accessors[number]
        view = self.file.bufferViews[entry.bufferView]
        values = np.frombuffer(
            self.block, KINDS[entry.componentType], entry.count * WIDTHS[entry.type], view.byteOffset + (entry.byteOffset or 0)
        )
        return values.reshape(entry.count, -1).astype(float) if WIDTHS[entry.type] > 1 else values.astype(float)

    def node(self, name):
        return next(k for k, node in enumerate(self.file.nodes) if node.name == name)

    def track(self, node, path):
        """Times and values of what moves a node, or None."""
        for animation in self.file.animations:
            for channel in animation.channels:
                if channel.target.node == node and channel.target.path == path:
                    sampler = animation.samplers[channel.sampler]
                    assert sampler.interpolation == "LINEAR"
                    return self.array(sampler.input), self.array(sampler.output)
        return None

    def at(self, node, path, frame, default):
        found = self.track(node, path)
        stored = getattr(self.file.nodes[node], path, None)
        return np.array(default if stored is None else stored, float) if found is None else found[1][frame]

    def local(self, node, frame):
        x, y, z, w = self.at(node, "rotation", frame, [0, 0, 0, 1])
        out = np.eye(4)
        out[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        out[:3, 3] = self.at(node, "translation", frame, [0, 0, 0])
        return out

    def world(self, node, frame):
        parent = next((k for k, other in enumerate(self.file.nodes) if node in (other.children or [])), None)
        return self.local(node, frame) if parent is None else self.world(parent, frame) @ self.local(node, frame)

    def mesh(self, name, frame):
        """Points in the scene at a frame: morph targets, then skin or node."""
        number = self.node(name)
        node = self.file.nodes[number]
        mesh = self.file.meshes[node.mesh]
        primitive = mesh.primitives[0]
        points = self.array(primitive.attributes.POSITION).copy()
        if primitive.targets:
            weights = self.track(number, "weights")
            weights = np.array(mesh.weights) if weights is None else weights[1].reshape(-1, len(primitive.targets))[frame]
            for weight, target in zip(weights, primitive.targets, strict=True):
                points += weight * self.array(target["POSITION"] if isinstance(target, dict) else target.POSITION)
        homogeneous = np.c_[points, np.ones(len(points))]
        if node.skin is None:
            return (homogeneous @ self.world(number, frame).T)[:, :3]
        skin = self.file.skins[node.skin]
        assert skin.inverseBindMatrices is None
        motion = np.stack([self.world(joint, frame) for joint in skin.joints])
        bodies, share = self.array(primitive.attributes.JOINTS_0).astype(int), self.array(primitive.attributes.WEIGHTS_0)
        assert np.abs(share.sum(axis=1) - 1).max() < 1e-6
        return np.einsum("nk,nkij,nj->ni", share, motion[bodies], homogeneous)[:, :3]


def upright(points):
    """Our frame in the file's: distal up, palm to the viewer."""
    return points[:, [2, 0, 1]]


@pytest.fixture(scope="module")
def fist(hand):
    return hl.simulate(hand, "fist")


@pytest.fixture(scope="module")
def written(fist, tmp_path_factory):
    return Reader(hl.save(fist, tmp_path_factory.mktemp("gltf") / "fist.glb"))


def test_skin_and_bones_are_where_the_clip_has_them_at_ten_times(written, fist, hand):
    time = written.track(written.file.skins[0].joints[hand.body_names.index("distal_phalanx_2")], "rotation")[0]
    assert time[0] == 0.0
    assert time[-1] == pytest.approx(fist.time[-1])
    moved = 0.0
    for frame in np.linspace(0, len(time) - 1, 10).round().astype(int):
        k = int(np.argmin(np.abs(fist.time - time[frame])))
        assert fist.time[k] == pytest.approx(time[frame], abs=1e-6)  # a frame of the clip itself
        for name in ("scaphoid", "metacarpal_5", "distal_phalanx_1", "distal_phalanx_2"):
            here = bone_points(written, name, frame)
            assert np.abs(here - upright(posed_bone(hand, name, fist.angle[k]))).max() < SINGLE
        skin = upright(fine_points(hand, blend(hand, fist.angle[k])))
        error = np.linalg.norm(written.mesh("skin", frame) - skin, axis=1)
        assert error.max() < 1.1 * TOLERANCE
        moved = max(moved, np.linalg.norm(skin - upright(hand.skin_fine.points), axis=1).max())
    assert moved > 0.05


def bone_points(reader, name, frame):
    """Bones and bodies may share a name: the one with a mesh is meant."""
    number = next(k for k, node in enumerate(reader.file.nodes) if node.name == name and node.mesh is not None)
    points = reader.array(reader.file.meshes[reader.file.nodes[number].mesh].primitives[0].attributes.POSITION)
    return (np.c_[points, np.ones(len(points))] @ reader.world(number, frame).T)[:, :3]


def test_without_the_corrective_shapes_the_skin_would_be_millimetres_off(written, fist, hand):
    last = len(fist.time) - 1
    time = written.track(written.file.skins[0].joints[7], "rotation")[0]
    primitive = written.file.meshes[written.file.nodes[written.node("skin")].mesh].primitives[0]
    kept, primitive.targets = primitive.targets, []
    try:
        bare = written.mesh("skin", len(time) - 1)
    finally:
        primitive.targets = kept
    wanted = upright(fine_points(hand, blend(hand, fist.angle[last])))
    assert 1e-3 < np.linalg.norm(bare - wanted, axis=1).max() < 2e-2


def test_the_file_is_one_that_trimesh_reads_too(fist, tmp_path, hand):
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.load(hl.save(fist, tmp_path / "fist.glb"))
    assert {"skin", "scaphoid"} <= set(scene.geometry)
    assert sum(len(mesh.faces) for mesh in scene.geometry.values()) == len(hand.skin_fine.faces) + sum(
        len(b.faces) for b in hand.bones.values()
    )


def test_quaternions_have_unit_length_and_never_jump_to_the_other_side(written):
    for joint in written.file.skins[0].joints:
        found = written.track(joint, "rotation")
        if found is not None:
            assert np.abs(np.linalg.norm(found[1], axis=1) - 1).max() < 1e-6
            assert (np.einsum("ti,ti->t", found[1][1:], found[1][:-1]) > 0.5).all()


def test_every_array_of_the_file_lies_on_four_bytes_and_inside_the_block(written):
    for view in written.file.bufferViews:
        assert view.byteOffset % 4 == 0
        assert view.byteOffset + view.byteLength <= written.file.buffers[0].byteLength
    for mesh in written.file.meshes:
        bounds = written.file.accessors[mesh.primitives[0].attributes.POSITION]
        points = written.array(mesh.primitives[0].attributes.POSITION)
        assert np.allclose(bounds.min, points.min(axis=0))
        assert np.allclose(bounds.max, points.max(axis=0))


def test_a_pose_is_a_file_that_does_not_move(hand, tmp_path):
    state = hl.pose(hand, {"mcp2.flexion_extension": 1.2, "pip2.flexion_extension": 1.3})
    still = Reader(hl.save(state, tmp_path / "pose.glb", hand=hand))
    assert not still.file.animations
    error = np.linalg.norm(still.mesh("skin", 0) - upright(fine_points(hand, state.skin)), axis=1)
    assert error.max() < 1.1 * TOLERANCE
    assert np.abs(bone_points(still, "distal_phalanx_2", 0) - upright(posed_bone(hand, "distal_phalanx_2", state.angle))).max() < SINGLE


def test_a_left_hand_is_written_as_a_left_hand(tmp_path):
    left = hl.load_hand(side="left")
    thumb = bone_points(Reader(hl.save(left, tmp_path / "left.glb")), "distal_phalanx_1", 0)
    assert thumb[:, 0].mean() < -0.01
