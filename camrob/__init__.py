"""CAM toolpaths into verified programs for redundant robot machining cells.

Verbs: files in, files out, and a result; `help(camrob.post)` says the rest.

    post            a CL file in, a verified robot program out
    verify          judge a program, whoever wrote it, and hold it to its CL file
    simulate        run a program on the ideal controller, write its log
    diagnose        where and why logs of the real cell deviate
    calibrate       a cell's error parameters from measured poses
    compensate      rewrite a program so that the calibrated robot meets its poses
    close_loop      program, run, diagnosis, correction, and again
    predict         the part as the machine as diagnosed would cut it
    place           where on the table a part is worked best
    batch           many jobs on all cores, or on a cluster
    regress         post every sample and compare it with its golden files
    tune_engines    fit a cell's fuzzy rules to samples, beside constant weights
    feed            a path's derivatives, or the study of a weld seam
    tracker         the study of a laser-tracker loop
    track_live      serve a controller with corrections from a laser tracker
    published_case  repeat a published calibration

On objects: what readers give goes in, arrays and objects come out, without files.

    resolve        a Toolpath in a Cell, Resolved: what post does first
    fit            error parameters from logs; correct: postures for them
    explain        where and why logs deviate, a Diagnosis
    run            a ProgramText on the ideal controller; placements: a part elsewhere
    replay         what a ProgramText does on a Cell, a Replay: postures, findings
    base_T_tool    the tool's poses (..., 4, 4) in postures q (..., n)

Readers: a file in, an object in SI out (m, rad, s).

    read_cell, read_setup    Cell, Setup: the machine, and what is mounted on it
    read_toolpath            Toolpath of Regions, from CL data or G-code
    read_program             ProgramText, in any robot language that is known
    read_log                 MeasurementLog, from .csv or .parquet
    shipped_cell             the folder of a cell that comes with camrob, by name

Objects: Solution (joints along a path), Program (before it is text), Finding with
Severity, LiveOptions, Progress, Share, and PostResult, ..., one a verb: its
`summary`, a PostSummary, ..., has in attributes what --json prints (to_json).
Within results: ToolPathInBase, Simulation, Placements, TapeLine, PredictedSurface,
Calibration (with CalibrationEvidence in a CalibrationFit), TruePath, RsiServer,
TrackerSession with its CycleLog; in a Setup MachineTool, whose axes G-code names.

Errors, all of CamrobError (`help("camrob.errors")`): InputError and its kin say where
an input is wrong; JobError and its kin: no program can be made safely, none is left.

Lengths in arguments are in mm where their names say so, paths are pathlib's.
Every name is loaded when it is first asked for: `import camrob` is light.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from camrob.machine_code import keep_kernels_fresh

if TYPE_CHECKING:
    from camrob.calibration.calibrate import CalibrationFit
    from camrob.calibration.calibration import Calibration
    from camrob.calibration.pose_by_pose import CalibrationEvidence
    from camrob.cell.cell import Cell
    from camrob.cell.read_cell import read_cell
    from camrob.cell.read_setup import read_setup
    from camrob.cell.setup import Setup
    from camrob.controller.replay import Replay, replay
    from camrob.controller.simulate import Simulation
    from camrob.errors import (
        CamrobError,
        CellError,
        CollisionError,
        InputError,
        JobError,
        KrlError,
        LimitError,
        LogError,
        ProgramError,
        SetupError,
        SingularError,
        StaleInputError,
        ToolpathError,
        UnreachableError,
        VerificationError,
    )
    from camrob.findings import Finding, Severity
    from camrob.gap.diagnosis import Diagnosis
    from camrob.jobs.batch import BatchResult, batch
    from camrob.jobs.calibrate import CalibrateResult, calibrate
    from camrob.jobs.close_loop import CloseLoopResult, close_loop
    from camrob.jobs.compensate import CompensateResult, compensate
    from camrob.jobs.diagnose import DiagnoseResult, diagnose
    from camrob.jobs.feed import FeedResult, feed
    from camrob.jobs.files.track_options import LiveOptions
    from camrob.jobs.objects.on_objects import Resolved, correct, explain, fit, placements, resolve, run
    from camrob.jobs.place import PlaceResult, place
    from camrob.jobs.post import PostResult, post
    from camrob.jobs.predict import PredictResult, predict
    from camrob.jobs.published_case import PublishedResult, published_case
    from camrob.jobs.regress import RegressResult, regress
    from camrob.jobs.simulate import SimulateResult, simulate
    from camrob.jobs.track_live import TrackLiveResult, track_live
    from camrob.jobs.tracker import TrackerResult, tracker
    from camrob.jobs.tune_engines import TuneEnginesResult, tune_engines
    from camrob.jobs.verify import VerifyResult, verify
    from camrob.kinematics.frames import base_T_tool
    from camrob.languages.read_program import read_program
    from camrob.loop.rsi.cycle_log import CycleLog
    from camrob.loop.rsi.server import RsiServer
    from camrob.loop.rsi.session import TrackerSession
    from camrob.machine_tool import MachineTool
    from camrob.measurement.log import MeasurementLog
    from camrob.measurement.read_log import read_log
    from camrob.prediction.surface import PredictedSurface
    from camrob.prediction.true_path import TruePath
    from camrob.program.program import Program
    from camrob.program.program_text import ProgramText
    from camrob.progress import Progress, Share
    from camrob.redundancy.path import ToolPathInBase
    from camrob.redundancy.planning.placement import Placements
    from camrob.redundancy.solution import Solution
    from camrob.shipped import shipped_cell
    from camrob.studies.published_robot import TapeLine
    from camrob.summaries.batch_summary import BatchSummary
    from camrob.summaries.calibration_summary import CalibrationSummary
    from camrob.summaries.closing.close_loop_summary import CloseLoopSummary
    from camrob.summaries.compensate_summary import CompensateSummary
    from camrob.summaries.diagnosis_summary import DiagnosisSummary
    from camrob.summaries.feed_summary import DerivativeSummary, FeedSummary, WeldSummary
    from camrob.summaries.live_summary import TrackLiveSummary
    from camrob.summaries.place_summary import PlaceSummary
    from camrob.summaries.post_summary import PostSummary
    from camrob.summaries.predict_summary import PredictSummary
    from camrob.summaries.regress_summary import RegressSummary
    from camrob.summaries.simulate_summary import SimulateSummary
    from camrob.summaries.tracker_summary import TrackerSummary
    from camrob.summaries.tune_summary import TuneSummary
    from camrob.summaries.verify_summary import VerifySummary
    from camrob.toolpath.read import read_toolpath
    from camrob.toolpath.region import Region
    from camrob.toolpath.toolpath import Toolpath

    __version__: str

__all__ = [
    "BatchResult",
    "BatchSummary",
    "CalibrateResult",
    "Calibration",
    "CalibrationEvidence",
    "CalibrationFit",
    "CalibrationSummary",
    "CamrobError",
    "Cell",
    "CellError",
    "CloseLoopResult",
    "CloseLoopSummary",
    "CollisionError",
    "CompensateResult",
    "CompensateSummary",
    "CycleLog",
    "DerivativeSummary",
    "DiagnoseResult",
    "Diagnosis",
    "DiagnosisSummary",
    "FeedResult",
    "FeedSummary",
    "Finding",
    "InputError",
    "JobError",
    "KrlError",
    "LimitError",
    "LiveOptions",
    "LogError",
    "MachineTool",
    "MeasurementLog",
    "PlaceResult",
    "PlaceSummary",
    "Placements",
    "PostResult",
    "PostSummary",
    "PredictResult",
    "PredictSummary",
    "PredictedSurface",
    "Program",
    "ProgramError",
    "ProgramText",
    "Progress",
    "PublishedResult",
    "Region",
    "RegressResult",
    "RegressSummary",
    "Replay",
    "Resolved",
    "RsiServer",
    "Setup",
    "SetupError",
    "Severity",
    "Share",
    "SimulateResult",
    "SimulateSummary",
    "Simulation",
    "SingularError",
    "Solution",
    "StaleInputError",
    "TapeLine",
    "ToolPathInBase",
    "Toolpath",
    "ToolpathError",
    "TrackLiveResult",
    "TrackLiveSummary",
    "TrackerResult",
    "TrackerSession",
    "TrackerSummary",
    "TruePath",
    "TuneEnginesResult",
    "TuneSummary",
    "UnreachableError",
    "VerificationError",
    "VerifyResult",
    "VerifySummary",
    "WeldSummary",
    "base_T_tool",
    "batch",
    "calibrate",
    "close_loop",
    "compensate",
    "correct",
    "diagnose",
    "explain",
    "feed",
    "fit",
    "place",
    "placements",
    "post",
    "predict",
    "published_case",
    "read_cell",
    "read_log",
    "read_program",
    "read_setup",
    "read_toolpath",
    "regress",
    "replay",
    "resolve",
    "run",
    "shipped_cell",
    "simulate",
    "track_live",
    "tracker",
    "tune_engines",
    "verify",
]

_HOME = {
    "BatchResult": "camrob.jobs.batch",
    "BatchSummary": "camrob.summaries.batch_summary",
    "CalibrateResult": "camrob.jobs.calibrate",
    "Calibration": "camrob.calibration.calibration",
    "CalibrationEvidence": "camrob.calibration.pose_by_pose",
    "CalibrationFit": "camrob.calibration.calibrate",
    "CalibrationSummary": "camrob.summaries.calibration_summary",
    "Cell": "camrob.cell.cell",
    "CloseLoopResult": "camrob.jobs.close_loop",
    "CloseLoopSummary": "camrob.summaries.closing.close_loop_summary",
    "CompensateResult": "camrob.jobs.compensate",
    "CompensateSummary": "camrob.summaries.compensate_summary",
    "CycleLog": "camrob.loop.rsi.cycle_log",
    "DerivativeSummary": "camrob.summaries.feed_summary",
    "DiagnoseResult": "camrob.jobs.diagnose",
    "Diagnosis": "camrob.gap.diagnosis",
    "DiagnosisSummary": "camrob.summaries.diagnosis_summary",
    "FeedResult": "camrob.jobs.feed",
    "FeedSummary": "camrob.summaries.feed_summary",
    "Finding": "camrob.findings",
    "LiveOptions": "camrob.jobs.files.track_options",
    "MachineTool": "camrob.machine_tool",
    "MeasurementLog": "camrob.measurement.log",
    "PlaceResult": "camrob.jobs.place",
    "PlaceSummary": "camrob.summaries.place_summary",
    "Placements": "camrob.redundancy.planning.placement",
    "PostResult": "camrob.jobs.post",
    "PostSummary": "camrob.summaries.post_summary",
    "PredictResult": "camrob.jobs.predict",
    "PredictSummary": "camrob.summaries.predict_summary",
    "PredictedSurface": "camrob.prediction.surface",
    "Program": "camrob.program.program",
    "ProgramText": "camrob.program.program_text",
    "Progress": "camrob.progress",
    "PublishedResult": "camrob.jobs.published_case",
    "Region": "camrob.toolpath.region",
    "RegressResult": "camrob.jobs.regress",
    "RegressSummary": "camrob.summaries.regress_summary",
    "Replay": "camrob.controller.replay",
    "Resolved": "camrob.jobs.objects.on_objects",
    "RsiServer": "camrob.loop.rsi.server",
    "Setup": "camrob.cell.setup",
    "Severity": "camrob.findings",
    "Share": "camrob.progress",
    "SimulateResult": "camrob.jobs.simulate",
    "SimulateSummary": "camrob.summaries.simulate_summary",
    "Simulation": "camrob.controller.simulate",
    "Solution": "camrob.redundancy.solution",
    "TapeLine": "camrob.studies.published_robot",
    "ToolPathInBase": "camrob.redundancy.path",
    "Toolpath": "camrob.toolpath.toolpath",
    "TrackLiveResult": "camrob.jobs.track_live",
    "TrackLiveSummary": "camrob.summaries.live_summary",
    "TrackerResult": "camrob.jobs.tracker",
    "TrackerSession": "camrob.loop.rsi.session",
    "TrackerSummary": "camrob.summaries.tracker_summary",
    "TruePath": "camrob.prediction.true_path",
    "TuneEnginesResult": "camrob.jobs.tune_engines",
    "TuneSummary": "camrob.summaries.tune_summary",
    "VerifyResult": "camrob.jobs.verify",
    "VerifySummary": "camrob.summaries.verify_summary",
    "WeldSummary": "camrob.summaries.feed_summary",
    "base_T_tool": "camrob.kinematics.frames",
    "batch": "camrob.jobs.batch",
    "calibrate": "camrob.jobs.calibrate",
    "close_loop": "camrob.jobs.close_loop",
    "compensate": "camrob.jobs.compensate",
    "correct": "camrob.jobs.objects.on_objects",
    "diagnose": "camrob.jobs.diagnose",
    "explain": "camrob.jobs.objects.on_objects",
    "feed": "camrob.jobs.feed",
    "fit": "camrob.jobs.objects.on_objects",
    "place": "camrob.jobs.place",
    "post": "camrob.jobs.post",
    "predict": "camrob.jobs.predict",
    "published_case": "camrob.jobs.published_case",
    "read_cell": "camrob.cell.read_cell",
    "read_log": "camrob.measurement.read_log",
    "read_program": "camrob.languages.read_program",
    "read_setup": "camrob.cell.read_setup",
    "read_toolpath": "camrob.toolpath.read",
    "regress": "camrob.jobs.regress",
    "replay": "camrob.controller.replay",
    "placements": "camrob.jobs.objects.on_objects",
    "resolve": "camrob.jobs.objects.on_objects",
    "run": "camrob.jobs.objects.on_objects",
    "shipped_cell": "camrob.shipped",
    "simulate": "camrob.jobs.simulate",
    "track_live": "camrob.jobs.track_live",
    "tracker": "camrob.jobs.tracker",
    "tune_engines": "camrob.jobs.tune_engines",
    "verify": "camrob.jobs.verify",
}
"""Where each public name lives; the rest of `__all__` is the tree of errors."""


keep_kernels_fresh()


class _Face(ModuleType):
    """This package as a module whose public names wait in its class.

    `help` documents in full whatever `dir` lists: thousands of lines, and all of camrob would be loaded for them. So `dir` lists
    a name once it has been used, and completion, which looks at a module's class too, offers all of them from the start.
    """

    @property
    def __version__(self) -> str:
        """The version that is installed. Raises AttributeError where camrob is not installed."""
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("camrob")
        except PackageNotFoundError:
            raise AttributeError("camrob is not installed, so its version is not known") from None


class _OnDemand:
    """A public name that is loaded when it is first asked for, and stays in the package from then on."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, module: ModuleType | None, owner: type) -> object:
        if module is None:
            return self
        value = getattr(import_module(_HOME.get(self.name, "camrob.errors")), self.name)
        vars(module)[self.name] = value
        return value


for _name in __all__:
    setattr(_Face, _name, _OnDemand(_name))
sys.modules[__name__].__class__ = _Face
