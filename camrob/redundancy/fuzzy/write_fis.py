"""Fuzzy inference systems written in the Fuzzy Logic Toolbox's text format, as a technician opens them."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.redundancy.fuzzy.fis import FuzzySystem, FuzzyVariable

__all__ = ["fis_text"]


def fis_text(system: FuzzySystem, remarks: Sequence[str] = ()) -> str:
    """The .fis text of a system, `remarks` first as comments; numbers with six digits, which `read_fis` reads back."""
    sugeno = system.kind == "sugeno"
    lines = [f"% {remark}".rstrip() for remark in remarks]
    lines += [
        "[System]",
        f"Name='{system.name}'",
        f"Type='{system.kind}'",
        "Version=2.0",
        f"NumInputs={len(system.inputs)}",
        f"NumOutputs={len(system.outputs)}",
        f"NumRules={len(system.rules)}",
        f"AndMethod='{system.conjunction}'",
        f"OrMethod='{system.disjunction}'",
        f"ImpMethod='{'prod' if sugeno else system.implication}'",
        f"AggMethod='{'sum' if sugeno else 'max'}'",
        f"DefuzzMethod='{system.defuzzification}'",
    ]
    for kind, variables in (("Input", system.inputs), ("Output", system.outputs)):
        for k, variable in enumerate(variables, start=1):
            lines += ["", f"[{kind}{k}]", *_variable(variable)]
    lines += ["", "[Rules]"]
    for rule in system.rules:
        ins, outs = (" ".join(map(str, terms)) for terms in (rule.inputs, rule.outputs))
        lines.append(f"{ins}, {outs} ({rule.weight:g}) : {1 if rule.conjunction else 2}")
    return "\n".join(lines) + "\n"


def _variable(variable: FuzzyVariable) -> list[str]:
    lines = [
        f"Name='{variable.name}'",
        f"Range=[{variable.lower:.6g} {variable.upper:.6g}]",
        f"NumMFs={len(variable.terms)}",
    ]
    for k, term in enumerate(variable.terms, start=1):
        lines.append(f"MF{k}='{term.name}':'{term.kind}',[{' '.join(f'{p:.6g}' for p in term.parameters)}]")
    return lines
