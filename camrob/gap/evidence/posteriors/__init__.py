"""The arithmetic of one set of units and of its neighbours, compiled."""
