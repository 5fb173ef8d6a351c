"""The methods side by side: every way to enforce constraints that the paper names, on the same problems."""
