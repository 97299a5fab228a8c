"""The tables of this hand: what they depend on, that they are read right, and how far they are off."""

import time

import numpy as np
import oracle
import pytest
from numba import njit

from handlab.physics.inertia import composite_about_axis, composite_tensor
from handlab.physics.inertia_table import linear_entry, nearest_entry
from handlab.physics.polyhedron import mass_properties
from handlab.simulation.inertia_kernel import look_up
from handlab.simulation.inertia_tables import (
    DE_LEVA,
    InertiaTables,
    carried_tensor,
    fist,
    from_tables,
    inertia_tables,
    table_errors,
    tensor_inertia,
    wrist_constant,
    wrist_inertia_error,
)
from handlab.simulation.kinematics import body_transforms, posed_axes
from handlab.simulation.mechanics import coupled, mechanics, moments_of_inertia
from handlab.simulation.skeleton import centres_of_mass


@pytest.fixture(scope="module")
def tables(hand):
    return inertia_tables(hand)


def named(hand, column):
    return None if column < 0 else hand.moving_names[column].partition(".")[0]


def test_every_joint_depends_on_the_next_two_joints_of_its_digit_and_the_wrist_on_none(hand, tables):
    wanted = {"wrist": (None, None), "cmc1": ("mcp1", "ip1"), "mcp1": ("ip1", None), "ip1": (None, None), "cmc5": ("mcp5", "pip5")}
    for k in "2345":
        wanted |= {f"mcp{k}": (f"pip{k}", f"dip{k}"), f"pip{k}": (f"dip{k}", None), f"dip{k}": (None, None)}
    for k, name in enumerate(hand.moving_names):
        assert (named(hand, tables.inner[k]), named(hand, tables.outer[k])) == wanted[name.partition(".")[0]], name


def test_tables_have_five_degrees_between_their_entries_and_reach_two_degrees_beyond_the_limits(hand, tables):
    limits = np.rad2deg(mechanics(hand).limits)
    assert np.rad2deg(tables.step) == pytest.approx(5.0)
    for k in range(len(tables.inner)):
        for side, other in enumerate((tables.inner[k], tables.outer[k])):
            if other < 0:
                assert tables.entries[k, side] == 1
                continue
            low = np.rad2deg(tables.low[k, side])
            high = low + 5.0 * (tables.entries[k, side] - 1)
            assert low / 5.0 == pytest.approx(round(low / 5.0)), "entries stand at whole multiples of the step"
            assert limits[other, 0] - 7.0 <= low <= limits[other, 0] - 2.0 + 1e-9
            assert limits[other, 1] + 2.0 - 1e-9 <= high <= limits[other, 1] + 7.0
    assert len(tables.values) == tables.start[-1] + tables.entries[-1].prod() == tables.entries.prod(axis=1).sum()


def block(tables, k):
    return tables.values[tables.start[k] : tables.start[k] + tables.entries[k].prod()].reshape(tables.entries[k])


def test_looking_up_is_reading_the_table_as_scipy_and_the_readable_form_do(hand, tables, rng):
    from scipy.interpolate import RegularGridInterpolator

    limits = mechanics(hand).limits
    for y in rng.uniform(limits[:, 0] - 0.2, limits[:, 1] + 0.2, (200, len(limits))):
        line, near = from_tables(hand, y), from_tables(hand, y, nearest=True)
        for k in range(len(limits)):
            axes = [j for j in (tables.inner[k], tables.outer[k]) if j >= 0]
            table = block(tables, k).reshape(tables.entries[k][: len(axes)])
            if not axes:
                assert line[k] == near[k] == table
                continue
            grids = [tables.low[k, side] + tables.step * np.arange(tables.entries[k, side]) for side in range(len(axes))]
            clipped = [np.clip(y[j], grid[0], grid[-1]) for j, grid in zip(axes, grids, strict=True)]
            for method, found, read in (("linear", line[k], linear_entry), ("nearest", near[k], nearest_entry)):
                assert found == pytest.approx(float(RegularGridInterpolator(grids, table, method=method)(clipped)[0]), rel=1e-9)
                assert found == pytest.approx(float(read(table, [grid[0] for grid in grids], tables.step, y[axes])), rel=1e-9)


