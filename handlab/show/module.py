"""The viewer's ES module: a few files that a server may serve as they are, or one text for places that take only one."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

STATIC = Path(__file__).parent / "static"
# each imports only what stands before it
PARTS = ("flesh.js", "lean.js", "hand3d.js", "nodes.js", "plots.js", "style.js", "recorded.js", "viewer.js")
PAINT = ("flesh.js", "lean.js", "hand3d.js", "nodes.js", "drawing.js", "style.js", "paint.js")
FIT = ("nodes.js", "drawing.js", "fit.js")
ENTRY = "viewer.js"
OWN_IMPORT = re.compile(r'^import \{[^}]*\} from "\./[a-z0-9]+\.js";\n', flags=re.MULTILINE)


@cache
def joined(parts: tuple[str, ...]) -> str:
    """Files as one plain piece of a script, without imports of one another and without exports."""
    text = "\n".join(OWN_IMPORT.sub("", (STATIC / part).read_text(encoding="utf-8")) for part in parts)
    return re.sub(r"^export (?=(?:async )?(?:function|class|const) )", "", text, flags=re.MULTILINE)


def viewer_module(*, exports: bool = True) -> str:
    """All parts as one module that exports ``mount`` and ``recorded``; without ``exports`` it is a plain piece of a script."""
    return joined(PARTS) + ("\nexport { mount, recorded };\n" if exports else "")
