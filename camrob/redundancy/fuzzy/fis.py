"""Fuzzy inference systems in the Fuzzy Logic Toolbox's text format (.fis), Mamdani and Sugeno type.

`FuzzySystem.evaluate` is the reference: scikit-fuzzy's membership functions and centroid (a Sugeno system's weighted average
or sum needs no library). `evaluate_grid` does the same for many points at once, to compile surfaces; a test holds it to the
reference.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import CellError
from camrob.redundancy.fuzzy.kept import kept

__all__ = ["FuzzyRule", "FuzzySystem", "FuzzyVariable", "Membership", "read_fis"]

Array = NDArray[np.float64]

MOST_INPUTS = 3  # a grid over all of them is looked at
SAMPLES = 201  # of an output's range, for aggregation and centroid
_RULE = re.compile(
    r"((?:-?\d{1,3}\s+)*-?\d{1,3})\s*,\s*((?:\d{1,3}\s+)*\d{1,3})\s*\((1|1\.0*|0|0?\.\d+)\)\s*:\s*([12])", re.ASCII
)  # terms of the inputs, terms of the outputs (weight, 0 to 1) : 1 for and, 2 for or
_PARAMETERS = {"trimf": 3, "trapmf": 4, "gaussmf": 2, "gauss2mf": 4, "gbellmf": 3, "sigmf": 2, "zmf": 2, "smf": 2}
# what each type may ask for; the toolbox writes ImpMethod and AggMethod of a Sugeno system, too, and heeds neither
_METHODS: dict[str, dict[str, tuple[str, ...]]] = {
    "mamdani": {
        "AndMethod": ("min", "prod"),
        "OrMethod": ("max",),
        "ImpMethod": ("min", "prod"),
        "AggMethod": ("max",),
        "DefuzzMethod": ("centroid",),
    },
    "sugeno": {
        "AndMethod": ("min", "prod"),
        "OrMethod": ("max", "probor"),
        "ImpMethod": ("min", "prod"),
        "AggMethod": ("max", "sum"),
        "DefuzzMethod": ("wtaver", "wtsum"),
    },
}


@dataclass(frozen=True, slots=True)
class Membership:
    """A membership function: the toolbox's `kind` and parameters in the toolbox's order."""

    name: str
    kind: str
    parameters: tuple[float, ...]

    def __call__(self, x: Array) -> Array:
        """Degrees of membership of x (any shape), by scikit-fuzzy."""
        import skfuzzy

        flat = np.atleast_1d(np.asarray(x, float)).ravel()
        p = self.parameters
        if self.kind in ("trimf", "trapmf"):
            degrees = getattr(skfuzzy, self.kind)(flat, list(p))
        elif self.kind == "gaussmf":  # the toolbox: sigma, centre
            degrees = skfuzzy.gaussmf(flat, p[1], p[0])
        elif self.kind == "gauss2mf":  # the toolbox: sigma, centre of the left flank, then of the right one
            degrees = skfuzzy.gauss2mf(flat, p[1], p[0], p[3], p[2])
        elif self.kind == "sigmf":  # the toolbox: slope, centre
            degrees = skfuzzy.sigmf(flat, p[1], p[0])
        else:
            degrees = getattr(skfuzzy, self.kind)(flat, *p)
        return np.asarray(degrees, float).reshape(np.shape(x))


@dataclass(frozen=True, slots=True)
class FuzzyVariable:
    """An input or output with its range and terms."""

    name: str
    lower: float
    upper: float
    terms: tuple[Membership, ...]


@dataclass(frozen=True, slots=True)
class FuzzyRule:
    """Terms by 1-based number, 0 for none, negative for not; `conjunction` True for and."""

    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    weight: float
    conjunction: bool


@dataclass(frozen=True, slots=True)
class FuzzySystem:
    """A Mamdani system with min or prod for and and implication, max for or and aggregation, centroid; or a Sugeno system.

    A Sugeno system's output terms are `constant` (one number) or `linear` (a factor for each input, then a constant); its
    `defuzzification` is wtaver, the rules' average by their strengths, or wtsum, their sum.
    """

    name: str
    inputs: tuple[FuzzyVariable, ...]
    outputs: tuple[FuzzyVariable, ...]
    rules: tuple[FuzzyRule, ...]
    conjunction: str = "min"
    implication: str = "min"
    kind: str = "mamdani"
    disjunction: str = "max"
    defuzzification: str = "centroid"

    def _strengths(self, x: Array) -> Array:
        """Firing strengths (N, rules) at x (N, inputs), clipped to the ranges."""
        degrees = []
        for k, variable in enumerate(self.inputs):
            clipped = np.clip(x[:, k], variable.lower, variable.upper)
            degrees.append([term(clipped) for term in variable.terms])
        strengths = np.zeros((len(x), len(self.rules)))
        for r, rule in enumerate(self.rules):
            parts = []
            for k, term_number in enumerate(rule.inputs):
                if term_number:
                    degree = degrees[k][abs(term_number) - 1]
                    parts.append(1.0 - degree if term_number < 0 else degree)
            stacked = np.stack(parts)
            if not rule.conjunction and self.disjunction == "probor":
                fired = 1.0 - (1.0 - stacked).prod(axis=0)
            elif not rule.conjunction:
                fired = stacked.max(axis=0)
            else:
                fired = stacked.min(axis=0) if self.conjunction == "min" else stacked.prod(axis=0)
            strengths[:, r] = rule.weight * fired
        return strengths

    def _aggregate(self, strengths: Array, k: int) -> tuple[Array, Array]:
        """Universe (SAMPLES,) of output k and aggregated memberships (N, SAMPLES)."""
        variable = self.outputs[k]
        universe = np.linspace(variable.lower, variable.upper, SAMPLES)
        total = np.zeros((len(strengths), SAMPLES))
        for t, term in enumerate(variable.terms, start=1):
            concluding = [r for r, rule in enumerate(self.rules) if rule.outputs[k] == t]
            if concluding:
                fired = strengths[:, concluding].max(axis=1)[:, None]
                shape = term(universe)[None, :]
                total = np.maximum(total, np.minimum(fired, shape) if self.implication == "min" else fired * shape)
        return universe, total

    def evaluate(self, x: Array) -> Array:
        """Outputs (outputs,) at one point x (inputs,), defuzzified by scikit-fuzzy: the reference."""
        if self.kind == "sugeno":
            return np.asarray(self._averaged(np.asarray(x, float)[None, :])[0])
        import skfuzzy

        strengths = self._strengths(np.asarray(x, float)[None, :])
        values = []
        for k in range(len(self.outputs)):
            universe, total = self._aggregate(strengths, k)
            values.append(float(skfuzzy.defuzz(universe, total[0], "centroid")))
        return np.array(values)

    def evaluate_grid(self, x: Array) -> Array:
        """Outputs (N, outputs) at points x (N, inputs): centroids of the piecewise linear aggregates, all at once."""
        if self.kind == "sugeno":
            return self._averaged(x)
        strengths = self._strengths(x)
        out = np.empty((len(x), len(self.outputs)))
        for k in range(len(self.outputs)):
            universe, total = self._aggregate(strengths, k)
            dx = universe[1] - universe[0]
            left, right = total[:, :-1], total[:, 1:]
            area = 0.5 * dx * (left + right).sum(axis=1)
            moment = ((left + right) * (0.5 * dx * universe[:-1]) + dx * dx * (left / 6.0 + right / 3.0)).sum(axis=1)
            out[:, k] = moment / area
        return out

    def _averaged(self, x: Array) -> Array:
        """Outputs (N, outputs) of a Sugeno system at x (N, inputs), clipped to the ranges."""
        strengths = self._strengths(x)
        clipped = np.clip(x, [v.lower for v in self.inputs], [v.upper for v in self.inputs])
        out = np.empty((len(x), len(self.outputs)))
        for k, output in enumerate(self.outputs):
            total, weight = np.zeros(len(x)), np.zeros(len(x))
            for r, rule in enumerate(self.rules):
                if rule.outputs[k]:
                    factors = np.array(output.terms[rule.outputs[k] - 1].parameters)
                    total += strengths[:, r] * (
                        clipped @ factors[:-1] + factors[-1] if len(factors) > 1 else factors[0]
                    )
                    weight += strengths[:, r]
            out[:, k] = total / weight if self.defuzzification == "wtaver" else total
        return out


def read_fis(path: Path) -> FuzzySystem:
    """The system in a .fis file. Raises CellError with file and line."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        raise CellError("can't be read", hint="put the engine's .fis file into the cell's folder", path=path) from None
    sections = _sections(lines, path)
    system = _Section(sections.get("System", {}), path, "System")
    for key, allowed in (("Type", tuple(_METHODS)), *_METHODS.get(system.text("Type"), {}).items()):
        if system.text(key) not in allowed:
            raise system.fail(key, f"is {system.text(key)!r}", f"use {' or '.join(allowed)}")
    kind = system.text("Type")
    if system.count("NumInputs") > MOST_INPUTS:
        raise system.fail("NumInputs", f"is {system.count('NumInputs')}", f"use {MOST_INPUTS} inputs or fewer")
    inputs = tuple(_variable(sections, f"Input{i + 1}", path, _PARAMETERS) for i in range(system.count("NumInputs")))
    kinds = _PARAMETERS if kind == "mamdani" else {"constant": 1, "linear": len(inputs) + 1}
    outputs = tuple(_variable(sections, f"Output{i + 1}", path, kinds) for i in range(system.count("NumOutputs")))
    rules = tuple(_rule(line, text, inputs, outputs, path) for text, line in sections.get("Rules", {}).values())
    if len(rules) != system.count("NumRules"):
        raise system.fail("NumRules", f"says {system.count('NumRules')}, there are {len(rules)}", "correct the count")
    result = FuzzySystem(
        system.text("Name"),
        inputs,
        outputs,
        rules,
        system.text("AndMethod"),
        system.text("ImpMethod"),
        kind,
        system.text("OrMethod"),
        system.text("DefuzzMethod"),
    )
    kept("covered", result, lambda: _check_covered(result, path))
    return result


