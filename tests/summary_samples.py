"""Summaries for tests of what is made of them: whole ones, of which a test changes what it is about."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.summaries.post_summary import PostSummary
from camrob.summaries.verify_summary import VerifySummary

__all__ = ["POST", "VERIFY", "diagnosis_summary", "effect_found", "post_summary", "region", "shrunk", "verify_summary"]


def region(index: int, name: str, **other: Any) -> dict[str, Any]:
    """A region of a post's summary."""
    plain = {
        "index": index,
        "name": name,
        "first_line": 10,
        "last_line": 20,
        "points": 300,
        "revised": False,
        "inv_kf_before": 0.61,
        "inv_kf_after": 0.61,
        "inv_kf_min": 0.45,
        "inv_kf_mean": 0.61,
    }
    return plain | other


POST: dict[str, Any] = {
    "program": "carving",
    "cell": "kr15_track_table",
    "method": "vjm",
    "source": {"file": "carving.cls", "sha256": "ab" * 32, "dialect": "nx-clsf", "units": "mm"},
    "points": 12345,
    "regions": [
        region(0, "ROUGH", first_line=12, last_line=340, revised=True, inv_kf_before=0.41, inv_kf_after=0.66),
        region(1, "FINISH", first_line=341, last_line=999, points=12045),
    ],
    "tracking": {"position_error_mm_max": 1e-6, "axis_error_deg_max": 1e-7},
    "conditioning": {"inv_kf_min": 0.45, "inv_kf_mean": 0.61, "inv_kf_bound_mean": None},
    "limits": {"margin_min": {"A1": 92.1, "A2": 3.0, "A5": 12.3, "A6": 55.0, "E1": 400.0, "E2": None}, "violations": 0},
    "singular": 0,
    "collisions": {
        "checked": True,
        "count": 0,
        "clearance_min_mm": 12.0,
        "clearance_pair": ["spindle", "table"],
        "sampled": "all",
        "skipped": [],
    },
    "external_travel": {"E1_mm": 812.0, "E2_deg": 95.0},
    "time_s": {"program": 310.2, "optimal": 221.7},
    "feed": {
        "mode": "program",
        "kept_percent": 90.0,
        "lost_s": 1.0,
        "lost_by_axis_s": {"A1": 1.0},
        "losses_count": 1,
        "losses": [
            {
                "first_line": 14,
                "last_line": 15,
                "axis": "A1",
                "cause": "A1 speed",
                "feed_mm_min": 900.0,
                "reached_mm_min": 800.0,
                "lost_s": 1.0,
            },
        ],
        "compared": [{"limits": "speed and acceleration", "program_s": 310.2, "planned_s": None}],
        "program_breaks": {
            "percent_of_cutting": 2.0,
            "worst": [{"quantity": "jerk", "times_the_limit": 3.0, "cause": "A1 jerk", "axis": "A1", "line": 14}],
        },
        "planned_uses": None,
    },
    "torques": {
        "masses": ["A2 arm: 42 kg"],
        "standing": "assumed masses",
        "axes": {
            "E1": {"max_n": 50.0, "gravity_max_n": 0.0, "line": 14},
            "A2": {"max_nm": 404.0, "gravity_max_nm": 382.0, "line": 15},
        },
    },
    "process": {"events_in_file": 3, "events_in_program": 3, "spindle": [[5, 3000.0, "CLW"]], "tool_changes": []},
    "verified": {
        "by": "a second library",
        "position_error_mm_max": 1e-4,
        "axis_error_deg_max": 1e-5,
        "second_library_error_mm_max": 1e-9,
        "second_library_poses": 20,
        "points": 12345,
    },
    "witness": {"complete": True, "judged_points": 12345, "judged_events": 3, "not_judged": []},
    "plan": None,
    "warnings": [{"line": 33, "code": "cutcom", "text": "CUTCOM is not honoured", "count": 1}],
    "notes": [],
    "files": ["carving.src", "carving.dat", "carving.json"],
    "manifest": {"camrob": "0.1.0", "cl_file": {}, "setup": {}, "cell": {}, "program": {}},
    "seconds": {"read": 0.1},
}
"""A summary of `camrob post` as NAME.json holds it."""


VERIFY: dict[str, Any] = {
    "program": "p",
    "cell": "kr15_track_table",
    "ok": True,
    "judged": {"path": True, "frames": True, "process": True, "limits": None, "collisions": True},
    "not_judged": [],
    "errors": [],
    "warnings": [],
    "process": {"events_in_file": None, "events_in_program": 0, "spindle": [], "tool_changes": []},
    "files": ["p.src"],
    "motions": None,
    "against": None,
    "seconds": 0.1,
}
"""A summary of `camrob verify`, of a program that could not be replayed."""


def shrunk(before: float, after: float, **other: Any) -> dict[str, Any]:
    """Errors on withheld samples before and after, mm rms."""
    sizes = {
        f"{name}_{when}_mm": times * rms
        for when, rms in (("before", before), ("after", after))
        for name, times in (("rms", 1.0), ("p95", 2.0), ("max", 3.0))
    }
    shrink = 1.0 - after / before
    return sizes | {"shrink": shrink, "shrink_interval": [shrink - 0.05, shrink + 0.05]} | other


