"""`python -m camrob`: the command line, where the `camrob` command isn't on the path."""

import sys

from camrob.cli import main

__all__ = ["main"]

if __name__ == "__main__":
    sys.exit(main())
