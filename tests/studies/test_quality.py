"""The table of promises: all kept by the reference hand, each broken by a hand that breaks it, and the same in the mirror."""

from dataclasses import replace

import numpy as np
import pytest

import handlab
from handlab.anatomy.records import frozen
from handlab.studies import quality as module
from handlab.studies import surfaces, tissue
from handlab.studies.places import joint_place
from handlab.studies.quality import quality

MM = 1e-3


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


@pytest.fixture(scope="module")
def table(hand):
    return quality(hand)


def named(rows, start):
    return next(row for row in rows if row.what.startswith(start))


def with_bone(hand, name, change):
    bone = hand.bones[name]
    return hand.with_(bones=hand.bones.with_items({**hand.bones, name: change(bone)}))


def moved(by):
    return lambda bone: replace(bone, points=frozen(bone.points + by))


def turned(mesh):
    return replace(mesh, faces=frozen(mesh.faces[:, ::-1], np.int64))


# ---------------------------------------------------------------- the reference hand


def test_the_reference_hand_keeps_every_promise(table):
    assert not [f"{row.what}: {row.measured}; wanted: {row.wanted}" for row in table if not row.ok]


def test_the_table_has_a_line_for_every_promise_and_says_what_was_found(table):
    assert len(table) == len({row.what for row in table}) >= 20
    for row in table:
        assert row.measured
        assert row.wanted
        assert isinstance(row.ok, bool)


def test_the_left_hand_measures_the_same(table):
    left = quality(handlab.load_hand(side="left"))
    for here, there in zip(table, left, strict=True):
        if here.what != "a hand loads in":
            assert here == there


# ---------------------------------------------------------------- surfaces


def tetrahedron(points=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))):
    from handlab.anatomy.records import Mesh

    return Mesh(frozen(points), frozen([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int64))


def test_a_good_mesh_has_no_faults():
    assert surfaces.faults(tetrahedron()) == ()


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda m: replace(m, faces=m.faces[:-1]), "3 open edges"),
        (lambda m: replace(m, faces=np.vstack([m.faces, m.faces[:1]])), "3 edges with more than two triangles"),
        (lambda m: replace(m, faces=np.vstack([m.faces[:-1], m.faces[-1:, ::-1]])), "3 edges between triangles of opposite orientation"),
        (lambda m: replace(m, points=np.vstack([m.points, [[5, 5, 5]]])), "points without triangle"),
        (turned, "triangles face inwards"),
        (
            lambda m: replace(
                m, points=np.vstack([m.points, -m.points[1:]]), faces=np.vstack([m.faces, np.array([0, 4, 5, 6])[m.faces][:, ::-1]])
            ),
            "1 points at which parts merely touch",
        ),
        (lambda m: replace(m, points=np.vstack([m.points, m.points + 3]), faces=np.vstack([m.faces, m.faces + 4])), "2 pieces"),
    ],
)
def test_each_fault_of_a_mesh_is_named(change, fault):
    assert fault in surfaces.faults(change(tetrahedron()))


def test_a_tunnel_through_a_mesh_is_found():
    import pyvista as pv

    from handlab.anatomy.records import Mesh

    torus = pv.ParametricTorus(u_res=20, v_res=12, w_res=2).triangulate().clean()
    torus = torus.compute_normals(auto_orient_normals=True, consistent_normals=True, split_vertices=False)
    assert surfaces.faults(Mesh(np.asarray(torus.points, float), torus.faces.reshape(-1, 4)[:, 1:])) == ("1 tunnels through it",)


def test_lengths_of_edges_are_counted_once():
    np.testing.assert_allclose(np.sort(surfaces.edge_lengths(tetrahedron())), [1, 1, 1, *[np.sqrt(2)] * 3])


# ---------------------------------------------------------------- each promise can be broken


def test_an_open_skin_and_a_turned_bone_are_found(hand):
    open_skin = hand.with_(skin=replace(hand.skin, faces=frozen(hand.skin.faces[1:], np.int64)))
    row = named(module._skins(open_skin), "both skins closed")
    assert not row.ok
    assert "even: 3 open edges" in row.measured
    row = named(module._bones(with_bone(hand, "lunate", turned)), "closed bones")
    assert not row.ok
    assert "lunate: triangles face inwards" in row.measured


def test_skin_pushed_through_itself_is_found(hand):
    points = np.array(hand.skin.points)
    points[hand.feature_points["tip_middle"]["palmar"]] -= [0.03, 0.0, 0.0004]
    assert not named(module._skins(hand.with_(skin=replace(hand.skin, points=frozen(points)))), "triangles that cross").ok


