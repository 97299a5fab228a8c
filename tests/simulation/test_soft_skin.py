import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.records import Mesh
from handlab.physics import springs
from handlab.physics.distance import closest, winding
from handlab.simulation import soft_hold_kernel, soft_limits
from handlab.simulation import soft_skin_kernel as kernel
from handlab.simulation.bone_field import bone_field
from handlab.simulation.geometric_muscle import geometric_muscles
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.play import simulate
from handlab.simulation.skin import blend
from handlab.simulation.soft_anchors import anchors, below
from handlab.simulation.soft_frame import AT_ONCE, ahead, at_bind, begin, first_frame, follow, frame, frames
from handlab.simulation.soft_look_kernel import beside, lacking, near_bone, touched
from handlab.simulation.soft_skin import PAIR_REST, soft_skin
from handlab.simulation.surface_graph import edges_of

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tools

from tools import soak

FRAME = 1 / 60


@pytest.fixture(scope="module")
def network(hand):
    return soft_skin(hand)


@pytest.fixture(scope="module")
def judge(hand, network):
    return soak.Judge(hand, network)


def forces(network, x, centre, arm):
    """Forces (n, 3) of all springs, from the plain laws."""
    i, j = network.first.astype(int), network.second.astype(int)
    way = x[j] - x[i]
    length = np.linalg.norm(way, axis=1)
    strain = 1 - network.rest / length
    pull = (network.stiffness * np.where(strain > 0, strain, network.slack * strain))[:, None] * way
    total = springs.mirrored_pair(x, centre, arm, network.hold, PAIR_REST * np.linalg.norm(arm, axis=1))
    np.add.at(total, i, pull)
    np.add.at(total, j, -pull)
    return total


def run(network, x, v, centre, arm, dt, steps, hold=None, damping=0.0, slack=None, rest=None):
    block, x, v = np.empty((10, len(x))), np.ascontiguousarray(x.T), np.ascontiguousarray(v.T)
    still = np.ascontiguousarray(centre.T)
    kernel.framed(still, still, np.ascontiguousarray(arm.T), PAIR_REST, block)
    held, slack = network.hold if hold is None else hold, network.slack if slack is None else slack
    relaxed = network.rest if rest is None else rest
    edges = (network.first, network.second, network.stiffness, relaxed)
    kernel.leapfrog(x, v, np.empty_like(x), *edges, slack, block, held, network.inverse_mass, dt, steps, damping)
    return x.T, v.T


def test_the_kernel_computes_the_plain_laws(network, rng):
    x = network.points + rng.normal(0, 2e-4, network.points.shape)
    v = rng.normal(0, 0.01, x.shape)
    dt, damping = 1e-4, 300.0
    moved, speed = run(network, x, v, network.centre, network.arm, dt, 1, damping=damping)
    kept, gained = springs.leapfrog_factors(dt, damping)
    expected = kept * v + gained * forces(network, x, network.centre, network.arm) * network.inverse_mass[:, None]
    np.testing.assert_allclose(speed, expected, atol=1e-10)
    np.testing.assert_allclose(moved, x + dt * expected, atol=1e-14)


def test_in_the_bind_posture_taut_skin_rests_where_it_is(network):
    balance = np.abs(forces(network, network.points, network.centre, network.arm)).max()
    assert balance < 1e-9
    moved, _ = run(network, network.points, np.zeros_like(network.points), network.centre, network.arm, 2e-4, 500, damping=network.damping)
    assert np.abs(moved - network.points).max() < 1e-9


def test_without_anchors_and_damping_the_momentum_of_the_skin_is_kept(network, rng):
    v = rng.normal(0, 0.01, network.points.shape)
    _, speed = run(network, network.points, v, network.centre, network.arm, 2e-4, 2000, hold=np.zeros(len(v)))
    np.testing.assert_allclose(network.mass @ speed, network.mass @ v, atol=1e-15)


