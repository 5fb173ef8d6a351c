"""Measures taut beside other codes on the same problems: scripts/benchmark and scripts/instructions."""
