"""Pictures of the mechanics: what they draw is what the laws say, every letter is large, and no label covers another."""

from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PathCollection

import handlab as hl
from handlab.show.balance_plots import shortened, torque_balance
from handlab.show.excursion_plots import excursion_plot
from handlab.show.force_length_plots import force_length
from handlab.show.step_plots import step_plot
from handlab.show.strength_plots import brand_plot, pull_map
from handlab.show.wall_plots import overlap, places, together
from handlab.show.wrist_plots import wrist_plot
from handlab.studies.torque_parts import Part

SMALLEST = 0.016  # of the picture's height


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def flat(hand):
    return hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))


@pytest.fixture(scope="module")
def pictures(hand, grip, flat):
    """How to draw every picture for the wall."""
    states = {"flat": flat, "grip": grip.states[-1]}
    return {
        "force-length, one state": lambda: force_length(hand, grip.states[-1]),
        "force-length, two states": lambda: force_length(hand, states),
        "force-length, three states": lambda: force_length(hand, {**states, "relaxed": hl.rest(hand)}),
        "Brand": lambda: brand_plot(hand),
        "wrist and thumb": lambda: pull_map(hand),
        "knuckle": lambda: pull_map(hand, "mcp2"),
        "excursion": lambda: excursion_plot(hand),
        "torque balance": lambda: torque_balance(grip, "mcp2"),
        "torque balance of the wrist": lambda: torque_balance(grip, "wrist", time=0.2, gravity=(0.0, 9.81, 0.0)),
        "wrist": lambda: wrist_plot({"relaxed": hand, "flat": hand.with_fibre_rest("flat")}),
        "steps": lambda: step_plot(hand),
    }


NAMES = (
    "force-length, one state", "force-length, two states", "force-length, three states", "Brand", "wrist and thumb", "knuckle", "excursion",
    "torque balance", "torque balance of the wrist", "wrist", "steps",
)  # fmt: skip


def words(figure):
    """Every text that is drawn, with its box in pixels."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    gone = hidden_ticks(figure)
    texts = [text for text in figure.findobj(plt.Text) if text.get_visible() and text.get_text().strip() and text not in gone]
    return {text: text.get_window_extent(renderer) for text in texts if text.axes is None or text.axes.axison}


def hidden_ticks(figure):
    """Tick labels outside of their axis' limits, which matplotlib keeps and does not draw."""
    gone = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                if not low - 1e-9 <= tick.get_loc() <= high + 1e-9:
                    gone |= {tick.label1, tick.label2}
    return gone


@pytest.mark.parametrize("name", NAMES)
def test_no_text_covers_another(pictures, name):
    figure = pictures[name]()
    boxes = words(figure)
    assert len(boxes) > 10
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        along = min(a.y1, b.y1) - max(a.y0, b.y0)
        assert across < 1.5 or along < 1.5, f"{one.get_text()!r} and {other.get_text()!r} overlap by {across:.1f} x {along:.1f} pixels"


@pytest.mark.parametrize("name", NAMES)
def test_no_text_leaves_the_picture(pictures, name):
    figure = pictures[name]()
    for text, box in words(figure).items():
        assert box.x0 > -1 and box.y0 > -1 and box.x1 < figure.bbox.x1 + 1 and box.y1 < figure.bbox.y1 + 1, text.get_text()


@pytest.mark.parametrize("name", NAMES)
def test_every_letter_can_be_read_from_the_last_row(pictures, name):
    figure = pictures[name]()
    height = 72 * figure.get_size_inches()[1]
    small = {text.get_text(): text.get_size() for text in words(figure) if text.get_size() < SMALLEST * height}
    assert not small


@pytest.mark.parametrize("name", NAMES)
def test_every_axis_says_its_unit_or_that_it_has_none(pictures, name):
    units = ("(mm)", "(ms)", "(N m)", "N", "(%", "(degrees)", "length", "force", "before", "torque (N m)")
    for axes in pictures[name]().axes:
        for axis in (axes.xaxis, axes.yaxis):
            named = any(label.get_text().strip(" 0123456789.\N{MINUS SIGN}-") for label in axis.get_ticklabels())
            shared = axis is axes.yaxis and not axis.get_label_text()
            assert named or shared or any(unit in axis.get_label_text() for unit in units), axis.get_label_text()


def offsets(axes):
    return np.concatenate([one.get_offsets() for one in axes.collections if isinstance(one, PathCollection) and len(one.get_offsets())])


