"""How far a plan may be above the best that exists: proved, written down, and proved again by the checker."""

from __future__ import annotations

from pathlib import Path

from camrob.errors import CellError
from camrob.findings import Finding, Severity
from camrob.jobs.files.inputs import JobInputs
from camrob.progress import Share
from camrob.redundancy.clock import Clock
from camrob.redundancy.solution import Solution
from camrob.summaries.post_summary import PriceBound

__all__ = ["bound_finding", "price_bound"]

_PROVING = 0.3  # of the time: the checker's enclosures are simpler, and take two to three times the prover's


def price_bound(
    inputs: JobInputs, solution: Solution, cell: Path, file: Path, seconds: float, progress: Share
) -> PriceBound:
    """A lower bound, proved, of what any plan of a job costs by the planner's own price, held against the plan's.

    cell: the cell's folder, which the checker reads by itself; file: gets the certificate; seconds: for proof and check together.
    """
    from camrob.redundancy.proving.prove import prove_prices  # both are asked for by few
    from camrob.redundancy.proving.statement import LEFT_OUT
    from camrob.witness.proof_check.check_plan import check

    clock, plan = Clock(seconds), solution.plan
    bases = () if plan is None else plan.bases
    price = 0.0 if plan is None else float(sum(plan.terms.values()))

    def said(bound: float, why: str, *, checked: bool) -> PriceBound:
        return PriceBound(
            price_m=price,
            bound_m=bound,
            within_percent=round(100.0 * (1.0 - bound / price), 2) if bound > 0.0 else None,
            checked=checked,
            why=why,
            left_out=LEFT_OUT,
            seconds=round(clock.taken, 1),
            certificate=file.name if bound > 0.0 else "",
        )

    if len(bases) != 1:
        return said(0.0, "tools are changed on the way" if bases else "no plan was found", checked=False)
    machine = inputs.of_stretch(0, None).cell
    try:
        proof = prove_prices(
            machine, bases, file, seconds=_PROVING * seconds, progress=lambda done: progress(_PROVING * done)
        )
    except CellError as error:
        return said(0.0, error.what, checked=False)
    late = "there was no time for a finer proof" if proof.out_of_time else ""

    def over() -> bool:
        progress(min(1.0, clock.taken / seconds))
        return clock.up

    try:
        bound = check(file, cell / "cell.toml", late=over)
    except TimeoutError:
        return said(proof.bound, "there was no time to check the certificate", checked=False)
    except ValueError as error:
        file.unlink()
        return said(0.0, f"the checker does not confirm it: {error}", checked=False)
    return said(bound, late, checked=True)


def bound_finding(proved: PriceBound) -> Finding:
    """What is proved, in a line."""
    if proved.within_percent is None:
        return Finding("plan-bound", f"no bound of the plan's price is proved: {proved.why}", Severity.INFO)
    text = f"the plan's price is within {proved.within_percent:.2f} % of the best that exists, proved"
    text += " and checked" if proved.checked else ""
    return Finding("plan-bound", text, Severity.INFO, value=proved.within_percent, unit="%")
