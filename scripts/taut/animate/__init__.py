"""Pictures of any mechanism, from its case file and its results."""
