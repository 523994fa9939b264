"""Where the compiled kernels are kept, whichever of Numba and camrob is imported first."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ASK = "from camrob.kinematics.kernels import inverse_kf_many; print(inverse_kf_many.dispatcher._cache.cache_path)"


def _place(first: str, home: Path, **more: str) -> Path:
    """The folder that a fresh process keeps a kernel in."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {"XDG_CACHE_HOME": str(home), **more}
    made = subprocess.run(
        [sys.executable, "-c", f"{first}; import camrob; {ASK}"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return Path(made.stdout.strip())


@pytest.mark.parametrize("first", ["import sys", "import numba", "from numba import njit"])
def test_kernels_are_kept_in_camrobs_folder(first: str, tmp_path: Path) -> None:
    place = _place(first, tmp_path)
    assert place.is_relative_to(tmp_path / "camrob")
    assert place.relative_to(tmp_path / "camrob").parts[0].startswith("kernels-")


def test_a_folder_that_the_user_set_is_left_alone(tmp_path: Path) -> None:
    own = tmp_path / "own"
    assert _place("import numba", tmp_path, NUMBA_CACHE_DIR=str(own)).is_relative_to(own)
