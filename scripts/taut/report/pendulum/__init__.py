"""The pendulum: Sect. 4.1 of the paper."""
