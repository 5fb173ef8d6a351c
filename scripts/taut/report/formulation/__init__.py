"""The formulation itself: what Sects 2 and 3 of the paper say of any problem."""
