"""Assemblies of Ondsel's solver and of FreeCAD: rigid parts in space, joined by markers."""