def _sections(lines: list[str], path: Path) -> dict[str, dict[str, tuple[str, int]]]:
    """Sections of key to (text, line); rules are keyed by their line."""
    sections: dict[str, dict[str, tuple[str, int]]] = {}
    current: dict[str, tuple[str, int]] | None = None
    name = ""
    for number, raw in enumerate(lines, start=1):
        text = raw.split("%")[0].strip()
        if not text:
            continue
        if text.startswith("[") and text.endswith("]"):
            name = text[1:-1]
            current = sections.setdefault(name, {})
        elif current is None:
            raise CellError("text before the first section", hint="begin with [System]", path=path, line=number)
        elif name == "Rules":
            current[str(number)] = (text, number)
        else:
            key, equals, value = text.partition("=")
            if not equals:
                raise CellError(f"{text!r} is not a key=value", hint="write key=value", path=path, line=number)
            current[key.strip()] = (value.strip(), number)
    return sections


class _Section:
    """One section's keys, read with their lines for errors."""

    def __init__(self, data: dict[str, tuple[str, int]], path: Path, name: str) -> None:
        self.data, self.path, self.name = data, path, name

    def fail(self, key: str, what: str, hint: str) -> CellError:
        return CellError(f"[{self.name}] {key} {what}", hint=hint, path=self.path, line=self.data.get(key, ("", 0))[1])

    def raw(self, key: str) -> str:
        if key not in self.data:
            raise self.fail(key, "is missing", "add it")
        return self.data[key][0]

    def text(self, key: str) -> str:
        return self.raw(key).strip("'\"")

    def count(self, key: str) -> int:
        value = self.raw(key)
        if not re.fullmatch("[1-9][0-9]{0,2}", value):
            raise self.fail(key, f"is {value!r}", "give a whole number from 1 on")
        return int(value)

    def numbers(self, key: str, text: str) -> tuple[float, ...]:
        try:
            values = tuple(float(v) for v in text.strip("[] ").split())
        except ValueError:
            values = (np.nan,)
        if not np.all(np.isfinite(values)):
            raise self.fail(key, f"holds {text!r}", "give finite numbers in brackets")
        return values


