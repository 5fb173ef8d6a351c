"""Figures and the report of taut, drawn from the CSV files of its runs alone."""
