"""Every named clip, and the postures that strain the skin most, in soft skin: nothing tears, turns over or lets bone through."""

import sys
from pathlib import Path

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.soft_skin import soft_skin
from handlab.simulation.worn import worn

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tools

from tools import skin_pictures, soak

FPS = 30
LOOKS = 3  # times at which a motion's bones are looked for outside its skin, the last frame among them


@pytest.fixture(scope="module")
def judge(hand):
    return soak.Judge(hand, soft_skin(hand))


def faults(hand, judge, time, angle, contraction):
    """What breaks a promise, in words; every frame but for the bones."""
    skin, found = worn(hand, time, angle, contraction, "springs and muscles"), []
    looked = np.unique(np.linspace(0, len(time) - 1, LOOKS + 1).round().astype(int)[1:])
    for k in range(len(time)):
        points = np.ascontiguousarray(skin.points(k))
        if not np.isfinite(points).all():
            return [f"frame {k} is not finite"]
        if (stretch := judge.stretch(points)) > soak.MOST_STRETCH:
            found.append(f"frame {k}: an edge is {stretch:.2f} times its rest length")
        if inverted := judge.inverted(points, angle[k]):
            found.append(f"frame {k}: {inverted} inverted triangles")
        if k in looked and (deep := judge.bone_outside(points, angle[k]))[0] > soak.DEEPEST:
            found.append(f"frame {k}: {deep[1]} is {1e3 * deep[0]:.2f} mm outside")
    return found


MOTIONS = (*hl.clips(), *skin_pictures.postures())


@pytest.fixture(scope="module")
def motions(hand):
    return {name: rest for name, *rest in skin_pictures.motions(hand, FPS)}


@pytest.mark.parametrize("name", MOTIONS)
def test_the_soft_skin_stays_whole_and_over_the_bones_in(name, hand, judge, motions):
    assert not (found := faults(hand, judge, *motions[name])), "\n".join(found[:8])


def torn(points, faces):
    return points * [1.0, 1.0, 2.3]


def turned(points, faces):
    moved, face = points.copy(), faces[1000]
    moved[face[0]] += 2.5 * (moved[face[1:]].mean(axis=0) - moved[face[0]])
    return moved


def pierced(points, faces):
    return points.mean(axis=0) + 0.8 * (points - points.mean(axis=0))


@pytest.mark.parametrize(("broken", "word"), [(torn, "rest length"), (turned, "inverted"), (pierced, "mm outside")])
def test_a_torn_turned_or_pierced_skin_is_found(broken, word, hand, judge, monkeypatch):
    class Broken:
        def points(self, frame):
            return broken(hand.skin.points, hand.skin.faces)

    monkeypatch.setattr(sys.modules[__name__], "worn", lambda *_: Broken())
    found = faults(hand, judge, np.zeros(1), hand.bind[None], None)
    assert any(word in one for one in found), found
