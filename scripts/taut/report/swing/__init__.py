"""The swing: Sect. 4.2 of the paper."""
