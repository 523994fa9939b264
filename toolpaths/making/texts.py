"""What stands beside each sample: its set-up and its README."""

from __future__ import annotations

__all__ = ["READMES", "SETUPS"]

SETUPS = {
    "carving": """\
# The block stands on a riser of 200 mm in the middle of the table, so that the spindle, lying flat for the front,
# clears the table's disc. The front looks along -y of the table's frame; the tool is the cell's own.
part_in_base = [0, 0, 200, 0, 0, 0]
clearance_mm = 60
rapid_feed_mm_min = 12000

[tool]
name = "ball 10"
diameter_mm = 10
length_mm = 80
corner_radius_mm = 5

[part]
mesh = "part.stl"

[stock]
box_mm = [-120, -80, 0, 120, 80, 165]
""",
    "relief": """\
# The disc stands on a riser of 200 mm in the middle of the table: the tool leans out by up to 34 degrees all round,
# and the table follows it.
part_in_base = [0, 0, 200, 0, 0, 0]
clearance_mm = 60
rapid_feed_mm_min = 12000

[tool]
name = "ball 10"
diameter_mm = 10
length_mm = 80
corner_radius_mm = 5

[part]
mesh = "part.stl"
""",
    "engraving": """\
# The plate lies on a riser of 200 mm in the middle of the table. Its grooves are cut into it, so that the mesh is
# the blank plate.
part_in_base = [0, 0, 200, 0, 0, 0]
clearance_mm = 40
rapid_feed_mm_min = 12000

[tool]
name = "ball 3"
diameter_mm = 3
length_mm = 80
corner_radius_mm = 1.5

[stock]
mesh = "stock.stl"
""",
    "globe": """\
# The column stands on the table, 250 mm off its middle, so that the ball keeps clear of the spindle at HOME.
part_in_base = [0, -250, 0, 0, 0, 0]
clearance_mm = 60
rapid_feed_mm_min = 12000

[tool]
name = "ball 10"
diameter_mm = 10
length_mm = 120
corner_radius_mm = 5

[part]
mesh = "part.stl"
""",
}

_ORIGIN = """
## Origin
Made by `python toolpaths/make_samples.py {name}` from formulas in `toolpaths/making/{name}.py`: the shape,
the path and the files are camrob's own, given to the public domain (CC0 1.0). The CL file is written in the
habits of NX CLSF (modal axis and feed, one-shot RAPID, MSYS per operation, PAINT bookkeeping, arcs with their
axis reversed), but not by NX.

## Counts
| | |
| --- | --- |
| operations | {operations} |
| points (GOTO) | {points} |
| of these rapid | {rapids} |
| arcs (CIRCLE) | {arcs} |
| holes (CYCLE) | {holes} |
| triangles of `{mesh}` | {triangles} |
"""

READMES = {
    "carving": """\
# carving: a frog on a plinth, two regions at 90 degrees
A frog of expanded polystyrene, 240 x 160 x 165 mm with its plinth, carved with a ball-end mill of 10 mm:
first from above (tool axis +z of the part), then from the front (tool axis -y), the table's and the track's
posture free to change between the two. This is the kind of 3+2 job that the paper on CAM-ROB integration for
redundant manipulators validates its post on.

- Each operation has an MSYS of its own; in the second it is turned, so that its points are seen from the
  front and its axis reads 0, 0, 1.
- Zig-zag passes, 3.2 mm apart. From above they come in five bands with a retract between, entered and left on
  upright quarter circles; from the front they follow the frog's outline in several patches.
- Border passes on both faces of the plinth with true corner arcs.
- The ball's centre is found by dropping it on the triangles of `part.stl`: it touches and does not gouge
  (points exactly, the lines between them within 0.05 mm). The front goes no deeper than 70 mm, so that the
  spindle stays before the plinth.
""",
    "relief": """\
# relief: a swirling rosette on a dome, five axes at once
A disc of 220 mm with nine swirling petals on a dome, cut with a ball-end mill of 10 mm in one spiral from
the rim to the knob. The tool leans out with the dome, 34 degrees at the rim, and leads by 8 degrees along its
feed; both fade towards the middle, so that the axis turns smoothly and once around with every turn of the
spiral.

- The axis is printed where it changes, which is at every point of the spiral; the leads in and out keep
  theirs and print none.
- The ball's centre is dropped on the triangles of `part.stl`; the tip lies a radius further down the axis, so
  leaning never gouges.
- Steps of 1.5 to 3 mm at 4000 mm/min.
""",
    "engraving": """\
# engraving: a name plate in single strokes
A plate of 240 x 110 x 20 mm with a hexfoil, the word camrob, a frame with notched corners and four holes for
pins, cut 0.8 mm deep with a ball-end mill of 3 mm.

- Small: lines and true arcs, full circles as two halves, many retracts, plunges at 300 mm/min and strokes at
  1500.
- The holes are a drilling cycle (`CYCLE/DRILL` to `CYCLE/OFF`), 6 mm deep.
- The MSYS lies in the middle of the plate's top.
""",
    "globe": """\
# globe: a ball on a column, past the level and with the arm nearly stretched
A ball of 260 mm whose middle is 800 mm over the table, finished with a ball-end mill of 10 mm along three
meridians, from the pole to 15 degrees under the equator and back, the tool normal to the ball all the way.

- So high up the arm is nearly stretched, and leaning past the level it has little choice: 1/k_F falls below
  the cell's threshold, where the condition term (h_cond) begins to act. On the other samples it never does.
- The tool's axis turns by 105 degrees down each meridian, evenly but for the ends.
""",
}
for _name in READMES:
    READMES[_name] += _ORIGIN
