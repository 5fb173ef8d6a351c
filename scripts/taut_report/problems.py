"""The problems of the paper, in its order; a further one plugs in here with its figures and its chapter."""
