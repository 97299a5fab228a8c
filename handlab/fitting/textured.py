"""A skin with its photograph in one glTF binary file (Khronos glTF 2.0): any 3D viewer opens it."""

from __future__ import annotations

import io
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy.glb import ARRAY_BUFFER, BINARY_CHUNK, ELEMENT_ARRAY_BUFFER, JSON_CHUNK, MAGIC, VERSION
from handlab.anatomy.meshes import FineSkin
from handlab.anatomy.store import seams
from handlab.fitting.texture import Texture

UNSIGNED, FLOAT = 5125, 5126  # component types of glTF
ROUGHNESS = 0.7


def png(texture: Texture) -> bytes:
    """The texture as a PNG file."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.asarray(texture.pixels)).save(stream, format="PNG", optimize=True)
    return stream.getvalue()


def save_textured(skin: FineSkin, texture: Texture, path: str | os.PathLike[str]) -> Path:
    """Write ``skin`` with its picture as ``path`` (.glb), whole or not at all.

    Raises ``ValueError`` for another suffix, ``OSError`` if the file cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() != ".glb":
        raise ValueError(f"{file.name}: a skin with its picture is written as .glb")
    indices, point, place = seams(skin.faces, skin.texture)
    blocks = [
        (skin.points[point].astype("<f4"), ARRAY_BUFFER, FLOAT, "VEC3"),
        (_normals(skin)[point].astype("<f4"), ARRAY_BUFFER, FLOAT, "VEC3"),
        (place.astype("<f4"), ARRAY_BUFFER, FLOAT, "VEC2"),
        (indices.ravel().astype("<u4"), ELEMENT_ARRAY_BUFFER, UNSIGNED, "SCALAR"),
    ]
    binary = bytearray()
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    for array, target, component, kind in blocks:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes, "target": target})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
        binary += array.tobytes()
    accessors[0] |= {"min": blocks[0][0].min(axis=0).tolist(), "max": blocks[0][0].max(axis=0).tolist()}
    image = png(texture)
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(image)})
    binary += image + b"\0" * (-len(image) % 4)
    surface = {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}
    skin_material = {
        "name": "skin",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS},
    }
    document = {
        "asset": {"version": "2.0", "generator": "handlab"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "skin_fine", "mesh": 0}],
        "meshes": [{"name": "skin_fine", "primitives": [surface]}],
        "materials": [skin_material],
        "textures": [{"source": 0}],
        "images": [{"bufferView": len(views) - 1, "mimeType": "image/png"}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    header = struct.pack("<III", MAGIC, VERSION, 28 + len(text) + len(binary)) + struct.pack("<II", len(text), JSON_CHUNK)
    part = file.with_name(f".{file.name}.part")
    try:
        part.write_bytes(header + text + struct.pack("<II", len(binary), BINARY_CHUNK) + bytes(binary))
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file


def _normals(skin: FineSkin) -> Any:
    a, b, c = (skin.points[skin.faces[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(skin.points)
    for i in range(3):
        np.add.at(normals, skin.faces[:, i], area)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
