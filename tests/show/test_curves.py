import matplotlib.pyplot as plt
import numpy as np
import pytest

import handlab as hl


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


def panels(figure):
    return {axes.get_title(loc="left") or axes.get_title(): axes for axes in figure.axes if axes.axison}


def test_the_lines_are_those_of_the_clip(grip, hand):
    shown = panels(hl.curves(grip, muscles=["FDP2", "EDC2"], joints=["pip2"]))
    fdp2 = hand.muscle_names.index("flexor_digitorum_profundus_index")
    edc2 = hand.muscle_names.index("extensor_digitorum_index")
    lines = {line.get_label(): line for line in shown["fibre length"].get_lines()}
    assert np.allclose(lines["FDP2"].get_ydata(), 1000 * grip.fibre_length[:, fdp2])
    assert np.allclose(lines["EDC2"].get_ydata(), 1000 * grip.fibre_length[:, edc2])
    angle = next(line for line in shown["joint angles"].get_lines() if line.get_label().startswith("pip2"))
    assert np.allclose(angle.get_ydata(), np.rad2deg(grip.angle[:, hand.dof_names.index("pip2.flexion_extension")]))
    assert np.allclose(angle.get_xdata(), grip.time)
    ratio = next(line for line in shown["fibre length / rest length"].get_lines() if line.get_label() == "FDP2")
    assert ratio.get_ydata()[0] == pytest.approx(1.0)
    contraction = next(line for line in shown["contraction"].get_lines() if line.get_label() == "FDP2")
    assert contraction.get_ydata().max() == pytest.approx(40.0)


def test_every_axis_has_a_unit(grip):
    shown = panels(hl.curves(grip))
    assert {name: axes.get_ylabel() for name, axes in shown.items()} == {
        "contraction": "%",
        "fibre length": "mm",
        "fibre length / rest length": "1 = at rest",
        "joint angles": "degrees",
    }
    assert all(axes.get_xlabel() == "time (s)" for axes in shown.values())


def test_colour_is_never_alone(grip):
    names = list(grip.hand.muscle_names[:8])
    shown = panels(hl.curves(grip, muscles=names))
    lines = [line for line in shown["fibre length"].get_lines() if not line.get_label().startswith("_")]
    assert len({line.get_color() for line in lines}) == 8
    assert len({str(line._dash_pattern) for line in lines}) == 8


def test_letters_are_large_enough_for_the_last_row(grip):
    figure = hl.curves(grip)
    height = figure.get_size_inches()[1] * 72
    for axes in figure.axes:
        for text in (axes.xaxis.label, axes.yaxis.label, axes.title):
            assert text.get_size() / height > 0.02


def test_a_joint_stands_for_its_own_rotations_and_not_for_its_followers(grip):
    shown = panels(hl.curves(grip, joints=["mcp2"]))
    assert list(shown) == ["joint angles"]
    labels = [line.get_label() for line in shown["joint angles"].get_lines() if not line.get_label().startswith("_")]
    assert labels == ["mcp2 flexion +", "mcp2 radial +"]


def test_without_names_the_busiest_are_shown(grip):
    labels = {line.get_label() for line in panels(hl.curves(grip))["contraction"].get_lines()}
    assert labels == {"FDP2", "FDP3", "FDP4", "ECRB"} or labels <= {"FDP2", "FDP3", "FDP4", "FDP5", "ECRB", "OPP"}
    assert len(labels) == 4


def test_more_lines_than_can_be_told_apart_are_refused(grip):
    with pytest.raises(ValueError, match="at most 8"):
        hl.curves(grip, muscles=grip.hand.muscle_names[:9])


def test_an_unknown_muscle_is_answered_with_the_nearest(grip):
    with pytest.raises(KeyError, match="flexor_digitorum_profundus_index"):
        hl.curves(grip, muscles=["FDP22"])


def test_a_figure_is_saved(grip, tmp_path):
    assert hl.save(hl.curves(grip), tmp_path / "curves.png").stat().st_size > 10_000
    with pytest.raises(ValueError, match=r"\.svg"):
        hl.save(hl.curves(grip), tmp_path / "curves.mp4")


def test_the_map_writes_every_lever_arm_and_only_those(hand):
    axes = hl.lever_arm_map(hand).axes[0]
    cells = {tuple(int(v) for v in text.get_position()): float(text.get_text()) for text in axes.texts if text.get_text()[0] in "+-"}
    arm = 1000 * hand.lever_arm
    assert len(cells) == np.count_nonzero(arm)
    for (column, row), written in cells.items():
        assert written == pytest.approx(arm[row, column], abs=0.051)


def test_the_map_shades_opposite_signs_with_opposite_colours(hand):
    image = hl.lever_arm_map(hand).axes[0].get_images()[0]
    shade, arm = image.get_array(), hand.lever_arm
    assert (np.sign(shade.filled(0.0)) == np.sign(arm)).all()
    assert image.norm.vmin == -image.norm.vmax