def test_over_ten_thousand_steps_the_energy_stays_bounded(network, rng):
    """Full springs, so that energy has a simple form."""
    i, j = network.first.astype(int), network.second.astype(int)
    x, v = network.points + rng.normal(0, 2e-5, network.points.shape), np.zeros_like(network.points)
    below, above = network.centre - network.arm, network.centre + network.arm
    rest, dt = PAIR_REST * np.linalg.norm(network.arm, axis=1), FRAME / network.substeps(FRAME)

    def energy(x, v):
        stretch = np.linalg.norm(x[j] - x[i], axis=1) - network.rest
        pair = sum((np.linalg.norm(x - a, axis=1) - rest) ** 2 for a in (below, above))
        return 0.5 * ((network.stiffness * stretch**2).sum() + (network.hold * pair).sum() + (network.mass * (v**2).sum(axis=1)).sum())

    ground = energy(network.points, np.zeros_like(v))
    found = []
    for _ in range(100):
        x, v = run(network, x, v, network.centre, network.arm, dt, 100, slack=1.0)
        half = v + 0.5 * dt * forces_full(network, x) * network.inverse_mass[:, None]
        found.append(energy(x, half) - ground)
    found = np.array(found)
    assert found.min() > 0.7 * found.mean() and found.max() < 1.3 * found.mean()
    assert found[-20:].mean() == pytest.approx(found[:20].mean(), rel=0.05)


def forces_full(network, x):
    way = x[network.second.astype(int)] - x[network.first.astype(int)]
    pull = (network.stiffness * (1 - network.rest / np.linalg.norm(way, axis=1)))[:, None] * way
    total = springs.mirrored_pair(x, network.centre, network.arm, network.hold, PAIR_REST * np.linalg.norm(network.arm, axis=1))
    np.add.at(total, network.first.astype(int), pull)
    np.add.at(total, network.second.astype(int), -pull)
    return total


@pytest.mark.parametrize(("factor", "stable"), [(0.99, True), (1.01, False)])
def test_the_predicted_step_is_right_within_two_percent(network, rng, factor, stable):
    """A push of a micrometre: it stays one, or it grows."""
    dt = factor * springs.stable_step(network.frequency)
    start = network.points + rng.normal(0, 1e-6, network.points.shape)
    moved, _ = run(network, start, np.zeros_like(start), network.centre, network.arm, dt, 4000, slack=1.0)
    grown = np.abs(moved - network.points).max()
    assert (grown < 2e-5) if stable else not (grown < 1e-3)


def test_twice_the_stiffness_needs_the_root_of_two_more_substeps(hand, network):
    twice = soft_skin(hand, 2 * network.young, tissue=2 * network.tissue)
    assert twice.frequency / network.frequency == pytest.approx(np.sqrt(2), rel=1e-3)


def test_the_order_in_time_is_two(network, rng):
    """Against a run with very small steps; the springs stay taut."""
    start = network.points + rng.normal(0, 1e-6, network.points.shape)
    seconds, counts = 2e-3, np.array([10, 20, 40])

    def end(n):
        dt = seconds / n
        v = -0.5 * dt * forces_full(network, start) * network.inverse_mass[:, None]
        return run(network, start, v, network.centre, network.arm, dt, n, slack=1.0)[0]

    exact = end(2560)
    error = [np.linalg.norm(end(n) - exact) for n in counts]
    assert -np.polyfit(np.log(counts), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.1)


def test_the_bone_field_is_a_signed_distance(hand, rng):
    field = bone_field(hand)
    for name in ("metacarpal_4", "distal_phalanx_2"):
        b = hand.body_names.index(name)
        place = rng.integers(1, field.size[b] - 1, (1500, 3))
        corners = np.ascontiguousarray(hand.bones[name].points[hand.bones[name].faces])
        points = field.origin[b] + place * field.spacing
        exact = closest(points, corners)[0] * np.where(winding(points, corners) > 0.5, -1, 1)
        found = (
            soft_hold_kernel.UNIT
            * field.value[field.start[b] + (place[:, 0] * field.size[b, 1] + place[:, 1]) * field.size[b, 2] + place[:, 2]]
        )
        near = np.abs(exact) < 0.002
        assert np.abs(found - exact)[near].max() < 0.0005 and np.median(np.abs(found - exact)[near]) < 0.0001
        assert (np.sign(found) == np.sign(exact))[~near].all()


