"""Results of the bench: which mutants are still to be run, counts, and the committed tables."""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from mutation.coverage import reach
from mutation.draw import Mutant, short
from mutation.run import Warm

Row = dict[str, Any]
COLUMNS = ("key", "room", "outcome", "class", "job", "does", "detail", "was")
TABLE = Path(__file__).resolve().parent.parent / "mutants_table.md"
QUICK, QUICK_JOBS = 1200, 60  # mutants and jobs of the quick run: a job costs half a second before the first mutant
SLOW_JOBS = ("planned", "optimal", "split", "again")
RELEASED = ("wrong", "wrong in part", "valid")
_STOPPED = "stopped"  # changed the program's text, which the gate did not release


def read(results: Path) -> dict[str, Row]:
    """The last row of each mutant."""
    if not results.is_file():
        return {}
    rows = [json.loads(line) for line in results.read_text(encoding="utf-8").splitlines() if line.strip()]
    return {row["key"]: row for row in rows}


def chosen(mutants: list[Mutant], results: Path, options: argparse.Namespace, warm: Warm) -> list[Mutant]:
    """The mutants that are to be run: those asked for, or the next ones that some job goes through."""
    earlier = read(results)
    if options.only:
        return [m for m in mutants if any(part in m.key for part in options.only)][: options.count]
    if options.again is not None:
        wanted = set(options.again or ["wrong"])
        return [m for m in mutants if m.key in earlier and earlier[m.key]["outcome"] in wanted]
    done = {*earlier, *(row["key"] for row in known(TABLE.with_suffix(".csv")))}
    out: list[Mutant] = []
    for m in mutants:
        if len(out) >= options.count:
            break
        if any(n in warm.baselines for n in reach(warm.package, m, warm.coverage)):
            out.append(m)
    return [m for m in out if m.key not in done]


def summary(results: Path, say: Callable[[str], None]) -> list[Row]:
    """Counts, said; the rows of wrong mutants."""
    rows = list(read(results).values())
    outcomes = Counter(row["outcome"] for row in rows)
    say(", ".join(f"{count} {name}" for name, count in outcomes.most_common()))
    wrong = [row for row in rows if row["outcome"] == "wrong"]
    say(f"changed the program: {sum(map(changed, rows))}; released and wrong: {len(wrong)}")
    for row in wrong:
        say(f"WRONG {row['key']} [{row['fault']}] {row['what']} | {row['job']}: {row['text']}")
    return wrong


def changed(row: Row) -> bool:
    """Whether a mutant changed the program's bytes, be it that they were released or stopped by the gate."""
    return row["outcome"] in RELEASED or bool(row["counts"].get("written"))


# -- tables -----------------------------------------------------------------------------------------------------


