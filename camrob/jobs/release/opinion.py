"""The witness's verdict on a program, as the jobs need it: a refusal, findings, and entries of their JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from camrob.errors import VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.release.refusal import advice
from camrob.jobs.release.upload import SUFFIX
from camrob.languages import language_suffixes
from camrob.program.language import Language
from camrob.summaries.post_summary import Manifest, WitnessFigures
from camrob.units import mm_min_to_m_s
from camrob.witness.happenings import Objection
from camrob.witness.judge import Verdict
from camrob.witness.manifest import check_manifest, check_upload, digests, make_manifest

__all__ = [
    "SLOWER_BY_PLAN",
    "SLOWER_BY_TOLERANCE",
    "compensated_manifest",
    "fastest_cut",
    "hold_to_witness",
    "manifest_findings",
    "manifest_of",
    "of_program",
    "reason_for_slower",
    "verified_by",
    "witness_figures",
]

# what is worth a warning in a program of somebody else's, and has no excuse in one of camrob's own
_OWN = frozenset(
    """no-status-turn ends-elsewhere path-from-home table-row peck-top-rounded spline-unasked axis-absent""".split()
)
_BY = "an independent witness"
SLOWER_BY_PLAN, SLOWER_BY_TOLERANCE = "--feed optimal", "the set-up's tolerance"
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
    findings = [_finding(o, o.text, o.cl_line) for o in verdict.warnings]
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
        MODAL_CALL: "call with M99",
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
        findings.append(replace(_finding(o, text, o.line), cl_line=o.cl_line, file=file))
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


def manifest_of(
    folder: Path, files: Iterable[str], cell: Path, clfile: Path, setup: Path | None, known: Iterable[Path] = ()
) -> Manifest:
    """The manifest of NAME.json, of program files in a folder."""
    program = [folder / name for name in files if name.endswith(language_suffixes())]
    return Manifest(**make_manifest(program, cell, clfile=clfile, setup=setup, known=known))


def compensated_manifest(folder: Path, cell: Path, source: Path, known: Iterable[Path]) -> Manifest:
    """The manifest of the program in a folder, whose targets are those of `source`, moved: CL file and set-up are those of the
    manifest beside that, where it is of the files that are there.
    """
    program = [file for file in folder.iterdir() if file.name.endswith(language_suffixes())]
    made = Manifest(**make_manifest(program, cell, known=known))
    then = _summary_beside(source).get("manifest")
    beside = [source.with_name(file.name) for file in program]
    given = digests(sorted(file for file in {source, *beside} if file.is_file()))
    if isinstance(then, Mapping) and then.get("program") == given:
        made = replace(made, cl_file=then.get("cl_file", {}), setup=then.get("setup", {}))
    return replace(made, source=given)


def manifest_findings(program: Path, cell: Path, clfile: Path | None, setup: Path | None) -> list[Finding]:
    """What differs from the manifest in the NAME.json beside a program; nothing where there is none."""
    manifest = _summary_beside(program).get("manifest")
    if not isinstance(manifest, Mapping):
        return []
    found = check_manifest(manifest, _named(program, manifest), cell, clfile=clfile, setup=setup)
    listed = program.with_suffix(SUFFIX)
    if listed.exists():
        found += check_upload(_text(listed), program, _named(program, manifest))
    return [_finding(o, o.text, 0) for o in found]


def reason_for_slower(program: Path) -> str:
    """Why a program is slower than its file says, as its own NAME.json has it; empty where it is not the program posted."""
    summary = _summary_beside(program)
    manifest, feed = summary.get("manifest"), summary.get("feed")
    if not isinstance(manifest, Mapping) or not isinstance(feed, Mapping):
        return ""
    reason = SLOWER_BY_PLAN if feed.get("mode") == "optimal" else SLOWER_BY_TOLERANCE if "tolerance" in feed else ""
    return reason if manifest.get("program") == digests(_named(program, manifest)) else ""


def fastest_cut(program: Path) -> float:
    """m/s of the fastest cut, where lines that are faster are rapids, as the program's own NAME.json has it; infinite where it
    says nothing, or is of another program.
    """
    summary = _summary_beside(program)
    manifest, feed = summary.get("manifest"), summary.get("feed")
    said = feed.get("fastest_cut_mm_min") if isinstance(feed, Mapping) else None
    if not isinstance(manifest, Mapping) or not isinstance(said, int | float) or not said > 0.0:
        return float("inf")
    return float(mm_min_to_m_s(said)) if manifest.get("program") == digests(_named(program, manifest)) else float("inf")


def _summary_beside(program: Path) -> Mapping[str, Any]:
    """The NAME.json beside a program; empty where there is none."""
    try:
        summary = json.loads(program.with_suffix(".json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return summary if isinstance(summary, Mapping) else {}


def _text(file: Path) -> str:
    """A file's text, empty where it has none that can be read."""
    try:
        return file.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return ""


def _named(program: Path, manifest: Mapping[str, Any]) -> set[Path]:
    """The program's files that are there: its own, and those that the manifest names."""
    named = manifest.get("program")
    files = [program.with_name(Path(name).name) for name in named] if isinstance(named, Mapping) else []
    return {file for file in {program, *files} if file.is_file()}


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


def _finding(o: Objection, text: str, line: int) -> Finding:
    severity = Severity.ERROR if o.severity == "error" else Severity.WARNING
    return Finding(o.code, text, severity, line=line, axis=o.axis, value=o.value, limit=o.limit, unit=o.unit)
