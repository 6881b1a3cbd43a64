"""The commands of `rattle`, imported when called."""
