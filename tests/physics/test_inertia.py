import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from handlab.physics.inertia import composite_about_axis, cylinder_about_end, from_points, rod_about_end, rod_tensor

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())
MASS, LENGTH = np.array(EXAMPLES["eq5"]["m_kg"]), np.array(EXAMPLES["eq5"]["l_m"])


def test_rods_and_cylinders_of_the_index_finger_give_the_worked_numbers():
    np.testing.assert_allclose(rod_about_end(MASS, LENGTH), EXAMPLES["eq5"]["J_printed"], rtol=1e-5)
    np.testing.assert_allclose(cylinder_about_end(MASS, LENGTH, EXAMPLES["eq5"]["R_m"]), EXAMPLES["eq5"]["J_solid_cylinder"], rtol=1e-5)


def finger(alpha, beta):
    """Ends of the three rods in the plane of flexion, and their inertia tensors."""
    corners = [np.zeros(3)]
    for length, turn in zip(LENGTH, (0.0, alpha, alpha + beta), strict=True):
        corners.append(corners[-1] + length * np.array([np.cos(turn), np.sin(turn), 0.0]))
    ends = np.array(list(pairwise(corners)))
    return ends, np.array([rod_tensor(m, pair) for m, pair in zip(MASS, ends, strict=True)])


@pytest.mark.parametrize("pose", EXAMPLES["chain"]["poses"], ids=lambda pose: f"PIP {pose['alpha_PIP_deg']}")
def test_a_bent_finger_has_the_worked_moments_about_each_of_its_joints(pose):
    ends, tensors = finger(np.deg2rad(pose["alpha_PIP_deg"]), np.deg2rad(pose["beta_DIP_deg"]))
    for joint, name in enumerate(("J_total_MCP", "J_total_PIP", "J_DIP")):
        carried = slice(joint, None)
        value = composite_about_axis(MASS[carried], ends[carried].mean(axis=1), tensors[carried], [0, 0, 1], ends[joint, 0])
        assert value == pytest.approx(pose[name], rel=1e-5)


def test_points_with_an_equal_share_of_the_mass_give_the_worked_number():
    example = EXAMPLES["vertex_sum"]
    points = np.linspace([0.0, 0.0, 0.0], [LENGTH[1], 0.0, 0.0], example["N"])
    assert from_points(MASS[1], points, [0, 0, 1], [0, 0, 0]) == pytest.approx(example["m_over_N"], rel=1e-5)
    assert from_points(MASS[1], points, [0, 0, 1], [0, 0, 0], literal=True) == pytest.approx(example["literal_m_times_sum"], rel=1e-5)


def test_many_points_of_a_body_tend_to_its_composite_moment():
    rng = np.random.default_rng(3)
    cube = rng.uniform(-1, 1, (200_000, 3)) * [0.01, 0.02, 0.03]
    tensor = np.diag([0.02**2 + 0.03**2, 0.01**2 + 0.03**2, 0.01**2 + 0.02**2]) / 3
    axis, anchor = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.05, 0.0, 0.01])
    exact = composite_about_axis([1.0], [[0, 0, 0]], [tensor], axis, anchor)
    assert from_points(1.0, cube, axis, anchor) == pytest.approx(exact, rel=0.01)


def test_a_finger_that_points_along_the_axis_has_almost_no_moment_about_it():
    ends, tensors = finger(0.0, 0.0)
    assert composite_about_axis(MASS, ends.mean(axis=1), tensors, [1, 0, 0], [0, 0, 0]) == pytest.approx(0.0, abs=1e-18)
