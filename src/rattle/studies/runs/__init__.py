"""Runs of many samples of one mechanism: what is asked, and how a batch of samples is run."""
