"""One folder per question: what it asks, what it computes, what it shows; see `rattle.question`."""
