import json
from math import cos, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from handlab.physics import springs

EXAMPLES = Path(__file__).parents[1] / "data" / "equations_examples.json"


def examples(key):
    return json.loads(EXAMPLES.read_text(encoding="utf-8"))[key]


def hung(k, m):
    """Acceleration of one mass on a spring to the origin."""
    return lambda x: -k / m * x


def swing(k, m, x0, dt, steps, damping=0.0):
    """Places of a mass that starts at rest at x0."""
    x = np.array([x0])
    v = springs.half_step(np.zeros(1), hung(k, m)(x), -dt)  # half a step behind
    path = [x[0]]
    for _ in range(steps):
        x, v = springs.leapfrog(x, v, hung(k, m), dt, damping)
        path.append(x[0])
    return np.array(path)


def order(error, steps):
    return -np.polyfit(np.log(steps), np.log(error), 1)[0]


def test_leapfrog_gives_the_worked_numbers():
    row = examples("leapfrog")
    accelerate = hung(row["k"], row["m"])
    x = np.array(row["x"][:1])
    v = springs.half_step(np.zeros(1), accelerate(x), row["dt"])
    places, speeds = [x[0]], [v[0]]
    x = x + row["dt"] * v
    for _ in range(3):
        places.append(x[0])
        x, v = springs.leapfrog(x, v, accelerate, row["dt"])
        speeds.append(v[0])
    np.testing.assert_allclose(places, row["x"], rtol=1e-6)
    np.testing.assert_allclose(speeds, row["v_half"], rtol=1e-5)
    assert springs.stable_step(sqrt(row["k"] / row["m"])) == pytest.approx(row["stability_limit_dt"], rel=1e-4)


def test_a_mirrored_pair_gives_the_worked_numbers():
    row = examples("kahler")["mirror"]
    arm = np.array([0.0, 0.0, row["l0_m"]])
    for key, move in (("normal_1mm", [0, 0, 1e-3]), ("tangential_1mm", [1e-3, 0, 0])):
        force = springs.mirrored_pair(np.array(move), np.zeros(3), arm, row["k"], row["l0_m"])
        np.testing.assert_allclose(1e6 * force, row[key], atol=1e-3)
    alone = springs.spring_force(np.array([0.0, 0.0, 1e-3]), -arm, row["k"], row["l0_m"])
    assert -1e3 * alone[2] == pytest.approx(row["single_spring_towards_bone_1mm_mN"])


def test_a_biphasic_spring_gives_the_worked_numbers():
    row = examples("kahler")["biphasic"]
    np.testing.assert_allclose(springs.biphasic(row["strain"], row["k1"], row["k2"], row["eps_c"]), row["force"])


def test_a_shortened_mirrored_pair_is_a_third_as_stiff_across_as_along():
    arm, k, d = np.array([0.0, 0.0, 5e-3]), 3.0, 1e-7
    along = springs.mirrored_pair(np.array([0, 0, d]), np.zeros(3), arm, k, 5e-3 * 2 / 3)[2] / -d
    across = springs.mirrored_pair(np.array([d, 0, 0]), np.zeros(3), arm, k, 5e-3 * 2 / 3)[0] / -d
    assert along == pytest.approx(2 * k, rel=1e-5)
    assert across == pytest.approx(2 * k / 3, rel=1e-5)


def test_a_single_spring_swings_as_the_cosine_with_order_two():
    k, m, x0, seconds = 2.0, 1e-4, 1e-3, 0.05
    steps = np.array([50, 100, 200, 400])
    exact = x0 * cos(sqrt(k / m) * seconds)
    error = [abs(swing(k, m, x0, seconds / n, n)[-1] - exact) for n in steps]
    assert 1.9 < order(error, steps) < 2.1


def test_a_damped_spring_dies_away_as_the_exact_solution_with_order_two():
    k, m, damping, x0, seconds = 2.0, 1e-4, 40.0, 1e-3, 0.03
    w = sqrt(k / m - damping**2 / 4)
    exact = x0 * np.exp(-damping * seconds / 2) * (cos(w * seconds) + damping / (2 * w) * sin(w * seconds))
    steps = np.array([50, 100, 200, 400])
    error = []
    for n in steps:
        dt = seconds / n
        x, v = np.array([x0]), np.zeros(1)
        # half a step back in time, with the damping term at its start, where the speed is 0
        v = v - 0.5 * dt * hung(k, m)(x) * (1 + damping * dt / 4)
        for _ in range(n):
            x, v = springs.leapfrog(x, v, hung(k, m), dt, damping)
        error.append(abs(x[0] - exact))
    assert 1.9 < order(error, steps) < 2.1


def chain(n, k, m):
    """Masses between fixed ends: acceleration across the chain, and the exact frequency of mode p."""
    laplace = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return laplace, lambda p: 2 * sqrt(k / m) * sin(p * pi / (2 * (n + 1)))


def test_a_chain_swings_in_its_modes_and_its_highest_frequency_is_found():
    n, k, m = 20, 3.0, 2e-4
    laplace, frequency = chain(n, k, m)
    mode = np.sin(3 * pi * np.arange(1, n + 1) / (n + 1))
    seconds, steps = 0.02, np.array([100, 200, 400])
    error = []
    for count in steps:
        dt, x = seconds / count, 1e-4 * mode
        v = springs.half_step(np.zeros(n), -k / m * laplace @ x, -dt)
        for _ in range(count):
            x, v = springs.leapfrog(x, v, lambda y: -k / m * laplace @ y, dt)
        error.append(np.abs(x - 1e-4 * mode * cos(frequency(3) * seconds)).max())
    assert 1.9 < order(error, steps) < 2.1
    edges = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    tensors = np.tile(np.diag([k, 0.0, 0.0]), (n - 1, 1, 1))
    ends = np.zeros((n, 3, 3))
    ends[[0, -1], 0, 0] = k
    matrix = springs.stiffness_matrix(n, edges, tensors, ends)
    assert springs.largest_frequency(matrix, np.full(n, m)) == pytest.approx(frequency(n), rel=1e-4)


