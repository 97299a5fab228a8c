"""The checks of "What the skin adds": right answers pass, and every common slip is told for what it is."""

from dataclasses import replace

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.simulation.soft_skin import soft_skin
from handlab.studies import knuckle, measures

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def states(hand):
    straight = dict.fromkeys(hand.moving_names, 0.0)
    fingers = {f"{joint}{k}.flexion_extension": np.deg2rad(80) for joint in ("mcp", "pip") for k in (2, 3, 4, 5)}
    angles = {"flat": {}, "bent": {"pip2.flexion_extension": np.pi / 2}, "fist": fingers}
    return {name: hl.pose(hand, straight | given) for name, given in angles.items()}


@pytest.fixture(scope="module")
def skin(hand, states):
    return {way: {name: knuckle.worn(hand, state, way) for name, state in states.items()} for way in ("linear", "blend", "springs")}


def said(exercise, *answers):
    return lesson("09").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def test_any_honest_length_of_a_line_is_noted():
    assert said("mine", 26).outcome is Outcome.NOTED
    assert "is 30 percent longer there" in said("mine", 26).text
    assert "is 10 percent shorter there" in said("mine", 18).text
    assert "as long as before" in said("mine", 20).text
    assert "in millimetres" in hint("mine", 2.6)
    assert "one number" in hint("mine", "long")


def volume(kind="right"):
    def own(points, faces):
        a, b, c = points[faces].transpose(1, 0, 2)
        each = np.linalg.det(np.stack([a, b, c], axis=1)) / 6
        return {
            "right": each.sum(),
            "no sixth": 6 * each.sum(),
            "third": 2 * each.sum(),
            "sign": -each.sum(),
            "abs": np.abs(each).sum(),
            "all": each,
            "off": 1.01 * each.sum(),
            "open": ...,
        }[kind]

    return own


def test_the_volume_passes_and_its_slips_are_told():
    assert said("volume", volume()).outcome is RIGHT
    assert said("volume", volume("open")).outcome is Outcome.OPEN
    slips = {"no sixth": "sixth is missing", "third": "not a third", "sign": "sign is turned", "abs": "leave out abs", "all": "one number"}
    for kind, word in slips.items():
        assert word in hint("volume", volume(kind))
    assert "the package has" in hint("volume", volume("off"))


def loss(hand, skin, way):
    part = knuckle.piece(hand, "pip2")
    before, after = (knuckle.piece_volume(skin[way][name], part) for name in ("flat", "bent"))
    return 100 * (1 - after / before)


def test_what_blending_loses_at_the_knuckle(hand, skin):
    linear, blend = (loss(hand, skin, way) for way in ("linear", "blend"))
    assert linear > blend + 3 > 8
    assert said("loss", linear, blend).outcome is RIGHT
    assert said("loss", ..., ...).outcome is Outcome.OPEN
    assert "counts positive" in hint("loss", -linear, blend)
    assert "what is lost" in hint("loss", 100 - linear, blend)
    assert "swapped" in hint("loss", blend, linear)
    assert "part of one" in hint("loss", linear / 100, blend)
    assert "'blend' is not" in hint("loss", linear, blend + 1)


def test_springs_keep_the_whole_and_the_piece_is_another_matter(hand, skin):
    piece = loss(hand, skin, "springs")
    whole = {way: 100 * knuckle.signed_volume(skin[way]["fist"], hand.skin.faces) / hand.skin.volume for way in skin}
    assert whole["springs"] == pytest.approx(100, abs=0.5)
    assert 85 < whole["blend"] < 97
    assert said("springs", piece, whole["blend"], whole["springs"]).outcome is RIGHT
    assert "swapped" in hint("springs", piece, whole["springs"], whole["blend"])
    assert "what is left" in hint("springs", piece, 100 - whole["blend"], whole["springs"])
    assert "counts positive" in hint("springs", -piece, whole["blend"], whole["springs"])


