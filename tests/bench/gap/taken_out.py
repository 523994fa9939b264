"""Every effect taken out of the library: `python tests/bench/gap/taken_out.py --each 20 --out DIR` writes DIR/taken_out.md.

Cases of one effect each, of 2 to 20 times the noise, from the sealed generator, diagnosed by a library that lacks its name. Right
is to say that something unknown is there, or what the path can't tell from it (the scorer simulates that). Worst is a name above
0.8 that the path does tell from it. A run that was stopped goes on where it stood; `--score` writes the table of what is there.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from gap.benchmark import read_lines, run
from gap.score import Row, of, rows_of

SURE = 0.8


def judged(row: Row) -> dict[str, bool]:
    """What of an answer is right or wrong."""
    alike = row.within()
    sure = any(e["probability"] > SURE for e in row.said["effects"])
    return {
        "flagged unknown": row.flagged,
        "said to be what looks the same": alike,
        "either": row.flagged or alike,
        f"a wrong name above {SURE:g}": sure and not alike,
    }


def table(rows: Sequence[Row]) -> list[str]:
    """A row an effect, and all, with 95 % intervals (Wilson)."""
    told = [(r, judged(r)) for r in rows]
    kinds = list(told[0][1]) if told else []
    lines = [
        f"| taken out | cases | {' | '.join(kinds)} | wrong names |",
        "| --- | --- |" + " --- |" * (len(kinds) + 1),
    ]
    for name in sorted({r.task["only"] for r in rows}):
        own = [(r, j) for r, j in told if r.task["only"] == name]
        wrong = [
            f"{e['effect']} {e['probability']:.2f} ({r.task['seed']})"
            for r, j in own
            if j[kinds[-1]]
            for e in r.said["effects"]
            if e["probability"] > SURE
        ]
        counts = " | ".join(str(sum(j[k] for _, j in own)) for k in kinds)
        lines.append(f"| {name} | {len(own)} | {counts} | {', '.join(wrong)} |")
    records = [of(j[k] for _, j in told) for k in kinds]
    ends = [
        f"{r['hits']} ({100 * r['interval'][0]:.1f} to {100 * r['interval'][1]:.1f} %)" if r["count"] else "-"
        for r in records
    ]
    return [*lines, f"| all | {len(rows)} | {' | '.join(ends)} | |"]


def main() -> None:
    """Run, and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--each", type=int, default=20, help="cases of every effect")
    parser.add_argument("--first", type=int, default=700_000, help="the first seed")
    parser.add_argument("--only", nargs="+", help="names of the effects, where not all are wanted")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--score", action="store_true", help="only write the table of what is there")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    if not arguments.score:
        run(
            argparse.Namespace(
                cases=0,
                nothing=0,
                each=0,
                left_out=arguments.each,
                first=arguments.first,
                only=arguments.only,
                workers=arguments.workers,
                out=arguments.out,
            )
        )
    labels = read_lines(arguments.out / "sealed" / "labels.jsonl")
    rows = rows_of(labels, read_lines(arguments.out / "answers.jsonl"))
    answered = [r for r in rows if r.group == "left out" and "error" not in r.said]
    head = [
        "# Every effect taken out of the library in turn",
        "",
        f"`python tests/bench/gap/taken_out.py --each {arguments.each} --first {arguments.first}`",
        f"({len(answered)} cases answered, {len(rows) - len(answered)} ended with an error). Intervals are 95 % (Wilson).",
        "",
    ]
    (arguments.out / "taken_out.md").write_text("\n".join([*head, *table(answered)]) + "\n")


if __name__ == "__main__":
    main()
