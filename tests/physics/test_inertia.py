import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from handlab.physics.inertia import (
    composite_about_axis,
    composite_tensor,
    cylinder_about_end,
    from_points,
    rod_about_end,
    rod_tensor,
    shifted_tensor,
    turned_tensor,
)

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


def turn(rng):
    """A random rotation."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def of_points(points, mass):
    """Inertia tensor about the origin of equal point masses."""
    square = np.einsum("ni,nj->ij", points, points) * mass / len(points)
    return np.trace(square) * np.eye(3) - square


def test_composite_tensors_of_four_bodies_are_those_of_two_hundred_thousand_point_masses():
    rng = np.random.default_rng(11)
    sides = rng.uniform(0.01, 0.05, (4, 3))
    masses, centres, turns = rng.uniform(0.002, 0.02, 4), rng.uniform(-0.05, 0.05, (4, 3)), [turn(rng) for _ in range(4)]
    about = np.array([0.03, -0.01, 0.02])
    box = [m / 12.0 * np.diag(np.sum(side**2) - side**2) for m, side in zip(masses, sides, strict=True)]
    clouds = [rng.uniform(-0.5, 0.5, (50_000, 3)) * s @ r.T + c - about for s, r, c in zip(sides, turns, centres, strict=True)]
    points = sum(of_points(cloud, m) for cloud, m in zip(clouds, masses, strict=True))
    found = composite_tensor(masses, centres, box, about, rotation=turns)
    np.testing.assert_allclose(found, points, atol=0.002 * np.trace(points))
    assert np.abs(found - composite_tensor(masses, centres, box, about)).max() > 0.009 * np.trace(points), "unturned boxes differ"


def test_a_tensor_gives_the_composite_moment_about_every_axis_through_its_point():
    rng = np.random.default_rng(12)
    masses, centres, about = rng.uniform(0.1, 1.0, 5), rng.normal(size=(5, 3)), rng.normal(size=3)
    spread = rng.normal(size=(5, 8, 3))
    tensors = np.array([of_points(cloud - cloud.mean(axis=0), 1.0) for cloud in spread])
    whole = composite_tensor(masses, centres, tensors, about)
    for axis in rng.normal(size=(20, 3)):
        unit = axis / np.linalg.norm(axis)
        assert unit @ whole @ unit == pytest.approx(composite_about_axis(masses, centres, tensors, unit, about), rel=1e-12)


def test_shifting_a_tensor_there_and_turning_it_back_gives_what_was_there_before():
    rng = np.random.default_rng(13)
    tensor, r = of_points(rng.normal(size=(9, 3)), 2.0), turn(rng)
    np.testing.assert_allclose(turned_tensor(turned_tensor(tensor, r), r.T), tensor, atol=1e-13)
    np.testing.assert_allclose(np.linalg.eigvalsh(turned_tensor(tensor, r)), np.linalg.eigvalsh(tensor), rtol=1e-12)
    away = shifted_tensor(2.0, np.zeros((3, 3)), [0.0, 3.0, 4.0])
    np.testing.assert_allclose(away, 2.0 * np.array([[25.0, 0, 0], [0, 16.0, -12.0], [0, -12.0, 9.0]]))


def test_a_chain_of_rods_has_the_worked_moment_through_its_tensor():
    pose = EXAMPLES["chain"]["poses"][1]
    ends, tensors = finger(np.deg2rad(pose["alpha_PIP_deg"]), np.deg2rad(pose["beta_DIP_deg"]))
    assert composite_tensor(MASS, ends.mean(axis=1), tensors, [0, 0, 0])[2, 2] == pytest.approx(pose["J_total_MCP"], rel=1e-5)
