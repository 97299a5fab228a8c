"""One hand, one short motion, and ways to look into a picture."""

import numpy as np
import pytest

import handlab as hl

GRIP = {"FDP2": 0.4, "FDP3": 0.4, "FDP4": 0.4, "FDP5": 0.4, "FDS3": 0.3, "ECRB": 0.5, "OPP": 0.4}


@pytest.fixture(scope="session")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="session")
def grip(hand):
    """Half a second of closing fingers, at 60 frames a second."""
    return hl.simulate(hand, {name: [(0.0, 0.0), (0.3, value)] for name, value in GRIP.items()}, seconds=0.5)


@pytest.fixture(scope="session")
def drawn():
    """Where something warmer than the grey-blue background is drawn: (height, width) of booleans."""

    def mask(picture, threshold=8):
        picture = np.asarray(picture)[..., :3].astype(int)
        return picture[..., 0] - picture[..., 2] > threshold

    return mask
