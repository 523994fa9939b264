"""What a program's text says of each of its motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.program.program_text import ProgramText

__all__ = ["said_lines"]


def said_lines(folder: Path, text: ProgramText, motion: NDArray[np.int64]) -> list[str]:
    """File, line and statement of each row (N,) of a program whose files lie in `folder`; nothing for a row below 0."""
    written = [(folder / name).read_text(encoding="utf-8", errors="replace").splitlines() for name in text.files]
    said = {}
    for row in np.unique(motion[motion >= 0]).tolist():
        file, line = int(text.file[row]), int(text.line[row])
        said[row] = f"{text.files[file]} {line}: {written[file][line - 1].strip()}"
    return [said.get(row, "") for row in motion.tolist()]
