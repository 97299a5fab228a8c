"""Ellipsoids of the geometric muscles: the compiled kernel against a readable one, volume, bounds, layers."""

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import load_grids
from handlab.anatomy.terms import UnknownName
from handlab.physics import bulge
from handlab.simulation.geometric_muscle import OVERLAP, ellipsoids, geometric_muscles, muscles_of, shape
from handlab.simulation.kinematics import relative_transforms

HYPOTHENAR = ("abductor_digiti_minimi", "flexor_digiti_minimi_brevis", "opponens_digiti_minimi")


@pytest.fixture(scope="module")
def muscles(hand):
    return geometric_muscles(hand)


@pytest.fixture(scope="module")
def postures(hand):
    """Angles (dof,) from named clips, the ends of the ranges, and random ones in between."""
    rng = np.random.default_rng(5)
    low, high = hand.limits.T
    found = [hl.simulate(hand, hl.keyframes(name)).angle[-1] for name in ("fist", "key-pinch", "spread")]
    return [hand.bind, *found, *(rng.uniform(low, high) for _ in range(6))]


def volume(muscles, shapes):
    return np.array([bulge.ellipsoid_volume(shapes.half[part]).sum() for part in muscles.segments])


def readable(muscles, transforms, contraction):
    """Centres, axes and half-axes of every fibre with the plain functions of ``physics.bulge``, both ends on bone."""
    c = muscles.chains
    for f, (start, count) in enumerate(zip(c.first_node, c.nodes, strict=True)):
        nodes, parts = slice(start, start + count), slice(start - f, start - f + count - 1)
        blend = np.einsum("nk,nkij->nij", c.share[nodes], transforms[c.body[nodes]])
        points = np.einsum("nij,nj->ni", blend[:, :3, :3], c.point[nodes]) + blend[:, :3, 3]
        active = max(contraction[row] for row in c.drive[c.grid[f]] if row >= 0)
        share = bulge.shares(c.length[parts], active)
        corners = bulge.on_line(points, np.concatenate([[0.0], np.cumsum(share)]))
        step = np.diff(corners, axis=0)
        length = np.linalg.norm(step, axis=1)
        rest = c.length[parts] * c.width[parts] * c.height[parts]
        area = bulge.volumes(c.length[parts], rest, active) / rest * c.length[parts] / length
        confined = c.confined[parts] == 1
        tall = np.clip(np.where(confined, area, np.sqrt(area)) * c.height[parts], c.low[parts], c.high[parts])
        wide = c.width[parts] * c.height[parts] * area / tall
        yield parts, step / length[:, None], np.stack([0.5 * OVERLAP * length, wide, tall], axis=1), (corners[1:] + corners[:-1]) / 2


def test_the_kernel_agrees_with_the_readable_one(hand, muscles, postures, rng):
    for angle in postures:
        transforms, contraction = relative_transforms(hand, angle), rng.uniform(0.0, 1.0, len(hand.muscles))
        found = shape(muscles, transforms, contraction)
        for parts, along, half, middle in readable(muscles, transforms, contraction):
            np.testing.assert_allclose(found.frame[parts, :, 0], along, atol=1e-9)
            np.testing.assert_allclose(found.half[parts], half, rtol=1e-9, atol=1e-12)
            lift = half[:, 2] - muscles.chains.height[parts]
            expected = middle + lift[:, None] * found.frame[parts, :, 2]
            np.testing.assert_allclose(found.centre[parts], expected, atol=1e-9)


def test_in_the_bind_posture_at_rest_every_ellipsoid_is_as_it_was_fitted(hand, muscles):
    found = ellipsoids(hand, hand.bind)
    chains = muscles.chains
    np.testing.assert_allclose(found.half[:, 0], 0.5 * OVERLAP * chains.length, rtol=1e-6)
    np.testing.assert_allclose(found.half[:, 1], chains.width, rtol=1e-6)
    np.testing.assert_allclose(found.half[:, 2], chains.height, rtol=1e-6)


