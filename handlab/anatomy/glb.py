"""Meshes in one glTF 2.0 binary file: it opens in any 3D viewer, and reads back here without a library.

The container is a JSON text and one block of numbers (Khronos glTF 2.0, sections 3 and 4). Written here because
loading a hand must take a fraction of a second, and because custom attributes (``_HEIGHT``) must survive.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy.records import Array

MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
COMPONENTS: dict[int, np.dtype[Any]] = {5121: np.dtype("<u1"), 5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
INDICES = "indices"
SKIN, BONE = 0, 1  # materials: without one a viewer shows polished metal, and some readers drop the texture coordinates
MATERIALS = [
    {"name": name, "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.7}}
    for name, colour in (("skin", [0.72, 0.45, 0.34, 1.0]), ("bone", [0.88, 0.83, 0.69, 1.0]))
]


def write_glb(
    path: Path, meshes: Mapping[str, Mapping[str, Array]], joints: tuple[str, ...], bodies: Mapping[str, str], notice: str
) -> None:
    """Write named meshes: per mesh ``indices`` (M, 3) and attributes such as ``POSITION`` (N, 3).

    ``joints`` are the rigid bodies that skin weights (``JOINTS_0``) number; ``bodies`` says which body carries a mesh.
    """
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "handlab", "copyright": notice},
        "scene": 0,
        "scenes": [{"nodes": []}],
        "nodes": [{"name": name} for name in joints],
        "materials": MATERIALS,
        "meshes": [],
        "accessors": [],
        "bufferViews": [],
    }
    block = bytearray()

    def accessor(array: Any, target: int) -> int:
        code = next(code for code, dtype in COMPONENTS.items() if dtype == array.dtype)
        width = 1 if array.ndim == 1 else array.shape[1]
        kind = next(kind for kind, size in WIDTHS.items() if size == width)
        block.extend(b"\0" * (-len(block) % 4))
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(block), "byteLength": array.nbytes, "target": target})
        block.extend(array.tobytes())
        entry = {"bufferView": len(document["bufferViews"]) - 1, "componentType": code, "count": len(array), "type": kind}
        if target == ARRAY_BUFFER and kind == "VEC3":
            entry |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        document["accessors"].append(entry)
        return len(document["accessors"]) - 1

    for name, arrays in meshes.items():
        indices = np.asarray(arrays[INDICES]).ravel().astype("<u2" if len(arrays["POSITION"]) < 65535 else "<u4")
        attributes = {
            key: accessor(np.asarray(values).astype("<u1" if key == "JOINTS_0" else "<f4"), ARRAY_BUFFER)
            for key, values in arrays.items()
            if key != INDICES
        }
        surface = {
            "attributes": attributes,
            "indices": accessor(indices, ELEMENT_ARRAY_BUFFER),
            "material": BONE if name in bodies else SKIN,
        }
        document["meshes"].append({"name": name, "primitives": [surface]})
        node: dict[str, Any] = {"name": name, "mesh": len(document["meshes"]) - 1}
        document["nodes"].append(node)
        number = len(document["nodes"]) - 1
        if name in bodies:
            document["nodes"][joints.index(bodies[name])].setdefault("children", []).append(number)
        else:
            document["scenes"][0]["nodes"].append(number)
        if "JOINTS_0" in arrays:
            node["skin"] = 0
    document["scenes"][0]["nodes"] += list(range(len(joints)))
    document["skins"] = [{"joints": list(range(len(joints)))}]
    block.extend(b"\0" * (-len(block) % 4))
    document["buffers"] = [{"byteLength": len(block)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    header = struct.pack("<III", MAGIC, VERSION, 12 + 8 + len(text) + 8 + len(block))
    path.write_bytes(
        header + struct.pack("<II", len(text), JSON_CHUNK) + text + struct.pack("<II", len(block), BINARY_CHUNK) + bytes(block)
    )


def read_glb(path: Path) -> dict[str, dict[str, Any]]:
    """Meshes by name: ``indices`` (M, 3) and attributes, as stored (float32). Raises ``ValueError`` on a broken file."""
    data = path.read_bytes()
    try:
        magic, version, length = struct.unpack_from("<III", data, 0)
        if magic != MAGIC or version != VERSION or length != len(data):
            raise ValueError("not a complete glTF 2.0 binary file")
        size, _ = struct.unpack_from("<II", data, 12)
        document = json.loads(data[20 : 20 + size])
        start = 20 + size + 8
        meshes = {}
        for mesh in document["meshes"]:
            primitive = mesh["primitives"][0]
            arrays = {key: _array(document, data, start, number) for key, number in primitive["attributes"].items()}
            meshes[mesh["name"]] = arrays | {INDICES: _array(document, data, start, primitive["indices"]).reshape(-1, 3)}
    except (struct.error, KeyError, IndexError, TypeError, ValueError) as error:
        raise ValueError(f"{path} is not a hand's mesh file: {error}; build or download it again") from error
    return meshes


def _array(document: dict[str, Any], data: bytes, start: int, number: int) -> Any:
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    width = WIDTHS[accessor["type"]]
    values = np.frombuffer(data, COMPONENTS[accessor["componentType"]], accessor["count"] * width, start + view["byteOffset"])
    return values if width == 1 else values.reshape(-1, width)
