"""The orbit of a pin in its oil film under the forces of the mechanism without play."""
