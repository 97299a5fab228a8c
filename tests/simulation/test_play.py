import csv

import numpy as np
import pytest

from handlab.physics.muscle import muscle_force
from handlab.simulation.keyframes import keyframes
from handlab.simulation.laws import SUBSTEP
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import integrate, rest, step

LIVELY = {
    "FDP2": [(0, 0), (0.3, 1), (1.1, 0.1), (2, 0.6)],
    "EDC2": [(0, 0.2), (0.7, 0), (0.9, 0.9), (2, 0)],
    "FCR": [(0, 0), (1, 0.8), (2, 0)],
    "DI1": [(0.5, 0), (0.6, 1)],
    "APB": 0.5,
}


def test_the_motion_is_the_same_at_any_frame_rate(hand):
    """Frames at the same time agree: whole seconds at 97, 24, 30 and 60, every sixth of a second at the last three."""
    clips = {fps: simulate(hand, LIVELY, fps=fps) for fps in (24, 30, 60, 97)}
    for fps, clip in clips.items():
        assert len(clip) == 2 * fps + 1
        for second in (0, 1, 2):
            assert np.rad2deg(np.abs(clip.angle[second * fps] - clips[60].angle[second * 60])).max() < 0.05
    np.testing.assert_allclose(clips[24].angle[::4], clips[60].angle[::10], atol=1e-12)
    np.testing.assert_allclose(clips[30].angle, clips[60].angle[::2], atol=1e-12)


def test_frames_between_substeps_lie_on_the_motion(hand):
    dense = simulate(hand, LIVELY, fps=round(1 / SUBSTEP))
    odd = simulate(hand, LIVELY, fps=97)
    for k in range(len(hand.dof_names)):
        on_motion = np.interp(odd.time, dense.time, dense.angle[:, k])
        assert np.rad2deg(np.abs(odd.angle[:, k] - on_motion)).max() < 0.05