def _variable(
    sections: dict[str, dict[str, tuple[str, int]]], name: str, path: Path, kinds: Mapping[str, int]
) -> FuzzyVariable:
    """An input or output whose terms are of one of `kinds`, which take so many numbers."""
    section = _Section(sections.get(name, {}), path, name)
    span = section.numbers("Range", section.raw("Range"))
    if len(span) != 2 or not span[0] < span[1]:
        raise section.fail("Range", "is not [lower upper]", "give two rising numbers")
    terms = []
    for i in range(section.count("NumMFs")):
        key = f"MF{i + 1}"
        match = re.fullmatch(r"'([^']*)'\s*:\s*'([^']*)'\s*,\s*(\[[^\]]*\]|[^\[\]]+)", section.raw(key))
        if match is None or match[2] not in kinds:
            raise section.fail(key, "is not a term", f"write 'name':'kind',[numbers], kind one of {', '.join(kinds)}")
        parameters = section.numbers(key, match[3])
        if len(parameters) != kinds[match[2]]:
            raise section.fail(key, f"has {len(parameters)} numbers", f"{match[2]} takes {kinds[match[2]]}")
        flaw = _flaw(match[2], parameters)
        if flaw:
            raise section.fail(key, flaw, "see the toolbox's description of the function")
        terms.append(Membership(match[1], match[2], parameters))
    return FuzzyVariable(section.text("Name"), span[0], span[1], tuple(terms))


