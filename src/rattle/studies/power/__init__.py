"""Power between elements and bodies: instants, cycles, and where the energy goes."""
