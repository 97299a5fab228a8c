import subprocess
import sys

import numpy as np

from handlab.physics import compiled


def test_where_machine_code_cannot_be_kept_a_kernel_is_compiled_anyway(monkeypatch):
    real = compiled.njit

    def no_place(**options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return real(**options)

    monkeypatch.setattr(compiled, "njit", no_place)

    @compiled.compiled
    def twice(values, out):
        for k in range(len(values)):
            out[k] = 2.0 * values[k]

    out = np.empty(2)
    twice(np.array([1.0, 2.0]), out)
    np.testing.assert_array_equal(out, [2.0, 4.0])


def test_key_frames_and_clips_are_read_without_compiler_and_scipy():
    code = "import sys, handlab; handlab.keyframes({'FDP2': 0.5}).at(1.0); handlab.clips(); "
    code += "sys.exit(bool({'numba', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
