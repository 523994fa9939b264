"""`python -m camrob.cli`: the command line."""

from camrob.cli.app import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