def test_an_uneven_skin_and_one_that_left_its_binding_are_found(hand):
    points = np.array(hand.skin.points)
    points += 0.0012 * np.sin(4000 * points)
    rows = tuple(module._skins(hand.with_(skin=replace(hand.skin, points=frozen(points)))))
    assert not named(rows, "fine skin from its binding").ok
    stretched = hand.with_(skin=replace(hand.skin, points=frozen(hand.skin.points * [1, 1, 2.2])))
    assert not named(module._skins(stretched), "edges of the even skin").ok


def test_texture_outside_the_picture_or_drawn_over_is_found(hand):
    outside = hand.with_(skin_fine=replace(hand.skin_fine, texture=frozen(hand.skin_fine.texture * 1.1)))
    assert not named(module._texture(outside), "texture coordinates").ok
    texture = np.array(hand.skin_fine.texture)
    texture[10] = texture[500] + 1e-4
    double = named(module._texture(hand.with_(skin_fine=replace(hand.skin_fine, texture=frozen(texture)))), "triangles that overlap")
    assert not double.ok
    assert int(double.measured) >= 2


def test_weights_that_do_not_add_to_1_are_found(hand):
    assert not named(module._weights(hand.with_(skin=replace(hand.skin, weights=frozen(0.999 * hand.skin.weights)))), "blend weights").ok
    short = hand.with_(feature_points=hand.feature_points.with_items(dict(list(hand.feature_points.items())[1:])))
    assert not named(module._weights(short), "feature points").ok


def test_a_bone_that_leaves_the_skin_is_named(hand):
    row = named(module._bones(with_bone(hand, "proximal_phalanx_3", moved([0, -6 * MM, 0]))), "least depth")
    assert not row.ok
    assert row.measured.startswith("-")
    assert "proximal_phalanx_3" in row.measured


def test_a_bone_that_leaves_the_fine_skin_alone_is_named(hand):
    shallow = hand.with_(skin_fine=replace(hand.skin_fine, points=frozen(hand.skin_fine.points + np.array([0, 2.5 * MM, 0]))))
    row = named(module._bones(shallow), "least depth")
    assert not row.ok
    assert not row.measured.startswith("-")
    assert "fine skin -" in row.measured


def test_a_bone_of_the_wrong_length_is_named(hand):
    long = with_bone(hand, "metacarpal_3", lambda bone: replace(bone, points=frozen(bone.points * [1.25, 1, 1])))
    row = named(module._bones(long), "bone lengths")
    assert not row.ok
    assert "metacarpal_3" in row.measured


@pytest.mark.parametrize(("by", "text"), [(3 * MM, "pip2 3."), (-2 * MM, "pip2 -")])
def test_a_joint_that_gapes_or_overlaps_is_named(hand, by, text):
    along = joint_place(hand, "pip2").distal
    row = named(module._joints(with_bone(hand, "middle_phalanx_2", moved(by * along))), "joint gaps")
    assert not row.ok
    assert text in row.measured


def test_bones_that_slid_off_their_joint_are_found(hand):
    along = joint_place(hand, "pip2").distal
    slid = hand
    for name in ("proximal_phalanx_2", "middle_phalanx_2"):
        slid = with_bone(slid, name, moved(5 * MM * along))
    assert not named(module._joints(slid), "finger joints' centres").ok
    along = joint_place(hand, "cmc3").distal
    slid = hand
    for name in ("capitate", "metacarpal_3"):
        slid = with_bone(slid, name, moved(6 * MM * along))
    row = named(module._joints(slid), "CMC joints' centres")
    assert not row.ok
    assert "cmc3" in row.measured


def test_skin_that_slid_along_a_finger_is_found_by_its_creases(hand):
    fine = hand.with_(skin_fine=replace(hand.skin_fine, points=frozen(hand.skin_fine.points - 4 * MM * joint_place(hand, "pip3").distal)))
    assert tissue.crease(fine, "pip3") - tissue.crease(hand, "pip3") == pytest.approx(-4 * MM, abs=0.3 * MM)
    row = named(module._joints(fine), "palmar creases")
    assert not row.ok
    assert "pip3" in row.measured


