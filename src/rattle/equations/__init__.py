"""The equations at one instant: constraints, forces, accelerations, contact problems."""
