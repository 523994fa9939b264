"""Post a sample part and print what the program is worth.

    .venv/bin/python examples/post_a_part.py [OUT]

OUT (by default out/post_a_part) receives the program, its summary and its report.
"""

from __future__ import annotations

import sys
from pathlib import Path

from camrob import PostResult, post

ROOT = Path(__file__).resolve().parents[1]


def post_the_engraving(out: Path) -> PostResult:
    """The engraved plate for the KR15 cell, its set-up taken from the `setup.toml` beside the CL file."""
    clfile = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    return post(clfile, cell=ROOT / "cells" / "kr15_track_table", out=out)


def main(out: Path) -> None:
    """Post, then print the figures that decide whether one would run it."""
    result = post_the_engraving(out)
    conditioning, witness = result.summary.conditioning, result.summary.witness
    print(f"motions: {len(result.program)}")
    print(f"tip off the CL file by at most: {result.summary.verified.position_error_mm_max:.4f} mm")
    print(f"1/k_F: mean {conditioning.inv_kf_mean:.3f}, lowest {conditioning.inv_kf_min:.3f}")
    print(f"every motion judged by the witness: {'yes' if witness.complete else 'no'}")
    for finding in result.findings:
        print(f"{finding.severity.name.lower()}: {finding.text}")
    print("files:", ", ".join(str(result.out / name) for name in result.files))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "post_a_part")
