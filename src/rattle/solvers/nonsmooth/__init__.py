"""Set-valued contacts from instant to instant: events, impacts, Moreau-Jean."""
