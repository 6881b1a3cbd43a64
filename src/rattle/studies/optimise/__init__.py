"""Values of parameters that make a number of a mechanism as small as possible: `Mechanism.optimise`."""
