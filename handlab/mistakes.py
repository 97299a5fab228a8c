"""How the command answers mistakes: one sentence on standard error and an exit code, never a traceback."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError, UnusedCliTokensError

TROUBLE = 1
USAGE_ERROR = 2
INTERRUPTED = 130


def answered(app: App, arguments: Sequence[str]) -> int:
    """The exit code of a command line: 0, 1 (doctor found trouble), 2 (a mistake, in one sentence), 130 (interrupted).

    With HANDLAB_DEBUG=1 errors are raised.
    """
    if os.environ.get("HANDLAB_DEBUG") == "1":
        return int(app(list(arguments)) or 0)
    try:
        return int(app(list(arguments)) or 0)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        sys.stdout = None  # the reader (head, less) has seen enough; Python would complain again when it closes the stream
        return 0
    except UnusedCliTokensError as error:
        extra = list(error.unused_tokens or ())
        first = list(arguments[:1]) == extra[:1]
        return complain(no_command(app, extra[0]) if first else f"cannot tell what {' '.join(extra)!r} means here")
    except CycloptsError as error:
        return complain(str(error))
    except (ValueError, LookupError, OSError, RuntimeError, TypeError) as error:
        return complain(str(error) or type(error).__name__)
    except Exception as error:
        return complain(f"{type(error).__name__}: {error} (this should not happen; HANDLAB_DEBUG=1 shows where)")


def no_command(app: App, word: str) -> str:
    """What to say about a word that is no command, with the nearest ones."""
    from handlab.anatomy.terms import find

    try:
        find(word, [name for name in app if not name.startswith("-")], kind="command")
    except LookupError as error:
        return str(error)
    return f"{word!r} stands in the wrong place"


def complain(text: str) -> int:
    """One sentence on standard error."""
    sys.stderr.write(f"handlab: {' '.join(text.split())}\n")
    return USAGE_ERROR
