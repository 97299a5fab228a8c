"""Pictures of newer telephones (HEIC), read by an extra package: ``pip install "handlab[photo]"``."""

from __future__ import annotations

BRANDS = (b"heic", b"heix", b"hevc", b"heim", b"heis", b"mif1", b"msf1", b"heif")


def is_heic(data: bytes) -> bool:
    """Whether the first bytes of a file are those of a HEIC picture."""
    return data[4:8] == b"ftyp" and data[8:12] in BRANDS


def readable(data: bytes) -> bool:
    """Whether ``data`` is a HEIC picture that can be read here; if so, Pillow opens it from now on."""
    if not is_heic(data):
        return False
    try:
        from pi_heif import register_heif_opener
    except ImportError:
        return False
    register_heif_opener()
    return True
