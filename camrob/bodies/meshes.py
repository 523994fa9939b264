"""Meshes of a cell and of a job as triangles in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.setup import Body
from camrob.errors import InputError, SetupError

__all__ = ["body_triangles", "read_triangles", "wraps"]

Array = NDArray[np.float64]

_KINDS = (".stl", ".obj", ".ply", ".off")
_STL_HEAD = 84  # bytes before the first facet: 80 of any kind, and the facets' number
_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_BOX_FACES = np.array(
    [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ]
)


def read_triangles(path: Path, scale: float, error: type[InputError] = SetupError) -> Array:
    """Triangles (k, 3, 3) of a mesh file, k > 0, coordinates multiplied by `scale`; flat ones are left out.

    Raises `error`, naming the file, where it can't be read as STL, OBJ, PLY or OFF or holds no surface.
    """
    if path.suffix.lower() not in _KINDS:
        raise error("is not a mesh that camrob reads", hint="give STL, OBJ, PLY or OFF", path=path)
    try:
        found = _binary_stl(path)
        if found is None:
            import trimesh  # takes as long to import as a small post to run: only where it has something to tell apart

            found = np.array(trimesh.load(str(path), force="mesh", process=False, skip_materials=True).triangles, float)
        triangles = found * scale
    except OSError as e:
        raise error(f"can't be read ({e.strerror or 'no such file'})", hint="check the path", path=path) from None
    except Exception as e:  # the readers of meshes raise whatever they stumble over
        raise error(f"is not a readable mesh ({type(e).__name__})", hint="export it again", path=path) from None
    if triangles.ndim != 3 or not len(triangles) or not np.all(np.isfinite(triangles)):
        raise error("holds no triangles, or some that are not numbers", hint="export it again", path=path)
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    solid = np.asarray(triangles[area > 0.0])
    if not len(solid):
        raise error("holds no surface", hint="export it again", path=path)
    return solid


def _binary_stl(path: Path) -> Array | None:
    """Triangles (k, 3, 3) of an STL file whose size says that it is a binary one, None of any other file."""
    if path.suffix.lower() != ".stl":
        return None
    data = path.read_bytes()
    count = int.from_bytes(data[_STL_HEAD - 4 : _STL_HEAD], "little")
    if len(data) != _STL_HEAD + count * _STL_FACET.itemsize:
        return None
    return np.asarray(np.frombuffer(data, _STL_FACET, offset=_STL_HEAD)["corners"], np.float64)


def body_triangles(body: Body) -> Array:
    """Triangles (k, 3, 3) of a part or stock in the frame `part`. Raises SetupError where its mesh can't be read."""
    if body.mesh is not None:
        return read_triangles(body.mesh, body.scale)
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    return np.asarray((body.lower + corners * (body.upper - body.lower))[_BOX_FACES])


def wraps(triangles: Array, point: Array) -> bool:
    """Whether a point (3,) lies inside a surface: its winding number by the triangles' solid angles.

    After van Oosterom and Strackee, The solid angle of a plane triangle, 1983; small holes do little harm.
    """
    a, b, c = (triangles[:, k] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    under = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la
    under += np.einsum("ij,ij->i", c, a) * lb
    turns = float(np.sum(np.arctan2(volume, under))) / (2.0 * np.pi)
    return abs(turns) > 0.5
