"""A post-processor for FreeCAD (Path or CAM workbench) that writes CL data for camrob: APT text, every motion written out.

Copy this file into FreeCAD's macro folder, and choose "camrob" as the job's post-processor; or, without the window:

    freecadcmd -c "..."      # see tests/toolpath/test_freecad.py for a whole run

Points are those of the job, in millimetres, with the tip of the tool where FreeCAD has it. The tool stands upright, but where the
job has A, B, C words: there it stands as ISO 841 has it (a positive word turns the tool about the part right-handedly, C
outermost), and points are taken as tip positions in the part. Drilling cycles are written as their moves. What has no meaning in
CL data raises ValueError, and no file is written: cutter compensation, tapping, probing, other planes, increments, inches.
"""

from __future__ import annotations

import math
import os

__all__ = ["TOOLTIP", "TOOLTIP_ARGS", "export"]

TOOLTIP = "CL data (APT) for camrob: FreeCAD's path as GOTO, CIRCLE, RAPID, FEDRAT, with the tool's axis."
TOOLTIP_ARGS = "No arguments."

_SILENT = {
    "G17", "G21", "G40", "G43", "G49", "G54", "G61", "G64", "G80", "G90", "G94", "M2", "M30",
}  # fmt: skip
_CYCLES = {"G73", "G81", "G82", "G83", "G85"}
_DIGITS = 6  # decimals of millimetres
_CHIP = 0.25  # mm: how far G73 goes back to break a chip, and how near to the last depth G83 goes in rapid


