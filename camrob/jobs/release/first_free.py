"""A job's program by the first of a method's ways that is fit for release."""

from __future__ import annotations

from pathlib import Path

from camrob.errors import CollisionError, JobError, VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.files.home import demand_free_home
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.release.attempt import Made, Order, fit
from camrob.jobs.release.refusal import as_hurried, as_planned, past_limit
from camrob.jobs.release.second_side import from_two_sides
from camrob.jobs.solving.resolved_job import BEGUN, ELSEWHERE, METHODS, PUBLISHED, resolve_job
from camrob.jobs.solving.sought import Sought
from camrob.jobs.solving.watch import Watch
from camrob.redundancy.clock import Clock
from camrob.redundancy.solution import ALL_TOUCH

__all__ = ["first_free"]

_ROUNDS, _FURTHER = 4, 1.5  # of solving again; times what an axis passed its limit by
_TOUCH = "touch something"
_ACCURATE_WAYS = 2  # of a plan for accuracy, before those by conditioning are tried: the knee, and still axes


def first_free(order: Order, inputs: JobInputs, folder: Path, watch: Watch) -> Made:
    """The program by the first of the method's ways that keeps free of collisions; the later ones say what was given up.

    Raises the error of the first way where all collide.
    """
    demand_free_home(inputs)
    first: JobError | None = None
    ways: list[tuple[Sought | None, str]] = [(None, way) for way in METHODS[order.asked.method]]
    if order.sought is not None:  # a plan that looks at the part's error, and else those by conditioning
        ways = [*((order.sought, way) for way in tuple(METHODS[order.asked.method])[:_ACCURATE_WAYS]), *ways]
    clock = Clock(order.asked.seconds)
    for sought, way in ways:
        late = first is not None and clock.up and way not in BEGUN  # each of the others begins with a plan of its own
        doomed = first is not None and _TOUCH in first.reasons and way != PUBLISHED  # the others have no other postures
        if late or doomed or (way == ELSEWHERE and not isinstance(first, CollisionError)):
            continue
        try:
            made = _fit_within_limits(order, inputs, sought, way, folder, watch, clock)
        except JobError as error:
            if first is None and not isinstance(error, CollisionError | VerificationError):
                raise _advised(error, order, inputs, watch) from None
            first = first or (as_planned(error) if order.asked.method == "planned" else error)
            continue
        if first is not None:
            blind = " by conditioning alone" if order.sought is not None and sought is None else ""
            text = f"posted as {way}{blind}, for the first choice was not fit: {first.what}"
            made.findings.append(Finding("plan-collides", text, line=first.line))
        return made
    if first is None:
        raise VerificationError(f"method {order.asked.method} has no variant to try")
    if isinstance(first, CollisionError | VerificationError):
        first = _advised(first, order, inputs, watch)
    raise as_hurried(first, clock.seconds) if clock.up and clock.seconds is not None else first


def _advised(error: JobError, order: Order, inputs: JobInputs, watch: Watch) -> JobError:
    """The error with a plan or a place that serves, but where the file works the part from two sides: it is turned over then."""
    if from_two_sides(inputs):
        return error
    from camrob.jobs.solving.elsewhere import with_a_place  # tries plans and placements

    with watch.stage("look for a place"):
        return with_a_place(error, inputs, planned=order.asked.method == "planned", progress=watch.share)


def _fit_within_limits(
    order: Order, inputs: JobInputs, sought: Sought | None, way: str, folder: Path, watch: Watch, clock: Clock
) -> Made:
    """A program by one way, solved again, further from the limits that its axes pass between two points, where they do."""
    further: dict[str, float] = {}
    stopped: VerificationError | None = None
    rounds = 0
    while True:
        try:
            with watch.stage("resolve"):
                resolved = resolve_job(
                    inputs,
                    order.asked.method,
                    way,
                    watch.share,
                    order.asked.device,
                    sought,
                    clock.left,
                    further=further,
                )
        except JobError as error:  # behind the first round the limit is the reason, not what it leaves no way to
            raise stopped or error from None
        try:
            made = fit(order, resolved, folder, watch)
        except VerificationError as error:
            over, rounds = past_limit(error), rounds + 1
            if not over or way != PUBLISHED or rounds == _ROUNDS:
                raise
            further[error.axis] = further.get(error.axis, 0.0) + _FURTHER * over
            stopped = error
            continue
        except CollisionError as error:
            error.reasons.update((_TOUCH, f.count) for f in resolved.solution.findings if f.code == ALL_TOUCH)
            raise
        for axis in further:
            text = f"{axis} was kept further from its limit, which it passed between points that keep it"
            made.findings.append(Finding("kept-from-limit", text, Severity.INFO, axis=axis))
        return made
