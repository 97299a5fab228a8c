"""Photographs as people have them, and files that are none."""

import io
import struct
import sys
import zlib

import numpy as np
import pytest
from PIL import Image

from handlab.fitting.lens import camera_distance_mm
from handlab.fitting.pictures import load_picture

ORIENTATION, EXIF_IFD, FOCAL_35 = 0x0112, 0x8769, 0xA405


def scene(width=120, height=90):
    """A picture whose upper left quarter is red: it shows which way is up."""
    pixels = np.full((height, width, 3), 30, np.uint8)
    pixels[: height // 2, : width // 2] = [220, 20, 20]
    return pixels


def encoded(pixels, kind="PNG", **options):
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, format=kind, **options)
    return stream.getvalue()


def exif(**tags):
    data = Image.Exif()
    for tag, value in tags.items():
        data[int(tag[1:])] = value
    return data


def png_of_size(width, height):
    """A PNG that claims a size and holds almost nothing."""

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP", "TIFF", "BMP"])
def test_a_picture_of_every_kind_comes_as_red_green_blue_rows_and_columns(kind, tmp_path):
    file = tmp_path / f"hand.{kind.lower()}"
    file.write_bytes(encoded(scene(), kind))
    found = load_picture(file)
    assert found.shape == (90, 120, 3) and found.dtype == np.uint8 and not found.flags.writeable
    assert np.abs(found[10, 10].astype(int) - [220, 20, 20]).max() < 12 and found[80, 110].max() < 45


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_picture_is_turned_upright_as_its_exif_data_say(orientation):
    upright = scene()
    stored = {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: upright.transpose(1, 0, 2),
        6: np.rot90(upright, 1),
        7: np.rot90(upright, 2).transpose(1, 0, 2),
        8: np.rot90(upright, -1),
    }[orientation]
    found = load_picture(encoded(np.ascontiguousarray(stored), "PNG", exif=exif(t274=orientation)))
    np.testing.assert_array_equal(found, upright)


@pytest.mark.parametrize("mode", ["L", "1", "P", "RGBA", "LA", "CMYK", "I;16"])
def test_grey_palette_transparent_and_printers_pictures_become_colour(mode):
    if mode == "I;16":
        stream = io.BytesIO()
        Image.fromarray(scene()[:, :, 0].astype(np.uint16) * 257).save(stream, format="PNG")
        data = stream.getvalue()
    else:
        stream = io.BytesIO()
        Image.fromarray(scene()).convert(mode).save(stream, format="TIFF" if mode == "CMYK" else "PNG")
        data = stream.getvalue()
    found = load_picture(data)
    assert found.shape == (90, 120, 3)
    assert found[5:40, 5:55].mean() > found[50:85, 65:115].mean() + 10


def test_transparent_parts_become_white():
    clear = np.dstack([scene(), np.zeros((90, 120), np.uint8)])
    assert load_picture(encoded(clear)).min() == 255


def test_pixels_are_taken_as_they_are():
    np.testing.assert_array_equal(load_picture(scene()), scene())
    assert load_picture(scene()[:, :, 0]).shape == (90, 120, 3)


def test_fifty_megapixels_are_read():
    width, height = 8192, 6144
    stream = io.BytesIO()
    Image.new("RGB", (width, height), (180, 140, 120)).save(stream, format="JPEG", quality=20)
    assert load_picture(stream.getvalue()).shape == (height, width, 3)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "empty"),
        (b"this is a letter, not a picture", "not a picture that can be read"),
        (b"%PDF-1.7 something", "not a picture that can be read"),
        (encoded(scene(400, 300), "JPEG")[:2000], "damaged or cut off"),
        (encoded(np.random.default_rng(0).integers(0, 255, (200, 200, 3), dtype=np.uint8))[:5000], "damaged or cut off"),
        (png_of_size(20000, 20000), "million"),
        (png_of_size(31000, 100), "million"),
        (png_of_size(300, 300), "damaged or cut off"),
        (encoded(scene(30, 30)), "a hand needs a few hundred"),
    ],
    ids=["empty", "text", "pdf", "cut jpeg", "cut png", "bomb", "far too wide", "almost nothing in it", "tiny"],
)
def test_what_is_no_picture_is_refused_in_one_sentence(data, says, tmp_path):
    file = tmp_path / "hand.jpg"
    file.write_bytes(data)
    with pytest.raises(ValueError, match=says) as caught:
        load_picture(file)
    assert "hand.jpg" in str(caught.value) and "\n" not in str(caught.value)


def test_a_bomb_is_refused_before_it_is_unpacked():
    import tracemalloc

    tracemalloc.start()
    with pytest.raises(ValueError, match="million"):
        load_picture(png_of_size(30000, 30000))
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_a_missing_picture_and_a_folder_are_told_apart(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no picture"):
        load_picture(tmp_path / "none.jpg")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        load_picture(tmp_path)


HEIC_HEAD = b"\0\0\0\x18ftypheic\0\0\0\0mif1heic"


def test_a_heic_picture_comes_upright_and_tells_the_distance_of_its_camera():
    """Stored lying on its side, with the turn that its EXIF data ask for, as telephones do."""
    heif = pytest.importorskip("pillow_heif")
    pytest.importorskip("pi_heif")
    notes = exif(t274=6)  # turn it by 90 degrees clockwise to see it upright
    notes.get_ifd(EXIF_IFD)[FOCAL_35] = 26
    stored = Image.fromarray(np.rot90(scene(400, 300), 1).copy())
    stream = io.BytesIO()
    heif.from_pillow(stored).save(stream, quality=90, exif=notes.tobytes())
    found = load_picture(stream.getvalue())
    assert found.shape == (300, 400, 3)
    assert np.abs(found.astype(int) - scene(400, 300)).mean() < 4.0
    assert camera_distance_mm(stream.getvalue(), 1.0) == pytest.approx(26.0 / 43.27 * 500.0, rel=1e-3)
    for size in (100, 600, len(stream.getvalue()) - 400):
        with pytest.raises(ValueError, match="damaged or cut off"):
            load_picture(stream.getvalue()[:size])


def test_a_heic_picture_names_the_package_that_reads_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pi_heif", None)
    with pytest.raises(ValueError, match=r'pip install "handlab\[photo\]"'):
        load_picture(HEIC_HEAD + b"\0" * 100)


def test_half_pictures_stay_refused_when_another_package_allows_them(monkeypatch):
    from PIL import ImageFile

    monkeypatch.setattr(ImageFile, "LOAD_TRUNCATED_IMAGES", True)
    with pytest.raises(ValueError, match="damaged or cut off"):
        load_picture(encoded(scene(400, 300), "JPEG")[:2000])
    assert ImageFile.LOAD_TRUNCATED_IMAGES is True


@pytest.mark.parametrize("bad", [np.zeros((9, 9)), np.zeros((100, 100, 5), np.uint8), np.zeros((100, 100, 3)), np.zeros(4, np.uint8)])
def test_an_array_that_is_no_picture_is_refused(bad):
    with pytest.raises(ValueError, match=r"picture|pixels"):
        load_picture(bad)
