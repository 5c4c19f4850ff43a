"""Where things are. Not in conftest.py: another folder's has the same name."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = Path(os.environ.get("FEELER_LIBRARY", ROOT / "build"))