def effect_found(name: str, axes: list[str], parameters: dict[str, float], **other: Any) -> dict[str, Any]:
    """An effect of a diagnosis, 97 % sure, that takes 0.3 mm to 0.07 mm."""
    return {
        "effect": name,
        "axes": axes,
        "probability": 0.97,
        "parameters": {k: {"value": v, "std": abs(v) / 50} for k, v in parameters.items()},
        **shrunk(0.3, 0.07),
        "alone": shrunk(0.3, 0.07),
        "added_last": shrunk(0.3, 0.07),
        "moves_mm": 0.29,
        "indistinguishable_from": [],
        "class": [name],
        "class_probability": 0.97,
        "evidence": 0.999,
        "implausible": "",
        "compensable": True,
        "rungs": ["encoder_to_tcp"],
        "regimes": ["direction"],
        "unusual": "",
    } | other


DIAGNOSIS: dict[str, Any] = {
    "cell": "kr15",
    "without": [],
    "gap": {
        "samples": 900,
        "rms_mm": 0.31,
        "p95_mm": 0.6,
        "max_mm": 0.9,
        "rms_deg": None,
        "noise_mm": 0.03,
        "outliers": 0,
    },
    "where": {
        "rungs": {"program_to_setpoint": None, "setpoint_to_encoder": 0.24, "encoder_to_tcp": 0.307},
        "rung_intervals": {
            "program_to_setpoint": None,
            "setpoint_to_encoder": [0.2, 0.3],
            "encoder_to_tcp": [0.3, 0.32],
        },
        "missing": [],
        "segments": [],
        "change_points": [],
        "lines": [],
        "directions": {"x": 0.2},
        "direction_intervals": {"x": [0.1, 0.3]},
        "axes": {"A2": 0.8},
        "axis_intervals": {"A2": [0.7, 0.9]},
        "regimes": {"position": 0.2, "direction": 0.9},
        "regime_intervals": {"position": [0.1, 0.3], "direction": [0.8, 1.0]},
        "further_regimes": {},
        "timing": [],
    },
    "latency_s": {"value": None, "interval": None},
    "status": "explained",
    "effects": [],
    "together": shrunk(0.3, 0.07)
    | {
        "withheld": "lap2.csv",
        "left_aside": 0,
        "predicted_shrink": 0.7,
        "expected_after_mm": 0.07,
        "removable_removed": 0.8,
        "compensable_mm": 0.0,
        "regimes_withheld": [],
    },
    "alternatives": [{"effects": ["backlash"], "probability": 1.0}],
    "within": {"setpoint_to_encoder": "noise", "encoder_to_tcp": "beyond"},
    "within_values": {
        name: {
            "rms_mm": size,
            "p95_mm": 2 * size,
            "noise_mm": 0.03,
            "noise_told": True,
            "tolerance_mm": None,
            "axis": axis,
        }
        | {"within": within}
        for name, size, axis, within in (
            ("setpoint_to_encoder", 0.01, "A1", "noise"),
            ("encoder_to_tcp", 0.3, "", "beyond"),
        )
    },
    "unknown": {
        "probability": 0.01,
        "rms_mm": 0.0,
        "share": 0.0,
        "where": {"rung": None, "axes": [], "regimes": [], "comes_back": ""},
        "text": "",
        "shapes": [],
        "implausible": {},
    },
    "aliases": [],
    "residual": {"rms_mm": 0.07, "noise_mm": 0.03, "structured_mm": 0.0, "discrepancy_mm": 0.0, "structure": []},
    "next_experiment": "None needed.",
    "logs": ["lap1.csv"],
    "axes_report": {},
    "added_load": None,
    "instrument": {"suspect": 0.0, "scale_ppm": None, "drift_mm": None, "gross": [], "text": ""},
    "compensable": {
        "effects": [],
        "left": [],
        "rms_before_mm": 0.3,
        "rms_after_mm": 0.3,
        "shrink": 0.0,
        "shrink_interval": [0.0, 0.0],
    },
    "standards": [],
}
"""A diagnosis.json: 0.3 mm, most of it behind the encoders, that reverses with the direction of motion."""


def diagnosis_summary(summary: Mapping[str, Any] = MappingProxyType(DIAGNOSIS), **changes: Any) -> DiagnosisSummary:
    """A diagnosis as the engine tells it, by default DIAGNOSIS, with some of its entries changed."""
    return DiagnosisSummary.from_json(_changed({"cell": "kr15", "without": [], **summary}, changes))


def post_summary(**changes: Any) -> PostSummary:
    """POST with some of its entries changed; of an entry that is an object, those of its keys that are given."""
    return PostSummary.from_json(_changed(POST, changes))


def verify_summary(**changes: Any) -> VerifySummary:
    """VERIFY with some of its entries changed."""
    return VerifySummary.from_json(_changed(VERIFY, changes))


def _changed(sample: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    summary = copy.deepcopy(sample)
    for key, value in changes.items():
        summary[key] = summary[key] | value if isinstance(value, dict) and isinstance(summary[key], dict) else value
    return summary
