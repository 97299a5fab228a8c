import io

import pytest
from PIL import Image

import handlab
from handlab.show.chain_panel import ChainPanel


def test_the_first_picture_is_there_before_a_slider_moves():
    pytest.importorskip("ipywidgets")
    panel = ChainPanel(handlab.load_hand())
    assert panel.widget
    assert min(Image.open(io.BytesIO(panel._picture.value)).size) > 300
