"""The studio: a page on this computer in which a mechanism is changed, seen and analysed (`rattle studio`)."""
