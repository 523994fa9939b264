"""Diagnoses of cases that `make` wrote, in one process, until a time: `answer.py DIR --out ANSWERS.jsonl --until 17:10`.

It never opens labels. What was answered already is passed over, so that a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import datetime
import json
import tempfile
import time
from pathlib import Path

KEEP = ("effect", "axes", "probability", "class", "class_probability", "shrink", "parameters")


def shortened(told, seconds):
    """What the scorer needs of a diagnosis.json."""
    unknown = {k: told["unknown"].get(k) for k in ("probability", "rms_mm", "share", "where", "text")}
    return {
        "status": told["status"],
        "effects": [{k: e.get(k) for k in KEEP} for e in told["effects"]],
        "alternatives": told["alternatives"],
        "unknown": unknown,
        "together": {
            k: told["together"].get(k) for k in ("shrink", "predicted_shrink", "rms_before_mm", "rms_after_mm")
        },
        "seconds": seconds,
    }


def answered(folder):
    """The answer to one case, or the error that there was instead."""
    import camrob
    from camrob.errors import CamrobError

    logs = sorted(folder.glob("run_*.csv"))
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as out:
        try:
            camrob.diagnose(cell=folder / "cell", log=logs, withheld=[folder / "withheld.csv"], out=Path(out))
        except CamrobError as error:
            return {"refused": str(error), "seconds": time.process_time() - begun}
        except Exception as error:  # a crash is an answer too: it is counted
            return {"error": f"{type(error).__name__}: {error}", "seconds": time.process_time() - begun}
        return shortened(json.loads((Path(out) / "diagnosis.json").read_text()), time.process_time() - begun)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--until", help="HH:MM: no case is begun behind it")
    parser.add_argument("--warm", type=Path, action="append", default=[], help="a case to compile on, not answered")
    given = parser.parse_args()
    for case in given.warm:
        answered(case)
    done = set()
    if given.out.exists():
        done = {json.loads(line)["seed"] for line in given.out.read_text().splitlines()}
    cases = sorted((p for p in given.folder.iterdir() if p.name.isdigit()), key=lambda p: int(p.name))
    for case in cases:
        if int(case.name) in done:
            continue
        if given.until and datetime.datetime.now().strftime("%H:%M") >= given.until:
            break
        with given.out.open("a") as file:
            file.write(json.dumps({"seed": int(case.name), "said": answered(case)}) + "\n")


if __name__ == "__main__":
    main()