def test_the_force_length_plot_has_all_muscles_as_dots_at_their_lengths(hand, grip):
    state = grip.states[-1]
    left, right = hl.force_length(hand, state).axes
    dots = offsets(left)
    assert len(dots) == 42
    ratio = state.fibre_length / hand.rest_length
    assert np.allclose(np.sort(dots[:, 0]), np.sort(ratio))
    assert [tick.get_text() for tick in right.get_yticklabels()] == [muscle.abbreviation for muscle in hand.muscles.values()]
    expected = np.maximum(0.0, 1.0 - 4.0 * (ratio - 1.1) ** 2) + np.where(ratio > 1.0, 2.77 * (ratio - 1.0) ** 2, 0.0)
    assert np.allclose(np.sort(dots[:, 1]), np.sort(expected))
    newtons = [float(text.get_text()) for text in right.texts]
    assert np.allclose(newtons, expected * hand.max_force, atol=0.51)


def test_several_states_stand_side_by_side_with_all_their_muscles(hand, grip, flat):
    states = {"flat": flat, "grip": grip.states[-1]}
    *curves, strip = force_length(hand, states).axes
    assert [axes.get_title(loc="left") for axes in curves] == ["flat", "grip"]
    for axes, state in zip(curves, states.values(), strict=True):
        assert np.allclose(np.sort(offsets(axes)[:, 0]), np.sort(state.fibre_length / hand.rest_length))
    lines = {line.get_label(): line.get_ydata() for line in strip.get_lines()}
    assert np.allclose(lines["grip"], states["grip"].fibre_length / hand.rest_length)


def test_the_flat_rest_posture_names_the_deep_flexors_that_cannot_close_the_fist(hand):
    closed = {
        f"{joint}{k}.flexion_extension": np.deg2rad(by) for joint, by in {"mcp": 80, "pip": 100, "dip": 50}.items() for k in range(2, 6)
    }
    straight = {"wrist.flexion_extension": 0.0}
    other = hand.with_fibre_rest("flat")
    texts = {}
    for title, one in (("relaxed", hand), ("flat", other)):
        axes = force_length(one, {"fist": hl.pose(one, closed | straight)}).axes[0]
        texts[title] = " ".join(text.get_text().replace("\n", " ") for text in axes.texts)
    assert "FDP 2 3 4 5" in texts["flat"]
    assert "FDP" not in texts["relaxed"]


def test_states_that_do_not_fit_beside_each_other_are_refused(hand, flat):
    with pytest.raises(ValueError, match="one to 3"):
        force_length(hand, {str(k): flat for k in range(4)})
    with pytest.raises(ValueError, match="between 0 and 1"):
        force_length(hand, contraction=1.4)


def test_wherever_newtons_are_shown_their_assumption_is_shown_too(hand):
    weak = hand.with_newton_per_percent(25)
    state = hl.rest(weak)
    for figure in (
        hl.force_length(weak),
        brand_plot(weak),
        wrist_plot(weak),
        torque_balance(weak, "mcp2", state=state, contraction={"FDP2": 0.5}),
    ):
        seen = " ".join(text.get_text() for text in words(figure))
        assert "25 N per % of tension" in seen
        assert "assumption" in seen


def test_brands_plot_has_every_muscle_at_its_length_and_tension_and_every_name(hand):
    axes = brand_plot(hand).axes[0]
    expected = sorted((1000 * muscle.rest_length, muscle.tension_percent) for muscle in hand.muscles.values())
    assert np.allclose(sorted(map(tuple, offsets(axes))), expected)
    labels = " ".join(text.get_text() for text in axes.texts).replace(",", "").split()
    assert len({"FDP2", "LUM1", "FCU", "DI4", "EIP", "EDC2"} & set(labels)) == 6


def test_the_lines_of_equal_work_are_the_area_under_the_active_curve(hand):
    """Work from 1.6 to 0.6 by numerical integration, read at the right end of the line that is marked 1 J."""
    axes = brand_plot(hand).axes[0]
    (mark,) = [text for text in axes.texts if text.get_text() == "1 J"]
    ratio = np.linspace(0.6, 1.6, 2001)
    area = np.trapezoid(1 - 4 * (ratio - 1.1) ** 2, ratio)
    length_mm, percent = axes.get_xlim()[1], mark.get_position()[1]
    assert area * percent * hand.newton_per_percent * length_mm / 1000 == pytest.approx(1.0, rel=1e-5)


