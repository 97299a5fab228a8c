"""How far the camera was: focal lengths, scanners' dots per inch, and what is assumed where a file tells nothing."""

import io

import numpy as np
import pytest
from PIL import Image

from handlab.fitting import lens
from handlab.fitting.calibration import Scale, confirmed
from handlab.fitting.lens import ASSUMED_MM, camera, camera_distance_mm, scan_mm_per_px


def file(width=400, height=300, kind="JPEG", dpi=None, **tags):
    """A picture of one colour; ``tags`` in its EXIF data, the camera's part, by number."""
    notes = Image.Exif()
    notes.get_ifd(lens.EXIF_PART).update({int(name[1:]): value for name, value in tags.items()})
    stream = io.BytesIO()
    options = {"exif": notes} if tags else {}
    Image.new("RGB", (width, height), (90, 90, 90)).save(stream, format=kind, **options, **({"dpi": dpi} if dpi else {}))
    return stream.getvalue()


FOCAL_35, FOCAL, DOTS, UNIT = "t41989", "t37386", "t41486", "t41488"


@pytest.mark.parametrize("width", [600, 1200])
def test_a_50_mm_lens_shows_72_cm_of_table_from_1_m(width):
    """On film of 24 x 36 mm, whatever the number of pixels."""
    told = camera(file(width, width * 2 // 3, **{FOCAL_35: 50}), 720.0 / width, (width, width * 2 // 3))
    assert told.distance_mm == pytest.approx(1000.0, rel=1e-3) and told.how == "focal length in the file"


def test_a_telephones_focal_length_tells_its_distance_from_a_file_or_its_bytes(tmp_path):
    data = file(4000, 3000, **{FOCAL_35: 26})
    (tmp_path / "phone.jpg").write_bytes(data)
    for picture in (data, tmp_path / "phone.jpg"):  # 26 mm on 43.27 mm of diagonal, 5000 px: f = 3004 px; 0.15 mm per px: 451 mm
        assert camera_distance_mm(picture, 0.15, (4000, 3000)) == pytest.approx(450.7, abs=0.5)
        assert camera_distance_mm(picture, 0.15) == pytest.approx(450.7, abs=0.5)


def test_a_large_camera_tells_focal_length_and_the_size_of_its_pixels_instead():
    """35 mm; 6000 pixels on 22.3 mm of sensor; at 0.1 mm per pixel: 35 / 22.3 * 600 mm, also when the picture is made smaller."""
    tags = {FOCAL: 35, DOTS: 6000 / 2.23, UNIT: 3, "t40962": 6000, "t40963": 4000}
    assert camera_distance_mm(file(6000, 4000, **tags), 0.1) == pytest.approx(941.7, rel=1e-3)
    assert camera_distance_mm(file(600, 400, **tags), 1.0) == pytest.approx(941.7, rel=1e-3)


def test_the_focal_length_of_a_picture_that_was_cut_says_nothing():
    tags = {FOCAL_35: 50, "t40962": 4000, "t40963": 3000}
    assert camera_distance_mm(file(400, 300, **tags), 2.0) is not None
    assert camera_distance_mm(file(400, 200, **tags), 2.0) is None


@pytest.mark.parametrize(
    "picture", [b"no picture", b"", "none.jpg", (400, 300), np.zeros((300, 400, 3), np.uint8), file(), file(kind="PNG")]
)
def test_where_nothing_is_told_60_cm_are_assumed(picture):
    assert camera_distance_mm(picture, 0.2, (400, 300)) is None
    assert camera(picture, 0.2, (400, 300)) == (ASSUMED_MM, "assumed") == (600.0, "assumed")


def test_a_focal_length_that_is_no_number_or_absurd_is_not_believed():
    for focal in (0, 1, 60000):
        assert camera(file(**{FOCAL_35: focal}), 0.2, (400, 300)).how == "assumed"


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF"])
def test_dots_per_inch_that_agree_with_the_scale_tell_a_scanner(kind):
    scan = file(kind=kind, dpi=(200, 200))
    assert scan_mm_per_px(scan, 0.1285) == pytest.approx(0.127, rel=2e-4)
    assert camera(scan, 0.1285, (400, 300)).distance_mm is None
    assert camera(scan, 0.135, (400, 300)) == (600.0, "assumed")  # 6 % off: the number in the file means nothing
    assert camera(file(kind=kind, dpi=(72, 72)), 0.15, (400, 300)) == (600.0, "assumed")


def test_a_scanners_resolution_is_better_than_a_coin_but_not_than_a_ruler():
    """The dark rim of a coin costs up to 2 %; whoever clicks a ruler is believed."""
    scan = file(dpi=(200, 200))
    assert confirmed(Scale(0.1292, "coin, 23.25 mm on 180 px"), scan).mm_per_px == pytest.approx(0.127)
    assert confirmed(Scale(0.1350, "coin, 23.25 mm on 172 px"), scan).mm_per_px == 0.1350
    assert confirmed(Scale(0.1275, "ruler, 150 mm on 1176 px"), scan).mm_per_px == 0.1275
    telephone = file(dpi=(200, 200), **{FOCAL_35: 400})  # what it says of dots means nothing
    assert camera_distance_mm(telephone, 0.1292) is not None
    assert confirmed(Scale(0.1292, "coin, 23.25 mm on 180 px"), telephone).mm_per_px == 0.1292
    assert confirmed(Scale(0.1292, "coin"), np.zeros((9, 9, 3), np.uint8)).mm_per_px == 0.1292
