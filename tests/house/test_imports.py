"""``import handlab`` stays light, and imports point one way."""

import subprocess
import sys

import pytest

import handlab as hl

HEAVY = ("pyvista", "vtk", "vtkmodules", "matplotlib", "numba", "scipy", "imageio", "PIL", "numpy", "cyclopts")


def loaded(code):
    """Top-level modules that a fresh interpreter has loaded after ``code``."""
    script = f"import sys\n{code}\nprint(' '.join(sorted({{name.partition('.')[0] for name in sys.modules}})))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_importing_handlab_loads_no_heavy_library():
    assert not loaded("import handlab") & set(HEAVY)


def test_loading_a_hand_loads_neither_drawing_nor_compiled_code():
    assert not loaded("import handlab\nhandlab.load_hand()") & set(HEAVY) - {"numpy"}


def test_simulating_loads_no_drawing_library():
    assert not loaded("import handlab as hl\nhl.rest(hl.load_hand())") & {"pyvista", "vtk", "vtkmodules", "matplotlib", "imageio", "PIL"}


def test_the_modules_that_draw_load_their_libraries_only_when_they_draw():
    code = "import handlab.show.save, handlab.show.scene, handlab.show.curves, handlab.show.plots, handlab.show.film, handlab.show.sheet"
    assert not loaded(code) & {"pyvista", "vtk", "vtkmodules", "matplotlib", "imageio", "imageio_ffmpeg", "PIL"}


@pytest.mark.parametrize("name", [name for name in hl.__all__ if name != "__version__"])
def test_every_public_name_can_be_reached_and_is_documented(name):
    assert getattr(hl, name).__doc__


def test_an_unknown_name_is_answered_with_what_there_is():
    with pytest.raises(AttributeError, match="load_hand"):
        hl.load_hands  # noqa: B018


def test_completion_offers_the_public_names():
    assert set(dir(hl)) == set(hl.__all__)
