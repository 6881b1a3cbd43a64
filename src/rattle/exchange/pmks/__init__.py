"""Links of PMKS+: a mechanism as the text behind the question mark of an address."""