def write(results: Path, table: Path) -> None:
    """table (.md): counts and what was wrong; beside it the same name in .csv: every mutant that changed the program, those of
    earlier rounds among them, whose results nobody keeps.
    """
    rows = read(results)
    before = {row["key"]: row for row in known(table.with_suffix(".csv"))}
    out = [_entry(row, before.get(key, {})) for key, row in rows.items() if changed(row)]
    out = sorted([*out, *(row for key, row in before.items() if key not in rows)], key=lambda entry: entry["key"])
    with table.with_suffix(".csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(out)
    table.write_text(_page(list(rows.values()), out), encoding="utf-8")


def known(table: Path) -> list[dict[str, str]]:
    """The rows of a committed table, none where there is no such file."""
    if not table.is_file():
        return []
    with table.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _entry(row: Row, before: dict[str, str]) -> dict[str, str]:
    released = row["outcome"] in RELEASED
    outcome = row["outcome"] if released else _STOPPED
    kind = row["fault"] if outcome.startswith("wrong") else ", ".join(row["kinds"]) if released else ""
    was = before.get("was", "") or (before.get("class", "") if before.get("outcome") == "wrong" else "")
    detail = row["text"] if outcome.startswith("wrong") else "" if released else (row["errors"] or [""])[0]
    does = f"{row['operator']}: {row['what']}"
    job = row["job"] or row.get("shown", "")
    room = ".".join(row["module"].split(".")[1:2])
    return dict(zip(COLUMNS, (row["key"], room, outcome, kind, job, short(does), short(detail), was), strict=True))


def _page(rows: Sequence[Row], out: Sequence[dict[str, str]]) -> str:
    outcomes = Counter(row["outcome"] for row in rows)
    count = Counter(entry["outcome"] for entry in out)
    lines = [
        "# Mutants of camrob, released or not",
        "",
        "Made by `python tests/bench/mutants.py --count N`, then `--table`; [the rows](mutants_table.csv).",
        "",
        f"{len(out)} mutants, drawn by rule from every function that a job of the bench goes through, changed the program's "
        f"bytes: {count[_STOPPED]} were written and not released, {count['valid']} released and valid, **{count['wrong']} "
        f"released and wrong**, {count['wrong in part']} wrong where the program says itself that it "
        "was not judged (verified in part).",
        "",
        f"The last round ran {len(rows)} mutants:",
        "",
        "| outcome | mutants |",
        "| --- | --- |",
        *(f"| {_OUTCOMES.get(name, name)} | {number} |" for name, number in outcomes.most_common()),
        "",
        "## By room, all rounds",
        "",
        "| room | changed the program | released, valid | released, wrong |",
        "| --- | --- | --- | --- |",
    ]
    rooms: dict[str, Counter[str]] = {}
    for entry in out:
        rooms.setdefault(entry["room"], Counter()).update(["changed", entry["outcome"]])
    for room, tally in sorted(rooms.items()):
        lines.append(f"| {room} | {tally['changed']} | {tally['valid']} | {tally['wrong']} |")
    lines += ["", "## In what the valid ones differ", "", "| difference | mutants |", "| --- | --- |"]
    kinds = Counter(kind for entry in out if entry["outcome"] == "valid" for kind in entry["class"].split(", "))
    lines += [f"| {kind} | {number} |" for kind, number in kinds.most_common()]
    for outcome, title in (("wrong", "Released and wrong"), ("wrong in part", _IN_PART)):
        some = [entry for entry in out if entry["outcome"] == outcome]
        lines += ["", f"## {title}", ""]
        lines += [f"- `{e['key']}` ({e['class']}, {e['job']}): {e['does']}; {e['detail']}" for e in some] or ["None."]
    return "\n".join(lines) + "\n"


_IN_PART = "Wrong where the program says first of all that it was not judged (verified in part)"
_OUTCOMES = {
    "wrong in part": "wrong in a place that the program says was not judged (verified in part)",
    "same": "the same bytes on every job that goes through it",
    "kept": "only met by jobs of which nothing may come, and nothing came",
    "refused": "refused",
    "crashed": "stopped by an error that is none of camrob's own, nothing released",
    "hang": "not finished in its time, nothing released",
    "valid": "released, changed, valid",
    "wrong": "released and wrong",
    "gone": "another change than that of the table",
    "unreached": "no usable job goes through it",
    "inapplicable": "could not be put into a running process",
}


# -- the quick run ----------------------------------------------------------------------------------------------


def quick(table: Path, seed: int) -> list[tuple[str, str, str]]:
    """(key, job, what it does) of the committed table, those that were wrong once first, on the few jobs that show most of them;
    of those that are still in the source a run takes the first QUICK.

    Left out: what is wrong today (the table names it), and slow jobs.
    """
    rows = [row for row in known(table) if row["job"] and row["outcome"] != "wrong" and row["job"] not in SLOW_JOBS]
    often = Counter(row["job"] for row in rows)
    for row in rows:
        often[row["job"]] += 50 if row["was"] else 0
    jobs = {name for name, _ in often.most_common(QUICK_JOBS)}

    def order(row: dict[str, str]) -> tuple[bool, str]:
        return not row["was"], hashlib.sha256(f"{seed}{row['key']}".encode()).hexdigest()

    return [(row["key"], row["job"], row["does"]) for row in sorted(rows, key=order) if row["job"] in jobs]
