"""What all tests share."""

import os
import sys
from pathlib import Path

# the matrices are small: threads of the linear algebra only get into each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# the formulas behind the reference values: collision.py, cooling.py, displacement.py, densities.py
sys.path.insert(0, str(Path(__file__).with_name("references")))
