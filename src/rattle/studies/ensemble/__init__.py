"""Many samples of one mechanism, whose parameters vary within their tolerances."""
