"""What the machine is: joints, tool, limits, masses, shapes, and the settings of its controller."""
