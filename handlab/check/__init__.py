"""Self-checks of the lessons' exercises.

>>> from handlab.check import lesson
>>> check = lesson("00")
>>> check("knuckles", ..., ...)
[ ] knuckles: not answered yet. Put your answer where the dots (...) are, and run the cell again.

A check never stops a notebook: an open answer is noted, a wrong one is explained. With ``HANDLAB_STRICT=1`` in the environment
both raise, so that a course (and the build) can insist.
"""

from handlab.check.lesson import Lesson, lesson
from handlab.check.verdict import NotAnswered, Verdict, WrongAnswer

__all__ = ["Lesson", "NotAnswered", "Verdict", "WrongAnswer", "lesson"]