class _Writer:
    """Turns the commands of a job into lines."""

    def __init__(self):
        self.lines = ["$$ CL data of FreeCAD, written by camrob_post", "UNITS/MM", "MULTAX/ON"]
        self.at = {"X": None, "Y": None, "Z": None, "A": 0.0, "B": 0.0, "C": 0.0}
        self.feed = None  # mm/min, as written last
        self.next_feed = None
        self.tool = None
        self.speed = 0.0
        self.sense = ""
        self.to_initial = True
        self.relative_centre = True

    # -- words

    def command(self, name, words):
        """One command of FreeCAD's, with its parameters (mm, degrees, and F in mm/s)."""
        name = name.strip().upper()
        if name.startswith("(") or not name:
            self.say("PPRINT/" + _text(name.strip("()")))
            return
        if name[0] in "GM" and name[1:].replace(".", "").isdigit():
            name = f"{name[0]}{float(name[1:]):g}"
        if "F" in words and words["F"] > 0.0 and name in ("G1", "G2", "G3", *_CYCLES):
            self.next_feed = words["F"] * 60.0
        if name in ("G0", "G1"):
            self.straight(words, rapid=name == "G0")
        elif name in ("G2", "G3"):
            self.arc(words, clockwise=name == "G2")
        elif name in _CYCLES:
            self.drill(name, words)
        elif name == "M6":
            self.load(words)
        elif name in ("M3", "M4"):
            self.speed, self.sense = words.get("S", self.speed), "CLW" if name == "M3" else "CCLW"
            if not self.speed > 0.0:
                raise ValueError(f"{name} without a speed: set the tool controller's spindle speed")
            self.say(f"SPINDL/RPM,{self.speed:.3f},{self.sense}")
        elif name == "M5":
            self.say("SPINDL/OFF")
        elif name in ("M7", "M8", "M9"):
            self.say({"M7": "COOLNT/MIST", "M8": "COOLNT/FLOOD", "M9": "COOLNT/OFF"}[name])
        elif name in ("M0", "M1"):
            self.say("STOP" if name == "M0" else "OPSTOP")
        elif name == "G4":
            self.say(f"DELAY/{words.get('P', words.get('X', 0.0)):.3f}")
        elif name in ("G98", "G99"):
            self.to_initial = name == "G98"
        elif name in ("G90.1", "G91.1"):
            self.relative_centre = name == "G91.1"
        elif name not in _SILENT:
            raise ValueError(f"{name} has no meaning in CL data for camrob: take it out of the job")

    def say(self, line):
        """One line."""
        self.lines.append(line)

    def load(self, words):
        """M6 T: another tool."""
        if "T" not in words:
            raise ValueError("M6 without a tool's number")
        number = int(words["T"])
        if number != self.tool:
            self.tool = number
            self.say(f"LOADTL/{number}")

    # -- motions

    def straight(self, words, *, rapid):
        """G0 or G1."""
        if not set(words) & set("XYZABC"):
            return
        self.at.update({axis: value for axis, value in words.items() if axis in self.at})
        self.go(rapid=rapid)

    def go(self, *, rapid):
        """To where the axes stand now; places before all three are known are left out, as they are in rapid."""
        if None in (self.at["X"], self.at["Y"], self.at["Z"]):
            if not rapid:
                raise ValueError("a cut before X, Y and Z are all named")
            return
        if rapid:
            self.say("RAPID")
        else:
            self.fed()
        self.say("GOTO/" + self.place())

    def fed(self):
        """FEDRAT where the feed changes."""
        if self.next_feed is None:
            raise ValueError("a cut without a feed: set the tool controller's feeds")
        if self.next_feed != self.feed:
            self.feed = self.next_feed
            self.say(f"FEDRAT/MMPM,{self.feed:.4f}")

    def place(self):
        """Tip and axis as six numbers."""
        a, b, c = (math.radians(self.at[axis]) for axis in "ABC")
        x, y, z = 0.0, -math.sin(a), math.cos(a)  # Rx(A) z
        x, z = x * math.cos(b) + z * math.sin(b), -x * math.sin(b) + z * math.cos(b)
        x, y = x * math.cos(c) - y * math.sin(c), x * math.sin(c) + y * math.cos(c)
        tip = [f"{self.at[axis] + 0.0:.{_DIGITS}f}" for axis in "XYZ"]
        return ",".join([*tip, *(f"{v + 0.0:.9f}" for v in (x, y, z))])

    def arc(self, words, *, clockwise):
        """G2 or G3 about Z, by I and J."""
        if words.get("K") or "R" in words or not self.relative_centre:
            raise ValueError("an arc by R, by K or with an absolute centre: FreeCAD's own paths have I and J")
        if None in (self.at["X"], self.at["Y"], self.at["Z"]):
            raise ValueError("an arc before X, Y and Z are all named")
        centre = (self.at["X"] + words.get("I", 0.0), self.at["Y"] + words.get("J", 0.0), self.at["Z"])
        radius = math.hypot(words.get("I", 0.0), words.get("J", 0.0))
        self.at.update({axis: value for axis, value in words.items() if axis in self.at})
        self.fed()
        numbers = [*centre, 0.0, 0.0, -1.0 if clockwise else 1.0, radius]
        self.say("CIRCLE/" + ",".join(f"{v + 0.0:.{_DIGITS}f}" for v in numbers))
        self.say("GOTO/" + self.place())

    def drill(self, name, words):
        """G73, G81, G82, G83, G85 as their moves."""
        if self.at["Z"] is None or "Z" not in words or "R" not in words:
            raise ValueError(f"{name} without Z or R, or from an unknown height")
        start, top, bottom = self.at["Z"], words["R"], words["Z"]
        end = max(start, top) if self.to_initial else top
        if start < top:
            self.at["Z"] = top
            self.go(rapid=True)
        self.at.update({axis: words[axis] for axis in "XY" if axis in words})
        self.go(rapid=True)
        self.to(top, rapid=True)
        bite = abs(words.get("Q", 0.0)) if name in ("G73", "G83") else 0.0
        depth = top
        while bite and depth - bite > bottom + 1e-6:
            depth -= bite
            self.to(depth, rapid=False)
            if name == "G83":
                self.to(top, rapid=True)
            self.to(min(top, depth + _CHIP), rapid=True)
        self.to(bottom, rapid=False)
        if words.get("P", 0.0) > 0.0 and name != "G81":
            self.say(f"DELAY/{words['P']:.3f}")
        if name == "G85":
            self.to(top, rapid=False)
        self.to(end, rapid=True)

    def to(self, height, *, rapid):
        """Along Z."""
        if self.at["Z"] != height:
            self.at["Z"] = height
            self.go(rapid=rapid)


def _text(text):
    """Plain text of one line, that no reader takes for more."""
    return "".join(c if " " <= c <= "~" and c != "$" else " " for c in str(text))[:70].strip()


def _commands(found):
    """Commands of an object, and of those in it."""
    if hasattr(found, "Group") and not hasattr(found, "Path"):
        for inner in found.Group:
            yield from _commands(inner)
    elif hasattr(found, "Path"):
        if getattr(found, "Active", True):
            yield found.Label, found.Path.Commands


def export(objectslist, filename, argstring=""):
    """Write the CL data of the job's objects to `filename` ("-": to none), and give the text. Raises ValueError."""
    del argstring
    writer = _Writer()
    name = os.path.splitext(os.path.basename(str(filename)))[0]
    writer.lines.insert(1, "PARTNO " + (_text(name) or "FREECAD"))
    for found in objectslist:
        for label, commands in _commands(found):
            writer.say("PPRINT/" + _text(label))
            for command in commands:
                writer.command(command.Name, dict(command.Parameters))
    writer.say("SPINDL/OFF")
    writer.say("FINI")
    text = "\n".join(writer.lines) + "\n"
    if filename != "-":
        with open(filename, "w", encoding="ascii") as file:
            file.write(text)
    return text
