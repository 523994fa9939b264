"""A second look at poses that no posture was climbed to: where limits leave little room, a neighbour's basins miss them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.certificate import Certificate, certify, survey_poses
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.scan_batched import Score

__all__ = ["second_look"]


def second_look(
    space: PlanSpace, base_T_tip: NDArray[np.float64], certificate: Certificate, score: Score | None
) -> Certificate:
    """The certificate of poses (W, 4, 4) with those that it reaches by no posture (1/k_F of 0) scanned for themselves.

    A pose that a scan of its own reaches by nothing ends it: that one can't be reached, as far as the lattice tells. Each
    scan finds at least the scanned pose a posture, so that no more rounds are needed than there are such poses.
    """
    value, u, branch = np.array(certificate.inv_kf), np.array(certificate.u), np.array(certificate.branch)
    while True:
        missed = np.flatnonzero(value <= 0.0)
        if not len(missed):
            break
        frames = np.ascontiguousarray(base_T_tip[missed])
        survey = survey_poses(space, frames, score)
        if np.any(survey.best.max(axis=1) <= 0.0):
            break
        found = certify(space, frames, survey)
        value[missed], u[missed], branch[missed] = found.inv_kf, found.u, found.branch
        if np.count_nonzero(value <= 0.0) == len(missed):
            break
    return Certificate(value, u, branch)
