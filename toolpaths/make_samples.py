"""Make the sample toolpaths anew: `python toolpaths/make_samples.py [NAME...]` rewrites their folders."""

from __future__ import annotations

import sys
from pathlib import Path

from making import carving, engraving, globe, relief
from making.texts import READMES, SETUPS

__all__ = ["files"]

SAMPLES = {"carving": carving, "relief": relief, "engraving": engraving, "globe": globe}
MESHES = {"carving": "part.stl", "relief": "part.stl", "engraving": "stock.stl", "globe": "part.stl"}


def files(name: str) -> dict[str, bytes]:
    """What the folder of a sample holds, by file name."""
    cl, mesh = SAMPLES[name].make()
    triangles = int.from_bytes(mesh[80:84], "little")
    readme = READMES[name].format(name=name, mesh=MESHES[name], triangles=triangles, **cl.counts)
    return {
        f"{name}.cls": cl.text().encode("ascii"),
        MESHES[name]: mesh,
        "setup.toml": SETUPS[name].encode("ascii"),
        "README.md": readme.encode("ascii"),
    }


def main(names: list[str]) -> int:
    """Write the samples of these names, all of them where none is named."""
    unknown = [name for name in names if name not in SAMPLES]
    if unknown:
        print(f"no sample is called {unknown[0]!r}: there are {', '.join(SAMPLES)}", file=sys.stderr)
        return 2
    for name in names or list(SAMPLES):
        folder = Path(__file__).parent / name
        folder.mkdir(exist_ok=True)
        for file, data in files(name).items():
            (folder / file).write_bytes(data)
            print(f"{folder.name}/{file}: {len(data)} bytes")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
