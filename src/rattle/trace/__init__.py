"""One model as straight-line code: its operations recorded once, folded, shared, and emitted for a machine."""
