"""What the scripts do: the report, sweeps, pictures of mechanisms and the benchmark, a folder each."""
