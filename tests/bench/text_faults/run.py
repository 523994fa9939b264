"""Cases drawn by the rules, each run through `verify` and counted."""

from __future__ import annotations

import json
import random
import shutil
import signal
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from text_faults.change import differences
from text_faults.context import Draw, NothingToDrawError
from text_faults.deeds import OpaqueError
from text_faults.jobs import CELL, Posted
from text_faults.rules import Rule, all_rules
from text_faults.tree import Tree, difference

_PATIENCE = 20.0
_PLAINLY_WRONG = {"path", "feed", "events", "limits"}


@dataclass(frozen=True)
class Case:
    """An edit of a job's program. verdict: `wrong`, `legal`, `open`, or `same` where a drawn fault changes nothing.

    differs: what the small interpreter found to differ, `opaque` where it can't follow.
    """

    key: str
    job: str
    family: str
    verdict: str
    differs: tuple[str, ...]
    files: Mapping[str, str]
    main: str
    edit: str


@dataclass(frozen=True)
class Outcome:
    """What `verify` says: `pass`, `refused`, `not judged`, `input error` (status 2), `crash`
    or `hang`. said: its first words."""

    key: str
    family: str
    verdict: str
    answer: str
    said: str
    differs: tuple[str, ...]
    edit: str

    @property
    def bad(self) -> bool:
        """A fault that passes, a legal rewrite that does not, a traceback, no end."""
        if self.answer in ("crash", "hang"):
            return True
        return (self.verdict == "wrong") == (self.answer == "pass") if self.verdict in ("wrong", "legal") else False


def trees(posted: Mapping[str, Posted]) -> dict[str, Tree]:
    """Every job's program as a tree."""
    return {name: Tree.of(f"{p.job.program}.src", p.files) for name, p in posted.items()}


def cases(posted: Mapping[str, Posted], *, seed: int = 1, times: int = 1, only: Sequence[str] = ()) -> list[Case]:
    """All draws of all rules on all programs, each text once. times: how often everything is drawn. only: parts of keys."""
    program = trees(posted)
    found: list[Case] = []
    texts: set[tuple[object, ...]] = {tuple(sorted(p.files.items())) for p in posted.values()}
    for rule in all_rules().values():
        for job in posted:
            if rule.only and job not in rule.only:
                continue
            for k in range(rule.times * times):
                key = f"{rule.name}/{job}/{k}"
                if only and not any(part in key for part in only):
                    continue
                rng = random.Random(f"{seed}:{key}")
                case = _case(key, rule, Draw(job, program[job], program, rng, posted[job].job.top))
                if case is not None and (text := (job, *sorted(case.files.items()))) not in texts:
                    texts.add(text)
                    found.append(case)
    return found


def one_of_each(posted: Mapping[str, Posted], *, seed: int = 1) -> list[Case]:
    """One case of every rule that counts, the programs in turn."""
    program, jobs = trees(posted), list(posted)
    found = []
    for number, rule in enumerate(all_rules().values()):
        for k in range(len(jobs)):
            job = jobs[(number + k) % len(jobs)]
            if rule.verdict == "open" or (rule.only and job not in rule.only):
                continue
            key = f"{rule.name}/{job}/0"
            case = _case(
                key, rule, Draw(job, program[job], program, random.Random(f"{seed}:{key}"), posted[job].job.top)
            )
            if case is not None and case.verdict in ("wrong", "legal"):
                found.append(case)
                break
    return found


def _case(key: str, rule: Rule, draw: Draw) -> Case | None:
    made = None
    for _ in range(8):
        try:
            made = rule.make(draw)
            break
        except NothingToDrawError:
            continue
    if made is None or made.texts() == draw.tree.texts():
        return None
    try:
        differs = tuple(sorted(differences(draw.tree, made)))
    except OpaqueError:
        differs = ("opaque",)
    verdict = rule.verdict
    if verdict == "checked":
        plain = {*_PLAINLY_WRONG, "opaque", *(["settings"] if rule.family == "frames" else [])}
        verdict = "wrong" if plain & set(differs) else "open" if differs else "same"
    return Case(key, draw.name, rule.family, verdict, differs, made.texts(), made.main, difference(draw.tree, made))


class _OutOfPatienceError(BaseException):
    """Nothing catches it on its way."""


@contextmanager
def _patience() -> Iterator[None]:
    """Seconds of computing are enough for an answer on programs of some dozen lines, however busy the machine is."""

    def over(number: int, frame: object) -> None:
        raise _OutOfPatienceError

    before = signal.signal(signal.SIGVTALRM, over)
    signal.setitimer(signal.ITIMER_VIRTUAL, _PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def judged(case: Case, posted: Posted, folder: Path) -> Outcome:
    """Run `verify` on a case: on one that should fail without collisions first, which can only refuse more."""
    from camrob.errors import CamrobError
    from camrob.jobs.verify import verify

    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, text in case.files.items():
        (folder / name).write_bytes(text.encode("latin-1"))
    answer, said = "pass", ""
    for collisions in (True,) if case.verdict == "legal" else (False, True):
        try:
            with _patience():
                result = verify(
                    folder / case.main, cell=CELL, against=posted.clfile, collisions=collisions, manifest=False
                )
        except CamrobError as error:
            answer, said = "input error", str(error)
            break
        except _OutOfPatienceError:
            answer, said = "hang", f"no answer after {_PATIENCE} s of computing"
            break
        except Exception as error:  # a traceback instead of a finding
            answer, said = "crash", f"{type(error).__name__}: {error}; {traceback.extract_tb(error.__traceback__)[-1]}"
            break
        errors = [f"{f.code}: {f.text}" for f in result.findings if f.severity.value == "error"]
        answer = {True: "pass", False: "refused", None: "not judged"}[result.ok]
        said = "; ".join(errors or list(result.summary.not_judged))
        if result.ok is False:
            break
    said = said.replace(str(folder), "").strip()[:400]
    return Outcome(case.key, case.family, case.verdict, answer, said, case.differs, case.edit)


def run(
    posted: Mapping[str, Posted], chosen: Iterable[Case], folder: Path, results: Path | None = None
) -> list[Outcome]:
    """Every case through `verify`; a line of JSON each in `results` as they come."""
    out = []
    for case in chosen:
        outcome = judged(case, posted[case.job], folder / "case")
        out.append(outcome)
        if results is not None:
            with results.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(asdict(outcome)) + "\n")
    return out


def read(results: Path) -> list[Outcome]:
    """Outcomes of an earlier run, the last of each key."""
    rows = [json.loads(line) for line in results.read_text(encoding="utf-8").splitlines()]
    found = {row["key"]: Outcome(**{**row, "differs": tuple(row["differs"])}) for row in rows}
    return list(found.values())
