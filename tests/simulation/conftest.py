"""The hand that the tests of this folder move."""

import sys
from pathlib import Path

import numpy as np
import pytest

import handlab

sys.path.insert(0, str(Path(__file__).parent))  # for oracle.py: tests are imported one by one


@pytest.fixture(scope="session")
def hand():
    return handlab.load_hand()


@pytest.fixture
def rng():
    return np.random.default_rng(20030726)
