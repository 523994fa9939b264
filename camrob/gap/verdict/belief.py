"""From evidence to belief: every constant between the two, in one record.

`slope` and `surest` are fitted to simulated cases of three worlds: causes alone, causes beside a smooth field of five times the
noise, and that field alone (`tests/gap/verdict/belief_cases.csv`; a test fits them again). `takes_less`, `takes_more` and
`takes_else` are how often such names were right on cases of two makers, one of whom had not read the library
(`tests/gap/verdict/delivery_cases.csv`, likewise). `stands_out` is chosen on the cases of four makers, three of whom had not read
the library (`tests/gap/verdict/sure_cases.csv`). `unclear` is by opened cases of the third, fourth and fifth author: 2 of 11 such
names were right. `most_times` and `of_gap` are chosen on the eleventh, twelfth and thirteenth author's opened cases: where all
that is wrong has its name and nothing is left, the unknown is said in 8 of 37 (11 before), and where something is in 55 of 57
as before. The others are chosen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["BELIEF", "Belief"]

_CERTAIN = 1e-9  # a probability nearer to 0 or 1 is as good as it


@dataclass(frozen=True, slots=True)
class Belief:
    """slope: share of the evidence's log odds that is believed, as neither the effects nor the discrepancy are described quite
    rightly; surest: share of right names among those that the evidence leaves no doubt about; impossible: what is left of a
    probability where the fitted value is one that no machine has, or withheld samples contradict the name; stays, share: of the
    noise and of the withheld gap, what has to hang together on withheld samples for even odds that something unknown stays;
    steep: log odds a unit of that size; nothing_else: probability of the unknown where nothing else is left to say; read_off:
    where the log shows it, at a drive; first_of_twins: share of the foot where the instrument's frame would show the
    same; idle: times what shapes of the unknown take beside names, that names have to take beside these; far_more: times a
    shape of the unknown, or what stays beyond the predicted, that an effect has to move the tool by to stand by it; farther:
    times the latter, from which it is sure: one that leaves a tenth of what it moves is 6 degrees off; by_noise, by_field,
    by_doubt: of the noise, of the discrepancy, and of what the fit leaves open, what may stay on withheld logs beyond what was
    predicted before every name is doubtful; doubtful: what is then left of it; beside_more: what is left of one that moves the
    tool by less than what stays unexplained, or than `smooth_more` times that where it is as smooth and cancels
    others that are, which it does where their energies are `cancels` times that of them together, or where all claims take less
    than `taken` of the energy by which they move it; part_seen: of one of whose
    pattern the logs show a part, and of one that needs such a one beside it; sure_from: times what stays, that a name has to
    move the tool by to be nearly sure; shown: share of a name's energy from which a simpler one of its kind shows it;
    delivered: of the energy by which a name moves the tool on samples that took no part, what it may take there at the least
    and at the most and be nearly sure (the middle two), or likely (the outer two); takes_less, takes_more, takes_else: how sure
    it can be at the most that takes less and more than these, and between them; most_part, most_times: of the gap's energy, or
    of the noise, what has to stay beside claims for even odds that it is anything; of_gap: of the gap, what a slightly wrong
    description of the claims leaves, which is nothing unknown; stands_out: squares of its values in standard errors, a
    parameter, from which a name can be nearly sure; unclear: how sure one can be at the most that is not likely either (no
    surer than `takes_less`) and does not stand out.
    """

    slope: float
    surest: float
    impossible: float
    stays: float
    share: float
    steep: float
    nothing_else: float
    read_off: float
    first_of_twins: float
    far_more: float
    farther: float
    idle: float
    by_noise: float
    by_field: float
    by_doubt: float
    doubtful: float
    beside_more: float
    smooth_more: float
    cancels: float
    sure_from: float
    shown: float
    taken: float
    part_seen: float
    delivered: tuple[float, float, float, float]
    takes_less: float
    takes_more: float
    takes_else: float
    most_part: float
    most_times: float
    of_gap: float
    stands_out: float
    unclear: float

    @property
    def likely(self) -> float:
        """How sure a name can be at the most of which something else may be the likeness."""
        return self.surest * self.part_seen

    def effect(self, probability: float, *, impossible: bool = False) -> float:
        """Probability of an effect, from that of the sets that hold it."""
        p = float(np.clip(probability, _CERTAIN, 1.0 - _CERTAIN))
        odds = self.slope * float(np.log(p / (1.0 - p)))
        return self.surest / (1.0 + float(np.exp(-odds))) * (self.impossible if impossible else 1.0)

    def unknown(self, structure: float, share: float) -> float:
        """Probability that something unknown stays. structure: in noises; share: of the gap."""
        size = min(structure / self.stays, share / self.share)
        return float(1.0 / (1.0 + np.exp(-self.steep * (size - 1.0))))

    def delivers(self, share: float) -> float:
        """How sure a name can be at the most that takes a share of the energy by which it moves the tool on samples that took
        no part.
        """
        least, less, more, most = self.delivered
        if less <= share <= more:
            return self.surest
        return self.takes_less if share < least else self.takes_more if share > most else self.takes_else

    def matters(self, rms: float, share: float, noise: float) -> float:
        """Probability that what stays beside claims is something unknown. rms: m of it, beyond the noise (m); share: of the gap's
        energy.
        """
        much = max(share / self.most_part, rms / (self.most_times * noise))
        size = min(much, rms / (self.stays * noise), float(np.sqrt(share)) / self.of_gap)
        return float(1.0 / (1.0 + np.exp(-self.steep * (size - 1.0))))

    def surprised(self, beyond: float, noise: float, discrepancy: float, doubt: float) -> bool:
        """True where more stays on withheld logs than predicted, m2 `beyond` it, than noise, discrepancy and doubt (m) allow."""
        return beyond > (self.by_noise * noise) ** 2 + (self.by_field * discrepancy) ** 2 + (self.by_doubt * doubt) ** 2


BELIEF = Belief(
    slope=0.81,
    surest=0.97,
    impossible=0.05,
    stays=0.585,
    share=0.026,
    steep=7.8,
    nothing_else=0.55,
    read_off=0.95,
    first_of_twins=0.85,
    far_more=4.0,
    farther=10.0,
    idle=3.0,
    by_noise=0.5,
    by_field=0.8,
    by_doubt=2.0,
    doubtful=0.5,
    beside_more=0.8,
    smooth_more=2.0,
    cancels=2.0,
    sure_from=2.0,
    shown=0.9,
    taken=0.5,
    part_seen=0.8,
    delivered=(0.5, 0.75, 1.15, 2.0),
    takes_less=0.55,
    takes_more=0.4,
    takes_else=0.6,
    most_part=0.1,
    most_times=1.3,
    of_gap=0.04,
    stands_out=50.0,
    unclear=0.35,
)
