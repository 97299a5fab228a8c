"""The number of steps that an eigenvalue predicts is the one that trials find."""

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.soft_skin import soft_skin
from handlab.studies import shaking


@pytest.fixture(scope="module")
def net():
    return soft_skin(hl.load_hand())


def test_stability_begins_within_two_percent_of_the_prediction_on_both_sides(net):
    predicted = shaking.predicted(net)
    assert 20.0 < predicted < 200.0
    assert shaking.grows(net, 0.98 * predicted)
    assert not shaking.grows(net, 1.02 * predicted)
    assert shaking.border(net) == pytest.approx(predicted, rel=0.02)


@pytest.mark.parametrize(("young", "tissue"), [(2e5, 3e4), (2e4, 15e3), (1e6, 15e3), (1e5, 2e5)])
def test_the_prediction_holds_for_other_skin_and_tissue(net, young, tissue):
    other = shaking.with_moduli(net, young, tissue)
    assert shaking.grows(other, 0.98 * shaking.predicted(other))
    assert not shaking.grows(other, 1.02 * shaking.predicted(other))


@pytest.mark.parametrize("damping", [0.0, 600.0, 3000.0])
def test_damping_does_not_move_the_border(damping):
    net = soft_skin(hl.load_hand(), damping=damping)
    assert shaking.grows(net, 0.99 * shaking.predicted(net))
    assert not shaking.grows(net, 1.01 * shaking.predicted(net))


def test_a_frame_twice_as_long_needs_twice_the_steps(net):
    assert shaking.predicted(net, 1 / 30) == pytest.approx(2.0 * shaking.predicted(net, 1 / 60), rel=1e-12)
    assert shaking.grows(net, 1.5 * shaking.predicted(net), frame=1 / 30)
    assert not shaking.grows(net, 2.04 * shaking.predicted(net), frame=1 / 30)


def test_everything_twice_as_stiff_needs_the_root_of_two_times_the_steps(net):
    double = shaking.with_moduli(net, 2.0 * net.young, 2.0 * net.tissue)
    assert shaking.predicted(double) / shaking.predicted(net) == pytest.approx(np.sqrt(2.0), rel=1e-5)


@pytest.mark.parametrize(("young", "tissue"), [(2e5, 15e3), (5e3, 3e4)])
def test_other_moduli_give_the_frequency_of_a_net_built_with_them(net, young, tissue):
    built = soft_skin(hl.load_hand(), young, tissue=tissue)
    other = shaking.with_moduli(net, young, tissue)
    assert other.frequency == pytest.approx(built.frequency, rel=1e-9)
    assert abs(other.frequency / net.frequency - 1.0) > 0.05


def test_four_times_the_mass_halves_the_frequency(net):
    assert shaking.with_mass(net, 4.0 * net.mass).frequency == pytest.approx(0.5 * net.frequency, rel=1e-6)


def test_the_stiffness_is_the_slope_of_the_forces(net):
    """Rayleigh's quotient of the worst pattern is the highest frequency squared, and no other pattern has a higher one."""
    matrix, mass = shaking.stiffness(net), np.repeat(net.mass, 3)
    assert abs(matrix - matrix.T).max() < 1e-9 * abs(matrix).max()

    def quotient(swing):
        x = swing.ravel()
        return np.sqrt(x @ (matrix @ x) / (x @ (mass * x)))

    worst = shaking.worst_pattern(net)
    assert np.linalg.norm(worst, axis=1).max() == pytest.approx(1.0)
    assert quotient(worst) == pytest.approx(net.frequency, rel=1e-5)
    for seed in range(5):
        assert quotient(np.random.default_rng(seed).standard_normal(worst.shape)) < net.frequency


def test_numbers_that_make_no_sense_are_told(net):
    with pytest.raises(ValueError, match="substeps is 0"):
        shaking.grows(net, 0)
    with pytest.raises(ValueError, match="young is -1"):
        shaking.with_moduli(net, -1.0, 1e4)
    with pytest.raises(ValueError, match="positive masses"):
        shaking.with_mass(net, [1.0, 2.0])
    with pytest.raises(ValueError, match="positive masses"):
        shaking.with_mass(net, 0.0 * net.mass)


def test_a_step_takes_less_than_a_millisecond(net):
    assert 1e-6 < shaking.seconds_per_step(net, 50) < 1e-3
