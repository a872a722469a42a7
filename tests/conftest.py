"""What all tests share."""

import os

# the matrices are small: threads of the linear algebra only get into each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
