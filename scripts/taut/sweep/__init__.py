"""Runs many variants of a case and collects what came of them."""
