"""The helicopter blade: Sect. 4.3 of the paper."""
