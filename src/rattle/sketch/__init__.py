"""Drawing by hand: what a mechanism under the mouse does, and what is measured on it by a click."""