def test_frames_are_rotations(hand, muscles, postures, rng):
    for angle in postures:
        frame = shape(muscles, relative_transforms(hand, angle), rng.uniform(0, 1, len(hand.muscles))).frame
        np.testing.assert_allclose(np.einsum("sij,sik->sjk", frame, frame), np.tile(np.eye(3), (len(frame), 1, 1)), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(frame), 1.0, atol=1e-9)


def test_the_outward_axis_points_to_the_skin(hand, muscles):
    for g, part in enumerate(muscles.segments):
        mean = muscles.fitted[g].outward.mean(axis=0)  # of every fibre
        for k in range(muscles.fibres[g]):
            count = (part.stop - part.start) // muscles.fibres[g]
            ways = muscles.rest.frame[part.start + k * count : part.start + (k + 1) * count, :, 2]
            assert (ways @ mean[k] > 0.0).mean() > 0.8, muscles.names[g]


@pytest.mark.parametrize("ratio", np.linspace(0.6, 1.2, 7))
@pytest.mark.parametrize("contraction", [0.0, 0.5, 1.0])
def test_the_volume_of_every_muscle_stays_between_0_6_and_1_2_of_rest_length(hand, muscles, ratio, contraction):
    squeezed = np.tile(np.diag([ratio, ratio, ratio, 1.0]), (len(hand.body_names), 1, 1))
    found = shape(muscles, squeezed, np.full(len(hand.muscles), contraction))
    np.testing.assert_allclose(volume(muscles, found) / volume(muscles, muscles.rest), 1.0, atol=1e-9)


def test_the_volume_of_every_muscle_stays_in_every_posture(hand, muscles, postures):
    for angle in postures:
        for contraction in (0.0, 1.0):
            found = shape(muscles, relative_transforms(hand, angle), np.full(len(hand.muscles), contraction))
            np.testing.assert_allclose(volume(muscles, found) / volume(muscles, muscles.rest), 1.0, atol=0.02)


def test_thickness_keeps_its_bounds_and_reaches_them(hand, muscles):
    low, high = 2e3 * muscles.chains.low, 2e3 * muscles.chains.high
    at_low, at_high = False, False
    for ratio in (0.3, 0.6, 1.0, 1.5, 3.0):
        transforms = np.tile(np.diag([ratio, ratio, ratio, 1.0]), (len(hand.body_names), 1, 1))
        for law in ("volume", "recalled"):
            thick = 2e3 * shape(muscles, transforms, np.full(len(hand.muscles), 1.0), law=law).half[:, 2]
            assert np.all((thick >= low - 1e-9) & (thick <= high + 1e-9))
            at_low, at_high = at_low or bool(np.any(thick < low + 1e-9)), at_high or bool(np.any(thick > high - 1e-9))
    assert at_low
    assert at_high