def test_an_entry_is_the_moment_of_all_that_the_joint_carries_in_that_posture(hand, tables):
    """MCP of the index finger with PIP 45 and DIP 30 degrees: body by body, about the posed axis."""
    k, pip, dip = (hand.moving_names.index(f"{joint}2.flexion_extension") for joint in ("mcp", "pip", "dip"))
    y = np.array(mechanics(hand).rest_y)
    y[pip], y[dip] = np.deg2rad([45.0, 30.0])
    angle = coupled(hand, y)
    carried = [hand.body_names.index(f"{bone}_phalanx_2") for bone in ("proximal", "middle", "distal")]
    turn = body_transforms(hand, angle)[carried, :3, :3]
    m = mechanics(hand)
    tensors = turn @ m.inertia[carried] @ np.swapaxes(turn, 1, 2)
    axes, anchors = posed_axes(hand, angle)
    d = hand.dof_names.index("mcp2.flexion_extension")
    exact = composite_about_axis(m.mass[carried], centres_of_mass(hand, angle)[carried], tensors, axes[d], anchors[d])
    i, j = np.rint((np.array([y[pip], y[dip]]) - tables.low[k]) / tables.step).astype(int)
    assert block(tables, k)[i, j] == pytest.approx(exact, rel=1e-9)
    assert from_tables(hand, y)[k] == pytest.approx(exact, rel=1e-9)


def test_the_tensors_are_the_diagonal_of_the_mass_matrix_of_mujoco(hand, rng):
    m = mechanics(hand)
    model = oracle.model(hand, (m.centre, m.inertia))
    for y in rng.uniform(*m.limits.T, (20, len(m.limits))):
        full = oracle.mass_matrix(model, oracle.at(model, hand, coupled(hand, y)))
        address = oracle.address(model, hand)
        diagonal = np.diag(full)[address] @ hand.coupling**2
        np.testing.assert_allclose(tensor_inertia(hand, y), diagonal, rtol=1e-9)


def test_tensors_of_chains_of_any_length_give_the_moment_about_every_axis_of_the_hand(hand, rng):
    """Four levels at the little finger, the whole hand at the wrist."""
    for y in rng.uniform(*mechanics(hand).limits.T, (3, len(hand.moving_names))):
        angle = coupled(hand, y)
        axes, _ = posed_axes(hand, angle)
        moments = moments_of_inertia(hand, angle)
        for d, name in enumerate(hand.dof_names):
            assert axes[d] @ carried_tensor(hand, name, angle) @ axes[d] == pytest.approx(moments[d], rel=1e-9), name


def test_all_bodies_together_have_the_tensor_of_the_solid_inside_the_skin(hand):
    """They were cut out of it point by point; the integral over the closed skin is exact. 1100 kg/m^3, bind posture."""
    solid = mass_properties(hand.skin.points, hand.skin.faces, density=1100.0)
    bodies = list(hand.bodies.values())
    mass, centre, inertia = (np.array([getattr(body, name) for body in bodies]) for name in ("mass", "centre", "inertia"))
    assert mass.sum() == pytest.approx(solid.mass, rel=0.002)
    np.testing.assert_allclose(mass @ centre / mass.sum(), solid.centre, atol=2e-4)
    whole = composite_tensor(mass, centre, inertia, solid.centre)
    np.testing.assert_allclose(whole, solid.inertia, atol=0.005 * np.trace(solid.inertia))


def by_joint(hand, errors):
    """Largest error of each joint, in percent."""
    worst = 100.0 * np.abs(errors).max(axis=0)
    return {name: worst[k] for k, name in enumerate(hand.moving_names)}


def test_where_a_joint_turns_about_parallel_axes_linear_tables_err_by_less_than_a_thousandth(hand):
    line, near = by_joint(hand, table_errors(hand, samples=400)), by_joint(hand, table_errors(hand, samples=400, nearest=True))
    for name in hand.moving_names:
        joint, _, motion = name.partition(".")
        if joint.startswith(("dip", "ip1")):
            assert line[name] == near[name] < 1e-9
        elif joint.startswith("pip") or joint == "mcp1":
            assert 0.01 < line[name] < 0.05, name
            assert 1.2 < near[name] < 3.0, name
        elif joint.startswith("mcp") and motion == "deviation":
            assert 0.03 < line[name] < 0.5, name
            assert 2.0 < near[name] < 4.0, name


def test_what_the_tables_leave_out_costs_more_than_their_steps(hand):
    """Deviation at the MCP joints, abduction of the thumb, the last joint and the ring finger at CMC 5, everything at the wrist."""
    line = by_joint(hand, table_errors(hand, samples=400))
    for k in "2345":
        assert 5.0 < line[f"mcp{k}.flexion_extension"] < 10.0
    assert 25.0 < line["cmc1.flexion_opposition"] < 50.0
    assert 1.0 < line["cmc1.abduction_adduction"] < 8.0
    assert 10.0 < line["cmc5.flexion_opposition"] < 30.0
    assert 35.0 < line["wrist.flexion_extension"] < 90.0
    assert 30.0 < line["wrist.deviation"] < 80.0


