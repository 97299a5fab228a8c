"""The two halves of a ``.glb`` (glTF 2.0 in one file) in the making: a JSON text and a block of numbers."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.glb import ARRAY_BUFFER, BINARY_CHUNK, COMPONENTS, ELEMENT_ARRAY_BUFFER, JSON_CHUNK, MAGIC, VERSION, WIDTHS
from handlab.anatomy.records import Array

# Distal is up, the palm looks at the viewer: (x, y, z) of the hand becomes (y, z, x) of the scene's (z, x, y).
UPRIGHT = [0.5, 0.5, 0.5, 0.5]


class Document:
    """The JSON half and the block of numbers of a ``.glb`` in the making."""

    def __init__(self, notice: str) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "handlab", "copyright": notice},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "hand", "rotation": UPRIGHT, "children": []}],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }
        self._block = bytearray()

    def accessor(self, array: NDArray[Any], *, target: int | None = None, normalized: bool = False, bounds: bool = False) -> int:
        """Append an array (n,) or (n, width); its number."""
        code = next(code for code, dtype in COMPONENTS.items() if dtype == array.dtype)
        width = 1 if array.ndim == 1 else array.shape[1]
        view = self.view(np.ascontiguousarray(array).tobytes(), target)
        kind = next(kind for kind, size in WIDTHS.items() if size == width)
        entry: dict[str, Any] = {"bufferView": view, "componentType": code, "count": len(array), "type": kind}
        if normalized:
            entry["normalized"] = True
        if bounds:
            flat = array.reshape(len(array), width)
            entry |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        return self.add("accessors", entry)

    def view(self, content: bytes, target: int | None = None) -> int:
        """Append bytes; the number of their view."""
        self._block.extend(b"\0" * (-len(self._block) % 4))
        entry = {"buffer": 0, "byteOffset": len(self._block), "byteLength": len(content)} | ({} if target is None else {"target": target})
        self._block.extend(content)
        return self.add("bufferViews", entry)

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Append an entry; its number."""
        self.json.setdefault(kind, []).append(entry)
        return len(self.json[kind]) - 1

    def node(self, entry: dict[str, Any], parent: int = 0) -> int:
        """Append a node below another; its number."""
        number = self.add("nodes", entry)
        self.json["nodes"][parent].setdefault("children", []).append(number)
        return number

    def points(self, array: Array) -> int:
        """Positions, with the bounds that the format wants."""
        return self.accessor(np.asarray(array, dtype="<f4"), target=ARRAY_BUFFER, bounds=True)

    def faces(self, faces: Any) -> int:
        """Triangles."""
        return self.accessor(np.asarray(faces).astype("<u2").ravel(), target=ELEMENT_ARRAY_BUFFER)

    def file(self) -> bytes:
        """The file."""
        block = bytes(self._block) + b"\0" * (-len(self._block) % 4)
        self.json["buffers"] = [{"byteLength": len(block)}]
        text = json.dumps(self.json, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        header = struct.pack("<III", MAGIC, VERSION, 12 + 8 + len(text) + 8 + len(block))
        return header + struct.pack("<II", len(text), JSON_CHUNK) + text + struct.pack("<II", len(block), BINARY_CHUNK) + block