def test_contraction_swells_the_belly_and_thins_the_ends(hand, muscles):
    resting, pulling = ellipsoids(hand, hand.bind), ellipsoids(hand, hand.bind, np.ones(len(hand.muscles)))
    for g, name in enumerate(muscles.names):
        part, fibres = muscles.segments[g], muscles.fibres[g]
        area = (pulling.half[part, 1] * pulling.half[part, 2]) / (resting.half[part, 1] * resting.half[part, 2])
        area = area.reshape(fibres, -1).mean(axis=0)
        middle = area[len(area) // 2]
        assert 1.1 < middle < 1.8, name
        assert min(area[0], area[-1]) < 0.8, name


def test_both_ends_stay_on_their_bones_when_a_muscle_contracts(hand, muscles):
    """Bone to bone: contraction alone moves no end; what swells, swells away from the bone."""
    resting, pulling = ellipsoids(hand, hand.bind), ellipsoids(hand, hand.bind, np.ones(len(hand.muscles)))
    for g, part in enumerate(muscles.segments):
        for k in range(muscles.fibres[g]):
            count = (part.stop - part.start) // muscles.fibres[g]
            lengths = []
            for shapes in (resting, pulling):
                fibre = slice(part.start + k * count, part.start + (k + 1) * count)
                lengths.append(2 * shapes.half[fibre, 0].sum() / OVERLAP)
            assert lengths[1] == pytest.approx(lengths[0], rel=0.03)  # chords of a curved line


def test_the_first_dorsal_interosseous_rises_in_the_web(hand, muscles):
    """Its upper side, seen along the outward axis, in a key pinch, against the same pose with the muscle off."""
    angle = hl.simulate(hand, hl.keyframes("key-pinch")).angle[-1]
    on = np.zeros(len(hand.muscles))
    on[hand.muscle_names.index("dorsal_interosseus_1")] = 1.0
    off, pulled = ellipsoids(hand, angle), ellipsoids(hand, angle, on)
    part = muscles.of("dorsal_interosseus_1_thumb_head")
    rise = np.einsum("sd,sd->s", (pulled.centre - off.centre)[part], off.frame[part, :, 2]) + (pulled.half - off.half)[part, 2]
    assert 2.5e-3 < rise.max() < 6e-3
    again = ellipsoids(hand, angle)
    np.testing.assert_array_equal(again.centre, off.centre)


def test_one_layer_moves_and_those_below_do_not(hand, muscles):
    """Abductor digiti minimi over flexor and opponens (Figure 2 right): no springs between muscles."""
    on = np.zeros(len(hand.muscles))
    on[hand.muscle_names.index("abductor_digiti_minimi")] = 1.0
    resting, pulling = ellipsoids(hand, hand.bind), ellipsoids(hand, hand.bind, on)
    moved = np.abs(pulling.centre - resting.centre).max(axis=1) + np.abs(pulling.half - resting.half).max(axis=1)
    for name in muscles.names:
        change = moved[muscles.of(name)].max()
        if name == HYPOTHENAR[0]:
            assert change > 3e-4
        else:
            assert change == 0.0, name


def test_the_abductor_lies_over_the_two_others_at_the_edge_of_the_palm(hand, muscles):
    """Its ellipsoids lie nearer to the skin than those of flexor and opponens."""
    from handlab.physics.distance import closest

    skin = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    depth = [closest(muscles.rest.centre[muscles.of(name)], skin)[0][2:-2].mean() for name in HYPOTHENAR]
    assert depth[0] + 1e-3 < min(depth[1:])


def test_one_contraction_drives_both_heads(hand, muscles):
    row = hand.muscle_names.index("adductor_pollicis")
    on = np.zeros(len(hand.muscles))
    on[row] = 1.0
    resting, pulling = ellipsoids(hand, hand.bind), ellipsoids(hand, hand.bind, on)
    for name in ("adductor_pollicis_oblique", "adductor_pollicis_transverse"):
        part = muscles.of(name)
        assert np.abs(pulling.half[part] - resting.half[part]).max() > 2e-4


def test_several_drives_count_with_the_largest(hand):
    import dataclasses

    grid = dataclasses.replace(load_grids()[0], drives=("FDP2", "EDC2"))
    both = muscles_of(hand, [grid])
    assert both.drives == (("flexor_digitorum_profundus_index", "extensor_digitorum_index"),)
    transforms, base = relative_transforms(hand, hand.bind), np.zeros(len(hand.muscles))
    values = []
    for fdp, edc in ((0.2, 0.7), (0.7, 0.2), (0.7, 0.7), (0.2, 0.2)):
        base[hand.muscle_names.index("flexor_digitorum_profundus_index")] = fdp
        base[hand.muscle_names.index("extensor_digitorum_index")] = edc
        values.append(shape(both, transforms, base).half)
    np.testing.assert_array_equal(values[0], values[1])
    np.testing.assert_array_equal(values[0], values[2])
    assert np.abs(values[0] - values[3]).max() > 1e-4


def test_the_recalled_law_thickens_by_1_plus_2_times_what_is_lost_and_keeps_no_volume(hand, muscles):
    ratio = 0.8
    squeezed = np.tile(np.diag([ratio, ratio, ratio, 1.0]), (len(hand.body_names), 1, 1))
    found = shape(muscles, squeezed, np.zeros(len(hand.muscles)), law="recalled")
    free = 1.4 * muscles.chains.height < muscles.chains.high
    assert free.mean() > 0.5
    np.testing.assert_allclose(found.half[free, 2] / muscles.chains.height[free], 1.4, rtol=1e-6)
    np.testing.assert_allclose(found.half[:, 1], muscles.chains.width, rtol=1e-6)
    assert np.any(volume(muscles, found) / volume(muscles, muscles.rest) > 1.05)


def test_a_muscle_whose_end_hangs_on_no_bone_shortens_towards_its_origin(hand):
    import dataclasses

    grid = next(grid for grid in load_grids() if grid.name == "flexor_digiti_minimi_brevis")
    free = muscles_of(hand, [dataclasses.replace(grid, on_bone=(True, False))])
    transforms = relative_transforms(hand, hand.bind)
    for law, kept in (("volume", 1.0 - bulge.FREE_SHORTENING), ("recalled", 0.5)):
        amount = 1.0 if law == "volume" else 0.5
        rest = 2 * free.rest.half[:, 0].sum() / OVERLAP
        found = shape(free, transforms, np.full(len(hand.muscles), amount), law=law)
        assert 2 * found.half[:, 0].sum() / OVERLAP == pytest.approx(kept * rest, rel=0.03)
    assert volume(free, shape(free, transforms, np.ones(len(hand.muscles))))[0] == pytest.approx(volume(free, free.rest)[0], rel=1e-9)


def test_segments_ride_on_their_bones(hand, muscles):
    """Bending the little finger moves the end of its abductor with the phalanx and leaves the origin on the pisiform."""
    angle = hand.bind.copy()
    angle[hand.dof_names.index("mcp5.flexion_extension")] += 0.8
    before, after = ellipsoids(hand, hand.bind), ellipsoids(hand, angle)
    part = muscles.of("abductor_digiti_minimi")
    count = (part.stop - part.start) // 2
    moved = np.linalg.norm(after.centre - before.centre, axis=1)[part].reshape(2, count)
    assert moved[:, 0].max() < 1e-3
    assert moved[:, -1].min() > 1.5e-3
    for other in ("opponens_pollicis", "dorsal_interosseus_2"):
        np.testing.assert_array_equal(after.centre[muscles.of(other)], before.centre[muscles.of(other)])


def test_the_left_hand_has_the_mirrored_muscles(hand, muscles):
    left = hl.load_hand(side="left")
    other = geometric_muscles(left)
    flip = np.array([1.0, 1.0, -1.0])
    np.testing.assert_allclose(other.rest.centre, muscles.rest.centre * flip, atol=1e-9)
    np.testing.assert_allclose(other.rest.half, muscles.rest.half, atol=1e-9)
    np.testing.assert_allclose(other.rest.frame[:, :, 0], muscles.rest.frame[:, :, 0] * flip, atol=1e-9)
    np.testing.assert_allclose(other.rest.frame[:, :, 2], muscles.rest.frame[:, :, 2] * flip, atol=1e-9)


def test_unknown_names_and_wrong_arrays_are_answered(hand, muscles):
    transforms = relative_transforms(hand, hand.bind)
    with pytest.raises(UnknownName, match="opponens_pollicis"):
        muscles.of("opponens_polici")
    with pytest.raises(ValueError, match="one value for every pseudo muscle"):
        shape(muscles, transforms, np.zeros(3))
    with pytest.raises(ValueError, match="choose 'volume'"):
        shape(muscles, transforms, np.zeros(len(hand.muscles)), law="linear")
    with pytest.raises(ValueError, match="own name"):
        muscles_of(hand, [load_grids()[0]] * 2)