def triangular_sheet(rows, columns, side):
    """A rectangle of equilateral triangles: points and faces."""
    points = np.array([[side * (c + 0.5 * (r % 2)), side * r * sqrt(3) / 2, 0.0] for r in range(rows) for c in range(columns)])
    faces = []
    for r in range(rows - 1):
        for c in range(columns - 1):
            a, b, d, e = r * columns + c, r * columns + c + 1, (r + 1) * columns + c, (r + 1) * columns + c + 1
            faces += [[a, b, d], [b, e, d]] if r % 2 == 0 else [[a, b, e], [a, e, d]]
    return points, np.array(faces)


def sheet_stiffness(points, faces, young, thickness):
    edges, inverse = np.unique(
        np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0, return_inverse=True
    )
    corner = points[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 2
    both = np.zeros(len(edges))
    np.add.at(both, inverse.ravel(), np.tile(area, 3))
    way = points[edges[:, 1]] - points[edges[:, 0]]
    length = np.linalg.norm(way, axis=1)
    return edges, way, length, springs.membrane_stiffness(young, thickness, both, length)


def test_a_pulled_membrane_stretches_as_young_s_modulus_says():
    """Pulled at both ends, free at the sides: strain = tension / (E t), and a third of it less across (Poisson's ratio 1/3)."""
    young, thickness, side = 1e5, 1.5e-3, 5e-3
    points, faces = triangular_sheet(41, 31, side)
    edges, way, length, k = sheet_stiffness(points, faces, young, thickness)
    matrix = springs.stiffness_matrix(len(points), edges, springs.spring_tensor(way, k, length)).tolil()
    y = points[:, 1]
    inner = np.flatnonzero((y > y.min() + 1e-9) & (y < y.max() - 1e-9))
    strain = 1e-3
    moved = np.zeros((len(points), 3))
    moved[:, 1] = strain * y
    # ends held along the pull only; flat problem: z is left out, and one node holds x
    free = [3 * i + d for i in range(len(points)) for d in (0, 1) if not (d == 1 and i not in set(inner)) and not (d == 0 and i == 0)]
    full = matrix.tocsr()
    from scipy.sparse.linalg import spsolve

    known = moved.ravel()
    rest = -(full @ known)[free]
    known = known.copy()
    known[free] += spsolve(full[free][:, free].tocsc(), rest)
    force = full @ known
    end = [3 * i + 1 for i in np.flatnonzero(y > y.max() - 1e-9)]
    width = np.ptp(points[:, 0]) - side / 2
    assert force[end].sum() / width / (young * thickness * strain) == pytest.approx(1.0, abs=0.03)
    middle = np.flatnonzero(np.abs(y - y.mean()) < 2 * side)
    across = np.polyfit(points[middle, 0], known.reshape(-1, 3)[middle, 0], 1)[0]
    assert across / strain == pytest.approx(-1 / 3, abs=0.02)


def test_a_net_without_anchors_keeps_its_momentum_and_its_energy_stays_bounded():
    points, faces = triangular_sheet(7, 7, 5e-3)
    edges, _, length, k = sheet_stiffness(points, faces, 1e5, 1.5e-3)
    mass = np.full(len(points), 4e-5)

    def force(x):
        pull = springs.spring_force(x[edges[:, 0]], x[edges[:, 1]], k, length)
        total = np.zeros_like(x)
        np.add.at(total, edges[:, 0], pull)
        np.add.at(total, edges[:, 1], -pull)
        return total

    way = points[edges[:, 1]] - points[edges[:, 0]]
    omega = springs.largest_frequency(springs.stiffness_matrix(len(points), edges, springs.spring_tensor(way, k, length)), mass)
    dt = 0.5 * springs.stable_step(omega)
    rng = np.random.default_rng(1)
    x, v = points + rng.normal(0, 1e-5, points.shape), rng.normal(0, 0.01, points.shape)
    momentum, energies = mass @ v, []
    for n in range(10_000):
        if n % 10 == 0:
            half = springs.half_step(v, force(x) / mass[:, None], dt)  # speed at the time of x
            stretch = np.linalg.norm(x[edges[:, 1]] - x[edges[:, 0]], axis=1) - length
            energies.append(0.5 * (mass * (half**2).sum(axis=1)).sum() + 0.5 * (k * stretch**2).sum())
        x, v = springs.leapfrog(x, v, lambda y: force(y) / mass[:, None], dt)
    np.testing.assert_allclose(mass @ v, momentum, atol=1e-12 * np.abs(mass @ np.abs(v)).max() + 1e-15)
    energies = np.array(energies)
    assert 0.8 < energies.min() / energies.mean() < energies.max() / energies.mean() < 1.25
    early, late = energies[:200].mean(), energies[-200:].mean()
    assert late / early == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("factor", "stable"), [(0.99, True), (1.01, False)])
def test_a_spring_is_stable_just_below_its_step_and_not_just_above(factor, stable):
    k, m = 2.0, 1e-4
    path = swing(k, m, 1e-3, factor * springs.stable_step(sqrt(k / m)), 2000)
    assert (np.abs(path).max() < 0.1) == stable


def test_the_number_of_substeps_goes_with_the_root_of_the_stiffness():
    assert springs.substeps(1 / 60, 5000.0, safety=1.0) == 42
    assert springs.substeps(1 / 60, 5000.0) == 60
    assert springs.substeps(1e-6, 5000.0) == 1
