"""How kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(kernel: F) -> F:
    """Compile a function of arrays on its first call: without the interpreter's lock, kept on disk for the next session.

    Where the package lies in a folder that cannot be written and there is no home either, it compiles anew each session.
    """
    return _kept(kernel)


def fused(kernel: F) -> F:
    """``compiled``, and a product may join the sum it goes into, rounded once instead of twice. The last bit then depends on the
    processor: for sums that nothing is built upon step by step."""
    return _kept(kernel, fastmath={"contract"})


def _kept(kernel: F, **options: Any) -> F:
    options = {"nogil": True, "error_model": "numpy", **options}
    try:
        return cast(F, njit(cache=True, **options)(kernel))
    except RuntimeError:
        return cast(F, njit(**options)(kernel))
