"""Tests of the named clips; each clip is played once per process."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # for motion.py: tests are imported one by one

import motion as played


@pytest.fixture(scope="session")
def hand():
    return played.hand()