def _flaw(kind: str, p: tuple[float, ...]) -> str:
    """What is wrong with a membership function's parameters, empty for nothing."""
    if kind in ("trimf", "trapmf", "zmf", "smf") and list(p) != sorted(p):
        return "has falling corners"
    if kind == "gauss2mf" and p[1] > p[3]:
        return "has its left flank right of the right one"
    wide = {"gaussmf": p[:1], "gauss2mf": p[::2], "gbellmf": p[:1]}.get(kind, ())
    return "has no width" if any(w <= 0.0 for w in wide) else ""


def _rule(
    line: int, text: str, inputs: tuple[FuzzyVariable, ...], outputs: tuple[FuzzyVariable, ...], path: Path
) -> FuzzyRule:
    match = _RULE.fullmatch(text)
    if match is not None:
        ins, outs = tuple(map(int, match[1].split())), tuple(map(int, match[2].split()))
        fits = len(ins) == len(inputs) and len(outs) == len(outputs) and any(ins)
        fits = fits and all(abs(t) <= len(v.terms) for t, v in zip(ins, inputs, strict=True))
        if fits and all(0 <= t <= len(v.terms) for t, v in zip(outs, outputs, strict=True)):
            return FuzzyRule(ins, outs, float(match[3]), match[4] == "1")
    raise CellError(
        f"{text!r} is not a rule", hint="write terms of inputs, outputs (weight) : 1 or 2", path=path, line=line
    )


def _check_covered(system: FuzzySystem, path: Path) -> tuple[Array, ...]:
    """Every posture must fire some rule for every output, or there is no weight. Returns nothing that has to be kept."""
    grids = np.meshgrid(*[np.linspace(v.lower, v.upper, 33) for v in system.inputs], indexing="ij")
    x = np.stack([g.ravel() for g in grids], axis=1)
    strengths = system._strengths(x)
    for k, output in enumerate(system.outputs):
        if system.kind == "mamdani":
            _check_terms(output, {rule.outputs[k] for rule in system.rules} - {0}, path)
        concluding = [r for r, rule in enumerate(system.rules) if rule.outputs[k]]
        fired = strengths[:, concluding].max(axis=1) if concluding else np.zeros(len(x))
        if np.any(fired < 1e-6):
            where = ", ".join(f"{v.name} {g:g}" for v, g in zip(system.inputs, x[int(np.argmin(fired))], strict=True))
            raise CellError(f"no rule gives {output.name} at {where}", hint="cover the whole range by rules", path=path)
    if system.kind == "sugeno":
        values = system.evaluate_grid(x)
        least = np.unravel_index(int(np.argmin(values)), values.shape)
        if not values[least] > 0.0:
            where = ", ".join(f"{v.name} {g:g}" for v, g in zip(system.inputs, x[least[0]], strict=True))
            what = f"{system.outputs[int(least[1])].name} is {values[least]:g} at {where}"
            raise CellError(what, hint="a weight is above 0: raise the terms", path=path)
    return ()


def _check_terms(output: FuzzyVariable, used: set[int], path: Path) -> None:
    """Terms that a Mamdani system's rules conclude must lie within the output's range."""
    universe = np.linspace(output.lower, output.upper, SAMPLES)
    for term in (output.terms[t - 1] for t in used):
        if term(universe).max() < 1e-3:
            what = f"term {term.name!r} of {output.name} lies outside of its Range"
            raise CellError(what, hint="move it inside", path=path)