def test_the_map_has_every_muscle_of_the_wrist_at_its_two_arms_with_its_tension_as_area(hand):
    axes = pull_map(hand, "wrist").axes[0]
    columns = [hand.dof_names.index(f"wrist.{name}") for name in ("flexion_extension", "deviation")]
    arms = 1000 * hand.lever_arm[:, columns]
    crossing = np.abs(arms).max(axis=1) > 0
    assert crossing.sum() == 24
    discs = [one for one in axes.collections if len(one.get_offsets()) and one.get_sizes()[0] != 34]
    area = sum(one.get_sizes()[0] for one in discs)
    tension = np.array([muscle.tension_percent for muscle in hand.muscles.values()])
    assert area / discs[0].get_sizes()[0] == pytest.approx(tension[crossing].sum() / 8.3)  # FDS 2 3 4 5 share the largest disc: 8.3 %
    for place in offsets(axes):
        assert np.abs(arms - place).max(axis=1).min() < 1e-9


def test_a_millimetre_is_as_long_across_as_up(hand):
    for axes in pull_map(hand).axes:
        axes.figure.draw_without_rendering()
        across, up = np.ptp(axes.get_xlim()) / axes.bbox.width, np.ptp(axes.get_ylim()) / axes.bbox.height
        assert across == pytest.approx(up, rel=0.02)


def test_a_joint_without_two_rotations_has_no_map(hand):
    with pytest.raises(ValueError, match="mcp2"):
        pull_map(hand, "pip2")
    with pytest.raises(ValueError, match="one or two"):
        pull_map(hand, ["wrist", "cmc1", "mcp2"])
    with pytest.raises(KeyError, match="wrist"):
        pull_map(hand, "wirst")


def test_the_bars_of_the_torque_balance_end_at_the_net_torque(grip):
    axes = torque_balance(grip, "mcp2").axes[0]
    bars = [(bar.get_x(), bar.get_width()) for bar in axes.patches]
    *parts, (begin, net) = bars
    assert begin == 0.0
    assert sum(width for _, width in parts) == pytest.approx(net, abs=1e-12)
    sizes = np.abs([a[1] + b[1] for a, b in zip(parts[::2], parts[1::2], strict=True)])
    shown = len(sizes) - 1  # the last one may be all small ones together
    assert (np.diff(sizes[:shown]) <= 1e-12).all()


def test_small_torques_share_a_bar_that_keeps_the_sum():
    parts = [Part(f"m{k}", 0.7 / (k + 1), 0.3 / (k + 1)) for k in range(30)]
    few = shortened(parts, most=5)
    assert [part.name for part in few] == ["m0", "m1", "m2", "m3", "26 more"]
    assert sum(part.passive for part in few) == pytest.approx(sum(part.passive for part in parts))
    assert sum(part.torque for part in few) == pytest.approx(sum(part.torque for part in parts))
    assert shortened(parts[:3], most=5) == parts[:3]


def test_a_torque_balance_wants_a_moment_that_exists(grip, hand):
    with pytest.raises(ValueError, match=r"0 to 0\.5 s"):
        torque_balance(grip, "mcp2", time=3.0)
    with pytest.raises(ValueError, match="time="):
        torque_balance(grip, "mcp2", contraction={"FDP2": 1.0})
    with pytest.raises(ValueError, match="state="):
        torque_balance(hand, "mcp2", time=0.1)
    with pytest.raises(KeyError, match="mcp2"):
        torque_balance(grip, "mpc2")


def test_names_of_one_place_are_one_label():
    assert together(["FDS2", "FDS3", "FDS4", "FDS5"]) == "FDS 2 3 4 5"
    assert together(["EIP"]) == "EIP"


def test_labels_stay_inside_the_frame_and_apart_even_in_a_crowd():
    """Points: a dense cloud of 25 dots in a corner, boxes of 40 x 16."""
    frame = np.array([[0.0, 0.0], [800.0, 500.0]])
    at = np.random.default_rng(3).random((25, 2)) * [260.0, 180.0] + [535.0, 315.0]
    half = np.tile([20.0, 8.0], (len(at), 1))
    middle = places(at, np.full(len(at), 5.0), half, frame)
    assert (middle - half >= frame[0] - 1e-9).all()
    assert (middle + half <= frame[1] + 1e-9).all()
    shared = overlap(middle, half[0], middle, half)
    np.fill_diagonal(shared, 0.0)
    assert shared.max() == 0.0
    assert np.linalg.norm(middle - at, axis=1).max() < 100.0
