"""The tabs whose content is computed, by the name of their job."""

TABS = ("forces", "equilibrium", "accuracy", "sensitivity", "ensemble", "power", "wear", "report")