def test_springs_that_do_not_keep_volume_lose_it(hand, states, skin):
    net = replace(soft_skin(hand), compliance=np.inf)
    left = 100 * knuckle.signed_volume(knuckle.worn(hand, states["fist"], "springs", network=net), hand.skin.faces) / hand.skin.volume
    assert 85 < left < 98
    assert said("broken", left).outcome is RIGHT
    assert "network=broken" in hint("broken", 100)
    assert "what is left" in hint("broken", 100 - left)
    blend = 100 * knuckle.signed_volume(skin["blend"]["fist"], hand.skin.faces) / hand.skin.volume
    assert "blended fist" in hint("broken", blend)


def test_the_volume_is_put_where_nothing_bends(hand, skin):
    part = knuckle.piece(hand, "wrist", girth=0.05)
    grow = {
        way: 100 * (knuckle.piece_volume(skin[way]["fist"], part) / knuckle.piece_volume(skin[way]["flat"], part) - 1)
        for way in ("springs", "blend")
    }
    assert grow["springs"] > 1
    assert grow["blend"] == pytest.approx(0, abs=0.1)
    assert said("wrist", grow["springs"], grow["blend"]).outcome is RIGHT
    assert "swapped" in hint("wrist", grow["blend"], grow["springs"])
    assert "how much it grows" in hint("wrist", 100 + grow["springs"], grow["blend"])
    assert "'blend' is not" in hint("wrist", grow["springs"], 3)


def test_ink_stretches_less_on_springs(hand, skin):
    longer = {}
    for side in ("dorsal", "palmar"):
        drawn = knuckle.ink(hand, "pip2", side)
        longer[side] = {
            way: 100 * (knuckle.ink_length(skin[way]["bent"], drawn) / knuckle.ink_length(skin[way]["flat"], drawn) - 1) for way in skin
        }
    blend, springs = longer["dorsal"]["blend"], longer["dorsal"]["springs"]
    assert said("ink", blend, springs).outcome is RIGHT
    assert "swapped" in hint("ink", springs, blend)
    assert "how much is added" in hint("ink", 100 + blend, springs)
    assert "palm side" in hint("ink", longer["palmar"]["blend"], springs)


def test_skin_is_drawn_in_by_millimetres(hand, skin):
    drawn = knuckle.ink(hand, "pip2")
    there = [knuckle.ink_points(skin[way]["bent"], drawn)[[0, -1]] for way in ("blend", "springs")]
    proximal, distal = 1000 * np.linalg.norm(there[1] - there[0], axis=1)
    assert 0.2 < proximal < 8
    assert 0.2 < distal < 8
    assert said("slide", proximal, distal).outcome is RIGHT
    assert "metres" in hint("slide", proximal / 1000, distal)
    assert "swapped" in hint("slide", distal, proximal)
    assert "distal end is not" in hint("slide", proximal, distal + 1)


def test_a_muscle_lifts_the_skin_above_it(hand):
    pinch = hl.simulate(hand, "key-pinch", hold=["wrist"]).states[-1]
    on = np.zeros(len(hand.muscles))
    on[hand.muscle_names.index(hand.muscles["DI1"].name)] = 1.0
    before, after = (knuckle.worn(hand, pinch, "springs and muscles", contraction=contraction) for contraction in (0 * on, on))
    rise = 1000 * ((after - before) * measures.vertex_normals(before, hand.skin.faces)).sum(axis=1)
    assert 1.0 < rise.max() < 6.0
    assert said("bulge", rise.max(), 0).outcome is RIGHT
    assert "millimetres" in hint("bulge", rise.max() / 1000, 0)
    assert "does not rise" in hint("bulge", rise.max() + 1, 0)
    assert "anything of muscles" in hint("bulge", rise.max(), 1)
    assert said("bulge", ..., ...).outcome is Outcome.OPEN


def test_the_forces_of_a_second_are_counted(hand):
    net = soft_skin(hand)
    edges, nodes, steps = len(net.stiffness), len(net.mass), net.substeps(1 / 60)
    assert said("count", 60 * steps * (edges + 2 * nodes)).outcome is RIGHT
    assert "two for each" in hint("count", 60 * steps * edges)
    assert "two springs" in hint("count", 60 * steps * (edges + nodes))
    assert "one picture" in hint("count", steps * (edges + 2 * nodes))
    assert "one step" in hint("count", 60 * (edges + 2 * nodes))
    assert "Pictures in a second" in hint("count", 1)
