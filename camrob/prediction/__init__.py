"""The part as it would come out: the tool's true path on the machine as diagnosed, and the surface that it leaves."""
