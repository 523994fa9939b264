"""The witness's verdict on a program, as the jobs need it: a refusal, findings, and entries of their JSON."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from camrob.errors import VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.release.refusal import advice
from camrob.program.language import Language
from camrob.summaries.post_summary import WitnessFigures
from camrob.witness.happenings import Objection
from camrob.witness.judge import Verdict

__all__ = ["finding_of", "hold_to_witness", "of_program", "verified_by", "witness_figures"]

# what is worth a warning in a program of somebody else's, and has no excuse in one of camrob's own
_OWN = frozenset(
    """no-status-turn ends-elsewhere path-from-home table-row peck-top-rounded spline-unasked axis-absent""".split()
)
_BY = "an independent witness"
_LONGEST = 90  # characters of a statement that is quoted
_MOST = 50  # spans not judged that are named one by one


def hold_to_witness(verdict: Verdict, folder: Path) -> list[Finding]:
    """The witness's warnings on a program about to be released; first of all, what it could not judge.

    folder: where the program's files lie until then. Raises VerificationError, with the CL file's line, for the first thing
    that stands against the program (statements are quoted, since nobody will see the lines' numbers), and for a file with macros.
    """
    against = [o for o in verdict.objections if o.severity == "error" or o.code in _OWN]
    for objection in against:
        others = len(against) - 1
        more = f" ({others} more such objection{'s' * (others > 1)})" if others else ""
        text = _quoted(objection, verdict, folder)
        raise VerificationError(
            f"the program was not released: the witness objects: {text}{more}; {advice(objection.code)}",
            line=objection.cl_line,
            axis=objection.axis,
            value=objection.value,
            limit=objection.limit,
            unit=objection.unit,
        )
    for text in verdict.unjudged:
        for unread, hint in _never().items():
            if unread in text:
                raise VerificationError(f"the program was not released: {text}; {hint}")
    findings = [finding_of(o, o.text, o.cl_line) for o in verdict.warnings]
    if not verdict.complete:
        spans = "; ".join(_not_judged(verdict)[:3])
        more = f" and {len(verdict.unjudged) - 3} more" if len(verdict.unjudged) > 3 else ""
        text = f"verified in part: the second opinion could not judge {spans}{more}; check these places by eye"
        findings.insert(0, Finding("verified-in-part", text))
    return findings


def _never() -> Mapping[str, str]:
    """Gaps of files that camrob refuses, since nothing that is made of one can be right, with what to do about each."""
    # the witness's readers of all controls, loaded where a file has a gap
    from camrob.witness.cl.apt_process import LATHE
    from camrob.witness.cl.customs import ASIDE
    from camrob.witness.cl.drilling import UPWARD
    from camrob.witness.cl.foreign.foreign_cycles import ACROSS
    from camrob.witness.cl.foreign.klartext_places import MODAL_CALL
    from camrob.witness.cl.foreign.klartext_values import ARC_BY_MACHINE, FEED_BY_TOOL
    from camrob.witness.cl.offsets import OFFSET
    from camrob.witness.cl.running.unread import NOWHERE
    from camrob.witness.cl.standing import TURNED, UNNAMED
    from camrob.witness.cl.teller import NO_CIRCLE
    from camrob.witness.cl.words import NO_AXIS, STRANGE

    return {
        UPWARD: "NX counts depths below the point as negative numbers; output the operation again",
        NO_CIRCLE: "a point before it is missing, or the centre is wrong; output the path again",
        NO_AXIS: "correct i, j, k in the CAM system",
        TURNED: "post with the tool centre point on (G43.4, M128, M428 or TRAORI)",
        OFFSET: 'have the CAM system write the path of the tool\'s centre, or say cutter_compensation = "wear" in setup.toml',
        STRANGE: "output it as GOTO from the CAM system, or delete the line where it means nothing",
        NOWHERE: "put the block or the subprogram into the file",
        ACROSS: "drill in G17",
        ASIDE: "mirror about the work zero: G101 X0, Y0",
        MODAL_CALL: "end it by M99 before the way along Z",
        ARC_BY_MACHINE: "use L for it",
        FEED_BY_TOOL: "name the feed in mm/min",
        LATHE: "give the milling operations a CL file of their own",
        UNNAMED: "name X, Y and Z in a rapid move before it",
    }


def of_program(verdict: Verdict) -> list[Finding]:
    """What stands against a program that lies there, by its own lines and the CL file's."""
    findings = []
    for o in verdict.objections:
        file = verdict.files[o.file] if 0 < o.file < len(verdict.files) else ""
        text = o.text.removeprefix(f"line {o.line} of the program: ")  # it has its own column
        findings.append(replace(finding_of(o, text, o.line), cl_line=o.cl_line, file=file))
    return findings + [Finding("not-judged", text) for text in _not_judged(verdict)]


def witness_figures(verdict: Verdict) -> WitnessFigures:
    """What the witness judged, and what it could not."""
    return WitnessFigures(
        complete=verdict.complete,
        judged_points=verdict.judged_points,
        judged_events=verdict.judged_events,
        not_judged=tuple(_not_judged(verdict)),
    )


def verified_by(verdict: Verdict, language: Language) -> str:
    """By what a released program was verified, for people."""
    return f"{_BY}{'' if verdict.complete else ', in part'}, the {language.title} reader and replay, and Pinocchio"


def _quoted(objection: Objection, verdict: Verdict, folder: Path) -> str:
    """An objection's text with the program's own statement where it names the line."""
    if not 0 <= objection.file < len(verdict.files):
        return objection.text
    try:
        lines = (folder / verdict.files[objection.file]).read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return objection.text

    def statement(found: re.Match[str]) -> str:
        number = int(found[1])
        written = lines[number - 1].strip() if 0 < number <= len(lines) else ""
        return repr(written[:_LONGEST] + "..." * (len(written) > _LONGEST)) if written else found[0]

    return re.sub(r"\bline (\d+) of the program", statement, objection.text)


def _not_judged(verdict: Verdict) -> list[str]:
    said = list(verdict.unjudged)
    return said[:_MOST] + ([f"and {len(said) - _MOST} more"] if len(said) > _MOST else [])


def finding_of(o: Objection, text: str, line: int) -> Finding:
    """The finding that an objection of the witness is, in these words."""
    severity = Severity.ERROR if o.severity == "error" else Severity.WARNING
    return Finding(o.code, text, severity, line=line, axis=o.axis, value=o.value, limit=o.limit, unit=o.unit)
