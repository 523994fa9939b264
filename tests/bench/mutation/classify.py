"""What an outcome of a mutant means: the same bytes, refused, released and valid, released and wrong."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mutation.jobs import Job
from mutation.posting import Outcome
from mutation.truth import RUSH, Rules, Verdict, judge

SOLVED_DEG = 0.02  # what printing leaves of a posture
PART = "verified-in-part"  # the finding of a program that says itself that it was not judged everywhere


@dataclass
class Baseline:
    """What a job comes to without a mutant; `unfit`: why it can't be used."""

    files: dict[str, bytes]
    verdict: Verdict | None
    rules: Rules | None
    seconds: float
    unfit: str = ""
    said: str = ""

    @classmethod
    def of(cls, job: Job, outcome: Outcome) -> Baseline:
        """Of the unmutated package."""
        if job.refuse:
            unfit = f"must be refused and is {outcome.status} {outcome.error}" if outcome.status != "refused" else ""
            return cls({}, None, job.rules(), outcome.seconds, unfit)
        if outcome.status != "released":
            return cls({}, None, None, outcome.seconds, f"{outcome.status}: {outcome.error}")
        rules = job.rules()
        if rules is None:
            return cls({}, None, None, outcome.seconds, "has no story")
        verdict = judge(outcome.files, job.program, rules)
        first = "; ".join(f"{kind}: {text}" for kind, text in verdict.faults[:2])
        return cls(
            dict(outcome.files), verdict, rules, outcome.seconds, first and f"wrong today: {first}", outcome.said
        )


@dataclass
class Result:
    """One mutant's fate over its jobs. written: a changed program was written and then refused."""

    key: str
    module: str
    name: str
    operator: str
    line: int
    what: str = ""
    outcome: str = ""
    fault: str = ""
    text: str = ""
    job: str = ""
    shown: str = ""  # the first job that shows a change, released or not
    kinds: set[str] = field(default_factory=set)
    counts: dict[str, int] = field(default_factory=dict)
    errors: set[str] = field(default_factory=set)
    seconds: float = 0.0

    def note(self, status: str, job: str, text: str = "") -> None:
        self.counts[status] = self.counts.get(status, 0) + 1
        if text and status in ("refused", "crashed", "hang"):
            self.errors.add(text.split(";")[0][:100])
        if status in ("wrong", "wrong in part", "valid", "written"):
            self.shown = self.shown or job
        if status.startswith("wrong"):
            self.job, self.text = job, text

    def settle(self) -> None:
        """The worst of the outcomes; the others only count."""
        for status in ("wrong", "wrong in part", "valid", "refused", "crashed", "hang", "same", "kept"):
            if not self.outcome and self.counts.get(status):
                self.outcome = status

    def row(self) -> dict[str, Any]:
        """For a line of JSON."""
        return {k: sorted(v) if isinstance(v, set) else v for k, v in vars(self).items()}


def classify(result: Result, job: Job, baseline: Baseline, outcome: Outcome) -> bool:
    """Take in one job's outcome; True where the mutant is known to be wrong."""
    if outcome.left:
        result.fault = "left-behind"
        result.note("wrong", job.name, f"refused, but {outcome.left} lies in the folder")
        return True
    if outcome.status == "same":
        result.note("same", job.name)
        return False
    if outcome.status != "released":
        result.note("kept" if job.refuse else outcome.status, job.name, outcome.error)
        if outcome.written and not job.refuse and dict(outcome.written) != baseline.files:
            result.note("written", job.name)
        return False
    if not job.refuse and dict(outcome.files) == baseline.files:
        result.note("same", job.name)
        return False
    if baseline.rules is None:
        status = "wrong in part" if PART in outcome.said else "wrong"
        result.fault = "must-refuse"
        result.note(status, job.name, f"{job.name} is released")
        return status == "wrong"
    verdict = judge(outcome.files, job.program, baseline.rules, known=baseline.verdict)
    faults = verdict.faults or _other(verdict, baseline.verdict, outcome)
    if faults:
        status = "wrong in part" if PART in outcome.said and PART in baseline.said else "wrong"
        result.fault = faults[0][0]
        result.note(status, job.name, f"{faults[0][1]} ({len(faults)} in all)")
        return status == "wrong"
    result.kinds |= kinds(verdict, baseline.verdict, outcome, baseline)
    result.note("valid", job.name)
    return False


def _other(verdict: Verdict, before: Verdict | None, outcome: Outcome) -> list[tuple[str, str]]:
    """What is wrong only beside the unmutated program."""
    if before is not None and verdict.rush > max(RUSH, RUSH * before.rush):
        return [("feed", f"an axis would have to run at {verdict.rush:.1f} times its speed in the cut")]
    return _only_turned(verdict, before, outcome)


def _only_turned(verdict: Verdict, before: Verdict | None, outcome: Outcome) -> list[tuple[str, str]]:
    """S and T that changed while every pose stayed, and are not those of the postures that were solved."""
    if before is None or verdict.turns == before.turns or verdict.printed != before.printed:
        return []
    if outcome.solved is not None:
        apart = np.abs(outcome.solved[:, None] - np.array(verdict.posture)[None, :, :6]).max(axis=2).min(axis=1)
        if apart.max() < SOLVED_DEG:
            return []
    return [("status-turn", f"{verdict.turns} for {before.turns}")]


def kinds(verdict: Verdict, before: Verdict | None, outcome: Outcome, baseline: Baseline) -> set[str]:
    """In what a valid program differs."""
    if before is None:
        return {"released where it was refused"}
    found = {
        name
        for name, same in (
            ("points of the cut", verdict.cut == before.cut),
            ("moves in the air", verdict.air == before.air),
            ("posture", verdict.posture == before.posture),
            ("exact stops", verdict.rounded == before.rounded),
            ("comments", verdict.texts == before.texts),
            ("feed", verdict.speeds == before.speeds),
            ("speed in the air", verdict.air_speeds == before.air_speeds),
            ("name", verdict.name == before.name),
            ("files", sorted(outcome.files) == sorted(baseline.files)),
        )
        if not same
    }
    return found or {"text"}
