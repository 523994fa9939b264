"""Counts, and the table that is committed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from text_faults.run import Outcome, read

_ANSWERS = ("refused", "not judged", "input error", "crash", "hang", "pass")


def summary(outcomes: Sequence[Outcome]) -> str:
    """The counts, and everything that came out badly with its edit."""
    lines = [_count(outcomes, verdict) for verdict in ("wrong", "legal", "open", "same")]
    for outcome in outcomes:
        if outcome.bad:
            lines += ["", f"{outcome.key} ({outcome.verdict}, {', '.join(outcome.differs)}): {outcome.answer}"]
            lines += [f"    {line}" for line in (*outcome.edit.splitlines(), outcome.said) if line]
    return "\n".join(lines)


def _count(outcomes: Sequence[Outcome], verdict: str) -> str:
    answers = Counter(o.answer for o in outcomes if o.verdict == verdict)
    return f"{verdict:6}: {sum(answers.values()):4}, " + ", ".join(f"{answers[a]} {a}" for a in _ANSWERS)


def write(results: Path, table: Path) -> None:
    """The table of the results of a whole run."""
    outcomes = read(results)
    wrong, legal = ([o for o in outcomes if o.verdict == v] for v in ("wrong", "legal"))
    text = [
        "# Faults in program text",
        "",
        "Made by `python tests/bench/text_faults.py` and `--table`: edits drawn by rule over the syntax tree of posted",
        "programs, each run through `verify --against --no-manifest`. A fault counts where what the machine does differs by",
        "more than 0.01 mm or 0.01 degrees, in a feed, in an event or in what is in force, as a small interpreter of the",
        "bench's own finds, or by what KRL says of statements that it does not follow.",
        "",
        f"**{len(wrong)} faults, {sum(o.bad for o in wrong)} pass; {len(legal)} legal rewrites, {sum(o.bad for o in legal)} "
        "do not pass.**",
        "",
    ]
    text += [
        "| family | faults | refused | not judged | input error | crash | hang | pass |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    text += _rows(wrong)
    text += [
        "",
        "| family | legal rewrites | refused | not judged | input error | crash | hang | pass |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    text += _rows(legal)
    text += ["", "## What came out badly", ""]
    text += [line for o in outcomes if o.bad for line in _entry(o)] or ["Nothing."]
    text += [
        "",
        "## Neither wrong nor the same",
        "",
        "Other postures, other ways through the air, other rapids, roundings that no controller carries out, settings on",
        "which nothing depends: run, not counted. Drawn faults that turn out to change nothing stand here as `same`.",
        "",
        "| rule | differs in | answers |",
        "| --- | --- | --- |",
    ]
    rest = [o for o in outcomes if o.verdict in ("open", "same")]
    for name in sorted({(o.key.split("/")[0], o.verdict) for o in rest}):
        rows = [o for o in rest if (o.key.split("/")[0], o.verdict) == name]
        differs = ", ".join(sorted({d for o in rows for d in o.differs})) or name[1]
        answers = Counter(o.answer for o in rows)
        text.append(f"| {name[0]} | {differs} | {', '.join(f'{answers[a]} {a}' for a in _ANSWERS if answers[a])} |")
    text += ["", "## Every rule", "", "| rule | verdict | cases | answers |", "| --- | --- | --- | --- |"]
    counted = [*wrong, *legal]
    for name in dict.fromkeys((o.key.split("/")[0], o.verdict) for o in counted):
        answers = Counter(o.answer for o in counted if (o.key.split("/")[0], o.verdict) == name)
        said = ", ".join(f"{answers[a]} {a}" for a in _ANSWERS if answers[a])
        text.append(f"| {name[0]} | {name[1]} | {sum(answers.values())} | {said} |")
    table.write_text("\n".join(text) + "\n", encoding="utf-8")


def _rows(outcomes: Sequence[Outcome]) -> list[str]:
    rows = []
    for family in dict.fromkeys(o.family for o in outcomes):
        answers = Counter(o.answer for o in outcomes if o.family == family)
        rows.append(f"| {family} | {sum(answers.values())} | " + " | ".join(str(answers[a]) for a in _ANSWERS) + " |")
    return rows


def _entry(outcome: Outcome) -> list[str]:
    body = [*outcome.edit.splitlines(), f"{outcome.answer}: {outcome.said}"]
    return [f"`{outcome.key}`, {outcome.verdict}:", "", "```text", *body, "```", ""]
