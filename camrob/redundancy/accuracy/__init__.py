"""How far a machine as measured is off in a posture, and what that costs on the part: for planners that aim at accuracy."""