def test_a_node_in_bone_is_pushed_out_to_its_clearance(hand):
    pairs, field = soft_limits.guard(hand), bone_field(hand)
    position = np.ascontiguousarray(hand.skin.points.T)
    bone = hand.bones["proximal_phalanx_3"]
    b = hand.body_names.index("proximal_phalanx_3")
    node = int(np.linalg.norm(hand.skin.points - bone.points.mean(axis=0), axis=1).argmin())
    position[:, node] = 0.7 * bone.points[5] + 0.3 * bone.points.mean(axis=0)
    mine = (pairs.corner == node).all(axis=1) & (pairs.body == b)
    only = [v[mine] for v in pairs[:3]]
    look, last = np.arange(mine.sum(), dtype=np.uint32), np.zeros(position.shape[1], np.int64)
    for _ in range(3):
        soft_hold_kernel.out_of_bone(position, relative_transforms(hand, hand.bind), *only, *field[1:], look, len(look), last, 7)
    assert last[node] == 7 and (last > 0).sum() == 1
    corners = np.ascontiguousarray(bone.points[bone.faces])
    point = np.ascontiguousarray(position[:, node][None])
    assert winding(point, corners)[0] < 0.5
    assert only[2][0] - 0.0004 < closest(point, corners)[0][0] < only[2][0] + 0.001


