"""`python -m camrob.warm`: the kernels, ahead of time."""

import sys

from camrob.warm.ahead import main

__all__ = ["main"]

if __name__ == "__main__":
    sys.exit(main())
