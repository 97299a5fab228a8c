"""Known people and their photographs, for the tests of this folder."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # for people.py and photograph.py: tests are imported one by one
