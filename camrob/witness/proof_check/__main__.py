"""`python -m camrob.witness.proof_check NAME.proof.npz CELL/cell.toml`: proves a plan's bound again, and says it."""

from __future__ import annotations

import sys
from pathlib import Path

from camrob.witness.proof_check.check_plan import check

__all__ = ["main"]


def main(arguments: list[str]) -> int:
    """Check the certificate that was named; 0 where it proves its bound, 1 where it doesn't, 2 where none was named."""
    if len(arguments) != 2:
        print(__doc__)
        return 2
    try:
        bound = check(Path(arguments[0]), Path(arguments[1]), say=lambda text: print(text, flush=True))
    except (OSError, KeyError, ValueError) as error:
        print(f"not proved: {error}")
        return 1
    print(f"proved: no plan through these waypoints costs less than {bound:.4f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