def test_a_finger_without_crease_is_named(hand, monkeypatch):
    monkeypatch.setattr(tissue, "palmar_profile", lambda *_: (np.linspace(-0.012, 0.012, 97), np.full(97, 0.008)))
    row = named(module._joints(hand), "palmar creases")
    assert not row.ok
    assert "no crease at ip1, pip2, dip2" in row.measured


@pytest.mark.parametrize("by", [-4 * MM, 4 * MM])
def test_knuckles_and_pulps_too_deep_or_too_shallow_are_named(hand, by):
    row = named(module._tissue(with_bone(hand, "metacarpal_2", moved([0, by, 0]))), "tissue over the knuckles")
    assert not row.ok
    assert "index" in row.measured.split("on top")[1]
    row = named(module._tissue(with_bone(hand, "distal_phalanx_4", moved([0, by, 0]))), "pulp")
    assert not row.ok
    assert "ring" in row.measured


def test_a_hand_of_lead_is_found(hand):
    heavy = hand.with_(bodies=hand.bodies.with_items({name: replace(body, mass=10 * body.mass) for name, body in hand.bodies.items()}))
    assert not named(module._mass(heavy), "mass").ok


# ---------------------------------------------------------------- measures


def test_soft_tissue_is_as_thick_as_a_bone_is_moved(hand):
    place = joint_place(hand, "dip3")
    thinner = with_bone(hand, "distal_phalanx_3", moved(1 * MM * place.palmar))
    assert tissue.pulp_thickness(hand, 3) - tissue.pulp_thickness(thinner, 3) == pytest.approx(1 * MM, abs=0.15 * MM)
    knuckle = joint_place(hand, "mcp3")
    deeper = with_bone(hand, "metacarpal_3", moved(0.5 * MM * knuckle.palmar))
    for here, there in zip(tissue.knuckle_tissue(hand, 3), tissue.knuckle_tissue(deeper, 3), strict=True):
        assert there - here == pytest.approx(0.5 * MM, abs=0.25 * MM)


def test_a_gap_widens_by_as_much_as_a_bone_is_moved(hand):
    place = joint_place(hand, "dip2")
    apart = with_bone(hand, "distal_phalanx_2", moved(1 * MM * place.distal))
    assert tissue.joint_gap(apart, "dip2")[0] - tissue.joint_gap(hand, "dip2")[0] == pytest.approx(1 * MM, abs=0.25 * MM)
    assert tissue.gap_ahead(apart, "dip2") - tissue.gap_ahead(hand, "dip2") == pytest.approx(0.5 * MM, abs=0.25 * MM)


def test_places_of_joints_point_distal_and_palmar(hand):
    for side in (hand, handlab.load_hand(side="left")):
        for name in ("wrist", "mcp3", "pip3", "dip3"):
            place = joint_place(side, name)
            assert place.distal[0] > 0.85
            assert place.palmar[1] > 0.7
            assert abs(place.distal @ place.flexion) < 1e-9
    for name in ("mcp2", "pip4", "ip1"):
        right, left = joint_place(hand, name), joint_place(handlab.load_hand(side="left"), name)
        np.testing.assert_allclose(left.centre, right.centre * [1, 1, -1], atol=1e-12)
        np.testing.assert_allclose(left.palmar, right.palmar * [1, 1, -1], atol=1e-12)


def test_lengths_of_bones_are_read_once_and_broken_files_are_named(tmp_path, monkeypatch):
    from handlab.anatomy import bone_lengths, data

    assert bone_lengths.bone_lengths_mm()[1] == {"metacarpal": 46.22, "proximal_phalanx": 31.57, "distal_phalanx": 21.67, "pulp": 5.67}
    text = (data.folder() / bone_lengths.FILE).read_text()
    assert "Buryanov" in bone_lengths.source()
    (tmp_path / "anatomy").mkdir()
    monkeypatch.setattr(data, "folder", lambda: tmp_path)
    for broken, what in (
        (text.replace("39.78", "long"), r"line 4: .*long"),
        (text.replace("39.78", "-3"), "not a length"),
        (text.replace("39.78", "nan"), "not a length"),
        (text.replace("index", "pointer"), "line 4: .*pointer"),
        (text.replace("metacarpal,", "shaft,"), "line 2: the columns are"),
        (text.rsplit("\n", 2)[0], "one line for each"),
        (text.replace("3.84", "3.84,9"), "line 4"),
    ):
        (tmp_path / bone_lengths.FILE).write_text(broken)
        with pytest.raises(ValueError, match=what):
            bone_lengths.bone_lengths_mm.__wrapped__()
