"""Named data: play of fits and rolling bearings, viscosity of oils, from tables that the package ships."""
