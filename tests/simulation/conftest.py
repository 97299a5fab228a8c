"""The hands that the tests of this folder move."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))


def _hand():
    if (Path(__file__).parents[2] / "assets" / "reference_hand" / "hand.json").exists():
        import handlab

        return handlab.load_hand()
    from stand_in import make

    return make()


@pytest.fixture(scope="session")
def hand():
    return _hand()


@pytest.fixture
def rng():
    return np.random.default_rng(20030726)
