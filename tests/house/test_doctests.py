"""A number claimed in a docstring is a doctest; here they run."""

import doctest
import importlib
import pkgutil

import pytest

import handlab

MODULES = ["handlab", *(found.name for found in pkgutil.walk_packages(handlab.__path__, "handlab."))]


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_give_what_they_say(name):
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert result.failed == 0


def test_there_are_examples():
    finder = doctest.DocTestFinder(exclude_empty=True)
    assert sum(bool(test.examples) for name in MODULES for test in finder.find(importlib.import_module(name))) >= 5
