"""Oil films of journal bearings: a calculator, and the solutions that the shipped table is made of."""
