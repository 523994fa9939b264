"""What comes with camrob beside its code: cells and samples, inside the wheel or, in a checkout, where they are kept."""

from __future__ import annotations

from pathlib import Path

from camrob.errors import InputError

__all__ = ["cell_beside", "demand_cell", "shipped_cell", "shipped_cells", "shipped_samples"]

_PACKAGE = Path(__file__).resolve().parent


def shipped_cells() -> dict[str, Path]:
    """Name to folder of every cell that comes with camrob."""
    return _folders("cells", "cell.toml")


def shipped_samples() -> dict[str, Path]:
    """Name to folder of every sample: a CL file, its setup.toml and the meshes that it names."""
    return _folders("toolpaths", "setup.toml")


def shipped_cell(name: str) -> Path:
    """The folder of a cell that comes with camrob, for `cell=`.

    Args:
        name: as `camrob cell list` prints it.

    Returns:
        The folder.

    Raises:
        InputError: another name.

    Example:
        >>> camrob.shipped_cell("ta1400_weld").name
        'ta1400_weld'
    """
    cells = shipped_cells()
    if name not in cells:
        raise InputError(f"no cell {name[:60]!r} comes with camrob", hint=f"take one of {', '.join(cells)}")
    return cells[name]


def cell_beside(folder: Path, named: str) -> Path:
    """The cell that a file in a folder names: a path from there, or where nothing is there the shipped cell of that name."""
    path = folder / named
    return path if path.exists() else shipped_cells().get(named, path)


def demand_cell(path: Path, named: str) -> None:
    """Raise InputError where a bare name is neither a path, that it was taken for, nor a shipped cell's."""
    if path.exists() or Path(named).suffix or len(Path(named).parts) != 1:
        return
    what = f"there is no folder {named[:60]!r}, and no cell of that name comes with camrob"
    raise InputError(what, hint=f"give the cell's folder, or one of {', '.join(shipped_cells())}")


def _folders(kind: str, holding: str) -> dict[str, Path]:
    """Folders of a kind that hold a certain file: those of the wheel (setup.py puts them there), else the checkout's."""
    inside = _PACKAGE / "_shipped" / kind
    parent = inside if inside.is_dir() else _PACKAGE.parent / kind
    return {file.parent.name: file.parent for file in sorted(parent.glob(f"*/{holding}"))}