def test_substeps_are_short_enough(hand):
    """Half as long, they move the angles of a lively clip by little; four times as long, by more: first order."""
    m, keys = mechanics(hand), keyframes(LIVELY)

    def path(dt):
        n = round(2.0 / dt)
        contraction = keys.at((np.arange(n) + 0.5) * dt)
        return integrate(hand, m.rest_y, np.zeros(len(m.rest_y)), contraction, dt, np.zeros(len(m.rest_y), bool))[0][:: n // 120]

    exact = path(SUBSTEP / 8)
    error = [np.rad2deg(np.abs(path(dt) - exact)).max() for dt in (SUBSTEP, SUBSTEP / 2)]
    assert error[0] < 0.5
    assert error[1] < 0.7 * error[0]


def test_a_long_clip_follows_its_keys_to_the_end(hand):
    """In one go, without the pieces that a simulation is cut into."""
    m, keys = mechanics(hand), keyframes(LIVELY)
    contraction = keys.at((np.arange(3600) + 0.5) * SUBSTEP)
    y, _ = integrate(hand, m.rest_y, np.zeros(len(m.rest_y)), contraction, SUBSTEP, np.zeros(len(m.rest_y), bool))
    np.testing.assert_allclose(simulate(hand, LIVELY, seconds=3).angle, coupled(hand, y[::20]), atol=1e-12)


def test_steps_of_one_frame_and_a_simulation_agree(hand):
    clip = simulate(hand, {"FDP2": 0.4, "ECRB": 0.2}, seconds=1)
    state = rest(hand)
    for _ in range(60):
        state = step(hand, state, {"FDP2": 0.4, "ECRB": 0.2}, 1 / 60)
    np.testing.assert_allclose(clip.angle[-1], state.angle, atol=1e-9)
    np.testing.assert_allclose(clip.states[-1].skin, state.skin, atol=1e-9)
    np.testing.assert_allclose(clip.speed[-1], state.speed, atol=1e-6)


def test_a_clip_records_what_the_laws_say(hand):
    clip = simulate(hand, LIVELY, seconds=0.5)
    np.testing.assert_allclose(clip.fibre_length, hand.rest_length - (clip.angle - rest(hand).angle) @ hand.lever_arm.T, atol=1e-15)
    np.testing.assert_allclose(clip.force, muscle_force(clip.contraction, clip.fibre_length / hand.rest_length, hand.max_force), atol=1e-12)
    np.testing.assert_allclose(clip.torque, clip.force @ hand.lever_arm, atol=1e-12)
    np.testing.assert_allclose(clip.angle, coupled(hand, clip.angle[:, mechanics(hand).moving]), atol=1e-15)
    assert clip.time[0] == 0.0 and clip.time[-1] == pytest.approx(0.5)


def test_a_clip_begins_in_the_relaxed_hand_or_where_it_is_told(hand):
    first = simulate(hand, {"FDP2": 1.0}, seconds=0.5)
    np.testing.assert_allclose(first.angle[0], rest(hand).angle, atol=1e-15)
    second = simulate(hand, {"FDP2": 1.0}, seconds=0.5, start=first.states[-1])
    np.testing.assert_allclose(second.angle[0], first.angle[-1], atol=1e-12)
    whole = simulate(hand, {"FDP2": 1.0}, seconds=1.0)
    np.testing.assert_allclose(second.angle[-1], whole.angle[-1], atol=1e-9)


def test_a_clip_lasts_until_its_last_key(hand):
    assert simulate(hand, {"FDP2": [(0, 0), (0.75, 1)]}).time[-1] == 0.75


def test_a_constant_needs_a_length(hand):
    with pytest.raises(ValueError, match="how long"):
        simulate(hand, {"FDP2": 1.0})


@pytest.mark.parametrize("bad", [{"seconds": 0}, {"seconds": float("nan")}, {"fps": 0}, {"fps": -1}, {"fps": "many"}, {"seconds": "long"}])
def test_no_length_and_no_frame_rate_are_refused(hand, bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        simulate(hand, {"FDP2": 1.0}, **{"seconds": 1, **bad})


def test_held_joints_stand_still_in_a_clip(hand):
    clip = simulate(hand, LIVELY, hold=["wrist"])
    assert np.ptp(clip.angle[:, :2]) == np.ptp(clip.angle[0, :2])
    assert np.all(clip.speed[:, :2] == 0.0)


def test_progress_rises_to_1(hand):
    seen = []
    simulate(hand, {"FDP2": 1.0}, seconds=3.3, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0 and len(seen) > 2


def test_states_are_a_sequence(hand):
    clip = simulate(hand, LIVELY, seconds=0.2)
    assert len(clip.states) == len(clip) == 13
    assert clip.states[-1].time == pytest.approx(0.2)
    assert [state.time for state in clip.states[2:5]] == pytest.approx([2 / 60, 3 / 60, 4 / 60])
    assert clip.states[0].skin.shape == hand.skin.points.shape
    with pytest.raises(IndexError):
        clip.states[13]


def test_the_table_has_units_and_the_file_has_the_table(hand, tmp_path):
    clip = simulate(hand, LIVELY, seconds=0.2)
    table = clip.table(muscles=["FDP2"], joints=["mcp2"])
    assert list(table)[:4] == ["time_s", "FDP2.contraction", "FDP2.fibre_length_mm", "FDP2.force_N"]
    assert "mcp2.deviation.angle_deg" in table and "pip2.flexion_extension.angle_deg" not in table
    assert "13 rows" in repr(table)
    path = tmp_path / "clip.csv"
    clip.to_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    assert len(rows) == 14 and len(rows[0]) == 1 + 3 * 42 + 3 * 31
    read = dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))
    np.testing.assert_allclose(read["FDP2.force_N"], table["FDP2.force_N"], rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(read["mcp2.deviation.angle_deg"], table["mcp2.deviation.angle_deg"], rtol=1e-8, atol=1e-12)


def test_a_table_of_an_unknown_joint_is_answered_with_the_nearest(hand):
    with pytest.raises(KeyError, match="mcp2"):
        simulate(hand, LIVELY, seconds=0.1).table(joints=["mpc2"])


def test_a_clip_cannot_be_changed(hand):
    clip = simulate(hand, LIVELY, seconds=0.1)
    for name in ("time", "contraction", "angle", "speed", "fibre_length", "force", "torque"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(clip, name)[0] = 1.0