def test_the_first_look_misses_nothing_that_lacks(hand, network, rng):
    """Against the field and the shadows of all pairs and triangles, looked up one by one in numpy."""
    from scipy.ndimage import map_coordinates

    pairs, field, angle = soft_limits.guard(hand), bone_field(hand), hl.simulate(hand, "fist", seconds=0.6).angle[-1]
    under = below(hand, network, angle, None)
    position = np.ascontiguousarray((blend(hand, angle) + rng.normal(0, 8e-4, network.points.shape)).T)
    look = np.empty(max(len(pairs.body), len(network.faces)) + 1, np.uint32)
    found = look[: near_bone(position, under.transforms, pairs.corner, *pairs[3:], field.floor, *field[2:], look)].astype(int)
    middle, lack = position[:, pairs.corner.astype(int)].mean(axis=2).T, np.full(len(pairs.body), -np.inf)
    for b in range(len(hand.body_names)):
        mine = np.flatnonzero(pairs.body == b)
        turn = under.transforms[b]
        cell = ((middle[mine] - turn[:3, 3]) @ turn[:3, :3] - field.origin[b]) / field.spacing
        grid = field.value[field.start[b] :][: field.size[b].prod()].reshape(field.size[b]).astype(float)
        lack[mine] = pairs.clearance[mine] - soft_hold_kernel.UNIT * map_coordinates(grid, cell.T, order=1, mode="nearest")
    assert set(np.flatnonzero(lack > 0.0)) <= set(found)
    assert 10 < (lack > 0.0).sum() < len(found) < len(pairs.body) / 2
    corner = position[:, network.faces.astype(int)]
    normal = np.cross(corner[:, :, 1] - corner[:, :, 0], corner[:, :, 2] - corner[:, :, 0], axis=0)
    shadow = (normal * under.plane).sum(axis=0) / (under.plane**2).sum(axis=0)
    few = look[: lacking(position, network.faces, under.plane, 0.1, look)]
    np.testing.assert_array_equal(few, np.flatnonzero(shadow < 0.1))
    assert 2 < len(few) < 300
    last = np.zeros(len(network.points), np.int64)
    last[[4, 70]] = 3, 2
    mine = np.flatnonzero((network.faces == 4).any(axis=1))
    np.testing.assert_array_equal(look[: touched(network.faces, last, 3, look)], mine)
    mark = np.zeros(8 * (len(network.faces) // 8 + 1), np.uint8)
    np.testing.assert_array_equal(look[: beside(last, 3, network.fan_start, network.fan, mark, look)], mine)
    assert not mark.any()


def test_edges_are_passed_over_only_if_nothing_moved_their_ends(network):
    """However the net is torn: passes that heed what moved do, to the last bit, what passes over all edges do."""
    rng = np.random.default_rng(3)
    heedful = np.ascontiguousarray(network.points.T)
    for node in rng.integers(0, heedful.shape[1], 5):
        heedful[:, node] += rng.normal(0.0, 0.02, 3)
    plain, edges = heedful.copy(), (network.first, network.second, network.longest, soft_limits.LONGEST)
    last, last_plain, since, found = np.zeros(heedful.shape[1], np.int64), np.zeros(heedful.shape[1], np.int64), 0, []
    for now in range(1, 30):
        found.append(soft_hold_kernel.shorten(heedful, *edges, last, since, now))
        assert found[-1] == soft_hold_kernel.shorten(plain, *edges, last_plain, 0, now)
        np.testing.assert_array_equal(heedful, plain)
        since = now
    assert 10 < found[0] < 200 and found[1] >= 1 and found[-1] == 0


def test_frames_known_beforehand_are_those_made_one_by_one(hand, network):
    drive = hl.keyframes("fist").for_hand(hand).at(FRAME * np.arange(40))
    start = first_frame(hand, network)
    now = start
    for values, other in zip(drive, frames(hand, network, start, drive, FRAME), strict=True):
        now = frame(hand, network, now, values, FRAME)
        assert np.array_equal(now.soft.position, other.soft.position)
        assert np.array_equal(now.y, other.y) and np.array_equal(now.speed, other.speed)


def test_work_ahead_comes_in_order_on_another_thread_and_fails_only_where_it_must():
    where = set()

    def work(k):
        where.add(threading.get_ident())
        if k == AT_ONCE:
            raise ValueError("too far")
        return k * k

    coming = ahead(work, 5 * AT_ONCE)
    assert [next(coming) for _ in range(AT_ONCE - 1)] == [k * k for k in range(AT_ONCE - 1)]
    with pytest.raises(ValueError, match="too far"):
        next(coming)
    assert len(where) == 1 and threading.get_ident() not in where
    for count in (0, 1, 2, AT_ONCE, 3 * AT_ONCE + 1):
        assert list(ahead(abs, count)) == list(range(count))


def test_a_triangle_that_was_turned_over_is_turned_back(network):
    position = np.ascontiguousarray(network.points.T)
    face = network.faces[1000].astype(int)
    position[:, face[0]] += 2.0 * (position[:, face[1:]].mean(axis=1) - position[:, face[0]])
    plane, look = np.ascontiguousarray(network.face_normal.T), np.empty(len(network.faces) + 1, np.uint32)
    left = []
    for _ in range(160):
        many = lacking(position, network.faces, plane, 0.1, look)
        left.append(many)
        soft_hold_kernel.unfold(position, network.faces, plane, 0.1, look, many, np.zeros(position.shape[1], np.int64), 1)
        if not many:
            break
    assert left[0] >= 1 and left[-1] == 0


def test_a_shadow_that_lacks_little_is_mended_by_a_little_and_its_middle_stays(network):
    face = network.faces[1000].astype(int)
    normal = network.face_normal[1000]
    height = {}
    for share in (0.0999, 0.09):  # of its rest area, by moving one corner towards the opposite edge
        position = np.ascontiguousarray(network.points.T)
        a, b, c = position[:, face].T
        foot = b + (a - b) @ (c - b) / ((c - b) @ (c - b)) * (c - b)
        position[:, face[0]] = foot + share * (a - foot)
        before = position.copy()
        found = soft_hold_kernel.unfold(
            position,
            network.faces,
            np.ascontiguousarray(network.face_normal.T),
            0.1,
            np.array([1000], np.uint32),
            1,
            np.zeros(position.shape[1], np.int64),
            1,
        )
        assert found == 1
        moved = (position - before)[:, face]
        np.testing.assert_allclose(moved.mean(axis=1), 0.0, atol=1e-15)
        a, b, c = position[:, face].T
        shadow = np.cross(b - a, c - a) @ normal / (normal @ normal)
        assert 0.1 < shadow < 0.103
        height[share] = np.abs(moved).max()
    assert height[0.0999] < 0.2 * height[0.09] < 0.2e-3


@pytest.mark.parametrize("after", [{}, {"FDP2": 0.6}])
def test_the_skin_of_a_fist_comes_to_rest_and_a_short_frame_does_not_move_it(hand, network, after):
    keys = hl.keyframes("fist").for_hand(hand)
    now = first_frame(hand, network)
    for k in range(90):
        now = frame(hand, network, now, keys.at(k * FRAME), FRAME)
    values = keys.at(90 * FRAME)
    for name, value in after.items():
        values[hand.muscle_names.index(hand.muscles[name].name)] = value
    for _ in range(120):
        before, now = now, frame(hand, network, now, values, FRAME)
    assert np.abs(now.soft.position - before.soft.position).max() < 2e-5
    short = frame(hand, network, now, values, 1e-3)
    assert np.abs(short.soft.position - now.soft.position).max() < 5e-4


@pytest.mark.parametrize("faces", [[[0, 1, 2]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]]])
def test_an_open_or_branching_mesh_is_refused(faces, rng):
    with pytest.raises(ValueError, match=r"open edges.*close it"):
        edges_of(Mesh(rng.normal(size=(5, 3)), np.array(faces)))


@pytest.mark.parametrize("wrong", [{"young": 0.0}, {"young": -1.0}, {"tissue": np.nan}, {"slack": -0.1}, {"thickness": np.inf}])
def test_constants_that_make_no_network_are_refused_by_name(hand, wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        soft_skin(hand, **wrong)


def test_an_unknown_way_to_wear_the_skin_is_answered_with_the_known_ones(hand, network):
    with pytest.raises(KeyError, match="springs"):
        follow(hand, network, at_bind(network), hand.bind, None, FRAME, skin="spring")


def test_springs_keep_the_volume_that_blending_loses(hand, network):
    fist = simulate(hand, "fist", fps=4).angle[-1]
    blended = follow(hand, network, at_bind(network), fist, None, FRAME, skin="blend").volume / network.volume - 1
    sprung = begin(hand, network, fist).volume / network.volume - 1
    assert blended < -0.03 and abs(sprung) < 0.01


def test_a_state_does_not_change_and_a_step_repeats_exactly(hand, network):
    soft = at_bind(network)
    before = soft.position.copy()
    ways = [follow(hand, network, soft, hand.bind + 0.1, None, FRAME) for _ in range(2)]
    np.testing.assert_array_equal(soft.position, before)
    np.testing.assert_array_equal(ways[0].position, ways[1].position)


def test_a_whole_frame_moves_bones_muscles_and_skin(hand, network):
    first = first_frame(hand, network)
    contraction = np.zeros(len(hand.muscles))
    contraction[hand.muscle_names.index(hand.muscles["FDP2"].name)] = 1.0
    now = first
    for _ in range(12):
        now = frame(hand, network, now, contraction, FRAME)
    assert np.abs(now.y - first.y).max() > 0.1
    assert np.linalg.norm(now.soft.position - first.soft.position, axis=0).max() > 0.005
    np.testing.assert_allclose(np.linalg.norm(now.soft.normal, axis=0), 1.0, atol=1e-9)


def test_in_key_pinch_the_first_dorsal_interosseus_lifts_the_skin_two_millimetres_and_it_returns(hand, network):
    clip = simulate(hand, "key-pinch", fps=4)
    k = hand.muscle_names.index("dorsal_interosseus_1")
    off, on = (np.where(np.arange(len(hand.muscles)) == k, value, clip.contraction[-1]) for value in (0.0, 1.0))
    flat = begin(hand, network, clip.angle[-1], off)
    swollen = begin(hand, network, clip.angle[-1], on)
    rise = ((swollen.position - flat.position) * flat.normal).sum(axis=0)
    muscles = geometric_muscles(hand)
    own = [i for i, name in enumerate(muscles.names) if name.startswith("dorsal_interosseus_1")]
    over = np.unique(network.ties.node[np.isin(muscles.owner[network.ties.ellipsoid.astype(int)], own)])
    assert 0.002 < rise[over].max() < 0.004
    assert np.abs(np.delete(rise, over)).max() < 0.0005
    for _ in range(180):  # what bones had pushed aside comes back in a third of a second, and ``begin`` leaves a little of it
        swollen, flat = (follow(hand, network, soft, clip.angle[-1], off, FRAME) for soft in (swollen, flat))
    assert np.abs(swollen.position - flat.position).max() < 1e-5


def test_centres_come_back_where_they_were_when_nothing_has_moved(hand, network):
    rest = anchors(network, relative_transforms(hand, hand.bind))
    rest.swell(network, 0.0)
    assert np.abs(rest.centre.T - network.centre).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0])
def test_a_minute_of_random_contraction_breaks_no_promise(hand, seed):
    tally, _ = soak.soak(hand, 60.0, seed)
    assert tally.frames == 3600 and tally.broken == 0
    assert tally.longest <= soak.MOST_STRETCH
    assert tally.inverted_frames == 0
    assert tally.bone_checks == 12 and tally.bone_faults == 0, tally.lines()