def test_finer_tables_do_not_mend_what_they_leave_out(hand):
    fine = by_joint(hand, table_errors(hand, samples=100, tables=inertia_tables(hand, step=np.deg2rad(2.5))))
    usual = by_joint(hand, table_errors(hand, samples=100))
    for finger in "2345":  # sampled errors hardly exceed the bound of the curvature
        assert 0.15 < fine[f"pip{finger}.flexion_extension"] / usual[f"pip{finger}.flexion_extension"] < 0.4
        assert fine[f"mcp{finger}.flexion_extension"] == pytest.approx(usual[f"mcp{finger}.flexion_extension"], rel=0.05)


def test_the_wrist_that_is_right_for_the_relaxed_hand_is_too_heavy_for_the_fist_and_too_light_for_the_open_hand(hand):
    found = wrist_inertia_error(hand)
    assert found.inertia.shape == found.error.shape == (41, 2)
    assert (np.diff(found.inertia, axis=0) < 0.0).all(), "a closing hand comes nearer to the wrist"
    for axis in (0, 1):
        assert -0.25 < found.error[0, axis] < -0.05
        assert 0.30 < found.error[-1, axis] < 0.60
    np.testing.assert_allclose(wrist_inertia_error(hand, constant="open").error[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(wrist_inertia_error(hand, constant="fist").error[-1], 0.0, atol=1e-12)


def test_the_constant_of_the_wrist_has_a_name_and_the_tables_take_it(hand):
    wrist = [k for k, name in enumerate(hand.moving_names) if name.startswith("wrist")]
    y = fist(hand)
    for name in ("relaxed", "open", "fist", *DE_LEVA):
        tables = inertia_tables(hand, wrist=name)
        np.testing.assert_array_equal(from_tables(hand, y, tables=tables)[wrist], wrist_constant(hand, name))
    np.testing.assert_array_equal(wrist_constant(hand, "de leva male"), (2.515e-3, 2.888e-3))
    np.testing.assert_allclose(wrist_constant(hand, "fist"), tensor_inertia(hand, y)[wrist])
    with pytest.raises(KeyError, match="relaxed"):
        wrist_constant(hand, "relaxd")


def test_tables_of_one_hand_are_made_once_and_cannot_be_changed(hand):
    assert inertia_tables(hand) is inertia_tables(hand)
    assert inertia_tables(hand, step=np.deg2rad(10)) is not inertia_tables(hand)
    with pytest.raises(ValueError, match="read-only"):
        inertia_tables(hand).values[0] = 1.0


def test_a_mirrored_hand_has_the_same_tables(hand):
    import handlab

    left = handlab.load_hand(side="left")
    np.testing.assert_allclose(inertia_tables(left).values, inertia_tables(hand).values, rtol=1e-9)


@pytest.mark.parametrize("step", [0.0, -0.1, 5.0, float("nan")])
def test_a_step_that_is_no_small_angle_in_radians_is_refused(hand, step):
    with pytest.raises(ValueError, match="radians"):
        inertia_tables(hand, step=step)


def test_a_look_up_at_an_angle_that_is_no_number_stays_inside_the_tables(hand, tables):
    for bad in (np.nan, np.inf, -np.inf, 1e300):
        for nearest in (False, True):
            found = from_tables(hand, np.full(len(hand.moving_names), bad), nearest=nearest)
            assert tables.values.min() <= found.min() <= found.max() <= tables.values.max()


def test_the_wrong_number_of_coordinates_is_refused(hand):
    with pytest.raises(ValueError, match="23 moving coordinates"):
        from_tables(hand, np.zeros(31))


@njit
def many(tables, y, nearest, out, times):
    total = 0.0
    for n in range(times):
        y[0] = 1e-9 * n
        look_up(tables, y, nearest, out)
        total += out[0]
    return total


def test_a_look_up_of_all_coordinates_takes_less_than_half_a_microsecond(hand, tables):
    assert isinstance(tables, InertiaTables)
    y, out = fist(hand), np.empty(len(hand.moving_names))
    for nearest in (True, False):
        many(tables, y, nearest, out, 1)
        times = []
        for _ in range(7):  # the quickest of a few: other work on this machine only adds
            begin = time.perf_counter()
            many(tables, y, nearest, out, 20_000)
            times.append((time.perf_counter() - begin) / 20_000)
        assert 5e-9 < min(times) < 0.5e-6
